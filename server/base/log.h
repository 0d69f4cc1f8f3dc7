/* The server's logs: JSON lines of requests and audit entries, and messages for people.
 * Leaves to others: what is logged.
 * Invariant: only the log's own thread writes; a caller never waits for a reader; lines that do not
 * fit are dropped and counted, and the count is logged. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/base/status.h"

struct srv_log;

/* A completed request. Texts may contain any bytes: they are escaped. */
struct srv_log_request {
    const char *id, *client, *method, *target;
    const char *token;                 /* short form of the token's digest; NULL = no token */
    const char *agent, *trace, *cache; /* each may be NULL */
    int status;                        /* HTTP status of the answer; 0 if no answer was started */
    const char *outcome;               /* how it ended: "answered", "left", ... */
    size_t bytes_in, bytes_out;        /* sizes of the bodies */
    int64_t wait, compute,
        total;  /* ns: in the queue, on a worker, and in total since the request line */
    long steps; /* steps of the computation */
};

/* An entry of the audit log. Texts may contain any bytes. */
struct srv_log_audit_entry {
    const char *id;      /* id of the request; "" = none */
    const char *who;     /* key, token, account, address; "operator" runs the process */
    const char *role;    /* of the client; "" = none */
    const char *what;    /* the action: "DELETE /v1/jobs/{id}", "keys" */
    const char *of;      /* object of the action, such as a job's id; NULL = none */
    int status;          /* HTTP status; 0 = not a request */
    const char *outcome; /* "done", "refused" or "failed" */
};

/* The streams that can be redirected to other files. */
enum srv_log_kind { SRV_LOG_REQUESTS, SRV_LOG_AUDIT };

/**
 * Starts a log and its thread.
 *
 * requests  file descriptor for the request lines, -1 = none.
 * messages  file descriptor for the messages.
 *
 * The log takes ownership of both, and closes them when it is freed or redirected, except the
 * standard streams; after a failure the caller keeps them.
 *
 * PEND_NO_MEMORY  also if the thread cannot be created.
 */
PEND_MUST_CHECK enum pend_status srv_log_new(struct srv_log **log, int requests, int messages);

/** Redirects the lines of one kind to another file descriptor from now on; -1 drops them. The log
 * takes ownership as in srv_log_new. Audit entries are dropped until the first call. Any thread. */
void srv_log_turn(struct srv_log *log, enum srv_log_kind kind, int fd);

/** Writes the remaining lines, waits at most about a second for a reader, and ends the thread. */
void srv_log_free(struct srv_log **log);

/** Adds a request line. Any thread; about a microsecond; never waits for the reader. */
void srv_log_request(struct srv_log *log, const struct srv_log_request *request);

/** Adds a line for an audit entry. Any thread; never waits for the reader. */
void srv_log_audit_entry(struct srv_log *log, const struct srv_log_audit_entry *entry);

/** Adds a message line; control characters in it become '?'. Any thread; never waits for the
 * reader. */
void srv_log_message(struct srv_log *log, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
