/* Decides when a process claims parts of jobs, and how many: after a notification, and again after
 * a claim that found some. Random delays keep processes from claiming simultaneously.
 * Leaves to others: querying the store, slots for the parts (part_runner).
 * Invariant: under the runner's lock. */
#pragma once

#include "server/store/store.h"

struct srv_part_claim {
    char name[SRV_NAME_BYTES]; /* unique name of this process, on all machines */
    struct srv_claim asked;
    struct srv_lease lease[SRV_CLAIMS]; /* the result of the claim */
    int wanted;                         /* the store must be queried for parts */
    int64_t asked_at;                   /* ns: time of the last query */
    int64_t poll_at;                    /* ns: time of the next query without a notification */
    int64_t at;       /* ns: earliest time of the next claim, so that other workers have a chance */
    int64_t aside_at; /* ns: from this time on, parts that were set aside come first; 0 = there are
                         none */
    uint64_t random;  /* random state for the waits before claims */
};

/** Initializes the claims of a process. lease_us: duration of its leases, us. */
void srv_part_claim_init(struct srv_part_claim *claim, int64_t lease_us);

/**
 * Processes the result of a claim.
 *
 * workers  processes that compute on this store, 0 = unknown.
 *
 * Returns the number of leases, which the caller then owns.
 */
int srv_part_claim_take(struct srv_part_claim *claim, enum srv_stored stored, long workers,
                        int64_t now);

/** Reports that there may be parts to claim. */
void srv_part_claim_hear(struct srv_part_claim *claim, long workers, int64_t now);

/**
 * Returns true if a claim is due; the caller then queries the store with `claim->asked`.
 *
 * room   number of parts that may be claimed.
 * holds  non-zero if the process holds parts.
 */
int srv_part_claim_due(struct srv_part_claim *claim, int room, int holds, int64_t now);

/** Returns the time of the next claim, ns, if no notification arrives. */
int64_t srv_part_claim_next(const struct srv_part_claim *claim, int64_t now);
