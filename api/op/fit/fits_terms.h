/* What an unknown of a fit needs that the pendulum has not: friction that is looked for from 0.
 * Leaves to others: reading terms (api/read), reading unknowns (fits_unknowns).
 * Invariant: a pendulum with more terms is the same pendulum: what was added does nothing.
 */
#pragma once

#include "api/read/tree_json.h"

/**
 * Gives a pendulum the terms that unknowns name and that do something from 0 on: masses of rods and
 * bodies, springs, friction, torques, drag, a push of the pivot. A pendulum on a cart is left
 * alone.
 *
 * tree  as api_tree_read left it.
 * list  the unknowns as they are in the document, whatever they are.
 *
 * PEND_NO_MEMORY  O(arms + unknowns).
 */
PEND_MUST_CHECK enum pend_status api_fit_give_terms(struct api_tree *tree,
                                                    const struct api_value *list);
