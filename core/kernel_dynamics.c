#include "core/kernel_dynamics.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/lanes.h"

/* loops over arms take as many at once as the instruction set holds */
#if defined(__AVX512F__)
enum { WIDE = 8 };
typedef lanes8 wide;
#define WIDE_(name) lanes8_##name
#elif defined(__AVX2__)
enum { WIDE = 4 };
typedef lanes4 wide;
#define WIDE_(name) lanes4_##name
#else
enum { WIDE = 2 };
typedef lanes2 wide;
#define WIDE_(name) lanes2_##name
#endif
#define fma1 lanes1_fma

/* Scratch of a block of arms; the letters are those of core/README.md. */
struct block {
    double cosine[DYNAMICS_BLOCK], sine[DYNAMICS_BLOCK]; /* C, Z: of the angle to the parent */
    double spin[DYNAMICS_BLOCK];                         /* w = l phi'^2 */
    double eff[DYNAMICS_BLOCK], held[DYNAMICS_BLOCK];    /* S, h */
    double lean[DYNAMICS_BLOCK], side[DYNAMICS_BLOCK];   /* r / (m + q), t / (m + q) */
};

/* Sums over the children of a joint that were met so far: S, S Z^2, S C Z, f C, f Z, D and H. */
struct sums {
    double s, q, r, b, t, area, lift;
};

/* what a joint hands to its children: its acceleration and how it yields */
struct tip {
    double radial, tangential, lean, side;
    double far; /* the largest acceleration on the way from the pivot: their rounding errors end up here */
};

/* The sizes of the sub-trees that wait halve from one to the next. */
/* Forces that are so many times smaller than masses times accelerations are another form's. Their error is this times
 * that of a double at most. */
#define LOAD_MOST 256
enum { WAITING = sizeof(int) * CHAR_BIT + 1 };

/* Masses times this power of 2 are near 1 in all; its inverse is finite. */
static double kernel_unit(double mass) {
    unsigned long long bits, exponent;
    memcpy(&bits, &mass, sizeof bits);
    exponent = bits >> 52;
    if (exponent < 23) exponent = 23;
    if (exponent > 2045) exponent = 2045;
    bits = (2046 - exponent) << 52;
    memcpy(&mass, &bits, sizeof bits);
    return mass;
}

LANES_INLINE wide wide_load(const double *from) {
    wide x;
    memcpy(&x, from, sizeof x);
    return x;
}

/* the first `count` of a vector's numbers; the others repeat the last */
LANES_INLINE wide wide_load_some(const double *from, int count) {
    wide x;
    for (int i = 0; i < WIDE; i++) x[i] = from[i < count ? i : count - 1];
    return x;
}

/* angles to the parents and what follows from an arm alone, arms a to a + WIDE of a block */
LANES_INLINE void block_angles(struct block *block, int i, wide x, wide base, wide rate, wide len) {
    // the difference is rounded, and near a half turn its rounding is all that tells two arms from aligned ones
    wide angle = x - base, back = x - angle, low = (x - (angle + back)) + (back - base), sine, cosine;
    WIDE_(sincos)(angle, low, &sine, &cosine);
    WIDE_(put)(block->cosine + i, cosine);
    WIDE_(put)(block->sine + i, sine);
    WIDE_(put)(block->spin + i, len * rate * rate);
    // what stays of a leaf, and of the places behind the last arm
    WIDE_(put)(block->eff + i, WIDE_(of)(0));
    WIDE_(put)(block->held + i, WIDE_(of)(0));
    WIDE_(put)(block->lean + i, WIDE_(of)(0));
    WIDE_(put)(block->side + i, WIDE_(of)(0));
}

static void block_prepare(struct block *block, const struct pend_tree *tree, const double phi[], const double rate[],
                          int begin, int count) {
    double base[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    const int *parent = tree->parent + begin;
    int i = 0;
    if (!begin) base[i++] = 0;
    for (; i < count; i++) base[i] = phi[parent[i]];
    phi += begin, rate += begin;
    const double *len = tree->len + begin;
    for (i = 0; i + WIDE <= count; i += WIDE)
        block_angles(block, i, wide_load(phi + i), WIDE_(get)(base + i), wide_load(rate + i), wide_load(len + i));
    if (i == count) return;
    count -= i;
    block_angles(block, i, wide_load_some(phi + i, count), wide_load_some(base + i, count),
                 wide_load_some(rate + i, count), wide_load_some(len + i, count));
}

/* the sweep from the leaves to the root */
struct climb {
    struct sums now;            /* of the joint whose first child was the last arm */
    struct sums stack[WAITING]; /* joints that wait for more children */
    struct sums *top;
    double unit;
};

LANES_INLINE int block_up(struct block *block, const struct pend_tree *tree, struct climb *climb, int begin,
                          int count) {
    const unsigned char *kin = tree->kin + begin;
    const double *mass = tree->mass + begin;
    struct sums now = climb->now, *top = climb->top;
    double unit = climb->unit;
    for (int i = count - 1; i >= 0; i--) {
        unsigned how = kin[i];
        double m = unit * mass[i], C = block->cosine[i], Z = block->sine[i], S = m, h = 0;
        if (!(how & PEND_KIN_LEAF)) {
            double inv = 1 / (m + now.q), det = fma1(m, m + now.s, now.area);
            h = fma1(m, now.b, now.lift) * inv;
            S = det * inv;
            block->held[i] = h;
            block->lean[i] = now.r * inv;
            block->side[i] = now.t * inv;
        }
        block->eff[i] = S;
        double f = fma1(-S, block->spin[i], h), ZZ = Z * Z, CZ = C * Z;
        if (how & PEND_KIN_LAST) {
            struct sums first = {S, S * ZZ, S * CZ, f * C, f * Z, 0, 0};
            if (how & PEND_KIN_FIRST)
                now = first;
            else
                *++top = first;
        } else {
            double s = top->s, q = top->q, r = top->r, b = top->b, t = top->t;
            double x = fma1(q, C, -r * Z), y = fma1(s - q, Z, -r * C), z = S * fma1(b, Z, -t * C);
            struct sums more = {s + S,
                                fma1(S, ZZ, q),
                                fma1(S, CZ, r),
                                fma1(f, C, b),
                                fma1(f, Z, t),
                                fma1(S, fma1(Z, y, C * x), top->area),
                                fma1(f, x, fma1(Z, z, top->lift))};
            if (how & PEND_KIN_FIRST)
                now = more, top--;
            else
                *top = more;
        }
    }
    climb->now = now, climb->top = top;
    return 1;
}

/* the sweep from the root to the leaves */
struct descent {
    struct tip now, stack[WAITING], *top;
    double inverse_unit;
    wide force, load, poison; /* largest |lambda|, largest S |acceleration of the base|; 0 while all is finite */
};

/* accelerations along the arms, and across them those of their bases */
LANES_INLINE void block_down(struct block *block, const unsigned char kin[], struct descent *descent, int count,
                             double along[], double across[], double far[]) {
    struct tip now = descent->now, *top = descent->top;
    for (int i = 0; i < count; i++) {
        unsigned how = kin[i];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        double C = block->cosine[i], Z = block->sine[i];
        double kappa = fma1(-Z, now.lean, C), shift = fma1(Z, now.side, block->spin[i]);
        double radial = fma1(kappa, now.radial, -shift);
        along[i] = radial;
        far[i] = now.far;
        across[i] = fma1(Z, now.radial, -C * now.tangential);
        if (!(how & PEND_KIN_LEAF)) {
            now.lean = block->lean[i], now.side = block->side[i];
            now.tangential = -fma1(now.lean, radial, now.side);
            now.radial = radial;
            double size = fabs(radial) + fabs(now.tangential) + block->spin[i];
            now.far = size > now.far ? size : now.far;
            if (how & PEND_KIN_FORK) *++top = now;
        }
    }
    descent->now = now, descent->top = top;
}

/* phi'' and lambda of some arms of a block */
LANES_INLINE void block_values(const struct block *block, int i, wide radial, wide across, wide far, wide len,
                               struct descent *descent, wide *acc, wide *force) {
    wide S = WIDE_(get)(block->eff + i);
    wide tension = WIDE_(fma)(S, radial, WIDE_(get)(block->held + i));
    wide tangential = WIDE_(fma)(WIDE_(get)(block->lean + i), radial, WIDE_(get)(block->side + i));
    wide load = S * (far + WIDE_(get)(block->spin + i));
    *acc = (across - tangential) * (1.0 / len);
    *force = tension * descent->inverse_unit;
    descent->force = WIDE_(max)(WIDE_(abs)(tension), descent->force);
    descent->load = WIDE_(max)(load, descent->load);
    descent->poison = WIDE_(fma)(*acc, WIDE_(of)(0), WIDE_(fma)(*force, WIDE_(of)(0), descent->poison));
}

LANES_INLINE void block_finish(struct block *block, const struct pend_tree *tree, struct descent *descent, int begin,
                               int count, double acc[], double force[]) {
    double along[DYNAMICS_BLOCK] __attribute__((aligned(64))), across[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    double far[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    block_down(block, tree->kin + begin, descent, count, along, across, far);
    const double *len = tree->len + begin;
    wide a, f;
    int i = 0;
    acc += begin, force += begin;
    for (; i + WIDE <= count; i += WIDE) {
        block_values(block, i, WIDE_(get)(along + i), WIDE_(get)(across + i), WIDE_(get)(far + i), wide_load(len + i),
                     descent, &a, &f);
        memcpy(acc + i, &a, sizeof a);
        memcpy(force + i, &f, sizeof f);
    }
    if (i == count) return;
    count -= i;
    block_values(block, i, wide_load_some(along + i, count), wide_load_some(across + i, count),
                 wide_load_some(far + i, count), wide_load_some(len + i, count), descent, &a, &f);
    for (int j = 0; j < count; j++) acc[i + j] = a[j], force[i + j] = f[j];
}

static int kernel_one(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                      double work[], double acc[], double force[]) {
    struct block *block = (struct block *)work;
    int n = tree->n, blocks = (n + DYNAMICS_BLOCK - 1) / DYNAMICS_BLOCK;
    struct climb climb;
    climb.now = (struct sums){0};
    climb.top = climb.stack, climb.unit = kernel_unit(tree->subtree_mass[0]);
    for (int b = blocks - 1; b >= 0; b--) {
        int begin = b * DYNAMICS_BLOCK, count = n - begin < DYNAMICS_BLOCK ? n - begin : DYNAMICS_BLOCK;
        block_prepare(block + b, tree, phi, rate, begin, count);
        if (!block_up(block + b, tree, &climb, begin, count)) return 0;
    }
    struct descent descent;
    // gravity is a pivot that accelerates with i g
    descent.now = (struct tip){0, gravity, 0, -gravity, fabs(gravity)};
    descent.top = descent.stack, descent.inverse_unit = 1 / climb.unit;
    descent.force = descent.load = descent.poison = WIDE_(of)(0);
    for (int b = 0; b < blocks; b++) {
        int begin = b * DYNAMICS_BLOCK, count = n - begin < DYNAMICS_BLOCK ? n - begin : DYNAMICS_BLOCK;
        block_finish(block + b, tree, &descent, begin, count, acc, force);
    }
    double most = 0, load = 0, poison = 0;
    for (int i = 0; i < WIDE; i++) {
        most = descent.force[i] > most ? descent.force[i] : most;
        load = descent.load[i] > load ? descent.load[i] : load;
        poison += descent.poison[i];
    }
    return poison == 0 && load <= LOAD_MOST * most;
}

/* Several states of one tree, one a lane: the same sweeps with the same operations, every number a vector. */
struct lanes_arm {
    wide cosine, sine, spin, eff, held, lean, side;
};

struct lanes_sums {
    wide s, q, r, b, t, area, lift;
};

struct lanes_tip {
    wide radial, tangential, lean, side, far;
};

/* arms whose angles are done together, so that nothing waits for a sine */
enum { LANES_BLOCK = 16 };

static void lanes_prepare(const struct pend_tree *tree, const double phi[], const double rate[], struct lanes_arm arm[],
                          int begin, int end) {
    for (int k = begin; k < end; k++) {
        wide x = WIDE_(get)(phi + DYNAMICS_LANES * k), base = WIDE_(of)(0), v = WIDE_(get)(rate + DYNAMICS_LANES * k);
        if (k) base = WIDE_(get)(phi + DYNAMICS_LANES * tree->parent[k]);
        wide angle = x - base, back = x - angle, low = (x - (angle + back)) + (back - base);
        WIDE_(sincos)(angle, low, &arm[k].sine, &arm[k].cosine);
        arm[k].spin = tree->len[k] * v * v;
    }
}

LANES_INLINE struct lanes_sums lanes_first(wide S, wide f, wide C, wide Z) {
    wide zero = WIDE_(of)(0);
    return (struct lanes_sums){S, S * (Z * Z), S * (C * Z), f * C, f * Z, zero, zero};
}

LANES_INLINE struct lanes_sums lanes_join(const struct lanes_sums *j, wide S, wide f, wide C, wide Z) {
    wide x = WIDE_(fma)(j->q, C, -(j->r * Z)), y = WIDE_(fma)(j->s - j->q, Z, -(j->r * C));
    wide z = S * WIDE_(fma)(j->b, Z, -(j->t * C));
    return (struct lanes_sums){j->s + S,
                               WIDE_(fma)(S, Z * Z, j->q),
                               WIDE_(fma)(S, C * Z, j->r),
                               WIDE_(fma)(f, C, j->b),
                               WIDE_(fma)(f, Z, j->t),
                               WIDE_(fma)(S, WIDE_(fma)(Z, y, C * x), j->area),
                               WIDE_(fma)(f, x, WIDE_(fma)(Z, z, j->lift))};
}

static void lanes_up(const struct pend_tree *tree, double unit, const double phi[], const double rate[],
                     struct lanes_arm arm[]) {
    struct lanes_sums stack[WAITING], *top = stack, now = {0};
    int ready = tree->n;
    for (int k = tree->n - 1; k >= 0; k--) {
        if (k < ready) {
            int begin = ready > LANES_BLOCK ? ready - LANES_BLOCK : 0;
            lanes_prepare(tree, phi, rate, arm, begin, ready);
            ready = begin;
        }
        unsigned how = tree->kin[k];
        struct lanes_arm *a = &arm[k];
        wide m = WIDE_(of)(unit * tree->mass[k]), S = m, C = a->cosine, Z = a->sine, f = -(m * a->spin);
        if (!(how & PEND_KIN_LEAF)) {
            wide inv = 1.0 / (m + now.q), h = WIDE_(fma)(m, now.b, now.lift) * inv;
            S = WIDE_(fma)(m, m + now.s, now.area) * inv;
            f = WIDE_(fma)(-S, a->spin, h);
            a->held = h;
            a->lean = now.r * inv;
            a->side = now.t * inv;
        }
        a->eff = S;
        if (!(how & PEND_KIN_LAST)) {
            now = lanes_join(top, S, f, C, Z);
            if (how & PEND_KIN_FIRST)
                top--;
            else
                *top = now;
        } else {
            now = lanes_first(S, f, C, Z);
            if (!(how & PEND_KIN_FIRST)) *++top = now;
        }
    }
}

/* returns all ones in the lanes whose digits are kept */
static wide lanes_down(const struct pend_tree *tree, double unit, double gravity, const struct lanes_arm arm[],
                       double acc[], double force[]) {
    struct lanes_tip stack[WAITING], *top = stack, now;
    wide zero = WIDE_(of)(0), most = zero, loads = zero, poison = zero;
    double inverse_unit = 1 / unit;
    // gravity is a pivot that accelerates with i g
    now = (struct lanes_tip){zero, zero + gravity, zero, zero - gravity, zero + fabs(gravity)};
    for (int k = 0; k < tree->n; k++) {
        unsigned how = tree->kin[k];
        const struct lanes_arm *a = &arm[k];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        wide C = a->cosine, Z = a->sine, w = a->spin, S = a->eff;
        wide kappa = WIDE_(fma)(-Z, now.lean, C), shift = WIDE_(fma)(Z, now.side, w);
        wide radial = WIDE_(fma)(kappa, now.radial, -shift), tension = S * radial;
        wide across = WIDE_(fma)(Z, now.radial, -(C * now.tangential));
        loads = WIDE_(max)(S * (now.far + w), loads);
        if (!(how & PEND_KIN_LEAF)) {
            now.lean = a->lean, now.side = a->side;
            now.tangential = -WIDE_(fma)(now.lean, radial, now.side);
            now.radial = radial;
            now.far = WIDE_(max)(WIDE_(abs)(radial) + WIDE_(abs)(now.tangential) + w, now.far);
            tension = WIDE_(fma)(S, radial, a->held);
            across += now.tangential;
            if (how & PEND_KIN_FORK) *++top = now;
        }
        most = WIDE_(max)(WIDE_(abs)(tension), most);
        tension *= inverse_unit;
        across *= 1 / tree->len[k];
        poison = WIDE_(fma)(across, zero, WIDE_(fma)(tension, zero, poison));
        WIDE_(put)(acc + DYNAMICS_LANES * k, across);
        WIDE_(put)(force + DYNAMICS_LANES * k, tension);
    }
    return (wide)((loads <= LOAD_MOST * most) & (poison == 0));
}

static unsigned kernel_lanes(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                             double work[], double acc[], double force[]) {
    struct lanes_arm *arm = (struct lanes_arm *)work;
    double unit = kernel_unit(tree->subtree_mass[0]);
    unsigned kept = 0;
    for (int i = 0; i < DYNAMICS_LANES; i += WIDE) {
        lanes_up(tree, unit, phi + i, rate + i, arm);
        wide good = lanes_down(tree, unit, gravity, arm, acc + i, force + i);
        long long bits[WIDE];
        memcpy(bits, &good, sizeof bits);
        for (int j = 0; j < WIDE; j++) kept |= bits[j] ? 1u << (i + j) : 0;
    }
    return kept;
}

#define KERNEL_PASTE2(a, b) a##b
#define KERNEL_PASTE(a, b) KERNEL_PASTE2(a, b)

const struct dynamics_kernel KERNEL_PASTE(pend_kernel_dynamics_, PEND_ISA) = {.one = kernel_one, .lanes = kernel_lanes};
