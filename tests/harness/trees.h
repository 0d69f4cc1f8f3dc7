/* Trees for tests: every small parent list, random large ones of several kinds, and random states.
 * Leaves to others: exact answers (harness/quad).
 * Invariant: the same seed gives the same tree on every machine. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Loads of gravity only, m/s^2. */
#define TEST_LOADS(g) (&(const struct pend_loads){.gravity = (g)})

enum test_tree_kind {
    TEST_TREE_ATTACHED,    /* each arm hangs on a random earlier one: depth about log n */
    TEST_TREE_CHAIN,       /* one after the other */
    TEST_TREE_STAR,        /* all on the first */
    TEST_TREE_BINARY,      /* the complete binary tree */
    TEST_TREE_CATERPILLAR, /* a chain whose joints carry one more arm each */
    TEST_TREE_BROOM,       /* a chain of n/2, the others on its tip */
    TEST_TREE_LIMBS,       /* each arm hangs on one of the previous 3: long, with short branches */
    TEST_TREE_KINDS
};

/* A pendulum with a state. length .. parent are in the caller's order, phi and rate in the
 * tree's stored order. */
struct test_tree {
    int n;
    double *length, *mass;
    int *parent;
    double *phi, *rate;
    struct pend_tree *tree;
};

/** A word for a kind. */
const char *test_tree_kind_name(enum test_tree_kind kind);

/** Parents of a kind, from 0, -1 = the pivot, each before its children. seed is used by the
 * random kinds. */
void test_parents(enum test_tree_kind kind, int n, int parent[], unsigned long long *seed);

/** Renumbers the arms at random: the same tree, parents no longer first. */
void test_parents_shuffle(int n, int parent[], unsigned long long *seed);

/**
 * Steps through all (n-1)! parent lists with parent[k] < k and one arm at the pivot: start with
 * test_parents_first, end when test_parents_next returns 0. Over n = 1 .. 8 there are 5914.
 */
void test_parents_first(int n, int parent[]);
int test_parents_next(int n, int parent[]);

/**
 * A tree with the parents given: lengths 10^±0.3 m, masses 10^±spread kg (uniform in the exponent),
 * angles uniform in (-pi, pi), rates in ±3 rad/s. Aborts if memory is short.
 */
void test_tree_init(struct test_tree *t, int n, const int parent[], double spread,
                    unsigned long long *seed);

/** The same for a random tree of a kind, with randomly numbered arms. */
void test_tree_random(struct test_tree *t, enum test_tree_kind kind, int n, double spread,
                      unsigned long long *seed);

/** Rebuilds t->tree after a change of length, mass or parent; the state is not changed. */
void test_tree_rebuild(struct test_tree *t);

void test_tree_clear(struct test_tree *t);

/** pend_dynamics of the tree in its state, with its own scratch memory, filled with signalling
 * NaN. */
void test_tree_dynamics(const struct test_tree *t, const struct pend_loads *loads, double acc[],
                        double force[]);

/** Largest |a - b| relative to the largest |b| (0 if both are all 0); NaN if any value is. */
double test_gap(int n, const double a[], const double b[]);
