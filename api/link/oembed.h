/* oEmbed (oembed.com): a link to the page as a frame that somebody else's page can show, and the
 * tag by which the page's document tells of it.
 * Leaves to others: who may have the frame (server/http/assets), what the page makes of a link.
 * Invariant: only links to the page of the host that was asked become frames; what of a link comes
 * into HTML has letters that a link may have (RFC 3986), and those of them that HTML reads are
 * escaped. */
#ifndef API_OEMBED_H
#define API_OEMBED_H

#include "api/base/buffer.h"
#include "api/base/problem.h"

enum {
    API_OEMBED_URL = 1000,   /* letters of a link that is asked for */
    API_OEMBED_LINK = 1200,  /* bytes of the frame's link with its NUL */
    API_OEMBED_WIDTH = 720,  /* px, where nobody wants less */
    API_OEMBED_HEIGHT = 480, /* px */
    API_OEMBED_MOST = 100000 /* px that maxwidth and maxheight may say */
};

/* What is asked for: the embed view of a link, in a frame of a size. */
struct api_oembed {
    char link[API_OEMBED_LINK]; /* of the embed view: https://host/?embed=1&lang=de#d=... */
    long width, height;         /* px, at most API_OEMBED_WIDTH and API_OEMBED_HEIGHT */
};

/**
 * Reads the query of a request for oEmbed: url (needed), format, maxwidth and maxheight, encoded as
 * RFC 3986 says; others, which sites add, are not looked at.
 *
 * query    of the request's target; NULL = there is none.
 * host     that the request was sent to, with its port; NULL = it does not say.
 * wanted   out; as it was where the query is refused.
 * problem  422: a parameter is missing, is there twice or is not what it must be, the url has more
 *          than API_OEMBED_URL letters; 404: the url is
 *          not one of the page of this host, or one of a room or of another document; 501: another
 *          format than json.
 *
 * Returns PEND_INVALID with the problem stated. O(bytes of the query), no allocation.
 */
PEND_MUST_CHECK enum pend_status api_oembed_read(const char *query, const char *host,
                                                 struct api_oembed *wanted,
                                                 struct api_problem *problem);

/** Appends the answer, of the type "rich", as JSON. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_oembed_write(const struct api_oembed *wanted,
                                                  struct api_buffer *out);

/**
 * Appends the tag <link rel="alternate" type="application/json+oembed" ...> by which a document
 * tells where its frame is described; nothing where the host has other letters than hosts have.
 *
 * scheme  "http" or "https".
 * host    with its port; NULL appends nothing.
 * query   of the document, as it came.
 *
 * Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status api_oembed_tag(const char *scheme, const char *host,
                                                const char *query, struct api_buffer *out);

/** True for a query that says what the page shows, so that the document is worth a frame:
 * readable links, /?length=1,1&theta=90,45, and worksheets that come with it, /?sheet=period. */
int api_oembed_tells(const char *query);

#endif
