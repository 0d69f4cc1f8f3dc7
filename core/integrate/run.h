/* An integration under way: the time loop, and the samples it hands out block by block.
 * Leaves to others: the steps (method_*), threads, deadlines and text (server, api).
 * Invariant: same problem, same bits, however the blocks are cut. */
#ifndef PEND_RUN_H
#define PEND_RUN_H

#include "core/integrate/method.h"

/* A block of samples, time-major in the CALLER's order of arms: phi[i * n + arm]. NULL arrays
 * are not wanted. */
struct pend_samples {
    long cap, count; /* room for cap samples, count are filled */
    double *t;       /* always wanted */
    double *phi, *rate, *acc, *force;
    double *z_re, *z_im, *zd_re, *zd_im;
    double *theta; /* rad, phi + pi/2, of small swings with all the digits that phi as a double does
                      not hold */
    double *kinetic, *potential; /* one value a sample, J */
};

struct pend_run_stats {
    const char *method;
    long steps, rejected, evaluations;
    double energy_drift; /* largest |E - E(start)| over the steps, relative to
                            pend_kinematics_energy_scale; 0 for a method that is linear, and where
                            the problem says no_drift */
    double horizon;  /* s, pend_horizon_until: among the instants handed out, until the run is over;
                        NaN where the  problem names no accuracy */
    double progress; /* 0 .. 1 */
};

struct pend_run;

/**
 * Prepares an integration; no step is taken yet.
 *
 * run      out; NULL on failure.
 * method   from pend_method_find.
 * problem  copied; its tree and its list of instants must outlive the run.
 *
 * PEND_INVALID    tolerances out of the method's range, times not monotonic, a state that is not
 *                 finite.
 * PEND_NO_MEMORY, and what the method's open returns.
 */
PEND_MUST_CHECK enum pend_status pend_run_new(struct pend_run **run,
                                              const struct pend_method *method,
                                              const struct pend_problem *problem,
                                              struct pend_error *error);

void pend_run_free(struct pend_run **run);

/**
 * Integrates on until `samples` is full, the last instant is reached, or `work` is used up, so that
 * a caller can look after its clock and its client in between.
 *
 * samples  cap >= 1; count is set to the number filled, also on failure; it can be 0 while a step
 *          takes long.
 * work     about how many arm-evaluations to spend before coming back; at least one step is taken
 *          or one group of samples made.
 * done     set non-zero once the last instant was handed out.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  error says the time and, if known, the
 * arm. A run that failed stays so.
 */
PEND_MUST_CHECK enum pend_status pend_run_next(struct pend_run *run, struct pend_samples *samples,
                                               double work, int *done, struct pend_error *error);

struct pend_run_stats pend_run_stats(const struct pend_run *run);

/** True where runs of a method can be carried from one process to another. */
int pend_run_carries(const struct pend_method *method);

/**
 * Shows a checkpoint all that a run has in hand between two calls of pend_run_next; where the
 * checkpoint puts it back, into a run that was just made of the same problem, that one hands out
 * what this one would have, bit for bit. Not after a failure.
 *
 * method  of which pend_run_carries.
 *
 * PEND_INVALID  what was put back is not of such a run, which is then worth nothing.
 */
PEND_MUST_CHECK enum pend_status pend_run_carry(struct pend_run *run,
                                                struct pend_checkpoint *checkpoint);

#endif
