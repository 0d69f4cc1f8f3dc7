/* Which web pages may read answers and what they may ask for (CORS).
 * Leaves to others: sending the fields (response), which routes are closed to other pages (router).
 * Invariant: an origin that is not allowed gets no field at all. */
#ifndef SRV_CORS_H
#define SRV_CORS_H

/* Of Access-Control-Expose-Headers: fields that a page's script may see. */
extern const char srv_cors_expose[];

/* Of Access-Control-Allow-Headers: fields that a page's request may have; all that mean
 * something here. */
extern const char srv_cors_fields[];

/**
 * The value of Access-Control-Allow-Origin.
 *
 * allowed  "*" for every page, "none", or a list of origins "https://a.org, http://localhost:8000",
 *          among which "*" may be: what is open is open to every page then, what is closed to those
 *          that are listed.
 * origin   of the request's Origin, or NULL.
 * closed   non-zero for what only listed pages may read: lists, and what changes jobs and scenes.
 *
 * Returns "*", origin, or NULL where no field is to be sent.
 */
const char *srv_cors_origin(const char *allowed, const char *origin, int closed);

/** True when answers depend on Origin: they are not the same for every page. */
int srv_cors_varies(const char *allowed);

/**
 * True for a page of another origin than the server's that is not listed either.
 *
 * origin  of the request, or NULL: no browser's page asks, or one of this origin does.
 * site    Sec-Fetch-Site, which a browser sends where it can and no page can forge, or NULL.
 * host    the request's Host, or NULL. A proxy may have taken the port off it.
 */
int srv_cors_foreign(const char *allowed, const char *origin, const char *site, const char *host);

#endif
