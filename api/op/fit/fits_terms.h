/* Adds the terms that unknowns need and the pendulum lacks, such as friction that starts from 0.
 * Leaves to others: reading terms (api/read), reading unknowns (fits_unknowns).
 * Invariant: the added terms are 0 and do not change the motion. */
#pragma once

#include "api/read/tree_json.h"

/**
 * Adds the terms of unknowns that may start from 0: masses of rods and bodies, springs, friction,
 * torques, drag, an acceleration of the pivot. A pendulum on a cart is not changed.
 *
 * tree  as api_tree_read left it.
 * list  the unknowns in the document, valid or not.
 *
 * PEND_NO_MEMORY  O(arms + unknowns).
 */
PEND_MUST_CHECK enum pend_status api_fit_give_terms(struct api_tree *tree,
                                                    const struct api_value *list);
