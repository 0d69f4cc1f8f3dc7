/* Tests whether a model fits the data and whether its standard errors are valid: the p-value of
 * chi-squared, the autocorrelation of the residuals, and outliers.
 * Leaves to others: whether the minimum was found (fit_end), sentences (api).
 * Invariant: standard errors are never decreased; a model that one test rejects is not accepted by
 * another. */
#pragma once

#include "core/fit/fit_state.h"

/**
 * Tests the model at the end of a search, and sets `model`, the results of the tests, and `beyond`.
 * If the model is rejected, the covariance becomes that of least squares with noise of the size and
 * autocorrelation of the residuals: (J'J)^-1 J'VJ (J'J)^-1, V that of an autoregression of second
 * order with their autocovariances (Yule and Walker). With a robust loss the transformation of
 * residuals and slopes is undone, and the covariance is that of an M-estimate (Huber): variance
 * (J'J)^-1.
 *
 * variance  of a residual, for the standard errors; with a loss out: the mean square of psi over
 *           the squared mean of psi'.
 * minimum   whether the search ended at a minimum.
 *
 * After pend_fit_state_look at all rows; chi-squared, degrees of freedom and `explained` must be
 * set.
 * PEND_NO_MEMORY, PEND_NOT_FINITE  O(measurements log measurements), times the squared number of
 *                                  unknowns if residuals are correlated.
 */
PEND_MUST_CHECK enum pend_status pend_fit_verdict(struct pend_fit *fit, double *variance,
                                                  int minimum);
