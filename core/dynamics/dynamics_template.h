/* Definitions for the fast forms of the dynamics: widths, the depth of the stack, and the bound
 * above which a form rejects a state because it may lose digits.
 * Leaves to others: the sweeps (dynamics_*_template).
 * Invariant: a power of 2 times all masses, and its inverse, are finite. */
#pragma once

#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics_sizes.h"
#include "core/simd/vec_isa.h"
#include "core/tree/tree.h"

#define fma1 lanes1_fma

/* Depth of the stack: the sizes of the sub-trees on it at least halve from one to the next. */
enum { WAITING = sizeof(int) * CHAR_BIT + 1 };

/* If mass times acceleration exceeds all forces by more than this factor, the state needs the
 * careful form. The error of the fast forms is at most this factor times the rounding error of a
 * double. */
#define LOAD_MOST 256

/* Returns a power of 2 that scales the masses to a total near 1; its inverse is finite. */
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
