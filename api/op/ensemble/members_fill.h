/* The members of an ensemble after reading, and the start of one of them.
 * Leaves to others: reading them (members_json), listed numbers (members_set), starts with a given
 * energy (members_energy).
 * Invariant: member i is a function of the request and i alone. */
#pragma once

#include <stdint.h>

#include "api/op/ensemble/members_energy.h"
#include "api/op/ensemble/members_set.h"
#include "api/read/state_json.h"

/* A number that varies: the quantity, the arm, and its values. */
struct api_variation {
    enum api_quantity quantity;
    int arm;   /* stored number; -1 for a number of the whole pendulum */
    int place; /* index of a term's number in the list */
    enum { API_SPREAD_LINEAR, API_SPREAD_LOG, API_SPREAD_UNIFORM, API_SPREAD_NORMAL } spread;
    double from, to; /* ends of an axis or of a uniform draw; mean and deviation of a normal draw;
                      * logarithms with LOG */
    long count;      /* number of values on an axis */
    int tied;        /* whether the number varies together with the previous variation */
};

enum { API_AXES = 8 }; /* the most axes of a grid */

struct api_members {
    long count;                /* number of members */
    long first;                /* for draws: the number of the first member */
    struct api_states *states; /* one state per member, or a common one */
    int listed;                /* whether there is one state per member */
    int variations;
    struct api_variation *variation; /* draws; or axes, of which the first varies fastest, each
                                      * followed by the variations tied to it */
    int axes;
    long axis_count[API_AXES];
    struct api_sets *sets; /* numbers of listed members; NULL if they have none */
    int on_energy;         /* whether some members start with a given energy */
    double energy;         /* J, for members without an energy of their own; NaN = none */
    int shown;             /* number of term values that vary */
    int *shown_place;      /* indices of these values in the list of terms */
    uint64_t seed;
    const struct pend_terms *terms; /* of the pendulum; NULL if it is ideal; not owned */
};

/** Returns non-zero if lengths, masses, gravity or numbers of terms differ between members.
 * O(variations). */
int api_members_shapes(const struct api_members *members);

/**
 * Writes the start and the start time of member i into arrays that contain the tree's own lengths,
 * masses, gravity and numbers of terms. An invalid random number, such as a negative length,
 * becomes NaN, and so do rates that cannot reach the energy.
 *
 * room  API_ENERGY_ROOM values per arm of the tree.
 * O(n + variations).
 */
void api_members_fill(const struct api_members *members, const struct pend_tree *tree, long i,
                      struct pend_member *member, double room[]);
