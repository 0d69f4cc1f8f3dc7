/* The linear response of a pendulum to harmonic drives: amplitude and phase of every arm at each
 * frequency.
 * Leaves to others: the equilibrium (rest), its free motion (damped), large swings (integrate).
 * Invariant: with a drive Re(f e^{i w t}) the motion about the equilibrium is Re(x e^{i w t}),
 * (K - w^2 M + i w C) x = f; no matrix is formed. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Number of frequencies that are computed at once. */
enum { PEND_RESPONSE_LANES = 8 };

/* The results for each arm. Forces are differences from those at rest, in the rotating frame of the
 * arm, as in struct bodies_forces. */
enum pend_response_part {
    PEND_RESPONSE_ANGLE,        /* rad */
    PEND_RESPONSE_X,            /* m, of the tip, including the pivot's motion */
    PEND_RESPONSE_Y,            /* m */
    PEND_RESPONSE_JOINT_ALONG,  /* N */
    PEND_RESPONSE_JOINT_ACROSS, /* N */
    PEND_RESPONSE_TIP_ALONG,    /* N, the paper's lambda */
    PEND_RESPONSE_TIP_ACROSS,   /* N */
    PEND_RESPONSE_PARTS
};

/* Complex amplitudes f of the drives. */
struct pend_response_drive {
    double pivot_re[2], pivot_im[2]; /* m, of the pivot's x and y */
    const double *couple_re; /* n torques, N m, stored order: on the arm, and with the opposite sign
                              * on its parent, unless the parent is a cart; NULL = none */
    const double *couple_im;
};

struct pend_response;

/**
 * Prepares the response about the equilibrium near a state.
 *
 * response  out; NULL on failure; released by pend_response_free.
 * tree      must outlive the response, as must the data of loads.
 * loads     of any pendulum; harmonics are ignored, and friction of speed s counts as damping f /
 *           s.
 * phi       n angles to start from, rad, stored order. For a cart, here and below, its position, m,
 *           takes the place of the angle, and the force along the rail, N, that of the torque; its
 *           forces and its tip's position have no meaning.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE no equilibrium was found.
 * O(n) per step of the search.
 */
PEND_MUST_CHECK enum pend_status pend_response_new(struct pend_response **response,
                                                   const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const double phi[], struct pend_error *error);
void pend_response_free(struct pend_response **response);

/** Returns the equilibrium: n angles, rad, stored order, which the response owns. */
const double *pend_response_rest(const struct pend_response *response);

/** Returns non-zero if the potential energy is a minimum at the equilibrium. */
int pend_response_stable(const struct pend_response *response);

/**
 * Computes the response at some frequencies.
 *
 * count    1 .. PEND_RESPONSE_LANES.
 * omega    count frequencies, rad/s, >= 0.
 * re, im   out: for each part count x n numbers, stored order; NULL if not needed.
 * defined  out, count flags: 0 if the amplitude is infinite or too sensitive to the last digits of
 *          the frequency: at the frequency of an undamped mode, or at 0 without a restoring force.
 *          The results are then 0.
 *
 * The bits of a frequency do not depend on the others. Cannot fail; O(n).
 */
void pend_response_at(struct pend_response *response, int count, const double omega[],
                      const struct pend_response_drive *drive,
                      double *const re[PEND_RESPONSE_PARTS], double *const im[PEND_RESPONSE_PARTS],
                      unsigned char defined[]);

/** Returns the bytes of a response of n arms. O(1). */
double pend_response_bytes(int n);
