/* An exchange whose answer needs a query to the store, preceded by a worker if its body must be
 * parsed: the common part of the routes of jobs and scenes.
 * Leaves to others: the query and the answer (jobs, job_results, scenes).
 * Invariant: the finish of every exchange is called exactly once, and not before the store has
 * answered. */
#pragma once

#include "server/work/exchange.h"

enum { SRV_STORE_REQUEST_KEY = 80 };

/* Words for a route's problems. */
struct srv_store_request_words {
    const char *many;  /* plural of the stored things: "jobs" */
    const char *again; /* advice for a client that does not know whether the thing was stored */
};

struct srv_store_request {
    struct srv_ask ask; /* first, because a query is converted to its store request */
    struct srv_task task;
    const struct srv_store_request_words *words;
    struct srv_exchange *exchange;
    struct srv_service *service;
    int (*check)(struct srv_store_request *asked);
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call);
    int reads; /* a read-only query, which is skipped if the client has left */
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored);
    char id[SRV_ID_BYTES];
    struct srv_job job;

    /* for a new job */
    char key[SRV_STORE_REQUEST_KEY + 1]; /* "" = none */
    char title[SRV_TITLE_BYTES];         /* "" = none */
    unsigned char digest[SRV_DIGEST_BYTES];
    long parts;
    int chained;
    int64_t cost_us;        /* estimated time of computation */
    struct srv_hold hold;   /* memory of parsing the request, then of the stored body */
    struct api_buffer body; /* the request in its stored form */

    /* for a job's results */
    void *request;
    size_t request_bytes;

    /* for an erasure */
    const char *client; /* the client whose data are erased */
    int count;          /* rows erased by the last query */
    int piece;          /* maximum number of rows per query */

    /* for a scene */
    struct api_buffer scene; /* the scene to store */
    void *kept;              /* the stored scene */
    size_t kept_bytes;

    /* for other routes: their own state, and the function that frees it */
    void *more;
    void (*more_free)(void *more);
};

extern const struct srv_store_request_words srv_store_request_jobs;

/** Creates a store request for an exchange. Returns NULL if that is not possible: the exchange is
 * answered, and its finish was called. */
struct srv_store_request *srv_store_request_begin(struct srv_exchange *exchange,
                                                  const struct srv_store_request_words *words);

/** Creates a store request for the job that the path names. Returns NULL as
 * srv_store_request_begin, also if the id is malformed. */
struct srv_store_request *srv_store_request_begin_one(struct srv_exchange *exchange);

/**
 * Queues a query to the store; clients take turns. A read-only query is skipped if the client has
 * left: its result is then SRV_STORED_AGAIN.
 *
 * answer  called on a storage thread; ends the store request, or submits another query.
 */
void srv_store_request_ask(struct srv_store_request *asked, enum srv_ask_kind kind,
                           enum srv_stored (*run)(struct srv_store *store,
                                                  struct srv_store_call *call),
                           void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/**
 * Lets a worker parse the request, then a storage thread store it.
 *
 * check   called by a worker; returns 1 to continue with `run`, else it has answered the exchange.
 * run     the query; it writes.
 * answer  as in srv_store_request_ask.
 *
 * If the queue is full the exchange is answered, and its finish was called.
 */
void srv_store_request_work(
    struct srv_store_request *asked, int (*check)(struct srv_store_request *asked),
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/** A query: reads the job with request->id into request->job. */
enum srv_stored srv_store_request_find(struct srv_store *store, struct srv_store_call *call);

/** Answers with the problem for a result of the store, in the words for jobs. */
void srv_store_request_refuse(struct srv_store_request *asked, enum srv_stored stored);

/** Calls the finish of the answered exchange, and frees the store request. */
void srv_store_request_end(struct srv_store_request *asked);

/** Frees the store request; the exchange's new owner will call its finish. */
void srv_store_request_leave(struct srv_store_request *asked);

/* The characters of an id. */
extern const char srv_store_request_letters[];

/** Returns true for a well-formed id. */
int srv_store_request_id_good(const char *id);
