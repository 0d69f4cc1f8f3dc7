/* TLS in the process: the certificate that is shown, the certificates that clients must show, and
 * the bytes of sealed connections. The only door to GnuTLS.
 * Leaves to others: handshakes and connections (libmicrohttpd, http), when certificates are read
 * again (daemon).
 * Invariant: a certificate that does not fit its key or the time never takes the place of one that
 * did. */
#ifndef SRV_TLS_H
#define SRV_TLS_H

#include <stddef.h>

#include "server/config/config.h"
#include "server/http/recv_hook.h"

enum { SRV_TLS_WHY = 160 };

struct srv_tls;

/**
 * Reads the certificate, its key, the authority of clients' certificates and the lists of those
 * that it has revoked, as the options name them.
 *
 * tls  out; NULL where no option names a certificate, and on failure. Ends with srv_tls_free.
 *
 * PEND_INVALID    error says which file does not fit, and why: it cannot be read, is no PEM, the
 * key is another certificate's or can be read by others, the time of one is over. PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_tls_new(struct srv_tls **tls, const struct srv_config *config,
                                             struct pend_error *error);

/** Frees it; no connection may be left. NULL is accepted. */
void srv_tls_free(struct srv_tls **tls);

/** Reads all files again; new connections are shown what they say. Fails as srv_tls_new does, and
 * then nothing has changed. One thread at a time, beside those that serve. */
PEND_MUST_CHECK enum pend_status srv_tls_reload(struct srv_tls *tls, struct pend_error *error);

/** Makes the calling thread serve with these certificates; NULL = with none. */
void srv_tls_here(struct srv_tls *tls);

/** The callback that libmicrohttpd wants for certificates (MHD_OPTION_HTTPS_CERT_CALLBACK). */
void *srv_tls_callback(void);

/** The authority of clients' certificates as PEM, for libmicrohttpd to ask them for one; NULL where
 * they need none. */
const char *srv_tls_trust(const struct srv_tls *tls);

/** The versions of TLS that are spoken, and how, as GnuTLS names them. */
extern const char srv_tls_priorities[];

/**
 * Whether the certificate that a client has shown in its handshake fits.
 *
 * session  of the connection, as libmicrohttpd tells it.
 * why      out: what is wrong with it, as the end of a sentence.
 *
 * Returns 1 where it fits, or where clients need none.
 */
int srv_tls_client_fits(struct srv_tls *tls, void *session, char why[SRV_TLS_WHY]);

/** Sends bytes on a sealed connection, as far as they can be sent at once. On the thread that
 * serves it. */
void srv_tls_send(void *session, const void *data, size_t bytes);

#endif
