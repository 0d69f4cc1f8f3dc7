/* What a transaction changes in the sums that the store keeps: of each client, and of all.
 * Leaves to others: when a sum is too large (store_quotas), the transaction (store_call).
 * Invariant: sums are written once a transaction, as its last writes, clients in the order of
 * their names and then the totals: so transactions of several processes wait for each other in
 * one order only, and not for long. On PostgreSQL a transaction that adds no open job and no job
 * that can be claimed, as a claim or the end of a part, changes no client's row: it inserts a row
 * into `changes`, which is folded into the client's later. So transactions of many workers do not
 * wait for each other, and a client's row never has fewer open jobs than there are. */
#ifndef SRV_STORE_TALLY_H
#define SRV_STORE_TALLY_H

#include "server/store/store_rows.h"

enum {
    SRV_TALLY_CLIENTS = 640, /* in one transaction */
    SRV_TALLY_PLACES = 64    /* rows of totals, so that processes do not wait for one row */
};

/* The sums of all: jobs of each enum srv_job_state, and: */
enum {
    SRV_TALLY_PARTS = SRV_JOB_STATES, /* that can be claimed */
    SRV_TALLY_BYTES,                  /* kept for jobs */
    SRV_TALLY_SCENES,
    SRV_TALLY_SCENE_BYTES,
    SRV_TALLY_SUMS
};

/* What is kept for one client. */
struct srv_tally_client {
    char name[SRV_NAME_BYTES];
    char source[SRV_NAME_BYTES]; /* its address or account; "" = not known here */
    int known;                   /* `jobs_were` and what follows it were read */
    int64_t jobs_were, bytes_were, scenes_were, scene_bytes_were; /* before this transaction */
    /* changes: open jobs, jobs of which a part can be claimed, turns, bytes kept, scenes */
    int64_t jobs, ready, turn, bytes, scenes, scene_bytes;
    int64_t weight; /* turns that a claim of its jobs counts for, where `source` is known */
};

/* The changes of one transaction; begins as {.sql, .place}. */
struct srv_tally {
    struct srv_sql *sql;
    int place; /* this connection's row of the totals */
    int count, known;
    int ring;                    /* whom to wake: bits of SRV_RING_ */
    char source[SRV_NAME_BYTES]; /* the one that was read last; "" = none was */
    int64_t source_clients, source_jobs, source_bytes; /* of it, before this transaction */
    int64_t source_open;             /* clients of it with open jobs, before this transaction */
    int64_t were[SRV_TALLY_SUMS];    /* once known: before this transaction */
    int64_t changes[SRV_TALLY_SUMS]; /* of the sums of all */
    struct srv_tally_client client[SRV_TALLY_CLIENTS];
};

/** True where there are changes of at most SRV_TALLY_CLIENTS clients and the client that was added
 * last is among them once. O(clients). */
int srv_tally_valid(const struct srv_tally *tally);

/** Forgets all changes: the transaction was rolled back, or has ended. */
void srv_tally_clear(struct srv_tally *tally);

/** The changes of a client. SRV_STORED_AGAIN when the transaction has too many clients. */
enum srv_stored srv_tally_client(struct srv_tally *tally, const char *name,
                                 struct srv_tally_client **client);

/**
 * Counts the sums of the client `name` anew from its rows; what this transaction has changed of
 * them must be written. The client's row is locked by a statement of its own first: the rows are
 * then counted as they are once everybody has committed who had changed these sums, so that no
 * change is lost or counted twice. O(rows of the client); for sums that are damaged or out of step.
 */
enum srv_stored srv_tally_count_anew(struct srv_tally *tally, const char *name);

/** Counts the sums of all anew, with what this transaction has written so far. O(all that is kept)
 */
enum srv_stored srv_tally_count_all(struct srv_tally *tally);

/** As srv_tally_client, and reads what there was before. */
enum srv_stored srv_tally_look(struct srv_tally *tally, const char *name,
                               struct srv_tally_client **client);

/** A sum of all: of before, and of this transaction. One that cannot have been counted is counted
 * anew, O(all that is kept). */
enum srv_stored srv_tally_total(struct srv_tally *tally, int which, int64_t *sum);

/**
 * What all clients of an address or account have: clients with jobs, open jobs, bytes; of before,
 * and of this transaction. O(clients of it).
 */
enum srv_stored srv_tally_source(struct srv_tally *tally, const char *source, int64_t *clients,
                                 int64_t *jobs, int64_t *bytes);

/** Writes the changes, and on SQLite wakes other processes. */
enum srv_stored srv_tally_write(struct srv_tally *tally);

#endif
