/* The changes of a transaction in the stored sums, of each client and of all.
 * Leaves to others: quotas (store_quotas), the transaction (store_call).
 * Invariant: sums are written once per transaction, as its last writes, clients in the order of
 * their names and then the totals. Transactions therefore lock rows in one order, and only briefly.
 * On PostgreSQL a transaction that adds no open and no claimable job (a claim, the end of a part)
 * changes no client's row: it inserts a row into `changes`, which is added to the client's row
 * later. Workers therefore do not wait for each other, and a client's row never shows too few open
 * jobs. */
#pragma once

#include "server/store/store_rows.h"
#include "server/store/sql.h"

enum {
    SRV_TALLY_CLIENTS = 640, /* maximum number of clients per transaction */
    SRV_TALLY_PLACES = 64    /* rows of totals, so that processes rarely wait for the same row */
};

/* The sums of all clients: jobs of each enum srv_job_state, then these. */
enum {
    SRV_TALLY_PARTS = SRV_JOB_STATES, /* claimable parts */
    SRV_TALLY_BYTES,                  /* bytes of jobs */
    SRV_TALLY_SCENES,
    SRV_TALLY_SCENE_BYTES,
    SRV_TALLY_SUMS
};

/* The sums of one client. */
struct srv_tally_client {
    char name[SRV_NAME_BYTES];
    char source[SRV_NAME_BYTES]; /* address or account of the client; "" = unknown */
    int known;                   /* `jobs_were` and the following members are read */
    int64_t jobs_were, bytes_were, scenes_were, scene_bytes_were; /* before this transaction */
    /* changes: open jobs, jobs with claimable parts, turns, bytes, scenes */
    int64_t jobs, ready, turn, bytes, scenes, scene_bytes;
    int64_t weight; /* turns per claim of its jobs, if `source` is known */
};

/* The changes of one transaction; initialized with {.sql, .place}. */
struct srv_tally {
    struct srv_sql *sql;
    int place; /* the connection's row of the totals */
    int count, known;
    int ring;                    /* notifications: SRV_RING_ bits */
    char source[SRV_NAME_BYTES]; /* the source whose sums were last read; "" = none */
    int64_t source_clients, source_jobs,
        source_bytes;                /* sums of `source` before this transaction */
    int64_t source_open;             /* its clients with open jobs before this transaction */
    int64_t were[SRV_TALLY_SUMS];    /* before this transaction, if known */
    int64_t changes[SRV_TALLY_SUMS]; /* changes of the sums of all clients */
    struct srv_tally_client client[SRV_TALLY_CLIENTS];
};

/** Returns the changes of a client. SRV_STORED_AGAIN if the transaction has too many clients. */
enum srv_stored srv_tally_client(struct srv_tally *tally, const char *name,
                                 struct srv_tally_client **client);

/** Recounts the sums of client `name` from its rows, for damaged or inconsistent sums; this
 * transaction's changes of them must be written. A separate statement locks the client's row first,
 * so that the count sees all transactions that changed these sums, and no change is lost or counted
 * twice. O(rows of the client). */
enum srv_stored srv_tally_count_anew(struct srv_tally *tally, const char *name);

/** Recounts the sums of all clients, including this transaction's writes. O(all stored rows). */
enum srv_stored srv_tally_count_all(struct srv_tally *tally);

/** As srv_tally_client, and reads the sums before this transaction. */
enum srv_stored srv_tally_look(struct srv_tally *tally, const char *name,
                               struct srv_tally_client **client);

/** Returns a sum of all clients, including this transaction. An impossible sum is recounted,
 * O(all stored rows). */
enum srv_stored srv_tally_total(struct srv_tally *tally, int which, int64_t *sum);

/** Returns the sums of all clients of an address or account, including this transaction: clients
 * with jobs, open jobs, bytes. O(clients of the source). */
enum srv_stored srv_tally_source(struct srv_tally *tally, const char *source, int64_t *clients,
                                 int64_t *jobs, int64_t *bytes);

/** Writes the changes; on SQLite also notifies other processes. */
enum srv_stored srv_tally_write(struct srv_tally *tally);

enum { SRV_SCHEMA = 1 }; /* the schema version of this program */

/**
 * Creates the tables if they do not exist.
 *
 * SRV_STORED_BROKEN  they have another version; the connection's complaint says so.
 * SRV_STORED_AWAY    the database is unreachable.
 */
enum srv_stored srv_schema_settle(struct srv_sql *sql);

/** Sets the complaint that the tables have another version. Returns SRV_STORED_BROKEN. */
enum srv_stored srv_schema_other(struct srv_sql *sql, int64_t version);
