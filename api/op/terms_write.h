/* Writing the terms of a real pendulum in the format of requests.
 * Leaves to others: the arms themselves (tree_write), reading the text (read/terms_json).
 * Invariant: reading the text gives the same list of numbers, bit for bit. */
#pragma once

#include "api/json/json_out.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/**
 * Appends the fields of stored arm k as members of its object; nothing for an ideal pendulum.
 *
 * Fails as api_out_number does. O(its harmonics + log of all harmonics).
 */
PEND_MUST_CHECK enum pend_status api_terms_write_arm(const struct pend_loads *loads, int k,
                                                     struct api_buffer *out);

/** Appends the fields of the whole pendulum as members of its object; tree: contains the mass of a
 * cart. Fails as api_out_number does. */
PEND_MUST_CHECK enum pend_status api_terms_write_whole(const struct pend_tree *tree,
                                                       const struct pend_loads *loads,
                                                       struct api_buffer *out);

/** Returns an upper bound of the bytes of this text. O(1). */
double api_terms_write_bytes(const struct pend_loads *loads);
