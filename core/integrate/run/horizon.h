/* The horizon of a motion, up to which its accuracy holds: the error is estimated during the
 * integration. The linearized equations, or a neighbour at a small distance, show how errors grow,
 * and the error of every step is added.
 * Leaves to others: the steps (method_*), the neighbour (neighbour), the requested instants (run),
 * the exact comparison with 32 digits (trust).
 * Invariant: the estimate does not change the motion's bits; the same problem gives the same
 * estimate. */
#pragma once

#include "core/integrate/methods/method.h"

/* Errors are assumed to be larger than their estimate by this factor. */
#define PEND_HORIZON_MARGIN 2.0

struct pend_horizon;

/**
 * Prepares an estimate.
 *
 * horizon  out; NULL on failure; released by pend_horizon_free.
 * method   the method that computes the motion.
 * problem  checked by pend_run_check, with an accuracy > 0. Its tree and its list of instants must
 *          outlive the estimate.
 *
 * PEND_NO_MEMORY
 * O(n) memory: the power series of one neighbour for trees of more than PEND_JETS_PAD arms and for
 * real pendulums, and one more series for methods without a series of their own.
 */
PEND_MUST_CHECK enum pend_status pend_horizon_new(struct pend_horizon **horizon,
                                                  const struct pend_method *method,
                                                  const struct pend_problem *problem,
                                                  struct pend_error *error);
void pend_horizon_free(struct pend_horizon **horizon);

/**
 * Adds an accepted step to the estimate. To be called after each step, in order. It does nothing
 * once the accuracy is lost.
 *
 * stepper    stepper of the method, after the step.
 * reached    the end of the step, s, relative to the first instant.
 * phi, rate  the state at that end, n values each, stored order.
 *
 * Cost, with the two orders that the Taylor method computes for the estimate in some steps: at
 * most three tenths of a step of a small tree, a little more in runs of thousands of periods, and
 * nothing once the accuracy is lost; less for other methods.
 */
void pend_horizon_step(struct pend_horizon *horizon, void *stepper, double reached,
                       const double phi[], const double rate[]);

/** Returns the last requested instant, s, among those already passed, up to which the accuracy
 * holds; the first instant if it holds up to no later one. The accuracy bounds the errors of all
 * angles, rad; of all angular velocities, relative to the largest angular velocity so far; and of
 * all forces, relative to the largest force so far. This is an estimate: for 504 random motions of
 * every kind, it was between half of the true instant and a tenth beyond it. O(log of the number of
 * instants). */
double pend_horizon_until(const struct pend_horizon *horizon);

/** Returns the time up to which the accuracy holds, s, relative to the first instant and not
 * rounded to a requested instant; `reached` if the accuracy is not lost yet. O(1). */
double pend_horizon_held(const struct pend_horizon *horizon, double reached);

/** Saves the state of an estimate to a checkpoint, or restores it; parameters and errors as
 * pend_run_carry. */
PEND_MUST_CHECK enum pend_status pend_horizon_carry(struct pend_horizon *horizon,
                                                    struct pend_checkpoint *checkpoint);
