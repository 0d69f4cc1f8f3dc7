#include "server/jobs/jobs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/link/scene.h"
#include "server/base/clock.h"
#include "server/jobs/store_request.h"
#include "server/work/admission.h"

static_assert((int)API_SCENE_ID == (int)SRV_ID_BYTES, "the store has room for a scene's id");

enum { SCENES_HEAD = 512 };

static const char scenes_json[] = "application/json";

static const struct srv_store_request_words scenes_words = {"scenes",
                                                            "the same scene is stored once"};

/* --- answers --- */

static void scenes_refuse(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    switch (stored) {
    case SRV_STORED_NONE:
        srv_exchange_problem(exchange, 404, "there is no scene with this id");
        break;
    case SRV_STORED_QUOTA:
        srv_exchange_problem(exchange, 429, API_TYPE_QUOTA "%.200s", asked->job.message);
        srv_exchange_retry(exchange, 3600);
        break;
    default:
        srv_store_request_refuse(asked, stored);
        break;
    }
}

/* Answers with a scene, which is immutable. */
static void scenes_give(struct srv_exchange *exchange, int status, const char *id, const void *data,
                        size_t bytes) {
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
    if (!srv_exchange_safe(exchange) || !srv_exchange_matches(exchange, etag)) return;
    srv_metrics_count(&exchange->service->metrics.not_modified, 1);
    exchange->status = 304;
    exchange->media_type = NULL;
    exchange->bytes = 0;
}

/* --- storing --- */

static enum srv_stored scenes_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    free(asked->kept);
    asked->kept = NULL;
    return srv_store_scene(store, asked->id, &asked->kept, &asked->kept_bytes);
}

/* Stores a scene, or adds this client to the stored one. Another process may store the same scene
 * between the two steps. */
static enum srv_stored scenes_put(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    const struct srv_identity *who = &asked->exchange->identity;
    enum srv_stored stored = SRV_STORED_CLASH;
    for (int turn = 0; turn < 2 && stored == SRV_STORED_CLASH; turn++) {
        stored = srv_store_scene_keep(store, asked->id, who->key, who->source);
        if (stored == SRV_STORED) return scenes_find(store, call);
        if (stored == SRV_STORED_NONE)
            stored = srv_store_scene_put(store, asked->id, who->key, who->source, asked->scene.data,
                                         asked->scene.bytes);
    }
    if (stored == SRV_STORED_QUOTA)
        snprintf(asked->job.message, sizeof asked->job.message, "%s", srv_store_complaint(store));
    return stored;
}

static void scenes_kept(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    char *location = srv_exchange_text(exchange, 64);
    if (stored != SRV_STORED) {
        scenes_refuse(asked, stored);
    } else {
        if (asked->kept)
            scenes_give(exchange, 201, asked->id, asked->kept, asked->kept_bytes);
        else
            scenes_give(exchange, 201, asked->id, asked->scene.data, asked->scene.bytes);
        if (location && exchange->status == 201) {
            snprintf(location, 64, "/v1/scenes/%s", asked->id);
            srv_exchange_header(exchange, "Location", location);
        }
    }
    srv_store_request_end(asked);
}

/* Reads the scene. Returns 1 if it may be stored; else the exchange is answered. */
static int scenes_check(struct srv_store_request *asked) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_config *config = srv_service_config(exchange->service);
    struct srv_stamp now = {0};
    struct api_request request = {.query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    srv_clock_stamp(&now);
    api_buffer_init(&asked->scene, (size_t)config->scene_bytes + SCENES_HEAD);
    int http = api_scene_read(&request, &config->limits, config->scene_bytes, now.text, asked->id,
                              &asked->scene, &exchange->answer);
    if (http) srv_exchange_answered(exchange, http, "application/problem+json");
    return !http;
}

void srv_scenes_create(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &scenes_words);
    if (asked) srv_store_request_work(asked, scenes_check, scenes_put, scenes_kept);
}

/* --- reading --- */

static void scenes_found(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored == SRV_STORED)
        scenes_give(asked->exchange, 200, asked->id, asked->kept, asked->kept_bytes);
    else
        scenes_refuse(asked, stored);
    srv_store_request_end(asked);
}

void srv_scenes_read(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &scenes_words);
    if (!asked) return;
    if (srv_store_request_id_good(exchange->argument)) {
        memcpy(asked->id, exchange->argument, SRV_ID_BYTES);
        srv_store_request_ask(asked, SRV_ASK_READ, scenes_find, scenes_found);
        return;
    }
    scenes_refuse(asked, SRV_STORED_NONE);
    srv_store_request_end(asked);
}

/* --- deleting --- */

static enum srv_stored scenes_let_go(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    return srv_store_scene_drop(store, asked->id, asked->exchange->identity.key);
}

static void scenes_gone(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    if (stored == SRV_STORED)
        srv_exchange_static(exchange, 204, NULL, NULL, 0);
    else if (stored == SRV_STORED_CLASH)
        srv_exchange_problem(exchange, 403,
                             API_TYPE_OWNER
                             "you may not delete this scene: it was not stored with your token or "
                             "account, or you have deleted it already");
    else
        scenes_refuse(asked, stored);
    srv_store_request_end(asked);
}

void srv_scenes_drop(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &scenes_words);
    if (!asked) return;
    if (exchange->identity.kind == SRV_IDENTITY_ADDRESS) {
        srv_admission_challenge(exchange, "only the token that stored a scene can delete it");
    } else if (srv_store_request_id_good(exchange->argument)) {
        memcpy(asked->id, exchange->argument, SRV_ID_BYTES);
        srv_store_request_ask(asked, SRV_ASK_WRITE, scenes_let_go, scenes_gone);
        return;
    } else {
        scenes_refuse(asked, SRV_STORED_NONE);
    }
    srv_store_request_end(asked);
}
