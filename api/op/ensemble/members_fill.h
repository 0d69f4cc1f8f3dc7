/* The members of an ensemble once they are read, and the start of one of them.
 * Leaves to others: reading them (members_json), listed numbers (members_set), starts on an energy
 * (members_energy).
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
    int place; /* of a term's number in the list */
    enum { API_SPREAD_LINEAR, API_SPREAD_LOG, API_SPREAD_UNIFORM, API_SPREAD_NORMAL } spread;
    double from, to; /* ends of an axis or of a uniform draw; mean and deviation of a normal one;
                        logarithms with LOG */
    long count;      /* of an axis */
    int tied;        /* varies together with the variation before it */
};

enum { API_AXES = 8 }; /* the most axes of a grid */

struct api_members {
    long count;                /* number of members */
    long first;                /* of draws: the number of the first member */
    struct api_states *states; /* one for each member, or a common one */
    int listed;                /* there is one state for each member */
    int variations;
    struct api_variation *variation; /* axes, the first varies fastest, each followed by those tied
                                      * to it; or draws */
    int axes;
    long axis_count[API_AXES];
    struct api_sets *sets; /* numbers of listed members; NULL = they have none */
    int on_energy;         /* some members start on a given energy */
    double energy;         /* J, of all members without an energy of their own; NaN = none */
    int shown;             /* number of varying numbers of terms */
    int *shown_place;      /* their places in the list of terms */
    uint64_t seed;
    const struct pend_terms *terms; /* of the pendulum, NULL for an ideal one; not owned */
};

/** Returns non-zero if lengths, masses, gravity or numbers of terms differ between members.
 * O(variations). */
int api_members_shapes(const struct api_members *members);

/**
 * Writes the start and the start time of member i into arrays that contain the tree's own lengths,
 * masses, gravity and numbers of terms. An invalid random number, such as a negative length,
 * becomes NaN; so do rates that cannot reach the energy.
 *
 * room  API_ENERGY_ROOM values per arm of the tree.
 * O(n + variations).
 */
void api_members_fill(const struct api_members *members, const struct pend_tree *tree, long i,
                      struct pend_member *member, double room[]);
