/* The workspace of an integration under way.
 * Leaves to others: the time loop (run), the samples (run_samples).
 * Invariant: one block of memory; arrays are in the tree's stored order. */
#pragma once

#include "core/integrate/run/horizon.h"

/* States at the ends of the last steps, whose energies were not computed yet. There are none
 * after pend_run_next. */
struct run_ends {
    int count, cap;
    double *phi, *rate;         /* stored order */
    double *time, *work, *heat; /* s, the request's own; J, what was given and lost so far */
    double *room;               /* 2 (cap + 1) rows, for energies */
};

struct pend_run {
    const struct pend_method *method;
    struct pend_problem problem; /* phi and rate point into this block */
    void *stepper;
    struct pend_horizon *horizon; /* NULL: no accuracy is given */
    double start, end;            /* s: the first instant, and the last one relative to it */
    double reached;               /* s, relative: the end of the last step */
    long next;                    /* number of the first instant without a sample */
    int group;                    /* most instants in one group */
    long listed_from;             /* number of the first instant in t */
    int listed;                   /* instants in t */
    int ordered;                  /* stored order is the caller's order */
    double sample_cost;           /* arm-evaluations that a sample stands for */
    double scale, energy_start, drift;
    int gives;                 /* drives and friction change the energy */
    struct pend_error failure; /* code PEND_OK: none */
    double *t, *relative;      /* the next instants, and the same relative to the first */
    struct pend_points points; /* a group's states, stored order */
    struct run_ends ends;
    double *re, *im, *scratch; /* one row each, and three */
    double *turns,
        *turns_low; /* rad, what the start's angles are larger by than the run's, stored order */
    int turned;     /* some turns are not 0 */
    int fine;       /* the start has digits that doubles do not hold */
    int unlike;     /* rows have the forces of their states, where those of a series lose digits */
    double *spare;  /* accelerations of a group that nobody wants; NULL where forces need none */
    double *room;   /* four rows, for energies */
    void *work;     /* of pend_dynamics_many, or of pend_dynamics_at of a real pendulum */
};
