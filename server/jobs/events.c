#include "server/jobs/events.h"

#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/condition.h"
#include "server/work/inflight.h"

enum {
    EVENTS_LOOK_MS = 500, /* ms between two queries without a notification */
    EVENTS_LEAST_MS = 40, /* least ms between two queries */
    EVENTS_REST = 3,      /* pause before the next backlog query, in multiples of the last query */
    EVENTS_TOPICS = 2,
    EVENTS_BYTES = SRV_EVENTS_TEXT + 2048 /* memory of a stream */
};

struct srv_events {
    struct srv_service *service;
    pthread_mutex_t lock;
    pthread_cond_t some;
    pthread_t thread;
    int most, count, started, over;
    int news, draining;
    enum srv_more more;
    int64_t rested; /* ns: time of the next backlog query */
    struct srv_list listeners;
    struct srv_topic *topic[EVENTS_TOPICS]; /* only the first `topics` are used */
    int topics;
};

PEND_VALIDATOR events_valid(const struct srv_events *events) {
    return events->service && events->most > 0 && events->count >= 0 &&
           events->count <= events->most && srv_list_empty(&events->listeners) == !events->count &&
           events->topics >= 0 && events->topics <= EVENTS_TOPICS;
}

/* --- one stream; called with the lock --- */

static struct srv_listener *listener_of_link(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct srv_listener, link);
}

static size_t listener_bytes(const struct srv_listener *listener) {
    size_t text = listener->text.cap > SRV_EVENTS_TEXT ? listener->text.cap : 0;
    return EVENTS_BYTES + text + listener->kept;
}

static void listener_count(struct srv_listener *listener) {
    assert(listener->taken <= listener->text.bytes);
    srv_hold_set(&listener->hold, listener_bytes(listener));
}

enum srv_room srv_events_keep(struct srv_listener *listener, size_t kept) {
    size_t before = listener->kept;
    listener->kept = kept;
    enum srv_room room = srv_hold_try(&listener->hold, listener_bytes(listener));
    if (room != SRV_ROOM) listener->kept = before;
    return room;
}

/* Copies the next event into the text to send. Returns 0 if there is none. */
static int listener_next(struct srv_listener *listener) {
    enum pend_status status = PEND_OK;
    listener->text.bytes = listener->taken = 0;
    if (listener->text.cap > SRV_EVENTS_TEXT) api_buffer_clear(&listener->text);
    if (listener->topic->news(listener)) {
        status = listener->topic->next(listener);
    } else if (listener->over) {
        return 0;
    } else if (listener->beat && !listener->media_type) {
        status = api_buffer_text(&listener->text, ":\n\n");
    } else {
        return 0;
    }
    listener->beat = 0;
    listener->beat_at = srv_clock_now() + (int64_t)SRV_EVENTS_BEAT_S * 1000000000;
    /* if memory is short the stream ends, and the client reconnects */
    if (status != PEND_OK) listener->text.bytes = 0;
    listener->over |= status != PEND_OK;
    return listener->text.bytes > 0;
}

static void listener_wake(struct srv_listener *listener) {
    if (!listener->waits) return;
    listener->waits = 0;
    listener->exchange->finish(listener->exchange);
}

static void events_more(struct srv_events *events, enum srv_more more) {
    if (events->more < more) events->more = more;
    if (events->more) pthread_cond_signal(&events->some);
}

static void listener_free(struct srv_events *events, struct srv_listener *listener) {
    srv_list_remove(&listener->link);
    events->count--;
    atomic_fetch_sub(&events->service->listening, 1);
    srv_hold_set(&listener->hold, 0);
    /* another report may be waiting until this one ends */
    if (listener->media_type) events_more(events, SRV_MORE_OLD);
    api_buffer_clear(&listener->text);
    listener->topic->drop(listener);
}

static void listener_answer(struct srv_events *events, struct srv_listener *listener) {
    struct srv_exchange *exchange = listener->exchange;
    assert(listener->until && exchange->listener == listener);
    listener->topic->answer(listener);
    assert(exchange->status);
    exchange->listener = NULL;
    listener_free(events, listener);
    exchange->finish(exchange);
}

/* --- public functions --- */

static int events_part(int most, int share) { return most / share > 0 ? most / share : 1; }

/* Returns 1 if the client, or all clients of its address or account together, have used their share
 * of the streams. */
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

/* Adds a stream or a wait if the limits allow it. *own is 1 if the client itself has too many. A
 * wait may end before this returns. */
static enum pend_status events_begin(struct srv_events *events, struct srv_listener *made,
                                     int *own) {
    struct srv_exchange *exchange = made->exchange;
    enum pend_status status = PEND_OK;
    if (!made->until && !made->media_type)
        status = api_buffer_format(&made->text, "retry: %d\n\n", SRV_EVENTS_RETRY_MS);
    pthread_mutex_lock(&events->lock);
    assert(events_valid(events));
    *own = events_sated(events, &exchange->identity);
    if (status == PEND_OK && (*own || events->count >= events->most)) status = PEND_LIMIT;
    if (status == PEND_OK && made->topic->enter) status = made->topic->enter(made);
    if (status == PEND_OK) {
        made->over = events->draining && !made->media_type;
        srv_list_append(&events->listeners, &made->link);
        events->count++;
        atomic_fetch_add(&events->service->listening, 1);
        made->hold = (struct srv_hold){.service = events->service,
                                       .payer = srv_exchange_payer(exchange),
                                       .kind = SRV_MEMORY_CONNECTIONS};
        listener_count(made);
        exchange->listener = made;
        atomic_store(&exchange->listens, 1);
        if (!made->until) {
            exchange->streams = 1;
            exchange->stream_bytes = -1;
        }
        if (made->wants) events_more(events, SRV_MORE_OLD);
        if (events->count == 1) pthread_cond_signal(&events->some);
        if (made->until && made->over) listener_answer(events, made);
    }
    assert(events_valid(events));
    pthread_mutex_unlock(&events->lock);
    return status;
}

/* Frees a listener that could not be added, and answers its exchange. */
static void events_refuse(struct srv_events *events, struct srv_listener *listener,
                          enum pend_status status, int own) {
    struct srv_exchange *exchange = listener->exchange;
    api_buffer_clear(&listener->text);
    listener->topic->drop(listener);
    if (status == PEND_NO_MEMORY) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else if (own) {
        srv_exchange_problem(
            exchange, 429,
            API_TYPE_QUOTA
            "too many event streams: you may have %d (a quarter of max-event-streams) open or "
            "waiting, and your address three times as many",
            events_part(events->most, SRV_EVENTS_SHARE));
        srv_exchange_retry(exchange, 5);
    } else {
        srv_exchange_busy(exchange, 5, "too many event streams are open: max-event-streams");
    }
}

void srv_events_open(struct srv_events *events, struct srv_listener *listener) {
    struct srv_exchange *exchange = listener->exchange;
    int own = 0;
    assert(exchange && listener->topic && !exchange->status && !listener->until);
    api_buffer_init(&listener->text, SRV_EVENTS_TEXT);
    listener->beat_at = srv_clock_now() + (int64_t)SRV_EVENTS_BEAT_S * 1000000000;
    enum pend_status status = events_begin(events, listener, &own);
    if (status != PEND_OK) {
        events_refuse(events, listener, status, own);
        return;
    }
    const char *type = listener->media_type;
    srv_exchange_static(exchange, 200, type ? type : "text/event-stream", NULL, 0);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
    /* keeps nginx from buffering the events */
    if (!type) srv_exchange_header(exchange, "X-Accel-Buffering", "no");
}

int srv_events_await(struct srv_events *events, struct srv_listener *listener) {
    int own = 0;
    assert(listener->exchange && listener->topic->answer && listener->until);
    assert(!listener->exchange->status);
    api_buffer_init(&listener->text, SRV_EVENTS_TEXT);
    listener->beat_at = INT64_MAX;
    enum pend_status status = events_begin(events, listener, &own);
    if (status != PEND_OK) events_refuse(events, listener, status, own);
    return status == PEND_OK;
}

long srv_events_read(struct srv_exchange *exchange, char *to, size_t cap,
                     void (*pause)(struct srv_exchange *)) {
    struct srv_events *events = exchange->service->events;
    long result = SRV_INFLIGHT_BROKEN;
    pthread_mutex_lock(&events->lock);
    assert(events_valid(events));
    struct srv_listener *listener = exchange->listener;
    assert(!listener ||
           (listener->exchange == exchange && listener->taken <= listener->text.bytes));
    if (listener && (listener->taken < listener->text.bytes || listener_next(listener))) {
        size_t left = listener->text.bytes - listener->taken, count = left < cap ? left : cap;
        memcpy(to, listener->text.data + listener->taken, count);
        listener->taken += count;
        result = (long)count;
    } else if (listener && listener->over) {
        result = listener->media_type && !listener->whole ? SRV_INFLIGHT_BROKEN : SRV_INFLIGHT_END;
    } else if (listener) {
        listener->waits = 1;
        listener_count(listener);
        if (listener->wants) events_more(events, SRV_MORE_OLD);
        pause(exchange);
        result = SRV_INFLIGHT_WAIT;
    }
    assert(events_valid(events));
    pthread_mutex_unlock(&events->lock);
    return result;
}

void srv_events_leave(struct srv_exchange *exchange, enum srv_stop why) {
    struct srv_events *events = exchange->service->events;
    pthread_mutex_lock(&events->lock);
    assert(events_valid(events));
    struct srv_listener *listener = exchange->listener;
    if (listener && listener->until) {
        if (why != SRV_STOP_SHUTDOWN) exchange->close = 1;
        listener_answer(events, listener);
    } else if (listener && why == SRV_STOP_SHUTDOWN) {
        listener->over = 1;
        listener_wake(listener);
    } else if (listener) {
        if (!exchange->stop) exchange->stop = (int)why;
        exchange->listener = NULL;
        listener_wake(listener);
        listener_free(events, listener);
    }
    assert(events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

void srv_events_news(struct srv_events *events) {
    if (!events) return;
    pthread_mutex_lock(&events->lock);
    assert(events_valid(events));
    events->news = 1;
    if (events->count) pthread_cond_signal(&events->some);
    assert(events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

/* Wakes the streams that have an event, and answers the exchanges whose wait is over. The caller
 * holds the lock. */
static void events_wake(struct srv_events *events) {
    int64_t now = srv_clock_now();
    struct srv_list *next;
    for (struct srv_list *link = events->listeners.next; link && link != &events->listeners;
         link = next) {
        struct srv_listener *at = listener_of_link(link);
        next = link->next;
        if (now >= at->beat_at) at->beat = 1;
        listener_count(at);
        if (at->until) {
            if (at->over || now >= at->until || at->topic->news(at)) listener_answer(events, at);
        } else if (at->over || at->beat || at->topic->news(at)) {
            listener_wake(at);
        }
    }
}

void srv_events_drain(struct srv_events *events) {
    if (!events) return;
    pthread_mutex_lock(&events->lock);
    assert(events_valid(events));
    events->draining = 1;
    SRV_LIST_EACH (link, &events->listeners)
        listener_of_link(link)->over |= !listener_of_link(link)->media_type;
    events_wake(events);
    assert(events_valid(events));
    pthread_mutex_unlock(&events->lock);
}

/* --- the polling thread --- */

/* The thread's next task. */
enum events_task { EVENTS_END, EVENTS_MORE, EVENTS_DUE };

/* Waits for the next task: a query for changes when it is due, before that the pending work of
 * topics. The caller holds the lock. */
static enum events_task events_wait(struct srv_events *events, int64_t asked) {
    int64_t look = asked + (int64_t)EVENTS_LOOK_MS * 1000000,
            least = asked + (int64_t)EVENTS_LEAST_MS * 1000000;
    while (!events->over) {
        int64_t now = srv_clock_now(), until = events->news ? least : look;
        if (!events->count) {
            srv_condition_wait(&events->some, &events->lock, SRV_CONDITION_NEVER);
            /* a new stream has just received the state, so the next query can wait */
            look = srv_clock_now() + (int64_t)EVENTS_LEAST_MS * 1000000;
        } else if (now >= until) {
            return EVENTS_DUE;
        } else if (events->more == SRV_MORE_NEW || (events->more && now >= events->rested)) {
            return EVENTS_MORE;
        } else {
            if (events->more && events->rested < until) until = events->rested;
            srv_condition_wait(&events->some, &events->lock, until);
        }
    }
    return EVENTS_END;
}

/* Runs one query of a topic. The caller holds the lock, which is released during the query. */
static void events_look(struct srv_events *events, struct srv_topic *topic, int due) {
    if (events->over || !topic->gather(topic, &events->listeners, due)) return;
    pthread_mutex_unlock(&events->lock);
    srv_storage_wait(events->service->storage, SRV_ASK_READ, &topic->ask);
    if (topic->work) topic->work(topic);
    pthread_mutex_lock(&events->lock);
    events_more(events, topic->tell(topic, &events->listeners));
    events_wake(events);
}

static void *events_main(void *context) {
    struct srv_events *events = context;
    int64_t asked = 0;
    pthread_mutex_lock(&events->lock);
    for (enum events_task task; (task = events_wait(events, asked)) != EVENTS_END;) {
        int64_t begun = srv_clock_now();
        if (task == EVENTS_DUE) asked = begun;
        if (task == EVENTS_DUE) events->news = 0;
        events->more = SRV_MORE_NONE;
        for (int i = 0; i < events->topics; i++)
            events_look(events, events->topic[i], task == EVENTS_DUE);
        events_wake(events);
        int64_t now = srv_clock_now();
        events->rested = now + EVENTS_REST * (now - begun);
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
    return PEND_OK;
}

enum pend_status srv_events_add(struct srv_events *events, struct srv_topic *topic) {
    if (!topic) return PEND_NO_MEMORY;
    assert(!events->started && events->topics < EVENTS_TOPICS);
    events->topic[events->topics++] = topic;
    return PEND_OK;
}

struct srv_topic *srv_events_topic(const struct srv_events *events, int i) {
    assert(i >= 0 && i < events->topics);
    return events->topic[i];
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
    for (int i = 0; i < gone->topics; i++) gone->topic[i]->free(gone->topic[i]);
    pthread_cond_destroy(&gone->some);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}
