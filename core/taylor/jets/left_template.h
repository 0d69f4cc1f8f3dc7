/* The terms of a power series that a step neglects: all beyond its order.
 * Leaves to others: the total error (horizon), the series (kernel_jets, which includes this).
 * Invariant: sums over arms use eight lanes in every instruction set. */
#pragma once

/* sums of products in the normal equations: C is a term, A and B the two terms before it */
enum { LEFT_AA, LEFT_AB, LEFT_BB, LEFT_AC, LEFT_BC, LEFT_SUMS, LEFT_PARTS = 8 / WIDE };

struct left_sums {
    wide sum[LEFT_SUMS][LEFT_PARTS];
};

/* the last JETS_FITTED terms of the rates at x, for the arms of one vector */
VEC_INLINE void left_terms(const struct jets_system *s, const struct jets_left *left, int a,
                           int arms, wide last[]) {
    const double *from = s->rate + jets_row(s, a) + (size_t)left->from * s->stride;
    double power = left->power;
    for (int i = 0; i < JETS_FITTED; i++, power *= left->x)
        last[i] = kernel_rates(from + (size_t)i * s->stride, arms) * power;
}

/* the sum over the lanes of the first `arms` arms */
VEC_INLINE double left_total(const wide sum[], int arms) {
    double total = 0;
    for (int i = 0; i < arms; i++) total += sum[i / WIDE][i % WIDE];
    return total;
}

/* The recurrence of the last terms of a series. All arms share the nearest pair of singularities in
 * the complex plane, so that a term is `one` times the term before it plus `two` times the term
 * before that. A least-squares fit over the last terms of all arms gives both factors; terms
 * include their power of x. */
VEC_INLINE void left_recurrence(const struct jets_system *s, const struct jets_left *left, int arms,
                                double *one, double *two) {
    struct left_sums x;
    for (int i = 0; i < LEFT_SUMS * LEFT_PARTS; i++)
        x.sum[i / LEFT_PARTS][i % LEFT_PARTS] = wide_of(0);
    for (int a = 0; a < s->n; a += WIDE) {
        wide last[JETS_FITTED];
        int part = a % 8 / WIDE;
        left_terms(s, left, a, arms, last);
        for (int i = 2; i < JETS_FITTED; i++) {
            wide p = last[i - 1], q = last[i - 2], r = last[i];
            x.sum[LEFT_AA][part] = wide_fma(p, p, x.sum[LEFT_AA][part]);
            x.sum[LEFT_AB][part] = wide_fma(p, q, x.sum[LEFT_AB][part]);
            x.sum[LEFT_BB][part] = wide_fma(q, q, x.sum[LEFT_BB][part]);
            x.sum[LEFT_AC][part] = wide_fma(p, r, x.sum[LEFT_AC][part]);
            x.sum[LEFT_BC][part] = wide_fma(q, r, x.sum[LEFT_BC][part]);
        }
    }
    double aa = left_total(x.sum[LEFT_AA], arms), ab = left_total(x.sum[LEFT_AB], arms),
           bb = left_total(x.sum[LEFT_BB], arms);
    double ac = left_total(x.sum[LEFT_AC], arms), bc = left_total(x.sum[LEFT_BC], arms),
           d = aa * bb - ab * ab;
    int good = d > 1e-6 * aa * bb;
    *one = good ? (ac * bb - bc * ab) / d : 0;
    *two = good ? (bc * aa - ac * ab) / d : 0;
}

static void kernel_left(const struct jets_system *s, const struct jets_left *left, double rate[],
                        double phi[]) {
    int arms = s->n > 4 ? 8 : s->n > 2 ? 4 : 2;
    double one, two;
    left_recurrence(s, left, arms, &one, &two);
    for (int a = 0; a < s->n; a += WIDE) {
        wide last[JETS_FITTED + JETS_FORETOLD], faster = wide_of(0), turned = wide_of(0);
        left_terms(s, left, a, arms, last);
        for (int i = JETS_FITTED; i < JETS_FITTED + JETS_FORETOLD; i++)
            last[i] = wide_fma(wide_of(two), last[i - 2], one * last[i - 1]);
        for (int i = JETS_FITTED - left->beyond; i < JETS_FITTED + JETS_FORETOLD; i++) {
            faster += last[i];
            turned = wide_fma(last[i], wide_of(s->share[left->from + i]), turned);
        }
        wide_put(rate + a, faster);
        wide_put(phi + a, turned);
    }
}
