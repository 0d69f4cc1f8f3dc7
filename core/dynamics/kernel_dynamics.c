#include "core/dynamics/kernel_dynamics.h"

#include "core/dynamics/dynamics_one_template.h"
#include "core/dynamics/dynamics_template.h"
#include "core/dynamics/dynamics_vec_template.h"

const struct dynamics_kernel KERNEL_NAME(pend_kernel_dynamics_) = {.one = kernel_blocks,
                                                                   .lanes = kernel_lanes};
