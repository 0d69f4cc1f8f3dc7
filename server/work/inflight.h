/* Computations under way, which are called works: the exchanges that wait for each, exchanges that
 * join one, and the two blocks between a work and the reader of its stream.
 * Leaves to others: computing (compute), suspending and resuming a connection (http).
 * Invariant: one lock guards every field of a work that several threads use; a work is freed when
 * no worker, queue or reader has it. */
#ifndef SRV_INFLIGHT_H
#define SRV_INFLIGHT_H

#include "api/call/call.h"
#include "server/base/hash_table.h"
#include "server/work/exchange.h"

enum {
    SRV_INFLIGHT_BLOCK = 1 << 18, /* bytes that may wait while as many are being sent */
    SRV_INFLIGHT_KEY = 72
};

struct srv_work {
    struct srv_task task; /* first: a task is its work */
    struct srv_service *service;
    struct srv_client *account; /* on whose account it is */

    /* the worker's that runs it */
    const struct api_limits *limits;
    struct srv_source *source; /* of an answer that lies somewhere already; NULL = it is computed */
    struct api_call *call;
    struct api_buffer out;   /* of the call */
    struct api_buffer coded; /* what the coding made of it */
    void *coder;             /* of a stream; NULL = as it is */
    enum srv_coding coding;
    double cost;                  /* s, estimated */
    int64_t queued, begun, spent; /* ns: when, when, how long on workers */
    char etag[SRV_ETAG_BYTES];    /* as the header field; "" before it is known */
    char key[SRV_INFLIGHT_KEY];   /* of the cache and of the computations in flight */
    size_t key_bytes;
    struct srv_hold hold; /* what it holds, and was promised */
    size_t foreseen;      /* bytes that out, coded and ready will come to */
    size_t ready_cap;     /* bytes of `ready`, as the worker saw it last */
    int promised;         /* it is a stream */

    /* under the lock */
    struct srv_list waiters; /* exchanges, first come first */
    int opened; /* the request was read: its exchange is not needed for more than its answer */
    enum srv_stop stop; /* why not to go on */
    int listed;
    struct srv_hash_node node;   /* by `key`, while it is listed */
    struct srv_exchange *reader; /* of the stream */
    int reader_waits;            /* suspended, for the next block */
    int parked;                  /* it waits for its reader */
    int fetching;                /* it waits for its source */
    int over;                    /* no worker and no queue has it any more */
    int ended;                   /* 1 = complete, -1 = broken */
    struct api_buffer ready;     /* the block that is being sent */
    size_t taken;                /* bytes of it that were */
};

/* What srv_inflight_read returns beside a number of bytes. */
enum { SRV_INFLIGHT_WAIT = 0, SRV_INFLIGHT_END = -1, SRV_INFLIGHT_BROKEN = -2 };

struct srv_inflight;

/** PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status srv_inflight_new(struct srv_inflight **inflight);

/** Frees it; no computation may be under way. */
void srv_inflight_free(struct srv_inflight **inflight);

/** Makes a work for an exchange, which waits for it. Returns NULL without memory. */
struct srv_work *srv_inflight_begin(struct srv_exchange *exchange);

/** Frees a work for which no exchange waits, and which no worker, queue or reader has. */
void srv_inflight_end(struct srv_work *work);

/** True when the fields of a work that several threads touch agree with each other; for
 * assertions, under the lock. O(1). */
int srv_inflight_valid(const struct srv_work *work);

/**
 * Says that the request was read. Its key is set.
 *
 * Returns 1 if another work computes the same: the exchange waits for that one from now on, and the
 * caller ends this one. Else returns 0, and other exchanges may join this work.
 */
int srv_inflight_opened(struct srv_work *work);

/** Why the work is not to go on. */
enum srv_stop srv_inflight_stop(struct srv_work *work);

/** Moves all who wait for a work, which nobody can join any more, to a list of the caller's: first
 * come first. */
void srv_inflight_take(struct srv_work *work, struct srv_list *taken);

/** Takes the first exchange out of such a list; NULL where it is empty. */
struct srv_exchange *srv_inflight_next(struct srv_list *taken);

/**
 * Takes an exchange away from its work or stream.
 *
 * detached  out: 1 if the caller is to call the exchange's finish, and to answer it unless it reads
 *           a stream; 0 if the worker does, or did, or the connection does not wait for that.
 *
 * Returns the work if no exchange is left and no worker has it: then the caller ends it. A work
 * that a worker has is stopped by that worker.
 */
struct srv_work *srv_inflight_leave(struct srv_exchange *exchange, enum srv_stop why,
                                    int *detached);

/** Why an exchange is not waited for any more, SRV_GO_ON where it is: of one that has no work, as
 * srv_inflight_stop for one that has. Any thread, until its finish is called. */
enum srv_stop srv_inflight_left(const struct srv_exchange *exchange);

/* --- streams --- */

/**
 * Makes the one who waits longest the reader; it is suspended until its finish is called, even if
 * it leaves.
 *
 * others  the others are appended to it, as by srv_inflight_take.
 *
 * Returns the reader, NULL where nobody waits.
 */
struct srv_exchange *srv_inflight_stream(struct srv_work *work, struct srv_list *others);

/** The number of exchanges that wait for a work. */
int srv_inflight_waiters(struct srv_work *work);

/** True when the reader has no bytes to send now. */
int srv_inflight_hungry(struct srv_work *work);

/**
 * Hands the bytes that a work has appended to its reader. Called by the worker that has the work.
 *
 * ended  0 = more will come, 1 = that was all, -1 = the rest is missing.
 *
 * over   out: 1 if the work has ended.
 *
 * Returns 1 when the worker is to go on. Else the work is not the worker's any more: it waits for
 * its reader, or has ended and may be freed.
 */
int srv_inflight_pass(struct srv_work *work, int ended, int *over);

/**
 * Lets a work rest until its source is ready. Returns 1 if it rests: the work is not the worker's
 * any more, and another thread may end it. Returns 0 if the work is to stop: the worker goes on.
 */
int srv_inflight_park(struct srv_work *work);

/** Queues a work that rests since srv_inflight_park; does nothing if it does not rest any more. Any
 * thread; the work must not have ended. */
void srv_inflight_unpark(struct srv_work *work);

/**
 * Takes bytes of a stream. Called on the sockets' thread.
 *
 * pause  called under the lock if there are no bytes: suspends the connection, which the exchange's
 *        finish resumes.
 *
 * Returns how many, SRV_INFLIGHT_WAIT after pause, SRV_INFLIGHT_END or SRV_INFLIGHT_BROKEN. O(cap).
 */
long srv_inflight_read(struct srv_exchange *exchange, char *to, size_t cap,
                       void (*pause)(struct srv_exchange *));

/** What is told of a stream's computation, copied, once srv_inflight_read came to
 * SRV_INFLIGHT_END; nothing before. */
void srv_inflight_stat_fields(struct srv_exchange *exchange, struct api_stats_headers *stat_fields);

#endif
