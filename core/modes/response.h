/* The linear response of a pendulum to harmonic drives: how far every arm swings, and when, at
 * each frequency.
 * Leaves to others: where the pendulum rests (rest), its free motion (damped), large swings
 * (integrate).
 * Invariant: with a drive Re(f e^{i w t}) the motion about the equilibrium is Re(x e^{i w t}),
 * (K - w^2 M + i w C) x = f; no matrix is formed. */
#ifndef PEND_RESPONSE_H
#define PEND_RESPONSE_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Frequencies that are computed side by side. */
enum { PEND_RESPONSE_LANES = 8 };

/* What is answered of each arm. Forces are what they are beyond those at rest, in the arm's own
 * frame, which turns with it: as bodies_forces has them. */
enum pend_response_part {
    PEND_RESPONSE_ANGLE,        /* rad */
    PEND_RESPONSE_X,            /* m, of the tip, the pivot's motion included */
    PEND_RESPONSE_Y,            /* m */
    PEND_RESPONSE_JOINT_ALONG,  /* N */
    PEND_RESPONSE_JOINT_ACROSS, /* N */
    PEND_RESPONSE_TIP_ALONG,    /* N: the paper's lambda */
    PEND_RESPONSE_TIP_ACROSS,   /* N */
    PEND_RESPONSE_PARTS
};

/* Complex amplitudes f of what drives the pendulum. */
struct pend_response_drive {
    double pivot_re[2], pivot_im[2]; /* m, of the pivot's x and y */
    const double *couple_re; /* n, N m, stored order: on the arm, and with the opposite sign on
                                what carries it, unless that is a cart; NULL = none */
    const double *couple_im;
};

struct pend_response;

/**
 * Prepares the response about the equilibrium near a state.
 *
 * response  out; NULL on failure; released by pend_response_free.
 * tree      must outlive the response, as must what loads point to.
 * loads     of any pendulum; harmonics are left out, and friction of speed s counts as f / s.
 * phi       n angles to start from, rad, stored order. The place of a cart stands for its angle
 *           here and below, m, and the force along the rail for the couple on it, N; its forces
 *           and its tip's place are of no meaning.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE no equilibrium was found.
 * O(n) a step of the search.
 */
PEND_MUST_CHECK enum pend_status pend_response_new(struct pend_response **response,
                                                   const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const double phi[], struct pend_error *error);

/** Frees a response and clears the pointer; NULL is accepted. */
void pend_response_free(struct pend_response **response);

/** Returns the equilibrium: n angles, rad, stored order, which the response owns. */
const double *pend_response_rest(const struct pend_response *response);

/** Non-zero if the potential energy is a minimum at the equilibrium. */
int pend_response_stable(const struct pend_response *response);

/**
 * Computes the response at some frequencies.
 *
 * count    1 .. PEND_RESPONSE_LANES.
 * omega    count frequencies, rad/s, >= 0.
 * re, im   out: for each part count x n numbers, stored order; NULL for parts that are not wanted.
 * defined  out, count flags: 0 where the amplitude is not finite or not known: at the frequency of
 *          a mode that nothing damps, or at 0 where nothing pulls back. A change of the last
 *          digits of the frequency would change it altogether there; its numbers are 0.
 *
 * The bits of a frequency do not depend on the others. Cannot fail; O(n).
 */
void pend_response_at(struct pend_response *response, int count, const double omega[],
                      const struct pend_response_drive *drive,
                      double *const re[PEND_RESPONSE_PARTS], double *const im[PEND_RESPONSE_PARTS],
                      unsigned char defined[]);

/** Returns the bytes of a response of n arms. O(1). */
double pend_response_bytes(int n);

#endif
