/* Reads and updates the file of API keys; one program at a time can change it.
 * Leaves to others: the changes (keys_command), which keys are active (key_ring).
 * Invariant: updates are atomic, even if the process dies; no other user can read the file. */
#pragma once

#include <sys/stat.h>

#include "server/keys/keys.h"

/**
 * Reads the keys of a file that only its owner can read (srv_secret_read).
 *
 * keys  from srv_keys_init; the caller clears it, after a failure too.
 * seen  out: the file's status; NULL if not needed.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error names the mistake and its line.
 */
PEND_MUST_CHECK enum pend_status srv_key_file_read(const char *path, struct srv_keys *keys,
                                                   struct stat *seen, struct pend_error *error);

/**
 * Changes the keys of a file: reads them, calls `change`, writes a new file with mode 0600 and the
 * same owner, and renames it over the old one. Concurrent changes in the same directory wait.
 *
 * make    non-zero: creates the file if it does not exist.
 * change  modifies the keys; if it fails, the file stays unchanged.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error names the mistake; or the result of `change`.
 */
PEND_MUST_CHECK enum pend_status srv_key_file_change(
    const char *path, int make,
    enum pend_status (*change)(struct srv_keys *keys, void *context, struct pend_error *error),
    void *context, struct pend_error *error);
