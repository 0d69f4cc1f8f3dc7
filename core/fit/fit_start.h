/* Initial values of a fit from its data: angles of arms, starts of runs, the camera.
 * Leaves to others: the choice of unknowns (api), the start of pieces (fit_pieces).
 * Invariant: these values are only the start of a search, never an answer. */
#pragma once

#include "core/fit/fit_problem.h"

/* The part of a start that the data determine: nothing, the angle and the rate, or the angle of a
 * turning point. */
enum pend_fit_started { PEND_FIT_START_NONE, PEND_FIT_START_BOTH, PEND_FIT_START_ANGLE };

/** Returns the angle of an arm (the caller's order) at a row, rad, from its own column or from the
 * measured tips at its ends, seen through the problem's camera; of a cart its position, m; NaN if
 * not measured. O(columns). */
double pend_fit_start_angle(const struct pend_fit_problem *problem, int arm, long row);

/** Computes angle and rate of an arm at a row: a parabola through the nearest measurements of its
 * run, two on each side. O(rows columns). */
void pend_fit_start_parabola(const struct pend_fit_problem *problem, int arm, long row, double *phi,
                             double *rate);

/**
 * Computes angle and rate of an arm at the start of a run from its first five measured rows: the
 * mean rate from the first to the last, each step taken the shorter way, or a parabola if the rate
 * changes. With up to 30 arms, an arm without a measured tip is assumed in line with the arms
 * between measured tips. If only rates are measured, the angle is their integral, and the arm hangs
 * in the middle of its first swings. If only passages, accelerations or amplitudes are measured,
 * the start is that of a swing with these values.
 *
 * Returns PEND_FIT_START_NONE if the arm is not measured in the run; then phi and rate are
 * unchanged. The rate is 0 if only one row measures the arm. O(rows columns).
 */
enum pend_fit_started pend_fit_start_state(const struct pend_fit_problem *problem, int run, int arm,
                                           double *phi, double *rate);

/** Returns the start value of an instrument's offset. For angles it is the mean direction of its
 * columns, rad, from the vertical or from the arm to which they are relative; for rates their mean,
 * rad/s. O(rows columns). */
double pend_fit_start_zero(const struct pend_fit_problem *problem, int zero);

/** Returns the root mean square angle, rad, by which the fastest column turns within a given number
 * of seconds. Each row continues from the previous one by the shorter way. 0 if no angle is
 * measured. O(rows columns). */
double pend_fit_start_turned(const struct pend_fit_problem *problem, double seconds);

/**
 * Returns whether the residuals of a column are at least ten times the noise of its data. Then the
 * minimum belongs to another motion, for example one with a different number of turns. The noise is
 * the deviation of measurements from the cubic through two neighbours on each side. residual: rows
 * x columns; NaN if not measured. O(rows columns).
 */
int pend_fit_start_noisy(const struct pend_fit_problem *problem, const double residual[]);

/**
 * Computes scale and origin of the camera from the positions of the measured tip nearest to the
 * pivot: the best circle through them (Kasa), whose radius is the length of the arms up to that
 * tip. If they determine no circle, the origin is above their middle. Only numbers that are NaN are
 * estimated. Returns 1; 0 if no tip is measured. O(rows columns).
 */
int pend_fit_start_camera(const struct pend_fit_problem *problem, double camera[PEND_FIT_CAMERA]);
