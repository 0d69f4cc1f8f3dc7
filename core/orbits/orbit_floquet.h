/* Floquet multipliers of an orbit that was found, and what they say about it.
 * Leaves to others: finding it (orbit_newton), where a count changes along a branch (orbits).
 * Invariant: multipliers of orbits between two rests come in pairs x, 1 / x, exactly; the pair of
 * the orbit itself and of its energy is 1, of those without a drive that do not rest too. */
#ifndef PEND_ORBIT_FLOQUET_H
#define PEND_ORBIT_FLOQUET_H

#include "core/orbits/orbit_newton.h"

/* Where real multipliers leave the circle and come back. */
enum orbit_border { ORBIT_PLUS /* +1 */, ORBIT_MINUS /* -1 */, ORBIT_REAL };

struct orbit_floquet {
    int n;
    double *re, *im; /* 2 n multipliers of the whole period */
    /* of the part of the orbit that was computed: how many real ones are beyond a border, and
     * beyond it by more than rounding errors; pairs count twice that are outside the circle */
    int beyond[ORBIT_REAL], surely[ORBIT_REAL], outside;
    double test[ORBIT_REAL]; /* changes sign where a real one passes a border */
    int stable;              /* no small disturbance grows exponentially */
    double growth;           /* the largest size of a multiplier, at least 1 */
    double *part_re, *part_im, *work;
    double *block;
};

/**
 * Prepares the memory for n arms.
 *
 * floquet  out; ends with pend_orbit_floquet_clear whatever is returned.
 *
 * PEND_NO_MEMORY  O(n^2).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_init(struct orbit_floquet *floquet, int n);

/** Frees the memory. */
void pend_orbit_floquet_clear(struct orbit_floquet *floquet);

/** Returns the bytes of pend_orbit_floquet_init. O(1). */
double pend_orbit_floquet_bytes(int n);

/**
 * Fills in the multipliers of the orbit that was found, with all derivatives.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_at(struct orbit_floquet *floquet,
                                                       struct orbit_newton *newton);

/**
 * Whether a disturbance that neither grows nor shrinks breaks the mirror symmetry of an orbit of a
 * driven pendulum: half a period turns such a one into the reverse of its mirror image.
 *
 * newton  has looked at half of the orbit; the multipliers of the whole one are kept.
 * breaks  out.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_half(struct orbit_floquet *floquet,
                                                         const struct orbit_newton *newton,
                                                         int *breaks);

#endif
