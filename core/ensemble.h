/* Many trajectories of one tree's shape, several at once in the lanes of the processor's vectors.
 * Leaves to others: where members come from and where results go (callbacks), threads (server).
 * Invariant: a member's result does not depend on its lane, its neighbours, or how the members are shared out: the same
 * bits on every thread count, and on avx2 and avx512 alike (base, without fused multiply-add, differs in rounding). */
#ifndef PEND_ENSEMBLE_H
#define PEND_ENSEMBLE_H

#include "core/isa.h"
#include "core/tree.h"

/* One member's start; arrays of n values in the tree's stored order, filled with the tree's own lengths, masses, the
 * problem's gravity and zeros before fetch is called. */
struct pend_member {
    double *phi, *rate;    /* rad, rad/s */
    double *length, *mass; /* m, kg, finite and > 0 */
    double gravity;        /* m/s^2 */
};

enum pend_stop { PEND_STOP_TIME, PEND_STOP_BOUND, PEND_STOP_FAILED };

/* What became of a member; arrays of n values in stored order, valid during the call only. */
struct pend_outcome {
    enum pend_stop stop;
    enum pend_status status; /* PEND_OK, or why it failed: PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS */
    double time;             /* s, where it ended */
    int arm;                 /* stored number of the arm that crossed its bound first, -1 = none did */
    const double *phi, *rate;
    const double *first_crossing; /* s, of each arm; NaN = it never crossed; NULL when no bound was asked for */
    const long *crossings;        /* how often each arm crossed; NULL when no bound was asked for */
    long steps;
};

/** Fills in the start of member number i; non-zero ends the run as cancelled. */
typedef int pend_fetch_fn(void *context, long i, struct pend_member *member);
/** Receives the outcome of member number i, in the order in which members end; non-zero ends the run as cancelled. */
typedef int pend_deliver_fn(void *context, long i, const struct pend_outcome *outcome);

struct pend_ensemble_problem {
    const struct pend_tree *tree;
    double gravity;    /* m/s^2 */
    double duration;   /* s, either sign */
    double rtol, atol; /* as of the taylor method */
    double bound; /* rad, > 0: theta = phi + pi/2 crossing bound + 2 i bound, i any integer, is noted: pi for flips,
                     anything for a bound of your own; touching it inside a step counts; 0 = not wanted */
    int stop_at_bound; /* non-zero: a member ends at its first crossing */
    long step_cap;     /* most steps of a member, 0 = no limit */
    pend_fetch_fn *fetch;
    pend_deliver_fn *deliver;
    void *context;
};

struct pend_ensemble;

/**
 * Prepares a workspace for one thread.
 *
 * ensemble  out; NULL on failure; ends with pend_ensemble_free.
 * problem   copied; its tree must outlive the workspace.
 * isa       pend_isa_best(), or a lower one.
 *
 * PEND_INVALID    a tolerance, the bound or the duration is out of range.
 * PEND_NO_MEMORY
 * One allocation.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_new(struct pend_ensemble **ensemble,
                                                   const struct pend_ensemble_problem *problem, enum pend_isa isa,
                                                   struct pend_error *error);

void pend_ensemble_free(struct pend_ensemble **ensemble);

/**
 * Computes the members first .. first + count - 1; a lane whose member ends takes the next.
 *
 * A member that fails is delivered as failed, the others stand.
 *
 * PEND_CANCELLED  a callback asked for it.
 * No allocation. Any number of workspaces may run at once.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_run(struct pend_ensemble *ensemble, long first, long count);

#endif
