/* A trajectory in numbers of about 32 digits, used to check the digits of trajectories in doubles.
 * Leaves to others: instants and samples (run, by way of method_extended).
 * Invariant: its bits are the same on avx2 and avx512. */
#pragma once

#include "core/base/checkpoint.h"
#include "core/base/isa.h"
#include "core/tree/loads.h"

#define PEND_EXTENDED_RTOL_MIN 1e-30

/* A state as sums of two doubles: n values each, stored order. */
struct pend_extended_state {
    double *phi, *phi_low;   /* rad */
    double *rate, *rate_low; /* rad/s */
};

struct pend_extended;

/**
 * Prepares a workspace for one thread.
 *
 * extended  out; NULL on failure; released by pend_extended_free.
 * tree      must outlive the workspace; lengths and masses are taken as exact doubles.
 * terms     of real pendulums, the same as in the loads, or NULL; must outlive the workspace.
 * rtol      PEND_EXTENDED_RTOL_MIN .. 0.1, of the local error; the error of a motion that is not
 *           chaotic stays near it.
 * atol      0 .. 1.
 * isa       pend_isa_best(), or a lower one.
 *
 * PEND_INVALID  a tolerance is out of range, or the series would take more than 1 GiB.
 * PEND_NO_MEMORY One allocation.
 */
PEND_MUST_CHECK enum pend_status pend_extended_new(struct pend_extended **extended,
                                                   const struct pend_tree *tree,
                                                   const struct pend_terms *terms, double rtol,
                                                   double atol, enum pend_isa isa,
                                                   struct pend_error *error);
void pend_extended_free(struct pend_extended **extended);

/**
 * Starts a trajectory in the workspace, at time 0.
 *
 * loads    gravity of any finite value, and the workspace's terms, whose values are copied.
 * state    copied; phi_low and rate_low may be NULL: zero.
 * start    s, time 0 in the time of drives.
 * stop     s, end of the trajectory, either sign; a step ends there exactly.
 */
void pend_extended_start(struct pend_extended *extended, const struct pend_loads *loads,
                         const struct pend_extended_state *state, double start, double stop);

/** Changes the time at which the trajectory stops, s. It must remain on the same side of
 * the current time. */
void pend_extended_stop(struct pend_extended *extended, double stop);

/** Replaces the values of the workspace's terms for the steps that follow. */
void pend_extended_value(struct pend_extended *extended, const double value[]);

enum pend_extended_stage { PEND_EXTENDED_UNDER_WAY, PEND_EXTENDED_STOPPED, PEND_EXTENDED_FAILED };

/** Takes one step; returns the new stage. No allocation, O(n order^2). */
enum pend_extended_stage pend_extended_step(struct pend_extended *extended);

/** Returns the time at the end of the last step, s. */
double pend_extended_time(const struct pend_extended *extended);

/** Returns the number of orders of the series that a step computes. */
int pend_extended_order(const struct pend_extended *extended);

/** Copies the state at the end of the last step, or at the start. */
void pend_extended_end(const struct pend_extended *extended,
                       const struct pend_extended_state *state);

/** Saves the state to a checkpoint, or restores it. The checkpoint holds the start of the last
 * step; after a restore, which follows pend_extended_start of the same trajectory, that step is
 * computed again. */
void pend_extended_carry(struct pend_extended *extended, struct pend_checkpoint *checkpoint);

/**
 * Computes values at instants inside the last step, as doubles and their rounding errors.
 *
 * count  any.
 * t      s; taken as exact.
 * to     receives instant i of arm k at [i * n + k]; phi_low and rate_low may be NULL.
 * acc    out, rad/s^2, NULL if not needed.
 * force  out, N, NULL if not needed.
 */
void pend_extended_at(const struct pend_extended *extended, int count, const double t[],
                      const struct pend_extended_state *to, double acc[], double force[]);

/** Computes the power of drives, and of friction and drag, of a real pendulum in the last step:
 * series about the step's start in x = (t - its start) / unit, pend_extended_order coefficients
 * each, J times unit^2, rounded to doubles. Returns the unit, s. O(n order^2). */
double pend_extended_power(const struct pend_extended *extended, double work[], double heat[]);
