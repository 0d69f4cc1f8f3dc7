/* The values of statements and the rows that they return.
 * Leaves to others: the statements (store_statements), rows that only one file reads (that file).
 * Invariant: a text or a list that is too long for its place is cut, and never written past it. */
#ifndef SRV_STORE_ROWS_H
#define SRV_STORE_ROWS_H

#include "server/store/store.h"
#include "server/store/store_statements.h"

/** A number. */
struct srv_value srv_value_whole(int64_t whole);

/** A text, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_text(const char *text);

/** A string of bytes, borrowed; NULL is the database's NULL. */
struct srv_value srv_value_bytes(const void *data, size_t bytes);

/** The value itself. */
struct srv_value srv_value_same(struct srv_value value);

/* Texts, whole numbers and byte strings (srv_value_bytes) as an array of values, and their number;
 * up to 20 of them. */
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
/* a macro does not expand itself: what it leaves is expanded 20 times more */
#define VALUE_EACH(v, ...) VALUE(v), __VA_OPT__(VALUE_AGAIN VALUE_NONE(__VA_ARGS__))
#define VALUE_AGAIN() VALUE_EACH
#define VALUE_NONE ()
#define VALUE_20(...) VALUE_5(VALUE_5(VALUE_5(VALUE_5(__VA_ARGS__))))
#define VALUE_5(...) VALUE_1(VALUE_1(VALUE_1(VALUE_1(__VA_ARGS__))))
#define VALUE_1(...) __VA_ARGS__

/* Run, or post, a statement on a connection with the values that are listed at the end. */
#define SRV_SQL_RUN(sql, id, row, context, ...)                                                    \
    (sql)->driver->run((sql), (int)(id), srv_statement_text[id], SRV_VALUES(__VA_ARGS__), (row),   \
                       (context))
#define SRV_SQL_POST(sql, id, ...)                                                                 \
    (sql)->driver->post((sql), (int)(id), srv_statement_text[id], SRV_VALUES(__VA_ARGS__))

/* Some whole numbers of the first row, for those who want no more, and how many rows there were. */
struct srv_row_wholes {
    int rows, count; /* count <= 4: of the numbers */
    int64_t whole[4];
    int flawed; /* one was no number, negative, or more than can be counted */
};

/** Takes a row into a struct srv_row_wholes. */
enum srv_stored srv_row_wholes(void *context, const struct srv_value field[]);

/* Whether bytes are what was written under a name; `field` is what follows them in their row:
 * seal, ... */
typedef int srv_whole_fn(const struct srv_value field[], const char *name, const void *data,
                         size_t bytes);

/* One field of bytes. */
struct srv_row_bytes {
    const char *name; /* the row's, and how its bytes are judged: the asker's */
    srv_whole_fn *whole;
    void *data; /* malloc'ed, the asker's; NULL where there was no row, or it is damaged */
    size_t bytes;
};

/** Takes a row into a struct srv_row_bytes. SRV_STORED_DAMAGED where it is no bytes or not those
 * that were written,
 * SRV_STORED_BROKEN when out of memory. */
enum srv_stored srv_row_bytes(void *context, const struct srv_value field[]);

/** Copies a field of text; what is none becomes "". */
void srv_row_text(const struct srv_value *field, char text[], size_t cap);

/* What is read may have been altered where it was kept, on a disk or by somebody else's program:
 * every field of a row is looked at when it is read. SQLite keeps any type in any column. */

/* A row that is read field by field. */
struct srv_row {
    const struct srv_value *next;
    const char *flaw; /* the first column that holds what nobody can have written; NULL = none */
};

/** The next field, a number of least .. most; else `least`, and the column is the row's flaw. */
int64_t srv_row_whole(struct srv_row *row, int64_t least, int64_t most, const char *column);

/** The next field, a text of least .. cap - 1 bytes, copied; else "", and the column is the row's
 * flaw. */
void srv_row_word(struct srv_row *row, size_t least, char text[], size_t cap, const char *column);

/** Makes a job one that has failed because of a column: nothing of it is believed but whose it
 * is. */
void srv_row_job_fail(struct srv_job *job, const char *flaw);

/* the last instant of the year 9999 in microseconds since 1970: what is later was written by no
 * clock */
#define SRV_ROW_LATEST INT64_C(253402300799999999)
/* more parts, or bytes, than there can be */
#define SRV_ROW_MOST (INT64_C(1) << 53)

enum { SRV_ROW_SEAL = 19, SRV_ROW_JOB = 20 }; /* of JOB_COLUMNS: the seal, and their number */

/* Jobs, as a statement lists them. */
struct srv_row_jobs {
    int count, cap;
    int nameless;                           /* there were rows without an id */
    struct srv_job *job;                    /* cap of them, the asker's */
    unsigned char digest[SRV_DIGEST_BYTES]; /* of the last, where the statement asks for it */
    int with_digest;
    int with_part; /* the statement asks for a part of the job as well: */
    long part_state, attempt;
};

/** Takes a row into a struct srv_row_jobs. A row that cannot have been written is a job that has
 * failed, see `flaw`; one without an id is left out. */
enum srv_stored srv_row_job(void *context, const struct srv_value field[]);

#endif
