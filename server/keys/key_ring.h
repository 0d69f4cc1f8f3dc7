/* The active API keys of a running server; reloads their file when it changes.
 * Leaves to others: the effect of a key (identity, admission), when to check the file (daemon).
 * Invariant: the active keys come from one complete reading; an invalid file changes nothing. */
#pragma once

#include "server/base/log.h"
#include "server/keys/keys.h"

/* The state of a key that a client sent. */
enum srv_key_verdict {
    SRV_KEY_GOOD,
    SRV_KEY_BROKEN,  /* truncated or mistyped: the check digits are wrong */
    SRV_KEY_UNKNOWN, /* never issued by this server, or removed */
    SRV_KEY_EXPIRED,
    SRV_KEY_REVOKED
};

struct srv_key_found {
    enum srv_key_verdict verdict;
    char name[SRV_KEY_NAME];       /* "" for a broken or unknown key */
    char digest[API_DIGEST_BYTES]; /* digest of the token; "" for a broken key */
    enum srv_role role;
    int64_t when; /* s since 1970: when it expired or was revoked */
    struct srv_limits limits;
};

struct srv_key_ring;

/**
 * Reads a file of keys.
 *
 * ring  out; NULL on failure. Ends with srv_key_ring_free.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error as for srv_key_file_read.
 */
PEND_MUST_CHECK enum pend_status srv_key_ring_new(struct srv_key_ring **ring, const char *path,
                                                  struct pend_error *error);

/** Frees a ring and clears the pointer; no thread may use it any more. NULL is accepted. */
void srv_key_ring_free(struct srv_key_ring **ring);

/** Reloads the file if it has changed, and logs that. An invalid file is logged once and changes
 * nothing. One thread at a time; may wait for the disk. */
void srv_key_ring_look(struct srv_key_ring *ring, struct srv_log *log);

/**
 * Looks up a key.
 *
 * token  a token for which srv_keys_meant is true.
 * now    s since 1970.
 *
 * Any thread; never waits for the disk. O(keys), about 3 ns each; the time is the same for every
 * well-formed token.
 */
struct srv_key_found srv_key_ring_find(struct srv_key_ring *ring, const char *token, int64_t now);

/** Returns true while the key with this digest is valid. Cost as srv_key_ring_find. */
int srv_key_ring_holds(struct srv_key_ring *ring, const char digest[API_DIGEST_BYTES], int64_t now);

/** Returns the limits of a role. Any thread. */
struct srv_limits srv_key_ring_role(struct srv_key_ring *ring, enum srv_role role);
