#include "server/http/connection_share.h"

#include <netdb.h>
#include <stdio.h>
#include <string.h>

enum {
    SHARE_SURPLUS = 16, /* connections above the share that get an answer; further ones are closed
                         * at once */
    SHARE_PART = 4      /* the share of a client is 1/4 of all connections */
};

int srv_connection_share(const struct srv_config *config) {
    double share = config->client_connections > 0 ? config->client_connections
                                                  : config->connections / SHARE_PART;
    return share > 1 ? (int)share : 1;
}

void srv_connection_share_peer(const struct sockaddr *address, char peer[SRV_PEER_BYTES]) {
    char text[64] = "";
    if (address && address->sa_family == AF_UNIX) {
        snprintf(peer, SRV_PEER_BYTES, "unix");
        return;
    }
    socklen_t bytes = address && address->sa_family == AF_INET6 ? 28 : 16;
    if (address) getnameinfo(address, bytes, text, sizeof text, NULL, 0, NI_NUMERICHOST);
    snprintf(peer, SRV_PEER_BYTES, "%.*s", SRV_PEER_BYTES - 1,
             strncmp(text, "::ffff:", 7) ? text : text + 7);
}

struct srv_client *srv_connection_share_client(struct srv_service *service, const char *peer) {
    struct srv_identity identity = {.kind = SRV_IDENTITY_ADDRESS};
    if (srv_peer_trusted(srv_service_trusted(service), peer)) return NULL;
    (void)srv_identity_begin(&identity, peer, NULL);
    assert(identity.source[0]);
    return srv_clients_take(service->clients, identity.source, NULL);
}

int srv_connection_share_passed(struct srv_service *service, const struct sockaddr *address) {
    char peer[SRV_PEER_BYTES];
    srv_connection_share_peer(address, peer);
    struct srv_client *client = srv_connection_share_client(service, peer);
    if (!client) return 0;
    int open = atomic_load(&client->connections);
    assert(open >= 0);
    srv_clients_give(service->clients, client);
    return open >= srv_connection_share(srv_service_config(service)) + SHARE_SURPLUS;
}

void srv_connection_share_refuse(struct srv_exchange *exchange, enum srv_surplus surplus) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    assert(surplus != SRV_SURPLUS_NONE);
    srv_metrics_count(surplus == SRV_SURPLUS_OWN    ? &metrics->refused_own_connections
                      : surplus == SRV_SURPLUS_HELD ? &metrics->refused_held
                                                    : &metrics->refused_connections,
                      1);
    if (surplus != SRV_SURPLUS_OWN) {
        srv_exchange_busy(exchange, 1,
                          surplus == SRV_SURPLUS_ALL
                              ? "too many connections are open: max-connections"
                              : "no memory is left for a connection: max-held-bytes");
        return;
    }
    srv_exchange_problem(exchange, 429,
                         API_TYPE_RATE
                         "you have more connections open than max-client-connections, %d",
                         srv_connection_share(srv_service_config(exchange->service)));
    srv_exchange_retry(exchange, 1);
}
