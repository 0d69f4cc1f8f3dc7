/* The OpenAPI document, compiled in from api/call/openapi.yaml as JSON, whole or for some tags.
 * Leaves to others: serving it (server).
 * Invariant: the bytes are valid JSON with the same content as the YAML. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/problem.h"

/* The document, and the same as OpenAPI 3.0 for older tools, more permissive where 3.0 cannot
 * express a rule. `pieces` divides the text, in order, each piece with the comma before it; bit i
 * of its tags is set if operations of api_openapi_tags[i] need it. */
extern const struct api_openapi {
    const char *json, *packed, *etag; /* packed: the document gzipped; etag: with quotes */
    size_t bytes, packed_bytes;
    const unsigned (*pieces)[2]; /* bytes, tags */
    int count;                   /* number of pieces */
} api_openapi[2];
extern const char *const api_openapi_tags[]; /* ended by NULL */
extern const char api_openapi_names[];       /* the tags as a text, "compute, jobs, ..." */

/** Writes a document with only the operations of some tags, and the components that they need. The
 * query is "tag=jobs,scenes" or "tag=jobs&tag=scenes". PEND_INVALID with a problem for any other
 * query, PEND_NO_MEMORY. O(bytes). */
PEND_MUST_CHECK enum pend_status api_openapi_write(const struct api_openapi *document,
                                                   const char *query, struct api_buffer *out,
                                                   struct api_problem *problem);
