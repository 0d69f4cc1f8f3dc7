#include "server/http/assets.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/openapi.h"

/* The content security policy: a document may load from this server only, and nobody may frame it.
 */
static const char assets_policy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src "
    "'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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
                        const char *keep) {
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
    srv_exchange_header(exchange, "Content-Security-Policy", assets_policy);
}

/* Documents are requested at every visit: they name the digest under which every other file is
 * found. */
static void assets_document(struct srv_exchange *exchange, const char *name) {
    const struct srv_asset *asset = assets_find(name);
    if (asset)
        assets_give(exchange, asset, "no-cache");
    else
        srv_exchange_problem(exchange, 404, "this server was built without %s", name);
}

void srv_assets_index(struct srv_exchange *exchange) { assets_document(exchange, "index.html"); }

void srv_assets_docs(struct srv_exchange *exchange) { assets_document(exchange, "docs.html"); }

void srv_assets_description(struct srv_exchange *exchange) {
    const struct srv_asset description = {.path = "openapi.json",
                                          .media_type = "application/json",
                                          .etag = api_openapi_etag,
                                          .plain = api_openapi_json,
                                          .plain_bytes = api_openapi_bytes,
                                          .packed = api_openapi_packed,
                                          .packed_bytes = api_openapi_packed_bytes};
    assets_give(exchange, &description, "no-cache");
}

void srv_assets_file(struct srv_exchange *exchange) {
    assert(exchange->argument);
    size_t digest = strlen(srv_assets_digest);
    const char *name = exchange->argument;
    int ours = !strncmp(name, srv_assets_digest, digest) && name[digest] == '/';
    const struct srv_asset *asset = ours ? assets_find(name + digest + 1) : NULL;
    if (asset && !assets_is_document(asset))
        assets_give(exchange, asset, assets_for_ever);
    else
        srv_exchange_problem(exchange, 404, "the page of this server has no file %.200s",
                             exchange->path);
}
