/* The type `arms`, in which the general kernel computes several arms at once, or one arm if a
 * number is already a vector. Its functions besides arithmetic: a bound, the sign, the larger of
 * two values, the square root, the hyperbolic tangent and its distance to 1.
 * Leaves to others: arithmetic (number), drives (bodies_number).
 * Invariant: an arm's result does not depend on other arms, nor on the width of vectors. */
#pragma once

#include <math.h>

#include "core/simd/number.h"

/* a number is one double, so a vector holds several arms */
#if defined NUMBER_VEC && NUMBER_VEC == 1
enum { BODIES_ARMS = WIDE };
typedef wide arms;
#define arms_of wide_of
#define arms_all wide_of
#define arms_fma wide_fma
#define arms_get wide_load
VEC_INLINE arms arms_add(arms x, arms y) { return x + y; }
VEC_INLINE arms arms_sub(arms x, arms y) { return x - y; }
VEC_INLINE arms arms_mul(arms x, arms y) { return x * y; }
VEC_INLINE arms arms_div(arms x, arms y) { return x / y; }
VEC_INLINE arms arms_neg(arms x) { return -x; }
VEC_INLINE void arms_put(num *at, arms x) { memcpy(at, &x, sizeof x); }
#else
enum { BODIES_ARMS = 1 };
typedef num arms;
#define arms_of num_of
#define arms_fma num_fma
#define arms_add num_add
#define arms_sub num_sub
#define arms_mul num_mul
#define arms_div num_div
#define arms_neg num_neg
VEC_INLINE arms arms_all(num x) { return x; }
VEC_INLINE arms arms_get(const num *at) { return *at; }
VEC_INLINE void arms_put(num *at, arms x) { *at = x; }
#endif

#ifdef NUMBER_VEC

#if NUMBER_VEC == 1
enum { ARMS_LANES = WIDE };
#define ARMS_(name) WIDE_(name)
#else
enum { ARMS_LANES = NUMBER_VEC };
#define ARMS_(name) NUM_(name)
#endif

static inline arms arms_limit(arms x, double bound) {
    return ARMS_(min)(ARMS_(max)(x, arms_of(-bound)), arms_of(bound));
}

static inline arms arms_most(arms x, arms y) { return ARMS_(max)(x, y); }

static inline arms arms_sign(arms x) {
    for (int i = 0; i < ARMS_LANES; i++) x[i] = copysign(1, x[i]);
    return x;
}

static inline arms arms_root(arms x) {
    for (int i = 0; i < ARMS_LANES; i++) x[i] = sqrt(x[i]);
    return x;
}

#elif defined NUMBER_TANGENT

static inline arms arms_limit(arms x, double bound) {
    double value = x.value;
    return fabs(value) <= bound ? x : num_of(copysign(bound, value));
}

static inline arms arms_most(arms x, arms y) { return x.value >= y.value ? x : y; }

static inline arms arms_sign(arms x) { return num_of(copysign(1, x.value)); }

static inline arms arms_root(arms x) {
    double root = sqrt(x.value);
    return tangent_chain(x, root, 0.5 / root);
}

#elif defined NUMBER_DOUBLE_DOUBLE

static inline arms arms_limit(arms x, double bound) {
    for (int i = 0; i < KERNEL_WIDTH; i++) {
        if (x.high[i] > bound) x.high[i] = bound, x.low[i] = 0;
        if (x.high[i] < -bound) x.high[i] = -bound, x.low[i] = 0;
    }
    return x;
}

static inline arms arms_most(arms x, arms y) {
    for (int i = 0; i < KERNEL_WIDTH; i++)
        if (y.high[i] > x.high[i]) x.high[i] = y.high[i], x.low[i] = y.low[i];
    return x;
}

static inline arms arms_sign(arms x) {
    for (int i = 0; i < KERNEL_WIDTH; i++) x.high[i] = copysign(1, x.high[i]), x.low[i] = 0;
    return x;
}

static inline num arms_root_near(num x) {
    num root = num_of(0);
    for (int i = 0; i < KERNEL_WIDTH; i++) root.high[i] = sqrt(x.high[i]);
    return root;
}

#endif

#if defined NUMBER_VEC || defined NUMBER_TANGENT
enum { ARMS_TANH_DEPTH = 9 };
#else
/** Returns the square root of a number above 0: two Newton steps from the root of a double. */
static inline arms arms_root(arms x) {
    num r = arms_root_near(x);
    for (int i = 0; i < 3; i++) r = num_mul(num_of(0.5), num_add(r, num_div(x, r)));
    return r;
}

enum { ARMS_TANH_DEPTH = 16 };
#endif

/* for larger x, 1 / (e^2x + 1) is negligible; up to here e^2x can be squared without overflow */
static const double arms_tanh_bound = 300;

/**
 * tanh x = 1 - 2 w and w = 1 / (e^2x + 1), of x >= 0, each to its own last digits.
 *
 * e^2x - 1 of a 4096th of x follows from the continued fraction of tanh, and is doubled twelve
 * times, u -> u (2 + u). While u is below 1 this keeps its relative accuracy; each doubling after
 * that doubles the relative error of w, which is small by then.
 */
static inline arms arms_tanh(arms x, arms *w) {
    enum { DOUBLINGS = 12 };
    arms t = arms_mul(arms_limit(x, arms_tanh_bound), arms_of(1.0 / (1 << DOUBLINGS)));
    arms z = arms_mul(t, t), f = arms_of(2 * ARMS_TANH_DEPTH + 1), two = arms_of(2);
    for (int j = ARMS_TANH_DEPTH - 1; j >= 0; j--) f = arms_add(arms_of(2 * j + 1), arms_div(z, f));
    t = arms_div(t, f);
    arms u = arms_div(arms_add(t, t), arms_sub(arms_of(1), t));
    for (int i = 0; i < DOUBLINGS; i++) u = arms_mul(u, arms_add(two, u));
    *w = arms_div(arms_of(1), arms_add(two, u));
    return arms_div(u, arms_add(two, u));
}
