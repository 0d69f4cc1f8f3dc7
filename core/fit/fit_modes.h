/* Frequencies of the modes of a hanging pendulum, as measured with a stopwatch.
 * Leaves to others: the modes (core/modes), comparison with data (fit_model).
 * Invariant: the slowest swinging mode comes first. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/**
 * Computes the angular frequencies of the modes about the equilibrium near hanging, including
 * friction.
 *
 * omega  out, n numbers, rad/s: positive ones ascending, then zeros for modes that do not swing.
 *
 * PEND_INVALID, PEND_NOT_FINITE, PEND_NO_CONVERGENCE  the pendulum has no such modes.
 * PEND_NO_MEMORY  O(n^2), with friction O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_fit_modes(const struct pend_tree *tree,
                                                const struct pend_loads *loads, double omega[]);
