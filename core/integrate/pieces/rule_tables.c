/* Inputs given at instants: a piece ends at each of them.
 * Leaves to others: the tables' values, with which every list of inputs begins (core/tree/rules).
 */
#include "core/integrate/pieces/rule.h"

static int tables_has(const struct pend_rules *rules) { return rules->tables > 0; }

static double tables_next(const struct pend_piece *piece, const void *own) {
    (void)own;
    return pend_rules_next(piece->rules, piece->now, piece->way);
}

const struct pend_rule pend_rule_tables = {.has = tables_has, .next = tables_next};
