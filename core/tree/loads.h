/* The loads on a tree: gravity and the terms of a real pendulum.
 * Leaves to others: the equations that use it (dynamics, taylor, modes, integrate).
 * Invariant: a computation never changes its loads; their owner keeps them unchanged until it
 * ends. */
#pragma once

#include "core/base/status.h"
#include "core/tree/terms.h"

/* Terms of the equations of motion that do not belong to the tree itself. */
struct pend_loads {
    double gravity; /* m/s^2, downwards (along -i); any finite value, negative values act upwards */
    const struct pend_terms *terms; /* terms besides those of the ideal pendulum; NULL = none; not
                                     * owned */
    const double *value;            /* values of the terms, terms->count numbers; not owned */
};

/** Returns non-zero if stored arm k is a cart. O(1). */
static inline int pend_loads_cart(const struct pend_loads *loads, int k) {
    return !k && pend_terms_cart(loads->terms);
}

/**
 * Checks loads for an integration.
 *
 * PEND_INVALID  gravity is not finite. O(1).
 */
PEND_MUST_CHECK enum pend_status pend_loads_check(const struct pend_loads *loads,
                                                  struct pend_error *error);

/**
 * Checks loads for a computation by power series: ensembles, Lyapunov exponents and sections, which
 * have no alternative method. Terms that the series do not support are rejected.
 *
 * PEND_INVALID  pend_loads_check fails. O(1).
 */
PEND_MUST_CHECK enum pend_status pend_loads_check_series(const struct pend_loads *loads,
                                                         struct pend_error *error);

/** Returns non-zero if the loads pull every arm downwards, so that hanging straight down is a
 * stable equilibrium: gravity is finite and greater than 0. The linear method requires this.
 * O(1). */
int pend_loads_pull_down(const struct pend_loads *loads);

/** Returns non-zero if friction or drag dissipate energy. O(n). */
int pend_loads_lose(const struct pend_loads *loads);

/** Returns an estimate of how fast terms make a pendulum move, rad/s: the sum of pend_terms_rate
 * and the fastest drive's frequency; 0 for an ideal pendulum. O(n + harmonics). */
double pend_loads_rate(const struct pend_loads *loads, const struct pend_tree *tree);

/** Returns the approximate decay rate of an arm due to friction and drag, 1/s. For stability, it
 * bounds the steps of explicit methods. O(n + harmonics). */
double pend_loads_decay(const struct pend_loads *loads, const struct pend_tree *tree);

/**
 * Checks loads for the linear method.
 *
 * PEND_INVALID  pend_loads_pull_down is false, or there are terms (core/modes/damped handles
 *               these). O(1).
 */
PEND_MUST_CHECK enum pend_status pend_loads_check_linear(const struct pend_loads *loads,
                                                         struct pend_error *error);
