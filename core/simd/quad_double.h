/* Numbers of about 62 digits: unevaluated sums of four doubles (Hida, Li and Bailey's
 * quad-double arithmetic).
 * Leaves to others: ranges (products below 1e290 in size, above 1e-200 to keep all digits), what
 * is not finite.
 * Invariant: parts fall by 2^-52 or more each; sums and products are within 2^-203 of the larger
 * operand's, for products and quotients the result's, size, in every instruction set. */
#ifndef PEND_QUAD_DOUBLE_H
#define PEND_QUAD_DOUBLE_H

#ifdef __FAST_MATH__
#error "sums of doubles need the rounding of IEEE 754: leave out -ffast-math"
#endif

#include <math.h>

/* keeps a number in a register as it is: without this a compiler could fuse a product into the
 * sums in which it is used */
#if defined(__x86_64__)
#define QUAD_PIN(x) __asm__("" : "+x"(x))
#elif defined(__aarch64__)
#define QUAD_PIN(x) __asm__("" : "+w"(x))
#else
#define QUAD_PIN(x) __asm__("" : "+m"(x))
#endif

typedef struct {
    double part[4];
} quad;

/** x + y with its rounding error (Knuth). */
static inline __attribute__((always_inline)) double quad_total(double x, double y, double *low) {
    double s = x + y, part = s - x;
    *low = (x - (s - part)) + (y - part);
    return s;
}

/** quad_total where |x| >= |y| (Dekker). */
static inline __attribute__((always_inline)) double quad_settle(double x, double y, double *low) {
    double s = x + y;
    *low = y - (s - x);
    return s;
}

/** x y with its rounding error. */
static inline __attribute__((always_inline)) double quad_product(double x, double y, double *low) {
    double p = x * y;
    QUAD_PIN(p);
    *low = fma(x, y, -p);
    return p;
}

/* a + b + c as a sum of three */
static inline __attribute__((always_inline)) void quad_three(double *a, double *b, double *c) {
    double t1, t2, t3;
    t1 = quad_total(*a, *b, &t2);
    *a = quad_total(*c, t1, &t3);
    *b = quad_total(t2, t3, c);
}

/* five parts that overlap, as a number */
static inline __attribute__((always_inline)) quad quad_renormal(double c0, double c1, double c2,
                                                                double c3, double c4) {
    double s0, s1, s2 = 0, s3 = 0;
    s0 = quad_settle(c3, c4, &c4);
    s0 = quad_settle(c2, s0, &c3);
    s0 = quad_settle(c1, s0, &c2);
    c0 = quad_settle(c0, s0, &c1);
    s0 = quad_settle(c0, c1, &s1);
    if (s1 != 0) {
        s1 = quad_settle(s1, c2, &s2);
        if (s2 != 0) {
            s2 = quad_settle(s2, c3, &s3);
            if (s3 != 0)
                s3 += c4;
            else
                s2 = quad_settle(s2, c4, &s3);
        } else {
            s1 = quad_settle(s1, c3, &s2);
            if (s2 != 0)
                s2 = quad_settle(s2, c4, &s3);
            else
                s1 = quad_settle(s1, c4, &s2);
        }
    } else {
        s0 = quad_settle(s0, c2, &s1);
        if (s1 != 0) {
            s1 = quad_settle(s1, c3, &s2);
            if (s2 != 0)
                s2 = quad_settle(s2, c4, &s3);
            else
                s1 = quad_settle(s1, c4, &s2);
        } else {
            s0 = quad_settle(s0, c3, &s1);
            if (s1 != 0)
                s1 = quad_settle(s1, c4, &s2);
            else
                s0 = quad_settle(s0, c4, &s1);
        }
    }
    return (quad){{s0, s1, s2, s3}};
}

static inline __attribute__((always_inline)) quad quad_of(double x) { return (quad){{x, 0, 0, 0}}; }

static inline __attribute__((always_inline)) quad quad_of2(double high, double low) {
    double rest, sum = quad_total(high, low, &rest);
    return (quad){{sum, rest, 0, 0}};
}

static inline __attribute__((always_inline)) quad quad_neg(quad x) {
    return (quad){{-x.part[0], -x.part[1], -x.part[2], -x.part[3]}};
}

static inline __attribute__((always_inline)) quad quad_add(quad a, quad b) {
    double t0, t1, t2, t3, s0 = quad_total(a.part[0], b.part[0], &t0),
                           s1 = quad_total(a.part[1], b.part[1], &t1);
    double s2 = quad_total(a.part[2], b.part[2], &t2), s3 = quad_total(a.part[3], b.part[3], &t3),
           u;
    s1 = quad_total(s1, t0, &t0);
    quad_three(&s2, &t0, &t1);
    // the lowest part needs no rest of its own
    u = quad_total(s3, t0, &t0);
    s3 = quad_total(t2, u, &t2);
    t0 = t0 + t2 + t1 + t3;
    return quad_renormal(s0, s1, s2, s3, t0);
}

static inline __attribute__((always_inline)) quad quad_sub(quad a, quad b) {
    return quad_add(a, quad_neg(b));
}

static inline __attribute__((always_inline)) quad quad_mul(quad x, quad y) {
    const double *a = x.part, *b = y.part;
    double q0, q1, q2, q3, q4, q5, t0, t1;
    double p0 = quad_product(a[0], b[0], &q0), p1 = quad_product(a[0], b[1], &q1);
    double p2 = quad_product(a[1], b[0], &q2), p3 = quad_product(a[0], b[2], &q3);
    double p4 = quad_product(a[1], b[1], &q4), p5 = quad_product(a[2], b[0], &q5);
    quad_three(&p1, &p2, &q0);
    quad_three(&p2, &q1, &q2);
    quad_three(&p3, &p4, &p5);
    // (p2, q1, q2) + (p3, p4, p5)
    double s0 = quad_total(p2, p3, &t0), s1 = quad_total(q1, p4, &t1), s2 = q2 + p5;
    s1 = quad_total(s1, t0, &t0);
    s2 += t0 + t1;
    s1 += a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0] + q0 + q3 + q4 + q5;
    return quad_renormal(p0, p1, s0, s1, s2);
}

static inline __attribute__((always_inline)) quad quad_fma(quad x, quad y, quad z) {
    return quad_add(quad_mul(x, y), z);
}

/** x times a power of two, exact. */
static inline __attribute__((always_inline)) quad quad_scale(quad x, double power) {
    return (quad){{x.part[0] * power, x.part[1] * power, x.part[2] * power, x.part[3] * power}};
}

static inline __attribute__((always_inline)) quad quad_div(quad x, quad y) {
    double q[5];
    for (int i = 0; i < 5; i++) {
        q[i] = x.part[0] / y.part[0];
        x = quad_sub(x, quad_mul(y, quad_of(q[i])));
    }
    return quad_renormal(q[0], q[1], q[2], q[3], q[4]);
}

/** Sine and cosine within 2^-195 of 1 up to |x| = 1e6. */
static inline void quad_sincos(quad x, quad *sine, quad *cosine) {
    enum { TERMS = 18, DOUBLINGS = 5 };
    const quad quarter = {{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110,
                           0x1.4cf98e804177dp-164}};
    double n = rint(x.part[0] * 0x1.45f306dc9c883p-1);
    quad r = quad_scale(quad_sub(x, quad_mul(quarter, quad_of(n))), 1.0 / (1 << DOUBLINGS)),
         z = quad_mul(r, r);
    // sin r, and 1 - cos r, which keeps its digits through the doublings
    quad s = r, v = quad_scale(z, 0.5), term = r, rest = v;
    for (int j = 1; j < TERMS; j++) {
        term = quad_neg(quad_div(quad_mul(term, z), quad_of((2.0 * j) * (2 * j + 1))));
        rest = quad_neg(quad_div(quad_mul(rest, z), quad_of((2.0 * j + 1) * (2 * j + 2))));
        s = quad_add(s, term);
        v = quad_add(v, rest);
    }
    for (int i = 0; i < DOUBLINGS; i++) {
        quad square = quad_mul(s, s);
        s = quad_scale(quad_mul(s, quad_sub(quad_of(1), v)), 2);
        v = quad_scale(square, 2);
    }
    quad c = quad_sub(quad_of(1), v);
    int turn = (int)(n - 4 * floor(n / 4));
    *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? quad_neg(s) : quad_neg(c);
    *cosine = turn == 0 ? c : turn == 1 ? quad_neg(s) : turn == 2 ? quad_neg(c) : s;
}

#endif
