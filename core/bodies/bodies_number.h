/* The sine and cosine of an angle and of a drive, for every kind of number.
 * Leaves to others: arithmetic (number).
 * Invariant: a lane's result does not depend on other lanes, nor on the width of vectors. */
#pragma once

#include "core/simd/number.h"

#if defined NUMBER_VEC && NUMBER_VEC == 1

static inline void num_turn(num x, num low, num *sine, num *cosine) {
    lanes2 s, c;
    lanes2_sincos(lanes2_of(x), lanes2_of(low), &s, &c);
    *sine = s[0], *cosine = c[0];
}

#elif defined NUMBER_VEC

static inline void num_turn(num x, num low, num *sine, num *cosine) {
    NUM_(sincos)(x, low, sine, cosine);
}

#elif defined NUMBER_TANGENT

/* sine and cosine of x + low; `low` is added to the value only */
static inline void num_turn(num x, double low, num *sine, num *cosine) {
    lanes2 s, c;
    lanes2_sincos(lanes2_of(x.value), lanes2_of(low), &s, &c);
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
/* x y as a sum of two numbers, by Dekker's and Veltkamp's splitting, with the same bits in every
 * instruction set */
static inline num_plain num_product(num_plain x, num_plain y, num_plain *low) {
    num_plain big = num_plain_of(0x1p27 + 1), p = x * y, a = big * x, b = big * y;
    num_plain xh = a - (a - x), xl = x - xh, yh = b - (b - y), yl = y - yh;
    *low = ((xh * yh - p) + xh * yl + xl * yh) + xl * yl;
    return p;
}
#endif

#ifdef NUMBER_VEC
/** Computes sine and cosine of omega (time + late) + phase, accurate to the last digit of a double
 * for omega time up to 1e12. */
static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    num low, x = num_product(omega, time, &low), sum = x + phase, part = sum - x;
    num rest = (x - (sum - part)) + (phase - part);
    num_turn(sum, rest + (low + omega * late), sine, cosine);
}
#elif defined NUMBER_TANGENT
/* the same for numbers with derivatives, which are taken with respect to the parameters of the
 * whole argument */
static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    double w = omega.value, t = time.value, start = phase.value, low;
    double x = num_product(w, t, &low), sum = x + start, part = sum - x;
    double rest = (x - (sum - part)) + (start - part);
    num angle = num_fma(omega, num_add(time, late), phase);
    num_turn(tangent_with(angle, sum), rest + (low + w * late.value), sine, cosine);
}
#else
static inline void num_drive(num omega, num time, num late, num phase, num *sine, num *cosine) {
    num_sincos(num_fma(omega, num_add(time, late), phase), sine, cosine);
}
#endif
