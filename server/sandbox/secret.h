/* Files that hold secrets: read whole, if nobody else can read them.
 * Leaves to others: what they say (key_file, config_load).
 * Invariant: a secret that other users of the machine could read is refused. */
#ifndef SRV_SECRET_H
#define SRV_SECRET_H

#include <sys/stat.h>

#include "api/base/buffer.h"
#include "core/base/status.h"

/**
 * Reads a file of mode 0600, or narrower, that belongs to this process's user or to root; to root
 * it may belong to anybody. One of root's that only a group may read besides is accepted from
 * another user's process: service managers hand out secrets so.
 *
 * out   what the file says is added; out->limit bounds it.
 * seen  out: what the system says of the file that was read; NULL = not wanted.
 *
 * PEND_INVALID    error says what is wrong: no file, somebody else's, too open, too long.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_secret_read(const char *path, struct api_buffer *out,
                                                 struct stat *seen, struct pend_error *error);

#endif
