/* The threads that call the store, so that no other thread waits for a disk or a database.
 * Leaves to others: the questions (store's calls), the use of the answers (the asker's `done`).
 * Invariant: a call that was accepted comes back through its `done`, once; addresses and clients
 * take turns, and the calls of one client that write are run in the order in which they came if
 * there is one writer. */
#ifndef SRV_STORAGE_H
#define SRV_STORAGE_H

#include "server/base/log.h"
#include "server/base/turns.h"
#include "server/store/store.h"

enum srv_ask_kind {
    SRV_ASK_WRITE, /* changes something */
    SRV_ASK_READ,  /* does not, and need not see what is being written */
    SRV_ASK_KINDS
};

/* Who asks: a client. Begins as {0}; it may go while none of its questions waits. */
struct srv_asker {
    struct {
        struct srv_turns_lane lane; /* its questions that wait */
        struct srv_turns_road road; /* those of all whose origin it is */
    } at[SRV_ASK_KINDS];
    struct srv_asker *origin; /* its address; NULL = itself */
};

/* A question to the store. It lies inside its owner's structure, so that asking allocates
 * nothing. */
struct srv_ask {
    struct srv_store_call call; /* first: run and, afterwards, stored */
    void (*done)(
        struct srv_ask *ask); /* on a thread of the storage: short, may end the ask's life */
    struct srv_asker *asker;  /* whose turn it takes; NULL = the process's own */
    struct srv_list link;     /* the storage's */
};

struct srv_storage;

/**
 * Opens the store and starts the threads.
 *
 * storage  out; NULL on failure.
 * news     called on a thread of the storage whenever there may be something to claim or to stop,
 *          by whomever, and when the store has come back, with bits of SRV_RING_; short.
 * log      hears when the store is lost, and when it is back; outlives the storage.
 * error    the sentence for the operator.
 *
 * As srv_store_open, and PEND_NO_MEMORY when threads cannot be had. A database that cannot be
 * reached is waited for.
 */
PEND_MUST_CHECK enum pend_status srv_storage_new(struct srv_storage **storage, const char *url,
                                                 const struct srv_store_rules *rules,
                                                 struct srv_log *log,
                                                 void (*news)(void *context, int rings),
                                                 void *context, struct pend_error *error);

/** Waits until all calls are answered, then ends the threads and closes the store. */
void srv_storage_free(struct srv_storage **storage);

/** Queues a call for a thread of the storage. Any thread; does not wait. Calls that are queued at
 * the same time share a write to disk. */
void srv_storage_ask(struct srv_storage *storage, enum srv_ask_kind kind, struct srv_ask *ask);

/** Asks and waits for the answer; `done` is not called. Only for threads that may wait: neither
 * libmicrohttpd's nor a worker's. */
enum srv_stored srv_storage_wait(struct srv_storage *storage, enum srv_ask_kind kind,
                                 struct srv_ask *ask);

/** Returns true while the store answers. */
int srv_storage_here(const struct srv_storage *storage);

/** Returns false if the store cannot notify other processes; callers must poll. */
int srv_storage_hears(const struct srv_storage *storage);

/** Returns figures that are about a second old. */
struct srv_store_figures srv_storage_figures(struct srv_storage *storage);

#endif
