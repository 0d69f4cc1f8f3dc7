/* A trajectory to compute and its answer, for all solvers.
 * Leaves to others: computing (ours in bench_trajectories, the others in peers).
 * Invariant: angles in the tree's stored order, one row per instant. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum { PROBLEM_ARMS_MAX = 256 };

struct problem {
    const char *name;
    int count;   /* instants, from 0 to stop */
    int members; /* of an ensemble, whose time is divided by this number; 0 = one trajectory */
    double stop, until, error; /* s; the error, rad, is to be reached up to `until` */
    struct pend_loads loads;
    struct pend_tree *tree;
    double phi[PROBLEM_ARMS_MAX], rate[PROBLEM_ARMS_MAX]; /* start */
};

/** Instant i, s. */
static inline double problem_time(const struct problem *problem, int i) {
    return i * problem->stop / (problem->count - 1);
}

/** Computes phi, count rows of n; 0 on success. Both tolerances are `tolerance`. */
typedef int problem_solver(const struct problem *problem, double tolerance, double phi[]);
