/* The members of an ensemble: their starts, the quantities that are looked for, and their outcomes.
 * Leaves to others: the computation (ensemble).
 * Invariant: arrays of one value an arm are in the tree's stored order. */
#ifndef PEND_MEMBER_H
#define PEND_MEMBER_H

#include "core/base/isa.h"
#include "core/integrate/events/event.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* One member's start; arrays of n values, filled with the tree's own lengths, masses, the
 * problem's loads and zeros before fetch is called. */
struct pend_member {
    double *phi, *rate;      /* rad, rad/s */
    double *length, *mass;   /* m, kg, finite and > 0; a mass may be 0 where terms make up for it */
    struct pend_loads loads; /* what acts on the tree; its terms are the problem's */
    double *value;           /* the numbers of its terms, loads.terms->count, each the member's own;
                                loads.value           points to them; NULL without terms */
    double start;            /* s, the member's beginning in the time of its drives; else 0 */
    double *phi_low; /* rad, what rounding to doubles has left of phi; NULL where the caller does
                        not look */
};

/**
 * Returns the tree of a member, which borrows everything: it is not freed, and lasts as long as the
 * arrays of the member and the tree whose shape it has.
 *
 * subtree  out, n values, kg, stored order.
 *
 * It is valid if the member's lengths and masses are in their ranges. O(n), no allocation.
 */
struct pend_tree pend_member_tree(const struct pend_tree *shape, const struct pend_member *member,
                                  double subtree[]);

enum pend_stop { PEND_STOP_TIME, PEND_STOP_BOUND, PEND_STOP_EVENT, PEND_STOP_FAILED };

/* When a member that crosses its bound ends: at the time only, at the first crossing of any arm,
 * or with the step in which the last arm that can cross has done so. And one with conditions: at
 * the time, or with the step in which the last condition has nothing more to tell. */
enum pend_until { PEND_UNTIL_TIME, PEND_UNTIL_FIRST, PEND_UNTIL_ALL, PEND_UNTIL_TOLD };

/* What is computed besides the end and the crossings; each takes some time. */
enum pend_observe {
    PEND_OBSERVE_EXTREMES = 1, /* the largest and smallest force of each arm */
    PEND_OBSERVE_SIGNS = 2,    /* when the force of each arm first changes sign */
    PEND_OBSERVE_ENERGY = 4,   /* how far the energy has drifted */
    PEND_OBSERVE_LYAPUNOV = 8  /* how fast a neighbour leaves; twice the work */
};

/* Forces of each arm, N, compression positive, over the whole motion and not at samples only. */
struct pend_force_range {
    const double *most, *most_time, *least, *least_time; /* s */
};

/* The outcome of a member; arrays of n values, valid during the call only. */
struct pend_outcome {
    enum pend_stop stop;
    enum pend_status status; /* PEND_OK, or why it failed: PEND_NOT_FINITE, PEND_STEP_TOO_SMALL,
                                PEND_TOO_MANY_STEPS */
    double time;             /* s, where it ended */
    int arm;      /* stored number of the arm that crossed its bound first, -1 = none did */
    double first; /* s, when; NaN = never */
    const double *phi, *rate; /* at `time`; of a member that was spared, at the start */
    const double *phi_low; /* rad, what rounding has left of phi, as far as it is known; NULL where
                              it is not */
    const double *first_crossing; /* s, of each arm; NaN = it never crossed; NULL when no bound was
                                     asked for */
    const long *crossings;        /* how often each arm crossed; NULL when no bound was asked for */
    struct pend_force_range force; /* NULLs where not asked for */
    const double *sign_change;     /* s, when the force of each arm first changed sign; NaN = never;
                                      NULL = not asked */
    double energy_drift; /* |E - E(start)| at the end over pend_kinematics_energy_scale; of a real
                            pendulum less what drives gave and friction took, over a scale that
                            includes what was exchanged */
    double horizon;  /* s, up to when the member keeps the problem's accuracy: `time` where it does
                        to the  end; NaN where the problem names none */
    double lyapunov; /* 1/s, logarithm of a neighbour's growth over the time; NaN where time is 0 */
    long steps;
};

/** Fills in the start of member number i; non-zero ends the run as cancelled. */
typedef int pend_fetch_fn(void *context, long i, struct pend_member *member);
/** Receives the outcome of member number i, in the order in which members end; non-zero ends the
 * run as cancelled. */
typedef int pend_deliver_fn(void *context, long i, const struct pend_outcome *outcome);
/**
 * Receives `count` rows of n values, those of the instants from `first` on, of member number i.
 * theta is phi + pi/2, rad, with the digits of a small swing, which phi as a double does not hold;
 * it is of no meaning for a cart, whose place phi is.
 */
typedef void pend_rows_fn(void *context, long i, long first, int count, const double phi[],
                          const double rate[], const double force[], const double theta[]);

/** Receives a passage of a condition of member number i, in the order of time, before the member's
 * outcome, and the state then, n values each. */
typedef void pend_hit_fn(void *context, long i, const struct pend_hit *hit, const double phi[],
                         const double rate[]);

struct pend_ensemble_problem {
    const struct pend_tree *tree;
    struct pend_loads loads; /* what acts on the tree */
    double duration;         /* s, either sign */
    double rtol, atol;       /* as of the taylor method */
    double accuracy;         /* that horizons go by (horizon.h), > 0; 0 = nobody asks */
    /* rad, > 0: theta = phi + pi/2 of an arm, not the place of a cart, crossing bound + 2 i bound,
     * i any integer, is noted: pi for
     * flips, anything for a bound of one's own. Touching it inside a step counts; starting on it
     * does not. 0: not wanted. */
    double bound;
    enum pend_until until;
    int spare; /* non-zero: the end is not wanted, and an ideal member whose energy lets no arm
                  reach its bound is delivered at once, with `time` the duration and no steps */
    unsigned observe;    /* enum pend_observe, or-ed */
    const double *times; /* s, ascending in the direction of the duration, none beyond it: rows are
                            wanted there */
    long times_count;    /* 0 = no rows */
    int events;          /* conditions, with until PEND_UNTIL_TIME or _TOLD; 0 = none */
    const struct pend_event *event; /* must outlive the ensemble; a stop ends a member there */
    long step_cap;                  /* most steps of a member, 0 = no limit */
    pend_fetch_fn *fetch;
    pend_deliver_fn *deliver;
    pend_rows_fn *rows; /* may be NULL where times_count is 0 */
    pend_hit_fn *hit;   /* may be NULL where there are no conditions */
    void *context;
};

#endif
