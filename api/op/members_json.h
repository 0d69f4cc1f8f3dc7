/* Reading the members of an ensemble from JSON: a list of states, a grid over chosen values, or
 * random draws.
 * Leaves to others: the observables (observables), the computation (ensemble).
 * Invariant: member i is a function of the request and i alone; no pointer into the document is
 * kept. */
#ifndef API_MEMBERS_JSON_H
#define API_MEMBERS_JSON_H

#include <stdint.h>

#include "api/op/varied.h"
#include "api/read/state_json.h"
#include "core/ensemble/member.h"

/* One value that varies: the quantity, the arm, and its values. */
struct api_variation {
    enum api_quantity quantity;
    int arm;   /* stored number; -1 for what is the pendulum's */
    int place; /* of a term's number in the list */
    enum { API_SPREAD_LINEAR, API_SPREAD_LOG, API_SPREAD_UNIFORM, API_SPREAD_NORMAL } spread;
    double from, to; /* ends of an axis or of a uniform draw; mean and deviation of a normal one;
                        logarithms with LOG */
    long count;      /* of an axis */
};

struct api_members {
    long count;                /* members */
    struct api_states *states; /* one for each member, or one from which all start */
    int listed;                /* there is one state for each member */
    int variations;
    struct api_variation *variation; /* axes, the first runs fastest; or draws */
    uint64_t seed;
    const struct pend_terms *terms; /* of the pendulum, NULL of an ideal one; not owned */
};

/**
 * Reads `states`, or `grid`, or `random`, with `initial` for the latter two.
 *
 * members  out; must be cleared by api_members_clear whatever is returned.
 * root     the request's object.
 * tree     as api_tree_read left it; of a faulty tree the parts that are known are used.
 *
 * PEND_INVALID   every fault was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_members_read(struct api_members *members,
                                                  const struct api_value *root,
                                                  const struct api_tree *tree,
                                                  const struct api_limits *limits,
                                                  struct api_problem *problem);

/** Returns how many of the variations are of terms. O(variations). */
int api_members_varied(const struct api_members *members);

/** Frees the states and the variations. */
void api_members_clear(struct api_members *members);

/**
 * Writes the start of member i into arrays that hold the tree's own lengths, masses, gravity and
 * numbers of terms. A number that was drawn and cannot be, as a negative length, becomes NaN. O(n).
 */
void api_members_fill(const struct api_members *members, int n, long i, struct pend_member *member);

#endif
