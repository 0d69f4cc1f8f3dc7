/* Rows of a motion in pieces: states, accelerations, forces and series of all arms while some of
 * their joints hold.
 * Leaves to others: the loop (pieces).
 * Invariant: an instant's bits do not depend on the other instants of a call. */
#ifndef PEND_PIECES_ROWS_H
#define PEND_PIECES_ROWS_H

#include "core/bodies/bodies.h"
#include "core/integrate/methods/method.h"

/** Fills in rows as a method's `at` does. */
void pend_pieces_at(void *stepper, const double t[], int count, const struct pend_points *points);

/**
 * The last step's series for all arms of a pendulum that is not pend_pieces_smooth.
 *
 * series  as the method's `series` gives it.
 * rate    out, coefficient j of arm k at [j n + k], j = 0 .. order, as those of the jets.
 * phi, phi_low  out, n values each, at the step's beginning.
 *
 * O(n order).
 */
void pend_pieces_series(const void *stepper, const struct pend_series *series, double rate[],
                        double phi[], double phi_low[]);

/**
 * Accelerations and forces of a state inside the last step, or at the start, of a pendulum that is
 * not pend_pieces_smooth.
 *
 * time    s, in the time of the drives.
 * acc     out, n values.
 * forces  out, as of pend_bodies_at.
 */
void pend_pieces_forces(void *stepper, double time, const double phi[], const double rate[],
                        double acc[], const struct bodies_forces *forces);

#endif
