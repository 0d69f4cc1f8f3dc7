/* Frequencies of the modes of a pendulum that hangs, as they are counted with a stopwatch.
 * Leaves to others: the modes (core/modes), what they are compared with (fit_model).
 * Invariant: the slowest of the modes that swing comes first. */
#ifndef PEND_FIT_MODES_H
#define PEND_FIT_MODES_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/**
 * Angular frequencies of the modes about the equilibrium next to hanging, with friction as it is.
 *
 * omega  out, n numbers, rad/s: those above 0 ascending, then zeros for modes that do not swing.
 *
 * PEND_INVALID, PEND_NOT_FINITE, PEND_NO_CONVERGENCE  there are no such modes.
 * PEND_NO_MEMORY  O(n^2), with friction O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_fit_modes(const struct pend_tree *tree,
                                                const struct pend_loads *loads, double omega[]);

#endif
