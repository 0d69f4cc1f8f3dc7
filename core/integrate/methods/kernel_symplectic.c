#include "core/integrate/methods/kernel_symplectic.h"

#include <math.h>
#include <string.h>

#include "core/integrate/methods/gauss_table.h"
#include "core/simd/vec_isa.h"

/* a number is one value for each stage */
#define NUMBER_VEC 8
enum { WIDTH = 8 };
#include "core/taylor/jets_template.h"

#include "core/integrate/methods/conserved_template.h"

/*
 * For every stage, in addition to the tree system:
 *
 * turn, boost        contributions of the stage to phi and p: h b_j phi', h b_j p'
 * phi, phi_low       angles, as sums of two doubles
 * up_re, up_im       e^{i phi}
 * go_re, go_im       first z' of the tip, later the momentum of the arm with its sub-tree */
#define SYMPLECTIC_ARRAYS(X)                                                                       \
    X(turn) X(boost) X(phi) X(phi_low) X(rate) X(up_re) X(up_im) X(go_re) X(go_im)

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X) SYMPLECTIC_ARRAYS(X)
#undef X
        ARRAY_COUNT
};

struct symplectic_lanes {
    struct jets_system tree;
    int real; /* whether the pendulum has terms: then `body` is used and, of `tree`, only drag_im */
    struct conserved body;
#define X(name) num *name;
    SYMPLECTIC_ARRAYS(X)
#undef X
};

static size_t symplectic_count(const struct pend_terms *terms, int n) {
    return ((size_t)ARRAY_COUNT * (size_t)n + conserved_numbers(terms, n)) * WIDTH;
}

static struct symplectic_lanes symplectic_view(const struct symplectic_system *system) {
    size_t n = (size_t)system->n;
    num *at = (num *)(void *)system->lanes;
    const struct pend_terms *terms = system->loads.terms;
    struct symplectic_lanes s = {.tree = {.n = system->n,
                                          .parent = system->parent,
                                          .end = system->end,
#define X(name) .name = at + (size_t)ARRAY_##name * n,
                                          JETS_ARRAYS(X)},
                                 .real = terms != NULL,
                                 SYMPLECTIC_ARRAYS(X)
#undef X
    };
    if (terms)
        s.body = conserved_view(terms, system->n, system->parent, at + (size_t)ARRAY_COUNT * n);
    return s;
}

static void symplectic_load(struct symplectic_system *system, const double len[],
                            const double mass[]) {
    memset(system->lanes, 0, symplectic_count(system->loads.terms, system->n) * sizeof(double));
    struct symplectic_lanes s = symplectic_view(system);
    if (s.real) conserved_load(&s.body, len, mass, system->loads.value);
    for (int k = 0; k < system->n; k++) {
        s.tree.len[k] = num_of(len[k]);
        s.tree.inv_len[k] = num_of(1 / len[k]);
        s.tree.mass[k] = num_of(mass[k]);
    }
}

/* computes sines and cosines of all angles, and the tree system */
static void symplectic_place(const struct symplectic_lanes *s) {
    const struct jets_system *tree = &s->tree;
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        num x = s->phi[k], low = s->phi_low[k];
        lanes8_sincos(x, low, &s->up_im[k], &s->up_re[k]);
        if (s->real) continue;
        if (p < 0) {
            tree->sine[k] = s->up_im[k];
            tree->cosine[k] = s->up_re[k];
            continue;
        }
        num y = s->phi[p], d = x - y, back = x - d;
        num error = (x - (d + back)) + (back - y);
        lanes8_sincos(d, error + (low - s->phi_low[p]), &tree->sine[k], &tree->cosine[k]);
    }
    if (s->real)
        conserved_place(&s->body, s->phi, s->phi_low);
    else
        jets_factor(tree);
}

/* Computes phi' = (Re M)^-1 p. A momentum acts like a couple on its arm, which equals a force p / l
 * across it; p is in drag_im. */
static void symplectic_solve(const struct symplectic_lanes *s) {
    const struct jets_system *tree = &s->tree;
    if (s->real) {
        conserved_rates(&s->body, tree->drag_im, s->rate);
        return;
    }
    for (int k = 0; k < tree->n; k++) {
        tree->drag_im[k] *= tree->inv_len[k];
        tree->heave[k] = tree->sum_side[k] = tree->sum_cos[k] = tree->sum_sin[k] = tree->early[k] =
            num_of(0);
    }
    jets_up(tree);
    jets_down(tree, num_of(0));
    for (int k = 0; k < tree->n; k++) {
        num ar = tree->from_radial[k], at = tree->from_tangential[k];
        s->rate[k] =
            (tree->sine[k] * ar - tree->cosine[k] * at + tree->tangential[k]) * tree->inv_len[k];
    }
}

/* computes the momentum of the sub-tree of each arm from the rates */
static void symplectic_flow(const struct symplectic_lanes *s) {
    const struct jets_system *tree = &s->tree;
    if (s->real) {
        conserved_flow(&s->body, s->rate);
        return;
    }
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        num speed = tree->len[k] * s->rate[k];
        s->go_re[k] = (p < 0 ? num_of(0) : s->go_re[p]) - speed * s->up_im[k];
        s->go_im[k] = (p < 0 ? num_of(0) : s->go_im[p]) + speed * s->up_re[k];
    }
    for (int k = 0; k < tree->n; k++) s->go_re[k] *= tree->mass[k], s->go_im[k] *= tree->mass[k];
    for (int k = tree->n - 1; k > 0; k--) {
        s->go_re[tree->parent[k]] += s->go_re[k];
        s->go_im[tree->parent[k]] += s->go_im[k];
    }
}

/* at every stage, the sum of the contributions of all stages, by the tableau */
VEC_INLINE num symplectic_through(num gain) {
    num sum = num_of(0);
    for (int j = 0; j < GAUSS_STAGES; j++)
        sum = num_fma(num_of(gain[j]), *(const num *)gauss_through[j], sum);
    return sum;
}

/* the generalized force on the angle of arm k: p' = - l (phi' Re(conj(u) P) + g m cos phi), where P
 * and m belong to the arm with its sub-tree */
VEC_INLINE num symplectic_force(const struct symplectic_system *system,
                                const struct symplectic_lanes *s, int k) {
    if (s->real) return s->body.pull[k];
    num along = s->up_re[k] * s->go_re[k] + s->up_im[k] * s->go_im[k];
    return -s->tree.len[k] * num_fma(s->rate[k], along,
                                     system->loads.gravity * system->subtree_mass[k] * s->up_re[k]);
}

/* the inertia of everything that rotates with the angle of arm k, kg m^2 */
VEC_INLINE num symplectic_inertia(const struct symplectic_system *system,
                                  const struct symplectic_lanes *s, int k) {
    if (s->real) return s->body.swing[k];
    return system->subtree_mass[k] * s->tree.len[k] * s->tree.len[k];
}

/* One iteration: angles from rates, rates from momenta, forces from both. Returns the largest
 * change as an angle. */
static double symplectic_iterate(const struct symplectic_system *system,
                                 const struct symplectic_lanes *s,
                                 const struct symplectic_state *from, num weight) {
    const struct jets_system *tree = &s->tree;
    for (int k = 0; k < tree->n; k++) {
        num x = num_of(from->phi[k]), add = from->phi_low[k] + symplectic_through(s->turn[k]);
        num sum = x + add, part = sum - x;
        s->phi[k] = sum;
        s->phi_low[k] = (x - (sum - part)) + (add - part);
        tree->drag_im[k] = from->p[k] + (from->p_low[k] + symplectic_through(s->boost[k]));
    }
    symplectic_place(s);
    symplectic_solve(s);
    symplectic_flow(s);
    if (s->real) conserved_pull(&s->body, system->loads.gravity, s->rate, s->up_re, s->up_im);
    num change = num_of(0), bad = num_of(0);
    for (int k = 0; k < tree->n; k++) {
        num turn = weight * s->rate[k], boost = weight * symplectic_force(system, s, k);
        change = lanes8_max(change, lanes8_abs(turn - s->turn[k]));
        // converts a change of momentum to the change of the angle in a step
        num inertia = symplectic_inertia(system, s, k);
        change = lanes8_max(change, system->length * lanes8_abs(boost - s->boost[k]) / inertia);
        s->turn[k] = turn;
        s->boost[k] = boost;
        bad += (turn - turn) + (boost - boost);
    }
    double most = 0;
    for (int i = 0; i < WIDTH; i++) {
        if (change[i] > most) most = change[i];
        if (bad[i] != 0) return NAN;
    }
    return most;
}

/* Iterates until rounding stops the convergence of the stages, and then once more: otherwise the
 * end would always deviate to the same side, and the energy would drift (Hairer, McLachlan,
 * Razakarivony 2008). */
static int symplectic_converge(struct symplectic_system *system, const struct symplectic_lanes *s,
                               const struct symplectic_state *from, num weight) {
    enum { ITERATIONS = 100, WINDOW = 8 };
    // the momentum of an arm is a sum over its sub-tree, and has the rounding error of that sum
    double last = INFINITY, size = 0, near = 1e-12 * (system->n > 8 ? system->n / 8.0 : 1);
    // in a chain of thousands of arms, rounding stops the convergence earlier, and the only sign is
    // that the changes no longer decrease
    double noise = fmin(1e-6, 4e-15 * system->n * system->n), least = INFINITY, earlier = INFINITY;
    for (int i = 0; i < ITERATIONS; i++) {
        double change = symplectic_iterate(system, s, from, weight);
        system->iterations++;
        // after the first iteration, values that are not finite mean that the stages do not
        // converge
        if (isnan(change)) return i ? 0 : -1;
        if (i == 0)
            for (int k = 0; k < system->n; k++)
                for (int j = 0; j < WIDTH; j++) size = fmax(size, fabs(s->turn[k][j]));
        size = fmax(size, change);
        least = fmin(least, change);
        int over = i % WINDOW == WINDOW - 1,
            still = over && least > 0.7 * earlier && least <= noise * size;
        if (over) earlier = least, least = INFINITY;
        if (change == 0 || still || (change >= last && change <= near * size)) {
            symplectic_iterate(system, s, from, weight);
            system->iterations++;
            return 1;
        }
        last = change;
    }
    return 0;
}

/* high + low + the sum over the stages, to the digits of two doubles */
static void symplectic_sum(double high, double low, num gain, double *to, double *to_low) {
    for (int j = 0; j < GAUSS_STAGES; j++) {
        double sum = high + gain[j], part = sum - high;
        low += (high - (sum - part)) + (gain[j] - part);
        high = sum;
    }
    *to = high + low;
    *to_low = low - (*to - high);
}

static int symplectic_step(struct symplectic_system *system, const struct symplectic_state *from,
                           const struct symplectic_state *to) {
    struct symplectic_lanes s = symplectic_view(system);
    num weight;
    memcpy(&weight, system->weight, sizeof weight);
    int good = symplectic_converge(system, &s, from, weight);
    if (good <= 0) return good;
    for (int k = 0; k < system->n; k++) {
        symplectic_sum(from->phi[k], from->phi_low[k], s.turn[k], &to->phi[k], &to->phi_low[k]);
        symplectic_sum(from->p[k], from->p_low[k], s.boost[k], &to->p[k], &to->p_low[k]);
        // the first guess for the next step
        num turn = num_of(0), push = num_of(0);
        for (int j = 0; j < GAUSS_STAGES; j++) {
            turn = num_fma(num_of(s.turn[k][j]), *(const num *)gauss_onward[j], turn);
            push = num_fma(num_of(s.boost[k][j]), *(const num *)gauss_onward[j], push);
        }
        s.turn[k] = turn;
        s.boost[k] = push;
    }
    return 1;
}

static void symplectic_momenta(const struct symplectic_system *system, const double phi[],
                               const double rate[], double p[]) {
    struct symplectic_lanes s = symplectic_view(system);
    for (int k = 0; k < system->n; k++) {
        s.phi[k] = num_of(phi[k]);
        s.phi_low[k] = num_of(0);
        s.rate[k] = num_of(rate[k]);
    }
    symplectic_place(&s);
    symplectic_flow(&s);
    // p = l Im(conj(u) P)
    for (int k = 0; k < system->n && s.real; k++) p[k] = s.body.couple_y[k][0];
    for (int k = 0; k < system->n && !s.real; k++)
        p[k] = (s.tree.len[k] * (s.up_re[k] * s.go_im[k] - s.up_im[k] * s.go_re[k]))[0];
}

static void symplectic_rates(const struct symplectic_system *system,
                             const struct symplectic_state *state, double rate[]) {
    struct symplectic_lanes s = symplectic_view(system);
    for (int k = 0; k < system->n; k++) {
        s.phi[k] = num_of(state->phi[k]);
        s.phi_low[k] = num_of(state->phi_low[k]);
        s.tree.drag_im[k] = num_of(state->p[k] + state->p_low[k]);
    }
    symplectic_place(&s);
    symplectic_solve(&s);
    for (int k = 0; k < system->n; k++) rate[k] = s.rate[k][0];
}

const struct symplectic_kernel KERNEL_NAME(pend_kernel_symplectic_) = {
    .count = symplectic_count,
    .load = symplectic_load,
    .momenta = symplectic_momenta,
    .rates = symplectic_rates,
    .step = symplectic_step,
};
