#include "server/http/assets.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/openapi.h"
#include "server/classes/class_request.h"

/* what a document may load: this server's own, the engine (WebAssembly) among it; who may frame it
 * stands behind */
#define ASSETS_POLICY                                                                              \
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "                 \
    "img-src 'self' data: blob:; "                                                                 \
    "font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors "

static const char assets_alone[] = ASSETS_POLICY "'none'";

static const char assets_for_ever[] = "public, max-age=31536000, immutable";

static int assets_order(const void *name, const void *asset) {
    return strcmp(name, ((const struct srv_asset *)asset)->path);
}

static const struct srv_asset *assets_find(const char *path) {
    return bsearch(path, srv_assets_table, (size_t)srv_assets_count, sizeof *srv_assets_table,
                   assets_order);
}

static int assets_is_document(const struct srv_asset *asset) {
    return !strncmp(asset->media_type, "text/html", 9);
}

static void assets_give(struct srv_exchange *exchange, const struct srv_asset *asset,
                        const char *keep, const char *policy) {
    assert(asset->plain && asset->media_type && asset->etag);
    int packed =
        asset->packed && srv_coding_accepts(exchange->field[SRV_ACCEPT_ENCODING], SRV_GZIP);
    if (srv_exchange_matches(exchange, asset->etag)) {
        srv_exchange_static(exchange, 304, NULL, NULL, 0);
        srv_metrics_count(&exchange->service->metrics.not_modified, 1);
    } else if (packed) {
        srv_exchange_static(exchange, 200, asset->media_type, asset->packed, asset->packed_bytes);
        srv_exchange_header(exchange, "Content-Encoding", "gzip");
    } else {
        srv_exchange_static(exchange, 200, asset->media_type, asset->plain, asset->plain_bytes);
    }
    srv_exchange_header(exchange, "Cache-Control", keep);
    srv_exchange_header(exchange, "ETag", asset->etag);
    srv_exchange_header(exchange, "Vary", "Accept-Encoding");
    srv_exchange_header(exchange, "Referrer-Policy", "no-referrer");
    srv_exchange_header(exchange, "Content-Security-Policy", policy);
}

/* Documents are requested at every visit: they name the digest under which every other file is
 * found. */
static void assets_document(struct srv_exchange *exchange, const char *name, const char *policy) {
    const struct srv_asset *asset = assets_find(name);
    if (asset)
        assets_give(exchange, asset, "no-cache", policy);
    else
        srv_exchange_problem(exchange, 404, "this server was built without %s", name);
}

/* is the view asked for that may be in a frame: has the query embed=1? */
static int assets_embeds(const char *query) {
    for (const char *part = query; part; part = strchr(part, '&')) {
        if (*part == '&') part++;
        size_t bytes = strcspn(part, "&");
        if (bytes == 7 && !strncmp(part, "embed=1", 7)) return 1;
    }
    return 0;
}

/* the policy of the embed view: whom frame-ancestors lists may have it in a frame */
static const char *assets_framed(struct srv_exchange *exchange) {
    const char *list = srv_service_config(exchange->service)->frame_ancestors;
    size_t bytes = sizeof ASSETS_POLICY + strlen(list);
    char *policy = strcmp(list, "none") ? srv_exchange_text(exchange, bytes) : NULL;
    if (!policy) return assets_alone;
    snprintf(policy, bytes, "%s%s", ASSETS_POLICY, list);
    for (char *comma = policy; (comma = strchr(comma, ','));) *comma = ' ';
    return policy;
}

void srv_assets_index(struct srv_exchange *exchange) {
    int embeds = assets_embeds(exchange->query);
    assets_document(exchange, "index.html", embeds ? assets_framed(exchange) : assets_alone);
}

void srv_assets_room(struct srv_exchange *exchange) {
    static const char page[] = "/?room=";
    char *location = srv_exchange_text(exchange, sizeof page + SRV_CLASS_CODE);
    if (!location) return;
    strcpy(location, page);
    int code = srv_class_request_read_code(exchange->argument, location + sizeof page - 1);
    assert(code);
    (void)code;
    srv_exchange_static(exchange, 302, NULL, NULL, 0);
    srv_exchange_header(exchange, "Location", location);
    srv_exchange_header(exchange, "Cache-Control", "no-cache");
}

void srv_assets_docs(struct srv_exchange *exchange) {
    assets_document(exchange, "docs.html", assets_alone);
}

void srv_assets_description(struct srv_exchange *exchange) {
    const struct srv_asset description = {.path = "openapi.json",
                                          .media_type = "application/json",
                                          .etag = api_openapi_etag,
                                          .plain = api_openapi_json,
                                          .plain_bytes = api_openapi_bytes,
                                          .packed = api_openapi_packed,
                                          .packed_bytes = api_openapi_packed_bytes};
    assets_give(exchange, &description, "no-cache", assets_alone);
}

void srv_assets_file(struct srv_exchange *exchange) {
    assert(exchange->argument);
    size_t digest = strlen(srv_assets_digest);
    const char *name = exchange->argument;
    int ours = !strncmp(name, srv_assets_digest, digest) && name[digest] == '/';
    const struct srv_asset *asset = ours ? assets_find(name + digest + 1) : NULL;
    if (asset && !assets_is_document(asset))
        assets_give(exchange, asset, assets_for_ever, assets_alone);
    else
        srv_exchange_problem(exchange, 404, "the page of this server has no file %.200s",
                             exchange->path);
}
