/* Many trajectories of trees of one shape; several run at once in the lanes of vector registers.
 * Leaves to others: the starts and the use of the results (callbacks), threads (server).
 * Invariant: a member's result depends neither on its lane, nor on its neighbours, nor on how
 * the members are divided among threads: the bits are the same for every number of threads, and
 * the same on avx2 and avx512 (base, without fused multiply-add, differs in rounding). */
#pragma once

#include "core/ensemble/member.h"

struct pend_ensemble;

/**
 * Prepares a workspace for one thread.
 *
 * ensemble  out; NULL on failure; released by pend_ensemble_free.
 * problem   copied; its tree and times must outlive the workspace.
 * isa       pend_isa_best(), or a lower one.
 *
 * PEND_INVALID    a tolerance, the bound or the duration is out of range.
 * PEND_NO_MEMORY
 * One allocation.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_new(struct pend_ensemble **ensemble,
                                                   const struct pend_ensemble_problem *problem,
                                                   enum pend_isa isa, struct pend_error *error);
void pend_ensemble_free(struct pend_ensemble **ensemble);

/** Starts a run of the members first .. first + count - 1, which pend_ensemble_go continues; an
 * unfinished earlier run is cancelled. A lane whose member has ended takes the next member; a
 * member that fails is delivered as failed, and the other members are not affected. */
void pend_ensemble_begin(struct pend_ensemble *ensemble, long first, long count);

/**
 * Takes up to `steps` steps of all lanes, so that the caller can check its deadline between calls.
 * The results' bits do not depend on `steps`.
 *
 * done  out: non-zero if all members of the run were delivered.
 *
 * PEND_CANCELLED  a callback returned non-zero. Any number of workspaces may run at once.
 * PEND_NO_MEMORY  members whose joints may stick or hit stops run one by one and allocate memory;
 *                 other members do not.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_go(struct pend_ensemble *ensemble, long steps,
                                                  int *done);
