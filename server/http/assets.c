#include "server/http/assets.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/openapi.h"
#include "api/link/oembed.h"
#include "server/classes/class_request.h"

static const char assets_for_ever[] = "public, max-age=31536000, immutable";

static int assets_order(const void *name, const void *asset) {
    return strcmp(name, ((const struct srv_asset *)asset)->path);
}

static const struct srv_asset *assets_find(const char *path) {
    return bsearch(path, srv_assets_table, (size_t)srv_assets_count, sizeof *srv_assets_table,
                   assets_order);
}

/* Returns the Content-Security-Policy of a document (srv_assets_policy) with the origins that may
 * frame it: a list separated by commas, or NULL for none. If memory is short, returns a policy that
 * allows nothing. */
static const char *assets_policy(struct srv_exchange *exchange, const char *list) {
    const char *frames = list && strcmp(list, "none") ? list : "'none'";
    size_t bytes = strlen(srv_assets_policy) + strlen(frames) + 1;
    char *policy = srv_exchange_text(exchange, bytes);
    if (!policy) return "default-src 'none'; frame-ancestors 'none'";
    snprintf(policy, bytes, "%s%s", srv_assets_policy, frames);
    for (char *comma = policy; (comma = strchr(comma, ','));) *comma = ' ';
    return policy;
}

static void assets_fields(struct srv_exchange *exchange, const char *keep, const char *policy) {
    srv_exchange_header(exchange, "Cache-Control", keep);
    srv_exchange_header(exchange, "Referrer-Policy", "no-referrer");
    srv_exchange_header(exchange, "Content-Security-Policy", policy);
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
    assets_fields(exchange, keep, policy);
    srv_exchange_header(exchange, "ETag", asset->etag);
    srv_exchange_header(exchange, "Vary", "Accept-Encoding");
}

/* Documents and the service worker are requested at every visit, because they contain the digest in
 * the paths of all other files. */
static void assets_document(struct srv_exchange *exchange, const char *name, const char *policy) {
    const struct srv_asset *asset = assets_find(name);
    if (asset)
        assets_give(exchange, asset, "no-cache", policy);
    else
        srv_exchange_problem(exchange, 404, "this server was built without %s", name);
}

/* true if the query contains embed=1: the view that may be in a frame */
static int assets_embeds(const char *query) {
    for (const char *part = query; part; part = strchr(part, '&')) {
        part += *part == '&';
        if (!strncmp(part, "embed=1", 7) && strchr("&", part[7])) return 1;
    }
    return 0;
}

/* Returns the scheme of the client's request, "http" or "https": that of this server's sockets, or
 * that reported by a trusted proxy. */
static const char *assets_scheme(const struct srv_exchange *exchange) {
    const struct srv_service *service = exchange->service;
    const char *said = exchange->field[SRV_SCHEME];
    if (!said || !srv_peer_trusted(srv_service_trusted(service), exchange->peer)) return "http";
    return strcmp(said, "https") ? "http" : "https";
}

/* Writes the page with a tag at the end of its head, which points to the oEmbed description of this
 * link. */
static enum pend_status assets_told(struct srv_exchange *exchange, const struct srv_asset *page) {
    const char *end = strstr(page->plain, "</head>");
    size_t head = end ? (size_t)(end - page->plain) : page->plain_bytes;
    PEND_TRY(api_buffer_add(&exchange->answer, page->plain, head));
    PEND_TRY(api_oembed_tag(assets_scheme(exchange), exchange->host, exchange->query,
                            &exchange->answer));
    return api_buffer_add(&exchange->answer, page->plain + head, page->plain_bytes - head);
}

static void assets_telling(struct srv_exchange *exchange) {
    const struct srv_asset *page = assets_find("index.html");
    assert(page);
    if (assets_told(exchange, page) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, 200, page->media_type);
    assets_fields(exchange, "no-cache", assets_policy(exchange, NULL));
}

void srv_assets_index(struct srv_exchange *exchange) {
    const char *list = srv_service_config(exchange->service)->frame_ancestors;
    int embeds = assets_embeds(exchange->query);
    if (!embeds && strcmp(list, "none") && api_oembed_tells(exchange->query))
        assets_telling(exchange);
    else
        assets_document(exchange, "index.html", assets_policy(exchange, embeds ? list : NULL));
}

/* Answers with the JSON that was written, or with its problem; frees the problem. */
static void assets_made(struct srv_exchange *exchange, enum pend_status status,
                        struct api_problem *problem) {
    if (status == PEND_INVALID)
        srv_exchange_problem(exchange, problem->status, "%s", problem->detail);
    else if (status != PEND_OK)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_answered(exchange, 200, "application/json");
    api_problem_clear(problem);
}

void srv_assets_oembed(struct srv_exchange *exchange) {
    const char *list = srv_service_config(exchange->service)->frame_ancestors;
    struct api_oembed wanted;
    struct api_problem problem;
    api_problem_init(&problem);
    enum pend_status status = api_oembed_read(exchange->query, exchange->host, &wanted, &problem);
    if (status == PEND_OK && !strcmp(list, "none")) {
        api_problem_set(&problem, 404,
                        "this server's page may not be embedded in other pages: see the option "
                        "--frame-ancestors");
        status = PEND_INVALID;
    }
    if (status == PEND_OK) status = api_oembed_write(&wanted, &exchange->answer);
    assets_made(exchange, status, &problem);
}

void srv_assets_room(struct srv_exchange *exchange) {
    /* A relative location, because a proxy may serve the page below another path. */
    static const char page[] = "./?room=";
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

void srv_assets_worker(struct srv_exchange *exchange) {
    assets_document(exchange, "sw.js", assets_policy(exchange, NULL));
    srv_exchange_header(exchange, "Service-Worker-Allowed", "/");
}

void srv_assets_docs(struct srv_exchange *exchange) {
    assets_document(exchange, "docs.html", assets_policy(exchange, NULL));
}

void srv_assets_description(struct srv_exchange *exchange) {
    const struct api_openapi *document = &api_openapi[!strcmp(exchange->path, "/openapi-3.0.json")];
    const struct srv_asset whole = {"openapi.json",        "application/json", document->etag,
                                    document->json,        document->bytes,    document->packed,
                                    document->packed_bytes};
    const char *query = exchange->query;
    struct api_problem problem;
    api_problem_init(&problem);
    if (query && *query)
        assets_made(exchange, api_openapi_write(document, query, &exchange->answer, &problem),
                    &problem);
    else
        assets_give(exchange, &whole, "no-cache", assets_policy(exchange, NULL));
}

void srv_assets_file(struct srv_exchange *exchange) {
    assert(exchange->argument);
    size_t digest = strlen(srv_assets_digest);
    const char *name = exchange->argument;
    int ours = !strncmp(name, srv_assets_digest, digest) && name[digest] == '/';
    const struct srv_asset *asset = ours ? assets_find(name + digest + 1) : NULL;
    // the paths of documents and of the service worker have no digest
    if (asset && strncmp(asset->media_type, "text/html", 9) && strcmp(asset->path, "sw.js"))
        assets_give(exchange, asset, assets_for_ever, assets_policy(exchange, NULL));
    else
        srv_exchange_problem(exchange, 404, "the page of this server has no file %.200s",
                             exchange->path);
}
