/* A block of samples of a motion.
 * Leaves to others: computing them (run), encoding them (api).
 * Invariant: the arrays belong to the caller. */
#pragma once

/* A block of samples, time-major in the CALLER's order of arms: phi[i * n + arm]. Arrays that are
 * not requested are NULL. */
struct pend_samples {
    long cap, count; /* capacity of the arrays; number of samples in them */
    double *t;       /* never NULL */
    double *phi, *rate, *acc, *force;
    double *z_re, *z_im, *zd_re, *zd_im;
    double *theta; /* rad, phi + pi/2; for a small swing with more correct digits than phi */
    /* N, forces of real pendulums besides `force`, the compression at the tip: across the arm at
     * its tip, and along and across the arm at its joint, as in struct bodies_forces */
    double *across, *joint_along, *joint_across;
    /* One value per sample, for a pendulum with a cart: position, m, and speed, m/s, along the
     * rail, and the force of the rail across it, N. The arrays of the arms have no column for the
     * cart. Without a cart these arrays are not changed. */
    double *cart_place, *cart_speed, *cart_reaction;
    double *control; /* N m or N: one output per controller and sample, up to this instant */
    double *kinetic, *potential; /* one value per sample, J */
    double *work, *heat;         /* J per sample: work of drives, heat of friction since the first
                                  * instant */
};
