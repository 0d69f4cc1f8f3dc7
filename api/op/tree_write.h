/* Writing the arms of a pendulum in the format of requests.
 * Leaves to others: reading them (tree_json), terms (terms_write).
 * Invariant: reading the text gives the same pendulum, bit for bit. */
#pragma once

#include "api/op/terms_write.h"
#include "api/read/tree_json.h"

/** Appends the member `arms`, in the caller's order. Fails as api_out_number does. O(n +
 * harmonics). */
PEND_MUST_CHECK enum pend_status api_tree_write_arms(const struct api_tree *tree,
                                                     struct api_buffer *out);
