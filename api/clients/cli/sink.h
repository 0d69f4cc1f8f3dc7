/* Where an answer goes: a file that is there only once it is whole, standard output, or memory.
 * Leaves to others: where it comes from (remote, local).
 * Invariant: a file of the wanted name is whole; what has arrived of one lies in NAME.part or
 * NAME.part-ETAG. */
#ifndef CLI_SINK_H
#define CLI_SINK_H

#include <stdio.h>

#include "api/base/buffer.h"

struct cli_sink {
    FILE *file; /* NULL: into text */
    const char *path;
    char *part;
    struct api_buffer text; /* an answer in memory, or a problem */
    long long have;         /* bytes in the file */
};

/** True if the sink is one: a part has a path, and bytes are counted of a file alone; for
 * assertions. */
int cli_sink_valid(const struct cli_sink *sink);

/** Opens a sink. path: of the file; NULL = standard output, "" = memory. kept: the name of the
 * answer, under which its beginning may be there already; NULL = begin anew. Dies on failure. */
void cli_sink_open(struct cli_sink *sink, const char *path, const char *kept);

/** Takes back what was written: the answer begins anew. Dies where it went to a pipe already. */
void cli_sink_again(struct cli_sink *sink);

/** Appends to the file, or to the text where there is none. Dies on failure. */
void cli_sink_add(struct cli_sink *sink, const char *data, size_t bytes);

/** Puts the whole file in its place, and frees the sink. */
void cli_sink_close(struct cli_sink *sink);

/** Writes a line over the last one, where standard error is a terminal; "" ends it. */
void cli_progress(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
