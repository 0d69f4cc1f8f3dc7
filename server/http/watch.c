#include "server/http/watch.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/condition.h"

enum {
    WATCH_SLOW_MS = 250,  /* the period in ms if only deadlines matter */
    WATCH_AFTERGLOW = 40, /* short periods after the last waiting connection, so that short requests
                           * need not wake the thread */
    WATCH_SIGHTS = 2 /* periods for which a client is kept after it has shut down its side, because
                      * it may still want its response */
};

static const char watch_head[] =
    "HTTP/1.1 408 Request Timeout\r\nContent-Type: application/problem+json\r\n"
    "Cache-Control: no-store\r\nConnection: close\r\n";
static const char watch_body[] =
    "{\"type\":\"about:blank\",\"title\":\"Request Timeout\",\"status\":408,\"detail\":\"the "
    "request was not complete in time\"}";

struct watch_lingerer {
    int fd;
    int64_t deadline;
};

/* In `watched`, connections that are not idle come first, so that a short period need not visit
 * thousands of others. */
struct srv_watch {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t thread;
    int stopping, asleep; /* asleep: the thread waits longer than a short period */
    int count, waiting, glow;
    int64_t listened; /* ns: last check of the event streams */
    struct srv_list watched;
    char timeout[512]; /* the text of the 408 response */
    int lingerers;
    int most; /* the most connections that can be watched */
    struct watch_lingerer linger[SRV_WATCH_LINGERING];
};

PEND_VALIDATOR watch_valid(const struct srv_watch *watch) {
    return watch->count >= 0 && watch->waiting >= 0 && watch->waiting <= watch->count &&
           watch->lingerers >= 0 && watch->lingerers <= SRV_WATCH_LINGERING &&
           srv_list_empty(&watch->watched) == !watch->count;
}

/* After the deadline: answers 408 to a client whose request is incomplete, and closes the
 * connection. */
static void watch_expire(struct srv_watch *watch, struct srv_watched *watched) {
    if (watched->phase == SRV_WATCH_READING) {
        atomic_store(&watched->late, 1);
        (void)!send(watched->fd, watch->timeout, strlen(watch->timeout),
                    MSG_DONTWAIT | MSG_NOSIGNAL);
    }
    shutdown(watched->fd, SHUT_RDWR);
    watched->deadline = 0;
}

static void watch_look(struct srv_watched *watched) {
    struct pollfd look = {.fd = watched->fd, .events = POLLRDHUP};
    if (watched->seen >= WATCH_SIGHTS || poll(&look, 1, 0) <= 0) return;
    watched->seen = look.revents & (POLLERR | POLLHUP) ? WATCH_SIGHTS : watched->seen + 1;
    if (watched->seen >= WATCH_SIGHTS) watched->left(watched);
}

/* Reports to libmicrohttpd that a client closed the stream in mid-request. libmicrohttpd takes a
 * short read for the end of the data until epoll reports again, which epoll does not if that end
 * arrived together with data. */
static void watch_end(struct srv_watched *watched) {
    struct pollfd look = {.fd = watched->fd, .events = POLLRDHUP};
    int unread = 0;
    if (poll(&look, 1, 0) <= 0 || ioctl(watched->fd, FIONREAD, &unread) || unread) return;
    if (++watched->seen >= WATCH_SIGHTS) shutdown(watched->fd, SHUT_RD);
}

static struct srv_watched *watch_of_link(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct srv_watched, link);
}

/* Closes a connection whose key was revoked or has expired. */
static void watch_revoke(struct srv_watched *watched) {
    if (!watched->keys || srv_key_ring_holds(watched->keys, watched->issued, (int64_t)time(NULL)))
        return;
    watched->keys = NULL;
    shutdown(watched->fd, SHUT_RDWR);
    if (watched->phase == SRV_WATCH_SENDING || watched->seen >= WATCH_SIGHTS) return;
    watched->seen = WATCH_SIGHTS;
    watched->left(watched);
}

static void watch_round(struct srv_watch *watch) {
    int64_t now = srv_clock_now();
    int slow = now - watch->listened >= (int64_t)(WATCH_SLOW_MS - SRV_WATCH_TICK_MS) * 1000000;
    if (slow) watch->listened = now;
    SRV_LIST_EACH (link, &watch->watched) {
        struct srv_watched *watched = watch_of_link(link);
        if (watched->phase != SRV_WATCH_WAITING && !slow) return;
        if (slow) watch_revoke(watched);
        if (watched->phase == SRV_WATCH_WAITING || watched->phase == SRV_WATCH_LISTENING)
            watch_look(watched);
        if (watched->phase == SRV_WATCH_READING && slow) watch_end(watched);
        if (watched->deadline && now > watched->deadline) watch_expire(watch, watched);
    }
}

/* Reads and discards incoming bytes. Returns 0 at the end of the stream. */
static int watch_read_on(int fd) {
    char rubbish[16384];
    for (int turn = 0; turn < 16; turn++) {
        ssize_t got = recv(fd, rubbish, sizeof rubbish, MSG_DONTWAIT);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return got < 0 && errno == EAGAIN;
    }
    return 1;
}

static void watch_linger_round(struct srv_watch *watch) {
    int64_t now = srv_clock_now();
    int kept = 0;
    for (int i = 0; i < watch->lingerers; i++) {
        struct watch_lingerer lingerer = watch->linger[i];
        if (now < lingerer.deadline && watch_read_on(lingerer.fd))
            watch->linger[kept++] = lingerer;
        else
            close(lingerer.fd);
    }
    watch->lingerers = kept;
    assert(watch_valid(watch));
}

static void watch_sleep(struct srv_watch *watch) {
    if (watch->waiting || watch->lingerers) watch->glow = WATCH_AFTERGLOW;
    int glows = watch->glow > 0, ms = glows ? SRV_WATCH_TICK_MS : watch->count ? WATCH_SLOW_MS : 0;
    watch->glow -= glows;
    watch->asleep = ms != SRV_WATCH_TICK_MS;
    srv_condition_wait(&watch->wake, &watch->lock,
                       ms ? srv_clock_now() + (int64_t)ms * 1000000 : SRV_CONDITION_NEVER);
    watch->asleep = 0;
}

static void *watch_main(void *argument) {
    struct srv_watch *watch = argument;
    pthread_mutex_lock(&watch->lock);
    while (!watch->stopping) {
        watch_round(watch);
        watch_linger_round(watch);
        watch_sleep(watch);
    }
    pthread_mutex_unlock(&watch->lock);
    return NULL;
}

void srv_watch_lingering(struct srv_watch *watch, int most) {
    assert(most >= 0 && most <= SRV_WATCH_LINGERING);
    watch->most = most;
}

enum pend_status srv_watch_new(struct srv_watch **watch) {
    struct srv_watch *made = *watch = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    made->most = SRV_WATCH_LINGERING;
    pthread_mutex_init(&made->lock, NULL);
    srv_condition_init(&made->wake);
    snprintf(made->timeout, sizeof made->timeout, "%sContent-Length: %zu\r\n\r\n%s", watch_head,
             sizeof watch_body - 1, watch_body);
    if (!pthread_create(&made->thread, NULL, watch_main, made)) return PEND_OK;
    pthread_cond_destroy(&made->wake);
    pthread_mutex_destroy(&made->lock);
    free(made);
    *watch = NULL;
    return PEND_NO_MEMORY;
}

void srv_watch_free(struct srv_watch **watch) {
    struct srv_watch *gone = *watch;
    *watch = NULL;
    if (!gone) return;
    pthread_mutex_lock(&gone->lock);
    gone->stopping = 1;
    pthread_cond_signal(&gone->wake);
    pthread_mutex_unlock(&gone->lock);
    pthread_join(gone->thread, NULL);
    assert(!gone->count);
    for (int i = 0; i < gone->lingerers; i++) close(gone->linger[i].fd);
    pthread_cond_destroy(&gone->wake);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

/* Ends a long sleep. The caller holds the lock. */
static void watch_wake(struct srv_watch *watch) {
    if (watch->asleep) pthread_cond_signal(&watch->wake);
    watch->asleep = 0;
}

void srv_watch_add(struct srv_watch *watch, struct srv_watched *watched, int64_t deadline) {
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    watched->phase = SRV_WATCH_IDLE;
    watched->deadline = deadline;
    watched->since = srv_clock_now();
    watched->served = watched->seen = 0;
    srv_list_append(&watch->watched, &watched->link);
    if (!watch->count++) watch_wake(watch);
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
}

void srv_watch_remove(struct srv_watch *watch, struct srv_watched *watched) {
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    srv_list_remove(&watched->link);
    watch->count--;
    watch->waiting -= watched->phase == SRV_WATCH_WAITING;
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
}

void srv_watch_phase(struct srv_watch *watch, struct srv_watched *watched,
                     enum srv_watch_phase phase, int64_t deadline) {
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    int waits = phase == SRV_WATCH_WAITING;
    if (waits != (watched->phase == SRV_WATCH_WAITING)) {
        watch->waiting += waits ? 1 : -1;
        srv_list_remove(&watched->link);
        srv_list_insert(waits ? &watch->watched : watch->watched.previous, &watched->link);
    }
    watched->phase = phase;
    watched->deadline = deadline;
    watched->seen = 0;
    if (phase == SRV_WATCH_IDLE || phase == SRV_WATCH_READING) watched->keys = NULL;
    if (phase == SRV_WATCH_IDLE) {
        watched->since = srv_clock_now();
        watched->served = 1;
    }
    if (phase == SRV_WATCH_WAITING) watch_wake(watch);
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
}

int srv_watch_crowd_out(struct srv_watch *watch) {
    struct srv_watched *found = NULL;
    int most = 0;
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    /* Connections that have always been idle are in the order in which they were added. */
    SRV_LIST_EACH (link, &watch->watched) {
        struct srv_watched *at = watch_of_link(link);
        if (at->phase != SRV_WATCH_IDLE || at->served || !at->siblings) continue;
        int siblings = atomic_load(at->siblings);
        if (siblings <= most) continue;
        most = siblings;
        found = at;
    }
    if (found) {
        shutdown(found->fd, SHUT_RDWR);
        found->siblings = NULL;
    }
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
    return found != NULL;
}

void srv_watch_key(struct srv_watch *watch, struct srv_watched *watched, struct srv_key_ring *keys,
                   const char issued[API_DIGEST_BYTES]) {
    pthread_mutex_lock(&watch->lock);
    watched->keys = *issued ? keys : NULL;
    memcpy(watched->issued, issued, sizeof watched->issued);
    pthread_mutex_unlock(&watch->lock);
}

void srv_watch_leave_all(struct srv_watch *watch) {
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    SRV_LIST_EACH (link, &watch->watched) {
        struct srv_watched *watched = watch_of_link(link);
        if ((watched->phase == SRV_WATCH_WAITING || watched->phase == SRV_WATCH_STREAMING ||
             watched->phase == SRV_WATCH_LISTENING) &&
            watched->seen < WATCH_SIGHTS) {
            watched->seen = WATCH_SIGHTS;
            watched->left(watched);
        }
    }
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
}

int srv_watch_busy(struct srv_watch *watch, int64_t began, int64_t patience) {
    int busy = 0;
    int64_t now = srv_clock_now(), moment = (int64_t)SRV_WATCH_MOMENT_MS * 1000000,
            lingering = now + (int64_t)SRV_WATCH_LINGER_MS * 1000000 - moment;
    if (patience < moment) patience = moment;
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    for (int i = 0; i < watch->lingerers; i++) busy += watch->linger[i].deadline > lingering;
    SRV_LIST_EACH (link, &watch->watched) {
        struct srv_watched *watched = watch_of_link(link);
        int unread = 0;
        /* A browser retries on another connection; a proxy must not retry a POST. */
        int64_t kept = atomic_load(&watched->relayed) ? patience : moment;
        busy += watched->phase != SRV_WATCH_IDLE ||
                now - watched->since < (watched->served ? moment : patience) ||
                (watched->served && now - began < kept) || ioctl(watched->fd, FIONREAD, &unread) ||
                unread;
    }
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
    return busy;
}

void srv_watch_linger(struct srv_watch *watch, int fd) {
    shutdown(fd, SHUT_WR);
    pthread_mutex_lock(&watch->lock);
    assert(watch_valid(watch));
    int room = watch->lingerers < watch->most;
    if (room) {
        int64_t deadline = srv_clock_now() + (int64_t)SRV_WATCH_LINGER_MS * 1000000;
        watch->linger[watch->lingerers++] = (struct watch_lingerer){fd, deadline};
        watch_wake(watch);
    }
    assert(watch_valid(watch));
    pthread_mutex_unlock(&watch->lock);
    if (!room) close(fd);
}
