/* The bifurcations found by a search for orbits: storing them and writing them.
 * Leaves to others: the search (core/orbits), the orbits (op_orbits).
 * Invariant: bifurcations are in their order along the branch; angles and rates are in the caller's
 * order. */
#pragma once

#include "api/base/buffer.h"
#include "api/encode/encode.h"
#include "core/base/checkpoint.h"
#include "core/orbits/orbit_problem.h"

/* A bifurcation, and its position. */
struct api_bifurcation {
    enum pend_orbits_kind kind;
    long after; /* number of orbits before it */
    double period, energy, value;
    double *state; /* n angles, then n rates */
};

struct api_bifurcations {
    const struct pend_tree *tree;
    int driven;
    const char *varies; /* name of the varied number; NULL = none */
    int count, places;
    struct api_bifurcation *item;
    double *block; /* memory of the columns */
};

/**
 * Adds a bifurcation.
 *
 * after  number of orbits before it.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_bifurcations_add(struct api_bifurcations *list,
                                                      const struct pend_orbit *orbit, long after);
void api_bifurcations_clear(struct api_bifurcations *list);

/** Returns an upper bound of the bytes of memory, including the columns if requested. O(1). */
double api_bifurcations_bytes(const struct api_bifurcations *list, int columns);

/** Adds the columns of a table whose rows are bifurcations. */
void api_bifurcations_table(const struct api_bifurcations *list, struct api_table *table);

/**
 * Creates the columns of that table.
 *
 * column  out; valid until api_bifurcations_clear.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_bifurcations_columns(struct api_bifurcations *list,
                                                          const struct api_table *table,
                                                          const double *column[]);

/**
 * Saves the list to a checkpoint, or restores it into an empty list.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID  the restored data are not such a list.
 */
PEND_MUST_CHECK enum pend_status api_bifurcations_carry(struct api_bifurcations *list,
                                                        struct pend_checkpoint *checkpoint);

/** Writes the list as the JSON member `bifurcations`. */
PEND_MUST_CHECK enum pend_status api_bifurcations_write(const struct api_bifurcations *list,
                                                        int digits, struct api_buffer *out);
