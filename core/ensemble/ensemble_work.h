/* The workspace of an ensemble on one thread.
 * Leaves to others: the computations in it (ensemble_watch, ensemble_shadow, ensemble).
 * Invariant: one block of memory; lane i belongs to seat i / (1 + paired). */
#pragma once

#include <math.h>

#include "core/ensemble/kernel_ensemble.h"
#include "core/ensemble/member.h"
#include "core/integrate/events/event_search.h"
#include "core/taylor/jets_system.h"

/* maximum number of steps of a member between two samples of its controllers: an unstable member
 * may rotate ever faster */
enum { ENSEMBLE_SAMPLE_STEPS = 200 };

/* The member in a lane. */
struct ensemble_seat {
    long member; /* -1 = the lane is idle */
    long steps, row;
    int arm, open;        /* the arm that crossed first; number of arms that may still cross but
                           * have not */
    double first;         /* s, time of the first crossing of any arm */
    double knot;          /* s, in the time of the drives: the end of the current piece */
    long sampled;         /* number of steps at the last sample of a controller */
    double settled;       /* s, the time since which the controllers see it near their reference;
                           * NaN = not near */
    double energy, scale; /* J: energy at the start, and the scale of the drift */
    int unlike;           /* forces are computed from states, because their series loses their
                           * digits */
    double growth, frequency, shortest; /* log of the neighbour's growth so far; 1/s, the divisor
                                         * that makes rates comparable with angles; m, the divisor
                                         * of a cart's position, the length of the shortest arm */
};

/* The members of a run that are not delivered yet. */
struct ensemble_queue {
    long next, end;
    long left; /* number of members not delivered yet */
    int cancelled;
};

/* The current member if members run one by one. */
struct ensemble_alone {
    const struct pend_method *method; /* NULL = members run side by side in lanes */
    struct pend_tree tree;
    struct pend_events *search; /* search for conditions, which precedes the motion */
    void *stepper;
    int searched;
    double end, reached; /* s, since the member's start: its end; the instant reached */
};

struct pend_ensemble {
    struct pend_ensemble_problem problem;
    const struct ensemble_kernel *kernel;
    struct ensemble_lanes lanes;
    double unit[ENSEMBLE_WIDTH_MAX]; /* s, unit of the last step's series */
    struct ensemble_queue queue;
    struct ensemble_seat seat[ENSEMBLE_WIDTH_MAX];
    double *first_crossing; /* at [lane * n + arm], as in the following arrays */
    long *crossings;
    double *most, *most_time, *least, *least_time, *sign_change;
    double *sense; /* the first sign of each force, 0 = not known yet */
    struct pend_member member;
    double *turns, *turns_low; /* rad, whole turns by which the member's angles exceed the lane's:
                                * [arm width + lane] */
    double *phi, *rate, *phi_low; /* state of an outcome */
    double *subtree;              /* kg, masses of the sub-trees of `member` */
    double *room;                 /* scratch of 4 n numbers for energies */
    /* angles, rates, forces and angles from the vertical at some instants: sorted by rows, and in
     * the order of the kernel */
    double *rows[4], *instants[4];
    struct event_truth truth;   /* memory for forces of states; phi is NULL if they are not
                                 * needed */
    struct event_search search; /* search for the problem's conditions */
    struct event_watch *watch;  /* at [lane * conditions + condition] */
    double *control;            /* memory of the controllers, at [lane * controls + number] */
    size_t controls;
    struct ensemble_alone alone;
};

/**
 * Returns the order of the errors' series, which grows by two for ten times as many swings. The
 * error of a regular motion grows in proportion to t, but a series of too low an order would make
 * it grow exponentially.
 *
 * gravity, duration  m/s^2 and s, of either sign.
 * known              order of the motion's series, the upper limit.
 */
static inline int ensemble_spread(const struct pend_tree *tree, double gravity, double duration,
                                  int known) {
    enum { SWINGS = 100, MORE = 8 };
    double shortest = INFINITY;
    int order = JETS_SPREAD;
    for (int k = 0; k < tree->n; k++) shortest = fmin(shortest, tree->len[k]);
    double swings = fabs(duration) * sqrt(fabs(gravity) / shortest);
    for (; swings > SWINGS && order < JETS_SPREAD + MORE; swings /= 10) order += 2;
    return order < known ? order : known;
}
