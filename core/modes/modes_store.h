/* Modes once computed: memory, scaling, decomposition, the mass inner product, and the stated
 * rule for signs and bases.
 * Leaves to others: computing eigenvalues and vectors (modes_gsl, modes).
 * Invariant: rotations stay inside groups of frequencies that agree to round-off. */
#ifndef PEND_MODES_STORE_H
#define PEND_MODES_STORE_H

#include "core/tree/tree.h"

/* An entry of a vector counts as zero when its size is at most this part of the vector's
 * largest: the paper's (0, 1, -1) comes out of floating point with a first entry of round-off. */
#define PEND_MODES_ZERO 1e-9

/* How a vector is scaled and signed. */
enum pend_normalize {
    PEND_NORMALIZE_MASS,  /* vector^T Re(0) vector = 1, the first entry (in the caller's order) that
                             is not zero > 0 */
    PEND_NORMALIZE_FIRST, /* that entry is 1 */
    PEND_NORMALIZE_MAX    /* the entry of largest magnitude is 1; of several that agree to
                             PEND_MODES_ZERO the first */
};

/* count modes of n arms; vector[k * n + arm] is mode-major, arm in stored order. */
struct pend_modes {
    int count, n;
    int first;   /* the number, from 0, of the first mode held: 0 unless only part was asked for */
    int growing; /* the first so many of the modes held do not swing but grow as e^{-omega t}, their
                    omega < 0; 0 about hanging */
    double *omega;  /* rad/s, ascending; 1/s below 0 */
    double *vector; /* theta of arm; mass-orthogonal, in Re(0) or, where arms stand, Re of the
                       equilibrium's angles; NULL when not asked for */
    double *norm;   /* sqrt(vector^T Re(0) vector) of each vector as it is scaled now; NULL without
                       vectors */
};

/**
 * Room for count modes of n arms in one block; the arrays are not set.
 *
 * modes    out; NULL on failure.
 * vectors  non-zero to have room for vectors and their norms.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_modes_alloc(struct pend_modes **modes, int count, int n,
                                                  int vectors);

/**
 * Square root of x^T Re(0) x.
 *
 * x     n angles, stored order.
 * tips  n doubles of scratch.
 * O(n).
 */
double pend_modes_mass_norm(const struct pend_tree *tree, const double x[], double tips[]);

/**
 * Gives the multiple frequency that begins at a mode its stated basis: orthogonal vectors that
 * begin to move at later and later arms.
 *
 * modes     omega ascending, vectors mass-orthogonal and of the same mass norm.
 * multiple  frequencies are one multiple frequency when the largest is at most this much above the
 *           least, relatively.
 * lead      in and out, one entry a mode: the first arm (the caller's number) whose entry is not
 *           zero, -1 where that is not known.
 *
 * Returns the number of the mode after it. O(n), and O(g^2 n) for a frequency of multiplicity g.
 */
int pend_modes_basis(struct pend_modes *modes, const struct pend_tree *tree, double multiple,
                     int mode, int lead[]);

/**
 * Scales a vector by a rule, and its norm with it.
 *
 * lead  the first arm (the caller's number) whose entry is not zero, -1 when that is not known.
 * O(n).
 */
void pend_modes_scale(struct pend_modes *modes, const struct pend_tree *tree, int mode,
                      enum pend_normalize rule, int lead);

/** Frees modes and clears the pointer; NULL is accepted. */
void pend_modes_free(struct pend_modes **modes);

/**
 * The angle from the nearest hanging position, rad in [-pi, pi], of an angle phi + low from the
 * positive real axis:
 * whole turns taken off, since an arm that hangs after a turn hangs. low is what rounding has left
 * of phi, or 0: then phi is taken to hang at -pi/2 as a double. O(1).
 */
double pend_modes_theta(double phi, double low);

/**
 * What is in a start of every mode: theta(t) = sum_k c_k(t) vector_k with c_k = amplitude cos(omega
 * t + phase) of a mode that swings, and c_k = rising e^{st} + falling e^{-st} of one that grows, s
 * = -omega.
 *
 * up           as in the request for the modes.
 * theta, rate  n values, rad and rad/s from the equilibrium, stored order; vectors as they are
 *              normalised now.
 * first        out, count values: amplitude >= 0; rising.
 * second       out, count values: phase, rad in (-pi, pi], 0 where the amplitude is 0; falling.
 *
 * PEND_NO_MEMORY  O(n) scratch.
 * O(count n).
 */
PEND_MUST_CHECK enum pend_status pend_modes_decompose(const struct pend_modes *modes,
                                                      const struct pend_tree *tree,
                                                      const unsigned char up[],
                                                      const double theta[], const double rate[],
                                                      double first[], double second[]);

#endif
