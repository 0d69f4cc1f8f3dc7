/* The listening socket: HOST:PORT or unix:PATH becomes a bound socket and its actual address.
 * Leaves to others: accepting connections (http).
 * Invariant: a returned socket listens, does not block and is not inherited by other programs. */
#ifndef SRV_LISTEN_H
#define SRV_LISTEN_H

#include "core/base/status.h"

enum { SRV_URL_BYTES = 320 };

/**
 * Binds and listens.
 *
 * address  HOST:PORT; the host is a name, a number, an IPv6 number in brackets, or * for every
 *          address. Port 0 takes a free one. Or unix:PATH: a socket of mode 0660, in the place of
 * one there that nobody listens on. fd       out, owned by the caller; -1 on failure. url      out:
 * http://HOST:PORT with the host as it was given (* as 0.0.0.0 or [::]) and the port as it is;
 * unix:PATH as it was given.
 *
 * PEND_INVALID  error says what could not be done and why: an unknown host, an address in use, no
 *               permission.
 * May ask the resolver, and then wait for it.
 */
PEND_MUST_CHECK enum pend_status srv_listen_open(const char *address, int *fd,
                                                 char url[SRV_URL_BYTES], struct pend_error *error);

/**
 * Lets nobody new in, while those who are half-way in or waiting to be accepted still get in: new
 * connections find silence, and knock again after a second, when this server is gone or the next
 * one is there.
 *
 * fd  a listening TCP socket. Returns 1, or 0 where the system does not allow it (some let only an
 *     administrator filter
 * what a socket receives); then nothing changes, and a connection that comes at the very end may be
 * reset.
 */
int srv_listen_settle(int fd);

#endif
