/* Trajectories in numbers of about 32 digits, several of one tree's shape at once, one a lane. The
 * digits of trajectories in doubles are checked against them.
 * Leaves to others: instants and samples (run, by way of method_extended), threads (server).
 * Invariant: a trajectory's bits do not depend on its lane or its neighbours, and are the same
 * on avx2 and avx512. */
#ifndef PEND_EXTENDED_H
#define PEND_EXTENDED_H

#include "core/ensemble/member.h"
#include "core/base/checkpoint.h"
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
 * extended  out; NULL on failure; ends with pend_extended_free.
 * tree      must outlive the workspace; lengths and masses are taken as the doubles that they are.
 * terms     of real pendulums, as those of the loads; must outlive the workspace; or NULL.
 * rtol      PEND_EXTENDED_RTOL_MIN .. 0.1, of the local error; the error of a motion that is not
 *           chaotic stays near it.
 * atol      0 .. 1.
 * single    non-zero: only lane 0 will be started; the bits are the same, in less time than with
 *           idle lanes.
 * isa       pend_isa_best(), or a lower one.
 *
 * PEND_INVALID  a tolerance is out of range, or the series would take more than 1 GiB (some 20 000
 *               arms in 8 lanes).
 * PEND_NO_MEMORY One allocation.
 */
PEND_MUST_CHECK enum pend_status pend_extended_new(struct pend_extended **extended,
                                                   const struct pend_tree *tree,
                                                   const struct pend_terms *terms, double rtol,
                                                   double atol, int single, enum pend_isa isa,
                                                   struct pend_error *error);

/** Frees a workspace and clears the pointer; NULL is accepted. */
void pend_extended_free(struct pend_extended **extended);

/** Returns the number of lanes: 2, 4 or 8. */
int pend_extended_width(const struct pend_extended *extended);

/**
 * Puts a trajectory into a lane, at time 0. Lanes that were never started repeat lane 0.
 *
 * loads    what acts on the tree; gravity of any finite value; the workspace's terms, whose numbers
 *          are copied.
 * state    copied; phi_low and rate_low may be NULL: zero.
 * start    s, what time 0 is in the time of drives.
 * stop     s, where the lane is to stop, either sign; a step ends there exactly.
 */
void pend_extended_start(struct pend_extended *extended, int lane, const struct pend_loads *loads,
                         const struct pend_extended_state *state, double start, double stop);

/** Changes the time at which a lane stops, s; the new time is on the same side of the lane's
 * time. */
void pend_extended_stop(struct pend_extended *extended, int lane, double stop);

/**
 * Takes one step in every lane that has not stopped. No allocation, O(n order^2) a lane.
 *
 * Returns how many lanes stopped or failed in this step.
 */
int pend_extended_step(struct pend_extended *extended);

enum pend_extended_lane { PEND_EXTENDED_UNDER_WAY, PEND_EXTENDED_STOPPED, PEND_EXTENDED_FAILED };

/** Returns the state of a lane. */
enum pend_extended_lane pend_extended_lane(const struct pend_extended *extended, int lane);

/** Returns the time at the end of a lane's last step, s. */
double pend_extended_time(const struct pend_extended *extended, int lane);

/** Returns the number of steps of a lane since its start. */
long pend_extended_steps(const struct pend_extended *extended, int lane);

/** Returns the number of orders of the series, which a step computes. */
int pend_extended_order(const struct pend_extended *extended);

/** Copies the state at the end of a lane's last step, or at its start. */
void pend_extended_end(const struct pend_extended *extended, int lane,
                       const struct pend_extended_state *state);

/**
 * Saves the state of lane 0 to a checkpoint, or restores it, for a workspace in which no other lane
 * was started. The checkpoint holds the start of the lane's last step; after a restore, which
 * follows pend_extended_start of the same trajectory, that step is computed again.
 */
void pend_extended_carry(struct pend_extended *extended, struct pend_checkpoint *checkpoint);

/**
 * Values of a lane at instants inside its last step, as doubles and their rounding errors.
 *
 * count  any.
 * t      s; taken as exact.
 * to     instant i of arm k at [i * n + k]; phi_low and rate_low may be NULL.
 * acc    out, rad/s^2, NULL = not wanted.
 * force  out, N, NULL = not wanted.
 */
void pend_extended_at(const struct pend_extended *extended, int lane, int count, const double t[],
                      const struct pend_extended_state *to, double acc[], double force[]);

/**
 * The power of drives, and what friction and the air take, in a lane's last step, of a real
 * pendulum: series about the step's start in x = (t - its start) / unit, pend_extended_order
 * coefficients each, J times unit^2, rounded to doubles. Returns the unit, s. O(n order^2).
 */
double pend_extended_power(const struct pend_extended *extended, int lane, double work[],
                           double heat[]);

/**
 * Many trajectories, as pend_ensemble_run: a lane whose member has ended takes the next member.
 * Only the duration ends a member.
 *
 * problem  has the workspace's tree and tolerances; bounds, observations and instants are ignored.
 *
 * PEND_CANCELLED  a callback returned non-zero. No allocation.
 */
PEND_MUST_CHECK enum pend_status pend_extended_run(struct pend_extended *extended,
                                                   const struct pend_ensemble_problem *problem,
                                                   long first, long count);

#endif
