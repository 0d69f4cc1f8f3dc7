/* Passages of conditions of random motions, and their check in 32 digits.
 * Leaves to others: the searches (events, core/ensemble), random pendulums (trees, bodies).
 * Invariant: conditions are on values that the motion reaches; nothing of the search is used. */
#pragma once

#include "core/integrate/events/event_search.h"
#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/trees.h"

enum {
    TEST_PASSAGES_ARMS = 4,
    TEST_PASSAGES_MOST = 4000,
    TEST_PASSAGES_CONDITIONS = 12,
    TEST_PASSAGES_GRID = 120,
    TEST_PASSAGES_EXTREMES = TEST_PASSAGES_CONDITIONS / 3
};

/* s, duration of a motion whose passages are searched for */
extern const double test_passages_duration;

/* The results of a search. */
struct test_passages {
    int count;
    struct pend_hit hit[TEST_PASSAGES_MOST];
    double phi[TEST_PASSAGES_MOST][TEST_PASSAGES_ARMS],
        rate[TEST_PASSAGES_MOST][TEST_PASSAGES_ARMS];
    double stopped; /* s */
};

/** Samples in 32 digits at instants after the start, which is the first of them. Ends with
 * test_record_clear. */
void test_passages_exactly(struct test_record *record, const struct test_tree *t,
                           const struct pend_loads *loads, long count, const double time[]);

/** The same at TEST_PASSAGES_GRID instants of the duration. */
void test_passages_grid(struct test_record *record, const struct test_tree *t,
                        const struct pend_loads *loads);

/**
 * Conditions of all kinds on values that the motion reaches; a level is between the quantity at two
 * random instants of the grid.
 *
 * conserves  non-zero: the energy is none of them.
 */
void test_passages_conditions(struct pend_event event[TEST_PASSAGES_CONDITIONS],
                              const struct test_tree *t, const struct test_record *grid,
                              int conserves, unsigned long long *seed);

/**
 * Draws random pendulum number i, ideal if i is even, its grid and its conditions. The grid ends
 * with test_record_clear, the tree and the bodies as in trees and bodies.
 */
void test_passages_random(struct test_tree *t, struct test_bodies *b, struct test_record *grid,
                          struct pend_event event[TEST_PASSAGES_CONDITIONS], int i,
                          unsigned long long *seed);

/**
 * Conditions beside extremes of random quantities, found in 32 digits, three for each: a level
 * 1e-10 of its scale inside the extreme, which is passed twice near it, one as far outside, which
 * is not, and the first again.
 *
 * time  s, out: the extremes; NaN if the quantity is no parabola.
 *
 * Returns how many are parabolas; 0, without conditions, if the motion has too few extremes.
 */
int test_passages_grazing(struct pend_event event[TEST_PASSAGES_CONDITIONS],
                          double time[TEST_PASSAGES_EXTREMES], const struct test_tree *t,
                          const struct pend_loads *loads, const struct test_record *grid,
                          int conserves, unsigned long long *seed);

/** Checks that the passages found near the extremes of test_passages_grazing are those pairs, and
 * those of the third condition if the first has them. */
void test_passages_grazed(const struct test_passages *found,
                          const double time[TEST_PASSAGES_EXTREMES]);

/**
 * Checks that the passages are in the order of time, that each condition's are one way and the
 * other in turn, are as many between instants of the grid as its changes of side there, but for
 * pairs, and that the quantity is on the right side between them.
 *
 * Returns the largest part by which a quantity misses its level in 32 digits: of its scale, and of
 * the most that a unit of the start, of every angle and rate, has made of it until then, so that
 * chaos does not count.
 */
double test_passages_check(const struct test_passages *found, const struct test_tree *t,
                           const struct pend_loads *loads, const struct test_record *grid,
                           const struct pend_event event[TEST_PASSAGES_CONDITIONS]);
