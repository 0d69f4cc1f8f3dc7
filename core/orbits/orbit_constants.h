/* The tuning constants of searches for orbits, each with its purpose, its unit, and in brackets the
 * test that fails if the value is three times larger or smaller. A constant that only ends a loop
 * is marked "Safety".
 * Leaves to others: limits of requests (api/base/limits). Invariant: all named tuning constants of
 * the directory are in this file. */
#pragma once

/* If a step takes at most this many corrections, the next one is longer.
 * [orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says] */
enum { BRANCH_EASY = 3 };
/* From this many corrections the next step is shorter. [orbits_switch_round_a_closed_branch] */
enum { BRANCH_HARD = 5 };
/* Shortest step. Unit: longest step. Safety: ends the loop of ever shorter ones. */
static const double branch_shortest = 1e-5;
/* Largest change of direction in a step. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double branch_bend = 0.9;
/* Largest gap of end and start that can be judged, whatever the growth.
 * [searches_end_as_they_must] */
static const double branch_wild = 1e-3;
/* Closer orbits of a branch are the same: the ends of a closed branch, or an orbit at a fold and
 * its mirror image. Unit: step. [orbits_switch_round_a_closed_branch] */
static const double branch_near = 0.1;
/* Most orbits that are searched for to locate a bifurcation. [searches_end_as_they_must] */
enum { CHANGE_MOST = 40 };
/* Accuracy of the location of a bifurcation. Unit: step. [orbits_switch_round_a_closed_branch] */
static const double change_short = 1e-7;
/* An orbit is at a bifurcation if the test of a multiplier is below this, or the slope at a fold.
 * Unit: of slopes, those at the ends. [searches_end_as_they_must] */
static const double change_zero = 1e-10;
/* Orbits this close to a fold are judged by the slope, not by the test of +1. At a crossing of
 * branches, where orbits are inaccurate, the search ends there and looks that far on either side,
 * and the equations change this little along the other branch. Unit: step; tests and slopes at the
 * ends; change in the next direction. [orbits_switch_round_a_closed_branch] */
static const double change_turn = 1e-3;
/* Largest angle between a step and an intermediate orbit on the same branch. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double change_bend = 0.8;
/* Largest slope at an intermediate orbit. Unit: slopes at the ends. [searches_end_as_they_must] */
static const double change_other = 2;
/* First distance at which an orbit is searched for if none is found at a point; each attempt
 * multiplies it by five. Unit: step. [searches_end_as_they_must] */
static const double change_beside = 2e-6;
/* Number of attempts at such distances. [orbits_switch_round_a_closed_branch] */
enum { CHANGE_BESIDE = 5 };
/* The first orbit of a branch may be farther away than requested by at most this factor.
 * [orbits_switch_nowhere_where_no_branch_begins] */
static const double change_near = 8;
/* Closer states are the same: the end of an orbit and its start, or, within ten times as much, its
 * mirror image after half of the period. [searches_end_as_they_must] */
static const double orbits_alike = 1e-6;
/* Accuracy of an orbit: of its end, multiplied by the growth of errors over a period, and of
 * multipliers at the unit circle. [searches_end_as_they_must] */
static const double orbits_exact = 1e-9;
/* Accuracy of multipliers of driven pendulums. A pair with a larger imaginary part is complex.
 * [searches_end_as_they_must] */
static const double floquet_driven = 1e-6;
/* Largest multiple of the base frequency that drives may have. [common_periods_are_found] */
enum { FORM_MULTIPLES = 12 };
/* Relative tolerance of the test for such multiples. [common_periods_are_found] */
static const double form_alike = 1e-12;
/* Most corrections of a search. [searches_end_as_they_must] */
enum { NEWTON_NEAR = 9 };
/* Most corrections if the start is far from the solution. [searches_end_as_they_must] */
enum { NEWTON_FAR = 60 };
/* A correction below this is the last one. [orbits_switch_round_a_closed_branch] */
static const double newton_fine = 1e-13;
/* A correction below this that is not smaller than the previous one is the last one. The next one
 * is expected to be the square, so all derivatives are computed for it if that is below this.
 * [bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides] */
static const double newton_stalled = 1e-8;
/* Longest correction. Unit: rad. [searches_end_as_they_must] */
static const double newton_longest = 0.5;
/* Arm evaluations of a piece of work, a quarter of a millisecond. [searches_end_as_they_must] */
static const double orbits_piece = 20000;
/* First swing of a branch from rest, and its first step. Unit: rad.
 * [a_branch_ends_once_where_a_bifurcation_lies_just_before_its_end] */
static const double orbits_begin = 0.02;
