/* The series kernels of one tree, by instruction set.
 * Leaves to others: memory, angles (jets).
 * Invariant: an unsupported set is never called. */
#ifndef PEND_KERNEL_JETS_H
#define PEND_KERNEL_JETS_H

#include "core/jets_system.h"

/* Sums of two doubles a value, as phi and phi' are carried from step to step; n values each,
 * padded with zeros to a multiple of 8: whole vectors of arms are read. */
struct jets_state {
    double *phi, *phi_low, *rate, *rate_low;
};

enum { JETS_SIZES = 8 };

/* Where values go; n values an instant, NULL = not wanted. */
struct jets_values {
    double *phi, *rate, *acc, *force;
};

struct jets_kernel {
    /**
     * All orders: rate_0 .. rate_order and force_0 .. force_{order - 1}, in powers of t / unit.
     *
     * system  one tree; trees of up to 8 arms need a stride of 8.
     * order   >= 1.
     */
    void (*orders)(const struct jets_system *system, const struct jets_state *state, double gravity, double unit,
                   int order);
    /**
     * The state x units after `from`, as sums of two doubles.
     */
    void (*advance)(const struct jets_system *system, int order, double x, double unit, const struct jets_state *from,
                    const struct jets_state *to);
    /**
     * Binary logarithms, within 1e-5, of the largest magnitudes among the arms of rate_0 .. rate_3 and
     * rate_{order - 3} .. rate_order; -1023 where all are zero, 1024 or more, or not a number, where one is not finite.
     */
    void (*sizes)(const struct jets_system *system, int order, double log2_of[JETS_SIZES]);
    /**
     * The values x[i] units after `from`, i = 0 .. count - 1, in rows of n. phi and rate are always wanted. A row's
     * bits do not depend on the other rows.
     */
    void (*values)(const struct jets_system *system, int order, const double x[], int count, double unit,
                   const struct jets_state *from, const struct jets_values *values);
};

extern const struct jets_kernel pend_kernel_jets_base;
#ifdef __x86_64__
extern const struct jets_kernel pend_kernel_jets_avx2, pend_kernel_jets_avx512;
#endif

#endif
