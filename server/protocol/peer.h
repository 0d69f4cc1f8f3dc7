/* Who a request comes from: the other end of the connection, or, behind a proxy that is trusted,
 * whom that names.
 * Leaves to others: what follows from it (clients, log).
 * Invariant: a header field of somebody who is not trusted changes nothing. */
#ifndef SRV_PEER_H
#define SRV_PEER_H

#include "core/base/status.h"

enum { SRV_PEER_NETWORKS = 32, SRV_PEER_BYTES = 48 };

/* Networks whose word is taken. */
struct srv_peers {
    int local; /* whoever connects by a path */
    int count;
    struct {
        unsigned char address[16]; /* IPv4 as ::ffff:a.b.c.d */
        int bits;
    } network[SRV_PEER_NETWORKS];
};

/**
 * Reads a list of networks.
 *
 * text  "10.0.0.0/8, ::1"; an address without a length is that address alone; "unix" is whoever
 *       connects by the path of a socket; "none" is none.
 *
 * PEND_INVALID  error says which entry is none.
 */
PEND_MUST_CHECK enum pend_status srv_peers_read(struct srv_peers *peers, const char *text,
                                                struct pend_error *error);

/** True where anybody's word is taken. */
int srv_peers_any(const struct srv_peers *peers);

/** True where the word of an address is taken: it is in one of the networks, or is "unix" and that
 * is in the list. */
int srv_peer_trusted(const struct srv_peers *peers, const char *address);

/** Returns true for a field that names addresses, "X-Forwarded-For" or "Forwarded"; any other
 * field names an account. */
int srv_peer_names_addresses(const char *header);

/** The network of an address, as text: of IPv6 that of 64 bits, which is what one household gets;
 * of an IPv4 address, also one that is written as IPv6, itself; of anything else the text. */
void srv_peer_network(const char *address, char network[SRV_PEER_BYTES]);

/** An address as a log may tell it that is to name nobody: of IPv4 its first 24 bits, of IPv6 48,
 * of anything else nothing. */
void srv_peer_shorten(const char *text, char shown[SRV_PEER_BYTES]);

/**
 * The address that a request comes from.
 *
 * peer    address at the other end, as text.
 * header  the field in which proxies tell, "X-Forwarded-For" or "Forwarded" (RFC 7239); of any
 *         other one the address is the peer.
 * value   of that field in the request, all of them joined by commas; NULL where there is none.
 * client  out: of the addresses that proxies told, from the last on, the first that is not of a
 *         trusted proxy itself; the peer where it is not trusted or tells nothing that is an
 *         address.
 */
void srv_peer_client(const struct srv_peers *peers, const char *peer, const char *header,
                     const char *value, char client[SRV_PEER_BYTES]);

#endif
