/* Quantities of a motion as power series over one step of the Taylor method, of a run or of a
 * member of an ensemble. Leaves to others: the series of angles and forces (jets, kernel_ensemble),
 * what is looked for in them (event_search). Invariant: series are in powers of the part s of the
 * step, 0 .. 1, so that coefficients neither overflow nor vanish.
 */
#pragma once

#include "core/integrate/methods/method.h"
#include "core/taylor/roots.h"

enum { EVENT_TERMS = PEND_ROOTS_DEGREE + 1 };

/* The forces of all arms at the nodes of a step, from the states there: those of a series lose
 * digits where masses are unlike (pend_dynamics_unlike). */
enum { EVENT_NODES = 5 };

struct event_truth {
    double *phi, *rate, *force; /* EVENT_NODES rows of n values */
    double *acc;                /* n values */
    void *work;                 /* pend_dynamics_at_bytes */
};

/* A step and the room for series of all arms. */
struct event_step {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    /* the jets whose series these are; NULL: coefficient j of arm k is at [(j n + k) lanes] of
     * rate and force, and its angle at [k lanes] of phi, as in an ensemble */
    const struct pend_jets *jets;
    int lanes;                       /* 1 with jets */
    const double *rate, *force;      /* series in powers of t / unit, as those of the jets */
    const double *share;             /* 1 / (j + 1) of order j */
    const double *phi, *phi_low;     /* rad, at the beginning, as sums of two */
    const double *turns, *turns_low; /* rad, what the motion's angles are larger by; NULL = 0 */
    int order;                       /* of rate; one more than that of force */
    double unit;                     /* s */
    double time, length; /* s: its beginning in the time of the drives, and how long it is */
    int degree;          /* of places and energies, at least that of an angle */
    double *room; /* of pend_event_series_room numbers, for energies; NULL = none are wanted */
    const struct event_truth *truth; /* of pend_event_series_truth; NULL = the series' forces */
};

/** The degree of places and energies over a step whose angles are known to an order: more, because
 * they are functions of the angles. O(1). */
int pend_event_series_degree(int order);

/** The step of a stepper of the Taylor method, without its time, length and room. O(1). */
struct event_step pend_event_series_step(const struct pend_series *series,
                                         const struct pend_tree *tree,
                                         const struct pend_loads *loads);

/** Numbers of the room that energies of n arms need. */
size_t pend_event_series_room(int n);

/** The angle of stored arm k, rad, or the place of a cart, m: coefficients 0 .. degree; the rest 0.
 * O(order). */
void pend_event_series_phi(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Its rate, rad/s. */
void pend_event_series_rate(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Bytes of memory, a multiple of 64, of the forces at a step's nodes, and their layout in it. */
size_t pend_event_truth_bytes(const struct pend_tree *tree, const struct pend_loads *loads);
void pend_event_truth_place(struct event_truth *truth, const struct pend_tree *tree, void *memory);

/** Computes the forces at the nodes of a step, which has no truth yet. O(EVENT_NODES n order). */
void pend_event_series_truth(const struct event_step *step, const struct event_truth *truth);

/** Its compression force, N; after pend_jets_forces. With a truth what the series misses there is
 * added, a polynomial through its nodes. */
void pend_event_series_force(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** The place of its tip, m. O(depth order^2). */
void pend_event_series_tip(const struct event_step *step, int k, double x[EVENT_TERMS],
                           double y[EVENT_TERMS]);

/** The square of the distance of two tips, m^2. O(depth order^2). */
void pend_event_series_square(const struct event_step *step, int k, int other,
                              double out[EVENT_TERMS]);

/** Kinetic and potential energy, J, with room. O(n order^2). */
void pend_event_series_energy(const struct event_step *step, double kinetic[EVENT_TERMS],
                              double potential[EVENT_TERMS]);
