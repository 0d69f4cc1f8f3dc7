#include "server/jobs/courier.h"

#include <assert.h>
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/container_of.h"
#include "server/sandbox/spawn.h"
#include "server/hooks/hook_loop.h"
#include "server/jobs/job_view.h"

enum {
    COURIER_TAKES = 8,    /* hooks that one question takes */
    COURIER_SHARE = 8,    /* messages of one client under way, after which others go first */
    COURIER_SOURCE = 16,  /* and of all clients of one address or account */
    COURIER_LEASE_S = 60, /* longer than hook_loop gives a message */
    COURIER_LOOK_MS = 1000,
    COURIER_PAUSE_MS = 100 /* between two looks, however much news there is */
};

/* s until the next attempt, after so many that failed: what Standard Webhooks proposes */
static const int courier_pauses[] = {5, 300, 1800, 7200, 18000, 36000, 50400, 72000, 86400};

/* A message under way. */
struct courier_place {
    int used;
    char job[SRV_ID_BYTES], client[SRV_NAME_BYTES], source[SRV_NAME_BYTES];
    long attempt;
};

struct srv_courier {
    struct srv_service *service;
    pthread_t thread;
    int runs, fd, bell;
    atomic_int over, lost;
    int more; /* the last look may have left some */
    struct courier_place place[SRV_HOOK_LOOP_MOST];
    struct srv_hook_order order;
};

/* --- questions to the store --- */

struct courier_take {
    struct srv_ask ask; /* first */
    const char *busy[SRV_HOOKS_BUSY];
    int most, count;
    struct srv_hook hook[COURIER_TAKES];
};

static enum srv_stored take_run(struct srv_store *store, struct srv_store_call *call) {
    struct courier_take *take = SRV_CONTAINER_OF(call, struct courier_take, ask.call);
    return srv_store_hooks_take(store, (int64_t)COURIER_LEASE_S * 1000000, take->busy, take->most,
                                take->hook, &take->count);
}

struct courier_told {
    struct srv_ask ask; /* first */
    const struct courier_place *place;
    enum srv_notify notify;
    int64_t after_us;
    int status;
};

static enum srv_stored told_run(struct srv_store *store, struct srv_store_call *call) {
    const struct courier_told *told = SRV_CONTAINER_OF(call, struct courier_told, ask.call);
    return srv_store_hook_told(store, told->place->job, told->place->attempt, told->notify,
                               told->after_us, told->status);
}

/* Writes how it went, and frees the place. What the store does not take is due again when the lease
 * has run out. */
static void courier_tell(struct srv_courier *courier, struct courier_place *place,
                         enum srv_notify notify, int64_t after_s, int status) {
    enum { TRIES = 5 };
    enum srv_stored stored = SRV_STORED_AGAIN;
    for (int i = 0; i < TRIES && stored == SRV_STORED_AGAIN; i++) {
        struct courier_told told = {.ask.call.run = told_run,
                                    .place = place,
                                    .notify = notify,
                                    .after_us = after_s * 1000000,
                                    .status = status};
        stored = srv_storage_wait(courier->service->storage, SRV_ASK_WRITE, &told.ask);
    }
    place->used = 0;
}

/* --- messages --- */

/* what the process that sends says of one */
static void courier_heard(struct srv_courier *courier, const struct srv_hook_told *told) {
    struct srv_metrics *metrics = &courier->service->metrics;
    struct courier_place *place = &courier->place[told->place];
    int pauses = (int)(sizeof courier_pauses / sizeof *courier_pauses);
    if (!place->used) return;
    int good = told->end == SRV_HOOK_ANSWERED && told->status >= 200 && told->status < 300;
    /* who is gone says so, and where nothing may be sent nothing ever may */
    int final = told->end == SRV_HOOK_REFUSED || told->status == 410 || place->attempt > pauses;
    if (good)
        srv_metrics_count(&metrics->hooks_delivered, 1);
    else if (told->end == SRV_HOOK_REFUSED)
        srv_metrics_count(&metrics->hooks_refused, 1);
    else
        srv_metrics_count(&metrics->hooks_failed, 1);
    if (!good && final) srv_metrics_count(&metrics->hooks_given_up, 1);
    int after = good || final ? 0 : courier_pauses[place->attempt - 1];
    courier_tell(courier, place,
                 good    ? SRV_NOTIFY_DELIVERED
                 : final ? SRV_NOTIFY_FAILED
                         : SRV_NOTIFY_WANTED,
                 after, told->end == SRV_HOOK_ANSWERED ? told->status : 0);
    courier->more = 1;
}

/* writes the order of a hook; returns 0 where it cannot be written */
static int courier_write(struct srv_courier *courier, const struct srv_hook *hook, int place) {
    struct srv_hook_order *order = &courier->order;
    struct api_job view = srv_job_view(&hook->job);
    struct api_buffer body;
    /* the message is the same at every attempt */
    view.notify = NULL;
    memset(order, 0, sizeof *order);
    api_buffer_init(&body, SRV_HOOK_BODY);
    int good = api_webhook_write(&view, &body) == PEND_OK && body.bytes <= SRV_HOOK_BODY;
    if (good) {
        order->place = place;
        order->bytes = (int)body.bytes;
        memcpy(order->body, body.data, body.bytes);
        memcpy(order->url, hook->url, sizeof order->url);
        api_webhook_id(hook->job.id, order->id);
        snprintf(order->timestamp, sizeof order->timestamp, "%lld", (long long)time(NULL));
        srv_hook_keys_sign(courier->service->hook_keys, hook->job.client, order->id,
                           order->timestamp, order->body, body.bytes, order->signatures);
    }
    api_buffer_clear(&body);
    return good;
}

static void courier_send(struct srv_courier *courier, const struct srv_hook *hook) {
    int at = 0;
    while (at < SRV_HOOK_LOOP_MOST && courier->place[at].used) at++;
    assert(at < SRV_HOOK_LOOP_MOST);
    struct courier_place *place = &courier->place[at];
    *place = (struct courier_place){.used = 1, .attempt = hook->attempt};
    memcpy(place->job, hook->job.id, sizeof place->job);
    memcpy(place->client, hook->job.client, sizeof place->client);
    memcpy(place->source, hook->source, sizeof place->source);
    if (courier_write(courier, hook, at) &&
        send(courier->fd, &courier->order, sizeof courier->order, MSG_NOSIGNAL) ==
            (ssize_t)sizeof courier->order)
        return;
    courier_tell(courier, place, SRV_NOTIFY_WANTED, courier_pauses[0], 0);
}

/* which clients and sources have many messages under way; returns how many places are free */
static int courier_busy(const struct srv_courier *courier, const char *busy[SRV_HOOKS_BUSY]) {
    int free_places = 0, clients = 0, sources = SRV_HOOKS_CLIENTS;
    for (int i = 0; i < SRV_HOOK_LOOP_MOST; i++) {
        const struct courier_place *place = &courier->place[i];
        int same = 0, near = 0;
        free_places += !place->used;
        for (int k = 0; k <= i && place->used; k++) {
            const struct courier_place *other = &courier->place[k];
            same += other->used && !strcmp(other->client, place->client);
            near += other->used && *place->source && !strcmp(other->source, place->source);
        }
        /* each once: at the message that makes it busy */
        if (same == COURIER_SHARE && clients < SRV_HOOKS_CLIENTS) busy[clients++] = place->client;
        if (near == COURIER_SOURCE && sources < SRV_HOOKS_BUSY) busy[sources++] = place->source;
    }
    return free_places;
}

/* hands out what is due, as far as there is room */
static void courier_look(struct srv_courier *courier) {
    struct courier_take *take = calloc(1, sizeof *take);
    courier->more = 0;
    if (!take) return;
    take->ask.call.run = take_run;
    int room = courier_busy(courier, take->busy);
    take->most = room < COURIER_TAKES ? room : COURIER_TAKES;
    if (take->most > 0 &&
        srv_storage_wait(courier->service->storage, SRV_ASK_WRITE, &take->ask) == SRV_STORED) {
        courier->more = take->count == take->most;
        for (int i = 0; i < take->count; i++) courier_send(courier, &take->hook[i]);
    }
    free(take);
}

/* --- the thread --- */

/* takes what the process that sends has said; returns 0 where it has gone */
static int courier_hear(struct srv_courier *courier) {
    for (;;) {
        struct srv_hook_told told;
        ssize_t got = recv(courier->fd, &told, sizeof told, MSG_DONTWAIT);
        if (got < 0) return errno == EAGAIN || errno == EINTR;
        if (got != (ssize_t)sizeof told || told.place < 0 || told.place >= SRV_HOOK_LOOP_MOST)
            return 0;
        courier_heard(courier, &told);
    }
}

static void *courier_main(void *context) {
    struct srv_courier *courier = context;
    int64_t look = srv_clock_now(), pause = srv_clock_span(COURIER_PAUSE_MS / 1000.0);
    int64_t idle = srv_clock_span(COURIER_LOOK_MS / 1000.0), last = look - pause;
    while (!atomic_load(&courier->over)) {
        struct pollfd ears[] = {{.fd = courier->fd, .events = POLLIN},
                                {.fd = courier->bell, .events = POLLIN}};
        int64_t now = srv_clock_now(), ms = (look - now) / 1000000 + 1;
        (void)poll(ears, 2, look > now ? (int)ms : 0);
        if (!courier_hear(courier)) {
            if (!atomic_load(&courier->over)) atomic_store(&courier->lost, 1);
            break;
        }
        uint64_t rung = 0;
        if (ears[1].revents & POLLIN && read(courier->bell, &rung, sizeof rung) > 0)
            courier->more = 1;
        now = srv_clock_now();
        if (now >= look && atomic_load(&courier->service->draining) == SRV_DRAIN_NOT) {
            courier_look(courier);
            last = srv_clock_now();
            look = last + idle;
        } else if (now >= look)
            look = now + idle;
        if (courier->more && look > last + pause) look = last + pause;
    }
    return NULL;
}

/* --- its life --- */

static enum pend_status courier_greet(const struct srv_courier *courier,
                                      const struct srv_config *config, char lack[SRV_CONFIG_TEXT],
                                      struct pend_error *error) {
    struct srv_hook_rules rules = {.walls = config->walls};
    struct srv_hook_hello hello = {.good = 0};
    struct iovec iov = {&hello, sizeof hello};
    struct msghdr message = {.msg_iov = &iov, .msg_iovlen = 1};
    memcpy(rules.networks, config->webhook_networks, sizeof rules.networks);
    memcpy(rules.authority, config->webhook_authority, sizeof rules.authority);
    if (send(courier->fd, &rules, sizeof rules, MSG_NOSIGNAL) != (ssize_t)sizeof rules ||
        srv_spawn_hear(courier->fd, &message) != (ssize_t)sizeof hello)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--webhook-secret: the process that is to send did not begin");
    hello.lack[sizeof hello.lack - 1] = 0;
    if (!hello.good)
        return pend_fail(error, PEND_INVALID, -1, 0, "--webhook-secret: walls: %.190s", hello.lack);
    snprintf(lack, SRV_CONFIG_TEXT, "%s", hello.lack);
    return PEND_OK;
}

enum pend_status srv_courier_new(struct srv_courier **courier, const struct srv_config *config,
                                 char lack[SRV_CONFIG_TEXT], struct pend_error *error) {
    struct srv_courier *made = *courier = calloc(1, sizeof *made);
    lack[0] = 0;
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->fd = -1;
    made->bell = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    enum pend_status status =
        made->bell >= 0 && srv_spawn("hooks", &made->fd) > 0
            ? courier_greet(made, config, lack, error)
            : pend_fail(error, PEND_INVALID, -1, 0, "--webhook-secret: %s", strerror(errno));
    if (status != PEND_OK) srv_courier_free(courier);
    return status;
}

enum pend_status srv_courier_start(struct srv_courier *courier, struct srv_service *service) {
    assert(service->storage && service->hook_keys);
    courier->service = service;
    courier->runs = !pthread_create(&courier->thread, NULL, courier_main, courier);
    return courier->runs ? PEND_OK : PEND_NO_MEMORY;
}

void srv_courier_news(struct srv_courier *courier) {
    const uint64_t one = 1;
    if (courier && write(courier->bell, &one, sizeof one) < 0) return;
}

int srv_courier_lost(const struct srv_courier *courier) { return atomic_load(&courier->lost); }

void srv_courier_end(struct srv_courier *courier) {
    if (!courier || !courier->runs) return;
    atomic_store(&courier->over, 1);
    srv_courier_news(courier);
    pthread_join(courier->thread, NULL);
    courier->runs = 0;
    /* what has been said is kept; what has not may have been sent, and is sent again */
    (void)courier_hear(courier);
    close(courier->fd);
    courier->fd = -1;
    for (int i = 0; i < SRV_HOOK_LOOP_MOST; i++)
        if (courier->place[i].used)
            courier_tell(courier, &courier->place[i], SRV_NOTIFY_WANTED, 0, 0);
}

void srv_courier_free(struct srv_courier **courier) {
    struct srv_courier *gone = *courier;
    *courier = NULL;
    if (!gone) return;
    assert(!gone->runs);
    if (gone->fd >= 0) close(gone->fd);
    if (gone->bell >= 0) close(gone->bell);
    free(gone);
}
