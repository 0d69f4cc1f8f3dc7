/* One request and its answer, with no socket in sight: what http hands to the router and the workers.
 * Leaves to others: bytes on the wire (http), what an answer says (router, compute).
 * Invariant: one thread at a time owns an exchange; only `stop` is set by others. */
#ifndef SRV_EXCHANGE_H
#define SRV_EXCHANGE_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "api/buffer.h"
#include "server/queue.h"
#include "server/service.h"

/* name, how several of them are taken: ONE = refused, LIST = joined by commas, LAST = the last counts */
#define SRV_FIELD_LIST(X)                                                                                              \
    X(SRV_CONTENT_LENGTH, "Content-Length", ONE)                                                                       \
    X(SRV_TRANSFER_ENCODING, "Transfer-Encoding", ONE)                                                                 \
    X(SRV_CONTENT_TYPE, "Content-Type", ONE)                                                                           \
    X(SRV_EXPECT, "Expect", LIST)                                                                                      \
    X(SRV_ACCEPT, "Accept", LIST)                                                                                      \
    X(SRV_REQUEST_ID, "X-Request-Id", LAST)                                                                            \
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
    SRV_CLIENT_BYTES = 48,
    SRV_HEADERS = 8 /* most header fields that are added to an answer */
};

/* Why an exchange's computation is not to go on. */
enum srv_stop { SRV_GO_ON, SRV_STOP_LEFT, SRV_STOP_SHUTDOWN };

struct srv_route;

struct srv_exchange {
    struct srv_task task; /* first: a task of this kind is its exchange */
    unsigned magic;
    struct srv_service *service;
    atomic_int stop; /* enum srv_stop */

    /* the request */
    const char *method; /* valid until the exchange is answered, as are the fields */
    const char *field[SRV_FIELD_COUNT];
    char client[SRV_CLIENT_BYTES];
    char target[SRV_TARGET_BYTES]; /* as it came */
    const char *path, *query;      /* of the target; the path decoded, query NULL where there is none */
    const char *id;
    int fields;     /* header fields so far */
    int64_t length; /* of the body: Content-Length, 0 without one, -1 when chunked */
    struct api_buffer body;
    const struct srv_route *route;
    const char *argument; /* variable part of the path, or NULL */

    /* the answer */
    int status; /* 0 until it is known */
    const char *media_type;
    const char *data; /* the body; lies in `answer`, or lasts longer than the exchange */
    size_t bytes;
    struct api_buffer answer;
    struct {
        const char *name, *value;
    } header[SRV_HEADERS];
    int headers;
    int close; /* the connection is to end with this answer */

    /* for the log */
    int64_t received, queued, begun, computed; /* ns, 0 = has not happened */
    long steps;
    size_t held; /* bytes counted in service->held */

    /** Gives the answered exchange back to where it came from; afterwards it is no more the caller's. Any thread. */
    void (*finish)(struct srv_exchange *exchange);

    size_t text_bytes;
    char text[SRV_TEXT_BYTES];
};

/** Prepares a new exchange for its first request; the caller sets finish and client. */
void srv_exchange_init(struct srv_exchange *exchange, struct srv_service *service);

/** Frees what an exchange owns. */
void srv_exchange_clear(struct srv_exchange *exchange);

/** Makes it ready for the next request; small buffers are kept for it. */
void srv_exchange_reset(struct srv_exchange *exchange);

/** Tests what must hold at any time. */
int srv_exchange_valid(const struct srv_exchange *exchange);

/** Room for a small text that lives until the reset; NULL when there is none left. */
char *srv_exchange_text(struct srv_exchange *exchange, size_t bytes);

/** Adds a header field to the answer; name and value must live until the reset. */
void srv_exchange_header(struct srv_exchange *exchange, const char *name, const char *value);

/** Answers with bytes that last longer than the exchange. */
void srv_exchange_static(struct srv_exchange *exchange, int status, const char *media_type, const char *data,
                         size_t bytes);

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

/** Counts bytes as held in memory by this exchange, all that it holds now. Returns 0 where that is beyond the limit. */
int srv_exchange_hold(struct srv_exchange *exchange, size_t bytes);

#endif
