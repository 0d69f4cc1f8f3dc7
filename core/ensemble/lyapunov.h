/* Lyapunov exponents of a motion: the growth rates of small deviations in several directions, which
 * are made orthonormal after each interval.
 * Leaves to others: the steps, which the motion and its neighbours take together (ensemble).
 * Invariant: neighbours are close enough for a linear law of their distances; otherwise an interval
 * is computed again in shorter pieces. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_lyapunov_problem {
    const struct pend_tree *tree; /* must outlive the computation */
    struct pend_loads loads;      /* gravity and other loads; its terms and their values must
                                   * outlive the computation too */
    /* the start, n values each, stored order; copied. A cart's position is measured in lengths of
     * the shortest arm. */
    const double *phi, *rate;
    int count;       /* number of exponents, 1 .. 2 n, the largest ones */
    double interval; /* s, > 0: time after which the directions are made orthonormal again; this may
                      * happen more often */
    double rtol;     /* local error tolerance of the motions, as for the taylor method; 0 = 1e-14 */
    const double *phi_low; /* rad, low-order part of phi, n values; NULL = 0 */
    double start;          /* s, the start of the motion in the time of its drives */
};

struct pend_lyapunov;

/**
 * Prepares a computation at time 0.
 *
 * lyapunov  out; NULL on failure; released by pend_lyapunov_free.
 *
 * PEND_INVALID    the count, the interval or the tolerance is out of range.
 * PEND_NO_MEMORY  6 n x count numbers.
 */
PEND_MUST_CHECK enum pend_status pend_lyapunov_new(struct pend_lyapunov **lyapunov,
                                                   const struct pend_lyapunov_problem *problem,
                                                   struct pend_error *error);
void pend_lyapunov_free(struct pend_lyapunov **lyapunov);

/**
 * Continues the current interval. The results' bits do not depend on `steps`.
 *
 * steps  the largest number of steps of all lanes in this call.
 * done   out: non-zero if the interval is over; the next call starts another.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  the motion, or a neighbour of it,
 * cannot be computed.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_lyapunov_go(struct pend_lyapunov *lyapunov, long steps,
                                                  int *done, struct pend_error *error);

/** Discards the intervals so far as a transient: the exponents will be computed from later
 * intervals. The directions are kept. */
void pend_lyapunov_forget(struct pend_lyapunov *lyapunov);

/**
 * Fills in the exponents over the intervals so far, 1/s.
 *
 * exponent  out, `count` values; 0 before the first interval is over.
 */
void pend_lyapunov_exponents(const struct pend_lyapunov *lyapunov, double exponent[]);

/**
 * Computes the standard error of each exponent, 1/s: the error of the mean over 16 to 31 time spans
 * of equal length, from the scatter of their growth rates, plus 1 over the total time, because the
 * directions take time to align. About two in three exponents computed over a longer time lie
 * within one error, nearly all within two. Exponents whose true value is 0 lie within two errors of
 * 0. With fewer than four spans, the error is at least the size of the exponent.
 *
 * error  out, `count` values.
 */
void pend_lyapunov_errors(const struct pend_lyapunov *lyapunov, double error[]);

/** Copies the motion's state at the end of the last interval: rad, with whole turns removed, and
 * rad/s. */
void pend_lyapunov_state(const struct pend_lyapunov *lyapunov, double phi[], double rate[]);

/** Returns the divisor of differences of rates, 1/s, that makes them comparable with differences of
 * angles. */
double pend_lyapunov_frequency(const struct pend_lyapunov *lyapunov);

/** Returns the number of integration steps of all motions so far. */
long pend_lyapunov_steps(const struct pend_lyapunov *lyapunov);
