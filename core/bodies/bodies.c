#include "core/bodies/bodies.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/base/isa.h"

enum {
    BODIES_TILE = 8,
    BODIES_AHEAD = 3,  /* orders stored beyond those of a series: rotations need two more */
    BODIES_SURELY = 16 /* a value that exceeds another by this factor counts as exact next to it */
};

const struct bodies_kernel *pend_kernel_bodies(void) {
    return PEND_ISA_PICK(pend_kernel_bodies, pend_isa_best());
}

/* number of arms, padded to whole tiles */
static size_t bodies_arms(int n) {
    return ((size_t)n + BODIES_TILE - 1) / BODIES_TILE * BODIES_TILE;
}

static size_t bodies_series(int n, int order) {
    return bodies_arms(n) * (size_t)(order + BODIES_AHEAD);
}

size_t pend_bodies_system_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                                int order) {
    size_t arms = bodies_arms(tree->n); // the four series that jets stores are not counted
    size_t own = bodies_numbers(terms, arms, bodies_series(tree->n, order), order) + 2 * arms;
    return (own + 7) / 8 * 8 * sizeof(double);
}

void pend_bodies_system(struct bodies_system *system, const struct pend_tree *tree,
                        const struct pend_loads *loads, int order, void *memory) {
    assert(tree->n >= 1 && loads->terms && order >= 1);
    size_t arms = bodies_arms(tree->n);
    memset(memory, 0, pend_bodies_system_bytes(tree, loads->terms, order));
    double *len = memory, *mass = len + arms;
    for (int k = 0; k < tree->n; k++) len[k] = tree->len[k], mass[k] = tree->mass[k];
    *system = (struct bodies_system){.n = tree->n,
                                     .stride = BODIES_TILE,
                                     .tile = (size_t)BODIES_TILE * (size_t)(order + BODIES_AHEAD),
                                     .parent = tree->parent,
                                     .terms = loads->terms,
                                     .len = len,
                                     .mass = mass,
                                     .value = loads->value};
    bodies_lay(system, arms, bodies_series(tree->n, order), order, mass + arms);
}

size_t pend_bodies_bytes(const struct pend_tree *tree, const struct pend_terms *terms) {
    return pend_bodies_system_bytes(tree, terms, 1) +
           4 * bodies_series(tree->n, 1) * sizeof(double);
}

/* the force of the rail on a cart, along and across it */
static void bodies_rail(const struct bodies_system *s, const struct bodies_forces *forces) {
    double c = -s->point_y[0], z = s->point_x[0], x = s->pivot_force_x[0], y = s->pivot_force_y[0];
    assert(s->terms->one[PEND_TERM_RAIL] >= 0);
    double along = c * x + z * y, across = c * y - z * x;
    if (forces->joint_along) forces->joint_along[0] = along;
    if (forces->joint_across) forces->joint_across[0] = across;
    if (forces->tip_along) forces->tip_along[0] = along;
    if (forces->tip_across) forces->tip_across[0] = across;
}

/* the terms whose sum is the force in arm k; their rounding errors bound its error */
static double bodies_terms(const struct bodies_system *s, int k) {
    int p = s->parent[k];
    if (s->need & BODIES_SHAPE)
        return (s->form_xx[k] + s->form_yy[k]) * (fabs(s->base_x[k]) + fabs(s->base_y[k])) +
               fabs(s->asked_x[k]) + fabs(s->asked_y[k]);
    double a = fabs(s->base_x[p]) + fabs(s->base_y[p]),
           b = fabs(s->asked_x[k]) + fabs(s->asked_y[k]);
    double m = fabs(s->early_m[k]) + fabs(s->late_m[p]);
    double sway =
        fmax(fabs(s->sway_xx[k]) + fabs(s->sway_xy[k]), fabs(s->sway_yx[k]) + fabs(s->sway_yy[k]));
    double keep =
        fmax(fabs(s->keep_xx[k]) + fabs(s->keep_xy[k]), fabs(s->keep_yx[k]) + fabs(s->keep_yy[k]));
    double swing = fabs(s->swing_x[k]) + fabs(s->swing_y[k]);
    double turn = fabs(s->turn_x[k]) + fabs(s->turn_y[k]);
    return sway * a + swing * fabs(s->pulled[p]) + turn * m + keep * b;
}

/* Sums over the children of every arm, in the arm's frame: their forces (wind), the terms of these
 * (known), and their resistance to acceleration with the arm's own mass (next_x, next_known,
 * next_y: the xx, xy and yy of a matrix). A state needs no further orders, so these rows of the
 * series are unused. */
static void bodies_gather(const struct bodies_system *s) {
    for (int k = 0; k < s->n; k++) {
        s->wind_x[k] = s->wind_y[k] = s->next_known[k] = s->known[k] = 0;
        s->next_x[k] = s->next_y[k] = s->body[k];
    }
    for (int k = 1; k < s->n; k++) {
        int p = s->parent[k];
        double C = s->cosine[k], Z = s->sine[k], x = s->reach_x[k], y = s->reach_y[k];
        double A = s->form_xx[k], B = s->form_xy[k], E = s->form_yy[k];
        s->known[p] += bodies_terms(s, k);
        s->wind_x[p] += C * x - Z * y;
        s->wind_y[p] += Z * x + C * y;
        s->next_x[p] += C * (C * A - Z * B) - Z * (C * B - Z * E);
        s->next_y[p] += Z * (Z * A + C * B) + C * (Z * B + C * E);
        s->next_known[p] += Z * (C * A - Z * B) + C * (C * B - Z * E);
    }
}

/* Corrects forces by the balance of forces. If heavy arms pull at each other across a light joint,
 * each force is a small difference of large terms, but the sum of these forces is determined by the
 * force at the parent's joint. The correction goes from root to leaves. The residual is distributed
 * over them in proportion to their compliance, unless the balance of a heavy arm is itself less
 * accurate than the forces. */
static void bodies_balance(const struct bodies_system *s) {
    bodies_gather(s);
    for (int k = 1; k < s->n; k++) {
        int p = s->parent[k];
        double kr = s->pulled[p], chi = s->answer[p], hx = s->moment_x[p], hy = s->moment_y[p];
        double A = s->next_x[p], B = s->next_known[p], E = s->next_y[p], M = s->body[p];
        double x = s->reach_x[p] - s->wind_x[p] - M * s->base_x[p] - (hx * kr - hy * chi);
        double y = s->reach_y[p] - s->wind_y[p] - M * s->base_y[p] - (hy * kr + hx * chi);
        if (s->need & BODIES_AIR) x += s->drag_x[p], y += s->drag_y[p];
        double rough = M * (fabs(s->base_x[p]) + fabs(s->base_y[p])) +
                       (fabs(hx) + fabs(hy)) * (fabs(kr) + fabs(chi));
        if (BODIES_SURELY * rough > s->known[p]) continue;
        // besides the arm's own mass all terms are >= 0, so the second bound only removes rounding
        double det = fmax(A * E - B * B, M * (A + E - M));
        double ax = (E * x - B * y) / det, ay = (A * y - B * x) / det;
        if (!(fabs(ax) + fabs(ay) < INFINITY)) continue;
        double C = s->cosine[k], Z = s->sine[k], bx = C * ax + Z * ay, by = C * ay - Z * ax;
        double fx = s->form_xx[k] * bx + s->form_xy[k] * by;
        s->reach_x[k] += fx;
        s->reach_y[k] += s->form_xy[k] * bx + s->form_yy[k] * by;
    }
}

/* The forces at the tips. Two formulas give such a force: the force at the joint minus all other
 * contributions, and the force on the tip's own mass plus its children's. Each loses digits if the
 * mass on its side is heavy. The mean of both, weighted with these masses, does not contain the
 * acceleration of the joint: w plus m (l - c) u'', where w is the joint's force times the tip's
 * share of M. For children attached elsewhere their share is subtracted, for children at the tip
 * the remaining share is added. */
static void bodies_tips(const struct bodies_system *s) {
    for (int k = 0; k < s->n; k++) {
        size_t row = bodies_row(s, k);
        double dx = s->mass[k] * s->tail_x[k], dy = s->mass[k] * s->tail_y[k];
        double kr = s->pulled[k], chi = s->answer[k], w = s->tip_share[k];
        s->tip_x[row] = w * s->reach_x[k] + (dx * kr - dy * chi);
        s->tip_y[row] = w * s->reach_y[k] + (dy * kr + dx * chi);
        if (s->need & BODIES_AIR) {
            s->tip_x[row] -= s->tip_rest[k] * s->drag_x[k];
            s->tip_y[row] -= s->tip_rest[k] * s->drag_y[k];
        }
    }
    for (int k = 1; k < s->n; k++) {
        size_t up = bodies_row(s, s->parent[k]);
        double C = s->cosine[k], Z = s->sine[k], x = s->reach_x[k], y = s->reach_y[k];
        double part = bodies_hung(s, k) ? -s->tip_share[s->parent[k]] : s->tip_rest[s->parent[k]];
        s->tip_x[up] += part * (C * x - Z * y);
        s->tip_y[up] += part * (Z * x + C * y);
    }
}

/* the system at a state, to order 1; the unit of time is 1 s */
static struct bodies_system bodies_expand(const struct pend_tree *tree,
                                          const struct pend_loads *loads,
                                          const struct bodies_state *state, void *work) {
    struct bodies_system s;
    size_t series = bodies_series(tree->n, 1),
           own = pend_bodies_system_bytes(tree, loads->terms, 1);
    pend_bodies_system(&s, tree, loads, 1, work);
    s.rate = (double *)(void *)((char *)work + own);
    s.force = s.rate + series, s.turn_re = s.rate + 2 * series, s.turn_im = s.rate + 3 * series;
    memset(s.rate, 0, 4 * series * sizeof(double));
    pend_kernel_bodies()->orders(&s, state, loads->gravity, 1, 1);
    return s;
}

void pend_bodies_power_at(const struct pend_tree *tree, const struct pend_loads *loads,
                          const struct bodies_state *state, void *work, double acc[], double *given,
                          double *lost) {
    struct bodies_system s = bodies_expand(tree, loads, state, work);
    pend_kernel_bodies()->power(&s, 1, 1, 1, given, lost);
    for (int k = 0; k < tree->n; k++) acc[k] = s.rate[bodies_row(&s, k) + s.stride];
}

void pend_bodies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                    const struct bodies_state *state, void *work, double acc[],
                    const struct bodies_forces *forces) {
    struct bodies_system s = bodies_expand(tree, loads, state, work);
    if (forces) {
        bodies_balance(&s);
        bodies_tips(&s);
    }
    for (int k = 0; k < tree->n; k++) {
        size_t row = bodies_row(&s, k);
        acc[k] = s.rate[row + s.stride];
        if (!forces) continue;
        if (forces->joint_along) forces->joint_along[k] = s.reach_x[k];
        if (forces->joint_across) forces->joint_across[k] = s.reach_y[k];
        if (forces->tip_along) forces->tip_along[k] = s.tip_x[row];
        if (forces->tip_across) forces->tip_across[k] = s.tip_y[row];
    }
    if (forces && pend_terms_cart(loads->terms)) bodies_rail(&s, forces);
}
