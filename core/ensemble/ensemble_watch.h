/* Events inside a step of a member: crossings of the bound, extremes and zeros of forces, and
 * requested rows.
 * Leaves to others: which steps may hold an event (kernel_ensemble), where members start and end
 * (ensemble).
 * Invariant: the events found do not depend on where the steps begin and end, beyond rounding. */
#pragma once

#include "core/ensemble/ensemble_work.h"

/**
 * Returns the step that lane i just took, so that events can be searched in it.
 *
 * tree, loads  out: the pendulum of the lane's member, with the values that positions, energies and
 *              forces need; valid until the next call; the returned step uses them.
 */
struct event_step pend_ensemble_watch_step(const struct pend_ensemble *e, int i,
                                           struct pend_tree *tree, struct pend_loads *loads);

/** Prepares the event search of the member that starts in lane i. O(n). */
void pend_ensemble_watch_start(struct pend_ensemble *e, int i);

/**
 * Records the crossings in the step that lane i just took, up to its fraction `most`, 0 <= most <=
 * 1.
 *
 * Returns the fraction of the step, 0 .. 1, at which these crossings end the member; infinity if
 * they do not end it.
 */
double pend_ensemble_watch_bound(struct pend_ensemble *e, int i, double most);

/** Records the extremes and sign changes of the forces up to the fraction `part` of the step, 0 <
 * part <= 1. */
void pend_ensemble_watch_force(struct pend_ensemble *e, int i, double part);

/** Reports the rows whose instants lie in the step of lane i, up to `until`, s. */
void pend_ensemble_watch_rows(struct pend_ensemble *e, int i, double until);

/** Computes the state at `part` of the step of lane i, 0 .. 1, into the outcome's arrays. */
void pend_ensemble_watch_state(struct pend_ensemble *e, int i, double part);

/** Returns the time at the fraction `part` of the step of lane i, s. */
double pend_ensemble_watch_time(const struct pend_ensemble *e, int i, double part);

/** Starts the piece of lane i at `now`, s, in the time of the drives: the controllers sample
 * `state`; sets the lane's inputs and the time at which it stops. O(n controllers). */
void pend_ensemble_watch_begin(struct pend_ensemble *e, int i, double now,
                               const struct ensemble_state *state);

/** Records for seat i whether the member is near the reference of its controllers at `now`, s. */
void pend_ensemble_watch_settled(struct pend_ensemble *e, int i, const double phi[],
                                 const struct pend_loads *loads, double now);

/** Starts the next piece of a lane at its stop; returns 0 if the member ends there. */
int pend_ensemble_watch_piece(struct pend_ensemble *e, int i);
