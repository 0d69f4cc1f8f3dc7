/* One request and its answer, independent of sockets: http passes it to the router and the workers.
 * Leaves to others: sockets (http), the contents of answers (router, compute).
 * Invariant: one thread at a time owns an exchange; the lock named at `being computed` guards the
 * fields there. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "api/base/buffer.h"
#include "api/call/call.h"
#include "api/op/op.h"
#include "server/work/clients.h"
#include "server/protocol/coding.h"
#include "server/work/hold.h"
#include "server/protocol/identity.h"
#include "server/protocol/response_body.h"
#include "server/work/service.h"

/* name, how repeated fields are treated: ONE = refused, LIST = joined by commas, LAST = the last
 * one counts */
#define SRV_FIELD_LIST(X)                                                                          \
    X(SRV_CONTENT_LENGTH, "Content-Length", ONE)                                                   \
    X(SRV_TRANSFER_ENCODING, "Transfer-Encoding", ONE)                                             \
    X(SRV_CONTENT_TYPE, "Content-Type", ONE)                                                       \
    X(SRV_CONTENT_ENCODING, "Content-Encoding", LIST)                                              \
    X(SRV_EXPECT, "Expect", LIST)                                                                  \
    X(SRV_ACCEPT, "Accept", LIST)                                                                  \
    X(SRV_ACCEPT_ENCODING, "Accept-Encoding", LIST)                                                \
    X(SRV_IF_NONE_MATCH, "If-None-Match", LIST)                                                    \
    X(SRV_RANGE, "Range", ONE)                                                                     \
    X(SRV_IF_RANGE, "If-Range", ONE)                                                               \
    X(SRV_LAST_EVENT_ID, "Last-Event-ID", LAST)                                                    \
    X(SRV_HOST, "Host", ONE)                                                                       \
    X(SRV_FETCH_SITE, "Sec-Fetch-Site", LAST)                                                      \
    X(SRV_ORIGIN, "Origin", LAST)                                                                  \
    X(SRV_PREFLIGHT, "Access-Control-Request-Method", LAST)                                        \
    X(SRV_PREFER, "Prefer", LIST)                                                                  \
    X(SRV_IDEMPOTENCY_KEY, "Idempotency-Key", ONE)                                                 \
    X(SRV_JOB_TITLE, "Job-Title", ONE)                                                             \
    X(SRV_ROOM_TOKEN, "Class-Token", ONE)                                                          \
    X(SRV_AUTHORIZATION, "Authorization", ONE)                                                     \
    X(SRV_REQUEST_ID, "X-Request-Id", LAST)                                                        \
    X(SRV_TRACE, "Traceparent", LAST)                                                              \
    X(SRV_SCHEME, "X-Forwarded-Proto", LAST)                                                       \
    X(SRV_FORWARDED, "", LIST) /* the name is the option client-header */                          \
    X(SRV_ROLES, "", LIST)     /* the name is the option role-header */                            \
    X(SRV_USER_AGENT, "User-Agent", LAST)

/* The header fields that the server reads. */
enum srv_field_id {
#define X(id, name, several) id,
    SRV_FIELD_LIST(X)
#undef X
        SRV_FIELD_COUNT
};

enum {
    SRV_TARGET_BYTES = 1024, /* longest request target, with its NUL */
    SRV_TEXT_BYTES = 2048,   /* small texts of one exchange */
    SRV_HEADERS = 12         /* largest number of header fields that are added to an answer */
};

/* The reason why an exchange's computation should not continue. */
enum srv_stop { SRV_GO_ON, SRV_STOP_LEFT, SRV_STOP_SHUTDOWN };

struct srv_listener;
struct srv_route;
struct srv_work;

/* The source of a stored answer: the request it was computed from, and the place of its parts. */
struct srv_source {
    struct api_source from;
    const char *body; /* body of the original request */
    size_t body_bytes;
    int ranged; /* the client requests a range, to be applied if the answer has not changed */
    struct api_range range;
    /* Suspends the computation until the source is ready; then the computation is queued again.
     * Returns 1 if it is suspended: the caller no longer owns the computation. Returns 0 if the
     * source is ready or the computation should stop. */
    int (*park)(struct srv_source *source, struct srv_work *work);
    void (*free)(struct srv_source *source);
};

struct srv_exchange {
    unsigned magic;
    struct srv_service *service;

    /* the request */
    const char *method; /* valid, like the fields, until the exchange is answered */
    const char *field[SRV_FIELD_COUNT];
    char peer[SRV_PEER_BYTES];    /* the other end of the connection; outlives the request */
    struct srv_identity identity; /* the client; `shown` is "" before the router has set it */
    struct srv_client *account;   /* the client's record; NULL if the route needs none */
    struct srv_client
        *payer; /* the record of the client's address, which pays for memory; NULL before */
    char target[SRV_TARGET_BYTES]; /* the target as received */
    const char *path, *query;      /* parts of the target: decoded path; query or NULL */
    const char *host; /* the requested host: of an absolute target, else of Host; NULL = none */
    int probes; /* received by the listener of probes and metrics, which serves nothing else */
    int closed; /* only listed web pages may read the answer (cors) */
    const char *id, *trace; /* X-Request-Id; traceparent, or NULL */
    enum srv_coding coding; /* the coding that the client accepts */
    int64_t length;         /* of the body: Content-Length; 0 = no body, -1 = chunked */
    struct api_buffer body;
    const struct srv_route *route;
    enum api_op_id op;    /* operation of the route */
    const char *argument; /* variable part of the path, or NULL */

    /* being computed; compute's, under its lock */
    struct srv_work *work;   /* computes the answer; NULL before and after */
    struct srv_list beside;  /* in the list of exchanges that wait for the same work */
    struct srv_work *stream; /* source of the answer's body, piece by piece; NULL for a complete
                              * one */
    int streams;             /* the answer is a stream, even if that has ended */
    struct srv_listener *listener; /* of an event stream; guarded by the lock of the events */
    atomic_int listens; /* the answer is or will be an event stream, even after its listener has
                         * ended */
    struct srv_source *source; /* source of a stored answer; NULL = it is computed */
    int apart;                 /* more than its bytes determines the answer: no cache key */
    int stop;                  /* enum srv_stop: why the client no longer waits for it */

    /* the answer */
    int status; /* 0 if not known yet */
    const char *media_type;
    const char *data; /* the body: in `answer`, in `response_body`, or in static memory */
    size_t bytes;
    int trails;                              /* a stream has trailers: api_stats_field_names */
    int64_t stream_bytes;                    /* of a stream's body, -1 = known only at its end */
    struct srv_response_body *response_body; /* the body, or NULL */
    struct srv_quota quota; /* remaining quota of the client; reported if quota.refresh > 0 */
    struct api_buffer answer;
    struct {
        const char *name, *value;
    } header[SRV_HEADERS];
    int headers;
    int close; /* the connection ends after this answer */

    /* for the log */
    int64_t received, queued, sending; /* ns, time of the event, 0 = has not happened */
    int64_t waited, computed;          /* ns, duration, 0 = none */
    long steps;
    const char *cache; /* "exact", "digest", "joined": why it was not computed; NULL = computed, or
                        * nothing to compute */
    struct srv_hold hold; /* memory of the request's body and of the server's own answers */
    size_t share;         /* bytes of `response_body` that are charged to the payer */

    /** Returns the answered exchange to its owner; after the call the caller must not use it. Any
     * thread. */
    void (*finish)(struct srv_exchange *exchange);

    size_t text_bytes;
    char text[SRV_TEXT_BYTES];
};

/* The value of Vary: the header fields that an answer depends on. */
extern const char srv_exchange_vary[];

/* Media types of requests with a body, for Accept-Post. */
extern const char srv_exchange_accepts[];

/** Prepares a new exchange for its first request; the caller sets finish and peer. */
void srv_exchange_init(struct srv_exchange *exchange, struct srv_service *service);
void srv_exchange_clear(struct srv_exchange *exchange);
int srv_exchange_valid(const struct srv_exchange *exchange);

/** Prepares an exchange for the next request; keeps small buffers. */
void srv_exchange_reset(struct srv_exchange *exchange);

/** Returns memory for a small text, valid until the reset; NULL if none is left. */
char *srv_exchange_text(struct srv_exchange *exchange, size_t bytes);

/** Adds a header field to the answer; name and value must be valid until the reset. */
void srv_exchange_header(struct srv_exchange *exchange, const char *name, const char *value);

/** Answers with bytes that remain valid longer than the exchange. */
void srv_exchange_static(struct srv_exchange *exchange, int status, const char *media_type,
                         const char *data, size_t bytes);

/** Answers with a response body, of which the exchange takes a share. */
void srv_exchange_response_body(struct srv_exchange *exchange,
                                struct srv_response_body *response_body);

/** Returns true for a safe method (RFC 9110, 9.2.1), with or without a body: GET, HEAD, QUERY. */
int srv_exchange_safe(const struct srv_exchange *exchange);

/** Returns true if the request's If-None-Match names an entity tag. */
int srv_exchange_matches(const struct srv_exchange *exchange, const char *etag);

/** Answers 304 if the client has the answer already; or 412 if the method is not safe (RFC 9110,
 * 13.1.2). */
void srv_exchange_not_modified(struct srv_exchange *exchange, const char *etag);

/** Answers with the contents of exchange->answer. */
void srv_exchange_answered(struct srv_exchange *exchange, int status, const char *media_type);

/**
 * Answers with a problem (RFC 9457), replacing any earlier answer.
 *
 * format  printf format of the detail sentence.
 */
void srv_exchange_problem(struct srv_exchange *exchange, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Answers 503 with Retry-After, in seconds. */
void srv_exchange_busy(struct srv_exchange *exchange, int seconds, const char *detail);

/** Adds Retry-After. */
void srv_exchange_retry(struct srv_exchange *exchange, double seconds);

/** Adds bytes of a body to the memory of this exchange; `bytes` is the total so far. Returns
 * whether there is memory; the bytes are counted in any case. */
enum srv_room srv_exchange_hold(struct srv_exchange *exchange, size_t bytes);

/** Answers that there is no memory for `what`: 413, 429 or 503, with the limit's name. */
void srv_exchange_crowded(struct srv_exchange *exchange, enum srv_room room, const char *what);

/** Answers 503 or 429 after srv_queue_push has refused the exchange's task with PEND_LIMIT or
 * PEND_INVALID. road_full: as in the task. */
void srv_exchange_queued_out(struct srv_exchange *exchange, enum pend_status status, int road_full);

/** Call it when the exchange is answered and its body is no longer needed: frees the body and
 * counts the answer's memory. If there is no memory, the answer becomes a problem. */
void srv_exchange_settle(struct srv_exchange *exchange);

/** Returns the record of the client that pays for the memory, NULL if memory is short. */
struct srv_client *srv_exchange_payer(struct srv_exchange *exchange);
