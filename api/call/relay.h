/* Messages between a call, a part or a plan and the process that computes it, where that is another
 * one: what is asked and what is told.
 * Leaves to others: carrying the messages (server/work/cells), what is made of them (call, part),
 * the side that computes (relay_host).
 * Invariant: what comes from the process that computes is believed in nothing but its numbers and
 * the bytes of its answer: every length, text and count is checked before it is used. */
#ifndef API_RELAY_H
#define API_RELAY_H

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/call/request.h"
#include "api/encode/remarks.h"

/* How a call stands. */
enum api_progress {
    API_MORE,   /* call again; bytes may have been appended */
    API_DONE,   /* the answer is complete: an answer of the operation, or a problem */
    API_BROKEN, /* it failed after api_call_promise: the bytes in out may be sent, but the client
                   must see that the message is not complete */
    API_WAITS   /* call again once the source has more; bytes may have been appended. Only after
                   api_call_results */
};

/* What is asked. */
enum api_relay_kind {
    API_RELAY_OPEN,  /* reads a request, as api_call_open */
    API_RELAY_RUN,   /* as api_call_run */
    API_RELAY_PLAN,  /* as api_plan_read */
    API_RELAY_BEGIN, /* reads a part's request, as api_part_new, and resumes it */
    API_RELAY_PART   /* as api_part_run; its output follows once it is complete */
};

struct api_relay_ask {
    enum api_relay_kind kind;
    const struct api_request *request; /* of OPEN, PLAN and BEGIN */
    const struct api_limits *limits;   /* of these */
    int clock;                         /* OPEN: the call has a clock there, and turns of 1 ms */
    int promised;                      /* RUN: the head of the answer was sent */
    int body;                          /* PLAN: the body is wanted in the form of the store */
    double seconds;                    /* PLAN: about how long a part should take */
    long number, parts;                /* BEGIN */
    const void *start;                 /* BEGIN: the checkpoint, NULL = none */
    size_t start_bytes;
};

/* What is told, beside the bytes of the output. A plain block of memory: it is sent as it is. */
struct api_relay_told {
    int progress; /* enum api_progress, of calls */
    int status;   /* enum pend_status, of parts; HTTP status of calls and plans */
    int streams;  /* as api_call_streams */
    int done;     /* of a part */
    long steps;
    long long length;           /* as struct api_answer */
    double cost, bytes, answer; /* as api_call_cost, api_call_bytes, api_call_answer_bytes */
    char digest[API_DIGEST_BYTES];
    char columns[API_COLUMNS_TEXT];
    char text[240];             /* of a part that failed: why */
    struct api_remarks remarks; /* the names of its fields are set by who reads it, from `named` */
    int named[API_REMARKS_FIELDS]; /* numbers of api_remarks_name */
    struct {
        long parts;
        int chained;
        double cost, bytes, kept;
    } plan;
};

/* The way to another process. */
struct api_relay {
    /**
     * Sends what is asked and waits for what is told.
     *
     * told  out, not checked.
     * out   the output is appended here.
     * more  a checkpoint or a body is appended here; NULL if none can come.
     *
     * PEND_BUG       the process ended, or told nonsense; error->text says how.
     * PEND_DEADLINE  it took longer than it may.
     * PEND_LIMIT     the output is larger than its buffer may be.
     * PEND_NO_MEMORY
     * After a failure the way leads nowhere: every further question fails.
     */
    enum pend_status (*ask)(void *context, const struct api_relay_ask *ask,
                            struct api_relay_told *told, struct api_buffer *out,
                            struct api_buffer *more, struct pend_error *error);
    void *context;
};

/**
 * Asks, and checks what is told; the parameters are those of struct api_relay.
 *
 * Fails as `ask` does, and with PEND_BUG where what is told cannot be.
 */
PEND_MUST_CHECK enum pend_status api_relay_ask(const struct api_relay *relay,
                                               const struct api_relay_ask *ask,
                                               struct api_relay_told *told, struct api_buffer *out,
                                               struct api_buffer *more, struct pend_error *error);

/** True where what was told to such a question can be: texts end and are printable, counts and
 * states are in range, numbers are finite. O(its size). */
int api_relay_believable(const struct api_relay_told *told, enum api_relay_kind kind);

enum { API_RELAY_TEXTS = 6 }; /* argument, query, content type, accept, body, checkpoint */

/* What lies before the texts of a question, as it is sent. */
struct api_relay_head {
    int kind, op, clock, promised, body;
    struct api_limits limits;
    double seconds;
    long number, parts;
    unsigned long long bytes[API_RELAY_TEXTS]; /* with the NUL that ends each; 0 = NULL */
};

/** Writes the head of a question, and which texts follow it, in their order; NULL where there is
 * none. Each is sent with one NUL behind it. */
void api_relay_put(const struct api_relay_ask *ask, struct api_relay_head *head,
                   const void *texts[API_RELAY_TEXTS]);

#endif
