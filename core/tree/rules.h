/* The rules that divide a motion into pieces: what changes between two pieces.
 * Leaves to others: the loop over pieces (core/integrate/pieces), their JSON (api).
 * Invariant: immutable while a motion is computed; a motion without rules is one piece. */
#ifndef PEND_RULES_H
#define PEND_RULES_H

#include <stddef.h>

#include "core/base/status.h"
#include "core/tree/terms.h"

/* The value of a table before its first instant and after its last one. */
enum pend_outside { PEND_OUTSIDE_REFUSE, PEND_OUTSIDE_HOLD, PEND_OUTSIDE_ZERO };

/* A torque, N m, or a force on a cart, N, given at instants, and added to the other inputs. */
struct pend_table {
    int drives; /* a stored arm; 0 of a pendulum on a cart is the cart */
    int count;  /* instants, >= 1 */
    int linear; /* 0: a value holds until the next instant; 1: linear between two */
    enum pend_outside outside;
    const double *t, *value; /* s, ascending, in the time of the drives; not owned */
};

/* Arrays of n values in stored order, not owned. */
struct pend_rules {
    int tables;
    const struct pend_table *table;
    /* Coulomb friction of joints, N m, 0 = none: of a joint that slides, and the most of one that
     * holds, no less; both NULL = no joint has any. */
    const double *sliding, *holding;
    /* Stops of joints by their angles to the parents (of a root, and of arms on a cart, theta; of a
     * cart its place, m): infinities = none; restitution 0 .. 1. All NULL = no joint has any. */
    const double *least, *most, *restitution;
};

/** Non-zero if joints may hold, stick or hit. O(1). */
static inline int pend_rules_joints(const struct pend_rules *rules) {
    return rules->sliding || rules->least;
}

/**
 * Returns the first instant, s, at which an input changes after `now`, or before it if way < 0;
 * infinite if there is none. O(tables log(instants)).
 */
double pend_rules_next(const struct pend_rules *rules, double now, int way);

/**
 * Writes the inputs of the piece that begins at an instant, or that ends there if way < 0.
 *
 * now    s, the instant; becomes PEND_TERM_PIECE.
 * value  in and out: the list of the terms; number j at value[j * stride].
 *
 * O(n + tables log(instants)).
 */
void pend_rules_inputs(const struct pend_rules *rules, const struct pend_terms *terms, double now,
                       int way, double value[], size_t stride);

/** The same, and the end of the piece: what pend_rules_next returns. Of a pendulum without rules it
 * writes nothing and returns an infinity. */
double pend_rules_piece(const struct pend_terms *terms, double now, int way, double value[],
                        size_t stride);

/**
 * Checks that the tables cover the times of a motion.
 *
 * PEND_INVALID  the motion leaves a table without outside values; error->arm is the caller's arm
 *               number by `order`.
 */
PEND_MUST_CHECK enum pend_status pend_rules_check(const struct pend_rules *rules, const int order[],
                                                  double first, double last,
                                                  struct pend_error *error);

#endif
