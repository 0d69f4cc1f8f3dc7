/* Reads the controllers of a pendulum: the field `control`.
 * Leaves to others: what their laws compute (core/integrate/pieces/control).
 * Invariant: every error is added; numbers are in stored order. */
#pragma once

#include "api/read/rules_json.h"

struct api_tree;

/* The pendulum that is controlled. */
struct api_controlled {
    const struct pend_tree *tree;
    int cart; /* non-zero: stored arm 0 is a cart */
    /* reads an arm by its number or name; returns the caller's number from 0, or -1 after an
     * error */
    int (*arm)(const struct api_tree *whole, const struct api_value *value,
               struct api_problem *problem);
    const struct api_tree *whole;
};

/** Returns the index in stored order of number i of a state in the caller's order: all theta, all
 * thetad, the cart's position and velocity; larger i are returned unchanged. O(1). */
int api_control_place(const struct api_controlled *of, int i);

/**
 * Reads controllers; without a value there are none.
 *
 * PEND_NO_MEMORY  errors are added to the problem. O(numbers).
 */
PEND_MUST_CHECK enum pend_status api_control_read(struct api_rules *rules,
                                                  const struct api_controlled *of,
                                                  const struct api_value *value,
                                                  struct api_problem *problem);
