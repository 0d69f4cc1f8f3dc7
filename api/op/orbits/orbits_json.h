/* Reading a request for periodic orbits: their kind, and the end of the branch.
 * Leaves to others: the tree (tree_json), the search (core/orbits), the answer (op_orbits).
 * Invariant: every fault is added; a valid request has orbits that can be searched. */
#pragma once

#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/orbits/orbit_problem.h"

enum { API_ORBITS_ARMS = 100, API_ORBITS_POINTS = 10000 };

struct api_orbits {
    struct api_tree tree;
    struct api_states *start;          /* of driven pendulums */
    struct pend_orbit_problem problem; /* without its tree, loads and start */
    const char *varies;                /* the name of the varied number, NULL = none */
    double omega;                      /* rad/s, of the drive; 0 without one */
    int rows;                          /* non-zero: bifurcations, else orbits */
    int digits;
};

/**
 * Reads the request; released by api_orbits_clear, also after a failure.
 *
 * PEND_INVALID   every fault was added.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_orbits_read(struct api_orbits *asked,
                                                 const struct api_reading *reading);

/** Frees what was read. */
void api_orbits_clear(struct api_orbits *asked);
