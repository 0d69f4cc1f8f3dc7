/* Bounds of unknowns: the search varies unbounded inner numbers instead of the unknowns.
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
