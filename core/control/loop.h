/* The linearized pendulum near an equilibrium, sampled, with actuators that hold their output for a
 * period; and its closed loop: multipliers, margins, reachable modes.
 * Leaves to others: the equilibrium and its modes (modes), running a controller (integrate).
 * Invariant: a and b are exact for the linearized motion; the state is stored in the units `scale`,
 * powers of two in which masses and the fastest rate are near 1.
 *
 * Derivation. The angles q from the equilibrium obey M q'' + C q' + K q = E u; with x = (q, q')
 * this is x' = F x + P u. Held over a period h, x_{k+1} = e^{F h} x_k + (integral of e^{F s}) P
 * u_k; both are blocks of the exponential of h [F P; 0 0]. A delay of d samples appends the last d
 * outputs to the state, newest first; the oldest one acts. Margins follow from 1 + L(z) = prod (z -
 * c_i) / prod (z - o_i) on the unit circle, where c_i are the multipliers of the closed loop and
 * o_i those of the loop that is open at one actuator. */
#pragma once

#include "core/modes/damped.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_loop {
    int n, inputs, delay;        /* number of coordinates and of actuators; delay in samples */
    int rows;                    /* size of the state: 2 n + inputs delay */
    double period;               /* s */
    double *mass, *inverse;      /* n x n: M and M^-1 */
    double *joint;               /* n x inputs: E, +1 for the arm, -1 for the arm that holds it */
    double *a, *b;               /* rows x rows and rows x inputs, in units of scale */
    double *scale, *input_scale; /* units of the state, rows numbers; of the inputs */
};

/* Margins of one actuator; all other loops are closed. */
struct pend_margins {
    double gain[2]; /* factors of the gain between which the loop is stable; 0, INFINITY = no
                     * bound */
    double phase;   /* rad, the least phase lag or lead that makes the loop unstable; pi = none */
    double delay;   /* s, the least delay that makes the loop unstable; INFINITY = none */
};

/**
 * Creates the loop about an equilibrium.
 *
 * loop    out; NULL on failure; freed by pend_loop_free.
 * phi     n angles of the equilibrium, rad, stored order; for a cart its position, m.
 * inputs  number of actuators, >= 1.
 * input   stored arms whose joints the actuators turn, N m; on a cart the output is a force, N.
 * period  s, > 0.
 * delay   samples, >= 0.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE  a value overflows.
 * O(rows^3).
 */
PEND_MUST_CHECK enum pend_status
pend_loop_new(struct pend_loop **loop, const struct pend_tree *tree, const struct pend_loads *loads,
              const double phi[], int inputs, const int input[], double period, int delay);
void pend_loop_free(struct pend_loop **loop);

/**
 * Computes the gains of u = -K x that minimize the sum of q x^2 + r u^2 over all samples.
 *
 * q      2 n weights >= 0: angles, then rates, in natural units.
 * r      inputs weights > 0.
 * gains  out, inputs x rows, natural units; those of delayed outputs last.
 *
 * Fails as pend_riccati.
 */
PEND_MUST_CHECK enum pend_status pend_loop_gains(const struct pend_loop *loop, const double q[],
                                                 const double r[], double gains[]);

/**
 * Computes the multipliers of the loop, by which deviations change from sample to sample.
 *
 * gains   inputs x rows.
 * open    index of an actuator whose gains count as 0; -1 = none.
 * re, im  out, rows numbers each, the largest first.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  O(rows^3).
 */
PEND_MUST_CHECK enum pend_status pend_loop_multipliers(const struct pend_loop *loop,
                                                       const double gains[], int open, double re[],
                                                       double im[]);

/** Computes the margins of a stable loop at one actuator. Fails as pend_loop_multipliers. O(rows^3
 * + 10^4 rows). */
PEND_MUST_CHECK enum pend_status pend_loop_margins(const struct pend_loop *loop,
                                                   const double gains[], int input,
                                                   struct pend_margins *margins);

/**
 * Computes how well modes are controllable or observable: |x^T e| for a mode x of unit norm in M
 * and e of unit norm in M^-1; over several e, the root of the sum of squares. For modes with the
 * same eigenvalue, the directions that earlier modes reach are subtracted.
 *
 * modes   of the loop's equilibrium.
 * count   vectors e: n x count, row-major; `joint` for actuators, unit vectors for sensors.
 * reach   out, modes->count numbers; below PEND_LOOP_REACHED the mode is not reached.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_loop_reach(const struct pend_loop *loop,
                                                 const struct pend_damped *modes, int count,
                                                 const double vectors[], double reach[]);
#define PEND_LOOP_REACHED 1e-7
