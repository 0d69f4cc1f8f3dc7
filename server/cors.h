/* Which web pages may read answers (CORS).
 * Leaves to others: sending the fields (http), what a route can do (router).
 * Invariant: an origin that is not allowed gets no field at all. */
#ifndef SRV_CORS_H
#define SRV_CORS_H

/* Of Access-Control-Expose-Headers: fields that a page's script may see. */
extern const char srv_cors_expose[];

/**
 * The value of Access-Control-Allow-Origin.
 *
 * allowed  "*" for every page, "none", or a list of origins "https://a.org, http://localhost:8000".
 * origin   of the request's Origin, or NULL.
 *
 * Returns "*", origin, or NULL where no field is to be sent.
 */
const char *srv_cors_origin(const char *allowed, const char *origin);

/** True when the answer depends on Origin: it is not the same for every page. */
int srv_cors_varies(const char *allowed);

#endif
