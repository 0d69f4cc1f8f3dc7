/* The tuning constants of searches for orbits, each with its purpose, its unit, and in brackets the
 * test that fails if the value is three times larger or smaller. Constants without brackets have no
 * such test yet.
 * Leaves to others: limits of requests (api/base/limits). Invariant: all named tuning constants of
 * the directory are in this file. */
#pragma once

/* If a step takes at most this many corrections, the next one is longer. Unit: corrections.
 * [orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says] */
enum { BRANCH_EASY = 3 };
/* If a step takes at least this many corrections, the next one is shorter. Unit: corrections.
 * [orbits_switch_round_a_branch_that_is_closed] */
enum { BRANCH_HARD = 5 };
/* Shortest step; the branch ends if it is not enough. Unit: longest step. */
static const double branch_shortest = 1e-5;
/* Largest change of direction in a step. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double branch_bend = 0.9;
/* Closing tolerance, multiplied by the growth of errors over a period. */
static const double branch_closed = 1e-9;
/* Largest closing error that can be judged, whatever the growth. */
static const double branch_wild = 1e-3;
/* Largest distance from its first orbit at which a branch counts as closed. Unit: step. */
static const double branch_missed = 0.1;
/* Most orbits that are searched for to locate a bifurcation. */
enum { CHANGE_MOST = 40 };
/* Accuracy of the location of a bifurcation. Unit: step. */
static const double change_short = 1e-7;
/* An orbit is at a bifurcation if the test of a multiplier is below this. */
static const double change_zero = 1e-11;
/* Largest slope at a fold. Unit: slopes at the ends. */
static const double change_zero_slope = 1e-9;
/* Largest slope at a crossing of branches, where small slopes make orbits inaccurate. Unit: slopes
 * at the ends. */
static const double change_level = 3e-4;
/* Distance on either side of a fold at which crossing multipliers are tested. Unit: step. */
static const double change_near_turn = 3e-3;
/* If the test of +1 is below this, the slope determines the side of an orbit. Unit: tests at the
 * ends. */
static const double change_tied = 1e-4;
/* Largest angle between a step and an intermediate orbit on the same branch. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double change_bend = 0.8;
/* Largest slope of such an intermediate orbit. Unit: slopes at the ends. */
static const double change_other = 2;
/* A symmetric orbit is closer than this to its mirror image after half of its period. */
static const double change_alike = 1e-5;
/* The same for an orbit at a fold. Unit: step. */
static const double change_alike_turn = 0.1;
/* First distance at which an orbit is searched for if none is found at a point; each attempt
 * multiplies it by five. Unit: step. */
static const double change_beside = 2e-6;
/* Number of such attempts. */
enum { CHANGE_BESIDE = 5 };
/* The first orbit of a branch may be farther away than requested by at most this factor. */
static const double change_near = 8;
/* An orbit has returned if its end is closer to its start than this. */
static const double check_alike = 1e-6;
/* A multiplier counts as on the unit circle if it is closer to it than this. */
static const double floquet_border = 1e-9;
/* The same for driven pendulums. A larger imaginary part makes a pair complex. */
static const double floquet_driven = 1e-6;
/* Largest multiple of the base frequency that drives may have. */
enum { FORM_MULTIPLES = 12 };
/* Tolerance in the test that all drive frequencies are multiples of one. Unit: relative. */
static const double form_alike = 1e-12;
/* Most corrections of a search. Unit: corrections. */
enum { NEWTON_NEAR = 9 };
/* Most corrections if the start is far from the solution. Unit: corrections. */
enum { NEWTON_FAR = 60 };
/* A correction below this is the last one. */
static const double newton_fine = 1e-13;
/* A correction below this that is not smaller than the previous one is the last one.
 * [bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides] */
static const double newton_stalled = 1e-8;
/* After a smaller correction the next is likely to be the last: all derivatives are computed. */
static const double newton_nearly = 1e-4;
/* Longest correction. Unit: rad. */
static const double newton_longest = 0.5;
/* Smallest fraction of a correction that is tried if the start is far from the solution. */
static const double newton_least = (1.0 / 256);
/* A direction in which the equations change by less than this belongs to another branch. Unit:
 * change in the next direction. */
static const double switch_least = 1e-3;
/* Size of a piece of work, which takes about a quarter of a millisecond. Unit: arm evaluations. */
static const double orbits_piece = 20000;
/* First swing of a branch from rest, and its first step. Unit: rad.
 * [a_branch_ends_once_where_a_bifurcation_lies_just_before_its_end] */
static const double orbits_begin = 0.02;
