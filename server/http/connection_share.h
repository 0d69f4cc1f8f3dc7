/* How many connections one address may have open, and which address a connection counts for.
 * Leaves to others: the count itself (work/clients), telling a client (connection).
 * Invariant: connections of a trusted proxy count for nobody, as they are those of its clients. */
#ifndef SRV_CONNECTION_SHARE_H
#define SRV_CONNECTION_SHARE_H

#include <sys/socket.h>

#include "server/work/exchange.h"

/** The most connections that one client may have open, >= 1. */
int srv_connection_share(const struct srv_config *config);

/** Writes an IPv4 or IPv6 address as text; "" for NULL. */
void srv_connection_share_peer(const struct sockaddr *address, char peer[SRV_PEER_BYTES]);

/** Adds a reference to the record of an address, as srv_clients_take does. Returns NULL for a
 * trusted proxy, and without memory. */
struct srv_client *srv_connection_share_client(struct srv_service *service, const char *peer);

/** True if an address has so many connections more than its share that a new one is to be closed
 * without an answer. */
int srv_connection_share_passed(struct srv_service *service, const struct sockaddr *address);

/* The limit that a connection is beyond. */
enum srv_surplus {
    SRV_SURPLUS_NONE,
    SRV_SURPLUS_ALL, /* max-connections */
    SRV_SURPLUS_OWN, /* max-client-connections */
    SRV_SURPLUS_HELD /* max-held-bytes */
};

/** Answers a request on a connection that is beyond a limit: 429 for the client's own, else 503. */
void srv_connection_share_refuse(struct srv_exchange *exchange, enum srv_surplus surplus);

#endif
