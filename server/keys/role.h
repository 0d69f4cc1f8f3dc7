/* Roles of clients and their limits: a table, parsing and formatting. A role never raises a limit
 * above the server's own option.
 * Leaves to others: assigning roles (keys, identity), enforcing limits (admission, hold, compute,
 * store).
 * Invariant: a limit is unset, a number within its range, or infinite: then only the server's
 * option applies. */
#pragma once

#include "api/base/buffer.h"
#include "core/base/status.h"

/* The role of a client. Without a file of keys all clients have SRV_ROLE_NONE, which has no limits
 * of its own. */
enum srv_role {
    SRV_ROLE_NONE,
    SRV_ROLE_ANONYMOUS, /* no API key and no account: an address, or a token that the client
                           generated */
    SRV_ROLE_PUPIL,
    SRV_ROLE_TEACHER,
    SRV_ROLE_BATCH,
    SRV_ROLE_OPERATOR,
    SRV_ROLE_COUNT
};

/* The limits of a role or key. */
enum srv_limit {
    SRV_LIMIT_REQUESTS, /* per second, averaged over a minute */
    SRV_LIMIT_COMPUTE,  /* seconds of computation per minute by synchronous requests */
    SRV_LIMIT_MEMORY,   /* bytes held at a time */
    SRV_LIMIT_BYTES,    /* stored for jobs when another job is posted */
    SRV_LIMIT_JOBS,     /* open jobs */
    SRV_LIMIT_PRIORITY, /* levels of the queue below the normal one */
    SRV_LIMIT_ROOMS,    /* open classrooms of one teacher */
    SRV_LIMIT_COUNT
};

/* An unset limit: that of the role applies or, for a role, its default. */
#define SRV_LIMIT_UNSET (-1.0)

/* Each limit is a number, INFINITY (no limit) or SRV_LIMIT_UNSET. */
struct srv_limits {
    double value[SRV_LIMIT_COUNT];
};

enum { SRV_LIMITS_TEXT = 256 /* bytes of a list of limits with its NUL */ };

/** Returns the name of a role, such as "pupil"; "" for SRV_ROLE_NONE. */
const char *srv_role_word(enum srv_role role);

/** Returns the role with this name, `bytes` long; SRV_ROLE_NONE if there is none. */
enum srv_role srv_role_of(const char *word, size_t bytes);

/** Returns the default limits of a role; SRV_ROLE_NONE has none. */
struct srv_limits srv_role_limits(enum srv_role role);

/** Sets all limits to SRV_LIMIT_UNSET. */
void srv_limits_unset(struct srv_limits *limits);

/**
 * Parses one limit, such as "memory=64M": a number within its range, with K, M or G for bytes, or
 * "none".
 *
 * text   NUL-terminated.
 *
 * PEND_INVALID  error names the correct form; nothing is changed.
 */
PEND_MUST_CHECK enum pend_status srv_limits_read(struct srv_limits *limits, const char *text,
                                                 struct pend_error *error);

/** Writes all set limits in the format of srv_limits_read, each after a blank. */
void srv_limits_write(const struct srv_limits *limits, char text[SRV_LIMITS_TEXT]);

/** Returns `own`, in which the unset limits are taken from `other`. */
struct srv_limits srv_limits_over(const struct srv_limits *own, const struct srv_limits *other);
