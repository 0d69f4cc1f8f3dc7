/* Roles of clients, and what each may have: a table of limits, and their reading and writing. What
 * the options allow to any client no role widens.
 * Leaves to others: who has which role (keys, identity), keeping to the limits (admission, hold,
 * compute, store).
 * Invariant: a limit is unset, or a number of its range, or none: then the server's own option
 * holds and no more. */
#ifndef SRV_ROLE_H
#define SRV_ROLE_H

#include "api/base/buffer.h"
#include "core/base/status.h"

/* Who a client is to this server. Without a file of keys all have the role of nobody, which has no
 * limits of its own. */
enum srv_role {
    SRV_ROLE_NONE,
    SRV_ROLE_ANONYMOUS, /* no key and no account: an address, or a secret of the client's own */
    SRV_ROLE_PUPIL,
    SRV_ROLE_TEACHER,
    SRV_ROLE_BATCH,
    SRV_ROLE_OPERATOR,
    SRV_ROLE_COUNT
};

/* What a role or a key bounds. */
enum srv_limit {
    SRV_LIMIT_REQUESTS, /* a second, on average over a minute */
    SRV_LIMIT_COMPUTE,  /* s of computation a minute, of requests that are answered at once */
    SRV_LIMIT_MEMORY,   /* bytes held at a time */
    SRV_LIMIT_BYTES,    /* kept for jobs when another is posted */
    SRV_LIMIT_JOBS,     /* that have not ended */
    SRV_LIMIT_PRIORITY, /* levels of the queue behind everybody else's */
    SRV_LIMIT_ROOMS,    /* class rooms that one teacher has at a time */
    SRV_LIMIT_COUNT
};

/* A limit that is not said: that of the role counts, or for a role its default. */
#define SRV_LIMIT_UNSET (-1.0)

/* Of each limit a number, INFINITY for none, or SRV_LIMIT_UNSET. */
struct srv_limits {
    double value[SRV_LIMIT_COUNT];
};

enum { SRV_LIMITS_TEXT = 256 /* bytes of a list of limits with its NUL */ };

/** The word of a role: "pupil". SRV_ROLE_NONE has "". */
const char *srv_role_word(enum srv_role role);

/** The role of a word of so many bytes; SRV_ROLE_NONE where it is none. */
enum srv_role srv_role_of(const char *word, size_t bytes);

/** The limits that a role has before anybody says others; those of SRV_ROLE_NONE are none. */
struct srv_limits srv_role_limits(enum srv_role role);

/** The word of a limit: "requests". */
const char *srv_limit_word(enum srv_limit limit);

/** Sets all limits to SRV_LIMIT_UNSET. */
void srv_limits_unset(struct srv_limits *limits);

/**
 * Reads one limit, "memory=64M": a number of its range, with K, M or G behind bytes, or none.
 *
 * text   ended by NUL.
 *
 * PEND_INVALID  error says what would be right; nothing is changed.
 */
PEND_MUST_CHECK enum pend_status srv_limits_read(struct srv_limits *limits, const char *text,
                                                 struct pend_error *error);

/** Writes those that are set, as srv_limits_read takes them, with a blank before each. */
void srv_limits_write(const struct srv_limits *limits, char text[SRV_LIMITS_TEXT]);

/** The limits of one, and where it says nothing those of another. */
struct srv_limits srv_limits_over(const struct srv_limits *own, const struct srv_limits *other);

#endif
