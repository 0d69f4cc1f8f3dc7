/* When a process claims parts of jobs, and which: after news, and again when a claim found some,
 * but not all processes at the same instant.
 * Leaves to others: asking the store, slots for the parts (part_runner).
 * Invariant: under the runner's lock, except srv_part_claim_run while the store is asked; the
 * leases are the claim's until they are taken. */
#pragma once

#include "server/store/store.h"

struct srv_part_claim {
    char name[SRV_NAME_BYTES]; /* of this process; no other has it, on any machine */
    struct srv_claim asked;
    struct srv_lease lease[SRV_CLAIMS]; /* what the claim returned */
    int wanted;                         /* the store should be asked for parts */
    int64_t asked_at;                   /* ns: when the store was asked */
    int64_t poll_at;                    /* ns: when to ask without being notified */
    int64_t at;       /* ns: no claim before this instant: other workers may be quicker */
    int64_t aside_at; /* ns: when parts that were set aside come before others; 0 = none wait */
    uint64_t random;  /* of the waits before claims */
};

/** Prepares the claims of a process. lease_us: how long its parts are held. */
void srv_part_claim_init(struct srv_part_claim *claim, int64_t lease_us);

/** Claims: a call of the store, on a thread of the storage. */
enum srv_stored srv_part_claim_run(struct srv_part_claim *claim, struct srv_store *store);

/**
 * Takes the answer to a claim.
 *
 * workers  processes that compute on this store, 0 = unknown.
 *
 * Returns the number of leases, which are the caller's.
 */
int srv_part_claim_take(struct srv_part_claim *claim, enum srv_stored stored, long workers,
                        int64_t now);

/** There may be parts to claim. */
void srv_part_claim_hear(struct srv_part_claim *claim, long workers, int64_t now);

/**
 * Whether a claim is due; the store is then to be asked for `claim->asked`.
 *
 * room   parts that may be claimed.
 * holds  the process holds parts.
 */
int srv_part_claim_due(struct srv_part_claim *claim, int room, int holds, int64_t now);

/** ns: the instant of the next claim without news. */
int64_t srv_part_claim_next(const struct srv_part_claim *claim, int64_t now);
