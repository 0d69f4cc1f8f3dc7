/* oEmbed (oembed.com): the frame for a link to the page, and the tag that announces it in the
 * page's document.
 * Leaves to others: which sites may frame the page (server/http/assets), the view of a link (the
 * page).
 * Invariant: only links to the page on the requested host become frames; the parts of a link in
 * HTML have valid characters (RFC 3986) and are escaped. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/problem.h"

enum {
    API_OEMBED_URL = 1000,   /* maximum number of characters of a requested link */
    API_OEMBED_LINK = 1200,  /* bytes of the frame's link with its NUL */
    API_OEMBED_WIDTH = 720,  /* default width, px */
    API_OEMBED_HEIGHT = 480, /* px */
    API_OEMBED_MOST = 100000 /* upper bound of maxwidth and maxheight, px */
};

/* The result: the embed view of a link, and the size of its frame. */
struct api_oembed {
    char link[API_OEMBED_LINK]; /* link of the embed view: https://host/?embed=1&lang=de#d=... */
    long width, height;         /* px, at most API_OEMBED_WIDTH and API_OEMBED_HEIGHT */
};

/**
 * Reads the query of an oEmbed request: url (required), format, maxwidth and maxheight, encoded by
 * RFC 3986; unknown parameters, which sites add, are ignored.
 *
 * query    query of the request's target; NULL = absent.
 * host     host of the request with its port; NULL = unknown.
 * wanted   out; unchanged if the query is refused.
 * problem  422: a parameter is missing, repeated or invalid, or the url is longer than
 *          API_OEMBED_URL; 404: the url is not a link to the page on this host, or one to a class
 * room or another document; 501: a format other than json.
 *
 * Returns PEND_INVALID with the problem set. O(bytes of the query), no allocation.
 */
PEND_MUST_CHECK enum pend_status api_oembed_read(const char *query, const char *host,
                                                 struct api_oembed *wanted,
                                                 struct api_problem *problem);

/** Appends the answer, of the type "rich", as JSON. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_oembed_write(const struct api_oembed *wanted,
                                                  struct api_buffer *out);

/**
 * Appends the tag <link rel="alternate" type="application/json+oembed" ...>, which announces the
 * frame of a document; nothing if the host has invalid characters.
 *
 * scheme  "http" or "https".
 * host    with its port; NULL appends nothing.
 * query   query of the document, unchanged.
 *
 * Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status api_oembed_tag(const char *scheme, const char *host,
                                                const char *query, struct api_buffer *out);

/** Returns true for a query that selects a view, so that a frame makes sense: readable links
 * (/?length=1,1&theta=90,45), examples (/?example=kapitza) and worksheets (/?sheet=period). */
int api_oembed_tells(const char *query);
