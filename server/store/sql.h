/* The driver interface of a database: statements, rows, and the words that differ between dialects;
 * and rows of values for one statement as arrays in PostgreSQL's binary format (sql_list).
 * Leaves to others: the statements (store_statements), the libraries (store_sqlite,
 * store_postgres).
 * Invariant: a connection is used by one thread at a time; data from outside are passed as
 * parameters only; every column of a list has as many values as the list has rows. */
#pragma once

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
    SRV_STORED_NONE,    /* not found */
    SRV_STORED_CLASH,   /* the key or id is in use by another request */
    SRV_STORED_QUOTA,   /* a quota would be exceeded */
    SRV_STORED_LOST,    /* the lease expired, or the job ended; nothing was written */
    SRV_STORED_DAMAGED, /* the stored data are invalid; other data are unaffected */
    SRV_STORED_FULL,    /* the disk is full; nothing was written */
    SRV_STORED_AGAIN,   /* conflict with another process; nothing was written */
    SRV_STORED_AWAY,    /* the store is unreachable; whether the call took effect is unknown */
    SRV_STORED_BROKEN   /* the store is damaged or has an unknown version, or memory is short */
};

/* Returns from the function unless the result is SRV_STORED. */
#define SRV_STORED_TRY(call)                                                                       \
    do {                                                                                           \
        enum srv_stored stored_try_ = (call);                                                      \
        if (stored_try_ != SRV_STORED) return stored_try_;                                         \
    } while (0)

/* A parameter, or a field of a row. It does not own its data. */
struct srv_value {
    enum { SRV_SQL_NULL, SRV_SQL_WHOLE, SRV_SQL_STRING, SRV_SQL_BYTES } kind;
    int64_t whole;
    const void *data; /* a text ends with a NUL that is not included in `bytes` */
    size_t bytes;
};

/* A connection; the first member of a driver's own struct. */
struct srv_sql {
    const struct srv_sql_driver *driver;
    char complaint[SRV_SQL_COMPLAINT]; /* the database's message about the last failure, or
                                        * the limit that refused a scene */
};

/** Receives a row; its fields are valid during the call. Any result other than SRV_STORED ends the
 * statement with that result. */
typedef enum srv_stored srv_row_fn(void *context, const struct srv_value field[]);

/* The roles of a connection's process, bits; 0 = unknown. */
enum {
    SRV_SQL_WORKS = 1,   /* the process computes parts of jobs */
    SRV_SQL_ANSWERS = 2, /* the process answers requests; worker processes leave it connections */
    SRV_SQL_BESIDE = 4   /* an additional connection of its process */
};

/* The recipients of a notification, bits. */
enum {
    SRV_RING_WORK = 1, /* workers: a part can be claimed */
    SRV_RING_STOP = 2, /* workers: a job whose parts they hold may have ended */
    SRV_RING_ENDS = 4, /* api processes: a job or a classroom has changed */
    SRV_RING_ALL = 7
};

struct srv_sql_driver {
    const char *scheme; /* prefix of urls: "sqlite:" */
    int batch;          /* useful number of calls per transaction */
    int distant;        /* the database is a server, which may be unreachable for a while */
    int shared;         /* several processes may write at the same time */
    /* The dialect's text for:
     * {begin};
     * {now}: microseconds since 1970 by the database's clock;
     * {lock}, {skip}: locks the rows read; waits for rows locked by others, or skips them;
     * {alone}: one process at a time creates tables;
     * {ring}: notifies all listening processes after the commit; {ring work}, {ring stop}: only
     * workers;
     * {crowd}: processes that compute, and connections of all processes;
     * {carries}: the limit of connections, and the worker processes supported besides an api
     * process; {bytes}: the type of byte strings; {hot}: options of a table whose few rows change
     * in every transaction. */
    const struct srv_sql_word { const char *token, *text; } * words; /* ends with a null token */
    /* Non-zero: the driver runs a statement for many rows of values at once. Such a statement has
     * {1}, {2}, ... for a row's values, and one of {from twb}, {using twb} and {beside twb} where
     * it lists the rows among its tables, with a letter for each value's type: t text, w integer, b
     * bytes. Other drivers run it row by row on $1, $2, ... */
    int lists;

    /**
     * Connects. If the database is unreachable, the connection is in the same state as a lost one.
     *
     * PEND_INVALID, PEND_NO_MEMORY
     */
    enum pend_status (*open)(struct srv_sql **sql, const char *url, int role,
                             struct pend_error *error);
    void (*close)(struct srv_sql *sql);
    /**
     * Runs one statement.
     *
     * id     0 .. SRV_SQL_STATEMENTS - 1: prepared at its first use; -1: run once.
     * text   with $1, $2, ... for the values; only {begin} reconnects a lost connection.
     * row    called for every row; NULL = rows are ignored.
     *
     * A statement on rows of values includes the rows posted to it since the last `run`.
     *
     * SRV_STORED_FULL, SRV_STORED_AGAIN, SRV_STORED_AWAY, SRV_STORED_BROKEN
     */
    enum srv_stored (*run)(struct srv_sql *sql, int id, const char *text,
                           const struct srv_value value[], int count, srv_row_fn *row,
                           void *context);
    /**
     * As run, for a statement whose rows are ignored. It may return before the statement is
     * executed; the next `run` then reports its failure.
     *
     * text  also {look}: the following reads are separate transactions; reconnects a lost
     *       connection. Rows for a statement on rows of values are collected, and run before any
     *       other statement: no two of them may change the same row of a table.
     */
    enum srv_stored (*post)(struct srv_sql *sql, int id, const char *text,
                            const struct srv_value value[], int count);
    /** Non-zero if the disk has space for this many bytes of results and some small writes; NULL =
     * unknown. */
    int (*room)(struct srv_sql *sql, size_t bytes);
    /** As srv_store_listen. */
    int (*listen)(struct srv_sql *sql, int timeout_ms, int wake);
};

extern const struct srv_sql_driver srv_sql_sqlite, srv_sql_postgres;

/** Stores the first line of a message of the database. */
void srv_sql_complain(struct srv_sql *sql, const char *text);

/** The type letters of a statement on rows of values, up to a "}"; NULL for other statements. */
const char *srv_sql_columns(const char *text);

/**
 * Writes a statement in a driver's dialect.
 *
 * out  space for SRV_SQL_TEXT bytes; a longer text is a bug.
 */
void srv_sql_spell(const struct srv_sql_driver *driver, const char *text, char out[SRV_SQL_TEXT]);

/* Collected rows; initialized with {0}. */
struct srv_sql_list {
    const char *text;    /* the statement to run on the rows; NULL while the list is empty */
    const char *letters; /* the types of its columns, see srv_sql_columns */
    int rows, columns;
    struct srv_sql_column {
        char *data; /* header and elements of an array */
        size_t bytes, cap;
        int nulls; /* some element is NULL */
    } column[SRV_SQL_PARAMETERS];
};

/**
 * Adds a row; its values are copied. O(bytes of the values).
 *
 * text   a statement on rows of values, the same for every row of the list.
 * value  `count` values of the statement's types; count <= SRV_SQL_PARAMETERS.
 *
 * Returns 0 if memory is short; the list is then empty.
 */
int srv_sql_list_add(struct srv_sql_list *list, const char *text, const struct srv_value value[],
                     int count);

/**
 * Returns the columns as parameters of one statement, each an array in binary form.
 *
 * data, bytes  out, one for each column; borrowed, and valid until a row is added.
 */
void srv_sql_list_arrays(struct srv_sql_list *list, const char *data[], int bytes[]);

/** Removes all rows and keeps the memory for the next ones; srv_sql_list_free frees it. */
void srv_sql_list_empty(struct srv_sql_list *list);
void srv_sql_list_free(struct srv_sql_list *list);
