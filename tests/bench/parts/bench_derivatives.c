/* Eight derivatives of a chain's motion of 5 s, compared with the motion alone and with eight
 * members of an ensemble in lanes, which one-sided differences would need; for a double pendulum,
 * compared with automatic differentiation in GSL's rk8pd, at a tolerance with which both have 10
 * digits. The arms are the paper's; rods have mass and damped joints.
 * Leaves to others: correctness (tests/core/derivatives). Invariant: all lines with the same number
 * of arms start from the same state; the parameters are the first arms' angles, rates, lengths and
 * masses, and gravity. */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <string.h>

#include "core/derivatives/derivatives.h"
#include "core/integrate/run/run.h"
#include "tests/bench/parts/bench.h"
#include "tests/harness/ensembles.h"

enum { ARMS = 16, MEMBERS = 8 };

static const double duration = 5, gravity = 9.81, tolerance = 1e-14;

static double begin_phi(int k) { return -1 + 0.3 * k; }

static struct pend_tree *chain(int n) {
    double length[ARMS], mass[ARMS];
    int parent[ARMS];
    struct pend_tree *tree;
    for (int k = 0; k < n; k++) length[k] = 1, mass[k] = 1 + 0.01 * k, parent[k] = k - 1;
    if (pend_tree_new(&tree, n, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    return tree;
}

/* the loads of a chain: gravity alone, or rods and damped joints too */
struct loaded {
    struct pend_loads loads;
    struct pend_terms *terms;
    double value[2 * ARMS];
};

static void load(struct loaded *on, const struct pend_tree *tree, int real) {
    unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_ROD] = 1, [PEND_TERM_DAMPING] = 1};
    static const unsigned char ones[PEND_TERM_ONES];
    *on = (struct loaded){.loads.gravity = gravity};
    if (!real) return;
    if (pend_terms_new(&on->terms, tree->n, rows, ones, 0, NULL, NULL) != PEND_OK)
        bench_broken("terms");
    pend_terms_clear(on->terms, tree, on->value);
    for (int k = 0; k < tree->n; k++) {
        on->value[on->terms->row[PEND_TERM_ROD] + k] = 0.5;
        on->value[on->terms->row[PEND_TERM_DAMPING] + k] = 0.01;
    }
    on->loads.terms = on->terms, on->loads.value = on->value;
}

static struct pend_problem problem_of(const struct pend_tree *tree, const struct loaded *on,
                                      double phi[], double rate[]) {
    for (int k = 0; k < tree->n; k++) phi[k] = begin_phi(k), rate[k] = 0.2;
    return (struct pend_problem){.tree = tree,
                                 .loads = on->loads,
                                 .phi = phi,
                                 .rate = rate,
                                 .times = {.count = 2, .span = duration, .divisor = 1},
                                 .rtol = tolerance};
}

static void plain(struct bench *bench, int n, int real) {
    double phi[ARMS], rate[ARMS], t[2], out[2][2 * ARMS];
    struct pend_tree *tree = chain(n);
    struct loaded on;
    load(&on, tree, real);
    struct pend_problem problem = problem_of(tree, &on, phi, rate);
    while (bench_go(bench, 1)) {
        struct pend_samples samples = {.cap = 2, .t = t, .phi = out[0], .rate = out[1]};
        struct pend_run *run;
        int done = 0;
        if (pend_run_new(&run, &pend_method_taylor, &problem, NULL) != PEND_OK ||
            pend_run_next(run, &samples, INFINITY, &done, NULL) != PEND_OK || !done)
            bench_broken("run");
        pend_run_free(&run);
    }
    pend_terms_free(&on.terms);
    pend_tree_free(&tree);
}

/* the parameters, arm by arm: angle, rate, length, mass; with one arm the fifth is gravity, and the
 * others repeat the angle */
static int parameters(int n, int count, struct pend_parameter by[]) {
    for (int i = 0; i < count; i++) {
        by[i] = (struct pend_parameter){(enum pend_parameter_kind)(i % 4), i / 4};
        if (i / 4 == n) by[i] = (struct pend_parameter){PEND_PARAMETER_GRAVITY, 0};
        if (i / 4 == n && i % 4) by[i] = (struct pend_parameter){PEND_PARAMETER_PHI, 0};
    }
    return count;
}

/* computes the derivatives of the final angles with respect to `count` parameters, [arm * count +
 * parameter] of the second row */
static void derive(const struct pend_problem *problem, int count, double slope[]) {
    struct pend_parameter by[64];
    struct pend_derivatives *derivatives;
    struct pend_derived_rows rows = {.derivative = {slope}};
    long made = 0;
    parameters(problem->tree->n, count, by);
    if (pend_derivatives_new(&derivatives, problem, count, by, NULL) != PEND_OK ||
        pend_derivatives_next(derivatives, &rows, 2, INFINITY, &made, NULL) != PEND_OK || made != 2)
        bench_broken("derivatives");
    pend_derivatives_free(&derivatives);
}

static void derived(struct bench *bench, int n, int count, int real) {
    double phi[ARMS], rate[ARMS];
    static double slope[2 * ARMS * 64];
    struct pend_tree *tree = chain(n);
    struct loaded on;
    load(&on, tree, real);
    struct pend_problem problem = problem_of(tree, &on, phi, rate);
    while (bench_go(bench, 1)) derive(&problem, count, slope);
    pend_terms_free(&on.terms);
    pend_tree_free(&tree);
}

static int member(void *context, long i, struct pend_member *member) {
    const struct pend_tree *tree = context;
    for (int k = 0; k < tree->n; k++) member->phi[k] = begin_phi(k), member->rate[k] = 0.2;
    member->phi[0] += 1e-6 * (double)(i % MEMBERS);
    return 0;
}

static int drop(void *context, long i, const struct pend_outcome *outcome) {
    (void)context, (void)i;
    return outcome->status != PEND_OK;
}

static void members(struct bench *bench, int n, int real) {
    struct pend_tree *tree = chain(n);
    struct loaded on;
    load(&on, tree, real);
    struct pend_ensemble_problem problem = {.tree = tree,
                                            .loads = on.loads,
                                            .duration = duration,
                                            .rtol = tolerance,
                                            .fetch = member,
                                            .deliver = drop,
                                            .context = tree};
    struct pend_ensemble *work;
    if (pend_ensemble_new(&work, &problem, pend_isa_best(), NULL) != PEND_OK)
        bench_broken("ensemble");
    while (bench_go(bench, 1))
        if (test_ensemble_run(work, 0, MEMBERS) != PEND_OK) bench_broken("ensemble");
    pend_ensemble_free(&work);
    pend_terms_free(&on.terms);
    pend_tree_free(&tree);
}

#define LINES(n)                                                                                   \
    BENCH(derivatives_##n##_arms_plain, "run") { plain(bench, n, 0); }                             \
    BENCH(derivatives_##n##_arms_by_8, "run") { derived(bench, n, 8, 0); }                         \
    BENCH(derivatives_##n##_arms_8_members, "8 members") { members(bench, n, 0); }                 \
    BENCH(derivatives_##n##_rods_plain, "run") { plain(bench, n, 1); }                             \
    BENCH(derivatives_##n##_rods_by_8, "run") { derived(bench, n, 8, 1); }                         \
    BENCH(derivatives_##n##_rods_8_members, "8 members") { members(bench, n, 1); }
LINES(1)
LINES(2)
LINES(3)
LINES(4)
LINES(8)
LINES(16)

/* ---- the peer: a double pendulum computed with dual numbers that have eight derivatives */

enum { DUALS = 9 };

typedef struct {
    double x[DUALS];
} dual;

static dual dual_of(double x, int parameter) {
    dual r = {{x}};
    if (parameter >= 0) r.x[1 + parameter] = 1;
    return r;
}

static dual dual_add(dual a, dual b) {
    for (int i = 0; i < DUALS; i++) a.x[i] += b.x[i];
    return a;
}

static dual dual_scale(dual a, double factor) {
    for (int i = 0; i < DUALS; i++) a.x[i] *= factor;
    return a;
}

static dual dual_mul(dual a, dual b) {
    dual r = {{a.x[0] * b.x[0]}};
    for (int i = 1; i < DUALS; i++) r.x[i] = a.x[0] * b.x[i] + b.x[0] * a.x[i];
    return r;
}

static dual dual_div(dual a, dual b) {
    dual r = {{a.x[0] / b.x[0]}};
    double inverse = 1 / b.x[0];
    for (int i = 1; i < DUALS; i++) r.x[i] = (a.x[i] - r.x[0] * b.x[i]) * inverse;
    return r;
}

static dual dual_chain(dual a, double value, double slope) {
    dual r = dual_scale(a, slope);
    r.x[0] = value;
    return r;
}

/* M(phi) phi'' = f of two arms by Cramer's rule; y: phi_1, phi_2, phi_1', phi_2' and the
 * derivatives of each */
static int peer_equations(double t, const double y[], double to[], void *context) {
    dual state[4], len[2], mass[2], arm[2], acc[2];
    (void)t, (void)context;
    memcpy(state, y, sizeof state);
    for (int k = 0; k < 2; k++)
        len[k] = dual_of(1, 4 * k + 2), mass[k] = dual_of(1 + 0.01 * k, 4 * k + 3);
    dual all = dual_add(mass[0], mass[1]), gap = dual_add(state[0], dual_scale(state[1], -1));
    double c = cos(gap.x[0]), s = sin(gap.x[0]);
    dual both = dual_mul(mass[1], dual_mul(len[0], len[1]));
    dual across = dual_mul(both, dual_chain(gap, s, c));
    dual a = dual_mul(all, dual_mul(len[0], len[0])), b = dual_mul(both, dual_chain(gap, c, -s));
    dual d = dual_mul(mass[1], dual_mul(len[1], len[1]));
    for (int k = 0; k < 2; k++) {
        double x = state[k].x[0];
        dual weight = dual_mul(k ? mass[1] : all, len[k]), other = state[3 - k];
        arm[k] = dual_scale(dual_mul(weight, dual_chain(state[k], cos(x), -sin(x))), -gravity);
        dual turned = dual_mul(across, dual_mul(other, other));
        arm[k] = dual_add(arm[k], dual_scale(turned, k ? 1 : -1));
    }
    dual det = dual_add(dual_mul(a, d), dual_scale(dual_mul(b, b), -1));
    acc[0] = dual_add(dual_mul(d, arm[0]), dual_scale(dual_mul(b, arm[1]), -1));
    acc[1] = dual_add(dual_mul(a, arm[1]), dual_scale(dual_mul(b, arm[0]), -1));
    for (int k = 0; k < 2; k++) acc[k] = dual_div(acc[k], det);
    memcpy(to, state + 2, 2 * sizeof(dual));
    memcpy(to + 2 * DUALS, acc, 2 * sizeof(dual));
    return GSL_SUCCESS;
}

/* the comparison is meaningful only if the peer's answer has as many digits as ours */
static void peer_same(const dual end[4]) {
    double phi[ARMS], rate[ARMS], slope[2 * 2 * 8];
    struct pend_tree *tree = chain(2);
    struct loaded on;
    load(&on, tree, 0);
    struct pend_problem problem = problem_of(tree, &on, phi, rate);
    derive(&problem, 8, slope);
    for (int i = 0; i < 16; i++) {
        double own = slope[16 + i], other = end[i / 8].x[1 + i % 8];
        if (!(fabs(own - other) <= 1e-10 * (1 + fabs(own)))) bench_broken("derivatives differ");
    }
    pend_tree_free(&tree);
}

BENCH(derivatives_2_arms_by_8_duals_in_rk8pd, "run") {
    dual y[4];
    gsl_odeiv2_system system = {peer_equations, NULL, 4 * DUALS, NULL};
    gsl_odeiv2_driver *driver =
        gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-2, 1e-12, 1e-12);
    if (!driver) bench_broken("memory");
    while (bench_go(bench, 1)) {
        double t = 0;
        for (int k = 0; k < 2; k++) y[k] = dual_of(begin_phi(k), 4 * k);
        for (int k = 0; k < 2; k++) y[2 + k] = dual_of(0.2, 4 * k + 1);
        if (gsl_odeiv2_driver_reset_hstart(driver, 1e-2) ||
            gsl_odeiv2_driver_apply(driver, &t, duration, (double *)(void *)y))
            bench_broken("rk8pd");
    }
    peer_same(y);
    gsl_odeiv2_driver_free(driver);
}
