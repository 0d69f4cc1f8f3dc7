/* One request and its answer, independent of sockets: http hands it to the router and the workers.
 * Leaves to others: sockets (http), what an answer says (router, compute).
 * Invariant: one thread at a time owns an exchange; the fields under `being computed` are guarded
 * by the lock that is named there. */
#ifndef SRV_EXCHANGE_H
#define SRV_EXCHANGE_H

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

/* name, how several of them are taken: ONE = refused, LIST = joined by commas, LAST = the last
 * counts */
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
    X(SRV_JOB_NOTIFY, "Job-Notify", ONE)                                                           \
    X(SRV_ROOM_TOKEN, "Class-Token", ONE)                                                          \
    X(SRV_AUTHORIZATION, "Authorization", ONE)                                                     \
    X(SRV_REQUEST_ID, "X-Request-Id", LAST)                                                        \
    X(SRV_TRACE, "Traceparent", LAST)                                                              \
    X(SRV_SCHEME, "X-Forwarded-Proto", LAST)                                                       \
    X(SRV_FORWARDED, "", LIST) /* the name is the option client-header */                          \
    X(SRV_ROLES, "", LIST)     /* the name is the option role-header */                            \
    X(SRV_USER_AGENT, "User-Agent", LAST)

/* The header fields that the server looks at. */
enum srv_field_id {
#define X(id, name, several) id,
    SRV_FIELD_LIST(X)
#undef X
        SRV_FIELD_COUNT
};

enum {
    SRV_TARGET_BYTES = 1024, /* longest request target, with its NUL */
    SRV_TEXT_BYTES = 2048,   /* small texts of one exchange */
    SRV_HEADERS = 12         /* most header fields that are added to an answer */
};

/* Why an exchange's computation is not to go on. */
enum srv_stop { SRV_GO_ON, SRV_STOP_LEFT, SRV_STOP_SHUTDOWN };

struct srv_listener;
struct srv_route;
struct srv_work;

/* The source of an answer that was computed before and is stored: the request it was computed from,
 * and where its parts are. */
struct srv_source {
    struct api_source from;
    const char *body; /* of the request that it was made of */
    size_t body_bytes;
    int ranged; /* the client wants `range` of it, if the answer is the one that it knows already */
    struct api_range range;
    /* Lets the work rest until the source is ready; then the work is queued again. Returns 1 if it
     * rests: the work is not the caller's any more. Returns 0 if the source is ready or the work is
     * to stop. */
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
    struct srv_identity identity; /* who asks; `shown` is "" before the router has set it */
    struct srv_client *account;   /* the client's record; NULL if the route needs none */
    struct srv_client
        *payer; /* the record of the client's address, whose share of memory it uses; NULL before */
    char target[SRV_TARGET_BYTES]; /* as it came */
    const char *path, *query; /* of the target; the path decoded, query NULL where there is none */
    const char *host; /* that it was sent to: of an absolute target, else of Host; NULL = none */
    int probes; /* it came to the listener of probes and metrics, which answers nothing else */
    int closed; /* only listed web pages may read the answer (cors) */
    const char *id, *trace; /* X-Request-Id; traceparent, or NULL */
    enum srv_coding coding; /* that the client wants */
    int64_t length;         /* of the body: Content-Length, 0 without one, -1 when chunked */
    struct api_buffer body;
    const struct srv_route *route;
    enum api_op_id op;    /* that the route names */
    const char *argument; /* variable part of the path, or NULL */

    /* being computed; compute's, under its lock */
    struct srv_work *work;   /* that computes the answer, NULL before and after */
    struct srv_list beside;  /* in the list of those that wait for the same */
    struct srv_work *stream; /* that the answer's body is read from, piece by piece; NULL for one
                                that is whole */
    int streams;             /* the answer is a stream, even where that is gone */
    struct srv_listener *listener; /* of a stream of events; events', under its lock */
    atomic_int listens; /* the answer is one, or waits for one, even where the listener is gone */
    struct srv_source *source; /* the answer is taken from there; NULL = it is computed */
    int apart; /* its bytes do not say what is answered: it is not looked up, nor kept, by them */
    int stop;  /* enum srv_stop: why it is not waited for any more */

    /* the answer */
    int status; /* 0 until it is known */
    const char *media_type;
    const char *
        data; /* the body; lies in `answer` or `response body`, or lasts longer than the exchange */
    size_t bytes;
    int trails;                              /* a stream has trailers: api_stats_field_names */
    int64_t stream_bytes;                    /* of a stream's body, -1 = not known before its end */
    struct srv_response_body *response_body; /* that it is, or NULL */
    struct srv_quota quota; /* what the client may still ask; to be told where quota.refresh > 0 */
    struct api_buffer answer;
    struct {
        const char *name, *value;
    } header[SRV_HEADERS];
    int headers;
    int close; /* the connection is to end with this answer */

    /* for the log */
    int64_t received, queued, sending; /* ns when, 0 = has not happened */
    int64_t waited, computed;          /* ns how long, 0 = not at all */
    long steps;
    const char *cache; /* "exact", "digest", "joined": why it was not computed; NULL = it was, or is
                          nothing to compute */
    struct srv_hold hold; /* of its body and its own answer */
    size_t share;         /* bytes of `response body` that the payer is charged with */

    /** Returns the answered exchange to its owner; afterwards the caller must not use it. Any
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

/** Frees what an exchange owns. */
void srv_exchange_clear(struct srv_exchange *exchange);

/** Prepares an exchange for the next request; small buffers are kept. */
void srv_exchange_reset(struct srv_exchange *exchange);

/** True when the fields agree with each other, as they must at any time; for assertions. O(1). */
int srv_exchange_valid(const struct srv_exchange *exchange);

/** Returns memory for a small text that lives until the reset; NULL if none is left. */
char *srv_exchange_text(struct srv_exchange *exchange, size_t bytes);

/** Adds a header field to the answer; name and value must live until the reset. */
void srv_exchange_header(struct srv_exchange *exchange, const char *name, const char *value);

/** Answers with bytes that last longer than the exchange. */
void srv_exchange_static(struct srv_exchange *exchange, int status, const char *media_type,
                         const char *data, size_t bytes);

/** Answers with a response body, of which the exchange takes a share. */
void srv_exchange_response_body(struct srv_exchange *exchange,
                                struct srv_response_body *response_body);

/** True for a method that changes nothing (RFC 9110, 9.2.1), with or without a body: GET, HEAD,
 * QUERY. */
int srv_exchange_safe(const struct srv_exchange *exchange);

/** True when the request's If-None-Match names an entity tag. */
int srv_exchange_matches(const struct srv_exchange *exchange, const char *etag);

/** Answers 304: the client has it already; or 412 where the method is not a safe one (RFC 9110,
 * 13.1.2). */
void srv_exchange_not_modified(struct srv_exchange *exchange, const char *etag);

/** Answers with what is in exchange->answer. */
void srv_exchange_answered(struct srv_exchange *exchange, int status, const char *media_type);

/**
 * Answers with a problem (RFC 9457) in place of whatever the answer was.
 *
 * format  printf format of the detail sentence.
 */
void srv_exchange_problem(struct srv_exchange *exchange, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Answers 503 with Retry-After; the client may come again after so many seconds. */
void srv_exchange_busy(struct srv_exchange *exchange, int seconds, const char *detail);

/** Adds Retry-After. */
void srv_exchange_retry(struct srv_exchange *exchange, double seconds);

/** Counts bytes of a body as held by this exchange, all of it so far. Returns whether there is
 * room; counted either way.
 */
enum srv_room srv_exchange_hold(struct srv_exchange *exchange, size_t bytes);

/** Answers that there is no room in memory for `what`: 413, 429 or 503, with the limit's name. */
void srv_exchange_crowded(struct srv_exchange *exchange, enum srv_room room, const char *what);

/**
 * The exchange is answered and its body needed no more: frees that, and counts the answer. One that
 * finds no room becomes a problem.
 */
void srv_exchange_settle(struct srv_exchange *exchange);

/** The scheme by which the client has come, "http" or "https": that of this server's sockets, or
 * what a proxy says that is trusted. */
const char *srv_exchange_scheme(const struct srv_exchange *exchange);

/** The record of the client who pays for the memory, NULL without memory for it. */
struct srv_client *srv_exchange_payer(struct srv_exchange *exchange);

#endif
