/* The order of the power series that reaches a tolerance at the least cost, and the size of the
 * first neglected term.
 * Leaves to others: memory (method_taylor caps the order of huge trees).
 * Invariant: all members of an ensemble have the same order. */
#pragma once

#include "core/tree/loads.h"

enum { PEND_TAYLOR_ORDER_MIN = 8, PEND_TAYLOR_ORDER_MAX = 30 };

/**
 * Returns the limit of the first neglected term of a step, relative to the motion of the step. It
 * is a hundredth of rtol, but not below round-off; unless the motion amplifies errors, the error of
 * a run then stays near rtol.
 *
 * rtol  > 0.
 */
double pend_taylor_target(double rtol);

/**
 * Returns the same limit as an absolute bound: a hundredth of atol, rad and rad/s.
 *
 * atol  >= 0.
 */
double pend_taylor_atol(double atol);

/* The upper limit of that bound, relative to the motion of the step, as a binary logarithm: the
 * limit of the largest rtol. Near the radius of convergence a larger term would not bound the terms
 * after it. */
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
 * Returns the unit of time of a motion's first series, s: a power of two near the time that the
 * fastest arm takes for a radian, estimated from the start; 1 if nothing will move.
 *
 * length  n lengths, m.
 * rate    n angular velocities, rad/s.
 * O(n).
 */
double pend_taylor_first_unit(int n, const struct pend_loads *loads, const double length[],
                              const double rate[]);
