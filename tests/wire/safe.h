/* Certificates of a test's own, in a directory that goes with its end.
 * Leaves to others: who shows them, and what follows (test_tls, test_webhooks).
 * Invariant: keys have mode 0600; what GnuTLS refuses is a failed check. */
#ifndef SAFE_H
#define SAFE_H

#include <gnutls/gnutls.h>
#include <gnutls/x509.h>

enum { PATH = 160, TEXT = 1 << 20, DAY = 86400 };

/* Certificates in a directory: ca, and others that it has signed. */
struct safe {
    char directory[64];
    gnutls_x509_privkey_t authority_key;
    gnutls_x509_crt_t authority;
};

/** Makes a directory with ca.pem and server.pem, which is good for localhost; returns 0 with a
 * failed check. */
int safe_begin(struct safe *safe);

void safe_end(struct safe *safe);

/** Where a file of that name is. */
void safe_path(const struct safe *safe, const char *name, char path[PATH]);

/** Writes a file of mode 0600. */
void safe_write(const struct safe *safe, const char *name, const gnutls_datum_t *text);

/** A key and a certificate of it, NAME.key and NAME.pem, signed by the authority, or by itself
 * where there is none yet; its time from now in days. */
void safe_make(struct safe *safe, const char *name, const char *purpose, int from, int to);

/** Checks what a call of GnuTLS says; returns 1 where it was good. */
int good(int code, const char *what);

#endif
