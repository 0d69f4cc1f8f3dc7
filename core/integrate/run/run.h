/* A running integration: the time loop, which returns samples block by block.
 * Leaves to others: the steps (method_*), threads, deadlines and text (server, api).
 * Invariant: the same problem gives the same bits, whatever the sizes of the blocks. */
#pragma once

#include "core/integrate/methods/method.h"
#include "core/integrate/run/samples.h"

struct pend_run_stats {
    const char *method;
    long steps, rejected, evaluations;
    double energy_drift; /* largest |E - E(start)| over the steps, relative to
                          * pend_kinematics_energy_scale; 0 for linear methods and with no_drift;
                          * NaN if an energy overflows */
    double horizon;      /* s, pend_horizon_until for the instants returned so far; NaN without an
                          * accuracy, and for linear methods */
    double held;         /* s, the same horizon, not rounded to a requested instant */
    double progress;     /* fraction of the run that is complete, 0 .. 1 */
    double saturated;    /* pend_control_saturated, and the index of its controller */
    int controller;
};

struct pend_run;

/**
 * Prepares an integration; no step is taken yet.
 *
 * run      out; NULL on failure; released by pend_run_free.
 * method   from pend_method_find.
 * problem  copied; its tree and its list of instants must outlive the run.
 *
 * PEND_INVALID    tolerances out of the method's range, times not monotonic, a state that is not
 *                 finite.
 * PEND_NO_MEMORY, and the failures of the method's `open`.
 * O(n), and the cost of `open`.
 */
PEND_MUST_CHECK enum pend_status pend_run_new(struct pend_run **run,
                                              const struct pend_method *method,
                                              const struct pend_problem *problem,
                                              struct pend_error *error);
void pend_run_free(struct pend_run **run);

/**
 * Continues the integration until `samples` is full, the last instant is reached, or `work` is used
 * up, so that the caller can check its deadline and its client between calls.
 *
 * samples  cap >= 1; count becomes the number of samples, also on failure; it can be 0.
 * work     approximate number of arm evaluations that this call may use; it takes at least one step
 *          or computes one group of samples.
 * done     out: non-zero once the sample of the last instant was returned.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  error contains the time and, if known,
 * the arm. Later calls return the same failure.
 */
PEND_MUST_CHECK enum pend_status pend_run_next(struct pend_run *run, struct pend_samples *samples,
                                               double work, int *done, struct pend_error *error);

/** Returns the statistics of a run so far. O(log of the number of instants). */
struct pend_run_stats pend_run_stats(const struct pend_run *run);

/** Returns true if runs of a method can be saved by a checkpoint. */
int pend_run_carries(const struct pend_method *method);

/**
 * Saves the state of a run to a checkpoint between two calls of pend_run_next, or restores it. A
 * run that is newly created for the same problem and then restored returns the same samples, bit
 * for bit. The run must not have failed, and pend_run_carries its method.
 *
 * PEND_INVALID  the restored state does not belong to such a run, which can then only be freed.
 */
PEND_MUST_CHECK enum pend_status pend_run_carry(struct pend_run *run,
                                                struct pend_checkpoint *checkpoint);
