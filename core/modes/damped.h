/* Small motions of a real pendulum about an equilibrium: its modes, damped or not. Few arms use
 * dense matrices.
 * Leaves to others: the equilibrium (rest), many arms (still, lossy), ideal pendulums, whose modes
 * need no matrix (modes). Invariant: the equations are M x'' + C x' + K x = 0 in the angles x from
 * the equilibrium; drives that depend on time are ignored. */
#pragma once

#include "core/modes/matrix.h"
#include "core/modes/still.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* From this number of coordinates on, undamped modes are found without a matrix; for fewer, dense
 * matrices are as fast. */
enum { PEND_DAMPED_TREE = 24 };
/* The largest number of coordinates whose damped modes are found from dense matrices. */
enum { PEND_DAMPED_DENSE = 100 };

struct pend_lossy;

/* Modes of n arms. Mode k moves as e^{(decay + i omega) t}: a pair of complex eigenvalues is one
 * mode, a real eigenvalue is one with omega = 0. */
struct pend_damped {
    int n, count;    /* number of arms; number of modes, n .. 2 n */
    double *phi;     /* n: the equilibrium, rad, stored order */
    double *omega;   /* rad/s, >= 0 */
    double *decay;   /* 1/s: the real part of the eigenvalue, negative for a decaying mode */
    double *re, *im; /* shapes, mode-major: the angle of arm k in mode j at j n + k. The largest
                      * entry of an arm is 1; if no arm swings, the entry of the cart, m, is 1. */
    /* state of the running search */
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    struct pend_still *still;
    double *square; /* n + n^2 numbers, results of that search */
    struct pend_lossy *lossy;
};

/**
 * Computes M, C and K at an equilibrium, n x n row-major each.
 *
 * M  kg m^2: M_jk = Re(conj(p u_j) H_k u_k) for an arm k beyond the point p of arm j, H the first
 *    moment of an arm with its sub-tree; M_kk = J_k + sum |p_c|^2 m_c.
 * C  N m s/rad: friction of the joints (friction of speed s counts as f / s), drag of the tips, 2
 *    gamma M.
 * K  N m/rad: springs, and Re(conj(G) H_k u_k) on the diagonal, which may be negative; G = i g + a,
 *    a the constant acceleration of the pivot.
 *
 * PEND_NO_MEMORY
 * O(n^2).
 */
PEND_MUST_CHECK enum pend_status pend_damped_matrices(const struct pend_tree *tree,
                                                      const struct pend_loads *loads,
                                                      const double phi[], double mass[],
                                                      double damping[], double stiffness[]);

/**
 * Computes one of the matrices of M x'' + C x' + K x = B u, u the torques of the joints; A is M^-1
 * K, S the path matrix.
 *
 * phi  n angles of an equilibrium, rad, stored order.
 * out  n x n row-major, in the caller's order; in B and S, the diagonal entry of a cart is the only
 *      one in its row and column.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE  M is numerically not positive definite.
 * O(n^2), A O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_damped_matrix(const struct pend_tree *tree,
                                                    const struct pend_loads *loads,
                                                    const double phi[], enum pend_matrix which,
                                                    double out[]);

/**
 * Finds all modes about the equilibrium to which Newton's method converges from a start.
 *
 * damped  out; NULL on failure; released by pend_damped_free.
 * phi     n angles to start from, rad, stored order.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE the equilibrium was not found, or eigenvalues did not converge.
 * Modes are sorted: growing ones first, then by omega, then by decay. O(n^2) without damping or
 * above PEND_DAMPED_DENSE, else O(n^3) with a matrix of 2 n rows.
 */
PEND_MUST_CHECK enum pend_status pend_damped_new(struct pend_damped **damped,
                                                 const struct pend_tree *tree,
                                                 const struct pend_loads *loads, const double phi[],
                                                 struct pend_error *error);
void pend_damped_free(struct pend_damped **damped);

/**
 * Finds the equilibrium as pend_damped_new does; pend_damped_step then finds the modes.
 *
 * tree, loads  must outlive the search.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE the equilibrium was not found. O(n) per step of Newton's method.
 */
PEND_MUST_CHECK enum pend_status pend_damped_begin(struct pend_damped **damped,
                                                   const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const double phi[], struct pend_error *error);

/**
 * Continues the search for modes: by some hundred sweeps over an undamped tree of PEND_DAMPED_TREE
 * arms or more, or over a damped tree of more than PEND_DAMPED_DENSE; otherwise it finds all modes
 * at once.
 *
 * damped  not finished; NULL on failure.
 * done    out, non-zero once all modes are found.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE eigenvalues did not converge.
 */
PEND_MUST_CHECK enum pend_status pend_damped_step(struct pend_damped **damped, int *done,
                                                  struct pend_error *error);
