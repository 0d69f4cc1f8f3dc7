/* A block of samples of a motion.
 * Leaves to others: computing them (run), encoding them (api).
 * Invariant: the arrays belong to the caller. */
#pragma once

/* A block of samples, time-major in the CALLER's order of arms: phi[i * n + arm]. Arrays that
 * are not wanted are NULL. */
struct pend_samples {
    long cap, count; /* sizes of the arrays, and number of samples in them */
    double *t;       /* never NULL */
    double *phi, *rate, *acc, *force;
    double *z_re, *z_im, *zd_re, *zd_im;
    double *theta; /* rad, phi + pi/2, of small swings with all the digits that phi as a double does
                      not hold */
    /* N, of real pendulums more than `force`, the compression at the tip: across the arm there, and
     * along and across it at its joint; as struct bodies_forces has them */
    double *across, *joint_along, *joint_across;
    /* one value a sample, of a pendulum with a cart: place, m, and speed, m/s, along the rail, and
     * the force of the rail across it, N; the arrays of the arms have no column for the cart. Of a
     * pendulum without a cart they stay as they are. */
    double *cart_place, *cart_speed, *cart_reaction;
    double *control; /* an output a controller and sample, N m or N, that acts up to this instant */
    double *kinetic, *potential; /* one value a sample, J */
    double *work, *heat; /* one value a sample, J: what drives gave and friction took since the
                            first instant */
};
