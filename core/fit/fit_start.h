/* Where a fit begins, as its data have it: angles of arms, starts of runs, the camera.
 * Leaves to others: what of it is unknown (api), the start of pieces (fit_pieces).
 * Invariant: nothing here is an answer; a search goes on from it. */
#pragma once

#include "core/fit/fit_problem.h"

/** Returns the angle of an arm (the caller's order) at a row, rad, by its own column or by the tips
 * at its ends as the problem's camera has them; NaN where they were not measured. O(columns). */
double pend_fit_start_angle(const struct pend_fit_problem *problem, int arm, long row);

/** Angle and rate of an arm at a row: a parabola through the measurements of its run next to it,
 * two on each side. O(rows columns). */
void pend_fit_start_parabola(const struct pend_fit_problem *problem, int arm, long row, double *phi,
                             double *rate);

/**
 * Angle and rate of an arm at the start of a run, by the first five rows in which it was measured:
 * its pace from the first to the last, each step by the shorter way, or where that changes a
 * parabola. Of up to 30 arms one without
 * a tip of its own is in a line with those between the tips that are measured. Where rates alone
 * are measured their integral is the angle, with hanging in the middle of its first swings.
 *
 * Returns 1; 0 where the arm is not measured in the run: phi and rate are left alone then. The rate
 * is 0 where one row alone has it. O(rows columns).
 */
int pend_fit_start_state(const struct pend_fit_problem *problem, int run, int arm, double *phi,
                         double *rate);

/** Returns where to begin with a zero of an instrument: the direction about which the angles of its
 * columns lie, from hanging or from the arm that they count from, rad; of rates their mean, rad/s.
 * O(rows columns). */
double pend_fit_start_zero(const struct pend_fit_problem *problem, int zero);

/** Returns by how much the angle of the fastest column turns within so many seconds, rad, root mean
 * square; each row goes on from the one before it by the shorter way. 0 where no angle is measured.
 * O(rows columns). */
double pend_fit_start_turned(const struct pend_fit_problem *problem, double seconds);

/**
 * Whether the residuals of a column are ten times the noise of its data and more: a minimum of
 * another motion, as of one with other whole turns. The noise is by how much measurements miss the
 * cubic through two neighbours on each side.
 *
 * residual  rows x columns; NaN where nothing was measured.
 *
 * O(rows columns).
 */
int pend_fit_start_noisy(const struct pend_fit_problem *problem, const double residual[]);

/**
 * Scale and origin of the camera by the places of the tip that is nearest to the pivot: the circle
 * that comes next to them (Kasa), whose radius is the length of the arms on the way there; where
 * they tell none the origin is above the middle of them.
 *
 * camera  of which those numbers are filled in that are NaN; known are the others.
 *
 * Returns 1; 0 where no tip is measured. O(rows columns).
 */
int pend_fit_start_camera(const struct pend_fit_problem *problem, double camera[PEND_FIT_CAMERA]);
