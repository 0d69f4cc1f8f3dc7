/* The members of an ensemble: their starts, the requested quantities, and their outcomes.
 * Leaves to others: the computation (ensemble).
 * Invariant: arrays of one value per arm are in the tree's stored order. */
#pragma once

#include "core/base/isa.h"
#include "core/integrate/events/event.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* The start of a member; arrays of n values. Before fetch is called, they contain the tree's own
 * lengths and masses, the problem's loads, and zeros. */
struct pend_member {
    double *phi, *rate;      /* rad, rad/s */
    double *length, *mass;   /* m, kg, finite and > 0; a mass may be 0 if terms add inertia */
    struct pend_loads loads; /* gravity and other loads; its terms are those of the problem */
    double *value;           /* values of the terms of this member, loads.terms->count; loads.value
                              * points to them; NULL without terms */
    double start;            /* s, the start in the time of the drives; 0 without drives */
    double *phi_low;         /* rad, low-order part of phi; NULL if not needed */
};

/**
 * Returns the tree of a member, which borrows all its arrays. Do not free it. It is valid as long
 * as the arrays of the member, and the tree whose shape it has, exist.
 *
 * subtree  out, n values, kg, stored order.
 *
 * The tree satisfies its invariants if the member's lengths and masses are in their ranges. O(n),
 * no allocation.
 */
struct pend_tree pend_member_tree(const struct pend_tree *shape, const struct pend_member *member,
                                  double subtree[]);

enum pend_stop { PEND_STOP_TIME, PEND_STOP_BOUND, PEND_STOP_EVENT, PEND_STOP_FAILED };

/* When a member ends. With a bound: at the end of the time, at the first crossing of any arm, or
 * after the step in which the last arm that has the energy to cross has crossed. With conditions:
 * at the end of the time, or after the step in which the last condition is complete. */
enum pend_until { PEND_UNTIL_TIME, PEND_UNTIL_FIRST, PEND_UNTIL_ALL, PEND_UNTIL_TOLD };

/* Optional quantities besides the end and the crossings; each takes some time. */
enum pend_observe {
    PEND_OBSERVE_EXTREMES = 1, /* the largest and smallest force of each arm */
    PEND_OBSERVE_SIGNS = 2,    /* the instant at which the force of each arm first changes sign */
    PEND_OBSERVE_ENERGY = 4,   /* the drift of the energy */
    PEND_OBSERVE_LYAPUNOV = 8  /* the growth of the distance to a neighbour; twice the work */
};

/* Extremes of each arm's force, N, compression positive, over the motion, not only at samples. */
struct pend_force_range {
    const double *most, *most_time, *least, *least_time; /* forces, N; their times, s */
};

/* The outcome of a member; arrays of n values, valid only during the call. */
struct pend_outcome {
    enum pend_stop stop;
    enum pend_status status;  /* PEND_OK, or the failure: PEND_NOT_FINITE, PEND_STEP_TOO_SMALL,
                               * PEND_TOO_MANY_STEPS */
    double time;              /* s, time at which the member ended */
    int arm;                  /* stored number of the arm that crossed its bound first; -1 = none */
    double first;             /* s, time of that crossing; NaN = never */
    const double *phi, *rate; /* state at `time`; at the start if not integrated (`spare`) */
    const double *phi_low;    /* rad, low-order part of phi; NULL if unknown */
    const double *first_crossing;  /* s, first crossing of each arm; NaN = never; may be NULL */
    const long *crossings;         /* number of crossings of each arm; NULL without a bound */
    struct pend_force_range force; /* pointers are NULL if not requested */
    const double *sign_change;     /* s, time at which each arm's force first changes sign; NaN =
                                    * never; NULL = not requested */
    double energy_drift; /* |E - E(start)| at the end over pend_kinematics_energy_scale. For a real
                          * pendulum, the work of drives and the heat of friction are subtracted,
                          * and the scale includes them. */
    double horizon;  /* s, the time up to which the member keeps the problem's accuracy; equal to
                      * `time` if it never loses it; NaN if the problem has no accuracy */
    double settled;  /* s, the time from which on `settle` holds; NaN = it does not hold in the last
                      * tenth of the time */
    double lyapunov; /* 1/s, log of a neighbour's growth divided by the time; NaN for time 0 */
    long steps;
};

/** Fills in the start of member number i; a non-zero return value ends the run as cancelled. */
typedef int pend_fetch_fn(void *context, long i, struct pend_member *member);
/** Receives the outcome of member number i, in the order in which members end; a non-zero return
 * value ends the run as cancelled. */
typedef int pend_deliver_fn(void *context, long i, const struct pend_outcome *outcome);
/** Receives `count` rows of n values of member number i, at the instants from `first` on. theta is
 * phi + pi/2, rad; for a small swing it has more correct digits than phi. It is undefined for a
 * cart, whose position is phi. */
typedef void pend_rows_fn(void *context, long i, long first, int count, const double phi[],
                          const double rate[], const double force[], const double theta[]);

/** Receives a passage of a condition of member number i, and the state at its instant, n values
 * each. Passages arrive in the order of time, before the member's outcome. */
typedef void pend_hit_fn(void *context, long i, const struct pend_hit *hit, const double phi[],
                         const double rate[]);

struct pend_ensemble_problem {
    const struct pend_tree *tree;
    struct pend_loads loads; /* gravity and other loads */
    double duration;         /* s, either sign */
    double rtol, atol;       /* tolerances, as for the taylor method */
    double accuracy;         /* requested accuracy, for horizons (horizon.h), > 0; 0 = none */
    /* rad, > 0: records when theta = phi + pi/2 of an arm, not a cart, crosses bound + 2 i bound
     * for an integer i. A bound of pi finds flips. Touching the bound inside a step counts, but not
     * a start on it. 0 = none. */
    double bound;
    double settle; /* rad, > 0: records the time from which on pend_control_near holds at all
                    * samples of the controllers; 0 = not requested */
    enum pend_until until;
    int spare; /* non-zero: the final state is not needed. An ideal member without the energy for
                * any arm to reach its bound is delivered at once, with `time` equal to the duration
                * and no steps. */
    unsigned observe;    /* flags of enum pend_observe */
    const double *times; /* s, instants of the rows, within the duration and in its direction */
    long times_count;    /* 0 = no rows */
    int events;          /* number of conditions, with until PEND_UNTIL_TIME or _TOLD; 0 = none */
    const struct pend_event *event; /* must outlive the ensemble; `stop` ends the member */
    long step_cap;                  /* largest number of steps of a member, 0 = no limit */
    pend_fetch_fn *fetch;
    pend_deliver_fn *deliver;
    pend_rows_fn *rows; /* may be NULL if times_count is 0 */
    pend_hit_fn *hit;   /* may be NULL without conditions */
    void *context;
};
