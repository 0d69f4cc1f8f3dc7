/* Rows of the paper's matrices about an equilibrium: A of the linearization, the mass matrix M,
 * S, B, and the matrices of damping C and stiffness K.
 * Leaves to others: whole matrices of an ideal pendulum (tree) and of a real pendulum (damped).
 * Invariant: no entry is a small difference of large numbers; arms are in the caller's order. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum pend_matrix {
    PEND_MATRIX_A,
    PEND_MATRIX_M,
    PEND_MATRIX_S,
    PEND_MATRIX_B,
    PEND_MATRIX_C,
    PEND_MATRIX_K,
    PEND_MATRIX_COUNT
};

/* The names of the matrices, ended by NULL. */
extern const char *const pend_matrix_names[PEND_MATRIX_COUNT + 1];

/**
 * Computes a row of a matrix.
 *
 * With s_k = 1 if arm k hangs and -1 if it is upright, theta'' = -A theta about that equilibrium
 * has A = diag(s) g Re(0)^-1 diag(l (S^T m)), and M = diag(s) Re(0) diag(s) is Re at the angles of
 * the equilibrium. Re(0)^-1 is a product of B, 1/m and 1/l, so that every entry has a closed form.
 * K = M A is diagonal, and C is 0. B also maps the torques of the joints to the torques on the
 * arms.
 *
 * loads    gravity and other loads; used for A and K only.
 * up       n flags in stored order, non-zero for upright arms; NULL if all hang.
 * arm      the row, an arm by the caller's number from 0.
 * row      out, n entries: 1/s^2, kg m^2, none, none, N m s/rad, N m/rad.
 *
 * O(n).
 */
void pend_matrix_row(const struct pend_tree *tree, const struct pend_loads *loads,
                     const unsigned char up[], enum pend_matrix which, int arm, double row[]);
