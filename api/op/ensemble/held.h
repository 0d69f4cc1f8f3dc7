/* Steps of many pendulums whose torques are held over each step: environments of learners.
 * Leaves to others: the pendulum, the time of a step and the tolerance (a request for an ensemble),
 * rewards and ends of episodes (the caller).
 * Invariant: a step has the bits of a member of that ensemble with this start and these torques. */
#pragma once

#include <stddef.h>

#define API_HELD_EXPORT __attribute__((visibility("default")))

struct api_held;

/**
 * Reads a request of POST /v1/ensembles, whose `duration` is the time of a step, s; its members do
 * not matter. Returns NULL if it is refused (the route says why), if all constant torques of the
 * arms and the constant force on the cart are 0, or if memory is short; released by api_held_free.
 */
API_HELD_EXPORT struct api_held *api_held_new(const char *body, size_t bytes);
API_HELD_EXPORT void api_held_free(struct api_held *held);

/**
 * Takes a step. n is the number of arms, and one more with a cart.
 *
 * state  in and out, count rows of 2 n + 1: theta of every arm in the caller's order, rad, the
 *        rates, rad/s, place, m, and speed, m/s, of a cart, and the time in that of the drives, s.
 * input  count rows of n: a torque for every arm, N m, then a force on the cart, N, which replace
 *        the constants of the pendulum.
 *
 * Returns the number of members that failed, whose angles are NaN; -1 if memory is short. Cost:
 * about one step of the method for each member, several members side by side.
 */
API_HELD_EXPORT long api_held_step(struct api_held *held, long count, double state[],
                                   const double input[]);
