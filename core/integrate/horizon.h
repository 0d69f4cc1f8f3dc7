/* How far an answer's digits reach: the error of a computed motion, estimated while it is
 * computed. The equations made linear, or a neighbour at a small distance, show how errors
 * spread, and every step's own error is added to it.
 * Leaves to others: the steps (method_*), the wanted instants (run), the exact comparison with
 * 32 digits (trust).
 * Invariant: the motion's bits do not depend on it; the same problem gives the same estimate. */
#ifndef PEND_HORIZON_H
#define PEND_HORIZON_H

#include "core/integrate/method.h"

/* By how much errors are taken to be larger than their estimate. */
#define PEND_HORIZON_MARGIN 3.0

struct pend_horizon;

/**
 * Prepares an estimate.
 *
 * horizon  out; NULL on failure; ends with pend_horizon_free.
 * method   the one that computes the motion.
 * problem  checked, with the method's defaults in place; its accuracy > 0. Its tree and its list of
 *          instants must outlive the estimate.
 *
 * PEND_NO_MEMORY. O(n) memory: of trees of more than PEND_JETS_PAD arms the power series of one
 * neighbour, and of methods that have no series of their own one more series.
 */
PEND_MUST_CHECK enum pend_status pend_horizon_new(struct pend_horizon **horizon,
                                                  const struct pend_method *method,
                                                  const struct pend_problem *problem,
                                                  struct pend_error *error);

void pend_horizon_free(struct pend_horizon **horizon);

/**
 * Takes an accepted step into account; to be called after each of them, in their order. Nothing is
 * done once the accuracy is lost.
 *
 * stepper    the method's, after the step.
 * reached    s, relative to the first instant.
 * phi, rate  the state there, n values each, stored order.
 *
 * Cost: with the two orders that the Taylor method computes for it, less than a tenth of its step
 * in the mean of long runs, where nothing is done once the accuracy is lost, and three tenths of
 * the step of a small tree before that; of other methods' steps less.
 */
void pend_horizon_step(struct pend_horizon *horizon, const void *stepper, double reached,
                       const double phi[], const double rate[]);

/**
 * The last of the wanted instants, among those that the steps have passed, up to which the errors
 * of all angles stay within the problem's accuracy, rad, those of all angular velocities within the
 * accuracy times the largest angular velocity of any arm so far, and those of all forces within the
 * accuracy times the largest force in any arm so far. s; the first instant where it is lost at
 * once. An estimate: the truth is seldom less, and not by over a tenth. O(log of the number of
 * instants).
 */
double pend_horizon_until(const struct pend_horizon *horizon);

/**
 * The same between instants: s from the first one on, of the sign of time's direction; up to it the
 * accuracy is kept. `reached` where it is not lost yet.
 */
double pend_horizon_held(const struct pend_horizon *horizon, double reached);

/** Shows a checkpoint all that an estimate has in hand, as pend_run_carry. */
PEND_MUST_CHECK enum pend_status pend_horizon_carry(struct pend_horizon *horizon,
                                                    struct pend_checkpoint *checkpoint);

#endif
