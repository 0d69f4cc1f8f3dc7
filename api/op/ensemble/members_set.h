/* The numbers of listed members of an ensemble: lengths, masses, gravity, values of terms, and the
 * energy at the start.
 * Leaves to others: the members' starts, and the use of the numbers (members_json).
 * Invariant: the numbers of member i are contiguous, in the order of the request; no pointer into
 * the document is kept. */
#pragma once

#include "api/op/varied.h"

/* One number. */
struct api_set {
    enum api_quantity quantity;
    int at; /* stored number of the arm, or index of a term's number, or -1 */
    double x;
};

struct api_sets;

/** Creates a list for `members` members, without numbers; released by api_sets_free.
 * PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status api_sets_new(struct api_sets **sets, long members);
void api_sets_free(struct api_sets **sets);

/**
 * Reads `length`, `mass`, `gravity`, `energy` and `set` of member i; members must be read in order.
 *
 * tree  the result of api_tree_read.
 *
 * Every error is added to the problem. PEND_NO_MEMORY. O(n + numbers).
 */
PEND_MUST_CHECK enum pend_status api_sets_read(struct api_sets *sets, long i,
                                               const struct api_value *member,
                                               const struct api_tree *tree,
                                               struct api_problem *problem);

/** api_sets_begin returns the address of member i's first number, api_sets_end the address after
 * its last. O(1). */
const struct api_set *api_sets_begin(const struct api_sets *sets, long i);
const struct api_set *api_sets_end(const struct api_sets *sets, long i);

/** Return non-zero if some member has an energy; if member i has one; if it has a rate; if some
 * member has its own length, mass, gravity or term value. O(1), for one member O(its numbers). */
int api_sets_energies(const struct api_sets *sets);
int api_sets_energy(const struct api_sets *sets, long i);
int api_sets_moves(const struct api_sets *sets, long i);
int api_sets_shapes(const struct api_sets *sets);

/**
 * Lists the indices of term values that some member has, in the order of their first occurrence.
 *
 * count  number of the terms' values; the size of `places`.
 *
 * PEND_NO_MEMORY. O(numbers + count).
 */
PEND_MUST_CHECK enum pend_status api_sets_places(const struct api_sets *sets, int count,
                                                 int places[], int *found);

/** Returns the bytes of memory. O(1). */
double api_sets_bytes(const struct api_sets *sets);
