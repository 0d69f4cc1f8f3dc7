/* Computed modes: memory, scaling, decomposition, the mass inner product, and the rule for signs
 * and bases.
 * Leaves to others: computing eigenvalues and vectors (modes).
 * Invariant: vectors are combined only within a group of frequencies that agree to round-off. */
#pragma once

#include "core/tree/loads.h"

/* The largest size, relative to the largest entry of a vector, of an entry that counts as zero.
 * Example: the first entry of the paper's mode (0, 1, -1) is computed as a number of the size of
 * round-off. */
#define PEND_MODES_ZERO 1e-9

/* The scale and the sign of a vector. */
enum pend_normalize {
    PEND_NORMALIZE_MASS,  /* vector^T Re(0) vector = 1, and the first non-zero entry (in the
                           * caller's order) is positive */
    PEND_NORMALIZE_FIRST, /* the first non-zero entry is 1 */
    PEND_NORMALIZE_MAX    /* the entry of largest magnitude is 1; if several agree to
                           * PEND_MODES_ZERO, the first of them */
};

/* count modes of n arms; vector[k * n + arm] is mode-major, arm in stored order. */
struct pend_modes {
    int count, n;
    int first;      /* number of the first stored mode among all modes of the tree, from 0 */
    int growing;    /* number of modes, at the start of the list, that grow as e^{-omega t} with
                     * omega < 0 instead of swinging; 0 about hanging */
    double *omega;  /* rad/s, ascending; 1/s if negative */
    double *vector; /* n angles theta per mode; mass-orthogonal in Re(0) or, with upright arms, in
                     * Re at the equilibrium's angles; NULL if not requested */
    double *norm;   /* per vector sqrt(vector^T Re(0) vector) in the current scale; NULL without
                     * vectors */
};

/**
 * Allocates count modes of n arms in one block; the arrays are not initialized.
 *
 * modes    out; NULL on failure; released by pend_modes_free.
 * vectors  non-zero to allocate vectors and their norms too.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_modes_alloc(struct pend_modes **modes, int count, int n,
                                                  int vectors);

/**
 * Sets the basis of the repeated frequency that begins at a mode: orthogonal vectors in echelon
 * form, each with its first non-zero entry at a later arm than the vector before.
 *
 * modes     omega ascending, vectors mass-orthogonal and of the same mass norm.
 * repeated  frequencies count as one repeated frequency if the largest exceeds the least by at most
 *           this relative difference.
 * lead      in and out, one entry per mode: the first arm (the caller's number) with a non-zero
 *           entry, -1 if unknown.
 *
 * Returns the number of the first mode of the next frequency. O(n), and O(g^2 n) for a frequency
 * of multiplicity g.
 */
int pend_modes_basis(struct pend_modes *modes, const struct pend_tree *tree, double multiple,
                     int mode, int lead[]);

/**
 * Scales a vector by a rule, and updates its norm.
 *
 * lead  the first arm (the caller's number) with a non-zero entry, -1 if unknown.
 * O(n).
 */
void pend_modes_scale(struct pend_modes *modes, const struct pend_tree *tree, int mode,
                      enum pend_normalize rule, int lead);

/** Removes all modes except numbers from .. end - 1, and counts the growing ones. O(count). */
void pend_modes_trim(struct pend_modes *modes, int from, int end);

/** Returns true if the invariants of computed modes hold. O(count). For assertions. */
void pend_modes_free(struct pend_modes **modes);

/** Returns the angle from the nearest hanging position, rad in [-pi, pi], of an angle phi + low
 * measured from the positive real axis; whole turns are removed. low is the rounding error of phi;
 * if it is 0, the double nearest -pi/2 counts as hanging. O(1). */
double pend_modes_theta(double phi, double low);

/**
 * Decomposes a start into modes: theta(t) = sum_k c_k(t) vector_k with c_k = amplitude cos(omega t
 * + phase) for a swinging mode, and c_k = rising e^{st} + falling e^{-st} for a growing one, s =
 * -omega.
 *
 * up           as in the request for the modes.
 * theta, rate  n values, rad and rad/s from the equilibrium, stored order.
 * first        out, count values, for the current scale of the vectors: amplitude >= 0; rising.
 * second       out, count values: phase, rad in (-pi, pi], 0 if the amplitude is 0; falling.
 *
 * PEND_NO_MEMORY  O(n) scratch.
 * O(count n).
 */
PEND_MUST_CHECK enum pend_status pend_modes_decompose(const struct pend_modes *modes,
                                                      const struct pend_tree *tree,
                                                      const unsigned char up[],
                                                      const double theta[], const double rate[],
                                                      double first[], double second[]);

/**
 * Differentiates the frequency of a simple mode about hanging. Rayleigh's quotient omega^2 = sum g
 * m_s l v^2 / sum m x^2 is stationary in the vector v; m_s is the mass of a sub-tree, x the
 * displacement of a tip. A repeated frequency has no derivatives.
 *
 * slope  out, 2 n + 1 numbers: by the lengths, rad/(s m), and by the masses, rad/(s kg), in stored
 *        order; by gravity, rad s/m.
 * O(n).
 */
void pend_modes_slope(const struct pend_modes *modes, const struct pend_tree *tree,
                      const struct pend_loads *loads, int mode, double slope[]);
