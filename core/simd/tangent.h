/* Numbers with derivatives: a value and its derivatives with respect to seven parameters, in eight
 * lanes. Sums, products and quotients follow the rules of differentiation.
 * Leaves to others: vectors (vec), functions beyond arithmetic (core/bodies/bodies_number).
 * Invariant: the value has the bits of the same operation on doubles; no derivative changes
 * another, nor the value. */
#ifndef PEND_TANGENT_H
#define PEND_TANGENT_H

#include "core/simd/vec_isa.h"

enum { TANGENT_LANES = 8, TANGENT_PARAMETERS = 7, TANGENT_PARTS = TANGENT_LANES / KERNEL_WIDTH };

/* The value is the first of the eight numbers. */
struct tangent {
    wide part[TANGENT_PARTS];
};

/** x without its first lane. */
VEC_INLINE wide tangent_rest(wide x) {
    static const long long mask[8] __attribute__((aligned(64))) = {0, -1, -1, -1, -1, -1, -1, -1};
    return (wide)((wide_mask)x & *(const wide_mask *)(const void *)mask);
}

/** Part p without the lane of the value. */
VEC_INLINE wide tangent_part(struct tangent x, int p) {
    return p ? x.part[p] : tangent_rest(x.part[0]);
}

/** x with another value. */
VEC_INLINE struct tangent tangent_with(struct tangent x, double value) {
    x.part[0][0] = value;
    return x;
}

/** A number that depends on no parameter. */
VEC_INLINE struct tangent tangent_of(double value) {
    static const long long mask[8] __attribute__((aligned(64))) = {-1, 0, 0, 0, 0, 0, 0, 0};
    struct tangent x;
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = wide_of(0);
    x.part[0] = (wide)((wide_mask)wide_of(value) & *(const wide_mask *)(const void *)mask);
    return x;
}

VEC_INLINE struct tangent tangent_add(struct tangent x, struct tangent y) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] + y.part[p];
    return x;
}

VEC_INLINE struct tangent tangent_sub(struct tangent x, struct tangent y) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] - y.part[p];
    return x;
}

VEC_INLINE struct tangent tangent_neg(struct tangent x) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = -x.part[p];
    return x;
}

VEC_INLINE struct tangent tangent_mul(struct tangent x, struct tangent y) {
    struct tangent product;
    wide a = wide_of(x.part[0][0]), b = wide_of(y.part[0][0]);
    for (int p = 0; p < TANGENT_PARTS; p++)
        product.part[p] = wide_fma(a, y.part[p], b * tangent_part(x, p));
    return product;
}

/** x y + z, its value rounded once where the instruction set can. */
VEC_INLINE struct tangent tangent_fma(struct tangent x, struct tangent y, struct tangent z) {
    wide a = wide_of(x.part[0][0]), b = wide_of(y.part[0][0]);
    for (int p = 0; p < TANGENT_PARTS; p++)
        z.part[p] = wide_fma(a, y.part[p], wide_fma(b, tangent_part(x, p), z.part[p]));
    return z;
}

VEC_INLINE struct tangent tangent_div(struct tangent x, struct tangent y) {
    double value = x.part[0][0] / y.part[0][0];
    wide quotient = wide_of(value), inverse = wide_of(1 / y.part[0][0]);
    for (int p = 0; p < TANGENT_PARTS; p++)
        x.part[p] = (x.part[p] - quotient * y.part[p]) * inverse;
    return tangent_with(x, value);
}

/** A function of x: its value there, and its slope, by which the derivatives are multiplied. */
VEC_INLINE struct tangent tangent_chain(struct tangent x, double value, double slope) {
    for (int p = 0; p < TANGENT_PARTS; p++) x.part[p] = x.part[p] * slope;
    return tangent_with(x, value);
}

#endif
