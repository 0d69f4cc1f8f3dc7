/* The destination of an answer: a regular file, which appears only when it is complete; a device or
 * a pipe; standard output; or memory.
 * Leaves to others: the source of the answer (remote, local).
 * Invariant: a regular file is written as NAME.part-XXXXXX, or as NAME.part-ETAG if a later run can
 * continue it, by one process at a time; a rename then puts it in its place. Anything but a regular
 * file is opened and written directly. */
#pragma once

#include <stdio.h>

#include "api/base/buffer.h"

struct cli_sink {
    FILE *file; /* NULL = memory */
    const char *path;
    char *real, *part;      /* the path without symbolic links; the path of the temporary file */
    struct api_buffer text; /* an answer in memory, or a problem */
    long long have;         /* number of bytes in the file */
};

/** Opens a sink. path: of the file; NULL or "-" = standard output, "" = memory. If it is a symbolic
 * link, the target is replaced and keeps its mode. kept: the ETag of the answer, whose beginning
 * an earlier run may have left; NULL = start from the beginning. Ends the program on failure, also
 * if the file is read-only or another process downloads the same answer to it. */
void cli_sink_open(struct cli_sink *sink, const char *path, const char *kept);

/** Discards what was written, because the answer starts again. Ends the program if some of it was
 * not written to a temporary file. */
void cli_sink_again(struct cli_sink *sink);

/** Appends to the file, or to memory. Ends the program on failure. */
void cli_sink_add(struct cli_sink *sink, const char *data, size_t bytes);

/** Moves the complete file to its place, and frees the sink. */
void cli_sink_close(struct cli_sink *sink);

/** Overwrites the last line if standard error is a terminal; "" ends the line. */
void cli_progress(const char *format, ...) __attribute__((format(printf, 1, 2)));
