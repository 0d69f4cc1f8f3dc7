/* Reads a request for periodic orbits: their kind, and the end of the branch.
 * Leaves to others: the tree (tree_json), the search (core/orbits), the answer (op_orbits).
 * Invariant: every error is added; orbits of a valid request can be searched for. */
#pragma once

#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/orbits/orbit_problem.h"

enum { API_ORBITS_ARMS = 100, API_ORBITS_POINTS = 10000 };

struct api_orbits {
    struct api_tree tree;
    struct api_states *start;          /* start, for driven pendulums */
    struct pend_orbit_problem problem; /* tree, loads and start are not set */
    const char *varies;                /* name of the varied number; NULL = none */
    double omega;                      /* rad/s, frequency of the drive; 0 without a drive */
    int rows;                          /* non-zero: the rows are bifurcations; 0: orbits */
    int digits;
};

/**
 * Reads the request; released by api_orbits_clear, also after a failure.
 *
 * PEND_INVALID   every error was added.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_orbits_read(struct api_orbits *asked,
                                                 const struct api_reading *reading);
void api_orbits_clear(struct api_orbits *asked);
