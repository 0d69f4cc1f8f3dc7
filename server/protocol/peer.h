/* The client's address: the peer of the connection or, behind a trusted proxy, the address that the
 * proxy reports.
 * Leaves to others: its use (clients, log).
 * Invariant: header fields from untrusted peers have no effect. */
#pragma once

#include "core/base/status.h"

enum { SRV_PEER_NETWORKS = 32, SRV_PEER_BYTES = 48 };

/* Networks of trusted proxies. */
struct srv_peers {
    int local; /* non-zero: connections to a Unix socket are trusted */
    int count;
    struct {
        unsigned char address[16]; /* IPv4 as ::ffff:a.b.c.d */
        int bits;
    } network[SRV_PEER_NETWORKS];
};

/**
 * Reads a list of networks.
 *
 * text  "10.0.0.0/8, ::1"; an address without a prefix length is that address alone; "unix" stands
 *       for Unix sockets; "none" is the empty list.
 *
 * PEND_INVALID  error names the invalid entry.
 */
PEND_MUST_CHECK enum pend_status srv_peers_read(struct srv_peers *peers, const char *text,
                                                struct pend_error *error);

/** Returns true if the list is not empty. */
int srv_peers_any(const struct srv_peers *peers);

/** Returns true if a peer is trusted: its address is in one of the networks, or it is "unix" and
 * the list contains "unix". */
int srv_peer_trusted(const struct srv_peers *peers, const char *address);

/** Returns true for a field that names addresses, "X-Forwarded-For" or "Forwarded"; any other
 * field names an account. */
int srv_peer_names_addresses(const char *header);

/** Writes the network that stands for a client: the /64 of an IPv6 address (one household), an IPv4
 * address itself (also if written as IPv6), any other text unchanged. */
void srv_peer_network(const char *address, char network[SRV_PEER_BYTES]);

/** Writes an anonymized address for the log: the first 24 bits of IPv4, 48 of IPv6, nothing for
 * other text. */
void srv_peer_shorten(const char *text, char shown[SRV_PEER_BYTES]);

/**
 * Determines the client's address.
 *
 * peer    address of the connection's peer, as text.
 * header  the field that proxies set, "X-Forwarded-For" or "Forwarded" (RFC 7239); with any other
 *         field the result is the peer.
 * value   values of that field, joined by commas; NULL if absent.
 * client  out: the last reported address that is not a trusted proxy; the peer if it is not trusted
 *         or reports no valid address.
 */
void srv_peer_client(const struct srv_peers *peers, const char *peer, const char *header,
                     const char *value, char client[SRV_PEER_BYTES]);
