/* Whether a model fits the data of a fit, and what its standard errors are worth: the p-value of
 * chi-squared, the run of the residuals, and measurements that lie far off.
 * Leaves to others: whether the minimum was found (fit_end), sentences (api).
 * Invariant: standard errors are never narrowed; what one test rejects no other accepts. */
#ifndef PEND_FIT_VERDICT_H
#define PEND_FIT_VERDICT_H

#include "core/fit/fit_state.h"

/**
 * Tests the model at the end of a search, and sets `model`, the numbers of the tests, and what lies
 * `beyond`. Where the model is rejected the covariance becomes what least squares have beside noise
 * as large and as alike as the residuals are: (J'J)^-1 J'VJ (J'J)^-1, V that of an autoregression
 * of second order with their autocovariances (Yule and Walker). With a loss the residuals and their
 * slopes are straightened, and the covariance is that of an M-estimate (Huber): variance (J'J)^-1.
 *
 * variance  of a residual, as the standard errors take it; with a loss out: the mean square of psi
 *           over the squared mean of psi'.
 * minimum   whether the search ended at one.
 *
 * After pend_fit_state_look at all rows; chi-squared, degrees of freedom and `explained` are there.
 * PEND_NO_MEMORY, PEND_NOT_FINITE  O(measurements log measurements), and times the squared number
 * of unknowns where residuals are alike.
 */
PEND_MUST_CHECK enum pend_status pend_fit_verdict(struct pend_fit *fit, double *variance,
                                                  int minimum);

#endif
