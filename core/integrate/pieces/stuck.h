/* The contracted pendulum: a child whose joint holds forms one rigid body with its parent, so that
 * a pendulum with holding joints becomes another pendulum with fewer arms.
 * Leaves to others: which joints hold (joints), the motion (core/bodies).
 * Invariant: a contracted pendulum has its own tree, terms and values; the angles of contracted
 * arms follow from those of the arms of its tree. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_stuck {
    struct pend_tree *tree;
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
    void *work;           /* scratch of pend_bodies_at */
    int n;                /* number of arms of the whole pendulum, whose stored order the arrays
                           * have */
    int *rep;             /* for each arm, the arm of `tree` with which it turns */
    int *of;              /* for each arm of `tree`, its index in the whole pendulum */
    unsigned char *still; /* flags: the arm does not turn */
    double *offset, *low; /* rad, the arm's angle minus that of `rep`, as a sum of two doubles */
};

/**
 * Contracts a pendulum.
 *
 * stuck  out; NULL on failure; released by pend_stuck_free.
 * loads  with terms and the values of a piece.
 * holds  n flags: joints that hold. An arm whose joint holds against the ground does not turn; a
 *        cart that holds does not move.
 * phi, phi_low  n angles as sums of two doubles; phi_low may be NULL.
 *
 * PEND_NO_MEMORY  O(n log n).
 */
PEND_MUST_CHECK enum pend_status pend_stuck_new(struct pend_stuck **stuck,
                                                const struct pend_tree *tree,
                                                const struct pend_loads *loads,
                                                const unsigned char holds[], const double phi[],
                                                const double phi_low[]);
void pend_stuck_free(struct pend_stuck **stuck);

/** Copies values that change between pieces, inputs and sliding torques, from a list of the whole
 * pendulum. O(n). */
void pend_stuck_inputs(struct pend_stuck *stuck, const struct pend_terms *terms,
                       const double value[]);

/** Copies rates or accelerations of the contracted pendulum to all arms; returns `to`. O(n). */
double *pend_stuck_spread(const struct pend_stuck *stuck, const double from[], double to[]);

/** Copies angles in the same way, as sums of two doubles; low parts may be NULL. */
void pend_stuck_turn(const struct pend_stuck *stuck, const double from[], const double from_low[],
                     double to[], double to_low[]);
