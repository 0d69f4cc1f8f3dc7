/* The own numbers of listed members of an ensemble: lengths, masses, gravity, numbers of terms, and
 * the energy at the start.
 * Leaves to others: the members' starts, and the use of numbers (members_json).
 * Invariant: the numbers of member i are contiguous, in the order of the request; no pointer into
 * the document is kept. */
#pragma once

#include "api/op/varied.h"

/* One number. */
struct api_set {
    enum api_quantity quantity;
    int at; /* stored number of the arm; place of a term's number; else -1 */
    double x;
};

struct api_sets;

/** Creates an empty list of so many members; released by api_sets_free. PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status api_sets_new(struct api_sets **sets, long members);

/** Frees the numbers; nothing happens if they are NULL. */
void api_sets_free(struct api_sets **sets);

/**
 * Reads `length`, `mass`, `gravity`, `energy` and `set` of member i; members are read in their
 * order.
 *
 * tree  the result of api_tree_read.
 *
 * Every fault is added to the problem. PEND_NO_MEMORY. O(n + numbers).
 */
PEND_MUST_CHECK enum pend_status api_sets_read(struct api_sets *sets, long i,
                                               const struct api_value *member,
                                               const struct api_tree *tree,
                                               struct api_problem *problem);

/** Returns the first number of member i, and one past its last. O(1). */
const struct api_set *api_sets_begin(const struct api_sets *sets, long i);
const struct api_set *api_sets_end(const struct api_sets *sets, long i);

/** Returns non-zero if some member has an energy; if member i has one; if it has a rate; if some
 * member has a length, a mass, a gravity or a term's number of its own. O(1), but for one member
 * O(its numbers). */
int api_sets_energies(const struct api_sets *sets);
int api_sets_energy(const struct api_sets *sets, long i);
int api_sets_moves(const struct api_sets *sets, long i);
int api_sets_shapes(const struct api_sets *sets);

/**
 * Lists the places of terms' numbers that some member has, in the order in which they are first
 * named.
 *
 * count  numbers of the terms; the size of `places`.
 *
 * PEND_NO_MEMORY. O(numbers + count).
 */
PEND_MUST_CHECK enum pend_status api_sets_places(const struct api_sets *sets, int count,
                                                 int places[], int *found);

/** Returns the bytes of memory. O(1). */
double api_sets_bytes(const struct api_sets *sets);
