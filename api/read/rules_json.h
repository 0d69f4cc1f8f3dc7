/* Reads the rules that divide a motion into pieces: tables of inputs, dry friction, stops.
 * Leaves to others: the fields that contain them (terms_json), their effect (core/tree/rules).
 * Invariant: the result contains no pointer into the document. */
#pragma once

#include "api/read/field.h"
#include "core/tree/rules.h"
#include "core/tree/tree.h"

/* The rules of a pendulum while it is read; arms are in the caller's order, and a cart follows
 * them. */
struct api_rules {
    struct pend_table *table; /* t and value of each table are in one block, which begins with t */
    int tables, room;
    /* rows of n + 1 numbers: sliding and static friction, lower and upper stop, restitution; NULL =
     * no joint has dry friction or stops */
    double *joint;
    int n, rubs, stops;                 /* number of arms; whether a joint has dry friction; whether
                                         * a joint has a stop */
    struct pend_controller *controller; /* in stored order, as are laws and numbers */
    struct pend_law *law;
    double *number;
    int controllers, laws;
    size_t numbers;
};

enum api_joint_row {
    API_JOINT_SLIDING,
    API_JOINT_HOLDING,
    API_JOINT_LEAST,
    API_JOINT_MOST,
    API_JOINT_RESTITUTION,
    API_JOINT_ROWS
};

/**
 * Reads a table that drives an arm, {"t", "value", "hold", "outside"}.
 *
 * PEND_NO_MEMORY  errors are added to the problem.
 */
PEND_MUST_CHECK enum pend_status api_rules_read_table(struct api_rules *rules, int drives,
                                                      const struct api_value *value,
                                                      struct api_problem *problem);

/**
 * Reads Coulomb friction, {"torque", "static"}, or of a cart {"force", "static"}.
 *
 * name  "torque" or "force".
 * n     arms of the pendulum; the cart is arm n.
 *
 * PEND_NO_MEMORY  errors are added to the problem.
 */
PEND_MUST_CHECK enum pend_status api_rules_read_friction(struct api_rules *rules, int n, int arm,
                                                         const char *name,
                                                         const struct api_value *value,
                                                         struct api_problem *problem);

/** Reads a stop, {"min", "max", "restitution"}. Parameters as in api_rules_read_friction. */
PEND_MUST_CHECK enum pend_status api_rules_read_stop(struct api_rules *rules, int n, int arm,
                                                     const struct api_value *value,
                                                     struct api_problem *problem);

/**
 * Creates the rules of a tree.
 *
 * made  out, to be freed by free(); NULL if there are none.
 *
 * PEND_NO_MEMORY  O(numbers).
 */
PEND_MUST_CHECK enum pend_status api_rules_make(const struct api_rules *rules,
                                                const struct pend_tree *tree,
                                                struct pend_rules **made);
