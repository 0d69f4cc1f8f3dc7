/* The file of keys: read, and changed by one program at a time.
 * Leaves to others: what is changed (keys_command), which keys are in force (key_ring).
 * Invariant: whoever reads the file finds the keys of before or of after a change, whole, whatever
 * dies meanwhile; no other user can read them. */
#ifndef SRV_KEY_FILE_H
#define SRV_KEY_FILE_H

#include <sys/stat.h>

#include "server/keys/keys.h"

/**
 * Reads the keys of a file, which must be nobody else's to read (srv_secret_read).
 *
 * keys  from srv_keys_init; to be cleared by the caller, after a failure too.
 * seen  out: what the system says of the file; NULL = not wanted.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says what is wrong, and where.
 */
PEND_MUST_CHECK enum pend_status srv_key_file_read(const char *path, struct srv_keys *keys,
                                                   struct stat *seen, struct pend_error *error);

/**
 * Changes the keys of a file: reads them, has them changed, writes them into a new file of mode
 * 0600 and the same owner, and puts that in the old one's place. Who else changes keys in the
 * same directory waits.
 *
 * make    non-zero: a file that is not there yet is made.
 * change  what is to be done; its failure leaves the file as it is.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says what is wrong; or what `change` returned.
 */
PEND_MUST_CHECK enum pend_status srv_key_file_change(
    const char *path, int make,
    enum pend_status (*change)(struct srv_keys *keys, void *context, struct pend_error *error),
    void *context, struct pend_error *error);

#endif
