/* The listening socket: HOST:PORT or unix:PATH becomes a bound socket and its actual address.
 * Leaves to others: accepting connections (http).
 * Invariant: a returned socket listens, does not block and is not inherited by other programs. */
#pragma once

#include "core/base/status.h"

enum { SRV_URL_BYTES = 320 };

/**
 * Binds and listens.
 *
 * address  HOST:PORT; the host is a name, an IPv4 address, an IPv6 address in brackets, or *
 *          for all addresses; port 0 takes a free one. Or unix:PATH: a socket with mode 0660,
 *          which replaces a stale one.
 * fd       out, owned by the caller; -1 on failure.
 * url      out: http://HOST:PORT with the given host (* becomes 0.0.0.0 or [::]) and the actual
 *          port; unix:PATH unchanged.
 *
 * PEND_INVALID  error names the failed step and the reason. May block in the resolver.
 */
PEND_MUST_CHECK enum pend_status srv_listen_open(const char *address, int *fd,
                                                 char url[SRV_URL_BYTES], struct pend_error *error);

/**
 * Stops accepting new connections; those in the handshake or in the backlog are still accepted. New
 * SYN packets are dropped, so that clients retry after a second, when the next server listens.
 *
 * fd  a listening TCP socket.
 *
 * Returns 1; or 0 if the system forbids socket filters: then nothing changes, and a connection at
 * the very end may be reset.
 */
int srv_listen_settle(int fd);
