#include "core/kernel_dynamics.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/kernel_width.h"

/* loops over arms take as many at once as the instruction set holds */
enum { WIDE = KERNEL_WIDTH };
typedef KERNEL_OF(lanes, ) wide;
#define WIDE_(name) KERNEL_OF(lanes, _##name)
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

/* the first `count` numbers of a vector; the others are 1 */
LANES_INLINE wide wide_load_some(const double *from, int count) {
#if defined(__AVX512F__)
    return (wide)_mm512_mask_loadu_pd(_mm512_set1_pd(1), (__mmask8)((1u << count) - 1), from);
#else
    wide x = WIDE_(of)(1);
    for (int i = 0; i < WIDE; i++)
        if (i < count) x[i] = from[i];
    return x;
#endif
}

LANES_INLINE void wide_store_some(double *to, wide x, int count) {
#if defined(__AVX512F__)
    _mm512_mask_storeu_pd(to, (__mmask8)((1u << count) - 1), (__m512d)x);
#else
    for (int i = 0; i < WIDE; i++)
        if (i < count) to[i] = x[i];
#endif
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
    wide_store_some(acc + i, a, count);
    wide_store_some(force + i, f, count);
}

/*
 * Long chains. A chain is a sequence from one end to the other; cut into DYNAMICS_LANES pieces that are solved side by
 * side it is one an eighth as long. A piece answers to the acceleration x of its base along its first arm, and to the
 * tension mu of the arm that follows it:
 *
 *     lambda of its first arm = S x + f + g mu        acceleration of its last tip along the next arm = g x + e - k mu
 */
struct chain_piece {
    lanes8 eff, bias, gain, drift, give; /* S, f, g, e, k */
};

/* how the tension of an arm follows from that of the one before it: slope lambda + offset + share mu */
struct chain_row {
    lanes8 slope, offset, share, sine, inverse_mass, inverse_len, tension;
};

/* masses further apart than this go the long way */
enum { CHAIN_MASSES = 1024 };

LANES_INLINE lanes8 chain_load(const double *from, size_t length) {
    return (lanes8){from[0],          from[length],     from[2 * length], from[3 * length],
                    from[4 * length], from[5 * length], from[6 * length], from[7 * length]};
}

LANES_INLINE void chain_angle(lanes8 x, lanes8 base, lanes8 *sine, lanes8 *cosine) {
    lanes8 angle = x - base, back = x - angle, low = (x - (angle + back)) + (back - base);
    lanes8_sincos(angle, low, sine, cosine);
}

/* the arms behind the last piece, fewer than DYNAMICS_LANES */
struct chain_rest {
    int count;
    double sine[DYNAMICS_LANES], cosine[DYNAMICS_LANES], mass[DYNAMICS_LANES];
    double slope[DYNAMICS_LANES], offset[DYNAMICS_LANES], tension[DYNAMICS_LANES];
    double eff, bias; /* of its first arm, 0 without one */
};

static void chain_rest_up(struct chain_rest *rest, const struct pend_tree *tree, double unit, const double phi[],
                          const double rate[]) {
    int first = tree->n / DYNAMICS_LANES * DYNAMICS_LANES;
    lanes8 x = lanes8_of(0), base = x, sine, cosine;
    double S = 0, f = 0;
    rest->count = tree->n - first;
    for (int i = 0; i < rest->count; i++) x[i] = phi[first + i], base[i] = phi[first + i - 1];
    chain_angle(x, base, &sine, &cosine);
    for (int i = rest->count - 1; i >= 0; i--) {
        double m = unit * tree->mass[first + i], v = rate[first + i], w = tree->len[first + i] * v * v, more = 0;
        rest->sine[i] = sine[i], rest->cosine[i] = cosine[i], rest->mass[i] = m;
        if (i + 1 < rest->count) {
            double C = cosine[i + 1], Z = sine[i + 1], part = m / fma1(S, Z * Z, m), both = m + S;
            rest->slope[i + 1] = S * C / both;
            rest->offset[i + 1] = m * f / both;
            more = part * C * f;
            S = both * part;
        } else {
            S = m;
        }
        f = fma1(-S, w, more);
    }
    rest->eff = S, rest->bias = f;
}

/* the pieces from their last arms to their first; row[i] is of arm i of every piece */
static struct chain_piece chain_up(const struct pend_tree *tree, double unit, const double phi[], const double rate[],
                                   const struct chain_rest *rest, struct chain_row row[], lanes8 *least, lanes8 *most) {
    size_t length = (size_t)(tree->n / DYNAMICS_LANES);
    const double *len = tree->len, *mass = tree->mass;
    lanes8 x = chain_load(phi + length - 1, length), next = lanes8_of(0), base, sine, cosine, first_sine, first_cosine;
    // the angle across each cut
    next = chain_load(phi, length);
    base = (lanes8){0, x[0], x[1], x[2], x[3], x[4], x[5], x[6]};
    chain_angle(next, base, &first_sine, &first_cosine);
    lanes8 C = {first_cosine[1], first_cosine[2], first_cosine[3], first_cosine[4],
                first_cosine[5], first_cosine[6], first_cosine[7], rest->count ? rest->cosine[0] : 0};
    lanes8 Z = {first_sine[1], first_sine[2], first_sine[3], first_sine[4],
                first_sine[5], first_sine[6], first_sine[7], rest->count ? rest->sine[0] : 0};
    struct chain_piece p = {0};
    *least = lanes8_of(INFINITY), *most = lanes8_of(0);
    for (size_t i = length; i-- > 0;) {
        lanes8 m = chain_load(mass + i, length) * unit, l = chain_load(len + i, length);
        lanes8 v = chain_load(rate + i, length), w = l * v * v, inverse = 1.0 / (m * l);
        row[i].inverse_mass = inverse * l;
        row[i].inverse_len = inverse * m;
        *least = lanes8_min(m, *least), *most = lanes8_max(m, *most);
        if (i + 1 == length) {
            p = (struct chain_piece){m, -(m * w), C, -(C * w), Z * Z * row[i].inverse_mass};
        } else {
            lanes8 ZZ = Z * Z, across = lanes8_fma(p.eff, ZZ, m), along = m + p.eff, both = 1.0 / (across * along);
            lanes8 yield = both * along, hold = both * across, part = m * yield, keep = part * C;
            lanes8 slip = ZZ * yield * p.gain, lead = m * hold;
            row[i + 1].slope = p.eff * C * hold;
            row[i + 1].offset = lead * p.bias;
            row[i + 1].share = lead * p.gain;
            p.drift = lanes8_fma(-slip, p.bias, p.drift);
            p.give = lanes8_fma(slip, p.gain, p.give);
            p.gain = keep * p.gain;
            p.drift = lanes8_fma(-p.gain, w, p.drift);
            p.eff = along * part;
            p.bias = lanes8_fma(keep, p.bias, -(p.eff * w));
        }
        if (i) {
            base = chain_load(phi + i - 1, length);
            chain_angle(x, base, &sine, &cosine);
            x = base;
        } else {
            sine = first_sine, cosine = first_cosine;
        }
        row[i].sine = Z = sine;
        C = cosine;
    }
    return p;
}

/* tensions of the pieces' first arms, and of the arms that follow them; returns the largest sum of what cancels there
 */
static double chain_join(const struct chain_piece *p, const struct chain_rest *rest, double gravity, double x,
                         lanes8 *first, lanes8 *next) {
    double S[DYNAMICS_LANES + 1], f[DYNAMICS_LANES + 1], inverse[DYNAMICS_LANES], load;
    S[DYNAMICS_LANES] = rest->eff, f[DYNAMICS_LANES] = rest->bias;
    for (int j = DYNAMICS_LANES - 1; j >= 0; j--) {
        inverse[j] = 1 / fma1(p->give[j], S[j + 1], 1);
        S[j] = p->eff[j] + p->gain[j] * p->gain[j] * S[j + 1] * inverse[j];
        f[j] = p->bias[j] + p->gain[j] * fma1(S[j + 1], p->drift[j], f[j + 1]) * inverse[j];
    }
    double tension = S[0] * x + f[0];
    load = S[0] * fabs(gravity) + fabs(f[0]);
    for (int j = 0; j < DYNAMICS_LANES; j++) {
        double y = fma1(p->gain[j], x, p->drift[j]);
        double here = (S[j + 1] * (fabs(p->gain[j] * x) + fabs(p->drift[j])) + fabs(f[j + 1])) * inverse[j];
        load = here > load ? here : load;
        (*first)[j] = tension;
        tension = fma1(S[j + 1], y, f[j + 1]) * inverse[j];
        (*next)[j] = tension;
        x = (y - p->give[j] * f[j + 1]) * inverse[j];
    }
    return load;
}

LANES_INLINE void chain_store(double to[], size_t length, lanes8 x) {
    for (size_t j = 0; j < DYNAMICS_LANES; j++) to[j * length] = x[j];
}

/* the rest of a chain from its first arm; before: lambda / m of the arm before it */
static void chain_rest_down(struct chain_rest *rest, const struct pend_tree *tree, double inverse_unit, double before,
                            double tension, double acc[], double force[]) {
    int first = tree->n - rest->count;
    for (int i = 0; i < rest->count; i++) {
        rest->tension[i] = tension = i ? fma1(rest->slope[i], tension, rest->offset[i]) : tension;
        force[first + i] = tension * inverse_unit;
    }
    for (int i = 0; i < rest->count; i++) {
        double after = i + 1 < rest->count ? rest->sine[i + 1] * rest->tension[i + 1] / rest->mass[i] : 0;
        acc[first + i] = (rest->sine[i] * before - after) / tree->len[first + i];
        before = rest->tension[i] / rest->mass[i];
    }
}

static int kernel_chain(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                        double work[], double acc[], double force[]) {
    size_t length = (size_t)(tree->n / DYNAMICS_LANES);
    struct chain_row *row = (struct chain_row *)work;
    struct chain_rest rest;
    lanes8 least, most, first, next, zero = lanes8_of(0), largest = zero, poison = zero;
    double unit = kernel_unit(tree->subtree_mass[0]), inverse_unit = 1 / unit;
    chain_rest_up(&rest, tree, unit, phi, rate);
    struct chain_piece p = chain_up(tree, unit, phi, rate, &rest, row, &least, &most);
    double load = chain_join(&p, &rest, gravity, row[0].sine[0] * gravity, &first, &next);
    // the tensions
    row[0].tension = first;
    for (size_t i = 1; i < length; i++)
        row[i].tension = lanes8_fma(row[i].slope, row[i - 1].tension, lanes8_fma(row[i].share, next, row[i].offset));
    // tips accelerate across their arms by what the next arm pulls, bases by what the arm before pulls
    lanes8 last = row[length - 1].tension * row[length - 1].inverse_mass;
    lanes8 before = {0, last[0], last[1], last[2], last[3], last[4], last[5], last[6]}, gap = row[0].sine * before;
    gap[0] = -gravity * cos(phi[0]);
    lanes8 next_sine = {row[0].sine[1], row[0].sine[2], row[0].sine[3], row[0].sine[4],
                        row[0].sine[5], row[0].sine[6], row[0].sine[7], rest.count ? rest.sine[0] : 0};
    for (size_t i = 0; i < length; i++) {
        struct chain_row *r = &row[i];
        lanes8 after = i + 1 < length ? r[1].sine * r[1].tension : next_sine * next;
        lanes8 a = lanes8_fma(-after, r->inverse_mass, gap) * r->inverse_len, f = r->tension * inverse_unit;
        largest = lanes8_max(lanes8_abs(r->tension), largest);
        poison = lanes8_fma(a, zero, lanes8_fma(f, zero, poison));
        chain_store(acc + i, length, a);
        chain_store(force + i, length, f);
        if (i + 1 < length) gap = r[1].sine * (r->tension * r->inverse_mass);
    }
    chain_rest_down(&rest, tree, inverse_unit, last[7], next[7], acc, force);
    double high = 0, low = INFINITY, heavy = 0, bad = 0;
    for (int j = 0; j < DYNAMICS_LANES; j++) {
        high = largest[j] > high ? largest[j] : high;
        low = least[j] < low ? least[j] : low;
        heavy = most[j] > heavy ? most[j] : heavy;
        bad += poison[j];
    }
    return bad == 0 && heavy <= CHAIN_MASSES * low && load <= LOAD_MOST * high;
}

static int kernel_is_chain(const struct pend_tree *tree) {
    return tree->n >= DYNAMICS_CHAIN && tree->depth[tree->n - 1] == tree->n;
}

static int kernel_one(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                      double work[], double acc[], double force[]) {
    if (kernel_is_chain(tree) && kernel_chain(tree, gravity, phi, rate, work, acc, force)) return 1;
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

const struct dynamics_kernel KERNEL_NAME(pend_kernel_dynamics_) = {.one = kernel_one, .lanes = kernel_lanes};
