/* The members of an ensemble: their starts, the requested quantities, and their outcomes.
 * Leaves to others: the computation (ensemble).
 * Invariant: arrays of one value per arm are in the tree's stored order. */
#pragma once

#include "core/base/isa.h"
#include "core/integrate/events/event.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* One member's start; arrays of n values, filled with the tree's own lengths, masses, the
 * problem's loads and zeros before fetch is called. */
struct pend_member {
    double *phi, *rate;      /* rad, rad/s */
    double *length, *mass;   /* m, kg, finite and > 0; a mass may be 0 if terms give the arm an
                              * inertia */
    struct pend_loads loads; /* what acts on the tree; its terms are the problem's */
    double *value;           /* the numbers of its terms, loads.terms->count, each the member's own;
                                loads.value           points to them; NULL without terms */
    double start;            /* s, the start of the member in the time of its drives; else 0 */
    double *phi_low;         /* rad, low-order part of phi; NULL if not needed */
};

/**
 * Returns the tree of a member, which borrows all its arrays. Do not free it; it is valid as long
 * as the arrays of the member and the tree whose shape it has.
 *
 * subtree  out, n values, kg, stored order.
 *
 * It is valid if the member's lengths and masses are in their ranges. O(n), no allocation.
 */
struct pend_tree pend_member_tree(const struct pend_tree *shape, const struct pend_member *member,
                                  double subtree[]);

enum pend_stop { PEND_STOP_TIME, PEND_STOP_BOUND, PEND_STOP_EVENT, PEND_STOP_FAILED };

/* When a member ends. With a bound: at the time only, at the first crossing of any arm, or after
 * the step in which the last arm that can cross has crossed. With conditions: at the time, or after
 * the step in which the last condition is complete. */
enum pend_until { PEND_UNTIL_TIME, PEND_UNTIL_FIRST, PEND_UNTIL_ALL, PEND_UNTIL_TOLD };

/* Quantities besides the end and the crossings; each takes some time. */
enum pend_observe {
    PEND_OBSERVE_EXTREMES = 1, /* the largest and smallest force of each arm */
    PEND_OBSERVE_SIGNS = 2,    /* the instant at which the force of each arm first changes sign */
    PEND_OBSERVE_ENERGY = 4,   /* the drift of the energy */
    PEND_OBSERVE_LYAPUNOV = 8  /* the growth of the distance to a neighbour; twice the work */
};

/* Forces of each arm, N, compression positive, over the whole motion, not only at samples. */
struct pend_force_range {
    const double *most, *most_time, *least, *least_time; /* s */
};

/* The outcome of a member; arrays of n values, valid during the call only. */
struct pend_outcome {
    enum pend_stop stop;
    enum pend_status status;  /* PEND_OK, or why it failed: PEND_NOT_FINITE, PEND_STEP_TOO_SMALL,
                                 PEND_TOO_MANY_STEPS */
    double time;              /* s, its end */
    int arm;                  /* stored number of the arm that crossed its bound first, -1 = none */
    double first;             /* s, of that crossing; NaN = never */
    const double *phi, *rate; /* at `time`; of a member that was spared, at the start */
    const double *phi_low;    /* rad, low-order part of phi; NULL if unknown */
    const double *first_crossing;  /* s, of each arm; NaN = never; NULL without a bound */
    const long *crossings;         /* number of crossings of each arm; NULL without a bound */
    struct pend_force_range force; /* NULLs if not requested */
    const double *sign_change;     /* s, of the first change of sign of each arm's force; NaN =
                                    * never; NULL = not requested */
    double energy_drift; /* |E - E(start)| at the end over pend_kinematics_energy_scale. For a real
                          * pendulum minus the work of drives and plus the heat of friction, over a
                          * scale that includes them. */
    double horizon;  /* s, up to which the member keeps the problem's accuracy: `time` if it does to
                      * the end; NaN if the problem has none */
    double settled;  /* s, since then `settle` holds; NaN = not for the last tenth of the time */
    double lyapunov; /* 1/s, logarithm of a neighbour's growth over the time; NaN if time is 0 */
    long steps;
};

/** Fills in the start of member number i; non-zero ends the run as cancelled. */
typedef int pend_fetch_fn(void *context, long i, struct pend_member *member);
/** Receives the outcome of member number i, in the order in which members end; non-zero ends the
 * run as cancelled. */
typedef int pend_deliver_fn(void *context, long i, const struct pend_outcome *outcome);
/**
 * Receives `count` rows of n values of member number i, at the instants from `first` on. theta is
 * phi + pi/2, rad, with the digits of a small swing that phi as a double cannot hold; it has no
 * meaning for a cart, whose position is phi.
 */
typedef void pend_rows_fn(void *context, long i, long first, int count, const double phi[],
                          const double rate[], const double force[], const double theta[]);

/** Receives a passage of a condition of member number i, in the order of time, before the member's
 * outcome, and the state at it, n values each. */
typedef void pend_hit_fn(void *context, long i, const struct pend_hit *hit, const double phi[],
                         const double rate[]);

struct pend_ensemble_problem {
    const struct pend_tree *tree;
    struct pend_loads loads; /* what acts on the tree */
    double duration;         /* s, either sign */
    double rtol, atol;       /* as of the taylor method */
    double accuracy;         /* accuracy of horizons (horizon.h), > 0; 0 = none */
    /* rad, > 0: notes when theta = phi + pi/2 of an arm, not a cart, crosses bound + 2 i bound for
     * an integer i. pi finds flips. Touching the bound inside a step counts; starting on it does
     * not. 0 = none. */
    double bound;
    double settle; /* rad, > 0: notes from when on pend_control_near holds at all samples of the
                    * controllers; 0 = not asked */
    enum pend_until until;
    int spare; /* non-zero: the end is not needed; an ideal member without the energy for any arm to
                * reach its bound is delivered at once, with `time` the duration and no steps */
    unsigned observe;    /* enum pend_observe, or-ed */
    const double *times; /* s, ascending in the direction of the duration, none beyond it: instants
                          * of rows */
    long times_count;    /* 0 = no rows */
    int events;          /* conditions, with until PEND_UNTIL_TIME or _TOLD; 0 = none */
    const struct pend_event *event; /* must outlive the ensemble; a stop ends a member there */
    long step_cap;                  /* largest number of steps of a member, 0 = no limit */
    pend_fetch_fn *fetch;
    pend_deliver_fn *deliver;
    pend_rows_fn *rows; /* may be NULL if times_count is 0 */
    pend_hit_fn *hit;   /* may be NULL without conditions */
    void *context;
};
