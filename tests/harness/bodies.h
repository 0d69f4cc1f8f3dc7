/* Real pendulums for tests: random terms and numbers for a tree.
 * Leaves to others: the trees (trees).
 * Invariant: the same seed gives the same pendulum on every machine. */
#pragma once

#include "core/tree/loads.h"
#include "tests/harness/trees.h"

/* The terms of a random pendulum; bits. */
enum test_terms {
    TEST_TERMS_RODS = 1,           /* rods, bodies with centers anywhere, arms attached anywhere */
    TEST_TERMS_SPRINGS = 2,        /* springs with rest angles */
    TEST_TERMS_DAMPING = 4,        /* viscous friction in the joints */
    TEST_TERMS_FRICTION = 8,       /* dry friction */
    TEST_TERMS_DRAG = 16,          /* linear and quadratic drag of tips */
    TEST_TERMS_DRAG_PER_MASS = 32, /* drag per mass */
    TEST_TERMS_TORQUES = 64,       /* constant torques and two harmonics on some arms */
    TEST_TERMS_PIVOT = 128,        /* three harmonics and an acceleration of the pivot */
    TEST_TERMS_ALL = 255,
    TEST_TERMS_CART = 256,           /* the first arm is a cart, on a rail of any direction */
    TEST_TERMS_CART_ALL = 256 + 127, /* and everything except a moving pivot */
    TEST_TERMS_PIECES = 512          /* the inputs of a piece, and joints that slide in it */
};

/* The terms of a pendulum and their numbers, which loads point to. */
struct test_bodies {
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
};

/** Random terms for a tree: gravity 9.81, masses of 10^±0.3 kg, springs of 0.5 to 2 N m/rad and so
 * on. Aborts if memory is short. */
void test_bodies_random(struct test_bodies *b, const struct pend_tree *tree, unsigned what,
                        unsigned long long *seed);

/** Frees what test_bodies_random created. */
void test_bodies_clear(struct test_bodies *b);
