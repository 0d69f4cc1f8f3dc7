/* Second derivatives of the sum of squares at the end of a search, if its slopes do not decide
 * whether that is a minimum. Example: if no pendulum has the given frequencies, the closest match
 * has two equal values. There the frequencies depend on neither value to first order, and a step of
 * any size seems to be a gain.
 * Leaves to others: first derivatives (fit_told), how a fit ends (fit_end).
 * Invariant: value, residual, slope and held of the fit are restored. */
#pragma once

#include "core/fit/fit_state.h"

/**
 * Computes half of the second derivative of the sum of squares along a direction of relative
 * changes; divided by the variance of a residual it is 1 / (standard error)^2. 0 if the motion
 * cannot be computed.
 *
 * After pend_fit_state_look at all rows. PEND_NO_MEMORY  three motions with derivatives.
 */
PEND_MUST_CHECK enum pend_status pend_fit_curve_along(struct pend_fit *fit,
                                                      const double direction[], double *bend);

/**
 * Computes the decrease of the sum of squares by a Newton step; infinite if this is not a minimum
 * with respect to the unknowns that are not fixed.
 *
 * covariance  out if the step is finite: of the unknowns that are not fixed, for residuals of
 *             variance 1; otherwise unchanged. NULL if not needed.
 *
 * After pend_fit_state_look at all rows. PEND_NO_MEMORY  twice as many motions with derivatives as
 * there are unknowns.
 */
PEND_MUST_CHECK enum pend_status pend_fit_curve_gain(struct pend_fit *fit, double *gain,
                                                     double covariance[]);
