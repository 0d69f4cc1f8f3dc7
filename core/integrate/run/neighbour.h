/* How the error of a state changes in one step: the power series of a neighbouring motion, at a
 * small distance in the direction of the error, minus that of the motion itself.
 * Leaves to others: the errors of steps, and the allowed error (horizon); the same for small ideal
 * trees, whose equations are linearized (pend_jets_spread).
 * Invariant: the motion's series are only read. */
#pragma once

#include "core/integrate/methods/method.h"
#include "core/taylor/jets/jets.h"

struct pend_neighbour {
    const struct pend_problem *problem;
    struct pend_jets jets;
    struct jets_state state;
    int order;    /* order of the last expansion; kept from step to step */
    double cart;  /* m, divisor that converts a cart's position to an angle; 0 without a cart */
    double speed; /* rad/s, range of linear dry friction; 0 = no friction */
    double *sum, *before; /* rows of partial sums, and of the previous column */
};

/** Returns the factor that makes the error of coordinate k comparable with errors of angles. */
static inline double pend_neighbour_share(double cart, int k) {
    return k || cart == 0 ? 1 : 1 / cart;
}

/** Returns the larger of two values; NaN if one is NaN. */
static inline double pend_larger(double x, double y) { return x > y ? x : y; }

/** Returns the bytes of memory, a multiple of 64, for series up to order `cap`. O(n). */
size_t pend_neighbour_bytes(const struct pend_problem *problem, int cap);

/**
 * Prepares a neighbour.
 *
 * neighbour  must not be moved.
 * problem    must outlive the neighbour.
 * cap        highest order, PEND_JETS_ORDER_MIN .. PEND_JETS_ORDER_MAX.
 * cart       m, as in the structure.
 * memory     pend_neighbour_bytes(problem, cap) bytes, aligned to 64; not owned.
 */
void pend_neighbour_init(struct pend_neighbour *neighbour, const struct pend_problem *problem,
                         int cap, double cart, void *memory);

/**
 * Replaces the errors at the start of a step by those x units later, to first order.
 *
 * Uses as many orders as it takes for the last two terms to be below `least`. A series whose terms
 * do not decrease, for example in a contracting motion, is summed by Wynn's vector epsilon
 * algorithm (P. Wynn, Math. Comp. 16 (1962) 301): a rational function that decays where e^-x does.
 *
 * step       jets, begin, unit and order are used; order <= cap.
 * least      allowed truncation relative to the error, > 0.
 * phi, rate  in and out: the errors, rad and rad/s, n values each.
 *
 * Returns the largest error of a force at the start, N. O(n order^2), no allocation.
 */
double pend_neighbour_spread(struct pend_neighbour *neighbour, const struct pend_series *step,
                             double x, double least, double phi[], double rate[]);
