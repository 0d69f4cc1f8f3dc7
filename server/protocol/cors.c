#include "server/protocol/cors.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

const char srv_cors_expose[] =
    "Accept-Ranges, Content-Disposition, Content-Range, Deprecation, ETag, Idempotency-Replayed, "
    "Link, Location, Preference-Applied, RateLimit, RateLimit-Limit, RateLimit-Policy, "
    "RateLimit-Remaining, RateLimit-Reset, Retry-After, Sunset, WWW-Authenticate, X-Columns, "
    "X-Energy-Drift, X-Horizon, X-Request-Id, X-Trust-Until, X-Warning";

const char srv_cors_fields[] =
    "Accept, Authorization, Class-Token, Content-Type, Idempotency-Key, If-None-Match, If-Range, "
    "Job-Title, Last-Event-ID, Prefer, Range, Traceparent, X-Request-Id";

static int cors_lists(const char *list, const char *entry) {
    size_t bytes = strlen(entry);
    for (const char *at = list; *at; at += strcspn(at, ","), at += *at == ',') {
        at += strspn(at, " \t");
        size_t length = strcspn(at, ", \t");
        if (length == bytes && !memcmp(at, entry, bytes)) return 1;
    }
    return 0;
}

int srv_cors_varies(const char *allowed) { return strcmp(allowed, "*") && strcmp(allowed, "none"); }

const char *srv_cors_origin(const char *allowed, const char *origin, int closed) {
    int listed = origin && *origin && strcmp(origin, "*") && strcmp(origin, "none") &&
                 cors_lists(allowed, origin);
    if (!closed && cors_lists(allowed, "*")) return "*";
    return listed ? origin : NULL;
}

/* true if the origin has this host. The scheme is not compared: a proxy may terminate TLS, and may
 * have removed the port. */
static int cors_same(const char *origin, const char *host) {
    const char *at = strstr(origin, "://");
    if (!at || !host) return 0;
    at += 3;
    size_t bytes = strlen(host);
    if (strncasecmp(at, host, bytes)) return 0;
    const char *colon = strrchr(host, ':');
    int ported = colon && !strchr(colon, ']');
    return !at[bytes] || (!ported && at[bytes] == ':');
}

int srv_cors_foreign(const char *allowed, const char *origin, const char *site, const char *host) {
    if (!origin || srv_cors_origin(allowed, origin, 1)) return 0;
    if (site) return strcmp(site, "same-origin") != 0 && strcmp(site, "none") != 0;
    return !cors_same(origin, host);
}
