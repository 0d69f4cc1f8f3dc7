/* An exchange whose answer needs a question to the store, and a worker before that if its body is
 * to be read: what the routes of jobs and scenes have in common.
 * Leaves to others: the question and the answer (jobs, job_results, scenes).
 * Invariant: the finish of every exchange is called exactly once, and not before the store has
 * answered. */
#ifndef SRV_STORE_REQUEST_H
#define SRV_STORE_REQUEST_H

#include "server/work/exchange.h"

enum { SRV_STORE_REQUEST_KEY = 80 };

/* The words for what a route stores, in its problems. */
struct srv_store_request_words {
    const char *many;  /* "jobs" */
    const char *again; /* what a client may do that does not know whether it was stored */
};

struct srv_store_request {
    struct srv_ask ask; /* first: an ask is its store request */
    struct srv_task task;
    const struct srv_store_request_words *words;
    struct srv_exchange *exchange;
    struct srv_service *service;
    int (*check)(struct srv_store_request *asked);
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call);
    int reads; /* the question changes nothing: not asked for a client who has left */
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored);
    char id[SRV_ID_BYTES];
    struct srv_job job;

    /* of a new job */
    char key[SRV_STORE_REQUEST_KEY + 1]; /* "" = none */
    char title[SRV_TITLE_BYTES];         /* "" = none */
    unsigned char digest[SRV_DIGEST_BYTES];
    long parts;
    int chained;
    int64_t cost_us;        /* of computation, estimated */
    struct srv_hold hold;   /* of reading the request, then of what is kept */
    struct api_buffer body; /* the request as it is kept */

    /* of a job whose results are wanted */
    void *request;
    size_t request_bytes;

    /* of an erasure */
    const char *client; /* whose things go */
    int count;          /* of those that went, */
    int piece;          /* and of those that may go at once */

    /* of a scene */
    struct api_buffer scene; /* that is to be kept */
    void *kept;              /* the one that the store has */
    size_t kept_bytes;

    /* of another route: what it has beside this, and how that is freed */
    void *more;
    void (*more_free)(void *more);
};

extern const struct srv_store_request_words srv_store_request_jobs;

/** Makes a store request for an exchange. Returns NULL if that is not possible; the exchange is
 * answered then, and its finish was called. */
struct srv_store_request *srv_store_request_begin(struct srv_exchange *exchange,
                                                  const struct srv_store_request_words *words);

/** Makes a store request for the job that the path names. Returns NULL as srv_store_request_begin,
 * also if that cannot be the id of a job. */
struct srv_store_request *srv_store_request_begin_one(struct srv_exchange *exchange);

/**
 * Asks the store, in the client's turn. What changes nothing is not asked for a client who has
 * left: the answer is SRV_STORED_AGAIN then.
 *
 * answer  called on a thread of the storage; ends the store request, or asks another question.
 */
void srv_store_request_ask(struct srv_store_request *asked, enum srv_ask_kind kind,
                           enum srv_stored (*run)(struct srv_store *store,
                                                  struct srv_store_call *call),
                           void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/**
 * Lets a worker read the request, then asks the store to keep it.
 *
 * check   called by a worker; returns 1 when the store may be asked, else it has answered the
 *         exchange.
 * run     the question; it writes.
 * answer  as in srv_store_request_ask.
 *
 * If the queue is full the exchange is answered, and its finish was called.
 */
void srv_store_request_work(
    struct srv_store_request *asked, int (*check)(struct srv_store_request *asked),
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/** A question: the job of store request->id, into store request->job. */
enum srv_stored srv_store_request_find(struct srv_store *store, struct srv_store_call *call);

/** Answers with the problem that a result of the store stands for, in the words of jobs. */
void srv_store_request_refuse(struct srv_store_request *asked, enum srv_stored stored);

/** Calls the finish of the answered exchange, and frees the store request. */
void srv_store_request_end(struct srv_store_request *asked);

/** Frees the store request; the exchange has another owner now, which will call its finish. */
void srv_store_request_leave(struct srv_store_request *asked);

/* The characters of an id. */
extern const char srv_store_request_letters[];

/** True for a text that has the form of an id. */
int srv_store_request_id_good(const char *id);

#endif
