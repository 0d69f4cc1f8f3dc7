/* The numbers of a pendulum that can vary between members or be parameters of derivatives, by name.
 * Leaves to others: axes and draws (members_json), the terms (core/tree/terms).
 * Invariant: a name, together with an arm or a harmonic if it needs one, identifies one number in
 * the list of terms. */
#pragma once

#include "api/read/tree_json.h"
#include "core/derivatives/parameter.h"

/* The quantities that can vary between members. */
enum api_quantity {
    API_VARY_PHI,
    API_VARY_THETA,
    API_VARY_PHID,
    API_VARY_THETAD,
    API_VARY_LENGTH,
    API_VARY_MASS,
    API_VARY_GRAVITY,
    API_VARY_TERM,   /* a number of a real pendulum (varied) */
    API_VARY_ENERGY, /* energy of a member's start (members_energy); cannot be a parameter of
                      * derivatives */
    API_VARY_COUNT
};

/* The number of names of terms. */
enum { API_VARIED = PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES + 9 };

/* The number that varies, or the parameter of a derivative. */
struct api_target {
    enum api_quantity quantity;
    int arm;   /* stored number; -1 for a number of the whole pendulum */
    int place; /* index of a term's number in the list */
};

/**
 * Reads an object's fields `vary`, `arm` and `harmonic`; ignores other fields.
 *
 * Returns 1, or 0 after an error if `vary` is missing or unknown. After other errors, such as an
 * unknown arm or a number that the pendulum does not have, `arm` or `place` is -1. O(harmonics).
 */
int api_target_read(struct api_target *target, const struct api_value *value,
                    const struct api_tree *tree, struct api_problem *problem);

/** Returns a target as the parameter of derivatives; arm or place 0 for one that was not found. The
 * target is no energy. O(1). */
struct pend_parameter api_target_parameter(const struct api_target *target);

/** Returns name number i, 0 .. API_VARIED - 1: "damping", "pivot_y_amplitude". O(1). */
const char *api_varied_name(int i);

/** Returns true if the name needs an arm. O(1). */
int api_varied_of_arm(int i);

/**
 * Finds the index of a number in the list of a pendulum's terms.
 *
 * arm       the stored number, -1 for names that need none.
 * harmonic  from 1; for names without harmonics it is 1.
 *
 * Returns the index; -1 if the pendulum does not have the number. O(harmonics).
 */
int api_varied_place(const struct api_tree *tree, int i, int arm, int harmonic);
