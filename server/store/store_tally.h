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

#include "server/store/store.h"
#include "server/store/store_statements.h"

enum {
    SRV_TALLY_CLIENTS = 640, /* in one transaction */
    SRV_TALLY_PLACES = 64    /* rows of totals, so that processes do not wait for one row */
};

/* What is kept for one client. */
struct srv_tally_client {
    char name[SRV_NAME_BYTES];
    char
        source[SRV_NAME_BYTES]; /* the address or account that it comes from; "" = not known here */
    int known;                  /* `jobs_were` and what follows it were read */
    int64_t jobs_were, bytes_were; /* before this transaction */
    int64_t scenes_were, scene_bytes_were;
    int64_t jobs, ready, turn,
        bytes; /* changes: open jobs, jobs of which a part can be claimed, turns, bytes kept */
    int64_t scenes, scene_bytes; /* changes */
    int64_t weight; /* turns that a claim of its jobs counts for, where `source` is known */
};

/* The changes of one transaction; begins as {0}. */
struct srv_tally {
    int count, known;
    int ring;                    /* whom to wake: bits of SRV_RING_ */
    int place;                   /* this connection's row of the totals; stays */
    char source[SRV_NAME_BYTES]; /* the one that was read last; "" = none was */
    int64_t source_clients, source_jobs, source_bytes; /* of it, before this transaction */
    int64_t source_open;           /* clients of it with open jobs, before this transaction */
    struct srv_store_figures were; /* once known: before this transaction */
    struct srv_store_figures change;
    struct srv_tally_client client[SRV_TALLY_CLIENTS];
};

/** True where there are changes of at most SRV_TALLY_CLIENTS clients and the client that was added
 * last is among them once. O(clients). */
int srv_tally_valid(const struct srv_tally *tally);

/** Forgets all changes: the transaction was rolled back, or has ended. */
void srv_tally_clear(struct srv_tally *tally);

/** The changes of a client; NULL when the transaction has too many clients. */
struct srv_tally_client *srv_tally_client(struct srv_tally *tally, const char *name);

/**
 * Counts the sums of the client `name` anew from its rows. The client's row is locked by a
 * statement of its own first:
 * the rows are then counted as they are once everybody has committed who had changed these sums, so
 * that no change is lost or counted twice. O(rows of the client); for sums that are damaged or out
 * of step.
 */
enum srv_stored srv_tally_count_anew(struct srv_sql *sql, const char *name);

/** As srv_tally_client, and reads what there was before. SRV_STORED_AGAIN when the transaction
 * has too many clients. */
enum srv_stored srv_tally_look(struct srv_tally *tally, struct srv_sql *sql, const char *name,
                               struct srv_tally_client **client);

/** Reads all totals: those of before, and of this transaction. Totals that cannot have been
 * counted are counted anew, O(all that is kept). */
enum srv_stored srv_tally_totals(struct srv_tally *tally, struct srv_sql *sql,
                                 struct srv_store_figures *figures);

/**
 * What all clients of an address or account have: clients with jobs, open jobs, bytes; of before,
 * and of this transaction. O(clients of it).
 */
enum srv_stored srv_tally_source(struct srv_tally *tally, struct srv_sql *sql, const char *source,
                                 int64_t *clients, int64_t *jobs, int64_t *bytes);

/** Writes the changes, and on SQLite wakes other processes. */
enum srv_stored srv_tally_write(struct srv_tally *tally, struct srv_sql *sql);

#endif
