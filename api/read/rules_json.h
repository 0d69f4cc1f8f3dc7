/* Reading what makes a pendulum's motion a list of pieces: inputs by tables.
 * Leaves to others: the fields in which they stand (terms_json), what they do (core/tree/rules).
 * Invariant: what was made holds no pointer into the document. */
#ifndef API_RULES_JSON_H
#define API_RULES_JSON_H

#include "api/read/field.h"
#include "core/tree/rules.h"
#include "core/tree/tree.h"

/* The rules of a pendulum while it is read; arms in the caller's order, a cart is one more. */
struct api_rules {
    struct pend_table *table; /* t and value of each are one block of their own, which t begins */
    int tables, room;
};

/** Frees what was read. */
void api_rules_clear(struct api_rules *rules);

/**
 * Reads a table of what drives an arm, {"t", "value", "hold", "outside"}.
 *
 * PEND_NO_MEMORY  faults are added to the problem.
 */
PEND_MUST_CHECK enum pend_status api_rules_read_table(struct api_rules *rules, int drives,
                                                      const struct api_value *value,
                                                      struct api_problem *problem);

/**
 * Makes the rules of a tree.
 *
 * made  out, to be freed by free(); NULL if there are none.
 *
 * PEND_NO_MEMORY  O(numbers).
 */
PEND_MUST_CHECK enum pend_status api_rules_make(const struct api_rules *rules,
                                                const struct pend_tree *tree,
                                                struct pend_rules **made);

#endif
