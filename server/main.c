/* pendulumd: reads its options, serves until a signal stops it, drains, and exits.
 * Leaves to others: everything else.
 * Invariant: exit status 0 after an orderly end, 1 after a failure of the system, 2 for a bad
 * option. */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "api/base/engine.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/notify.h"
#include "server/config/config_load.h"
#include "server/daemon.h"
#include "server/healthy.h"
#include "server/keys_command.h"
#include "server/sandbox_setup.h"

extern char **environ;

enum { MAIN_LOOK_MS = 100, MAIN_KEYS_MS = 500, MAIN_AGAIN = 75 };

/* Signals received by the main thread; SIGPIPE is ignored, so that write fails with EPIPE. */
struct main_ears {
    sigset_t all;
    int terminal; /* standard input is a terminal, so a hangup may mean that it was closed */
};

#if defined(__x86_64__) && defined(__CET__)
/* The C library's start objects are not marked as compatible with indirect-branch tracking (IBT),
 * so the linker would drop that mark from the program. The Makefile names these functions in their
 * place. */
void srv_main_entry(void);
void srv_main_nothing(void);
__attribute__((naked, used)) void srv_main_entry(void) { __asm__("jmp _start"); }
__attribute__((used)) void srv_main_nothing(void) {}
#endif

static void main_listen(struct main_ears *ears) {
    static const int heard[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2};
    sigemptyset(&ears->all);
    for (size_t i = 0; i < sizeof heard / sizeof *heard; i++) sigaddset(&ears->all, heard[i]);
    pthread_sigmask(SIG_BLOCK, &ears->all, NULL);
    signal(SIGPIPE, SIG_IGN);
    ears->terminal = isatty(STDIN_FILENO);
}

/* waits for the next signal, at most `ms`; < 0 = without limit. Returns 0 if none arrived */
static int main_signal(const struct main_ears *ears, int ms) {
    struct timespec span = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    for (;;) {
        int got = ms < 0 ? sigwaitinfo(&ears->all, NULL) : sigtimedwait(&ears->all, NULL, &span);
        if (got > 0 || (ms >= 0 && errno == EAGAIN)) return got > 0 ? got : 0;
    }
}

static int main_print(enum srv_config_task task) {
    struct api_buffer text;
    enum pend_status status = PEND_OK;
    api_buffer_init(&text, 65536);
    if (task == SRV_CONFIG_VERSION)
        status =
            api_buffer_format(&text, "pendulumd %s (engine %s)\n", api_version, api_engine_name);
    else
        status = task == SRV_CONFIG_HELP ? srv_config_help(&text) : srv_config_table(&text);
    int good = status == PEND_OK && fwrite(text.data, 1, text.bytes, stdout) == text.bytes &&
               !fflush(stdout);
    api_buffer_clear(&text);
    return good ? 0 : 1;
}

/* true if a signal ends the server. SIGHUP ends it if its terminal is gone; otherwise it reloads.
 */
static int main_ends(const struct main_ears *ears, int number) {
    struct pollfd terminal = {.fd = STDIN_FILENO};
    if (number != SIGHUP) return number == SIGTERM || number == SIGINT;
    return ears->terminal && poll(&terminal, 1, 0) > 0 && terminal.revents & (POLLHUP | POLLERR);
}

/* reloads all options; invalid ones change nothing */
static void main_reload(struct srv_daemon *daemon, int argc, char **argv) {
    struct pend_error error = {.text = ""};
    struct srv_config next;
    enum pend_status status = srv_config_load(&next, argc, argv, environ, &error);
    if (status == PEND_OK) status = srv_daemon_reload(daemon, &next, &error);
    if (status != PEND_OK)
        srv_log_message(srv_daemon_log(daemon), "reload: nothing has changed: %s", error.text);
}

/* describes the store for the log; the url of a database may contain a password */
static const char *main_kept(const struct srv_config *config) {
    if (!strcmp(config->store, "none")) return "no jobs are kept";
    if (!strcmp(config->store, "sqlite"))
        return "jobs are kept in ~/.local/state/pendulumd, unless XDG_STATE_HOME is set";
    return strncmp(config->store, "sqlite:", 7) ? "jobs are kept in the database"
                                                : "jobs are kept in ";
}

/* serves until a signal ends it or, with until-idle-seconds > 0, until it was idle for that time.
 * Returns the exit status: MAIN_AGAIN if a batch worker is ended while there may be work */
static int main_serve(struct srv_daemon *daemon, const struct main_ears *ears, double idle,
                      int argc, char **argv) {
    int look = idle > 0 ? MAIN_LOOK_MS : srv_daemon_has_keys(daemon) ? MAIN_KEYS_MS : -1;
    for (;;) {
        int number = main_signal(ears, look);
        if (number && main_ends(ears, number))
            return idle > 0 && srv_daemon_idle(daemon) <= 0 ? MAIN_AGAIN : 0;
        srv_daemon_look(daemon);
        if (number == SIGHUP) main_reload(daemon, argc, argv);
        if (number == SIGUSR1) srv_daemon_reopen(daemon);
        if (number || idle <= 0 || srv_daemon_idle(daemon) < idle) continue;
        srv_log_message(srv_daemon_log(daemon), "nothing to compute for %.15g s: exiting", idle);
        return 0;
    }
}

/* drains: running requests may finish within the drain time; a second signal ends the wait */
static void main_drain(struct srv_daemon *daemon, const struct main_ears *ears) {
    int64_t limit = srv_clock_now() + srv_clock_span(srv_daemon_patience(daemon));
    int hurry = 0;
    srv_notify("STOPPING=1");
    while (!hurry && !srv_daemon_drain(daemon, 0))
        hurry = main_ends(ears, main_signal(ears, 5)) || srv_clock_now() > limit;
    srv_daemon_free(&daemon);
}

int main(int argc, char **argv) {
    struct pend_error error = {.text = ""};
    struct srv_config config;
    struct srv_daemon *daemon;
    struct main_ears ears;
    /* otherwise the next opened file, such as the listening socket or the store, would get the
     * number of a closed standard stream */
    for (int fd = 0; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) != fd) return 1;
    /* jobs and logs that the process creates are private */
    umask(0077);
    const char *word = argc > 1 ? argv[1] : "";
    if (!strcmp(word, "keys")) return srv_keys_command(argc, argv);
    if (!strcmp(word, "healthy")) return srv_healthy_command(argc, argv, environ);
    if (srv_config_load(&config, argc, argv, environ, &error) != PEND_OK) {
        fprintf(stderr, "pendulumd: %s\n", error.text);
        return 2;
    }
    if (config.task != SRV_CONFIG_SERVE) return main_print(config.task);
    main_listen(&ears);
    if (srv_sandbox_root(&config, &error) != PEND_OK ||
        srv_daemon_new(&daemon, &config, &error) != PEND_OK) {
        fprintf(stderr, "pendulumd: %s\n", error.text);
        return 1;
    }
    srv_log_message(srv_daemon_log(daemon), "listening on %s", srv_daemon_url(daemon));
    if (isatty(STDERR_FILENO))
        srv_log_message(srv_daemon_log(daemon), "open it in a browser; Ctrl-C stops it; %s%.200s",
                        main_kept(&config),
                        strncmp(config.store, "sqlite:", 7) ? "" : config.store + 7);
    if (srv_daemon_lack(daemon)[0])
        srv_log_message(srv_daemon_log(daemon), "sandbox: incomplete: %s", srv_daemon_lack(daemon));
    if (config.warning[0]) srv_log_message(srv_daemon_log(daemon), "%s", config.warning);
    srv_notify("READY=1");
    int status = main_serve(daemon, &ears, config.until_idle_seconds, argc, argv);
    main_drain(daemon, &ears);
    return status;
}
