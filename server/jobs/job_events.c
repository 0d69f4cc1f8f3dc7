#include "server/jobs/job_events.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"

const char *srv_job_word(enum srv_job_state state) {
    static const char *const word[SRV_JOB_STATES] = {"accepted", "running", "successful", "failed",
                                                     "dismissed"};
    /* a state from the store may be out of range: then the job counts as failed */
    return state >= 0 && state < SRV_JOB_STATES ? word[state] : "failed";
}

/* Seconds until the job is done, extrapolated from its completed parts; running parts count half.
 * -1 = unknown. */
static double job_remaining(const struct srv_job *job) {
    if (job->state != SRV_JOB_RUNNING || !job->done || !job->started) return -1;
    double done = 0.5 * (double)(job->done + job->begun - job->waiting);
    return 1e-6 * (double)(job->now - job->started) / done * ((double)job->parts - done);
}

struct api_job srv_job_view(const struct srv_job *job) {
    return (struct api_job){.id = job->id,
                            .operation = job->operation,
                            .status = srv_job_word(job->state),
                            .message = job->message,
                            .title = job->title,
                            .version = job->version,
                            .owner = srv_identity_word(job->client),
                            .parts = job->parts,
                            .done = job->done,
                            .created = job->created,
                            .started = job->started,
                            .finished = job->finished,
                            .expires = job->expires,
                            .bytes = job->bytes,
                            .remaining = job_remaining(job),
                            .request = job->state <= SRV_JOB_SUCCESSFUL,
                            .results = job->state == SRV_JOB_SUCCESSFUL};
}

int srv_job_over(const struct srv_job *job) { return job->state > SRV_JOB_RUNNING; }

struct job_listener {
    struct srv_listener listener;
    struct srv_job job;      /* the job as last read */
    char told[SRV_EVENT_ID]; /* id of the last event sent; "" = none */
    int gone;                /* the job no longer exists */
    void (*answer)(struct srv_exchange *exchange, const struct srv_job *job);
};

struct job_topic {
    struct srv_topic topic;
    int count;
    struct srv_job *job; /* ids on entry, states on return */
    enum srv_stored *stored;
};

void srv_job_events_id(const struct srv_job *job, char id[SRV_EVENT_ID]) {
    snprintf(id, SRV_EVENT_ID, "%s-%ld", srv_job_word(job->state), job->done);
}

/* --- one stream --- */

static struct job_listener *job_listener(const struct srv_listener *listener) {
    return SRV_CONTAINER_OF(listener, struct job_listener, listener);
}

static int job_news(const struct srv_listener *listener) {
    const struct job_listener *own = job_listener(listener);
    char id[SRV_EVENT_ID];
    if (listener->until) return srv_job_over(&own->job);
    srv_job_events_id(&own->job, id);
    return strcmp(id, own->told) != 0;
}

static void job_answer(struct srv_listener *listener) {
    struct job_listener *own = job_listener(listener);
    own->answer(listener->exchange, own->gone ? NULL : &own->job);
}

static enum pend_status job_next(struct srv_listener *listener) {
    struct job_listener *own = job_listener(listener);
    struct api_buffer json, *text = &listener->text;
    struct api_job view = srv_job_view(&own->job);
    api_buffer_init(&json, SRV_EVENTS_TEXT);
    srv_job_events_id(&own->job, own->told);
    enum pend_status status = api_job_write(&view, &json);
    if (status == PEND_OK)
        status = api_buffer_format(text, "event: progress\nid: %s\ndata: ", own->told);
    if (status == PEND_OK) status = api_buffer_add(text, json.data, json.bytes);
    if (status == PEND_OK) status = api_buffer_text(text, "\n\n");
    api_buffer_clear(&json);
    listener->over |= srv_job_over(&own->job);
    return status;
}

static void job_drop(struct srv_listener *listener) { free(job_listener(listener)); }

/* Creates a listener of a job; if memory is short, answers the exchange and returns NULL. */
static struct job_listener *job_listen(struct srv_exchange *exchange, const struct srv_job *job) {
    assert(exchange->service->events && *job->id);
    struct job_listener *made = calloc(1, sizeof *made);
    if (!made) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return NULL;
    }
    made->job = *job;
    made->listener.exchange = exchange;
    made->listener.topic = srv_events_topic(exchange->service->events, 0);
    return made;
}

void srv_job_events_open(struct srv_exchange *exchange, const struct srv_job *job,
                         const char *last) {
    struct job_listener *made = job_listen(exchange, job);
    if (!made) return;
    if (last) snprintf(made->told, sizeof made->told, "%s", last);
    srv_events_open(exchange->service->events, &made->listener);
}

int srv_job_events_await(struct srv_exchange *exchange, const struct srv_job *job, int seconds,
                         void (*answer)(struct srv_exchange *exchange, const struct srv_job *job)) {
    assert(seconds > 0 && seconds <= SRV_JOB_WAIT_S && !srv_job_over(job));
    struct job_listener *made = job_listen(exchange, job);
    if (!made) return 0;
    made->answer = answer;
    made->listener.until = srv_clock_now() + srv_clock_span(seconds);
    return srv_events_await(exchange->service->events, &made->listener);
}

static enum srv_stored look_run(struct srv_store *store, struct srv_store_call *call) {
    struct job_topic *look = SRV_CONTAINER_OF(call, struct job_topic, topic.ask.call);
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < look->count; i++) {
        char id[SRV_ID_BYTES];
        memcpy(id, look->job[i].id, sizeof id);
        /* if the store is unreachable, stop at the first job */
        if (stored < SRV_STORED_AWAY) stored = srv_store_job(store, id, &look->job[i]);
        look->stored[i] = stored;
        memcpy(look->job[i].id, id, sizeof id);
    }
    return stored < SRV_STORED_AWAY ? SRV_STORED : stored;
}

static int look_find(const struct job_topic *look, const char *id) {
    int i = 0;
    while (i < look->count && strcmp(look->job[i].id, id) != 0) i++;
    return i;
}

static int look_gather(struct srv_topic *topic, struct srv_list *listeners, int due) {
    struct job_topic *look = SRV_CONTAINER_OF(topic, struct job_topic, topic);
    look->count = 0;
    if (!due) return 0;
    SRV_LIST_EACH (link, listeners) {
        const struct srv_listener *at = SRV_CONTAINER_OF(link, struct srv_listener, link);
        if (at->topic != topic || at->over) continue;
        const struct srv_job *job = &job_listener(at)->job;
        if (look_find(look, job->id) == look->count)
            memcpy(look->job[look->count++].id, job->id, SRV_ID_BYTES);
    }
    return look->count;
}

static enum srv_more look_tell(struct srv_topic *topic, struct srv_list *listeners) {
    const struct job_topic *look = SRV_CONTAINER_OF(topic, struct job_topic, topic);
    SRV_LIST_EACH (link, listeners) {
        struct srv_listener *at = SRV_CONTAINER_OF(link, struct srv_listener, link);
        if (at->topic != topic) continue;
        struct srv_job *job = &job_listener(at)->job;
        int i = look_find(look, job->id), found = i < look->count;
        if (found && look->stored[i] == SRV_STORED) *job = look->job[i];
        /* the job no longer exists; a client that reconnects gets 404 */
        if (found && look->stored[i] == SRV_STORED_NONE) at->over = job_listener(at)->gone = 1;
    }
    return SRV_MORE_NONE;
}

static void look_free(struct srv_topic *topic) {
    struct job_topic *gone = SRV_CONTAINER_OF(topic, struct job_topic, topic);
    free(gone->job);
    free(gone->stored);
    free(gone);
}

struct srv_topic *srv_job_events_new(int most) {
    struct job_topic *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    made->topic = (struct srv_topic){.ask = {.call = {.run = look_run}},
                                     .news = job_news,
                                     .next = job_next,
                                     .answer = job_answer,
                                     .gather = look_gather,
                                     .tell = look_tell,
                                     .drop = job_drop,
                                     .free = look_free};
    made->job = calloc((size_t)most, sizeof *made->job);
    made->stored = calloc((size_t)most, sizeof *made->stored);
    if (made->job && made->stored) return &made->topic;
    look_free(&made->topic);
    return NULL;
}
