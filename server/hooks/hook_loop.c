#include "server/hooks/hook_loop.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/sandbox/calls.h"
#include "server/sandbox/fence.h"
#include "server/sandbox/privileges.h"
#include "server/sandbox/spawn.h"
#include "server/hooks/hook_address.h"
#include "server/hooks/hook_files.h"

enum {
    LOOP_LOOKUP_S = 15, /* for the look-up of a name, beside the seconds of the transfer */
    LOOP_CPU_S = 10,
    LOOP_DATA = 256 << 20
};

struct loop {
    struct srv_hook_rules rules;
    struct srv_peers networks;
    int pid[SRV_HOOK_LOOP_MOST]; /* of the process that sends the message of a place; 0 = none */
    struct srv_hook_order order;
};

static void loop_wake(int number) { (void)number; }

/* --- the process of one message --- */

static void loop_limit(void) {
    const struct rlimit none = {0, 0}, seconds = {LOOP_CPU_S, LOOP_CPU_S},
                        data = {LOOP_DATA, LOOP_DATA};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &seconds);
    setrlimit(RLIMIT_FSIZE, &none);
    if (!srv_calls_sanitized()) setrlimit(RLIMIT_DATA, &data);
}

static _Noreturn void loop_child(const struct loop *loop, int maker) {
    struct pend_error error;
    const struct srv_hook_order *order = &loop->order;
    struct srv_hook_told told = {.place = order->place, .end = SRV_HOOK_BROKEN};
    const struct srv_hook_message message = {order->url,        order->id,   order->timestamp,
                                             order->signatures, order->body, (size_t)order->bytes};
    signal(SIGCHLD, SIG_DFL);
    signal(SIGPIPE, SIG_IGN);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) || (int)getppid() != maker) _exit(1);
    prctl(PR_SET_NAME, "pendulumd-hook");
    loop_limit();
    /* whatever it waits for, and whatever a library does about it */
    alarm(LOOP_LOOKUP_S + SRV_HOOK_SECONDS);
    static struct srv_fence fence;
    srv_hook_files(&fence, loop->rules.authority);
    int walls = loop->rules.walls != 0, good = 1;
    if (walls) good = srv_fence_close(&fence, &error) == PEND_OK;
    if (walls) good &= srv_calls_restrict(&error) == PEND_OK;
    if (!good && loop->rules.walls != SRV_CONFIG_AUTO) _exit(1);
    told.end = srv_hook_post(&message, &loop->networks, loop->rules.authority, &told.status);
    _exit(send(SRV_SPAWN_FD, &told, sizeof told, MSG_NOSIGNAL) != (ssize_t)sizeof told);
}

/* --- the process that makes these --- */

/* answers for one that cannot any more */
static void loop_answer(int place, enum srv_hook_end end) {
    const struct srv_hook_told told = {.place = place, .end = end};
    (void)send(SRV_SPAWN_FD, &told, sizeof told, MSG_NOSIGNAL);
}

/* waits for those that have ended; who ended by status 0 has answered */
static void loop_reap(struct loop *loop) {
    int status, pid;
    while ((pid = (int)waitpid(-1, &status, WNOHANG)) > 0)
        for (int i = 0; i < SRV_HOOK_LOOP_MOST; i++) {
            if (loop->pid[i] != pid) continue;
            loop->pid[i] = 0;
            if (WIFEXITED(status) && !WEXITSTATUS(status)) continue;
            int late = WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM;
            loop_answer(i, late ? SRV_HOOK_NOWHERE : SRV_HOOK_BROKEN);
        }
}

/* whether an order is one that the daemon can have given */
static int loop_good(const struct loop *loop) {
    const struct srv_hook_order *order = &loop->order;
    return order->place >= 0 && order->place < SRV_HOOK_LOOP_MOST && order->bytes >= 0 &&
           order->bytes <= SRV_HOOK_BODY && memchr(order->url, 0, sizeof order->url) &&
           memchr(order->id, 0, sizeof order->id) &&
           memchr(order->timestamp, 0, sizeof order->timestamp) &&
           memchr(order->signatures, 0, sizeof order->signatures);
}

/* takes an order, if there is one; returns 0 when the daemon has gone */
static int loop_obey(struct loop *loop) {
    struct srv_hook_order *order = &loop->order;
    ssize_t got = recv(SRV_SPAWN_FD, order, sizeof *order, MSG_DONTWAIT);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got != (ssize_t)sizeof *order || !loop_good(loop)) return 0;
    /* one that has just answered may not have been waited for yet */
    while (loop->pid[order->place]) {
        if (waitpid(loop->pid[order->place], NULL, 0) < 0 && errno == EINTR) continue;
        loop->pid[order->place] = 0;
    }
    int maker = (int)getpid(), pid = (int)fork();
    if (!pid) loop_child(loop, maker);
    if (pid > 0)
        loop->pid[order->place] = pid;
    else
        loop_answer(order->place, SRV_HOOK_BROKEN);
    return 1;
}

static _Noreturn void loop_serve(struct loop *loop) {
    sigset_t none, child;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    sigprocmask(SIG_BLOCK, &child, &none);
    sigdelset(&none, SIGCHLD);
    do {
        struct pollfd ear = {.fd = SRV_SPAWN_FD, .events = POLLIN};
        ppoll(&ear, 1, NULL, &none);
        loop_reap(loop);
    } while (loop_obey(loop));
    /* its processes end with it */
    _exit(0);
}

/* gives up what it does not need; returns 0 where --walls on needs more than there is */
static int loop_confine(const struct loop *loop, struct srv_hook_hello *hello) {
    static const char *const system[] = {"/etc", "/usr", "/lib", "/lib64"};
    static struct srv_fence fence = {.connects = 1};
    size_t used = 0;
    /* more than a message needs: who resolves names may be told anew by another file of its name,
     * and each message's process has a fence of its own, around the files that are there then */
    for (size_t i = 0; i < sizeof system / sizeof *system; i++)
        srv_fence_add(&fence, SRV_FENCE_READ, system[i]);
    srv_fence_add(&fence, SRV_FENCE_READ, "/dev/urandom");
    /* who looks names up is often told in /run, where the credentials of services are too */
    char resolver[PATH_MAX];
    if (realpath("/etc/resolv.conf", resolver))
        srv_fence_add_around(&fence, SRV_FENCE_READ, resolver);
    if (strcmp(loop->rules.authority, "none"))
        srv_fence_add_around(&fence, SRV_FENCE_READ, loop->rules.authority);
    for (int wall = 0; loop->rules.walls != 0 && wall < 2; wall++) {
        struct pend_error error = {.text = ""};
        if ((wall ? srv_fence_close(&fence, &error) : srv_privileges_drop(&error)) == PEND_OK)
            continue;
        if (used < sizeof hello->lack)
            used += (size_t)snprintf(hello->lack + used, sizeof hello->lack - used, "%s%.90s",
                                     used ? "; " : "", error.text);
        if (loop->rules.walls != SRV_CONFIG_AUTO) return 0;
    }
    return 1;
}

int srv_hook_loop_main(void) {
    struct srv_hook_hello hello = {.good = 0};
    struct pend_error error;
    const struct sigaction wake = {.sa_handler = loop_wake};
    if (!srv_spawned()) {
        fprintf(stderr, "pendulumd: hooks is what the server starts by itself: --webhook-secret\n");
        return 2;
    }
    struct loop *loop = calloc(1, sizeof *loop);
    prctl(PR_SET_NAME, "pendulumd-hooks");
    int good = loop && !sigaction(SIGCHLD, &wake, NULL) &&
               read(SRV_SPAWN_FD, &loop->rules, sizeof loop->rules) == (ssize_t)sizeof loop->rules;
    if (good) good = srv_hook_networks(&loop->networks, loop->rules.networks, &error) == PEND_OK;
    if (good) hello.good = loop_confine(loop, &hello);
    /* the end of its socket says so too, but only to one that looks */
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (send(SRV_SPAWN_FD, &hello, sizeof hello, MSG_NOSIGNAL) == (ssize_t)sizeof hello &&
        hello.good)
        loop_serve(loop);
    free(loop);
    return 0;
}
