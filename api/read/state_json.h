/* Reads states of a tree from JSON: angles and velocities, or one of the tree's modes.
 * Leaves to others: the tree (tree_json), the use of the states (op_*).
 * Invariant: states are in the tree's stored order and contain no pointer into the document. */
#pragma once

#include "api/read/tree_json.h"

/* count states of n arms each, a cart counted as one, in one block of memory. api_states_settle
 * computes a state that was given as a mode. */
struct api_states {
    int n;
    long count;
    double *phi, *rate;         /* count x n: rad and rad/s */
    double *phi_low, *rate_low; /* count x n: the rounding errors of phi and rate */
    double *amplitude;          /* count: amplitudes of the modes, rad */
    int *mode;                  /* count: mode that gives a state, from 1; 0 = angles give it */
    int mode_least, mode_most;  /* range of the modes that are still to be computed; 0 = none */
    double
        degrees; /* an angle in rad that looks like degrees, if the request has no unit; 0 = none */
};

/**
 * Allocates states at rest with phi = 0.
 *
 * states  out; NULL on failure; released by api_states_free.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_states_new(struct api_states **states, long count, int n);
void api_states_free(struct api_states **states);
int api_states_valid(const struct api_states *states);

/** Returns the bytes of memory of states, including the temporary memory of api_states_settle if
 * one of them is a mode; 0 for NULL. O(1). */
double api_states_bytes(const struct api_states *states);

/**
 * Reads state number i.
 *
 * states   NULL = only check the value, as far as possible without a tree.
 * value    an object; if missing, the state at rest with phi = 0.
 * tree     the result of api_tree_read; of an invalid tree the known parts are used.
 * limits   the largest number of arms whose modes may be computed.
 *
 * Every error is added to the problem. O(n).
 */
void api_states_read(struct api_states *states, long i, const struct api_value *value,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/**
 * Computes the states that were given as modes, if any.
 *
 * Fails as pend_modes_new does. O(n^3).
 */
PEND_MUST_CHECK enum pend_status
api_states_settle(struct api_states *states, const struct api_tree *tree, struct pend_error *error);
