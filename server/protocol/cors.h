/* The web pages that may read answers, and the fields that their requests may have (CORS).
 * Leaves to others: sending the fields (response), which routes are closed to other pages (router).
 * Invariant: an origin that is not allowed gets no field at all. */
#ifndef SRV_CORS_H
#define SRV_CORS_H

/* The value of Access-Control-Expose-Headers: the fields that a page's script may read. */
extern const char srv_cors_expose[];

/* The value of Access-Control-Allow-Headers: the fields that a page's request may have, which
 * are all that the server uses. */
extern const char srv_cors_fields[];

/**
 * Returns the value of Access-Control-Allow-Origin.
 *
 * allowed  "*" for every page, "none", or a list of origins "https://a.org, http://localhost:8000".
 * If the list contains "*", open routes are open to every page and closed routes to the listed
 * ones.
 * origin   of the request's Origin, or NULL.
 * closed   non-zero for routes that only listed pages may use: lists, and changes of jobs and
 * scenes.
 *
 * Returns "*", origin, or NULL if no field is to be sent.
 */
const char *srv_cors_origin(const char *allowed, const char *origin, int closed);

/** Returns true if answers depend on Origin, because they are not the same for every page. */
int srv_cors_varies(const char *allowed);

/**
 * Returns true for a page of another origin than the server's that is not listed either.
 *
 * origin  of the request, or NULL: the request comes from no browser's page, or from one of this
 * origin.
 * site    Sec-Fetch-Site, which browsers send and no page can forge, or NULL.
 * host    the request's Host, or NULL. A proxy may have removed the port.
 */
int srv_cors_foreign(const char *allowed, const char *origin, const char *site, const char *host);

#endif
