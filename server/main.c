/* pendulumd: reads its options, serves until it is told to stop, drains, and ends.
 * Leaves to others: everything else.
 * Invariant: exit status 0 after an orderly end, 1 where the world is in the way, 2 for a bad option. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "server/clock.h"
#include "server/config.h"
#include "server/daemon.h"
#include "server/log.h"
#include "server/notify.h"

extern char **environ;

enum { MAIN_LOOK_MS = 100 };

/* the signals that end the server wait for main_signal; a closed pipe is an error of write, not the end */
static void main_signals(sigset_t *ends) {
    sigemptyset(ends);
    sigaddset(ends, SIGTERM);
    sigaddset(ends, SIGINT);
    sigaddset(ends, SIGHUP);
    pthread_sigmask(SIG_BLOCK, ends, NULL);
    signal(SIGPIPE, SIG_IGN);
}

/* the next signal, waiting so long for it at most, < 0 for ever; 0 if there was none */
static int main_signal(const sigset_t *ends, int ms) {
    struct timespec span = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    for (;;) {
        int got = ms < 0 ? sigwaitinfo(ends, NULL) : sigtimedwait(ends, NULL, &span);
        if (got > 0 || (ms >= 0 && errno == EAGAIN)) return got > 0 ? got : 0;
    }
}

/* what was asked for is a text */
static int main_print(enum srv_config_task task) {
    struct api_buffer text;
    enum pend_status status = PEND_OK;
    api_buffer_init(&text, 65536);
    if (task == SRV_CONFIG_VERSION)
        status = api_buffer_text(&text, "pendulumd " SRV_VERSION "\n");
    else
        status = task == SRV_CONFIG_HELP ? srv_config_help(&text) : srv_config_table(&text);
    int good = status == PEND_OK && fwrite(text.data, 1, text.bytes, stdout) == text.bytes && !fflush(stdout);
    api_buffer_clear(&text);
    return good ? 0 : 1;
}

/* serves until a signal, or until there was nothing to compute for so many seconds, > 0 */
static void main_serve(struct srv_daemon *daemon, const sigset_t *ends, double idle) {
    while (!main_signal(ends, idle > 0 ? MAIN_LOOK_MS : -1)) {
        if (srv_daemon_idle(daemon) < idle) continue;
        srv_log_message(srv_daemon_log(daemon), "there was nothing to compute for %.15g s: ends", idle);
        return;
    }
}

/* lets what runs finish within its time; a second signal ends the patience */
static void main_drain(struct srv_daemon *daemon, const sigset_t *ends, double seconds) {
    int64_t limit = srv_clock_now() + srv_clock_span(seconds);
    int hurry = 0;
    srv_notify("STOPPING=1");
    while (!hurry && !srv_daemon_drain(daemon, 0)) hurry = main_signal(ends, 5) || srv_clock_now() > limit;
    srv_daemon_free(&daemon);
}

int main(int argc, char **argv) {
    struct pend_error error = {.text = ""};
    struct srv_config config;
    struct srv_daemon *daemon;
    sigset_t ends;
    if (srv_config_load(&config, argc, argv, environ, &error) != PEND_OK) {
        fprintf(stderr, "pendulumd: %s\n", error.text);
        return 2;
    }
    if (config.task != SRV_CONFIG_SERVE) return main_print(config.task);
    main_signals(&ends);
    if (srv_daemon_new(&daemon, &config, &error) != PEND_OK) {
        fprintf(stderr, "pendulumd: %s\n", error.text);
        return 1;
    }
    srv_log_message(srv_daemon_log(daemon), "listening on %s", srv_daemon_url(daemon));
    if (config.warning[0]) srv_log_message(srv_daemon_log(daemon), "%s", config.warning);
    srv_notify("READY=1");
    main_serve(daemon, &ends, config.until_idle_seconds);
    main_drain(daemon, &ends, config.drain_seconds);
    return 0;
}
