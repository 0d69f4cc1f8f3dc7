/* The host names that a server answers to. This prevents DNS rebinding: a foreign web page can make
 * its own name resolve to this server's address, and would then share the server's origin. Leaves
 * to others: answering 421 (router). Invariant: a server on loopback answers only to this machine's
 * names, unless its options allow more. */
#pragma once

/**
 * Returns true if a list of hosts is well-formed.
 *
 * list  "*" = any host; "auto"; or hosts like "pendulum.example.org, *.example.org, 192.0.2.1,
 *       [::1], localhost:8080". A host without a port matches any port.
 */
int srv_hosts_good(const char *list);

/**
 * Resolves "auto".
 *
 * list     as above.
 * listen   HOST:PORT, the server's address.
 * proxied  non-zero if it trusts a proxy, which forwards the host name of its own request.
 *
 * Returns the list; for "auto" the names of loopback if the server listens there without a proxy,
 * else "*".
 */
const char *srv_hosts_mean(const char *list, const char *listen, int proxied);

/**
 * Returns true if the server accepts a host.
 *
 * list  as srv_hosts_mean returns it.
 * host  value of Host: "example.org:8080", in any case, with or without a trailing dot. NULL and ""
 *       (absent, as in HTTP/1.0, which no browser uses) are accepted.
 */
int srv_hosts_allow(const char *list, const char *host);

/** Returns true if a host is a numeric address, with or without a port. Such a host needs no DNS.
 */
int srv_hosts_numeric(const char *host);
