#include "api/call/openapi.h"

#include <string.h>
#include <strings.h>

enum pend_status api_openapi_write(const struct api_openapi *document, const char *query,
                                   struct api_buffer *out, struct api_problem *problem) {
    unsigned tags = 0;
    for (const char *at = query; *at; at += *at != 0) {
        if (at == query || at[-1] == '&') at += strncmp(at, "tag=", 4) ? 0 : 4;
        size_t bytes = strcspn(at, ",&%"), i = 0;
        for (const char *tag; (tag = api_openapi_tags[i]); i++)
            if (strlen(tag) == bytes && !memcmp(tag, at, bytes)) break;
        if (!api_openapi_tags[i]) {
            api_problem_set(problem, 422, "?tag= must be one or more of %s, got %.99s",
                            api_openapi_names, at);
            return PEND_INVALID;
        }
        tags |= 1u << i;
        at += bytes;
        if (!strncasecmp(at, "%2c", 3)) at += 2; /* an encoded comma separates tags too */
    }
    const char *at = document->json;
    for (int i = 0; i < document->count; at += document->pieces[i++][0]) {
        if (!(document->pieces[i][1] & tags)) continue;
        /* the first element of a list has no comma before it */
        int comma = *at == ',' && strchr("[{", out->data[out->bytes - 1]);
        PEND_TRY(api_buffer_add(out, at + comma, document->pieces[i][0] - (size_t)comma));
    }
    return PEND_OK;
}
