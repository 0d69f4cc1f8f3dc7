/* Angles of any size as whole turns and a remainder. Dynamics, series and samples are computed
 * from the remainder.
 * Leaves to others: which angles are reduced (run, section, ensemble, lyapunov, modes, and the
 * API for forces).
 * Invariant: angles up to PEND_TURNS_FROM are their own remainder, to the last bit. */
#pragma once

#include <math.h>

/* pi / 2 is M_PI_2 + PEND_QUARTER_LOW */
#define PEND_QUARTER_LOW 0x1.1a62633145c07p-54

/* rad; larger angles are reduced, because their sines, cosines and sums would lose digits */
#define PEND_TURNS_FROM 1024.0

/* A number of about 32 digits. */
struct pend_sum {
    double high, low; /* low is the rounding error of the sum */
};

/** Adds x, and its rounding error to `low` (Knuth's algorithm, without branches). */
static inline void pend_sum_add(struct pend_sum *sum, double x) {
    double high = sum->high + x, part = high - sum->high;
    sum->low += (sum->high - (high - part)) + (x - part);
    sum->high = high;
}

/**
 * Returns the remainder of an angle phi + low: the angle minus whole turns.
 *
 * phi    any finite number, rad.
 * low    the rounding error of phi, rad, or 0.
 * turns  out, the whole turns that were subtracted, rad: remainder + turns = phi + low; NULL if not
 *        needed.
 *
 * Up to PEND_TURNS_FROM in size the remainder is the angle itself, with no turns. Otherwise it lies
 * in [-pi, pi], with an absolute error of at most 2^-102, and with that relative error if `low` is
 * 0. O(1): a product with 2^e / (2 pi) to 192 binary digits (Payne and Hanek).
 */
struct pend_sum pend_turns_rest(double phi, double low, struct pend_sum *turns);

/* rad; for angles theta from the vertical below this, a double stores digits of theta that a double
 * of phi = theta - pi/2 loses */
#define PEND_TURNS_SMALL 0x1p-6

/** Returns the angle from the vertical, phi + low + pi / 2, rounded once if it is small. */
static inline double pend_turns_theta(double phi, double low) {
    double high = phi + M_PI_2, part = high - phi;
    // the rounding error of the sum, and the low part of pi / 2
    double lost = (phi - (high - part)) + (M_PI_2 - part);
    return high + (lost + (low + PEND_QUARTER_LOW));
}

/** Returns phi = theta - pi / 2 of an angle theta from the vertical, with its rounding error. */
static inline struct pend_sum pend_turns_hanging(double theta) {
    double high = theta - M_PI_2, part = high - theta;
    double low = (theta - (high - part)) - (M_PI_2 + part) - PEND_QUARTER_LOW;
    double sum = high + low;
    return (struct pend_sum){sum, low - (sum - high)};
}

/** Returns phi plus whole turns, rounded; phi itself if the turns are 0. */
static inline double pend_turns_add(double phi, double turns_high, double turns_low) {
    return turns_high == 0 ? phi : turns_high + (turns_low + phi);
}
