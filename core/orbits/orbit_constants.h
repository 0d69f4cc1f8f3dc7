/* The tuning constants of searches for orbits, a row each: value, unit, what it decides, and in
 * brackets the test that fails at three times the value or a third. A row without has none yet.
 * Leaves to others: limits of requests (api/base/limits). Invariant: no other file of the folder
 * has such a number by name. */
#ifndef PEND_ORBIT_CONSTANTS_H
#define PEND_ORBIT_CONSTANTS_H

/* A step with as many or fewer is followed by a longer one. Unit: corrections.
 * [orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says] */
enum { BRANCH_EASY = 3 };
/* A step with as many or more is followed by a shorter one. Unit: corrections.
 * [orbits_switch_round_a_branch_that_is_closed] */
enum { BRANCH_HARD = 5 };
/* A branch ends where a shorter step would be needed. Unit: longest step. */
static const double branch_shortest = 1e-5;
/* Largest turn of the direction in a step. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double branch_bend = 0.9;
/* Closing tolerance, times the growth of errors over a period. */
static const double branch_closed = 1e-9;
/* Above it closure cannot be decided, whatever the growth. */
static const double branch_wild = 1e-3;
/* How near a branch passes its first orbit when it closes. Unit: step. */
static const double branch_missed = 0.1;
/* Most orbits that are looked for to locate a bifurcation. */
enum { CHANGE_MOST = 40 };
/* A bifurcation is located to this. Unit: step. */
static const double change_short = 1e-7;
/* Test of a multiplier that is so small is at a bifurcation. */
static const double change_zero = 1e-11;
/* Slope at a fold. Unit: slopes at the ends. */
static const double change_zero_slope = 1e-9;
/* Slope where two branches meet: orbits nearer to it have larger errors. Unit: slopes at the ends.
 */
static const double change_level = 3e-4;
/* Where on either side of a turn it is seen whether a multiplier passes. Unit: step. */
static const double change_near_turn = 3e-3;
/* Test of +1 below which the slope says on which side an orbit is. Unit: tests at the ends. */
static const double change_tied = 1e-4;
/* Largest turn between a step and an orbit inside it of the same branch. Unit: cosine.
 * [bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else] */
static const double change_bend = 0.8;
/* Largest slope of such an orbit. Unit: slopes at the ends. */
static const double change_other = 2;
/* How near its mirror image an orbit is after half of its period. */
static const double change_alike = 1e-5;
/* The same of an orbit at a turn. Unit: step. */
static const double change_alike_turn = 0.1;
/* How far beside a place without an orbit one is looked for; five times as far each time. Unit:
 * step. */
static const double change_beside = 2e-6;
/* How often it is looked for there. */
enum { CHANGE_BESIDE = 5 };
/* How many times farther than looked for the first orbit of a branch may be. */
static const double change_near = 8;
/* An orbit that misses its start by less has come back. */
static const double check_alike = 1e-6;
/* A multiplier nearer to the circle is on it. */
static const double floquet_border = 1e-9;
/* The same of driven pendulums; the imaginary part that tells a pair. */
static const double floquet_driven = 1e-6;
/* Largest multiple of one frequency that drives may have. */
enum { FORM_MULTIPLES = 12 };
/* Frequencies of drives are multiples of one to this. Unit: relative. */
static const double form_alike = 1e-12;
/* Most corrections. Unit: corrections. */
enum { NEWTON_NEAR = 9 };
/* Most corrections from far away. Unit: corrections. */
enum { NEWTON_FAR = 60 };
/* A correction of this size is the last one. */
static const double newton_fine = 1e-13;
/* A correction below this that no longer shrinks is the last one.
 * [bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides] */
static const double newton_stalled = 1e-8;
/* After such a correction the next is likely to be the last: all derivatives. */
static const double newton_nearly = 1e-4;
/* Longest correction. Unit: rad. */
static const double newton_longest = 0.5;
/* Least part of a correction that is tried from far away. */
static const double newton_least = (1.0 / 256);
/* Change of the equations in a direction in which another branch leaves. Unit: next direction. */
static const double switch_least = 1e-3;
/* Arm-evaluations of a piece of work, a quarter of a millisecond. */
static const double orbits_piece = 20000;
/* First swing of a branch from a rest, and its first step. Unit: rad.
 * [a_branch_ends_once_where_a_bifurcation_lies_just_before_its_end] */
static const double orbits_begin = 0.02;

#endif
