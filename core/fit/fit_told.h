/* Identifiability of the unknowns, from the slopes at a minimum: the singular values of the
 * Jacobian matrix and their directions.
 * Leaves to others: the slopes (fit_model), the search (fit).
 * Invariant: an unknown at a bound has no component in any identifiable direction. */
#pragma once

#include <stddef.h>

#include "core/base/status.h"

struct fit_told {
    int q;              /* number of unknowns */
    double *direction;  /* q x q: column d is the direction of singular value d */
    double *value;      /* q singular values, descending */
    double *gain;       /* q: component of the remaining residuals in each direction */
    double *change;     /* measurements x q: the change of the residuals along a direction,
                         * normalized to length 1 */
    const double *size; /* scales of the q unknowns */
    double least;       /* directions with a smaller singular value are not identifiable */
};

/**
 * Decomposes slopes, m x q, of m >= q measurements with respect to q unknowns; pend_fit_told_clear
 * also after a failure. fixed: unknowns at a bound, whose slopes count as 0. size: must outlive
 * `told`.
 *
 * PEND_NOT_FINITE  slopes times sizes are not finite, or above 1e140. PEND_NO_MEMORY  O(m q^2).
 */
PEND_MUST_CHECK enum pend_status pend_fit_told_init(struct fit_told *told, size_t m, int q,
                                                    const double slope[], const double residual[],
                                                    const unsigned char fixed[],
                                                    const double size[]);
void pend_fit_told_clear(struct fit_told *told);

/**
 * Makes directions with a smaller singular value identifiable if their effect is well above
 * rounding and their standard error is below 1000 times the scale of the unknowns. In chaotic
 * motions the effect of one direction can be 1e9 times that of others, which are identifiable all
 * the same. variance: of a residual. O(1).
 */
void pend_fit_told_sure(struct fit_told *told, double variance);

/** Returns whether direction d is identifiable: its effect is above 1e-9 of the largest, or
 * pend_fit_told_sure accepted it. O(1). */
int pend_fit_told_is(const struct fit_told *told, int d);

/** Computes the covariance of the unknowns, q x q, in their own units, for residuals of variance 1,
 * without the directions that are not identifiable. O(q^3). */
void pend_fit_told_covariance(const struct fit_told *told, double covariance[]);

/** Computes the residuals minus their components in all identifiable directions, m numbers. O(m
 * q). */
void pend_fit_told_rest(const struct fit_told *told, size_t m, const double residual[],
                        double rest[]);

/** Returns the decrease of the sum of squares by one more step, to first order. O(q). */
double pend_fit_told_gain(const struct fit_told *told);

/**
 * Computes a Newton step along the identifiable directions, each scaled by its effect on the
 * residuals, so that narrow and wide valleys are treated alike.
 *
 * bend        q x q: change of the gradient (half the derivatives with respect to relative changes
 *             of the unknowns, rows) along the directions, columns.
 * noise       error of `bend` in directions that do not change the residuals; smaller values count
 *             as 0.
 * loose       error per singular value in directions that change the residuals.
 * gain        out: decrease of the sum of squares by the step; infinite if this is not a minimum.
 * covariance  out, q x q, in the unknowns' own units, unless the gain is infinite; NULL if not
 *             needed.
 *
 * PEND_NO_MEMORY  O(q^3).
 */
PEND_MUST_CHECK enum pend_status pend_fit_told_newton(const struct fit_told *told,
                                                      const double bend[], double noise,
                                                      double loose, double *gain,
                                                      double covariance[]);

/**
 * Copies the directions that are not identifiable, each with a largest component of 1, to most x q
 * numbers: first single unknowns that the data do not depend on, then combinations. Returns their
 * number, without those of unknowns at a bound. O(q^2).
 */
int pend_fit_told_blind(const struct fit_told *told, const unsigned char fixed[], int most,
                        double to[]);
