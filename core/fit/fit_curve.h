/* Second derivatives of the sum of squares at the end of a search: where its slopes alone do not
 * say whether that is a minimum. Frequencies that no pendulum has are met best where two values
 * become alike, and there they change with neither: to first order a step of any size would gain.
 * Leaves to others: first derivatives (fit_told), how a fit ends (fit_end).
 * Invariant: value, residual, slope and held of the fit are afterwards as they were. */
#ifndef PEND_FIT_CURVE_H
#define PEND_FIT_CURVE_H

#include "core/fit/fit_state.h"

/**
 * How the sum of squares bends along a direction of relative changes, half of its second
 * derivative: over the variance of a residual it is 1 / (standard error)^2. 0 where there is no
 * motion.
 *
 * After pend_fit_state_look at all rows. PEND_NO_MEMORY  three motions with derivatives.
 */
PEND_MUST_CHECK enum pend_status pend_fit_curve_along(struct pend_fit *fit,
                                                      const double direction[], double *bend);

/**
 * What a step of Newton's method could take from the sum of squares: infinite where it is no
 * minimum of those unknowns that are not held.
 *
 * covariance  out where the step is finite: of the unknowns that are not held, for residuals of
 *             variance 1; else left alone. NULL = not wanted.
 *
 * After pend_fit_state_look at all rows. PEND_NO_MEMORY  twice as many motions with derivatives as
 * there are unknowns.
 */
PEND_MUST_CHECK enum pend_status pend_fit_curve_gain(struct pend_fit *fit, double *gain,
                                                     double covariance[]);

#endif
