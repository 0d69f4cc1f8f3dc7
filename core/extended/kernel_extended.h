/* One step of several trajectories in numbers of 32 digits at once, one trajectory a lane, by
 * instruction set.
 * Leaves to others: which trajectory is in which lane, and the use of its end (extended).
 * Invariant: no lane's result depends on another lane. */
#ifndef PEND_KERNEL_EXTENDED_H
#define PEND_KERNEL_EXTENDED_H

#include <stddef.h>

#include "core/base/isa.h"
#include "core/tree/terms.h"

/* Values of arm k in lane i are array[k * width + i]; one value a lane: array[i]. All arrays are
 * aligned to 64. */
struct extended_state {
    double *phi, *phi_low, *rate, *rate_low; /* angles, rad, and rates, rad/s, as sums of two */
    double *time;                            /* s, one value a lane; taken as exact */
};

struct extended_lanes {
    int n, order;
    int single;  /* all lanes hold the same trajectory; only kernels of width 4 use this */
    int precise; /* coefficients above this order are so small that one double each is enough */
    const int *parent, *end;
    double log_rtol, log_atol;      /* binary logarithms */
    struct extended_state from, to; /* start and end of the step */
    double *len, *mass;             /* an arm's own */
    double *gravity, *unit, *stop;  /* one value a lane; unit and stop - time have one sign */
    double *start; /* s, one value a lane: what time 0 is in the time of drives; taken as exact */
    const struct pend_terms *terms; /* of real pendulums; NULL = ideal ones */
    double *value;                  /* their numbers: number j of lane i at value[j * width + i] */
    unsigned char *attention;       /* out, one a lane */
    double *share;                  /* 1 / (j + 1) of order j, up to order + 1 */
    double *series; /* rate, force, turn_re, turn_im, orders 0 .. order + 1, then scratch */
};

enum { EXTENDED_WIDTH_MAX = 8, EXTENDED_DONE = 1, EXTENDED_BAD = 2 };

/* Values of all arms at several instants, instant i of arm k at [i * n + k]. phi and rate are
 * required; the others may be NULL. */
struct extended_values {
    double *phi, *phi_low, *rate, *rate_low, *acc, *force;
};

struct extended_kernel {
    int width;
    /** Doubles that `series` needs; terms: NULL for ideal pendulums. */
    size_t (*series_count)(const struct pend_terms *terms, int n, int order);
    /**
     * Takes one step in every lane, never beyond stop.
     *
     * Sets attention to EXTENDED_DONE where stop is reached and to EXTENDED_BAD where a number is
     * not finite or time stands still. Returns non-zero if it set attention in any lane.
     */
    int (*step)(struct extended_lanes *lanes);
    /**
     * The values of one lane at `count` instants t, s, inside the step just taken, before from and
     * to are swapped.
     *
     * unit  s, of that step.
     */
    void (*values)(const struct extended_lanes *lanes, int lane, double unit, int count,
                   const double t[], const struct extended_values *to);
    /**
     * The power of drives, and what friction and the air take, of one lane of a real pendulum as
     * series about the start of the step just taken: `order` coefficients each, J times unit^2,
     * rounded.
     *
     * unit  s, of that step.
     */
    void (*power)(const struct extended_lanes *lanes, int lane, double unit, double work[],
                  double heat[]);
};

PEND_ISA_EACH(struct extended_kernel, pend_kernel_extended);

#endif
