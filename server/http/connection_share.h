/* The limit of open connections per address, and the address for which a connection counts.
 * Leaves to others: the count itself (work/clients), answers to clients (connection).
 * Invariant: connections of a trusted proxy are not limited, because they are those of its
 * clients. */
#pragma once

#include <sys/socket.h>

#include "server/work/exchange.h"

/** Returns the largest number of connections that one client may have open, >= 1. */
int srv_connection_share(const struct srv_config *config);

/** Writes an IPv4 or IPv6 address as text; "" for NULL. */
void srv_connection_share_peer(const struct sockaddr *address, char peer[SRV_PEER_BYTES]);

/** Adds a reference to the record of an address, as srv_clients_take does. Returns NULL for a
 * trusted proxy, and if memory is short. */
struct srv_client *srv_connection_share_client(struct srv_service *service, const char *peer);

/** Returns true if an address is so far above its share that a new connection is closed without an
 * answer. */
int srv_connection_share_passed(struct srv_service *service, const struct sockaddr *address);

/* The limit that a connection exceeds. */
enum srv_surplus {
    SRV_SURPLUS_NONE,
    SRV_SURPLUS_ALL, /* max-connections */
    SRV_SURPLUS_OWN, /* max-client-connections */
    SRV_SURPLUS_HELD /* max-held-bytes */
};

/** Answers a request on a connection that exceeds a limit: 429 for the client's own, else 503. */
void srv_connection_share_refuse(struct srv_exchange *exchange, enum srv_surplus surplus);
