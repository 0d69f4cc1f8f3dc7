/* The host names that a server answers to. A web page of somebody else can make its own name
 * resolve to this server's address (DNS rebinding); it would then have the same origin as the
 * server if the server answered to any name.
 * Leaves to others: answering 421 (router).
 * Invariant: a server that only this machine can reach answers to this machine's names alone,
 * unless its options say more. */
#ifndef SRV_HOSTS_H
#define SRV_HOSTS_H

/**
 * True for a list of hosts that can be one.
 *
 * list  "*" = any; "auto"; or hosts like "pendulum.example.org, *.example.org, 192.0.2.1, [::1],
 *       localhost:8080": a
 * host without a port is good with any.
 */
int srv_hosts_good(const char *list);

/**
 * What "auto" means for a server.
 *
 * list     as above.
 * listen   HOST:PORT, where it listens.
 * proxied  non-zero where it trusts a proxy: that passes on the name by which it was asked itself.
 *
 * Returns the list; for "auto" one of loopback's names where only this machine reaches the server,
 * else "*".
 */
const char *srv_hosts_mean(const char *list, const char *listen, int proxied);

/**
 * True where a server answers to a host.
 *
 * list  as srv_hosts_mean returns it.
 * host  of the request: "example.org:8080", in any case, with or without a dot at the end; NULL or
 *       "" = none was named, as by HTTP/1.0, which no browser speaks.
 */
int srv_hosts_allow(const char *list, const char *host);

/** True for a host that is an address, with or without a port: no name was looked up that somebody
 * may have turned here.
 */
int srv_hosts_numeric(const char *host);

#endif
