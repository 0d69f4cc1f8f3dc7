/* The interface that a database has to offer to a store: statements, rows, and the words that
 * differ between dialects.
 * Leaves to others: the statements (store_statements), the libraries (store_sqlite,
 * store_postgres).
 * Invariant: a connection is used by one thread at a time; data from outside are passed as
 * parameters only. */
#ifndef SRV_SQL_H
#define SRV_SQL_H

#include <stddef.h>
#include <stdint.h>

#include "core/base/status.h"

enum {
    SRV_SQL_PARAMETERS = 27,
    SRV_SQL_STATEMENTS = 128,
    SRV_SQL_TEXT = 2048,
    SRV_SQL_COMPLAINT = 240
};

/* The result of a call to a store. */
enum srv_stored {
    SRV_STORED,         /* done, and on disk */
    SRV_STORED_NONE,    /* there is no such thing */
    SRV_STORED_CLASH,   /* the key or id is taken by another request */
    SRV_STORED_QUOTA,   /* a quota would be exceeded */
    SRV_STORED_LOST,    /* the lease was lost, or the job ended meanwhile; nothing was written */
    SRV_STORED_DAMAGED, /* what is kept of it is not what can have been written; others are as
                           before */
    SRV_STORED_FULL,    /* the disk is full; nothing was written */
    SRV_STORED_AGAIN,   /* another process was in the way; nothing was written */
    SRV_STORED_AWAY,  /* the store cannot be reached now; whether the call took effect is unknown */
    SRV_STORED_BROKEN /* the store is damaged, out of memory, or not what this version can read */
};

/* Passes on what is not SRV_STORED. */
#define SRV_STORED_TRY(call)                                                                       \
    do {                                                                                           \
        enum srv_stored stored_try_ = (call);                                                      \
        if (stored_try_ != SRV_STORED) return stored_try_;                                         \
    } while (0)

/* A parameter, or a field of a row; data is borrowed. */
struct srv_value {
    enum { SRV_SQL_NULL, SRV_SQL_WHOLE, SRV_SQL_STRING, SRV_SQL_BYTES } kind;
    int64_t whole;
    const void *data; /* a text ends with a NUL that `bytes` does not count */
    size_t bytes;
};

/* A connection; a driver's own begins with it. */
struct srv_sql {
    const struct srv_sql_driver *driver;
    char complaint[SRV_SQL_COMPLAINT]; /* what the database said of the last failure */
};

/** Receives a row; its fields are valid during the call. Anything but SRV_STORED ends the
 * statement with that. */
typedef enum srv_stored srv_row_fn(void *context, const struct srv_value field[]);

/* What the process of a connection does, of bits; 0 = not known. */
enum {
    SRV_SQL_WORKS = 1, /* it computes parts of jobs */
    SRV_SQL_ANSWERS =
        2,             /* it answers requests; a process that only works leaves connections free */
    SRV_SQL_BESIDE = 4 /* the connection is not the first one of its process */
};

/* Whom a notification is for, of bits. */
enum {
    SRV_RING_WORK = 1, /* workers: a part can be claimed */
    SRV_RING_STOP = 2, /* workers: a job of which they hold parts may have ended */
    SRV_RING_ENDS = 4, /* processes that answer: a job or a class room has changed */
    SRV_RING_ALL = 7
};

/* A kind of database. */
struct srv_sql_driver {
    const char *scheme; /* what urls begin with: "sqlite:" */
    int batch;          /* calls worth one transaction */
    int distant;        /* it may be out of reach for a while */
    int shared;         /* several processes may change it at the same time */
    /* What stands in statements for {begin}; {now}, microseconds since 1970 by the database's
     * clock; {lock} and {skip}: the rows read are locked, those that another transaction has locked
     * are waited for, or left out; {alone}: tables are made by one process at a time; {ring}: wakes
     * the processes that listen, once committed, {ring work} and {ring stop}: the workers alone;
     * {crowd}: the number of processes that compute, and of the connections of all; {carries}: the
     * connections that the database takes, and how many processes that only compute it carries
     * beside one that answers; {bytes}: the type of byte strings; {hot}: what a table is told whose
     * few rows change with every transaction. */
    const struct srv_sql_word { const char *token, *text; } * words; /* up to one without a token */
    /* It runs a statement on many rows of values at once. Such a statement has {1}, {2}, ... for
     * a row's values, and one of {from twb}, {using twb} and {beside twb} where it names the
     * rows among its tables, with a letter for the type of each value: t a text, w a whole
     * number, b bytes. Elsewhere it is a statement on $1, $2, ... */
    int lists;

    /**
     * Connects. Where the database cannot be reached just now the connection is like one that was
     * lost.
     *
     * PEND_INVALID, PEND_NO_MEMORY
     */
    enum pend_status (*open)(struct srv_sql **sql, const char *url, int role,
                             struct pend_error *error);
    void (*close)(struct srv_sql *sql);
    /**
     * Runs one statement.
     *
     * id     0 .. SRV_SQL_STATEMENTS - 1: prepared at its first use and kept; -1: run once.
     * text   with $1, $2, ... for the values; a lost connection is made anew by a {begin} only.
     * row    called for every row; NULL where none is of interest.
     *
     * A statement on rows of values runs on those that were posted to it since the last `run`, and
     * on these.
     *
     * SRV_STORED_FULL, SRV_STORED_AGAIN, SRV_STORED_AWAY, SRV_STORED_BROKEN
     */
    enum srv_stored (*run)(struct srv_sql *sql, int id, const char *text,
                           const struct srv_value value[], int count, srv_row_fn *row,
                           void *context);
    /**
     * As run, of a statement of whose rows none is of interest. It may not wait: what became of it
     * is then the answer to the next `run`, which fails where it did.
     *
     * text  {look} as well: reads will come, each a transaction of its own; a lost connection is
     *       made anew. The rows of a statement on rows of values are gathered, and run before any
     *       other statement does: no two of them may change the same row of a table.
     */
    enum srv_stored (*post)(struct srv_sql *sql, int id, const char *text,
                            const struct srv_value value[], int count);
    /** Whether so many bytes of results may be written, and small things after them; NULL = it
     * may be tried. */
    int (*room)(struct srv_sql *sql, size_t bytes);
    /** As srv_store_listen. */
    int (*listen)(struct srv_sql *sql, int timeout_ms, int wake);
};

extern const struct srv_sql_driver srv_sql_sqlite, srv_sql_postgres;

/** Keeps the first line of a message of the database. */
void srv_sql_complain(struct srv_sql *sql, const char *text);

/** The letters of the types of a statement on rows of values, up to a "}"; NULL where it is none.
 */
const char *srv_sql_columns(const char *text);

/**
 * Writes a statement in a driver's dialect.
 *
 * out  room for SRV_SQL_TEXT; longer is a bug of ours.
 */
void srv_sql_spell(const struct srv_sql_driver *driver, const char *text, char out[SRV_SQL_TEXT]);

#endif
