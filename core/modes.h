/* Eigenfrequencies and eigenmodes of the linearization about hanging, theta'' = -A theta (lin).
 * Leaves to others: drawing and time (method_linear, api).
 * Invariant: omega ascending; vectors orthogonal in the mass inner product, in the tree's stored order. */
#ifndef PEND_MODES_H
#define PEND_MODES_H

#include "core/tree.h"

/* An entry of a vector counts as zero when its size is at most this part of the vector's largest: the paper's
 * (0, 1, -1) comes out of floating point with a first entry of round-off. */
#define PEND_MODES_ZERO 1e-9

enum pend_normalize { PEND_NORMALIZE_FIRST, PEND_NORMALIZE_MASS, PEND_NORMALIZE_MAX };

/* count modes of n arms; vector[k * n + arm] is mode-major, arm in stored order. */
struct pend_modes {
    int count, n;
    int first;      /* the number, from 0, of the first mode held: 0 unless only part was asked for */
    double *omega;  /* rad/s, ascending */
    double *vector; /* theta of arm, scaled so that vector^T Re(0) vector = 1; NULL when not asked for */
    double *norm;   /* sqrt(vector^T Re(0) vector) of each vector as it is scaled now; NULL without vectors */
};

/**
 * All modes of a tree.
 *
 * Signs and bases are fixed, so that the same tree gives the same vectors: the first entry in the caller's order that
 * is not zero (PEND_MODES_ZERO) is positive, and the vectors of a multiple frequency are the one orthogonal basis in
 * which that entry comes later from vector to vector.
 *
 * modes    out; NULL on failure; ends with pend_modes_free.
 * gravity  m/s^2, > 0.
 * vectors  non-zero to compute the eigenvectors too.
 *
 * PEND_INVALID         gravity is not > 0.
 * PEND_NO_MEMORY, PEND_NO_CONVERGENCE
 * O(n^3) time, O(n^2) memory.
 */
PEND_MUST_CHECK enum pend_status pend_modes_new(struct pend_modes **modes, const struct pend_tree *tree, double gravity,
                                                int vectors, struct pend_error *error);

/** Frees modes and clears the pointer; NULL is accepted. */
void pend_modes_free(struct pend_modes **modes);

/**
 * Rescales every vector in place: FIRST makes the first entry (in the caller's order) that is not zero 1, MASS makes
 * vector^T Re(0) vector = 1 with the first non-zero entry positive, MAX makes the entry of largest magnitude 1 (of
 * several that agree to PEND_MODES_ZERO the first). O(count n).
 */
void pend_modes_normalize(struct pend_modes *modes, const struct pend_tree *tree, enum pend_normalize rule);

/**
 * Amplitude and phase of every mode in a start: theta(t) = sum_k amplitude_k vector_k cos(omega_k t + phase_k).
 *
 * theta, rate  n values, rad and rad/s, stored order; vectors as they are normalised now.
 * amplitude    out, count values, >= 0.
 * phase        out, count values, rad in (-pi, pi]; 0 where the amplitude is 0.
 *
 * PEND_NO_MEMORY  O(n) scratch.
 * O(count n).
 */
PEND_MUST_CHECK enum pend_status pend_modes_decompose(const struct pend_modes *modes, const struct pend_tree *tree,
                                                      const double theta[], const double rate[], double amplitude[],
                                                      double phase[]);

#endif
