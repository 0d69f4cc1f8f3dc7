/* Conditions on the members of an ensemble, whose passages are found from the series of each lane.
 * Leaves to others: finding passages in a step (event_search), other events (ensemble_watch).
 * Invariant: a member's passages depend neither on its lane nor on its neighbours. */
#pragma once

#include "core/ensemble/ensemble_work.h"

/** Returns the bytes of memory for a problem's conditions, a multiple of 64; may be 0. */
size_t pend_ensemble_events_bytes(const struct pend_ensemble_problem *problem, int width);

/** Lays out the conditions in that memory, which must be zero and aligned to 64. */
void pend_ensemble_events_place(struct pend_ensemble *e, void *memory);

/**
 * Reports the passages in the step that lane i just took.
 *
 * Returns the fraction of the step, 0 .. 1, at which they end the member; infinity if they do not
 * end it. No allocation.
 */
double pend_ensemble_events_step(struct pend_ensemble *e, int i);
