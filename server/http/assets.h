/* The page's files and the API's description, compiled in: the routes /, /docs, /sw.js,
 * /page/DIGEST/FILE, /openapi.json and /openapi-3.0.json; and /oembed, for embedding the page
 * elsewhere.
 * Leaves to others: the files themselves (web/), making them C (assets_embed.py), reading a link
 * (api/link/oembed).
 * Invariant: files under /page/DIGEST never change, so a browser may cache them for ever. */
#pragma once

#include "server/work/exchange.h"

/* A file. */
struct srv_asset {
    const char *path; /* under /page/DIGEST/, or an HTML document's name */
    const char *media_type;
    const char *etag;
    const char *plain;
    size_t plain_bytes;
    const char *packed; /* gzip-compressed; NULL if that is not shorter */
    size_t packed_bytes;
};

/* Made by assets_embed.py: sorted by path. */
extern const struct srv_asset srv_assets_table[];
extern const int srv_assets_count;
extern const char srv_assets_digest[]; /* of all files, 16 hexadecimal digits */
extern const char srv_assets_policy[]; /* the Content-Security-Policy of documents, up to
                                        * frame-ancestors */

/** GET /: the page. Its embed view, /?embed=1, may be framed by the origins of frame-ancestors;
 * other views may not be framed. The head of a valid link's document refers to /oembed. */
void srv_assets_index(struct srv_exchange *exchange);

/** GET /{room}: 302 to the page in the class room of this code, /?room=CODE, whether it exists or
 * not; short enough for a blackboard. */
void srv_assets_room(struct srv_exchange *exchange);

/** GET /oembed: the description for embedding a link to the page; 404 if frame-ancestors is
 * empty. */
void srv_assets_oembed(struct srv_exchange *exchange);

/** GET /docs: the API's reference page. */
void srv_assets_docs(struct srv_exchange *exchange);

/** GET /sw.js: the page's service worker, which caches the page in the browser. To remove it, let a
 * proxy answer 404 here. */
void srv_assets_worker(struct srv_exchange *exchange);

/** GET /openapi.json and /openapi-3.0.json; with ?tag=jobs,scenes only the operations of these
 * tags. 422 for any other query. */
void srv_assets_description(struct srv_exchange *exchange);

/** GET /page/{digest}/{file}: scripts, styles and fonts of both. 404 for another build's digest. */
void srv_assets_file(struct srv_exchange *exchange);
