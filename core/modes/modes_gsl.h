/* Modes through GSL's dense symmetric eigensolver: the independent check of the fast form, for
 * small trees.
 * Leaves to others: large trees, wild masses (modes).
 * Invariant: works on the paper's matrices only, shares no formula with the fast form. */
#ifndef PEND_MODES_GSL_H
#define PEND_MODES_GSL_H

#include "core/modes/modes_store.h"
#include "core/tree/loads.h"

/**
 * All modes of a tree from its mass matrix. Parameters and result as pend_modes_new.
 *
 * With K = g diag(l (S^T m)) the symmetric K^{-1/2} Re(0) K^{-1/2} has the eigenvalues 1/omega^2:
 * the slow modes, those that one sees, are its large ones and come out to full precision.
 *
 * PEND_INVALID         gravity is not > 0.
 * PEND_NO_MEMORY, PEND_NO_CONVERGENCE O(n^3) time, O(n^2) memory.
 */
PEND_MUST_CHECK enum pend_status pend_modes_gsl_new(struct pend_modes **modes,
                                                    const struct pend_tree *tree,
                                                    const struct pend_loads *loads, int vectors,
                                                    struct pend_error *error);

#endif
