/* Phi'' and lambda of a long chain in one state.
 * Leaves to others: other trees, several states, forces that cancel (dynamics).
 * Invariant: the same operations for any width of vectors. */
#ifndef PEND_DYNAMICS_CHAIN_KERNEL_H
#define PEND_DYNAMICS_CHAIN_KERNEL_H

#include "core/dynamics_kernel.h"

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
    lanes8_between(x, base, &sine, &cosine);
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
    lanes8_between(next, base, &first_sine, &first_cosine);
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
            lanes8_between(x, base, &sine, &cosine);
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

#endif
