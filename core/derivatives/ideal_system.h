/* The arrays of an ideal pendulum's motion in a step and of eight of its derivatives.
 * Leaves to others: memory (ideal), arithmetic (kernel_ideal).
 * Invariant: series of the motion are in tiles of eight arms, those of derivatives in rows of eight
 * parameters. */
#pragma once

#include "core/taylor/jets_system.h"

/* largest number of arms whose system is inverted; rows of eight numbers per arm in a group's
 * scratch */
enum { IDEAL_LANES = 8, IDEAL_DENSE = 8, IDEAL_WORK = 18, IDEAL_BEYOND = 3 };

/* number of doubles in a row of the table */
enum { IDEAL_PITCH = 2 * IDEAL_DENSE };

/* The motion about the start of a step, the same for all groups. Order j of arm k is at
 * ideal_place(known, k, j), in tiles of eight arms; coefficients beyond the order are 0. */
struct ideal_known {
    int n, order;
    int masses;    /* some parameter is a mass */
    size_t tile;   /* numbers in a tile of eight arms */
    double *rate;  /* series of the rates per unit of time, orders 0 .. order; set
                    * by the caller, as is `force` */
    double *force; /* series of the forces, orders -1 .. order - 1; order -1 is 0 */
    const double *kept_re, *kept_im; /* rotation factors stored by the motion of a small tree;
                                      * otherwise NULL */
    /* series of e^{i (phi - phi_0)}, to order + 1 */
    double *turn_re, *turn_im;
    /* If masses vary: accelerations of tips minus the acceleration of gravity, in the frames of the
     * arms at the start, to order - 1. For a pendulum with one arm: the series of sin phi and cos
     * phi. */
    double *acc_re, *acc_im;
    double *table;             /* 2 IDEAL_DENSE rows: responses of accelerations and forces to unit
                                * loads */
    double gravity;            /* gravity, with time in units of the series */
    double unit, square;       /* s, the unit of time; its square */
    struct jets_system system; /* the system of order 0; only arrays of the factorization are
                                * used */
    /* For real pendulums (ideal_loads.h); masses at the tips are those of the equivalent points. */
    int loaded, joints, bodies; /* whether it is a real pendulum; whether it has friction, springs
                                 * or torques; whether it has bodies */
    int lengths;                /* some parameter is a length */
    double *inertia;            /* n inertias of bodies beyond those of the equivalent points, kg
                                 * m^2 */
    double *hold, *stiff;       /* n torques at the joint per unit of rate, of angle */
    double *bend;               /* n deflections of springs */
    /* For bodies, n each: compliance of the tip to a force across; compliance of the joint to
     * accelerations along and across; resistance of the joint to an acceleration along; J' / l^2
     * (ideal_bodies_factor). */
    double *yield, *slip_along, *slip_across, *bear, *twist;
    double *pivot_force_re,
        *pivot_force_im; /* series of the forces on tips, in the frames of the arms at the start */
    double *across;      /* series of the forces across the arms, if lengths vary */
    const double *lift_x, *lift_y; /* series of the pivot's acceleration plus gravity; NULL if the
                                    * pivot is at rest */
};

/** Returns the index of order j of arm k in a series of the motion. */
static inline size_t ideal_place(const struct ideal_known *known, int k, int j) {
    return (size_t)(k / IDEAL_LANES) * known->tile + (size_t)j * IDEAL_LANES +
           (size_t)(k % IDEAL_LANES);
}

/* A group of eight derivatives. Arrays are rows of eight numbers, one per arm in stored order,
 * aligned to 64 bytes; a series has `rows` rows per arm. */
struct ideal_group {
    size_t rows;
    int lanes;                                   /* number of lanes with a parameter; others hold
                                                  * zeros */
    int lengths, masses;                         /* a parameter of the group is of this kind */
    double *phi, *phi_low, *rate, *rate_low;     /* state at the start of a step */
    double *end_phi, *end_low, *end_rate, *slow; /* state at the end of the step; `slow`: low-order
                                                  * part of the rates */
    double *length, *mass;                       /* derivatives of lengths, relative to the lengths,
                                                  * and of masses */
    double *gravity;                             /* derivative of gravity; one row */
    int pairs; /* true if the group varies friction, a spring or an inertia */
    double *inertia, *hold, *stiff, *torque; /* derivatives of the above and of constant torques,
                                              * which include springs with a varied rest angle */
    double *angle;                           /* series of phi, order 0 .. order + 1 */
    double *along, *across; /* series of the force at the tip, in the arm's frame at the start */
    double *work;           /* IDEAL_WORK rows per arm */
    double *out[4];         /* phi, rate, acc, force at an instant */
};
