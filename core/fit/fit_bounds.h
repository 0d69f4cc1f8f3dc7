/* Bounds of unknowns, for which the search varies unbounded inner numbers, and robust losses.
 * Leaves to others: the fit (fit).
 * Invariant: a value is between its bounds for any inner number: by a sine for two bounds, an
 * exponential for one. */
#pragma once

#include <math.h>

#include "core/fit/fit_problem.h"

/** Returns the value of an unknown for an inner number. O(1). */
static inline double fit_bounds_outer(const struct pend_fit_unknown *u, double x) {
    if (isfinite(u->low) && isfinite(u->high))
        return u->low + (u->high - u->low) * 0.5 * (1 + sin(x));
    if (isfinite(u->low)) return u->low + exp(x);
    if (isfinite(u->high)) return u->high - exp(x);
    return x;
}

/** Returns the inner number for a value between the bounds. O(1). */
static inline double fit_bounds_inner(const struct pend_fit_unknown *u, double value) {
    if (isfinite(u->low) && isfinite(u->high))
        return asin(2 * (value - u->low) / (u->high - u->low) - 1);
    if (isfinite(u->low)) return log(value - u->low);
    if (isfinite(u->high)) return log(u->high - value);
    return value;
}

/** Returns the derivative of the value with respect to its inner number. O(1). */
static inline double fit_bounds_stretch(const struct pend_fit_unknown *u, double x) {
    if (isfinite(u->low) && isfinite(u->high)) return (u->high - u->low) * 0.5 * cos(x);
    if (isfinite(u->low)) return exp(x);
    if (isfinite(u->high)) return -exp(x);
    return 1;
}

/** Returns whether a value counts as being at a bound: its distance is below a millionth of the
 * interval, or of the bound's size if there is only one bound. No inner number reaches a bound
 * exactly. O(1). */
static inline int fit_bounds_at(const struct pend_fit_unknown *u, double value) {
    double size = fmax(fabs(u->start), 1e-3);
    if (isfinite(u->low) && isfinite(u->high)) size = u->high - u->low;
    return value - u->low < 1e-6 * size || u->high - value < 1e-6 * size;
}

/* ---- Robust losses, with SciPy's names: with z = (residual / knee)^2, the fit minimizes the sum
 * of knee^2 rho(z) instead of that of squares. The search treats them as squares of transformed
 * residuals; the transformation is the identity to first order at 0. */

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
