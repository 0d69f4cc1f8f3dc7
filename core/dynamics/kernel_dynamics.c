#include "core/dynamics/kernel_dynamics.h"

#include "core/dynamics/dynamics_chain_template.h"
#include "core/dynamics/dynamics_template.h"
#include "core/dynamics/dynamics_vec_template.h"
#include "core/dynamics/dynamics_one_template.h"

static int kernel_one(const struct pend_tree *tree, const struct pend_loads *loads,
                      const double phi[], const double rate[], double work[], double acc[],
                      double force[]) {
    if (kernel_is_chain(tree) && kernel_chain(tree, loads, phi, rate, work, acc, force)) return 1;
    return kernel_blocks(tree, loads, phi, rate, work, acc, force);
}

const struct dynamics_kernel KERNEL_NAME(pend_kernel_dynamics_) = {.one = kernel_one,
                                                                   .lanes = kernel_lanes};
