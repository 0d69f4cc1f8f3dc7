/* The numbers of a real pendulum that can vary from member to member, by name.
 * Leaves to others: axes and draws (members_json), what the terms are (core/tree/terms).
 * Invariant: a name stands for one number of the list of terms, together with an arm or a harmonic
 * where it needs one. */
#ifndef API_VARIED_H
#define API_VARIED_H

#include "api/read/tree_json.h"

/* How many names there are. */
enum { API_VARIED = PEND_TERM_ROWS + PEND_TERM_ONES + 9 };

/** Returns name number i, 0 .. API_VARIED - 1: "damping", "pivot_y_amplitude". O(1). */
const char *api_varied_name(int i);

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
