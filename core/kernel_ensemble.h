/* One step of several members of an ensemble at once, one member a lane, by instruction set.
 * Leaves to others: which member is in which lane, and what becomes of it (ensemble).
 * Invariant: no lane's result depends on another lane. */
#ifndef PEND_KERNEL_ENSEMBLE_H
#define PEND_KERNEL_ENSEMBLE_H

#include <stddef.h>

/* Values of arm k in lane i are array[k * width + i]; one value a lane: array[i]. All arrays are aligned to 64. */
struct ensemble_state {
    double *phi, *phi_low, *rate, *rate_low; /* angles, rad, and rates, rad/s, as sums of two */
    double *time;                            /* s, one value a lane */
};

struct ensemble_lanes {
    int n, order, width;
    const int *parent, *end;
    double log_rtol, log_atol;      /* binary logarithms */
    double bound;                   /* rad; crossings of theta = bound + 2 i bound are looked for; 0 = none */
    struct ensemble_state from, to; /* start and end of the step */
    double *len, *inv_len, *mass;   /* an arm's own */
    double *gravity, *unit, *stop;  /* one value a lane; unit and stop - time have one sign */
    double *step;                   /* out: the step in units */
    double *cell;                   /* the number i of the stretch that theta of an arm is in */
    double *near;                   /* out, an arm's own: 0 where the step surely stays in the cell */
    double *series;                 /* rate, force, turn_re, turn_im, orders 0 .. order + 1, then scratch */
    double *share;                  /* 1 / (j + 1) of order j */
};

enum { ENSEMBLE_WIDTH_MAX = 8, ENSEMBLE_DONE = 1, ENSEMBLE_BAD = 2, ENSEMBLE_NEAR = 4 };

struct ensemble_kernel {
    int width;
    /** Doubles that `series` needs. */
    size_t (*series_count)(int n, int order);
    /**
     * Takes one step in every lane, never beyond stop.
     *
     * attention  out, width values: ENSEMBLE_DONE where stop is reached, ENSEMBLE_BAD where a number is not finite or
     *            time stands still, ENSEMBLE_NEAR where some arm may have left its cell.
     * Returns whether any lane wants attention.
     */
    int (*step)(struct ensemble_lanes *lanes, unsigned char attention[]);
};

extern const struct ensemble_kernel pend_kernel_ensemble_base;
#ifdef __x86_64__
extern const struct ensemble_kernel pend_kernel_ensemble_avx2, pend_kernel_ensemble_avx512;
#endif

#endif
