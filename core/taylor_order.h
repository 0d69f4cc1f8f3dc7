/* The order of the power series that reaches a tolerance at the least cost.
 * Leaves to others: memory (method_taylor caps the order of huge trees).
 * Invariant: the same for one trajectory and for a member of an ensemble. */
#ifndef PEND_TAYLOR_ORDER_H
#define PEND_TAYLOR_ORDER_H

enum { PEND_TAYLOR_ORDER_MIN = 8, PEND_TAYLOR_ORDER_MAX = 30 };

/**
 * The order, PEND_TAYLOR_ORDER_MIN .. PEND_TAYLOR_ORDER_MAX.
 *
 * rtol  > 0.
 */
int pend_taylor_order(double rtol);

#endif
