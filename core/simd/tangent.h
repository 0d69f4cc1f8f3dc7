/* Numbers with derivatives: a value and its derivatives with respect to eight parameters, in the
 * lanes of vectors. Sums, products and quotients follow the rules of differentiation.
 * Leaves to others: vectors (vec), functions beyond arithmetic (core/bodies/bodies_number).
 * Invariant: the value has the bits of the same operation on doubles; a derivative affects neither
 * the value nor other derivatives. */
#pragma once

#include "core/simd/vec_isa.h"

enum { TANGENT_PARAMETERS = 8, TANGENT_PARTS = TANGENT_PARAMETERS / KERNEL_WIDTH };

/* The value is stored apart from the derivatives: in their vector it would take the place of one
 * derivative and require a mask in every product. The alignment to a cache line saves 5 to 12 % of
 * the time of all derivatives. */
struct tangent {
    double value;
    _Alignas(64) wide part[TANGENT_PARTS];
};

/** Returns x with another value. */
VEC_INLINE struct tangent tangent_with(struct tangent x, double value) {
    x.value = value;
    return x;
}

/** A number that depends on no parameter. */
VEC_INLINE struct tangent tangent_of(double value) {
    struct tangent x = {.value = value};
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = wide_of(0);
    return x;
}

VEC_INLINE struct tangent tangent_add(struct tangent x, struct tangent y) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] + y.part[p];
    return tangent_with(x, x.value + y.value);
}

VEC_INLINE struct tangent tangent_sub(struct tangent x, struct tangent y) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] - y.part[p];
    return tangent_with(x, x.value - y.value);
}

VEC_INLINE struct tangent tangent_neg(struct tangent x) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = -x.part[p];
    return tangent_with(x, -x.value);
}

VEC_INLINE struct tangent tangent_mul(struct tangent x, struct tangent y) {
    wide a = wide_of(x.value), b = wide_of(y.value);
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = wide_fma(a, y.part[p], b * x.part[p]);
    return tangent_with(x, x.value * y.value);
}

/** x y + z, its value rounded once where the instruction set can. */
VEC_INLINE struct tangent tangent_fma(struct tangent x, struct tangent y, struct tangent z) {
    wide a = wide_of(x.value), b = wide_of(y.value);
    for (int p = 0; p < TANGENT_PARTS; p++)
        z.part[p] = wide_fma(a, y.part[p], wide_fma(b, x.part[p], z.part[p]));
    return tangent_with(z, lanes1_fma(x.value, y.value, z.value));
}

VEC_INLINE struct tangent tangent_div(struct tangent x, struct tangent y) {
    double value = x.value / y.value;
    wide quotient = wide_of(value), inverse = wide_of(1 / y.value);
    for (int p = 0; p < TANGENT_PARTS; p++)
        x.part[p] = (x.part[p] - quotient * y.part[p]) * inverse;
    return tangent_with(x, value);
}

/** A function of x: its value, and the derivatives of x multiplied by its slope. */
VEC_INLINE struct tangent tangent_chain(struct tangent x, double value, double slope) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] * slope;
    return tangent_with(x, value);
}
