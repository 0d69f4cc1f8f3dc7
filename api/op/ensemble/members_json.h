/* Reads the members of an ensemble from JSON: a list of states, or of members with numbers of their
 * own; a grid of values; or random draws.
 * Leaves to others: a listed member's numbers (members_set), a member's start (members_fill), the
 * observables (observables), the computation (ensemble).
 * Invariant: no pointer into the document is kept. */
#pragma once

#include "api/op/ensemble/members_fill.h"

/**
 * Reads `states`, `members`, `grid` or `random`, with `initial` for the latter three, and `energy`.
 *
 * members  out; released by api_members_clear, also after a failure.
 * root     the request's object.
 * tree     the result of api_tree_read; if the tree is invalid, its known parts are used.
 *
 * PEND_INVALID   every error was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_members_read(struct api_members *members,
                                                  const struct api_value *root,
                                                  const struct api_tree *tree,
                                                  const struct api_limits *limits,
                                                  struct api_problem *problem);
void api_members_clear(struct api_members *members);

/** Returns the bytes of memory of the variations and of listed members' numbers, without the
 * states. O(1). */
double api_members_bytes(const struct api_members *members);
