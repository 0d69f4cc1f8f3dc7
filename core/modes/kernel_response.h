/* The sweeps over a tree for its response to harmonic drives of eight frequencies, side by side;
 * compiled once for each instruction set.
 * Leaves to others: the constants of the arms (linear_arms), the results (response).
 * Invariant: lanes never mix, so that the bits of a frequency do not depend on the others. */
#pragma once

#include "core/base/isa.h"
#include "core/modes/linear_arms.h"

enum { RESPONSE_LANES = 8 };

/* A complex number in each lane. */
struct response_lanes {
    _Alignas(64) double re[RESPONSE_LANES];
    double im[RESPONSE_LANES];
};

/* The values of an arm in the sweeps. If its base moves by b and the arm turns by x, the sub-tree
 * exerts the force form b + cross x at its base. */
struct response_node {
    struct response_lanes form[3], cross[2], own; /* coefficients of b^2 (xx, xy, yy), of b x, and
                                                   * of x^2 */
    struct response_lanes joint, inverse;         /* spring and damper of the joint; inverse of the
                                                   * elimination pivot */
    struct response_lanes drive, couple, push[2]; /* given torque, N m; torque, N m, and force, N,
                                                   * on the right-hand side of an elimination */
    struct response_lanes angle, base[2];         /* angle, rad; displacement of the joint, m */
    struct response_lanes force[2], rest;         /* joint force, N; residual of the equation, N
                                                   * m */
    struct response_lanes scale;                  /* sizes of `own`, and of the terms of `rest` */
};

/* Input and output of the sweeps for eight frequencies. */
struct response_sweep {
    double omega[RESPONSE_LANES];   /* rad/s */
    struct response_lanes pivot[2]; /* m, the pivot's displacement */
    double moved[RESPONSE_LANES];   /* J: sum of squares of the solution times the arms' own
                                     * stiffness */
    double driven[RESPONSE_LANES];  /* J: sum of squares of the torques over that stiffness */
};

/**
 * Solves the equations of motion for eight frequencies; the nodes receive angles, displacements of
 * joints and forces at joints.
 *
 * node  n, aligned to 64; in: drive; out: all other members.
 *
 * Cannot fail; values that overflow are not finite. O(n): one sweep to the root and one back, and
 * two more for each of at most six refinements.
 */
typedef void pend_response_fn(const struct linear_arms *arms, struct response_sweep *sweep,
                              struct response_node node[]);

pend_response_fn pend_response_base;
#ifdef __x86_64__
pend_response_fn pend_response_avx2, pend_response_avx512;
#endif
