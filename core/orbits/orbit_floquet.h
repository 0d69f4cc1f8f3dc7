/* Floquet multipliers of an orbit, and the tests based on them.
 * Leaves to others: finding the orbit (orbit_newton), changes along a branch (orbits).
 * Invariant: multipliers of orbits between two states of rest come in exact pairs x, 1 / x. Without
 * a drive the pair of the orbit itself and of its energy is exactly 1. */
#pragma once

#include "core/orbits/orbit_newton.h"

/* the points at which real multipliers cross the unit circle */
enum orbit_border { ORBIT_PLUS /* +1 */, ORBIT_MINUS /* -1 */, ORBIT_REAL };

struct orbit_floquet {
    int n;
    double *re, *im; /* 2 n multipliers of the whole period */
    /* For the computed part of the orbit: the number of real multipliers beyond each boundary; the
     * number beyond it by more than rounding errors; the number outside the unit circle, where a
     * complex pair counts as two. */
    int beyond[ORBIT_REAL], surely[ORBIT_REAL], outside;
    double test[ORBIT_REAL]; /* changes sign when a real multiplier crosses a boundary */
    int stable;              /* whether no small disturbance grows exponentially */
    double growth;           /* the largest size of a multiplier, at least 1 */
    double *part_re, *part_im, *work;
    double *block;
};

/**
 * Prepares the memory for n arms.
 *
 * floquet  out; released by pend_orbit_floquet_clear, also after a failure.
 *
 * PEND_NO_MEMORY  O(n^2).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_init(struct orbit_floquet *floquet, int n);
void pend_orbit_floquet_clear(struct orbit_floquet *floquet);

/** Returns the bytes of pend_orbit_floquet_init. O(1). */
double pend_orbit_floquet_bytes(int n);

/**
 * Computes the multipliers of the orbit found, from all derivatives.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_at(struct orbit_floquet *floquet,
                                                       struct orbit_newton *newton);

/**
 * Tests whether a neutral disturbance breaks the mirror symmetry of a driven pendulum's orbit. It
 * does if the half period maps the disturbance to minus its mirror image.
 *
 * newton  has evaluated half of the orbit; the multipliers of the whole orbit are not changed.
 * breaks  out.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_floquet_half(struct orbit_floquet *floquet,
                                                         const struct orbit_newton *newton,
                                                         int *breaks);
