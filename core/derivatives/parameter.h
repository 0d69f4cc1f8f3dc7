/* Parameters with respect to which a motion is differentiated.
 * Leaves to others: names of parameters (api), derivatives (derivatives).
 * Invariant: arms are counted in stored order. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* The quantity with respect to which a derivative is taken. */
enum pend_parameter_kind {
    PEND_PARAMETER_PHI,     /* the initial angle of an arm, rad */
    PEND_PARAMETER_RATE,    /* the initial rate of an arm, rad/s */
    PEND_PARAMETER_LENGTH,  /* length of an arm, m; its rod and the joints at its tip move with
                             * it */
    PEND_PARAMETER_MASS,    /* mass at the tip of an arm, kg */
    PEND_PARAMETER_GRAVITY, /* m/s^2 */
    PEND_PARAMETER_TERM     /* a value in the list of terms, in its unit */
};

struct pend_parameter {
    enum pend_parameter_kind kind;
    int at; /* stored number of the arm, or index in the list of terms; 0 for gravity */
};

/** Returns the value of a parameter; 0 for an initial angle or rate, which have fixed units.
 * O(1). */
static inline double pend_parameter_value(const struct pend_tree *tree,
                                          const struct pend_loads *loads,
                                          struct pend_parameter by) {
    switch (by.kind) {
    case PEND_PARAMETER_LENGTH:
        return tree->len[by.at];
    case PEND_PARAMETER_MASS:
        return tree->mass[by.at];
    case PEND_PARAMETER_GRAVITY:
        return loads->gravity;
    case PEND_PARAMETER_TERM:
        return loads->value[by.at];
    default:
        return 0;
    }
}
