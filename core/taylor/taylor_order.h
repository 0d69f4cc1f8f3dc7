/* The order of the power series that reaches a tolerance at the least cost, and the size of the
 * first neglected term.
 * Leaves to others: memory (method_taylor caps the order of huge trees).
 * Invariant: all members of an ensemble have the same order. */
#pragma once

#include "core/tree/loads.h"

enum { PEND_TAYLOR_ORDER_MIN = 8, PEND_TAYLOR_ORDER_MAX = 30 };

/**
 * Returns the limit of the first neglected term of a step, relative to the motion of the step. It
 * is a hundredth of rtol, but at least round-off. The error of a run then stays near rtol unless
 * the motion amplifies errors.
 *
 * rtol  > 0.
 */
double pend_taylor_target(double rtol);

/**
 * Returns the limit of the first neglected term as an absolute bound: a hundredth of atol, rad and
 * rad/s.
 *
 * atol  >= 0.
 */
double pend_taylor_atol(double atol);

/* The upper bound of that limit relative to the motion of the step, as log2: the limit for the
 * largest rtol. Near the radius of convergence a larger term would not bound the terms after it. */
#define PEND_TAYLOR_LOG_CAP (-9.965784284662087)

/**
 * Returns the order, PEND_TAYLOR_ORDER_MIN .. PEND_TAYLOR_ORDER_MAX.
 *
 * rtol   > 0.
 * alone  non-zero for one trajectory: near round-off it takes two more orders, because the fixed
 *        cost of a step is higher and fewer steps cause less rounding.
 */
int pend_taylor_order(double rtol, int alone);

/**
 * Returns the unit of time for a motion's first series, s: a power of two near the time in which
 * the fastest arm turns by a radian, estimated from the start; 1 if nothing will move. O(n).
 *
 * length  n lengths, m.
 * rate    n angular velocities, rad/s.
 */
double pend_taylor_first_unit(int n, const struct pend_loads *loads, const double length[],
                              const double rate[]);
