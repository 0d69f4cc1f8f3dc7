/* One step of several members of an ensemble at once, one member per lane, by instruction set.
 * Leaves to others: which member is in which lane, and the delivery of its outcome (ensemble).
 * Invariant: no lane's result depends on another lane, except within a pair of lanes. */
#pragma once

#include <stddef.h>

#include "core/base/isa.h"
#include "core/tree/terms.h"

/* The value of arm k in lane i is array[k * width + i]; with one value per lane it is array[i]. All
 * arrays are aligned to 64. */
struct ensemble_state {
    double *phi, *phi_low, *rate, *rate_low; /* angles, rad, and rates, rad/s: sums of two
                                              * doubles */
    double *time;                            /* s, one value per lane */
    double *gain; /* J, one value per lane: work of drives minus heat of friction, if requested */
};

/* Sets of lanes, bit i for lane i. */
typedef unsigned char ensemble_set;

/* Horizons of the members, computed as in horizon.h for all lanes at once. Each array has one value
 * per lane, or one value per arm and lane. */
struct ensemble_doubt {
    double grade;                /* ratio of an error to the allowed one, per error; 0 = no
                                  * horizons */
    double *phi, *rate;          /* the errors, rad and rad/s, of each arm */
    double *fastest, *strongest; /* largest rate, rad/s, and largest force, N, so far */
    double *time, *ratio; /* the recorded instants, s, and the largest ratio of an error to the
                           * allowed one at each */
    double *held;         /* s, the instant up to which the accuracy holds; ENSEMBLE_HELD until it
                           * is lost */
    int order;            /* order of the errors' series during a step */
    double *series;       /* series of the errors during a step */
    double *limit;        /* ensemble_limits numbers per lane, for series that do not converge */
};

/** Returns how many numbers per lane the limits of the errors' series of n arms need. */
static inline size_t ensemble_limits(int n, int order) {
    return 4 * (size_t)n * (size_t)(order + 1);
}

/* s, later than every time */
#define ENSEMBLE_HELD 1e301

/* Additional orders of the series whose coefficients are computed if horizons are requested. */
enum { ENSEMBLE_DOUBT_BEYOND = 1 };

struct ensemble_lanes {
    int n, order, width;
    int known; /* order of the series that is computed, at least `order` */
    struct ensemble_doubt doubt;
    int paired; /* lanes 2 j and 2 j + 1 take the same step */
    const int *parent, *end;
    double log_rtol, log_atol; /* binary logarithms */
    double bound; /* rad; searches for crossings of theta = bound + 2 i bound; 0 = none */
    int extremes,
        signs;  /* non-zero to search for new extremes of forces, and for changes of their sign */
    int forces; /* non-zero if forces are needed at other instants than the start of a step */
    struct ensemble_state from, to; /* start and end of the step */
    double *len, *inv_len, *mass;   /* properties of each arm */
    double *gravity, *unit, *stop;  /* one value per lane; unit and stop - time have the same
                                     * sign */
    double *start;                  /* s, one value per lane: time 0 in the time of the drives */
    const struct pend_terms *terms; /* terms of real pendulums; NULL = ideal pendulums */
    double *value;                  /* values of the terms: number j of lane i at value[j * width +
                                     * i] */
    double *power; /* out: coefficient j of the step's energy gain per unit of x, divided by j + 1,
                    * J, at power[j * width + lane]; NULL if not needed */
    double *step;  /* out: length of the step in units */
    double *cell;  /* the index i of the cell that contains theta of each arm */
    double *force_max, *force_min;    /* N, extremes of each arm's force so far */
    ensemble_set *near, *peak, *turn; /* out, one set of lanes per arm: the step may leave the cell;
                                       * the force may exceed its extremes; the force may be zero */
    double *series; /* rate, force, turn_re, turn_im, orders 0 .. order + 1, then scratch */
    double *share;  /* 1 / (j + 1) of order j */
};

enum { ENSEMBLE_WIDTH_MAX = 8, ENSEMBLE_INSTANTS = 8, ENSEMBLE_ORDER_MAX = 32 };

/* Lanes that need the caller's attention. */
struct ensemble_attention {
    ensemble_set done;  /* stop is reached */
    ensemble_set bad;   /* a value is not finite, or the time does not advance */
    ensemble_set near;  /* an arm may have left its cell */
    ensemble_set force; /* the force of an arm may have exceeded an extreme or crossed zero */
};

/* Values inside a step: instant i of arm k at [k * ENSEMBLE_INSTANTS + i]; force may be NULL. */
struct ensemble_values {
    double *phi, *rate, *force; /* rad, rad/s, N */
};

struct ensemble_kernel {
    int width;
    /** Returns the number of doubles that `series` needs; terms: NULL for ideal pendulums. */
    size_t (*series_count)(const struct pend_terms *terms, int n, int order);
    /** Prepares `series`, once, after all other arrays are set. */
    void (*prepare)(struct ensemble_lanes *lanes);
    /** Returns the start of the series of the forces; those of the rates begin at `series`. */
    const double *(*force)(const struct ensemble_lanes *lanes);
    /** Takes one step in every lane, which never goes beyond `stop`. */
    void (*step)(struct ensemble_lanes *lanes, struct ensemble_attention *attention);
    /**
     * Computes the values of one lane at ENSEMBLE_INSTANTS instants x inside its last step, in
     * units; to be called before `from` and `to` are swapped.
     *
     * unit  s, unit of the last step.
     */
    void (*values)(const struct ensemble_lanes *lanes, int lane, double unit, const double x[],
                   const struct ensemble_values *to);
};

PEND_ISA_EACH(struct ensemble_kernel, pend_kernel_ensemble);
