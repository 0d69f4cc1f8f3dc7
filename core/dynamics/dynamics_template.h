/* What the quick forms of the dynamics share: widths, the depth of the stack, and the bound above
 * which a form gives a state up because its digits are in doubt.
 * Leaves to others: the sweeps (dynamics_*_template).
 * Invariant: a power of 2 times all masses, and its inverse, are finite. */
#ifndef PEND_DYNAMICS_TEMPLATE_H
#define PEND_DYNAMICS_TEMPLATE_H

#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics_sizes.h"
#include "core/simd/vec_isa.h"
#include "core/tree/tree.h"

#define fma1 lanes1_fma

/* The sizes of the sub-trees that wait halve from one to the next. */
enum { WAITING = sizeof(int) * CHAR_BIT + 1 };

/* Forces that are so many times smaller than masses times accelerations are another form's.
 * Their error is this times that of a double at most. */
#define LOAD_MOST 256

/* Masses times this power of 2 are near 1 in all; its inverse is finite. */
VEC_INLINE double kernel_unit(double mass) {
    unsigned long long bits, exponent;
    memcpy(&bits, &mass, sizeof bits);
    exponent = bits >> 52;
    if (exponent < 23) exponent = 23;
    if (exponent > 2045) exponent = 2045;
    bits = (2046 - exponent) << 52;
    memcpy(&mass, &bits, sizeof bits);
    return mass;
}

#endif
