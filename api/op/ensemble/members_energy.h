/* Starts of members with a given energy: scales all rates of a start by one factor, so that the sum
 * of kinetic and potential energy has the given value.
 * Leaves to others: reading and choosing the energy (members_json), energies (core/dynamics).
 * Invariant: a start whose rates cannot reach the energy has NaN for rates, never a wrong
 * energy. */
#pragma once

#include "api/op/varied.h"
#include "core/ensemble/member.h"

enum { API_ENERGY_ROOM = 6 }; /* numbers of scratch per arm */

/** Reads an object's `vary` if it is "energy", which has no arm. Returns 0 if it is another
 * quantity. */
int api_energy_target(struct api_target *target, const struct api_value *value,
                      struct api_problem *problem);

/**
 * Scales a member's rates by a factor >= 0 so that it starts with a given energy.
 *
 * member  has its angles, rates, lengths, masses, loads, and start time.
 * energy  J, kinetic plus potential as in trajectories: measured from the pivot's height, with
 *         springs, in the ground's frame.
 * room    API_ENERGY_ROOM values per arm.
 *
 * The rates become NaN if no such factor exists: if the potential energy alone is larger, or no
 * rate can be scaled. O(n).
 */
void api_energy_reach(const struct pend_tree *tree, struct pend_member *member, double energy,
                      double room[]);
