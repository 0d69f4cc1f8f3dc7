/* What makes a motion a list of pieces: rules by which something changes between two of them.
 * Leaves to others: the loop over pieces (core/integrate/pieces), their JSON (api).
 * Invariant: immutable while a motion is computed; a pendulum without rules has one piece. */
#ifndef PEND_RULES_H
#define PEND_RULES_H

#include <stddef.h>

#include "core/base/status.h"
#include "core/tree/terms.h"

/* What a table gives before its first instant and after its last one. */
enum pend_outside { PEND_OUTSIDE_REFUSE, PEND_OUTSIDE_HOLD, PEND_OUTSIDE_ZERO };

/* A torque, N m, or a force on a cart, N, given at instants, and added to the other inputs. */
struct pend_table {
    int drives; /* a stored arm; 0 of a pendulum on a cart is the cart */
    int count;  /* instants, >= 1 */
    int linear; /* 0: a value holds until the next instant; 1: linear between two */
    enum pend_outside outside;
    const double *t, *value; /* s, ascending, in the time of the drives; not owned */
};

struct pend_rules {
    int tables;
    const struct pend_table *table; /* not owned */
};

/** Returns the first instant, s, at which an input changes after `now`, or before it for way < 0;
 * an infinity if there is none. O(tables log(instants)). */
double pend_rules_next(const struct pend_rules *rules, double now, int way);

/**
 * Writes the inputs of the piece that begins at an instant, or ends there for way < 0.
 *
 * now    s, at which PEND_TERM_PIECE is put.
 * value  in and out: the list of the terms; number j at value[j * stride].
 *
 * O(n + tables log(instants)).
 */
void pend_rules_inputs(const struct pend_rules *rules, const struct pend_terms *terms, double now,
                       int way, double value[], size_t stride);

/**
 * Checks that tables cover a motion.
 *
 * PEND_INVALID  the motion leaves a table that has no value outside; error->arm is the caller's
 *               arm as `order` numbers it.
 */
PEND_MUST_CHECK enum pend_status pend_rules_check(const struct pend_rules *rules, const int order[],
                                                  double first, double last,
                                                  struct pend_error *error);

#endif
