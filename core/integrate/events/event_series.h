/* Quantities of a motion as power series over one step of the Taylor method, of a run or of a
 * member of an ensemble. Leaves to others: the series of angles and forces (jets, kernel_ensemble),
 * the conditions on the quantities (event_search). Invariant: series are in powers of the fraction
 * s of the step, 0 .. 1, so that coefficients neither overflow nor vanish. */
#pragma once

#include "core/integrate/methods/method.h"
#include "core/taylor/roots.h"

enum { EVENT_TERMS = PEND_ROOTS_DEGREE + 1 };

/* Forces of all arms at the nodes of a step, computed from the states there. They replace those of
 * the series, which lose digits if masses are very different (pend_dynamics_unlike). */
enum { EVENT_NODES = 5 };

struct event_truth {
    double *phi, *rate, *force; /* EVENT_NODES rows of n values */
    double *acc;                /* n values */
    void *work;                 /* pend_dynamics_at_bytes of scratch */
};

/* A step, and the memory for series of all arms. */
struct event_step {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    /* The owner of the series. NULL as in an ensemble: then coefficient j of arm k is at [(j n + k)
     * lanes] of rate and force, and the angle of arm k at [k lanes] of phi. */
    const struct pend_jets *jets;
    int lanes;                       /* distance between two arms in those arrays; 1 with jets */
    const double *rate, *force;      /* series in powers of t / unit, as those of the jets */
    const double *share;             /* 1 / (j + 1) of order j */
    const double *phi, *phi_low;     /* rad, at the start of the step, as sums of two doubles */
    const double *turns, *turns_low; /* rad, whole turns to add to the angles of the motion; NULL =
                                      * 0 */
    int order;                       /* order of `rate`, which is one more than that of `force` */
    double unit;                     /* s, unit of the series */
    double time, length; /* s: start of the step in the time of the drives; length of the step */
    int degree;          /* degree of positions and energies, at least as high as that of angles */
    double *room;        /* pend_event_series_room numbers, for energies; NULL if not needed */
    const struct event_truth *truth; /* forces at the nodes by pend_event_series_truth; NULL = use
                                      * the series */
};

/** Returns the degree of positions and energies over a step whose angles are known to `order`. It
 * is higher, because positions and energies are functions of the angles. O(1). */
int pend_event_series_degree(int order);

/** Returns the last step of a stepper of the Taylor method, without time, length and room. O(1). */
struct event_step pend_event_series_step(const struct pend_series *series,
                                         const struct pend_tree *tree,
                                         const struct pend_loads *loads);

/** Returns how many numbers the energies of n arms need. */
size_t pend_event_series_room(int n);

/** Computes the angle of stored arm k, rad, or the position of a cart, m: coefficients 0 .. degree;
 * higher ones are 0. O(order). */
void pend_event_series_phi(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Computes the rate of arm k, rad/s. */
void pend_event_series_rate(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Returns the bytes of memory, a multiple of 64, for the forces at a step's nodes. The second
 * function lays them out. */
size_t pend_event_truth_bytes(const struct pend_tree *tree, const struct pend_loads *loads);
void pend_event_truth_place(struct event_truth *truth, const struct pend_tree *tree, void *memory);

/** Computes the forces at the nodes of a step whose `truth` is not set yet. O(EVENT_NODES n
 * order). */
void pend_event_series_truth(const struct event_step *step, const struct event_truth *truth);

/** Computes the compression force of arm k, N, after pend_jets_forces. If the step has forces at
 * nodes, their difference from the series is added, as a polynomial through the nodes. */
void pend_event_series_force(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Computes the position of the tip of arm k, m. O(depth order^2). */
void pend_event_series_tip(const struct event_step *step, int k, double x[EVENT_TERMS],
                           double y[EVENT_TERMS]);

/** Computes the squared distance of two tips, m^2. O(depth order^2). */
void pend_event_series_square(const struct event_step *step, int k, int other,
                              double out[EVENT_TERMS]);

/** Computes the kinetic and potential energy, J; step->room must be set. O(n order^2). */
void pend_event_series_energy(const struct event_step *step, double kinetic[EVENT_TERMS],
                              double potential[EVENT_TERMS]);
