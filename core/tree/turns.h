/* Angles of any size as whole turns and a rest, exactly: what dynamics, series and samples are
 * computed from.
 * Leaves to others: which angles are reduced (run, section, ensemble, lyapunov, modes, and the
 * API for forces).
 * Invariant: angles up to PEND_TURNS_FROM are their own rest, to the last bit. */
#ifndef PEND_TURNS_H
#define PEND_TURNS_H

/* rad; sines and cosines of larger angles, and sums of them, would cost digits */
#define PEND_TURNS_FROM 1024.0

/* A number of about 32 digits. */
struct pend_sum {
    double high, low; /* low is what rounding the sum leaves */
};

/**
 * The rest of an angle phi + low: the angle less whole turns.
 *
 * phi    any finite number, rad.
 * low    what rounding has left of it, or 0.
 * turns  out, the whole turns that were taken away, rad: rest + turns = phi + low; NULL = not
 *        wanted.
 *
 * Up to PEND_TURNS_FROM in size the angle itself and no turns; else within [-pi, pi] and off by at
 * most 2^-102 of 1, and of the rest where `low` is 0. O(1): a product with 2^e / (2 pi) to 192
 * places.
 */
struct pend_sum pend_turns_rest(double phi, double low, struct pend_sum *turns);

/* rad, up to which angles from hanging have digits that doubles of angles from the real axis do
 * not hold */
#define PEND_TURNS_SMALL 0x1p-6

/** The angle from hanging, phi + low + pi / 2, rounded once where it is small. */
static inline double pend_turns_theta(double phi, double low) {
    double high = phi + 0x1.921fb54442d18p+0, part = high - phi;
    // what the sum has lost, and the second half of pi / 2
    double lost = (phi - (high - part)) + (0x1.921fb54442d18p+0 - part);
    return high + (lost + (low + 0x1.1a62633145c07p-54));
}

/** The angle phi = theta - pi / 2 of an angle from hanging, with what rounding has left of it. */
static inline struct pend_sum pend_turns_hanging(double theta) {
    double high = theta - 0x1.921fb54442d18p+0, part = high - theta;
    double low = (theta - (high - part)) - (0x1.921fb54442d18p+0 + part) - 0x1.1a62633145c07p-54;
    double sum = high + low;
    return (struct pend_sum){sum, low - (sum - high)};
}

/** phi plus whole turns, rounded; phi itself where turns are 0. */
static inline double pend_turns_add(double phi, double turns_high, double turns_low) {
    return turns_high == 0 ? phi : turns_high + (turns_low + phi);
}

#endif
