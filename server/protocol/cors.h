/* CORS: the web pages that may read answers, and the header fields that their requests may have.
 * Leaves to others: sending the fields (response), which routes are closed to other pages (router).
 * Invariant: an origin that is not allowed gets no CORS field. */
#pragma once

/* The value of Access-Control-Expose-Headers: the fields that a page's script may read. */
extern const char srv_cors_expose[];

/* The value of Access-Control-Allow-Headers: all request fields that the server uses. */
extern const char srv_cors_fields[];

/**
 * Returns the value of Access-Control-Allow-Origin.
 *
 * allowed  "*" for every page, "none", or a list of origins "https://a.org, http://localhost:8000".
 *          A list with "*" opens open routes to every page, and closed routes to listed pages.
 * origin   value of Origin, or NULL.
 * closed   non-zero for routes that only listed pages may use: lists, and changes of jobs and
 *          scenes.
 *
 * Returns "*", origin, or NULL if no field must be sent.
 */
const char *srv_cors_origin(const char *allowed, const char *origin, int closed);

/** Returns true if answers depend on Origin, so that Vary must name it. */
int srv_cors_varies(const char *allowed);

/**
 * Returns true if the request comes from a page of another origin that is not listed.
 *
 * origin  value of Origin, or NULL: no browser, or a page of this server.
 * site    value of Sec-Fetch-Site, which no page can forge, or NULL.
 * host    value of Host, or NULL. A proxy may have removed the port.
 */
int srv_cors_foreign(const char *allowed, const char *origin, const char *site, const char *host);
