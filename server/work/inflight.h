/* Computations under way, called works: the exchanges that wait for each, exchanges that join one,
 * and the two blocks between a computation and the reader of its stream.
 * Leaves to others: computing (compute), suspending and resuming a connection (http).
 * Invariant: one lock guards every field of a computation that several threads use; a computation
 * is freed when no worker, queue or reader has it. */
#pragma once

#include "api/call/call.h"
#include "server/base/hash_table.h"
#include "server/work/exchange.h"

enum {
    SRV_INFLIGHT_BLOCK = 1 << 18, /* bytes that may be queued while as many are being sent */
    SRV_INFLIGHT_KEY = 72
};

struct srv_work {
    struct srv_task task; /* first: a task converts to its computation */
    struct srv_service *service;
    struct srv_client *account; /* the client that pays for it */

    /* the limits for the operation */
    const struct api_limits *limits;
    struct srv_source *source; /* source of a stored answer; NULL = it is computed */
    struct api_call *call;
    struct api_buffer out;   /* output of the call */
    struct api_buffer coded; /* output of the coding */
    void *coder;             /* state of a stream's coding; NULL = uncoded */
    enum srv_coding coding;
    double cost;                  /* s, estimated */
    int64_t queued, begun, spent; /* ns: time queued, time started, duration on workers */
    char etag[SRV_ETAG_BYTES];    /* as in the header field; "" before it is known */
    char key[SRV_INFLIGHT_KEY];   /* key in the cache and in the table of computations */
    size_t key_bytes;
    struct srv_hold hold; /* memory held and reserved */
    size_t foreseen;      /* expected bytes of out, coded and ready */
    size_t ready_cap;     /* bytes of `ready`, as last seen by the worker */
    int promised;         /* the response is a stream */

    /* under the lock */
    struct srv_list waiters; /* exchanges, first come first */
    int opened;              /* the request was read; the exchange only waits for its answer */
    enum srv_stop stop;      /* reason to stop */
    int listed;
    struct srv_hash_node node;   /* by `key`, while it is listed */
    struct srv_exchange *reader; /* of the stream */
    int reader_waits;            /* suspended, until the next block */
    int parked;                  /* the computation waits for its reader */
    int fetching;                /* the computation waits for its source */
    int over;                    /* neither a worker nor the queue has it */
    int ended;                   /* 1 = complete, -1 = broken */
    struct api_buffer ready;     /* the block that is being sent */
    size_t taken;                /* bytes of that block already sent */
};

/* Results of srv_inflight_read other than a number of bytes. */
enum { SRV_INFLIGHT_WAIT = 0, SRV_INFLIGHT_END = -1, SRV_INFLIGHT_BROKEN = -2 };

struct srv_inflight;

/** PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status srv_inflight_new(struct srv_inflight **inflight);

/** Frees the computations; none may be under way. */
void srv_inflight_free(struct srv_inflight **inflight);

/** Creates a computation for an exchange, which waits for it. Returns NULL if memory is short. */
struct srv_work *srv_inflight_begin(struct srv_exchange *exchange);

/** Frees a computation without waiting exchanges that no worker, queue or reader has. */
void srv_inflight_end(struct srv_work *work);

/** Returns true if the fields of a computation that several threads use are consistent; for
 * assertions, under the lock. O(1). */
int srv_inflight_valid(const struct srv_work *work);

/**
 * Reports that the request was read. The computation's key must be set.
 *
 * Returns 1 if another computation has the same result: the exchange then waits for that one, and
 * the caller ends its own. Otherwise returns 0, and other exchanges may join this computation.
 */
int srv_inflight_opened(struct srv_work *work);

/** Returns the reason why the computation should stop. */
enum srv_stop srv_inflight_stop(struct srv_work *work);

/** Removes and returns the first exchange of a list from srv_inflight_take; NULL if it is empty. */
void srv_inflight_take(struct srv_work *work, struct srv_list *taken);

/** Removes and returns the first exchange of such a list; NULL if it is empty. */
struct srv_exchange *srv_inflight_next(struct srv_list *taken);

/**
 * Removes an exchange from its work or stream.
 *
 * detached  out: 1 if the caller must call the exchange's `finish`, and answer it unless it reads a
 *           stream; 0 if the worker does, or if the connection does not wait for it.
 *
 * Returns the computation if no exchange is left and no worker has it: then the caller ends it.
 * Otherwise the worker stops it.
 */
struct srv_work *srv_inflight_leave(struct srv_exchange *exchange, enum srv_stop why,
                                    int *detached);

/** Returns why the client of an exchange without a computation no longer waits, or SRV_GO_ON. Any
 * thread, until the exchange's `finish` is called. */
enum srv_stop srv_inflight_left(const struct srv_exchange *exchange);

/* --- streams --- */

/**
 * Makes the exchange that has waited longest the reader; it is suspended until its `finish` is
 * called, even if it leaves.
 *
 * others  out: the other exchanges are appended, as by srv_inflight_take.
 *
 * Returns the reader, NULL if no exchange waits.
 */
struct srv_exchange *srv_inflight_stream(struct srv_work *work, struct srv_list *others);

/** Returns the number of exchanges that wait for a computation. */
int srv_inflight_waiters(struct srv_work *work);

/** Returns true if the reader has no bytes to send now. */
int srv_inflight_hungry(struct srv_work *work);

/**
 * Passes the bytes that a computation has appended to its reader. Called by the worker that has the
 * computation. ended  0 = more will come, 1 = that was all, -1 = the rest is missing.
 *
 * over   out: 1 if the computation has ended.
 *
 * Returns 1 if the worker should continue. Otherwise the worker no longer owns the computation: it
 * waits for its reader, or has ended and may be freed.
 */
int srv_inflight_pass(struct srv_work *work, int ended, int *over);

/** Suspends a computation until its source is ready. Returns 1 if it is suspended: the worker no
 * longer owns it, and another thread may end it. Returns 0 if the computation should stop: the
 * worker continues. */
int srv_inflight_park(struct srv_work *work);

/** Queues a computation suspended by srv_inflight_park; no effect if it is not suspended any more.
 * Any thread; the computation must not have ended. */
void srv_inflight_unpark(struct srv_work *work);

/**
 * Takes bytes of a stream. Called on the sockets' thread.
 *
 * pause  called under the lock if there are no bytes: suspends the connection, which the exchange's
 *        finish resumes.
 *
 * Returns their number, SRV_INFLIGHT_WAIT after pause, SRV_INFLIGHT_END or SRV_INFLIGHT_BROKEN.
 * O(cap).
 */
long srv_inflight_read(struct srv_exchange *exchange, char *to, size_t cap,
                       void (*pause)(struct srv_exchange *));

/** Copies the statistics of a stream's computation, after srv_inflight_read returned
 * SRV_INFLIGHT_END; nothing before. */
void srv_inflight_stat_fields(struct srv_exchange *exchange, struct api_stats_headers *stat_fields);
