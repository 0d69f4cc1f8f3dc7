/* Random motions of ideal and real pendulums, classified by the growth of a small error, for tests
 * of error estimates.
 * Leaves to others: their computation and the true errors.
 * Invariant: the same seed gives the same motion on every machine. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum test_motion_kind {
    TEST_MOTION_CHAOTIC, /* 2 to 6 arms without friction, any start */
    TEST_MOTION_REGULAR, /* one arm at any amplitude, two or three with small swings */
    TEST_MOTION_DAMPED,  /* viscous friction of the joints from weak to 100 times critical */
    TEST_MOTION_STIFF,   /* a slow arm and a light one in a stiff joint */
    TEST_MOTION_STUCK,   /* dry friction that stops the motion */
    TEST_MOTION_DRIVEN,  /* a driven arm or a shaken pivot, damped */
    TEST_MOTION_CART,    /* arms on a cart, damped */
    TEST_MOTION_KINDS
};

enum { TEST_MOTION_ARMS = 6, TEST_MOTION_NUMBERS = 64 };

struct test_motion {
    struct pend_tree *tree;
    struct pend_terms *terms; /* NULL = an ideal pendulum */
    double value[TEST_MOTION_NUMBERS];
    double phi[TEST_MOTION_ARMS], rate[TEST_MOTION_ARMS];
    double span; /* s, a duration that suits the kind */
};

/** A word for a kind. */
const char *test_motion_name(enum test_motion_kind kind);

/** Draws motion number i of a kind. Aborts if memory is short. */
void test_motion_init(struct test_motion *motion, enum test_motion_kind kind, int i);

/** The number of arms of a motion, without a cart. */
int test_motion_arms(const struct test_motion *motion);

/** The loads of a motion, which point into it. */
struct pend_loads test_motion_loads(const struct test_motion *motion);

/** Frees what test_motion_init created. */
void test_motion_clear(struct test_motion *motion);
