/* A pendulum in the form in which its equations are written: all arrays in the caller's order, with
 * the parent of each arm.
 * Leaves to others: the text of the equations (equations_latex, equations_code).
 * Invariant: immutable once made; owns its arrays. */
#ifndef API_EQUATIONS_H
#define API_EQUATIONS_H

#include "api/base/buffer.h"
#include "api/read/state_json.h"
#include "core/tree/loads.h"

enum {
    API_EQUATIONS_EXPLICIT = 8, /* arms up to which the entries are written out by default */
    API_EQUATIONS_MOST = 20     /* arms up to which they can be */
};

struct api_equations {
    int n;
    int is_explicit;         /* every entry is written out */
    struct pend_loads loads; /* what acts on the tree; its terms are lent, as the tree is */
    const struct pend_tree *tree;
    int *parent;           /* from 0, -1 = the pivot */
    int *place;            /* the stored arms, by which the terms count */
    double *length, *mass; /* m, kg */
    double *phi, *rate;    /* the start, rad and rad/s */
    double cart[2];        /* of a cart, m and m/s */
};

/**
 * Copies a tree, its loads and its start.
 *
 * equations  out; NULL on failure; ends with api_equations_free.
 * tree       must outlive the copy.
 * start      one state of the tree.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE  the start was given by a mode and is beyond the range of a double.
 * O(n), one allocation.
 */
PEND_MUST_CHECK enum pend_status api_equations_new(struct api_equations **equations,
                                                   const struct api_tree *tree,
                                                   const struct api_states *start, int is_explicit);

/** Frees the copy; nothing happens if it is NULL. */
void api_equations_free(struct api_equations **equations);

/** True if arm `above` is on the way from the pivot to the tip of `arm`, `arm` itself
 * included. O(depth). */
int api_equations_carries(const struct api_equations *equations, int above, int arm);

#endif
