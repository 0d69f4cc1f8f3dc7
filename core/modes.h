/* Eigenfrequencies and eigenmodes of the linearization about an equilibrium, theta'' = -A theta (lin) about hanging.
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
    int growing;    /* the first so many of the modes held do not swing but grow as e^{-omega t}, their omega < 0; 0
                       about hanging */
    double *omega;  /* rad/s, ascending; 1/s below 0 */
    double *vector; /* theta of arm, scaled so that vector^T Re(0) vector = 1 (Re of the equilibrium's angles where
                       arms stand); NULL when not asked for */
    double *norm;   /* sqrt(vector^T Re(0) vector) of each vector as it is scaled now; NULL without vectors */
};

enum pend_select { PEND_SELECT_ALL, PEND_SELECT_SLOWEST, PEND_SELECT_FASTEST, PEND_SELECT_BETWEEN };

/* What is wanted of a tree's modes; {.gravity = 9.81} asks for all frequencies about hanging. */
struct pend_modes_request {
    double gravity; /* m/s^2, > 0 */
    int vectors;    /* non-zero to compute the eigenvectors too */
    enum pend_select select;
    int count;               /* SLOWEST, FASTEST: how many of the first, of the last in ascending order of omega */
    double from, to;         /* BETWEEN: those with from <= omega <= to; none is no error */
    const unsigned char *up; /* n flags in stored order, non-zero where the arm stands up; NULL: all hang. theta is then
                                the small deviation from that equilibrium. */
};

/**
 * Modes of a tree.
 *
 * No matrix is formed: in tip displacements the linearization is a weighted tree whose sweeps count the eigenvalues
 * below a shift, to full relative precision, and give the vectors (core/README.md). Branches that are alike are solved
 * once.
 *
 * Signs and bases are fixed, so that the same tree gives the same vectors: the first entry in the caller's order that
 * is not zero (PEND_MODES_ZERO) is positive, and the vectors of a multiple frequency are the one orthogonal basis in
 * which that entry comes later from vector to vector.
 *
 * modes    out; NULL on failure; ends with pend_modes_free.
 * request  copied nowhere; see above.
 *
 * PEND_INVALID         gravity is not > 0, count not in 1 .. n, from > to or not a number.
 * PEND_NO_MEMORY, PEND_NO_CONVERGENCE
 * O(count n) time; memory O(n), with vectors O(count n).
 */
PEND_MUST_CHECK enum pend_status pend_modes_select(struct pend_modes **modes, const struct pend_tree *tree,
                                                   const struct pend_modes_request *request, struct pend_error *error);

/** All modes about hanging: pend_modes_select with the rest of the request 0. */
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
 * Amplitude and phase of every mode in a start: theta(t) = sum_k amplitude_k vector_k cos(omega_k t + phase_k). All
 * modes must swing (growing = 0).
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
