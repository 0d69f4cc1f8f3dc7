/* Phi'' and lambda of a long chain in one state. Without this form the request of a trajectory
 * takes more processor time: 39 % more by rk8pd, 64 % by rkf45 and 10 % by ode23 for a chain of 128
 * arms, and 11 to 13 % for 1024 arms (avx2 and avx512).
 * Leaves to others: other trees, several states, states with cancelling forces (dynamics).
 * Invariant: the same operations for any width of vectors. */
#ifndef PEND_DYNAMICS_CHAIN_TEMPLATE_H
#define PEND_DYNAMICS_CHAIN_TEMPLATE_H

#include "core/dynamics/dynamics_template.h"

/*
 * A long chain is cut into DYNAMICS_VEC pieces that are solved side by side, which makes the
 * sequential part an eighth as long. A piece depends linearly on the acceleration x of its base
 * along its first arm and on the tension mu of the arm after it:
 *
 * lambda of its first arm = S x + f + g mu
 * acceleration of its last tip along the next arm = g x + e - k mu */
struct chain_pieces {
    double eff[DYNAMICS_VEC], bias[DYNAMICS_VEC], gain[DYNAMICS_VEC]; /* S, f, g */
    double drift[DYNAMICS_VEC], give[DYNAMICS_VEC];                   /* e, k */
    double least, most;                                               /* masses */
};

/* frames before the first arms of the pieces, and before the first arm of the remainder */
struct chain_cuts {
    double sine[DYNAMICS_VEC + 1], cosine[DYNAMICS_VEC + 1];
};

/* the tension of an arm is slope lambda + offset + share mu, lambda the tension of the arm before
 * it */
struct chain_row {
    wide slope, offset, share, sine, inverse_mass, inverse_len, tension;
};

/* chains whose masses differ by more than this factor use the form for any tree */
enum { CHAIN_MASSES = 1024 };

/* one number of every piece, or of as many pieces as fit a vector */
VEC_INLINE wide chain_load(const double *from, size_t length) {
#if KERNEL_WIDTH == 8
    return (wide){from[0],          from[length],     from[2 * length], from[3 * length],
                  from[4 * length], from[5 * length], from[6 * length], from[7 * length]};
#elif KERNEL_WIDTH == 4
    return (wide){from[0], from[length], from[2 * length], from[3 * length]};
#else
    return (wide){from[0], from[length]};
#endif
}

VEC_INLINE void chain_store(double to[], size_t length, wide x) {
    for (size_t j = 0; j < WIDE; j++) to[j * length] = x[j];
}

VEC_INLINE void chain_put(double *to, wide x) { memcpy(to, &x, sizeof x); }

/* DYNAMICS_VEC angles x - base */
static void chain_angles(const double x[], const double base[], double sine[], double cosine[]) {
    for (int j = 0; j < DYNAMICS_VEC; j += WIDE) {
        wide s, c;
        WIDE_(between)(wide_load(x + j), wide_load(base + j), &s, &c);
        chain_put(sine + j, s);
        chain_put(cosine + j, c);
    }
}

/* the arms after the last piece, fewer than DYNAMICS_VEC */
struct chain_rest {
    int count;
    double sine[DYNAMICS_VEC], cosine[DYNAMICS_VEC], mass[DYNAMICS_VEC];
    double slope[DYNAMICS_VEC], offset[DYNAMICS_VEC], tension[DYNAMICS_VEC];
    double eff, bias; /* of its first arm; 0 if there is none */
};

static void chain_rest_up(struct chain_rest *rest, const struct pend_tree *tree, double unit,
                          const double phi[], const double rate[]) {
    int first = tree->n / DYNAMICS_VEC * DYNAMICS_VEC;
    double x[DYNAMICS_VEC] = {0}, base[DYNAMICS_VEC] = {0}, S = 0, f = 0;
    rest->count = tree->n - first;
    for (int i = 0; i < rest->count; i++) x[i] = phi[first + i], base[i] = phi[first + i - 1];
    chain_angles(x, base, rest->sine, rest->cosine);
    for (int i = rest->count - 1; i >= 0; i--) {
        double m = unit * tree->mass[first + i], v = rate[first + i],
               w = tree->len[first + i] * v * v, more = 0;
        rest->mass[i] = m;
        if (i + 1 < rest->count) {
            double C = rest->cosine[i + 1], Z = rest->sine[i + 1], part = m / fma1(S, Z * Z, m),
                   both = m + S;
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

static void chain_cut(struct chain_cuts *cuts, const struct chain_rest *rest, size_t length,
                      const double phi[]) {
    double x[DYNAMICS_VEC], base[DYNAMICS_VEC];
    for (size_t j = 0; j < DYNAMICS_VEC; j++)
        x[j] = phi[j * length], base[j] = j ? phi[j * length - 1] : 0;
    chain_angles(x, base, cuts->sine, cuts->cosine);
    cuts->sine[DYNAMICS_VEC] = rest->count ? rest->sine[0] : 0;
    cuts->cosine[DYNAMICS_VEC] = rest->count ? rest->cosine[0] : 0;
}

/* WIDE pieces, from `part` on, from their last arms to their first; row[i] belongs to arm i of
 * every piece */
static void chain_up(const struct pend_tree *tree, double unit, const double phi[],
                     const double rate[], const struct chain_cuts *cuts, int part,
                     struct chain_row row[], struct chain_pieces *pieces) {
    size_t length = (size_t)(tree->n / DYNAMICS_VEC), begin = (size_t)part * length;
    const double *len = tree->len + begin, *mass = tree->mass + begin;
    phi += begin, rate += begin;
    wide x = chain_load(phi + length - 1, length), sine, cosine;
    wide C = wide_load(cuts->cosine + part + 1), Z = wide_load(cuts->sine + part + 1);
    wide eff = C, bias = C, gain = C, drift = C, give = C, least = WIDE_(of)(INFINITY),
         most = WIDE_(of)(0);
    for (size_t i = length; i-- > 0;) {
        wide m = chain_load(mass + i, length) * unit, l = chain_load(len + i, length);
        wide v = chain_load(rate + i, length), w = l * v * v, inverse = 1.0 / (m * l);
        row[i].inverse_mass = inverse * l;
        row[i].inverse_len = inverse * m;
        least = WIDE_(min)(m, least), most = WIDE_(max)(m, most);
        if (i + 1 == length) {
            eff = m, bias = -(m * w), gain = C, drift = -(C * w),
            give = Z * Z * row[i].inverse_mass;
        } else {
            wide ZZ = Z * Z, across = WIDE_(fma)(eff, ZZ, m), along = m + eff,
                 both = 1.0 / (across * along);
            wide yield = both * along, hold = both * across, part_m = m * yield, keep = part_m * C;
            wide slip = ZZ * yield * gain, lead = m * hold;
            row[i + 1].slope = eff * C * hold;
            row[i + 1].offset = lead * bias;
            row[i + 1].share = lead * gain;
            drift = WIDE_(fma)(-slip, bias, drift);
            give = WIDE_(fma)(slip, gain, give);
            gain = keep * gain;
            drift = WIDE_(fma)(-gain, w, drift);
            eff = along * part_m;
            bias = WIDE_(fma)(keep, bias, -(eff * w));
        }
        if (i) {
            wide base = chain_load(phi + i - 1, length);
            WIDE_(between)(x, base, &sine, &cosine);
            x = base;
        } else {
            sine = wide_load(cuts->sine + part), cosine = wide_load(cuts->cosine + part);
        }
        row[i].sine = Z = sine;
        C = cosine;
    }
    chain_put(pieces->eff + part, eff);
    chain_put(pieces->bias + part, bias);
    chain_put(pieces->gain + part, gain);
    chain_put(pieces->drift + part, drift);
    chain_put(pieces->give + part, give);
    for (int j = 0; j < WIDE; j++) {
        pieces->least = least[j] < pieces->least ? least[j] : pieces->least;
        pieces->most = most[j] > pieces->most ? most[j] : pieces->most;
    }
}

/* tensions of the pieces' first arms and of the arms after the pieces; returns the largest sum of
 * terms that cancel */
static double chain_join(const struct chain_pieces *p, const struct chain_rest *rest,
                         double gravity, double x, double first[], double next[]) {
    double S[DYNAMICS_VEC + 1], f[DYNAMICS_VEC + 1], inverse[DYNAMICS_VEC], load;
    S[DYNAMICS_VEC] = rest->eff, f[DYNAMICS_VEC] = rest->bias;
    for (int j = DYNAMICS_VEC - 1; j >= 0; j--) {
        inverse[j] = 1 / fma1(p->give[j], S[j + 1], 1);
        S[j] = p->eff[j] + p->gain[j] * p->gain[j] * S[j + 1] * inverse[j];
        f[j] = p->bias[j] + p->gain[j] * fma1(S[j + 1], p->drift[j], f[j + 1]) * inverse[j];
    }
    double tension = S[0] * x + f[0];
    load = S[0] * fabs(gravity) + fabs(f[0]);
    for (int j = 0; j < DYNAMICS_VEC; j++) {
        double y = fma1(p->gain[j], x, p->drift[j]);
        double here =
            (S[j + 1] * (fabs(p->gain[j] * x) + fabs(p->drift[j])) + fabs(f[j + 1])) * inverse[j];
        load = here > load ? here : load;
        first[j] = tension;
        tension = fma1(S[j + 1], y, f[j + 1]) * inverse[j];
        next[j] = tension;
        x = (y - p->give[j] * f[j + 1]) * inverse[j];
    }
    return load;
}

/* Values passed from piece to piece in the sweep from the root: tensions of the first arms and of
 * the arms after the pieces; lambda / m of the arm before. */
struct chain_ends {
    double first[DYNAMICS_VEC], next[DYNAMICS_VEC], before[DYNAMICS_VEC + 1];
};

/* the tensions of WIDE pieces */
static void chain_tensions(size_t length, int part, struct chain_row row[],
                           struct chain_ends *ends) {
    wide next = wide_load(ends->next + part), tension = wide_load(ends->first + part);
    row[0].tension = tension;
    for (size_t i = 1; i < length; i++) {
        tension = WIDE_(fma)(row[i].slope, tension, WIDE_(fma)(row[i].share, next, row[i].offset));
        row[i].tension = tension;
    }
    chain_put(ends->before + part + 1, tension * row[length - 1].inverse_mass);
}

/* Across its arm, a tip accelerates by the pull of the next arm and a base by the pull of the arm
 * before. gap: the same for the base of the first arm. Returns whether all values are finite. */
static int chain_down(size_t length, int part, const struct chain_row row[],
                      const struct chain_ends *ends, const struct chain_cuts *cuts, double unit,
                      wide gap, double acc[], double force[], double *most) {
    wide zero = WIDE_(of)(0), largest = zero, poison = zero;
    wide end = wide_load(cuts->sine + part + 1) * wide_load(ends->next + part);
    double inverse_unit = 1 / unit;
    acc += (size_t)part * length, force += (size_t)part * length;
    for (size_t i = 0; i < length; i++) {
        const struct chain_row *r = &row[i];
        wide after = i + 1 < length ? r[1].sine * r[1].tension : end;
        wide a = WIDE_(fma)(-after, r->inverse_mass, gap) * r->inverse_len,
             f = r->tension * inverse_unit;
        largest = WIDE_(peak)(r->tension, largest);
        poison = WIDE_(fma)(a, zero, WIDE_(fma)(f, zero, poison));
        chain_store(acc + i, length, a);
        chain_store(force + i, length, f);
        if (i + 1 < length) gap = r[1].sine * (r->tension * r->inverse_mass);
    }
    int fine = 1;
    for (int j = 0; j < WIDE; j++) {
        *most = largest[j] > *most ? largest[j] : *most;
        fine &= poison[j] == 0;
    }
    return fine;
}

/* the remainder of a chain from its first arm; before: lambda / m of the arm before it */
static void chain_rest_down(struct chain_rest *rest, const struct pend_tree *tree,
                            double inverse_unit, double before, double tension, double acc[],
                            double force[]) {
    int first = tree->n - rest->count;
    for (int i = 0; i < rest->count; i++) {
        rest->tension[i] = tension = i ? fma1(rest->slope[i], tension, rest->offset[i]) : tension;
        force[first + i] = tension * inverse_unit;
    }
    for (int i = 0; i < rest->count; i++) {
        double after =
            i + 1 < rest->count ? rest->sine[i + 1] * rest->tension[i + 1] / rest->mass[i] : 0;
        acc[first + i] = (rest->sine[i] * before - after) / tree->len[first + i];
        before = rest->tension[i] / rest->mass[i];
    }
}

static int kernel_chain(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], const double rate[], double work[], double acc[],
                        double force[]) {
    size_t length = (size_t)(tree->n / DYNAMICS_VEC);
    struct chain_row *row = (struct chain_row *)work;
    struct chain_rest rest;
    struct chain_cuts cuts;
    struct chain_pieces pieces = {.least = INFINITY};
    struct chain_ends ends;
    double gravity = loads->gravity, unit = kernel_unit(tree->subtree_mass[0]), most = 0;
    int fine = 1;
    chain_rest_up(&rest, tree, unit, phi, rate);
    chain_cut(&cuts, &rest, length, phi);
    for (int j = 0; j < DYNAMICS_VEC; j += WIDE)
        chain_up(tree, unit, phi, rate, &cuts, j, row + (size_t)(j / WIDE) * length, &pieces);
    double load =
        chain_join(&pieces, &rest, gravity, cuts.sine[0] * gravity, ends.first, ends.next);
    ends.before[0] = 0;
    for (int j = 0; j < DYNAMICS_VEC; j += WIDE) {
        struct chain_row *part = row + (size_t)(j / WIDE) * length;
        chain_tensions(length, j, part, &ends);
        wide gap = part[0].sine * wide_load(ends.before + j);
        if (!j) gap[0] = -gravity * cos(phi[0]);
        fine &= chain_down(length, j, part, &ends, &cuts, unit, gap, acc, force, &most);
    }
    chain_rest_down(&rest, tree, 1 / unit, ends.before[DYNAMICS_VEC], ends.next[DYNAMICS_VEC - 1],
                    acc, force);
    return fine && pieces.most <= CHAIN_MASSES * pieces.least && load <= LOAD_MOST * most;
}

static int kernel_is_chain(const struct pend_tree *tree) {
    return tree->n >= DYNAMICS_CHAIN && tree->depth[tree->n - 1] == tree->n;
}

#endif
