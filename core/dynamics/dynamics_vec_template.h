/* Computes phi'' and lambda of several states of one tree, one state per lane: every number of the
 * sweeps is a vector.
 * Leaves to others: single states (dynamics_one_template, with the same operations), memory
 * (dynamics).
 * Invariant: lanes never mix; a state's result has the same bits as if computed alone. */
#pragma once

#include "core/dynamics/dynamics_template.h"

/* Values of an arm: C, Z, w, S; with children also h, r / (m + q), t / (m + q). */
struct lanes_arm {
    wide cosine, sine, spin, eff, held, lean, side;
};

/* Sums over the children of a joint visited so far: S C^2, S Z^2, S C Z, f C, f Z, D and H. */
struct lanes_sums {
    wide p, q, r, b, t, area, lift;
};

/* Values passed from a joint to its children: its acceleration along its arm, minus its
 * acceleration across, and its compliance. */
struct lanes_tip {
    wide radial, yield, lean, side;
};

/* The angles of an arm are computed this many arms ahead, to keep the processor busy during the
 * division of a joint. */
enum { VEC_AHEAD = 2 };

/* Maxima over a sweep: |lambda|, and the factors that bound all S |acceleration|. */
struct lanes_peaks {
    wide force, radial, yield, spin, poison; /* poison: 0 while all values are finite */
};

VEC_INLINE void lanes_prepare(const struct pend_tree *tree, const double phi[], const double rate[],
                              struct lanes_arm *arm, int k) {
    wide x = WIDE_(get)(phi + DYNAMICS_VEC * k), base = WIDE_(of)(0),
         v = WIDE_(get)(rate + DYNAMICS_VEC * k);
    if (k) base = WIDE_(get)(phi + DYNAMICS_VEC * tree->parent[k]);
    WIDE_(between)(x, base, &arm->sine, &arm->cosine);
    arm->spin = tree->len[k] * v * v;
}

VEC_INLINE struct lanes_sums lanes_first(wide S, wide f, wide C, wide Z) {
    wide zero = WIDE_(of)(0);
    return (struct lanes_sums){S * (C * C), S * (Z * Z), S * (C * Z), f * C, f * Z, zero, zero};
}

VEC_INLINE struct lanes_sums lanes_join(const struct lanes_sums *j, wide S, wide f, wide C,
                                        wide Z) {
    wide x = WIDE_(fma)(j->q, C, -(j->r * Z)), y = WIDE_(fma)(j->p, Z, -(j->r * C));
    wide z = WIDE_(fma)(j->b, Z, -(j->t * C));
    return (struct lanes_sums){WIDE_(fma)(S, C * C, j->p),
                               WIDE_(fma)(S, Z * Z, j->q),
                               WIDE_(fma)(S, C * Z, j->r),
                               WIDE_(fma)(f, C, j->b),
                               WIDE_(fma)(f, Z, j->t),
                               WIDE_(fma)(S, WIDE_(fma)(Z, y, C * x), j->area),
                               WIDE_(fma)(S, Z * z, WIDE_(fma)(f, x, j->lift))};
}

/* leaves to root; returns the largest S */
static wide lanes_up(const struct pend_tree *tree, double unit, const double phi[],
                     const double rate[], struct lanes_arm arm[]) {
    struct lanes_sums stack[WAITING], *top = stack, now = {0};
    wide largest = WIDE_(of)(0), zero = largest, scale = WIDE_(of)(unit);
    VEC_PIN(scale); // keeps the compiler from scaling masses before they are copied to all lanes
    for (int k = tree->n - 1; k >= 0 && k >= tree->n - VEC_AHEAD; k--)
        lanes_prepare(tree, phi, rate, &arm[k], k);
    for (int k = tree->n - 1; k >= 0; k--) {
        if (k >= VEC_AHEAD) lanes_prepare(tree, phi, rate, &arm[k - VEC_AHEAD], k - VEC_AHEAD);
        unsigned how = tree->kin[k];
        struct lanes_arm *a = &arm[k];
        wide m = scale * WIDE_(of)(tree->mass[k]), S, f, C = a->cosine, Z = a->sine;
        if (!(how & PEND_KIN_LEAF)) {
            wide inv = 1.0 / (m + now.q), h = WIDE_(fma)(m, now.b, now.lift) * inv;
            S = WIDE_(fma)(WIDE_(fma)(m, now.p, now.area), inv, m);
            f = WIDE_(fma)(-S, a->spin, h);
            a->held = h;
            a->lean = now.r * inv;
            a->side = now.t * inv;
        } else {
            S = m;
            f = WIDE_(fma)(-m, a->spin, zero);
        }
        a->eff = S;
        largest = WIDE_(max)(S, largest);
        if (how & PEND_KIN_LAST)
            now = lanes_first(S, f, C, Z);
        else if (how & PEND_KIN_LEAF)
            now = lanes_join(&now, S, f, C, Z);
        else
            now = lanes_join(top--, S, f, C, Z);
        // the previous arm is neither parent nor sibling
        if (!(how & PEND_KIN_FIRST) && tree->kin[k - 1] & PEND_KIN_LAST) *++top = now;
    }
    return largest;
}

/* the acceleration of a tip along its arm, from that of the arm's base */
VEC_INLINE wide lanes_radial(const struct lanes_tip *base, const struct lanes_arm *a) {
    wide shift = WIDE_(fma)(a->sine, base->side, a->spin);
    return WIDE_(fma)(WIDE_(fma)(-a->sine, base->lean, a->cosine), base->radial, -shift);
}

static void lanes_down(const struct pend_tree *tree, double unit, double gravity,
                       const struct lanes_arm arm[], double acc[], double force[],
                       struct lanes_peaks *peaks) {
    struct lanes_tip stack[WAITING], *top = stack, now;
    wide zero = WIDE_(of)(0), most = zero, radials = zero + fabs(gravity), yields = zero,
         spins = zero, poison = zero;
    double inverse_unit = 1 / unit;
    // gravity is equivalent to a pivot with the acceleration i g
    now = (struct lanes_tip){zero, zero - gravity, zero, zero - gravity};
    for (int k = 0; k < tree->n; k++) {
        unsigned how = tree->kin[k];
        const struct lanes_arm *a = &arm[k];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        wide w = a->spin, radial = lanes_radial(&now, a), tension;
        wide across = WIDE_(fma)(a->cosine, now.yield, a->sine * now.radial);
        if (!(how & PEND_KIN_LEAF)) {
            now =
                (struct lanes_tip){radial, WIDE_(fma)(a->lean, radial, a->side), a->lean, a->side};
            tension = WIDE_(fma)(a->eff, radial, a->held);
            across -= now.yield;
            radials = WIDE_(peak)(radial, radials);
            yields = WIDE_(peak)(now.yield, yields);
            if (how & PEND_KIN_FORK) *++top = now;
        } else {
            tension = a->eff * radial;
        }
        spins = WIDE_(max)(w, spins);
        most = WIDE_(peak)(tension, most);
        tension *= inverse_unit;
        across *= 1 / tree->len[k];
        poison = WIDE_(fma)(across, zero, poison);
        WIDE_(put)(acc + DYNAMICS_VEC * k, across);
        WIDE_(put)(force + DYNAMICS_VEC * k, tension);
    }
    *peaks = (struct lanes_peaks){most, radials, yields, spins, poison};
}

/* the largest S |acceleration of the base|, where each base counts with the largest acceleration on
 * its path from the pivot */
static wide lanes_load(const struct pend_tree *tree, double gravity, const struct lanes_arm arm[]) {
    struct {
        struct lanes_tip tip;
        wide far;
    } stack[WAITING], *top = stack, now;
    wide zero = WIDE_(of)(0), load = zero;
    now.tip = (struct lanes_tip){zero, zero - gravity, zero, zero - gravity};
    now.far = zero + fabs(gravity);
    for (int k = 0; k < tree->n; k++) {
        unsigned how = tree->kin[k];
        const struct lanes_arm *a = &arm[k];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        wide w = a->spin, radial;
        load = WIDE_(max)(a->eff * (now.far + w), load);
        if (how & PEND_KIN_LEAF) continue;
        radial = lanes_radial(&now.tip, a);
        now.tip =
            (struct lanes_tip){radial, WIDE_(fma)(a->lean, radial, a->side), a->lean, a->side};
        now.far = WIDE_(max)(WIDE_(abs)(now.tip.radial) + WIDE_(abs)(now.tip.yield) + w, now.far);
        if (how & PEND_KIN_FORK) *++top = now;
    }
    return load;
}

/* a bit for each lane in which x <= y < infinity and z is 0 */
VEC_INLINE unsigned lanes_kept(wide x, wide y, wide z) {
    unsigned kept = 0;
    for (int i = 0; i < WIDE; i++)
        kept |= x[i] <= y[i] && y[i] < INFINITY && z[i] == 0 ? 1u << i : 0;
    return kept;
}

static unsigned kernel_lanes(const struct pend_tree *tree, const struct pend_loads *loads,
                             const double phi[], const double rate[], double work[], double acc[],
                             double force[]) {
    struct lanes_arm *arm = (struct lanes_arm *)work;
    double gravity = loads->gravity, unit = kernel_unit(tree->subtree_mass[0]);
    unsigned kept = 0, all = (1u << WIDE) - 1;
    for (int i = 0; i < DYNAMICS_VEC; i += WIDE) {
        struct lanes_peaks peaks;
        wide eff = lanes_up(tree, unit, phi + i, rate + i, arm);
        lanes_down(tree, unit, gravity, arm, acc + i, force + i, &peaks);
        // an upper bound of all loads, which usually suffices
        wide most = LOAD_MOST * peaks.force,
             load = eff * (peaks.radial + peaks.yield + peaks.spin + peaks.spin);
        unsigned good = lanes_kept(load, most, peaks.poison);
        if (good != all) good = lanes_kept(lanes_load(tree, gravity, arm), most, peaks.poison);
        kept |= good << i;
    }
    return kept;
}
