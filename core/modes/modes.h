/* Eigenfrequencies and eigenmodes of the linearization about an equilibrium, about the hanging
 * position theta'' = -A theta (lin).
 * Leaves to others: motion in time (method_linear), drawing (api).
 * Invariant: omega ascending; vectors orthogonal in the mass inner product, in the tree's stored
 * order. */
#pragma once

#include "core/modes/modes_store.h"
#include "core/tree/loads.h"

enum pend_select {
    PEND_SELECT_ALL,
    PEND_SELECT_SLOWEST,
    PEND_SELECT_FASTEST,
    PEND_SELECT_NUMBERS,
    PEND_SELECT_BETWEEN
};

/* The request for a tree's modes; {.loads.gravity = 9.81} requests all frequencies about the
 * hanging position. */
struct pend_modes_request {
    struct pend_loads loads; /* gravity and other loads; gravity > 0 */
    int vectors;             /* non-zero to compute the eigenvectors too */
    enum pend_normalize normalize;
    enum pend_select select; /* which modes; sorted by ascending signed omega^2: growing first */
    int count; /* for SLOWEST and FASTEST the number of modes; for NUMBERS the number of modes from
                * `first` on */
    int first; /* for NUMBERS: number of the first mode, from 0 */
    double from, to; /* for BETWEEN: rad/s, from <= omega <= to, up to round-off; an empty range is
                      * not an error */
    const unsigned char *up; /* n flags in stored order, non-zero for upright arms; NULL: all hang.
                              * theta is the small deviation from that equilibrium. */
};

struct pend_modes_search;

/**
 * Starts the search for modes of a tree.
 *
 * No matrix is formed: in tip displacements the linearization is a weighted tree. Sweeps over this
 * tree count the eigenvalues below a shift, to full relative precision, and give the vectors
 * (core/theory.md). Like branches (equal sub-trees on one joint) are computed only once. No
 * eigenvalue is 0, and the number of negative ones is the number of upright arms.
 *
 * Signs and bases are fixed, so that the same tree gives the same vectors: the first entry in the
 * caller's order that is not zero (PEND_MODES_ZERO) is positive, and the vectors of a repeated
 * frequency form the one orthogonal basis in which this entry is at a later arm in each further
 * vector. A selection that cuts a repeated frequency contains some vectors of that basis.
 *
 * search   out; NULL on failure; released by pend_modes_search_free.
 * tree     must outlive the search, as request->up must; the rest of the request is copied.
 *
 * PEND_INVALID    gravity is not > 0, count not in 1 .. n, from > to or not a number, or the
 *                 squares of the frequencies may lie outside 1e-300 to 1e300 (rad/s)^2.
 * PEND_NO_MEMORY
 * O(n), O(n log n) at worst.
 */
PEND_MUST_CHECK enum pend_status pend_modes_search_new(struct pend_modes_search **search,
                                                       const struct pend_tree *tree,
                                                       const struct pend_modes_request *request,
                                                       struct pend_error *error);
void pend_modes_search_free(struct pend_modes_search **search);

/** Returns the number of modes that the search will find, which is known from the start. */
int pend_modes_search_count(const struct pend_modes_search *search);

/**
 * Continues the search by a step of O(n), about 64 sweeps over the tree, so that the caller can
 * check its deadline between steps. All steps together take O(count n) time; memory is O(n), with
 * vectors O(count n).
 *
 * done  out: non-zero once all modes are found.
 *
 * PEND_NO_MEMORY, PEND_NO_CONVERGENCE
 */
PEND_MUST_CHECK enum pend_status pend_modes_search_step(struct pend_modes_search *search, int *done,
                                                        struct pend_error *error);

/** Returns the modes of a finished search; the caller releases them by pend_modes_free. NULL after
 * the first call. */
struct pend_modes *pend_modes_search_take(struct pend_modes_search *search);

/**
 * Returns an estimate of the time that a search takes, s. O(1).
 *
 * A tree whose eigenvalues are nearly but not exactly equal can take longer.
 */
double pend_modes_cost(int n, int count, int vectors);

/** Runs a whole search. Parameters and errors as pend_modes_search_new and _step. */
PEND_MUST_CHECK enum pend_status pend_modes_select(struct pend_modes **modes,
                                                   const struct pend_tree *tree,
                                                   const struct pend_modes_request *request,
                                                   struct pend_error *error);

/** Finds all modes about the hanging position: pend_modes_select with a request of zeros. */
PEND_MUST_CHECK enum pend_status pend_modes_new(struct pend_modes **modes,
                                                const struct pend_tree *tree,
                                                const struct pend_loads *loads, int vectors,
                                                struct pend_error *error);
