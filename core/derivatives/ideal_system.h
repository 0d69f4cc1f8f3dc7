/* The arrays of an ideal pendulum's motion in a step and of eight derivatives beside it.
 * Leaves to others: memory (ideal), arithmetic (kernel_ideal).
 * Invariant: series of the motion are in tiles of eight arms, those of derivatives in rows of eight
 * parameters. */
#ifndef PEND_IDEAL_SYSTEM_H
#define PEND_IDEAL_SYSTEM_H

#include "core/taylor/jets_system.h"

/* arms of a tree whose system is inverted; rows of eight numbers an arm that a group works in */
enum { IDEAL_LANES = 8, IDEAL_DENSE = 8, IDEAL_WORK = 18, IDEAL_BEYOND = 3 };

/* numbers of a row of the table */
enum { IDEAL_PITCH = 2 * IDEAL_DENSE };

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
    double *table;       /* 2 IDEAL_DENSE rows: what accelerations and forces answer to units */
    double gravity;      /* in units */
    double unit, square; /* s, the unit of time; its square */
    struct jets_system system; /* of order 0: arrays of the factorization alone */
    /* Of a real pendulum (ideal_loads.h), whose masses at the tips are those of the points that its
     * bodies are like: */
    int loaded, joints, bodies; /* it is one; torques of friction and springs; bodies */
    int lengths;                /* some parameter is a length */
    double *inertia;            /* n: what bodies have beyond such points, kg m^2 */
    double *hold, *stiff;       /* n: torque for a unit of rate, of angle, to the parent */
    double *bend;               /* n: angles from those at which springs rest */
    /* n, of bodies: what the tip of an arm yields to a force across, and its joint to accelerations
     * along and across; what the joint opposes to one along; J' / l^2 (ideal_bodies_factor) */
    double *yield, *slip_along, *slip_across, *bear, *twist;
    double *pivot_force_re,
        *pivot_force_im; /* series of the forces on tips, in the arms' frames of the start */
    double *across;      /* series of the forces across, where lengths vary */
    const double *lift_x, *lift_y; /* series of the pivot's acceleration and gravity; NULL = that
                                    * of a pivot at rest */
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
    int lanes;                                   /* with a parameter; the others hold zeros */
    int lengths, masses;                         /* some of its parameters are of this kind */
    double *phi, *phi_low, *rate, *rate_low;     /* at the start of a step */
    double *end_phi, *end_low, *end_rate, *slow; /* at its end */
    double *length, *mass;                       /* how lengths, over themselves, and masses vary */
    double *gravity;                             /* one row */
    int pairs; /* some of its parameters are those of friction or springs, or of inertias */
    double *inertia, *hold, *stiff, *torque; /* how they vary; constant torques, those of springs
                                              * that rest elsewhere included */
    double *angle;                           /* series of phi, order 0 .. order + 1 */
    double *along, *across; /* of the force at the tip in the arm's frame of the start */
    double *work;           /* IDEAL_WORK rows an arm */
    double *out[4];         /* phi, rate, acc, force at an instant */
};

#endif
