#include "core/modes/modes_kernel.h"

#include <math.h>

#include "core/simd/vec_isa.h"

/* compiled once for every instruction set: see the Makefile */
#define NUMBER_DOUBLE_DOUBLE
#include "core/simd/number.h"

#define wide_pick WIDE_(pick)
#define num_pick NUM_(pick)

/* the iteration ends if the relative correction of the eigenvalue is at most this */
#define FINE_ENOUGH 1e-27

enum { FINE_ROUNDS = 5 };

/* The arrays of the twisted factorization, as in kernel_modes. */
struct fine {
    num *t;     /* pivot of the sweep from below, without the node's own spring */
    num *above; /* pull from above; before that, the sums over earlier siblings; afterwards, in
                 * .high, x - x_parent */
    num *tip;   /* sums over later siblings; then 1 / (u + c); then x */
};

/* t + c, replaced if it nearly vanishes */
VEC_INLINE num fine_pivot(num t, double spring) {
    num d = num_add(t, num_of(spring));
    d.high = wide_pick((wide_mask)(d.high == 0), wide_of(spring * 0x1p-110), d.high);
    return d;
}

/* c t / (t + c) */
VEC_INLINE num fine_pull(num t, double spring) {
    return num_div(num_mul(t, num_of(spring)), fine_pivot(t, spring));
}

/* the sweep from the leaves inwards */
static void fine_up(const struct pend_laplacian *laplacian, num minus_shift, struct fine w) {
    num stack[PEND_LAPLACIAN_STACK], pull = num_of(0);
    int top = 0;
    for (int k = laplacian->n - 1; k >= 0; k--) {
        unsigned turn = laplacian->turn[k];
        if (turn & PEND_TURN_LEAF) {
            stack[top++] = pull;
            pull = num_of(0);
        }
        w.t[k] = num_fma(minus_shift, num_of(laplacian->mass[k]), pull);
        pull = fine_pull(w.t[k], laplacian->spring[k]);
        if (!(turn & PEND_TURN_NEXT)) continue;
        w.tip[k] = stack[--top];
        pull = num_add(pull, stack[top]);
    }
}

/* the sweep from the root outwards; returns in each lane the node with the smallest |gamma| / m,
 * and gamma there */
static wide_mask fine_down(const struct pend_laplacian *laplacian, num minus_shift, struct fine w,
                           wide *gamma) {
    wide least = wide_of(INFINITY), least_mass = wide_of(1);
    wide_mask at = {0};
    w.above[0] = num_of(laplacian->spring[0]);
    for (int k = 0; k < laplacian->n; k++) {
        double spring = laplacian->spring[k], mass = laplacian->mass[k];
        if (k) {
            /* the pull of everything on the parent except this branch */
            int p = laplacian->parent[k];
            num u = num_fma(minus_shift, num_of(laplacian->mass[p]), w.above[p]),
                earlier = num_of(0);
            if (k > p + 1) {
                earlier = w.above[k];
                u = num_add(u, earlier);
            }
            if (laplacian->turn[k] & PEND_TURN_NEXT) {
                u = num_add(u, w.tip[k]);
                w.above[laplacian->end[k]] = num_add(earlier, fine_pull(w.t[k], spring));
            }
            w.tip[k] = num_div(num_of(1), fine_pivot(u, spring));
            w.above[k] = num_mul(num_mul(u, w.tip[k]), num_of(spring));
        }
        wide here = num_add(w.t[k], w.above[k]).high,
             size = wide_pick((wide_mask)(here < 0), -here, here);
        wide_mask less = (wide_mask)(size * least_mass < least * mass);
        least = wide_pick(less, size, least);
        least_mass = wide_pick(less, wide_of(mass), least_mass);
        *gamma = wide_pick(less, here, *gamma);
        at = (less & ((wide_mask){0} + k)) | (~less & at);
    }
    return at;
}

/* computes the shape along the paths from the twists to the pivot */
static void fine_climb(const struct pend_laplacian *laplacian, struct fine w, wide_mask at) {
    num x = num_of(1);
    for (int k = laplacian->n - 1; k >= 0; k--) {
        wide_mask climbed = (at >= k) & (at < laplacian->end[k]);
        wide y = k ? x.high * w.above[k].high / laplacian->spring[k] : x.high;
        num from = k ? num_mul(x, num_mul(w.tip[k], num_of(laplacian->spring[k]))) : x;
        w.above[k].high = wide_pick(climbed, y, w.above[k].high);
        w.tip[k] = num_pick(climbed, x, w.tip[k]);
        x = num_pick(climbed, from, x);
    }
}

/* Continues x from the paths into all other branches, and writes the angles to the lanes' rows.
 * Returns sum m x^2. */
static wide fine_spread(const struct pend_laplacian *laplacian, struct fine w, wide_mask at,
                        double *row[]) {
    wide total = {0};
    for (int k = 0; k < laplacian->n; k++) {
        double spring = laplacian->spring[k];
        wide y = w.above[k].high;
        if (k) {
            wide_mask climbed = (at >= k) & (at < laplacian->end[k]);
            num ratio = num_div(w.tip[laplacian->parent[k]], fine_pivot(w.t[k], spring));
            y = wide_pick(climbed, y, -ratio.high * w.t[k].high);
            w.tip[k] = num_pick(climbed, w.tip[k], num_mul(ratio, num_of(spring)));
        }
        total = wide_fma(laplacian->mass[k] * w.tip[k].high, w.tip[k].high, total);
        for (int i = 0; i < WIDE; i++) row[i][k] = y[i] / laplacian->len[k];
    }
    return total;
}

void KERNEL_NAME(pend_modes_refine_for_)(const struct pend_laplacian *laplacian,
                                         const double value[], int lead, double work[],
                                         double *vector[], double *tip[]);
void KERNEL_NAME(pend_modes_refine_for_)(const struct pend_laplacian *laplacian,
                                         const double value[], int lead, double work[],
                                         double *vector[], double *tip[]) {
    size_t n = (size_t)laplacian->n;
    struct fine w = {(num *)work, (num *)work + n, (num *)work + 2 * n};
    num minus_shift = num_of(0);
    wide square = {0}, scale, gamma = {0};
    for (int i = 0; i < WIDE; i++) minus_shift.high[i] = -value[i];
    for (int round = 0; round < FINE_ROUNDS; round++) {
        int enough = 1;
        fine_up(laplacian, minus_shift, w);
        wide_mask at = fine_down(laplacian, minus_shift, w, &gamma);
        fine_climb(laplacian, w, at);
        square = fine_spread(laplacian, w, at, vector);
        /* Rayleigh quotient: the residual is gamma at the twist, where x is 1, and 0 elsewhere */
        num step = num_of(0);
        step.high = -gamma / square;
        for (int i = 0; i < WIDE; i++)
            enough &= !(fabs(step.high[i]) > FINE_ENOUGH * fabs(value[i]));
        minus_shift = num_add(minus_shift, step);
        if (enough) break;
    }
    for (int i = 0; i < WIDE; i++) {
        scale[i] = copysign(1 / sqrt(square[i]), vector[i][lead]);
        for (size_t k = 0; k < n; k++) vector[i][k] *= scale[i];
        for (size_t k = 0; tip && k < n; k++) tip[i][k] = w.tip[k].high[i] * scale[i];
    }
}
