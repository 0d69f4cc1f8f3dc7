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

/* The same as OpenAPI 3.0, for older tools; what 3.0 cannot express is described more permissively.
 */
extern const char api_openapi_twin_json[];
extern const size_t api_openapi_twin_bytes;
extern const char api_openapi_twin_packed[];
extern const size_t api_openapi_twin_packed_bytes;
extern const char api_openapi_twin_etag[];

#endif
