/* The pendulum that is left while joints hold: child and parent are one rigid body, so that a
 * pendulum with joints that hold is another one with fewer arms.
 * Leaves to others: which joints hold (joints), the motion (core/bodies).
 * Invariant: a stuck pendulum has its own tree, terms and numbers; angles of arms that it has lost
 * follow from those that it has. */
#ifndef PEND_STUCK_H
#define PEND_STUCK_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_stuck {
    struct pend_tree *tree;
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
    void *work;           /* of pend_bodies_at */
    int n;                /* arms of the whole pendulum; arrays in its stored order */
    int *rep;             /* the stored arm of `tree` with which each turns */
    int *of;              /* the whole pendulum's arm that each stored arm of `tree` is */
    unsigned char *still; /* the arm does not turn at all */
    double *offset, *low; /* rad, by which its angle is larger than that arm's: a sum of two */
};

/**
 * Contracts a pendulum.
 *
 * stuck  out; NULL on failure; released by pend_stuck_free.
 * loads  with terms; the numbers of a piece.
 * holds  n flags: joints that hold. An arm whose joint holds against the ground does not turn; a
 *        cart that holds does not move.
 * phi, phi_low  n angles as sums of two; phi_low may be NULL.
 *
 * PEND_NO_MEMORY  O(n log n).
 */
PEND_MUST_CHECK enum pend_status pend_stuck_new(struct pend_stuck **stuck,
                                                const struct pend_tree *tree,
                                                const struct pend_loads *loads,
                                                const unsigned char holds[], const double phi[],
                                                const double phi_low[]);

/** Frees it and clears the pointer; NULL is accepted. */
void pend_stuck_free(struct pend_stuck **stuck);

/** Copies numbers that change between pieces, inputs and sliding torques, from a list of the whole
 * pendulum. O(n). */
void pend_stuck_inputs(struct pend_stuck *stuck, const struct pend_terms *terms,
                       const double value[]);

/** Copies rates or accelerations of the stuck pendulum to all arms; returns `to`. O(n). */
double *pend_stuck_spread(const struct pend_stuck *stuck, const double from[], double to[]);

/** The same of angles, as sums of two; low parts may be NULL. */
void pend_stuck_turn(const struct pend_stuck *stuck, const double from[], const double from_low[],
                     double to[], double to_low[]);

#endif
