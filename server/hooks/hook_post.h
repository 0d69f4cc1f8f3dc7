/* One message, posted over HTTPS to a url that nobody vouches for: by libcurl, in a process that
 * has nothing else.
 * Leaves to others: whether the url is one (api/call/webhook), the process (hook_loop).
 * Invariant: it connects to addresses that were checked, of one look-up; it follows no redirect,
 * uses no proxy, sends no cookie, and reads no more of an answer than its head. */
#ifndef SRV_HOOK_POST_H
#define SRV_HOOK_POST_H

#include "api/call/webhook.h"
#include "server/protocol/peer.h"

/* What became of it. */
enum srv_hook_end {
    SRV_HOOK_ANSWERED,
    SRV_HOOK_NOWHERE, /* the name has no address, nobody answered in time, or not by good TLS */
    SRV_HOOK_REFUSED, /* the address is none that it may go to */
    SRV_HOOK_BROKEN   /* this process could not send it */
};

enum {
    SRV_HOOK_CONNECT_S = 5, /* for a connection with TLS */
    SRV_HOOK_SECONDS = 15   /* and for all of it, but the name's look-up */
};

struct srv_hook_message {
    const char *url, *id, *timestamp, *signatures, *body;
    size_t bytes;
};

/**
 * Posts a message.
 *
 * networks   that are allowed besides public addresses.
 * authority  a file of certificates (PEM) to trust, or "none": those of the system.
 * status     out: of the answer; 0 = there was none.
 */
enum srv_hook_end srv_hook_post(const struct srv_hook_message *message,
                                const struct srv_peers *networks, const char *authority,
                                int *status);

#endif
