#include "server/work/zygote.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
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
#include "server/config/config.h"
#include "server/sandbox/fence.h"
#include "server/sandbox/privileges.h"
#include "server/sandbox/spawn.h"
#include "server/work/cell_loop.h"

/* A process that was made and not yet told of as ended. */
struct zygote_child {
    unsigned long long number;
    int pid;           /* its own until it was waited for */
    int ended, status; /* it was waited for; how it ended */
    int dropped;       /* nobody will ask how it ended */
};

struct zygote {
    struct srv_zygote_rules rules;
    struct srv_calls_filter *filter; /* NULL = none */
    unsigned long long made;         /* processes, so far */
    int count;
    struct zygote_child child[SRV_ZYGOTE_MOST];
    struct zygote_spare {
        unsigned long long number;
        int pid, fd;
    } spare;   /* made ahead; pid 0 = none */
    int wants; /* one is to be made ahead: not after one that ended by itself, or that could not be
                  made, until somebody asks, or processes that end at once would be made without
                  pause */
};

/* a signal's handler: poll ends */
static void zygote_wake(int number) { (void)number; }

/* --- the processes --- */

/* what a process may take; a core would hold what the client has sent */
static void zygote_limit(const struct srv_zygote_rules *rules) {
    const struct rlimit none = {0, 0}, seconds = {(rlim_t)rules->seconds, (rlim_t)rules->seconds},
                        bytes = {(rlim_t)rules->bytes, (rlim_t)rules->bytes};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &seconds);
    if (srv_calls_sanitized()) return;
    setrlimit(RLIMIT_DATA, &bytes);
    setrlimit(RLIMIT_NOFILE, &none);
    setrlimit(RLIMIT_NPROC, &none);
}

/* Has this process end with the one that made it, `maker`, whatever it does then. Returns 0 where
 * that has gone already. */
static int zygote_bind(int maker) {
    return !prctl(PR_SET_PDEATHSIG, SIGKILL) && (int)getppid() == maker;
}

/* the life of a process that computes */
static _Noreturn void zygote_child_main(const struct zygote *zygote, int maker, int fd) {
    signal(SIGCHLD, SIG_DFL);
    if (!zygote_bind(maker)) _exit(1);
    prctl(PR_SET_NAME, "pendulumd-cell");
    /* what a sanitizer has found is told */
    if (!srv_calls_sanitized()) dup2(STDIN_FILENO, STDERR_FILENO);
    if (fd != SRV_ZYGOTE_FD && (dup2(fd, SRV_ZYGOTE_FD) < 0)) _exit(1);
    close_range(SRV_ZYGOTE_FD + 1, ~0U, 0);
    zygote_limit(&zygote->rules);
    if (zygote->filter && !srv_calls_computing_close(zygote->filter)) _exit(1);
    srv_cell_loop(SRV_ZYGOTE_FD);
    _exit(0);
}

/* makes a process, and says its number, its pid and the daemon's end of its socket; pid -1 = it
 * could not be made */
static struct zygote_spare zygote_fork(struct zygote *zygote) {
    struct zygote_spare made = {.pid = -1, .fd = -1};
    int ends[2], maker = (int)getpid();
    if (zygote->count == SRV_ZYGOTE_MOST ||
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends))
        return made;
    int pid = (int)fork();
    if (!pid) zygote_child_main(zygote, maker, ends[1]);
    close(ends[1]);
    if (pid < 0) {
        close(ends[0]);
        return made;
    }
    made = (struct zygote_spare){++zygote->made, pid, ends[0]};
    zygote->child[zygote->count++] = (struct zygote_child){.number = made.number, .pid = pid};
    return made;
}

static struct zygote_child *zygote_find(struct zygote *zygote, unsigned long long number) {
    for (int i = 0; i < zygote->count; i++)
        if (zygote->child[i].number == number) return &zygote->child[i];
    return NULL;
}

/* the one that has a pid: of those that were waited for it may be another's again */
static struct zygote_child *zygote_running(struct zygote *zygote, int pid) {
    for (int i = 0; i < zygote->count; i++)
        if (zygote->child[i].pid == pid && !zygote->child[i].ended) return &zygote->child[i];
    return NULL;
}

static void zygote_forget(struct zygote *zygote, struct zygote_child *child) {
    assert(zygote->count > 0 && child->ended);
    *child = zygote->child[--zygote->count];
}

static void zygote_ended(struct zygote *zygote, struct zygote_child *child, int status) {
    child->ended = 1;
    child->status = status;
    if (zygote->spare.pid && child->number == zygote->spare.number) {
        close(zygote->spare.fd);
        zygote->spare.pid = zygote->wants = 0;
        child->dropped = 1;
    }
    if (child->dropped) zygote_forget(zygote, child);
}

/* waits for those that have ended */
static void zygote_reap(struct zygote *zygote) {
    int status, pid;
    while ((pid = (int)waitpid(-1, &status, WNOHANG)) > 0) {
        struct zygote_child *child = zygote_running(zygote, pid);
        if (child) zygote_ended(zygote, child, status);
    }
}

/* --- orders --- */

/* answers with a descriptor, -1 = without one; returns 0 where the daemon has gone */
static int zygote_tell(const struct srv_zygote_told *told, int fd) {
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {.room = {0}};
    struct iovec iov = {.iov_base = (void *)told, .iov_len = sizeof *told};
    struct msghdr message = {.msg_iov = &iov, .msg_iovlen = 1};
    if (fd >= 0) {
        message.msg_control = control.room;
        message.msg_controllen = sizeof control.room;
        struct cmsghdr *head = CMSG_FIRSTHDR(&message);
        head->cmsg_level = SOL_SOCKET;
        head->cmsg_type = SCM_RIGHTS;
        head->cmsg_len = CMSG_LEN(sizeof fd);
        memcpy(CMSG_DATA(head), &fd, sizeof fd);
    }
    return sendmsg(SRV_ZYGOTE_FD, &message, MSG_NOSIGNAL) == (ssize_t)sizeof *told;
}

/* ends a process; nobody but this one waits for it, so until then its pid is its own */
static int zygote_end(struct zygote *zygote, unsigned long long number, int tells) {
    struct zygote_child *child = zygote_find(zygote, number);
    struct srv_zygote_told told = {.pid = child && !child->dropped ? child->pid : -1,
                                   .number = number};
    if (child && !child->ended) kill(child->pid, SIGKILL);
    if (child && !tells) {
        child->dropped = 1;
        if (child->ended) zygote_forget(zygote, child);
    }
    if (!tells) return 1;
    if (told.pid > 0) {
        if (!child->ended && waitpid(told.pid, &child->status, 0) == told.pid) child->ended = 1;
        told.status = child->status;
        if (child->ended) zygote_forget(zygote, child);
    }
    return zygote_tell(&told, -1);
}

/* what processes may take from now on; the one that was made ahead is of before */
static void zygote_rule(struct zygote *zygote, const struct srv_zygote_rules *rules) {
    struct srv_zygote_rules *now = &zygote->rules;
    if (rules->bytes == now->bytes && rules->seconds == now->seconds) return;
    now->bytes = rules->bytes;
    now->seconds = rules->seconds;
    if (!zygote->spare.pid) return;
    close(zygote->spare.fd);
    zygote->spare.pid = 0;
    (void)zygote_end(zygote, zygote->spare.number, 0);
}

static int zygote_new(struct zygote *zygote, const struct srv_zygote_rules *rules) {
    zygote_rule(zygote, rules);
    struct zygote_spare given = zygote->spare.pid ? zygote->spare : zygote_fork(zygote);
    zygote->spare.pid = 0;
    zygote->wants = 1;
    int good =
        zygote_tell(&(struct srv_zygote_told){.pid = given.pid, .number = given.number}, given.fd);
    if (given.fd >= 0) close(given.fd);
    return good;
}

/* takes an order, if there is one; returns 0 when the daemon has gone */
static int zygote_obey(struct zygote *zygote) {
    struct srv_zygote_order order;
    struct iovec iov = {&order, sizeof order};
    struct msghdr message = {.msg_iov = &iov, .msg_iovlen = 1};
    ssize_t got = recvmsg(SRV_ZYGOTE_FD, &message, MSG_DONTWAIT);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got != (ssize_t)sizeof order) return 0;
    switch (order.what) {
    case SRV_ZYGOTE_NEW:
        return zygote_new(zygote, &order.rules);
    case SRV_ZYGOTE_END:
        return zygote_end(zygote, order.number, 1);
    case SRV_ZYGOTE_DROP:
        return zygote_end(zygote, order.number, 0);
    default:
        return 0;
    }
}

static _Noreturn void zygote_serve(struct zygote *zygote) {
    sigset_t none, child;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    sigprocmask(SIG_BLOCK, &child, &none);
    sigdelset(&none, SIGCHLD);
    for (;;) {
        struct pollfd ear = {.fd = SRV_ZYGOTE_FD, .events = POLLIN};
        const struct timespec at_once = {0};
        int waits = ppoll(&ear, 1, &at_once, &none);
        zygote_reap(zygote);
        /* while nobody waits: a process for the next who asks */
        if (waits <= 0 && !zygote->spare.pid && zygote->wants) {
            struct zygote_spare spare = zygote_fork(zygote);
            if (spare.pid > 0)
                zygote->spare = spare;
            else
                zygote->wants = 0;
        }
        if (waits <= 0) ppoll(&ear, 1, NULL, &none);
        zygote_reap(zygote);
        if (!zygote_obey(zygote)) break;
    }
    for (int i = 0; i < zygote->count; i++)
        if (!zygote->child[i].ended) kill(zygote->child[i].pid, SIGKILL);
    /* without what a sanitizer does at the end, which wants files */
    _exit(0);
}

/* --- the beginning --- */

/* gives up what it does not need; returns 0 where --walls on needs more than there is */
static int zygote_confine(struct zygote *zygote, struct srv_zygote_hello *hello) {
    const struct srv_fence fence = {.count = 0};
    struct pend_error error = {.text = ""};
    size_t used = 0;
    for (int wall = 0; zygote->rules.walls != 0 && wall < 3; wall++) {
        enum pend_status status = wall == 0   ? srv_privileges_drop(&error)
                                  : wall == 1 ? srv_fence_close(&fence, &error)
                                              : srv_calls_computing_new(&zygote->filter, &error);
        if (status == PEND_OK) continue;
        if (used < sizeof hello->lack)
            used += (size_t)snprintf(hello->lack + used, sizeof hello->lack - used, "%s%.90s",
                                     used ? "; " : "", error.text);
        if (zygote->rules.walls != SRV_CONFIG_AUTO) return 0;
    }
    return 1;
}

int srv_zygote_main(void) {
    struct srv_zygote_hello hello = {.good = 0};
    const struct sigaction wake = {.sa_handler = zygote_wake};
    if (!srv_spawned()) {
        fprintf(stderr, "pendulumd: compute is what the server starts by itself: --isolate on\n");
        return 2;
    }
    struct zygote *zygote = calloc(1, sizeof *zygote);
    prctl(PR_SET_NAME, "pendulumd-cells");
    if (zygote) zygote->wants = 1;
    if (!zygote || sigaction(SIGCHLD, &wake, NULL) ||
        read(SRV_ZYGOTE_FD, &zygote->rules, sizeof zygote->rules) !=
            (ssize_t)sizeof zygote->rules) {
        free(zygote);
        return 1;
    }
    hello.good = zygote_confine(zygote, &hello);
    /* the end of its socket says so too, but only to one that looks */
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (send(SRV_ZYGOTE_FD, &hello, sizeof hello, MSG_NOSIGNAL) == (ssize_t)sizeof hello &&
        hello.good)
        zygote_serve(zygote);
    free(zygote);
    return 0;
}
