#include "server/cors.h"

#include <string.h>

const char srv_cors_expose[] = "Accept-Ranges, Content-Disposition, Content-Range, ETag, Location, Preference-Applied, "
                               "RateLimit-Limit, RateLimit-Remaining, "
                               "RateLimit-Reset, Retry-After, X-Columns, X-Request-Id";

int srv_cors_varies(const char *allowed) { return strcmp(allowed, "*") && strcmp(allowed, "none"); }

const char *srv_cors_origin(const char *allowed, const char *origin) {
    if (!strcmp(allowed, "*")) return allowed;
    if (!origin || !*origin || !srv_cors_varies(allowed)) return NULL;
    size_t bytes = strlen(origin);
    for (const char *at = allowed; *at; at += strcspn(at, ","), at += *at == ',') {
        at += strspn(at, " \t");
        size_t length = strcspn(at, ", \t");
        if (length == bytes && !memcmp(at, origin, bytes)) return origin;
    }
    return NULL;
}
