/* Controllers that sample the state of a pendulum and hold their output: laws, delay, limits.
 * Leaves to others: stopping a motion at a sample (pieces), the parameters of the laws
 * (core/tree/rules).
 * Invariant: sample k of a controller is at start + k period, not at a sum of periods; the state of
 * a controller consists of doubles, initially 0. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/rules.h"
#include "core/tree/tree.h"

/** Returns the number of doubles in the state of all controllers of a pendulum of n coordinates; 0
 * without controllers. rules may be NULL. O(controllers). */
size_t pend_control_numbers(const struct pend_rules *rules, int n);

/** Returns the time of the next sample of any controller, s. O(controllers). */
double pend_control_next(const struct pend_rules *rules, int n, double start, const double own[]);

/**
 * Updates the controllers whose next sample is at `now`.
 *
 * start      s, start of the motion, in the time of the drives, like `now`.
 * phi, rate  n values, stored order.
 * own        pend_control_numbers values.
 *
 * O(n) per controller; swing_up also computes the energy.
 */
void pend_control_sample(const struct pend_tree *tree, const struct pend_loads *loads, double start,
                         double now, const double phi[], const double rate[], double own[]);

/** Returns the present output of controller i, N m or N. */
double pend_control_output(const struct pend_rules *rules, int n, int i, const double own[]);

/** Returns, of all controllers, the largest fraction of samples at a limit, and the index of that
 * controller; 0 before the first sample. */
double pend_control_saturated(const struct pend_rules *rules, int n, const double own[],
                              int *controller);

/** Returns true if the angles of all arms, without whole turns, are within a bound, rad, of the
 * reference of the first controller's last law, which must be a feedback law. O(n). */
int pend_control_near(const struct pend_tree *tree, const struct pend_loads *loads, double now,
                      const double phi[], double bound);

/** Returns the final law of controller i, which follows all swing-ups. O(laws). */
static inline const struct pend_law *pend_control_last(const struct pend_rules *rules, int i) {
    const struct pend_law *law = rules->law + rules->controller[i].law;
    while (law->kind == PEND_LAW_SWING_UP) law = rules->law + law->next;
    return law;
}
