/* What measurements tell of the unknowns, from the slopes at a minimum: the singular values of the
 * Jacobian matrix and their directions.
 * Leaves to others: the slopes (fit_model), the search (fit).
 * Invariant: an unknown at a bound has no part in any direction that the data tell. */
#ifndef PEND_FIT_TOLD_H
#define PEND_FIT_TOLD_H

#include <stddef.h>

#include "core/base/status.h"

struct fit_told {
    int q;              /* unknowns */
    double *direction;  /* q x q: column d is the direction of singular value d */
    double *value;      /* q, descending */
    double *gain;       /* q: what a direction still takes from the residuals */
    double *change;     /* measurements x q: what a direction changes in them, of length 1 */
    const double *size; /* q: what an unknown is measured in */
    double least;       /* a smaller singular value's direction is not told */
};

/**
 * Decomposes slopes.
 *
 * told      out; ends with pend_fit_told_clear, also after a failure.
 * m, q      measurements and unknowns, m >= q.
 * slope     m x q.
 * residual  m.
 * fixed     q flags: unknowns at a bound, whose slopes count as 0.
 * size      q numbers, which must outlive `told`.
 *
 * PEND_NOT_FINITE  slopes times sizes are no numbers, or above 1e140.
 * PEND_NO_MEMORY   O(m q^2).
 */
PEND_MUST_CHECK enum pend_status pend_fit_told_init(struct fit_told *told, size_t m, int q,
                                                    const double slope[], const double residual[],
                                                    const unsigned char fixed[],
                                                    const double size[]);

/** Frees the memory. */
void pend_fit_told_clear(struct fit_told *told);

/**
 * Lets a direction be told whose effect is less than that part of the largest, but well above its
 * rounding, and such that its standard error is below 1000 times what the unknowns are measured in:
 * chaotic motions tell one direction by 1e9 times as much as others, which they tell well.
 *
 * variance  of a residual.
 *
 * O(1).
 */
void pend_fit_told_sure(struct fit_told *told, double variance);

/** Whether the data tell direction d: its effect is above 1e-9 of the largest, or less than that
 * and sure. O(1). */
int pend_fit_told_is(const struct fit_told *told, int d);

/** The covariance of the unknowns, q x q, in their own units, for residuals of variance 1; what is
 * not told has no part in it. O(q^3). */
void pend_fit_told_covariance(const struct fit_told *told, double covariance[]);

/** What of the residuals is left once every direction that the data tell has taken its part, m
 * numbers. O(m q). */
void pend_fit_told_rest(const struct fit_told *told, size_t m, const double residual[],
                        double rest[]);

/** What one more step could take from the sum of squares, to first order. O(q). */
double pend_fit_told_gain(const struct fit_told *told);

/**
 * A step of Newton's method along the directions that the data tell, each measured by what it
 * changes in the residuals, so that a narrow valley is no flatter than others.
 *
 * bend        q x q: half of the derivative of the sum of squares by relative changes of unknowns,
 *             rows, as it changes along directions, columns.
 * noise       error of these where the residuals do not change; what is less counts as 0.
 * loose       the same over a direction's singular value where they do.
 * gain        out: what the step takes from the sum of squares; infinite at what is no minimum.
 * covariance  out, q x q, in the unknowns' own units, unless the gain is infinite; NULL = not
 * wanted.
 *
 * PEND_NO_MEMORY  O(q^3).
 */
PEND_MUST_CHECK enum pend_status pend_fit_told_newton(const struct fit_told *told,
                                                      const double bend[], double noise,
                                                      double loose, double *gain,
                                                      double covariance[]);

/**
 * Copies the directions that are not told, each with a largest part of 1: first the unknowns that
 * the data do not depend on at all, one by one, then what is not told apart.
 *
 * to  most x q.
 *
 * Returns how many; those of unknowns at a bound are left out. O(q^2).
 */
int pend_fit_told_blind(const struct fit_told *told, const unsigned char fixed[], int most,
                        double to[]);

#endif
