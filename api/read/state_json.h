/* States of a tree out of JSON: angles and velocities, or one of the tree's modes.
 * Leaves to others: the tree (tree_json), what the states are for (op_*).
 * Invariant: states are in the tree's stored order; nothing of the document is kept. */
#ifndef API_STATE_JSON_H
#define API_STATE_JSON_H

#include "api/read/tree_json.h"

/* count states of n arms each, one block. A state that was given as a mode is computed by
 * api_states_settle. */
struct api_states {
    int n;
    long count;
    double *phi, *rate;         /* count x n, rad and rad/s */
    double *phi_low, *rate_low; /* count x n, what rounding leaves of them */
    double *amplitude;          /* count, rad */
    int *mode;                  /* count, from 1; 0 = given by its angles */
    int mode_least, mode_most;  /* of the modes that are still to be computed; 0 = none is */
};

/**
 * States at rest with phi = 0.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_states_new(struct api_states **states, long count, int n);

void api_states_free(struct api_states **states);

/**
 * Bytes of memory that states take, and that api_states_settle takes for a time where one of them
 * is a mode; NULL takes none. O(1).
 */
double api_states_bytes(const struct api_states *states);

/**
 * Reads state number i.
 *
 * states   NULL = only check, as far as that goes without a tree.
 * value    an object; a missing one is the state at rest with phi = 0.
 * tree     as it was read; a faulty one is used as far as it is known.
 * limits   of the arms of a tree whose modes are asked for.
 *
 * Every fault is added to the problem. O(n).
 */
void api_states_read(struct api_states *states, long i, const struct api_value *value,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/**
 * Computes the states that were given as modes; nothing to do where there is none.
 *
 * Fails as pend_modes_new does. O(n^3).
 */
PEND_MUST_CHECK enum pend_status
api_states_settle(struct api_states *states, const struct api_tree *tree, struct pend_error *error);

#endif
