/* The workspace of a running integration.
 * Leaves to others: the time loop (run), the samples (run_samples).
 * Invariant: one block of memory; arrays are in the tree's stored order. */
#pragma once

#include "core/integrate/run/horizon.h"

/* States at the ends of the last steps, whose energies are not computed yet. Empty after
 * pend_run_next. */
struct run_ends {
    int count, cap;
    double *phi, *rate;         /* stored order */
    double *time, *work, *heat; /* s, in the time of the request; J, work and heat so far */
    double *room;               /* scratch of 2 (cap + 1) rows for energies */
};

struct pend_run {
    const struct pend_method *method;
    struct pend_problem problem; /* phi and rate point into this block */
    void *stepper;
    struct pend_horizon *horizon; /* NULL if no accuracy is given */
    double start, end;            /* s: first instant; last instant, relative */
    double reached;               /* s, relative: the end of the last step */
    long next;                    /* index of the first instant without a sample */
    int group;                    /* maximum number of instants in one group */
    long listed_from;             /* index of the first instant in t */
    int listed;                   /* number of instants in t */
    int ordered;                  /* whether the stored order is the caller's order */
    double sample_cost;           /* cost of a sample in arm evaluations */
    double scale, energy_start, drift;
    int gives;                 /* whether drives or friction change the energy */
    struct pend_error failure; /* the failure, if any; otherwise its code is PEND_OK */
    double *t, *relative;      /* the next instants; the same, relative to the first */
    struct pend_points points; /* states of a group, stored order */
    struct run_ends ends;
    double *re, *im, *scratch; /* one row each; scratch has three */
    double *turns, *turns_low; /* rad, whole turns removed from the initial angles, stored order */
    int turned;                /* whether some of these turns are not 0 */
    int fine;                  /* whether the initial state has digits beyond those of doubles */
    int unlike;                /* forces are computed from states, because series lose digits */
    double *spare; /* accelerations of a group, if needed but not requested; else NULL */
    double *room;  /* scratch of four rows for energies */
    void *work;    /* scratch of pend_dynamics_many, or of pend_dynamics_at for a real pendulum */
};
