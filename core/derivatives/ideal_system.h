/* The arrays of an ideal pendulum's motion in a step and of eight derivatives beside it.
 * Leaves to others: memory (ideal), arithmetic (kernel_ideal).
 * Invariant: series of the motion are in tiles of eight arms, those of derivatives in rows of eight
 * parameters. */
#ifndef PEND_IDEAL_SYSTEM_H
#define PEND_IDEAL_SYSTEM_H

#include "core/taylor/jets_system.h"

/* arms of a tree whose system is inverted; rows of eight numbers an arm that a group works in */
enum { IDEAL_LANES = 8, IDEAL_DENSE = 4, IDEAL_WORK = 18, IDEAL_BEYOND = 3 };

/* The motion about the start of a step, the same for all groups. Series are in tiles of eight arms:
 * order j of arm k is at ideal_place(known, k, j); what is beyond the order is 0. */
struct ideal_known {
    int n, order;
    int masses;                      /* some parameter is a mass */
    size_t tile;                     /* numbers of a tile of eight arms */
    double *rate;                    /* order 0 .. order, in units; from the caller, as `force` */
    double *force;                   /* order -1, which is 0, .. order - 1 */
    const double *kept_re, *kept_im; /* the motion's own turns, of a small tree; else NULL */
    /* e^{i (phi - phi_0)}, to order + 1 */
    double *turn_re, *turn_im;
    /* Accelerations of tips less gravity's in the arms' frames of the start, to order - 1, where
     * masses vary; of one arm alone the series of sin phi and cos phi. */
    double *acc_re, *acc_im;
    double *table;             /* IDEAL_DENSE * 16: what accelerations and forces answer to units */
    double gravity;            /* in units */
    double square;             /* s^2, the unit of time squared */
    struct jets_system system; /* of order 0: arrays of the factorization alone */
};

/** Where order j of arm k stands in a series of what is known. */
static inline size_t ideal_place(const struct ideal_known *known, int k, int j) {
    return (size_t)(k / IDEAL_LANES) * known->tile + (size_t)j * IDEAL_LANES +
           (size_t)(k % IDEAL_LANES);
}

/* Eight derivatives. Arrays are rows of eight numbers, one an arm in stored order, aligned to 64
 * bytes; a series has `rows` rows an arm. */
struct ideal_group {
    size_t rows;
    int lengths, masses;                         /* some of its parameters are of this kind */
    double *phi, *phi_low, *rate, *rate_low;     /* at the start of a step */
    double *end_phi, *end_low, *end_rate, *slow; /* at its end */
    double *length, *mass;                       /* how lengths, over themselves, and masses vary */
    double *gravity;                             /* one row */
    double *angle;                               /* series of phi, order 0 .. order + 1 */
    double *along, *across; /* of the force at the tip in the arm's frame of the start */
    double *work;           /* IDEAL_WORK rows an arm */
    double *out[4];         /* phi, rate, acc, force at an instant */
};

#endif
