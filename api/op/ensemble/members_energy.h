/* Starts of members on a given energy: all rates of a start are scaled by one factor until the sum
 * of kinetic and potential energy is the one that is wanted.
 * Leaves to others: reading and choosing the energy (members_json), energies (core/dynamics).
 * Invariant: a start whose rates cannot reach the energy has NaN for rates, never a wrong energy.
 */
#ifndef API_MEMBERS_ENERGY_H
#define API_MEMBERS_ENERGY_H

#include "api/op/varied.h"
#include "core/ensemble/member.h"

enum { API_ENERGY_ROOM = 6 }; /* values of scratch an arm */

/** Reads an object's `vary` if it is "energy", which has no arm. Returns 0 if it is something else.
 */
int api_energy_target(struct api_target *target, const struct api_value *value,
                      struct api_problem *problem);

/**
 * Scales a member's rates by a factor of at least 0 so that it starts on an energy.
 *
 * member  with its angles, rates, lengths, masses, loads, and when it begins.
 * energy  J, kinetic and potential as trajectories tell them: measured from the pivot, springs
 *         included, in the ground's frame.
 * room    API_ENERGY_ROOM values an arm.
 *
 * The rates become NaN where no such factor exists: where the angles alone have more energy, or
 * nothing moves. O(n).
 */
void api_energy_reach(const struct pend_tree *tree, struct pend_member *member, double energy,
                      double room[]);

#endif
