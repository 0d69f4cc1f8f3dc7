/* The tuning constants of searches for orbits, one per row: value, unit, purpose, and in brackets
 * the test that fails at three times the value or a third. Rows without brackets have no such test
 * yet.
 * Leaves to others: limits of requests (api/base/limits). Invariant: all named tuning constants of
 * the folder are in this file. */
#pragma once

/* After a step with at most this many, the next one is longer. Unit: corrections.
 * [orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says] */
enum { BRANCH_EASY = 3 };
/* After a step with at least this many, the next one is shorter. Unit: corrections.
 * [orbits_switch_round_a_branch_that_is_closed] */
enum { BRANCH_HARD = 5 };
/* A branch ends if it needs a shorter step. Unit: longest step. */
static const double branch_shortest = 1e-5;
/* Largest turn of the direction in a step. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double branch_bend = 0.9;
/* Closing tolerance, multiplied by the growth of errors over a period. */
static const double branch_closed = 1e-9;
/* Above it closure cannot be decided, whatever the growth. */
static const double branch_wild = 1e-3;
/* Distance from its first orbit at which a branch counts as closed. Unit: step. */
static const double branch_missed = 0.1;
/* Most orbits that are searched to locate a bifurcation. */
enum { CHANGE_MOST = 40 };
/* Accuracy of the location of a bifurcation. Unit: step. */
static const double change_short = 1e-7;
/* An orbit with a smaller test of a multiplier is at a bifurcation. */
static const double change_zero = 1e-11;
/* Slope at a fold. Unit: slopes at the ends. */
static const double change_zero_slope = 1e-9;
/* Slope where two branches meet: orbits with smaller slopes have larger errors. Unit: slopes at the
 * ends. */
static const double change_level = 3e-4;
/* Distance on either side of a fold at which crossing multipliers are tested. Unit: step. */
static const double change_near_turn = 3e-3;
/* If the test of +1 is smaller, the slope determines the side of an orbit. Unit: tests at the
 * ends. */
static const double change_tied = 1e-4;
/* Largest turn between a step and an orbit inside it of the same branch. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double change_bend = 0.8;
/* Largest slope of such an orbit. Unit: slopes at the ends. */
static const double change_other = 2;
/* Distance of an orbit after half of its period from its mirror image below which they are
 * equal. */
static const double change_alike = 1e-5;
/* The same for an orbit at a fold. Unit: step. */
static const double change_alike_turn = 0.1;
/* First distance from a point without an orbit at which one is searched; grows fivefold each time.
 * Unit: step. */
static const double change_beside = 2e-6;
/* Number of such searches. */
enum { CHANGE_BESIDE = 5 };
/* The first orbit of a branch may be at most this many times as far away as requested. */
static const double change_near = 8;
/* An orbit that ends closer to its start has returned. */
static const double check_alike = 1e-6;
/* A multiplier closer to the circle is on it. */
static const double floquet_border = 1e-9;
/* The same for driven pendulums; a larger imaginary part makes a pair complex. */
static const double floquet_driven = 1e-6;
/* Largest multiple of one frequency that drives may have. */
enum { FORM_MULTIPLES = 12 };
/* Tolerance for frequencies of drives to be multiples of one. Unit: relative. */
static const double form_alike = 1e-12;
/* Most corrections. Unit: corrections. */
enum { NEWTON_NEAR = 9 };
/* Most corrections from far away. Unit: corrections. */
enum { NEWTON_FAR = 60 };
/* A correction of this size is the last one. */
static const double newton_fine = 1e-13;
/* A correction below this that no longer decreases is the last one.
 * [bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides] */
static const double newton_stalled = 1e-8;
/* After such a correction the next is likely to be the last, and computes all derivatives. */
static const double newton_nearly = 1e-4;
/* Longest correction. Unit: rad. */
static const double newton_longest = 0.5;
/* Smallest part of a correction that is tried from far away. */
static const double newton_least = (1.0 / 256);
/* A direction in which the equations change by less is that of another branch. Unit: next
 * direction. */
static const double switch_least = 1e-3;
/* Size of a piece of work in arm-evaluations, a quarter of a millisecond. */
static const double orbits_piece = 20000;
/* First swing of a branch from rest, and its first step. Unit: rad.
 * [a_branch_ends_once_where_a_bifurcation_lies_just_before_its_end] */
static const double orbits_begin = 0.02;
