/* The values of statements and the rows that they return; seals: checksums of rows and their
 * positions, which show whether a row is unchanged.
 * Leaves to others: the statements (store_statements), rows that only one file reads (that file).
 * Invariant: a text or a list that is too long is truncated; nothing is written out of bounds.
 * Every job, chunk of results, scene and room item has a seal, which has no secret: it detects
 * accidents and exchanged rows, not an attacker who can write to the database. */
#pragma once

#include "server/store/store.h"
#include "server/store/store_statements.h"
#include "api/call/digest.h"

/** Returns a number. */
struct srv_value srv_value_whole(int64_t whole);

/** Returns a text, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_text(const char *text);

/** Returns a string of bytes, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_bytes(const void *data, size_t bytes);

/** Returns the value itself. */
struct srv_value srv_value_same(struct srv_value value);

/* Up to 20 texts, integers and byte strings (srv_value_bytes) as an array of values, and their
 * number. */
#define SRV_VALUES(...)                                                                            \
    (const struct srv_value[]){__VA_OPT__(VALUE_20(VALUE_EACH(__VA_ARGS__))){0}},                  \
        (int)(sizeof(const struct srv_value[]){__VA_OPT__(VALUE_20(VALUE_EACH(__VA_ARGS__))){0}} / \
              sizeof(struct srv_value)) -                                                          \
            1
#define VALUE(v)                                                                                   \
    _Generic((v), char *                                                                           \
             : srv_value_text, const char *                                                        \
             : srv_value_text, struct srv_value                                                    \
             : srv_value_same, default                                                             \
             : srv_value_whole)(v)
/* a macro does not expand itself, so its result is rescanned 20 more times */
#define VALUE_EACH(v, ...) VALUE(v), __VA_OPT__(VALUE_AGAIN VALUE_NONE(__VA_ARGS__))
#define VALUE_AGAIN() VALUE_EACH
#define VALUE_NONE ()
#define VALUE_20(...) VALUE_5(VALUE_5(VALUE_5(VALUE_5(__VA_ARGS__))))
#define VALUE_5(...) VALUE_1(VALUE_1(VALUE_1(VALUE_1(__VA_ARGS__))))
#define VALUE_1(...) __VA_ARGS__

/* Runs, or posts, a statement on a connection with the values that are listed at the end. */
#define SRV_SQL_RUN(sql, id, row, context, ...)                                                    \
    (sql)->driver->run((sql), (int)(id), srv_statement_text[id], SRV_VALUES(__VA_ARGS__), (row),   \
                       (context))
#define SRV_SQL_POST(sql, id, ...)                                                                 \
    (sql)->driver->post((sql), (int)(id), srv_statement_text[id], SRV_VALUES(__VA_ARGS__))

/* Integers of the first row, and the number of rows. */
struct srv_row_wholes {
    int rows, count; /* count: of the integers, at most 4 */
    int64_t whole[4];
    int flawed; /* a field was no number, negative, or too large */
};

/** Reads a row into a struct srv_row_wholes. */
enum srv_stored srv_row_wholes(void *context, const struct srv_value field[]);

/* Verifies bytes that were stored under a name; `field` are the fields after them in their row:
 * seal,
 * ... */
typedef int srv_whole_fn(const struct srv_value field[], const char *name, const void *data,
                         size_t bytes);

/* One field of bytes. */
struct srv_row_bytes {
    const char
        *name; /* the name of the row and the function that verifies its bytes, set by the caller */
    srv_whole_fn *whole;
    void *data; /* malloc'ed, the caller frees it; NULL if there was no row, or it is damaged */
    size_t bytes;
};

/** Reads a row into a struct srv_row_bytes. SRV_STORED_DAMAGED: the bytes are missing or their
 * checksum is wrong; SRV_STORED_BROKEN: memory is short. */
enum srv_stored srv_row_bytes(void *context, const struct srv_value field[]);

/** Copies a text field; any other type becomes "". */
void srv_row_text(const struct srv_value *field, char text[], size_t cap);

/* Stored data may have been altered on disk or by another program, and SQLite stores any type in
 * any column: every field of a row is checked when it is read. */

/* A row that is read field by field. */
struct srv_row {
    const struct srv_value *next;
    const char *flaw; /* the first column with an impossible value; NULL = none */
};

/** Returns the next field, an integer in least .. most; otherwise `least`, and the column becomes
 * the row's flaw. */
int64_t srv_row_whole(struct srv_row *row, int64_t least, int64_t most, const char *column);

/** Copies the next field, a text of least .. cap - 1 bytes; otherwise "", and the column becomes
 * the row's flaw. */
void srv_row_word(struct srv_row *row, size_t least, char text[], size_t cap, const char *column);

/** Marks a job as failed because of a damaged column; only its owner is still trusted. */
void srv_row_job_fail(struct srv_job *job, const char *flaw);

/* the last instant of the year 9999, in us since 1970: later times are invalid */
#define SRV_ROW_LATEST INT64_C(253402300799999999)
/* upper bound of parts and bytes */
#define SRV_ROW_MOST (INT64_C(1) << 53)

enum {
    SRV_ROW_SEAL = 19,
    SRV_ROW_JOB = 20
}; /* index of the seal in JOB_COLUMNS, and number of columns */

/* Jobs listed by a statement. */
struct srv_row_jobs {
    int count, cap;
    int nameless;                           /* there were rows without an id */
    struct srv_job *job;                    /* `cap` jobs, owned by the caller */
    unsigned char digest[SRV_DIGEST_BYTES]; /* of the last job, if the statement selects it */
    int with_digest;
    int with_part; /* non-zero: a part of the job is selected, too: */
    long part_state, attempt;
};

/** Reads a row into a struct srv_row_jobs. An invalid row becomes a failed job, see `flaw`; a row
 * without an id is skipped. */
enum srv_stored srv_row_job(void *context, const struct srv_value field[]);

/* the seal of a job's row: the seal of its request, then that of all constant columns */
enum { SRV_SEAL_JOB_BYTES = 2 * API_SEAL_BYTES };

/** Computes the seal of a job's row from its id, client, operation, parts, chained, created, title
 * and version, and its request. O(bytes). */
void srv_seal_job(unsigned char seal[SRV_SEAL_JOB_BYTES], const struct srv_job *job,
                  const void *request, size_t bytes);

/** Returns non-zero if a job's row, without its request, is unchanged. O(1). */
int srv_seal_job_whole(const struct srv_job *job, const struct srv_value *seal);

/** Returns non-zero if a job's request is unchanged; `seal` is that of the row. O(bytes). */
int srv_seal_request_whole(const struct srv_value *seal, const void *request, size_t bytes);

/** Computes the seal of a chunk of results from its bytes, job, part and index. O(bytes). */
void srv_seal_chunk(unsigned char seal[API_SEAL_BYTES], const char *job, long part, long chunk,
                    const void *data, size_t bytes);

/** Returns non-zero if a chunk is unchanged and in its place. O(bytes). */
int srv_seal_chunk_whole(const struct srv_value *seal, const char *job, long part, long chunk,
                         const void *data, size_t bytes);

/** Computes the seal of a scene from its id and body. O(bytes). */
void srv_seal_scene(unsigned char seal[API_SEAL_BYTES], const char *id, const void *body,
                    size_t bytes);

/** Returns non-zero if a scene is unchanged. O(bytes). */
int srv_seal_scene_whole(const struct srv_value *seal, const char *id, const void *body,
                         size_t bytes);

/** Computes the seal of a room item from the room's code, the item's name, its readers, its change
 * number, flag and body. O(bytes). */
void srv_seal_item(unsigned char seal[API_SEAL_BYTES], const char *code, const char *name,
                   const int64_t number[3], const void *body, size_t bytes);

/** Returns non-zero if an item is unchanged. O(bytes). */
int srv_seal_item_whole(const struct srv_value *seal, const char *code, const char *name,
                        const int64_t number[3], const void *body, size_t bytes);
