/* Which addresses webhooks may go to: those of the public internet, and networks that the operator
 * names.
 * Leaves to others: looking names up, and connecting (hook_post).
 * Invariant: what is not known to be public is refused; an IPv4 address inside an IPv6 one is
 * judged as itself. */
#ifndef SRV_HOOK_ADDRESS_H
#define SRV_HOOK_ADDRESS_H

#include "server/protocol/peer.h"

struct sockaddr;

/**
 * Reads the list of networks that are allowed besides; as srv_peers_read, without "unix".
 *
 * PEND_INVALID
 */
PEND_MUST_CHECK enum pend_status srv_hook_networks(struct srv_peers *networks, const char *text,
                                                   struct pend_error *error);

/** Whether a message may go to an address; of another family than IPv4 and IPv6 never. */
int srv_hook_address_may(const struct sockaddr *address, const struct srv_peers *networks);

/** The same of a text; 1 as well where it is no address but a name. */
int srv_hook_host_may(const char *host, const struct srv_peers *networks);

#endif
