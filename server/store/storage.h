/* The threads that access the store, so that no other thread waits for a disk or a database.
 * Leaves to others: the queries (calls of the store), the use of the results (`done`).
 * Invariant: `done` of an accepted query is called exactly once; addresses and clients take turns;
 * with one writer, the writes of a client run in order. */
#pragma once

#include "server/base/log.h"
#include "server/base/turns.h"
#include "server/store/store.h"

enum srv_ask_kind {
    SRV_ASK_WRITE, /* writes */
    SRV_ASK_READ,  /* reads, and need not see concurrent writes */
    SRV_ASK_FILE,  /* uses files of results, on a thread without a store: `run` receives NULL */
    SRV_ASK_KINDS
};

/* A client that queries the store. Initialized with {0}; can be freed while none of its queries
 * waits. */
struct srv_asker {
    struct {
        struct srv_turns_lane lane; /* the client's waiting queries */
        struct srv_turns_road road; /* the queries of all clients with this origin */
    } at[SRV_ASK_KINDS];
    struct srv_asker *origin; /* the client's address; NULL = the client itself */
};

/* A query to the store. It is part of its owner's struct, so that queueing allocates nothing. */
struct srv_ask {
    struct srv_store_call call; /* first: `run`, and afterwards `stored` */
    void (*done)(
        struct srv_ask *ask); /* called on a storage thread; must be short; may free the query */
    struct srv_asker *asker;  /* the client whose turn it takes; NULL = the process itself */
    struct srv_list link;     /* used by the storage */
};

struct srv_storage;

/**
 * Opens the store and starts the threads.
 *
 * storage  out; NULL on failure.
 * news     called on a storage thread with SRV_RING_ bits after a notification, and when the store
 *          is reachable again; must be short.
 * log      receives a line when the store becomes unreachable or reachable; must outlive the
 *          storage.
 * error    the sentence for the operator.
 *
 * As srv_store_open; also PEND_NO_MEMORY if threads cannot be created. An unreachable database is
 * retried.
 */
PEND_MUST_CHECK enum pend_status srv_storage_new(struct srv_storage **storage, const char *url,
                                                 const struct srv_store_rules *rules,
                                                 struct srv_log *log,
                                                 void (*news)(void *context, int rings),
                                                 void *context, struct pend_error *error);

/** Waits until all queries are answered, then ends the threads and closes the store. */
void srv_storage_free(struct srv_storage **storage);

/** Queues a query. Any thread; does not wait. Queries that are queued together share a sync to
 * disk. */
void srv_storage_ask(struct srv_storage *storage, enum srv_ask_kind kind, struct srv_ask *ask);

/** Runs a query and waits for its result; `done` is not called. Only for threads that may block,
 * not for libmicrohttpd's and the workers. */
enum srv_stored srv_storage_wait(struct srv_storage *storage, enum srv_ask_kind kind,
                                 struct srv_ask *ask);

/** Returns true while the store is reachable. */
int srv_storage_here(const struct srv_storage *storage);

/** Returns false if the store cannot notify other processes; callers must poll. */
int srv_storage_hears(const struct srv_storage *storage);

/** Returns figures that are about a second old. */
struct srv_store_figures srv_storage_figures(struct srv_storage *storage);
