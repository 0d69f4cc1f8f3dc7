/* The order of the power series that reaches a tolerance at the least cost, and the size of the term left out.
 * Leaves to others: memory (method_taylor caps the order of huge trees).
 * Invariant: the same for one trajectory and for a member of an ensemble. */
#ifndef PEND_TAYLOR_ORDER_H
#define PEND_TAYLOR_ORDER_H

enum { PEND_TAYLOR_ORDER_MIN = 8, PEND_TAYLOR_ORDER_MAX = 30 };

/**
 * What the first neglected term of a step may be, relative to the motion of the step: a hundredth of rtol, so that the
 * error of a run stays near rtol while it is not amplified, but never below round-off.
 *
 * rtol  > 0.
 */
double pend_taylor_target(double rtol);

/**
 * The order, PEND_TAYLOR_ORDER_MIN .. PEND_TAYLOR_ORDER_MAX.
 *
 * rtol  > 0.
 */
int pend_taylor_order(double rtol);

#endif
