/* Functions of one number that the general kernel needs beyond arithmetic, for every kind of
 * number: a bound, the square root, the hyperbolic tangent, and the sine and cosine of a drive.
 * Leaves to others: arithmetic (number).
 * Invariant: a lane's result does not depend on other lanes, nor on the width of vectors. */
#ifndef PEND_BODIES_NUMBER_H
#define PEND_BODIES_NUMBER_H

#include <math.h>

#include "core/simd/number.h"

#if defined NUMBER_VEC && NUMBER_VEC == 1

static inline num num_limit(num x, double bound) { return fmin(fmax(x, -bound), bound); }

static inline num num_root(num x) { return sqrt(x); }

static inline void num_turn(num x, num low, num *sine, num *cosine) {
    lanes2 s, c;
    lanes2_sincos(lanes2_of(x), lanes2_of(low), &s, &c);
    *sine = s[0], *cosine = c[0];
}

#elif defined NUMBER_VEC

static inline num num_limit(num x, double bound) {
    return NUM_(min)(NUM_(max)(x, num_of(-bound)), num_of(bound));
}

static inline num num_root(num x) {
    for (int i = 0; i < NUMBER_VEC; i++) x[i] = sqrt(x[i]);
    return x;
}

static inline void num_turn(num x, num low, num *sine, num *cosine) {
    NUM_(sincos)(x, low, sine, cosine);
}

#elif defined NUMBER_DOUBLE_DOUBLE

static inline num num_limit(num x, double bound) {
    for (int i = 0; i < KERNEL_WIDTH; i++) {
        if (x.high[i] > bound) x.high[i] = bound, x.low[i] = 0;
        if (x.high[i] < -bound) x.high[i] = -bound, x.low[i] = 0;
    }
    return x;
}

static inline num num_root_near(num x) {
    num root = num_of(0);
    for (int i = 0; i < KERNEL_WIDTH; i++) root.high[i] = sqrt(x.high[i]);
    return root;
}

#elif defined NUMBER_QUAD_DOUBLE

static inline num num_limit(num x, double bound) {
    if (x.part[0] > bound) return num_of(bound);
    return x.part[0] < -bound ? num_of(-bound) : x;
}

static inline num num_root_near(num x) { return num_of(sqrt(x.part[0])); }

#elif defined NUMBER_TANGENT

static inline num num_limit(num x, double bound) {
    double value = x.part[0][0];
    return fabs(value) <= bound ? x : num_of(copysign(bound, value));
}

static inline num num_root(num x) {
    double root = sqrt(x.part[0][0]);
    return tangent_chain(x, root, 0.5 / root);
}

/* sine and cosine of x, to whose value `low` is added */
static inline void num_turn(num x, double low, num *sine, num *cosine) {
    lanes2 s, c;
    lanes2_sincos(lanes2_of(x.part[0][0]), lanes2_of(low), &s, &c);
    *sine = tangent_chain(x, s[0], c[0]);
    *cosine = tangent_chain(x, c[0], -s[0]);
}

#endif

#ifdef NUMBER_TANGENT
typedef double num_plain;
#define num_plain_of(x) (x)
#elif defined NUMBER_VEC
typedef num num_plain;
#define num_plain_of num_of
#endif

#if defined NUMBER_VEC || defined NUMBER_TANGENT
/* x y as a sum of two, by Dekker's and Veltkamp's splitting: the same in every instruction set */
static inline num_plain num_product(num_plain x, num_plain y, num_plain *low) {
    num_plain big = num_plain_of(0x1p27 + 1), p = x * y, a = big * x, b = big * y;
    num_plain xh = a - (a - x), xl = x - xh, yh = b - (b - y), yl = y - yh;
    *low = ((xh * yh - p) + xh * yl + xl * yh) + xl * yl;
    return p;
}

enum { NUM_TANH_DEPTH = 9 };
static const double num_tanh_bound = 20;
#endif

#ifdef NUMBER_VEC
/**
 * Sine and cosine of omega (time + late) + phase, to the last digits of double arithmetic with
 * omega time up to 1e12.
 */
static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    num low, x = num_product(omega, time, &low), sum = x + phase, part = sum - x;
    num rest = (x - (sum - part)) + (phase - part);
    num_turn(sum, rest + (low + omega * late), sine, cosine);
}
#elif defined NUMBER_TANGENT
/* as of doubles; the derivatives are those of omega (time + late) + phase */
static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    double w = omega.part[0][0], t = time.part[0][0], start = phase.part[0][0], low;
    double x = num_product(w, t, &low), sum = x + start, part = sum - x;
    double rest = (x - (sum - part)) + (start - part);
    num angle = num_fma(omega, num_add(time, late), phase);
    num_turn(tangent_with(angle, sum), rest + (low + w * late.part[0][0]), sine, cosine);
}
#else
/** The square root of a number above 0, by two of Newton's steps from that of a double. */
static inline num num_root(num x) {
    num r = num_root_near(x);
    for (int i = 0; i < 3; i++) r = num_mul(num_of(0.5), num_add(r, num_div(x, r)));
    return r;
}

static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    num_sincos(num_fma(omega, num_add(time, late), phase), sine, cosine);
}

enum { NUM_TANH_DEPTH = 16 };
static const double num_tanh_bound = 80;
#endif

/**
 * The hyperbolic tangent: of a 4096th of x by its continued fraction, then doubled twelve times,
 * which adds no more than a rounding each and loses none of the relative accuracy.
 */
static inline num num_tanh(num x) {
    enum { DOUBLINGS = 12 };
    num t = num_mul(num_limit(x, num_tanh_bound), num_of(1.0 / (1 << DOUBLINGS)));
    num z = num_mul(t, t), f = num_of(2 * NUM_TANH_DEPTH + 1);
    for (int j = NUM_TANH_DEPTH - 1; j >= 0; j--) f = num_add(num_of(2 * j + 1), num_div(z, f));
    t = num_div(t, f);
    for (int i = 0; i < DOUBLINGS; i++) t = num_div(num_add(t, t), num_fma(t, t, num_of(1)));
    return t;
}

#endif
