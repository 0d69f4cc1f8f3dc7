#include "server/jobs/events.h"

#include <assert.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/condition.h"
#include "server/base/list.h"
#include "server/work/inflight.h"
#include "server/jobs/job_view.h"

enum {
    EVENTS_LOOK_MS = 500, /* how often the store is asked without news */
    EVENTS_LEAST_MS = 40, /* how long nothing is asked after it was */
    EVENTS_TEXT = 8192,
    EVENTS_BYTES = EVENTS_TEXT + 2048 /* that a stream takes in memory */
};

/* A stream that is open. */
struct srv_listener {
    struct srv_exchange *exchange;
    struct srv_list link;
    struct srv_job job;      /* as it was seen last */
    char told[SRV_EVENT_ID]; /* of the event that was sent last; "" = none */
    int64_t beat_at;         /* ns: when a comment is due */
    int beat, over;          /* a comment is due; nothing will come any more */
    int waits;               /* suspended, for the next event */
    struct api_buffer text;  /* what is being sent */
    size_t taken;            /* bytes of it that were */
};

/* A question about all jobs that somebody listens to. */
struct events_look {
    struct srv_ask ask;
    int count;
    struct srv_job *job; /* ids in, states out */
    enum srv_stored *stored;
};

struct srv_events {
    struct srv_service *service;
    pthread_mutex_t lock;
    pthread_cond_t some;
    pthread_t thread;
    int most, count, started, over;
    int news, draining;
    struct srv_list listeners;
    struct events_look look; /* the thread's */
};

int srv_events_valid(const struct srv_events *events) {
    return events->service && events->most > 0 && events->count >= 0 &&
           events->count <= events->most && srv_list_empty(&events->listeners) == !events->count &&
           events->look.count >= 0 && events->look.count <= events->most;
}

void srv_events_id(const struct srv_job *job, char id[SRV_EVENT_ID]) {
    snprintf(id, SRV_EVENT_ID, "%s-%ld", srv_job_word(job->state), job->done);
}

/* --- one stream; called with the lock --- */

static struct srv_listener *listener_of_link(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct srv_listener, link);
}

/* there is something that was not told */
static int listener_news(const struct srv_listener *listener) {
    char id[SRV_EVENT_ID];
    srv_events_id(&listener->job, id);
    return strcmp(id, listener->told) != 0;
}

static enum pend_status listener_event(struct srv_listener *listener) {
    struct api_buffer json, *text = &listener->text;
    struct api_job view = srv_job_view(&listener->job);
    api_buffer_init(&json, EVENTS_TEXT);
    srv_events_id(&listener->job, listener->told);
    enum pend_status status = api_job_write(&view, &json);
    if (status == PEND_OK)
        status = api_buffer_format(text, "event: progress\nid: %s\ndata: ", listener->told);
    if (status == PEND_OK) status = api_buffer_add(text, json.data, json.bytes);
    if (status == PEND_OK) status = api_buffer_text(text, "\n\n");
    api_buffer_clear(&json);
    return status;
}

/* puts what comes next where it is sent from; 0 where nothing does */
static int listener_next(struct srv_listener *listener) {
    enum pend_status status = PEND_OK;
    listener->text.bytes = listener->taken = 0;
    if (listener_news(listener)) {
        status = listener_event(listener);
        listener->over |= srv_job_over(&listener->job);
    } else if (listener->over) {
        return 0;
    } else if (listener->beat) {
        status = api_buffer_text(&listener->text, ":\n\n");
    } else {
        return 0;
    }
    listener->beat = 0;
    listener->beat_at = srv_clock_now() + (int64_t)SRV_EVENTS_BEAT_S * 1000000000;
    /* without memory the client comes again */
    if (status != PEND_OK) listener->text.bytes = 0;
    listener->over |= status != PEND_OK;
    return listener->text.bytes > 0;
}

static void listener_wake(struct srv_listener *listener) {
    if (!listener->waits) return;
    listener->waits = 0;
    listener->exchange->finish(listener->exchange);
}

static void listener_free(struct srv_events *events, struct srv_listener *listener) {
    srv_list_remove(&listener->link);
    events->count--;
    atomic_fetch_sub(&events->service->listening, 1);
    srv_memory_add(&events->service->memory, SRV_MEMORY_CONNECTIONS, -EVENTS_BYTES);
    api_buffer_clear(&listener->text);
    free(listener);
}

/* --- from outside --- */

/* so many of so many, at least one */
static int events_part(int most, int share) { return most / share > 0 ? most / share : 1; }

/* whether a client has its share of the streams, or all clients of its address or account have
 * theirs */
static int events_sated(const struct srv_events *events, const struct srv_identity *who) {
    int own = 0, all = 0;
    SRV_LIST_EACH (link, &events->listeners) {
        const struct srv_listener *at = listener_of_link(link);
        own += !strcmp(at->exchange->identity.key, who->key);
        all += !strcmp(at->exchange->identity.source, who->source);
    }
    return own >= events_part(events->most, SRV_EVENTS_SHARE) ||
           all >= events_part(3 * events->most, SRV_EVENTS_SHARE);
}

enum pend_status srv_events_open(struct srv_events *events, struct srv_exchange *exchange,
                                 const struct srv_job *job, const char *last, int *own) {
    struct srv_listener *made = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    *made =
        (struct srv_listener){.exchange = exchange,
                              .job = *job,
                              .beat_at = srv_clock_now() + (int64_t)SRV_EVENTS_BEAT_S * 1000000000};
    if (last) snprintf(made->told, sizeof made->told, "%s", last);
    api_buffer_init(&made->text, EVENTS_TEXT);
    enum pend_status status = api_buffer_format(&made->text, "retry: %d\n\n", SRV_EVENTS_RETRY_MS);
    pthread_mutex_lock(&events->lock);
    assert(srv_events_valid(events));
    *own = events_sated(events, &exchange->identity);
    if (status == PEND_OK && (*own || events->count >= events->most)) status = PEND_LIMIT;
    if (status == PEND_OK) {
        made->over = events->draining;
        srv_list_append(&events->listeners, &made->link);
        events->count++;
        atomic_fetch_add(&events->service->listening, 1);
        srv_memory_add(&events->service->memory, SRV_MEMORY_CONNECTIONS, EVENTS_BYTES);
        exchange->listener = made;
        exchange->listens = exchange->streams = 1;
        exchange->stream_bytes = -1;
        pthread_cond_signal(&events->some);
    }
    assert(srv_events_valid(events));
    pthread_mutex_unlock(&events->lock);
    if (status == PEND_OK) return PEND_OK;
    api_buffer_clear(&made->text);
    free(made);
    return status;
}

long srv_events_read(struct srv_exchange *exchange, char *to, size_t cap,
                     void (*pause)(struct srv_exchange *)) {
    struct srv_events *events = exchange->service->events;
    long result = SRV_INFLIGHT_BROKEN;
    pthread_mutex_lock(&events->lock);
    assert(srv_events_valid(events));
    struct srv_listener *listener = exchange->listener;
    assert(!listener ||
           (listener->exchange == exchange && listener->taken <= listener->text.bytes));
    if (listener && (listener->taken < listener->text.bytes || listener_next(listener))) {
        size_t left = listener->text.bytes - listener->taken, count = left < cap ? left : cap;
        memcpy(to, listener->text.data + listener->taken, count);
        listener->taken += count;
        result = (long)count;
    } else if (listener && listener->over) {
        result = SRV_INFLIGHT_END;
    } else if (listener) {
        listener->waits = 1;
        pause(exchange);
        result = SRV_INFLIGHT_WAIT;
    }
    assert(srv_events_valid(events));
    pthread_mutex_unlock(&events->lock);
    return result;
}

void srv_events_leave(struct srv_exchange *exchange, enum srv_stop why) {
    struct srv_events *events = exchange->service->events;
    pthread_mutex_lock(&events->lock);
    assert(srv_events_valid(events));
    struct srv_listener *listener = exchange->listener;
    if (listener && why == SRV_STOP_SHUTDOWN) {
        listener->over = 1;
        listener_wake(listener);
    } else if (listener) {
        if (!exchange->stop) exchange->stop = (int)why;
        exchange->listener = NULL;
        listener_wake(listener);
        listener_free(events, listener);
    }
    assert(srv_events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

void srv_events_news(struct srv_events *events) {
    if (!events) return;
    pthread_mutex_lock(&events->lock);
    assert(srv_events_valid(events));
    events->news = 1;
    if (events->count) pthread_cond_signal(&events->some);
    assert(srv_events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

void srv_events_drain(struct srv_events *events) {
    if (!events) return;
    pthread_mutex_lock(&events->lock);
    assert(srv_events_valid(events));
    events->draining = 1;
    SRV_LIST_EACH (link, &events->listeners) {
        struct srv_listener *at = listener_of_link(link);
        at->over = 1;
        listener_wake(at);
    }
    assert(srv_events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

/* --- the thread that looks --- */

static enum srv_stored look_run(struct srv_store *store, struct srv_store_call *call) {
    struct events_look *look = SRV_CONTAINER_OF(call, struct events_look, ask.call);
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < look->count; i++) {
        char id[SRV_ID_BYTES];
        memcpy(id, look->job[i].id, sizeof id);
        /* a store that is away is not asked again for each */
        if (stored < SRV_STORED_AWAY) stored = srv_store_job(store, id, &look->job[i]);
        look->stored[i] = stored;
        memcpy(look->job[i].id, id, sizeof id);
    }
    return stored < SRV_STORED_AWAY ? SRV_STORED : stored;
}

static int look_find(const struct events_look *look, const char *id) {
    int i = 0;
    while (i < look->count && strcmp(look->job[i].id, id) != 0) i++;
    return i;
}

/* lists the jobs that are listened to; with the lock */
static void look_gather(struct srv_events *events) {
    struct events_look *look = &events->look;
    look->count = 0;
    SRV_LIST_EACH (link, &events->listeners) {
        const struct srv_listener *at = listener_of_link(link);
        if (!at->over && look_find(look, at->job.id) == look->count)
            memcpy(look->job[look->count++].id, at->job.id, SRV_ID_BYTES);
    }
}

/* tells what was found; with the lock */
static void look_tell(struct srv_events *events) {
    const struct events_look *look = &events->look;
    int64_t now = srv_clock_now();
    SRV_LIST_EACH (link, &events->listeners) {
        struct srv_listener *at = listener_of_link(link);
        int i = look_find(look, at->job.id), found = i < look->count;
        if (found && look->stored[i] == SRV_STORED) at->job = look->job[i];
        /* it is not kept any more: who comes again is told so */
        if (found && look->stored[i] == SRV_STORED_NONE) at->over = 1;
        if (now >= at->beat_at) at->beat = 1;
        if (at->over || at->beat || listener_news(at)) listener_wake(at);
    }
}

/* waits for something to do; 0 at the end; with the lock */
static int events_wait(struct srv_events *events, int64_t asked) {
    int64_t look = asked + (int64_t)EVENTS_LOOK_MS * 1000000,
            least = asked + (int64_t)EVENTS_LEAST_MS * 1000000;
    while (!events->over) {
        int64_t now = srv_clock_now(), until = events->news ? least : look;
        if (!events->count) {
            srv_condition_wait(&events->some, &events->lock, SRV_CONDITION_NEVER);
            /* the first one has just been told how things are */
            look = srv_clock_now() + (int64_t)EVENTS_LEAST_MS * 1000000;
        } else if (now >= until) {
            break;
        } else {
            srv_condition_wait(&events->some, &events->lock, until);
        }
    }
    events->news = 0;
    return !events->over;
}

static void *events_main(void *context) {
    struct srv_events *events = context;
    int64_t asked = 0;
    pthread_mutex_lock(&events->lock);
    while (events_wait(events, asked)) {
        look_gather(events);
        pthread_mutex_unlock(&events->lock);
        asked = srv_clock_now();
        events->look.ask.call.run = look_run;
        if (events->look.count)
            srv_storage_wait(events->service->storage, SRV_ASK_READ, &events->look.ask);
        pthread_mutex_lock(&events->lock);
        look_tell(events);
    }
    pthread_mutex_unlock(&events->lock);
    return NULL;
}

/* --- start and end --- */

enum pend_status srv_events_new(struct srv_events **events, struct srv_service *service, int most) {
    struct srv_events *made = *events = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    assert(service && most > 0);
    made->service = service;
    made->most = most;
    pthread_mutex_init(&made->lock, NULL);
    srv_condition_init(&made->some);
    made->look.job = calloc((size_t)most, sizeof *made->look.job);
    made->look.stored = calloc((size_t)most, sizeof *made->look.stored);
    if (made->look.job && made->look.stored) return PEND_OK;
    srv_events_free(events);
    return PEND_NO_MEMORY;
}

enum pend_status srv_events_start(struct srv_events *events) {
    events->started = !pthread_create(&events->thread, NULL, events_main, events);
    return events->started ? PEND_OK : PEND_NO_MEMORY;
}

void srv_events_end(struct srv_events *events) {
    pthread_mutex_lock(&events->lock);
    events->over = 1;
    pthread_cond_signal(&events->some);
    pthread_mutex_unlock(&events->lock);
    if (events->started) pthread_join(events->thread, NULL);
    events->started = 0;
}

void srv_events_free(struct srv_events **events) {
    struct srv_events *gone = *events;
    *events = NULL;
    if (!gone) return;
    assert(srv_list_empty(&gone->listeners) && !gone->started);
    free(gone->look.job);
    free(gone->look.stored);
    pthread_cond_destroy(&gone->some);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}
