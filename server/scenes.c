#include "server/scenes.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/scene.h"
#include "server/admission.h"
#include "server/clock.h"

_Static_assert((int)API_SCENE_ID == (int)SRV_ID_BYTES, "the store has room for a scene's id");

enum { SCENES_HEAD = 512, SCENES_LONG_BODY = 1 << 18 };

static const char scenes_json[] = "application/json";

/* An exchange on its way to the store and back. */
struct scenes_errand {
    struct srv_ask ask; /* first: an ask is its errand */
    struct srv_task task;
    struct srv_exchange *exchange;
    char id[SRV_ID_BYTES];
    struct api_buffer scene; /* that is to be kept */
    void *kept;              /* the one that the store has */
    size_t kept_bytes;
};

/* --- an errand's life --- */

/* the exchange is answered and goes home */
static void scenes_end(struct scenes_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct srv_service *service = exchange->service;
    api_buffer_clear(&errand->scene);
    free(errand->kept);
    free(errand);
    exchange->finish(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

/* an errand for an exchange; NULL, with the exchange answered and gone, where that cannot be */
static struct scenes_errand *scenes_begin(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    struct scenes_errand *errand = service->storage ? calloc(1, sizeof *errand) : NULL;
    if (errand) {
        errand->exchange = exchange;
        api_buffer_init(&errand->scene, (size_t)service->config.scene_bytes + SCENES_HEAD);
        atomic_fetch_add(&service->computing, 1);
        return errand;
    }
    if (service->storage)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_problem(exchange, 404, "this server keeps no scenes: its option --store is none");
    exchange->finish(exchange);
    return NULL;
}

/* --- answers --- */

/* what went wrong in the store */
static void scenes_refuse(struct srv_exchange *exchange, enum srv_stored stored) {
    switch (stored) {
    case SRV_STORED_NONE:
        srv_exchange_problem(exchange, 404, "there is no scene of this id");
        break;
    case SRV_STORED_QUOTA:
        srv_exchange_problem(exchange, 429, "the client has max-client-scenes, %.0f, scenes, which are kept for ever",
                             exchange->service->config.client_scenes);
        srv_exchange_retry(exchange, 3600);
        break;
    case SRV_STORED_FULL:
        srv_exchange_busy(exchange, 60, "the store's disk is full");
        break;
    case SRV_STORED_AGAIN:
        srv_exchange_busy(exchange, 1, "the store is busy; nothing was changed");
        break;
    default:
        srv_exchange_busy(exchange, 2, "the store is out of reach; the same scene again is kept once");
        break;
    }
}

/* answers with a scene; its bytes are those that were kept, for ever */
static void scenes_give(struct srv_exchange *exchange, int status, const char *id, const void *data, size_t bytes) {
    if (api_buffer_add(&exchange->answer, data, bytes) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, status, scenes_json);
    char *etag = srv_exchange_text(exchange, SRV_ID_BYTES + 2);
    if (!etag) return;
    snprintf(etag, SRV_ID_BYTES + 2, "\"%s\"", id);
    srv_exchange_header(exchange, "ETag", etag);
    if (status != 200) return;
    srv_exchange_header(exchange, "Cache-Control", "public, max-age=31536000, immutable");
    if (!srv_exchange_matches(exchange, etag)) return;
    srv_metrics_count(&exchange->service->metrics.not_modified, 1);
    exchange->status = 304;
    exchange->media_type = NULL;
    exchange->bytes = 0;
}

/* --- keeping one --- */

/* the scene that is there already, else the new one; between the two another process may keep the same */
static enum srv_stored scenes_put(struct srv_store *store, struct srv_store_call *call) {
    struct scenes_errand *errand = (struct scenes_errand *)call;
    free(errand->kept);
    errand->kept = NULL;
    enum srv_stored stored = srv_store_scene(store, errand->id, &errand->kept, &errand->kept_bytes);
    if (stored != SRV_STORED_NONE) return stored;
    stored =
        srv_store_scene_put(store, errand->id, errand->exchange->account->key, errand->scene.data, errand->scene.bytes);
    if (stored != SRV_STORED_CLASH) return stored;
    return srv_store_scene(store, errand->id, &errand->kept, &errand->kept_bytes);
}

static void scenes_kept(struct srv_ask *ask) {
    struct scenes_errand *errand = (struct scenes_errand *)ask;
    struct srv_exchange *exchange = errand->exchange;
    char *location = srv_exchange_text(exchange, 64);
    if (ask->call.stored != SRV_STORED) {
        scenes_refuse(exchange, ask->call.stored);
    } else {
        if (errand->kept)
            scenes_give(exchange, 201, errand->id, errand->kept, errand->kept_bytes);
        else
            scenes_give(exchange, 201, errand->id, errand->scene.data, errand->scene.bytes);
        if (location && exchange->status == 201) {
            snprintf(location, 64, "/v1/scenes/%s", errand->id);
            srv_exchange_header(exchange, "Location", location);
        }
    }
    scenes_end(errand);
}

/* reads the scene; returns 1 when it may be kept, else the exchange is answered */
static int scenes_check(struct scenes_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    const struct srv_config *config = &exchange->service->config;
    struct srv_stamp now = {0};
    struct api_request request = {.query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    srv_clock_stamp(&now);
    int http = api_scene_read(&request, &config->limits, config->scene_bytes, now.text, errand->id, &errand->scene,
                              &exchange->answer);
    if (http) srv_exchange_answered(exchange, http, "application/problem+json");
    return !http;
}

static void scenes_run(struct srv_task *task) {
    struct scenes_errand *errand = (struct scenes_errand *)((char *)task - offsetof(struct scenes_errand, task));
    struct srv_exchange *exchange = errand->exchange;
    struct srv_service *service = exchange->service;
    int64_t begin = srv_clock_now();
    exchange->waited = begin - exchange->queued;
    atomic_fetch_add(&service->busy, 1);
    int good = scenes_check(errand);
    exchange->computed = srv_clock_now() - begin;
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)exchange->computed);
    if (!good) {
        scenes_end(errand);
        return;
    }
    errand->ask.call.run = scenes_put;
    errand->ask.done = scenes_kept;
    srv_storage_ask(service->storage, SRV_ASK_WRITE, &errand->ask);
}

/* there is no room in the queue */
static void scenes_crowded(struct srv_exchange *exchange, enum pend_status status) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    if (status == PEND_LIMIT) {
        srv_metrics_count(&metrics->refused_queue, 1);
        srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
        return;
    }
    srv_metrics_count(&metrics->refused_client, 1);
    srv_exchange_problem(exchange, 429, "%.0f requests of yours wait for a worker: max-client-queue",
                         exchange->service->config.client_queue);
    srv_exchange_retry(exchange, 1);
}

void srv_scenes_create(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    struct scenes_errand *errand = scenes_begin(exchange);
    if (!errand) return;
    if (atomic_load(&service->draining)) {
        srv_exchange_busy(exchange, 5, "the server is draining");
        scenes_end(errand);
        return;
    }
    if (!srv_admission_count(exchange)) {
        scenes_end(errand);
        return;
    }
    exchange->queued = srv_clock_now();
    errand->task = (struct srv_task){
        .run = scenes_run, .lane = &exchange->account->lane, .level = exchange->body.bytes > SCENES_LONG_BODY};
    enum pend_status status = srv_queue_push(service->queue, &errand->task);
    if (status == PEND_OK) return;
    scenes_crowded(exchange, status);
    scenes_end(errand);
}

/* --- reading one --- */

static enum srv_stored scenes_find(struct srv_store *store, struct srv_store_call *call) {
    struct scenes_errand *errand = (struct scenes_errand *)call;
    free(errand->kept);
    errand->kept = NULL;
    return srv_store_scene(store, errand->id, &errand->kept, &errand->kept_bytes);
}

static void scenes_found(struct srv_ask *ask) {
    struct scenes_errand *errand = (struct scenes_errand *)ask;
    if (ask->call.stored == SRV_STORED)
        scenes_give(errand->exchange, 200, errand->id, errand->kept, errand->kept_bytes);
    else
        scenes_refuse(errand->exchange, ask->call.stored);
    scenes_end(errand);
}

void srv_scenes_read(struct srv_exchange *exchange) {
    static const char letters[] = "0123456789abcdefghjkmnpqrstvwxyz";
    struct scenes_errand *errand = scenes_begin(exchange);
    if (!errand) return;
    if (strlen(exchange->argument) != SRV_ID_BYTES - 1 || strspn(exchange->argument, letters) != SRV_ID_BYTES - 1) {
        scenes_refuse(exchange, SRV_STORED_NONE);
        scenes_end(errand);
        return;
    }
    memcpy(errand->id, exchange->argument, SRV_ID_BYTES);
    errand->ask.call.run = scenes_find;
    errand->ask.done = scenes_found;
    srv_storage_ask(exchange->service->storage, SRV_ASK_READ, &errand->ask);
}
