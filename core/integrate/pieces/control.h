/* Controllers that sample the state of a pendulum and hold their output: laws, delay, limits.
 * Leaves to others: when a motion reaches a sample (rule_control, ensembles), what the laws are
 * (core/tree/rules).
 * Invariant: sample k of a controller is at start + k period, not at a sum of periods; what is kept
 * from sample to sample are doubles, zeros at the start. */
#ifndef PEND_CONTROL_H
#define PEND_CONTROL_H

#include "core/tree/loads.h"
#include "core/tree/rules.h"
#include "core/tree/tree.h"

/** Returns how many doubles the controllers of a pendulum of n coordinates keep. O(controllers). */
size_t pend_control_numbers(const struct pend_rules *rules, int n);

/** Returns the first instant at which a controller samples that has not sampled yet, s.
 * O(controllers). */
double pend_control_next(const struct pend_rules *rules, int n, double start, const double own[]);

/**
 * Lets those controllers sample whose next sample is at `now`.
 *
 * start      s, of the motion, in the time of the drives, as now.
 * phi, rate  n values, stored order.
 * own        pend_control_numbers values.
 *
 * O(n) a controller and, of swing_up, an energy.
 */
void pend_control_sample(const struct pend_tree *tree, const struct pend_loads *loads, double start,
                         double now, const double phi[], const double rate[], double own[]);

/** Returns the output of controller i that acts, N m or N. */
double pend_control_output(const struct pend_rules *rules, int n, int i, const double own[]);

/** Returns the part of all samples at which the output was at a limit, the largest of all
 * controllers, and which that is; 0 before the first. */
double pend_control_saturated(const struct pend_rules *rules, int n, const double own[],
                              int *controller);

#endif
