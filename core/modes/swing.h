/* The period of a single pendulum that swings by any amplitude.
 * Leaves to others: frequencies of small swings (modes, damped).
 * Invariant: without friction. */
#pragma once

#include <math.h>

/** Returns agm(1, cos(amplitude / 2)), the ratio of a swing's frequency to that of a small swing
 * (Gauss). amplitude in rad, 0 .. pi without pi. O(1). */
static inline double pend_swing_slow(double amplitude) {
    double a = 1, b = cos(amplitude / 2);
    for (double next; fabs(a - b) > 1e-15 * a; a = next) next = (a + b) / 2, b = sqrt(a * b);
    return a;
}
