/* The fast forms of the dynamics, for each instruction set.
 * Leaves to others: states for which the fast forms may lose digits (dynamics), memory (dynamics).
 * Invariant: a kernel is called only on a processor that has its instruction set. */
#pragma once

#include "core/dynamics/dynamics_sizes.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct dynamics_kernel {
    /**
     * Computes one state. Parameters as pend_dynamics, but force is never NULL.
     *
     * work  DYNAMICS_VALUES numbers per arm, in whole blocks, aligned to 64.
     *
     * Returns non-zero if the result is accurate; otherwise acc and force are undefined.
     */
    int (*one)(const struct pend_tree *tree, const struct pend_loads *loads, const double phi[],
               const double rate[], double work[], double acc[], double force[]);
    /**
     * Computes DYNAMICS_VEC states; arm k of state i is at DYNAMICS_VEC k + i of each array.
     *
     * work  DYNAMICS_VALUES * DYNAMICS_VEC numbers per arm, aligned to 64.
     *
     * Returns a bit for each state whose result is accurate.
     */
    unsigned (*lanes)(const struct pend_tree *tree, const struct pend_loads *loads,
                      const double phi[], const double rate[], double work[], double acc[],
                      double force[]);
};

extern const struct dynamics_kernel pend_kernel_dynamics_base;
#ifdef __x86_64__
extern const struct dynamics_kernel pend_kernel_dynamics_avx2, pend_kernel_dynamics_avx512;
#endif
