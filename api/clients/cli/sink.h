/* Where an answer goes: a regular file, which appears only when it is complete; a device or a pipe;
 * standard output; or memory.
 * Leaves to others: where it comes from (remote, local).
 * Invariant: a regular file is written as NAME.part-XXXXXX, or as NAME.part-ETAG where a later run
 * can continue it, by one process alone; a rename then puts it in its place. What is no regular
 * file is opened and written directly. */
#pragma once

#include <stdio.h>

#include "api/base/buffer.h"

struct cli_sink {
    FILE *file; /* NULL: into text */
    const char *path;
    char *real, *part;      /* the path without symbolic links; the temporary file's */
    struct api_buffer text; /* an answer in memory, or a problem */
    long long have;         /* bytes in the file */
};

/** True if the sink is one: a part has a path, and bytes are counted of a file alone; for
 * assertions. */
int cli_sink_valid(const struct cli_sink *sink);

/** Opens a sink. path: of the file; NULL or "-" = standard output, "" = memory. A symbolic link's
 * target is replaced, with its mode. kept: the name of the answer, whose beginning an earlier run
 * may have left; NULL = begin anew. Dies on failure: also where the file is read-only, and where
 * another process downloads the same answer to it. */
void cli_sink_open(struct cli_sink *sink, const char *path, const char *kept);

/** Takes back what was written: the answer begins anew. Dies where some of it went elsewhere than
 * to a temporary file. */
void cli_sink_again(struct cli_sink *sink);

/** Appends to the file, or to the text where there is none. Dies on failure. */
void cli_sink_add(struct cli_sink *sink, const char *data, size_t bytes);

/** Puts the whole file in its place, and frees the sink. */
void cli_sink_close(struct cli_sink *sink);

/** Writes a line over the last one, where standard error is a terminal; "" ends it. */
void cli_progress(const char *format, ...) __attribute__((format(printf, 1, 2)));
