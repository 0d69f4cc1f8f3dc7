/* Robust losses, with SciPy's names: with z = (residual / knee)^2, the fit minimizes the sum of
 * knee^2 rho(z) instead of that of squares. The search treats them as squares of transformed
 * residuals.
 * Leaves to others: the choice of loss and knees (api).
 * Invariant: the transformation is the identity to first order at 0. */
#pragma once

#include <math.h>

#include "core/fit/fit_problem.h"

/** Computes a loss at z: `rho`, its derivative `slope`, and psi' of psi = residual times slope.
 * O(1). */
struct fit_loss {
    double rho, slope, psi;
};

static inline struct fit_loss fit_loss_at(enum pend_fit_loss loss, double z) {
    double root = sqrt(1 + z);
    if (loss == PEND_FIT_HUBER && z > 1) return (struct fit_loss){2 * sqrt(z) - 1, 1 / sqrt(z), 0};
    if (loss == PEND_FIT_SOFT_L1)
        return (struct fit_loss){2 * z / (root + 1), 1 / root, 1 / (root * root * root)};
    if (loss == PEND_FIT_CAUCHY)
        return (struct fit_loss){log1p(z), 1 / (1 + z), (1 - z) / ((1 + z) * (1 + z))};
    return (struct fit_loss){z, 1, 1};
}

/** Returns the transformed residual, whose square is knee^2 rho(z); `by`: its derivative with
 * respect to the residual. O(1). */
static inline double fit_loss_bend(enum pend_fit_loss loss, double knee, double r, double *by) {
    double z = r / knee * (r / knee);
    struct fit_loss at = fit_loss_at(loss, z);
    *by = z > 1e-30 ? at.slope * sqrt(z / at.rho) : 1;
    return z > 1e-30 ? r * sqrt(at.rho / z) : r;
}

/** Returns the residual for a transformed residual. O(1). */
static inline double fit_loss_straight(enum pend_fit_loss loss, double knee, double bent) {
    double u = bent / knee * (bent / knee), z = u;
    if (loss == PEND_FIT_HUBER && u > 1) z = (u + 1) * (u + 1) / 4;
    if (loss == PEND_FIT_SOFT_L1) z = u + u * u / 4;
    if (loss == PEND_FIT_CAUCHY) z = expm1(u);
    return copysign(knee * sqrt(z), bent);
}
