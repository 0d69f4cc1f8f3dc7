/* A pendulum as its equations are written about it: everything in the caller's order, and who
 * hangs on whom.
 * Leaves to others: the words (equations_latex, equations_code).
 * Invariant: immutable once made; owns what it holds. */
#ifndef API_EQUATIONS_H
#define API_EQUATIONS_H

#include "api/base/buffer.h"
#include "api/read/state_json.h"
#include "core/tree/loads.h"

enum {
    API_EQUATIONS_EXPLICIT = 8, /* arms up to which the entries are written out where nobody says */
    API_EQUATIONS_MOST = 20     /* arms up to which they can be */
};

struct api_equations {
    int n;
    int is_explicit;         /* every entry is written out */
    struct pend_loads loads; /* what acts on the tree */
    int *parent;             /* from 0, -1 = the pivot */
    double *length, *mass;   /* m, kg */
    double *phi, *rate;      /* the start, rad and rad/s */
};

/**
 * Gathers what is needed.
 *
 * equations  out; NULL on failure.
 * start      one state of the tree.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE  the start, of a mode, is beyond all numbers.
 * O(n), one allocation.
 */
PEND_MUST_CHECK enum pend_status api_equations_new(struct api_equations **equations,
                                                   const struct api_tree *tree,
                                                   const struct api_states *start, int is_explicit);

void api_equations_free(struct api_equations **equations);

/** True where arm `above` is on the way from the pivot to the tip of `arm`, `arm` itself
 * included. O(depth). */
int api_equations_carries(const struct api_equations *equations, int above, int arm);

#endif
