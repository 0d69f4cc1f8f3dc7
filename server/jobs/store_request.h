/* An exchange on its way to the store and back, maybe by way of a worker: what the routes of
 * jobs and scenes have in common. Leaves to others: what is asked and what follows (jobs,
 * job_results, scenes). Invariant: every exchange that comes in goes out through its finish,
 * once, and not before the store has answered. */
#ifndef SRV_STORE_REQUEST_H
#define SRV_STORE_REQUEST_H

#include "server/work/exchange.h"

enum { SRV_STORE_REQUEST_KEY = 80 };

/* What a route keeps, in the words of its problems. */
struct srv_store_request_words {
    const char *many;  /* "jobs" */
    const char *again; /* what a client that does not know whether it was kept may rely on */
};

struct srv_store_request {
    struct srv_ask ask; /* first: an ask is its store request */
    struct srv_task task;
    const struct srv_store_request_words *words;
    struct srv_exchange *exchange;
    struct srv_service *service;
    int (*check)(struct srv_store_request *asked);
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored);
    char id[SRV_ID_BYTES];
    struct srv_job job;

    /* of a new job */
    char key[SRV_STORE_REQUEST_KEY + 1]; /* "" = none */
    unsigned char digest[SRV_DIGEST_BYTES];
    long parts;
    int chained;
    int64_t cost_us;        /* of computation, estimated */
    struct api_buffer body; /* the request as it is kept */

    /* of a job whose results are wanted */
    void *request;
    size_t request_bytes;

    /* of many jobs */
    struct srv_job *page; /* room for `most` */
    int most, count;
    const char *before;

    /* of a scene */
    struct api_buffer scene; /* that is to be kept */
    void *kept;              /* the one that the store has */
    size_t kept_bytes;
};

extern const struct srv_store_request_words srv_store_request_jobs;

/** A store request for an exchange; NULL, with the exchange answered and gone, where that cannot
 * be. */
struct srv_store_request *srv_store_request_begin(struct srv_exchange *exchange,
                                                  const struct srv_store_request_words *words);

/** A store request for the job that the path names; NULL, with the exchange answered and gone,
 * where it cannot be one's id.
 */
struct srv_store_request *srv_store_request_begin_one(struct srv_exchange *exchange);

/**
 * Asks the store.
 *
 * answer  called on a thread of the storage; ends the store request, or asks again.
 */
void srv_store_request_ask(struct srv_store_request *asked, enum srv_ask_kind kind,
                           enum srv_stored (*run)(struct srv_store *store,
                                                  struct srv_store_call *call),
                           void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/**
 * Has a worker read the request, then asks the store to keep what it says.
 *
 * check   called by a worker; returns 1 when the store may be asked, else it has answered the
 *         exchange.
 * run     the question, a write.
 * answer  as in srv_store_request_ask.
 *
 * Without room in the queue the exchange is answered and gone.
 */
void srv_store_request_work(
    struct srv_store_request *asked, int (*check)(struct srv_store_request *asked),
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored));

/** A question: the job of store request->id, into store request->job. */
enum srv_stored srv_store_request_find(struct srv_store *store, struct srv_store_call *call);

/** Answers what went wrong in the store; what there is none of, or too many, are jobs. */
void srv_store_request_refuse(struct srv_store_request *asked, enum srv_stored stored);

/** The exchange is answered and goes home; the store request is over. */
void srv_store_request_end(struct srv_store_request *asked);

/** The store request is over, but another has taken the exchange on. */
void srv_store_request_leave(struct srv_store_request *asked);

/** The letters of an id. */
extern const char srv_store_request_letters[];

/** True for what may be an id. */
int srv_store_request_id_good(const char *id);

#endif
