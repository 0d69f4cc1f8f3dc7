/* The OpenAPI document, compiled in from api/call/openapi.yaml as JSON.
 * Leaves to others: serving it (server).
 * Invariant: the bytes are valid JSON with the same content as the YAML. */
#ifndef API_OPENAPI_H
#define API_OPENAPI_H

#include <stddef.h>

extern const char api_openapi_json[];
extern const size_t api_openapi_bytes;

/* The same gzipped, and its entity tag with its quotes. */
extern const char api_openapi_packed[];
extern const size_t api_openapi_packed_bytes;
extern const char api_openapi_etag[];

#endif
