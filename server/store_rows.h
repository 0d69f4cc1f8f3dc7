/* Values that statements are given, and rows that they answer with.
 * Leaves to others: the statements (store_statements), rows that only one file reads (that file).
 * Invariant: a text or a list that is too long for its place is cut, and never written past it. */
#ifndef SRV_STORE_ROWS_H
#define SRV_STORE_ROWS_H

#include "server/store.h"

/** A number. */
struct srv_value srv_value_whole(int64_t whole);

/** A text, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_text(const char *text);

/** A string of bytes, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_bytes(const void *data, size_t bytes);

/* Some whole numbers of the first row, for those who want no more, and how many rows there were. */
struct srv_row_wholes {
    int rows, count; /* count <= 4: of the numbers */
    int64_t whole[4];
};

/** Takes a row into a struct srv_row_wholes. */
enum srv_stored srv_row_wholes(void *context, const struct srv_value field[]);

/* One field of bytes. */
struct srv_row_bytes {
    void *data; /* malloc'ed, the asker's; NULL where there was no row */
    size_t bytes;
};

/** Takes a row into a struct srv_row_bytes. SRV_STORED_BROKEN when out of memory. */
enum srv_stored srv_row_bytes(void *context, const struct srv_value field[]);

/** Copies a field of text; NULL becomes "". */
void srv_row_text(const struct srv_value *field, char text[], size_t cap);

enum { SRV_ROW_JOB = 17 }; /* fields of JOB_COLUMNS */

/* Jobs, as a statement lists them. */
struct srv_row_jobs {
    int count, cap;
    struct srv_job *job;                    /* cap of them, the asker's */
    unsigned char digest[SRV_DIGEST_BYTES]; /* of the last, where the statement asks for it */
    int with_digest;
    int with_lease; /* the statement asks for a shard of the job as well: */
    long shard_state, attempt;
};

/** Takes a row into a struct srv_row_jobs. */
enum srv_stored srv_row_job(void *context, const struct srv_value field[]);

#endif
