/* The keys that are in force in a running server, read again when their file changes.
 * Leaves to others: what follows from a key (identity, admission), when the file is looked at
 * (daemon).
 * Invariant: the keys in force are those of one whole reading; a file that is wrong changes
 * nothing. */
#ifndef SRV_KEY_RING_H
#define SRV_KEY_RING_H

#include "server/base/log.h"
#include "server/keys/keys.h"

/* What a ring knows of a key that somebody shows. */
enum srv_key_verdict {
    SRV_KEY_GOOD,
    SRV_KEY_BROKEN,  /* it is not whole: cut, or copied wrongly */
    SRV_KEY_UNKNOWN, /* it was never made here, or has been removed */
    SRV_KEY_EXPIRED,
    SRV_KEY_REVOKED
};

struct srv_key_found {
    enum srv_key_verdict verdict;
    char name[SRV_KEY_NAME];       /* "" of a key that is broken or unknown */
    char digest[API_DIGEST_BYTES]; /* of the whole token; "" of a key that is broken */
    enum srv_role role;
    int64_t when; /* s since 1970: since when it is expired or revoked */
    struct srv_limits limits;
};

struct srv_key_ring;

/**
 * Reads a file of keys.
 *
 * ring  out; NULL on failure. Ends with srv_key_ring_free.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error as of srv_key_file_read.
 */
PEND_MUST_CHECK enum pend_status srv_key_ring_new(struct srv_key_ring **ring, const char *path,
                                                  struct pend_error *error);

/** Frees a ring and clears the pointer; no thread may ask it any more. NULL is accepted. */
void srv_key_ring_free(struct srv_key_ring **ring);

/**
 * Reads the file again if it is another one than was read last, and says so in the log; a wrong one
 * is said once and changes nothing. One thread at a time; may wait for the disk.
 */
void srv_key_ring_look(struct srv_key_ring *ring, struct srv_log *log);

/**
 * What is known of a key.
 *
 * token  that looks like one (srv_keys_meant).
 * now    s since 1970.
 *
 * Any thread; never waits for the disk. O(keys), about 3 ns each, and the same time for every whole
 * token.
 */
struct srv_key_found srv_key_ring_find(struct srv_key_ring *ring, const char *token, int64_t now);

/** True while the key of a digest is good. As srv_key_ring_find. */
int srv_key_ring_holds(struct srv_key_ring *ring, const char digest[API_DIGEST_BYTES], int64_t now);

/** What a role may have. Any thread. */
struct srv_limits srv_key_ring_role(struct srv_key_ring *ring, enum srv_role role);

#endif
