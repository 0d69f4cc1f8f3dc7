/* The numbers of a pendulum that can vary from member to member, or by which is differentiated, by
 * name.
 * Leaves to others: axes and draws (members_json), what the terms are (core/tree/terms).
 * Invariant: a name stands for one number of the list of terms, together with an arm or a harmonic
 * where it needs one. */
#ifndef API_VARIED_H
#define API_VARIED_H

#include "api/read/tree_json.h"

/* The quantities that can vary from member to member. */
enum api_quantity {
    API_VARY_PHI,
    API_VARY_THETA,
    API_VARY_PHID,
    API_VARY_THETAD,
    API_VARY_LENGTH,
    API_VARY_MASS,
    API_VARY_GRAVITY,
    API_VARY_TERM,   /* a number of a real pendulum (varied) */
    API_VARY_ENERGY, /* that a member starts on (members_energy); nothing is differentiated by it */
    API_VARY_COUNT
};

/* How many names of terms there are. */
enum { API_VARIED = PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES + 9 };

/* What varies, or what a derivative is with respect to. */
struct api_target {
    enum api_quantity quantity;
    int arm;   /* stored number; -1 for what is the pendulum's */
    int place; /* of a term's number in the list */
};

/**
 * Reads what an object's fields `vary`, `arm` and `harmonic` name; other fields are left alone.
 *
 * Returns 1; 0 if `vary` is missing or is no such name, which is a fault. Other faults, as of the
 * arm or of a number that the pendulum has not, leave `arm` or `place` -1. O(harmonics).
 */
int api_target_read(struct api_target *target, const struct api_value *value,
                    const struct api_tree *tree, struct api_problem *problem);

/** Returns name number i, 0 .. API_VARIED - 1: "damping", "pivot_y_amplitude". O(1). */
const char *api_varied_name(int i);

/** Returns true if the name, or "phi", "phid" or "mass", is of a number that a cart has too.
 * O(1). */
int api_varied_of_cart(const char *name);

/** Returns true if the name needs an arm. O(1). */
int api_varied_of_arm(int i);

/**
 * Finds the place of a number in the list of a pendulum's terms.
 *
 * arm       the stored number, -1 for names that need none.
 * harmonic  from 1, of what the name says; for names without harmonics it is 1.
 *
 * Returns the place; -1 if the pendulum has no such number. O(harmonics).
 */
int api_varied_place(const struct api_tree *tree, int i, int arm, int harmonic);

#endif
