/* Reads files with secrets.
 * Leaves to others: their contents (key_file, config_load).
 * Invariant: a file that other users of the machine can read is refused. */
#pragma once

#include <sys/stat.h>

#include "api/base/buffer.h"
#include "core/base/status.h"

/**
 * Reads a file with mode 0600 or narrower that belongs to this process's user or to root (a process
 * of root reads files of any owner). A file of root that a group may read is accepted too, because
 * service managers provide secrets this way.
 *
 * out   the contents are appended; out->limit bounds them.
 * seen  out: status of the file; NULL if not needed.
 *
 * PEND_INVALID    error names the reason: missing, wrong owner, readable by others, too long.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_secret_read(const char *path, struct api_buffer *out,
                                                 struct stat *seen, struct pend_error *error);
