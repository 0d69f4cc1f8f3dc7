/* Real pendulums compared with ideal ones of the same arms: a series to order 20, and runs of 5 s
 * by power series and by GSL's rk8pd on the same O(n) equations, at a tolerance of 1e-12.
 * Leaves to others: ideal trees against other programs (bench_dynamics, bench_trajectories).
 * Invariant: the same trees and numbers every time; loads are light, so that all variants of a tree
 * move similarly and their times are comparable. */
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "core/taylor/jets/jets.h"
#include "tests/bench/parts/bench.h"
#include "tests/harness/ensembles.h"

enum { ARMS_MAX = 1000, ORDER = 20 };

/* the loads that make a pendulum real */
enum kind { IDEAL, COUPLES, PIVOT, BOTH, RODS, LOADED, EVERYTHING };

/* a chain; a tree in which the parent of each arm is one of the three before it; the complete
 * binary tree; a tree in which the first arm is the parent of all others */
enum shape { CHAIN, LIMBS, BINARY, STAR };

struct subject {
    struct pend_tree *tree;
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
    _Alignas(64) double phi[ARMS_MAX], rate[ARMS_MAX], zero[ARMS_MAX];
};

static void subject_fill(struct subject *s, enum pend_term_row row, double number) {
    int at = s->terms->row[row];
    for (int k = 0; k < s->terms->n && at >= 0; k++) s->value[at + k] = number;
}

static void subject_terms(struct subject *s, int n, enum kind kind) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int drives[2] = {PEND_DRIVE_PIVOT_Y, 0}, place[2], all = kind == EVERYTHING;
    int loaded = kind == LOADED, harmonics = all ? 2 : kind == PIVOT || kind == BOTH || loaded;
    rows[PEND_TERM_DAMPING] = rows[PEND_TERM_STIFFNESS] =
        kind == COUPLES || kind == BOTH || loaded || all;
    rows[PEND_TERM_ROD] = kind == RODS || loaded || all;
    rows[PEND_TERM_FRICTION] = rows[PEND_TERM_DRAG] = rows[PEND_TERM_DRAG_QUADRATIC] = all;
    ones[PEND_TERM_DRAG_PER_MASS] = all;
    if (pend_terms_new(&s->terms, n, rows, ones, harmonics, drives, place) != PEND_OK)
        bench_broken("terms");
    s->value = calloc((size_t)s->terms->count + 1, sizeof *s->value);
    if (!s->value) bench_broken("memory");
    pend_terms_clear(s->terms, s->tree, s->value);
    subject_fill(s, PEND_TERM_DAMPING, 0.01);
    subject_fill(s, PEND_TERM_STIFFNESS, 0.1);
    subject_fill(s, PEND_TERM_ROD, 0.5);
    subject_fill(s, PEND_TERM_FRICTION, 0.01);
    subject_fill(s, PEND_TERM_DRAG, 0.01);
    subject_fill(s, PEND_TERM_DRAG_QUADRATIC, 0.01);
    if (all) s->value[s->terms->one[PEND_TERM_DRAG_PER_MASS]] = 0.01;
    for (int i = 0; i < harmonics; i++) {
        double *h = s->value + s->terms->harmonic[i].at;
        h[0] = 0.02, h[1] = 5, h[2] = 0;
    }
    s->loads.terms = s->terms, s->loads.value = s->value;
}

static int subject_parent(enum shape shape, int k, unsigned *state) {
    *state = *state * 1664525u + 1013904223u;
    if (shape == STAR) return k ? 0 : -1;
    if (shape == BINARY) return (k + 1) / 2 - 1;
    return shape == CHAIN || k < 3 ? k - 1 : k - 1 - (int)((*state >> 16) % 3);
}

static void subject_open(struct subject *s, int n, enum shape shape, enum kind kind) {
    double length[ARMS_MAX], mass[ARMS_MAX];
    int parent[ARMS_MAX];
    unsigned state = 1;
    memset(s, 0, sizeof *s);
    for (int k = 0; k < n; k++) {
        parent[k] = subject_parent(shape, k, &state);
        length[k] = 1, mass[k] = 1 + 0.01 * k;
        s->phi[k] = -1 + 0.3 * k, s->rate[k] = 0.2;
    }
    if (pend_tree_new(&s->tree, n, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    s->loads.gravity = 9.81;
    if (kind != IDEAL) subject_terms(s, n, kind);
}

static void subject_close(struct subject *s) {
    pend_tree_free(&s->tree);
    pend_terms_free(&s->terms);
    free(s->value);
}

static void series(struct bench *bench, int n, enum shape shape, enum kind kind) {
    struct subject s;
    struct pend_jets jets;
    subject_open(&s, n, shape, kind);
    size_t bytes = pend_jets_bytes(s.tree, s.terms, ORDER);
    void *memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!memory) bench_broken("memory");
    struct jets_state state = {
        .phi = s.phi, .phi_low = s.zero, .rate = s.rate, .rate_low = s.zero, .time = 1};
    pend_jets_init(&jets, s.tree, &s.loads, ORDER, memory);
    while (bench_go(bench, 1)) pend_jets_expand(&jets, &s.loads, 0.0625, &state, ORDER);
    if (!(jets.rate[pend_jets_place(&jets, 0, 1)] != 0)) bench_broken("series");
    free(memory);
    subject_close(&s);
}

static void run(struct bench *bench, int n, enum shape shape, enum kind kind, const char *name) {
    static double t[2], phi[2 * ARMS_MAX], rate[2 * ARMS_MAX];
    struct subject s;
    subject_open(&s, n, shape, kind);
    struct pend_problem problem = {
        .tree = s.tree, .loads = s.loads, .phi = s.phi, .rate = s.rate, .atol_given = 1};
    problem.times = (struct pend_times){.count = 2, .span = 5, .divisor = 1};
    problem.rtol = problem.atol = 1e-12;
    while (bench_go(bench, 1)) {
        struct pend_samples samples = {.cap = 2, .t = t, .phi = phi, .rate = rate};
        struct pend_run *one;
        int done = 0;
        if (pend_run_new(&one, pend_method_find(name), &problem, NULL) != PEND_OK)
            bench_broken(name);
        while (!done)
            if (pend_run_next(one, &samples, 1e9, &done, NULL) != PEND_OK) bench_broken(name);
        pend_run_free(&one);
    }
    subject_close(&s);
}

/* times members of an ensemble, each with its own initial angles */
static int member_fetch(void *context, long i, struct pend_member *member) {
    const struct subject *s = context;
    for (int k = 0; k < s->tree->n; k++) {
        member->phi[k] = s->phi[k] + 1e-3 * (double)(i % 1000);
        member->rate[k] = s->rate[k];
    }
    return 0;
}

static int member_drop(void *context, long i, const struct pend_outcome *outcome) {
    (void)context, (void)i;
    return outcome->status != PEND_OK;
}

static void members(struct bench *bench, int n, enum shape shape, enum kind kind) {
    struct subject s;
    struct pend_ensemble *work;
    long first = 0;
    enum { MEMBERS = 64 };
    subject_open(&s, n, shape, kind);
    struct pend_ensemble_problem problem = {.tree = s.tree,
                                            .loads = s.loads,
                                            .duration = 1,
                                            .rtol = 1e-12,
                                            .fetch = member_fetch,
                                            .context = &s,
                                            .deliver = member_drop};
    if (pend_ensemble_new(&work, &problem, pend_isa_best(), NULL) != PEND_OK)
        bench_broken("ensemble");
    for (; bench_go(bench, MEMBERS); first += MEMBERS)
        if (test_ensemble_run(work, first, MEMBERS) != PEND_OK) bench_broken("ensemble");
    pend_ensemble_free(&work);
    subject_close(&s);
}

#define KINDS(X, ...)                                                                              \
    X(ideal, IDEAL, __VA_ARGS__)                                                                   \
    X(couples, COUPLES, __VA_ARGS__)                                                               \
    X(pivot, PIVOT, __VA_ARGS__) X(rods, RODS, __VA_ARGS__) X(everything, EVERYTHING, __VA_ARGS__)
#define QUICK_KINDS(X, ...)                                                                        \
    X(ideal, IDEAL, __VA_ARGS__)                                                                   \
    X(couples, COUPLES, __VA_ARGS__) X(pivot, PIVOT, __VA_ARGS__) X(both, BOTH, __VA_ARGS__)
#define SOME_KINDS(X, ...)                                                                         \
    X(ideal, IDEAL, __VA_ARGS__)                                                                   \
    X(couples, COUPLES, __VA_ARGS__) X(pivot, PIVOT, __VA_ARGS__) X(rods, RODS, __VA_ARGS__)
#define SERIES(name, kind, n, shape, tree)                                                         \
    BENCH(bodies_series_##tree##_##name, "series") { series(bench, n, shape, kind); }
#define RUN(name, kind, n, shape, tree)                                                            \
    BENCH(bodies_run_##tree##_##name, "run") { run(bench, n, shape, kind, "taylor"); }             \
    BENCH(bodies_run_##tree##_##name##_rk8pd, "run") { run(bench, n, shape, kind, "rk8pd"); }

KINDS(SERIES, 1, CHAIN, arm_1)
KINDS(SERIES, 2, CHAIN, chain_2)
KINDS(SERIES, 6, LIMBS, limbs_6)
KINDS(SERIES, 16, CHAIN, chain_16)
KINDS(SERIES, 40, LIMBS, limbs_40)
QUICK_KINDS(SERIES, 9, CHAIN, chain_9)
QUICK_KINDS(SERIES, 200, CHAIN, chain_200)
QUICK_KINDS(SERIES, 1000, CHAIN, chain_1000)
SOME_KINDS(SERIES, 5, CHAIN, chain_5)
SOME_KINDS(SERIES, 10, CHAIN, chain_10)
SOME_KINDS(SERIES, 20, CHAIN, chain_20)
SOME_KINDS(SERIES, 50, CHAIN, chain_50)
SERIES(rods, RODS, 32, CHAIN, chain_32)
SERIES(ideal, IDEAL, 32, CHAIN, chain_32)
SERIES(loaded_rods, LOADED, 16, CHAIN, chain_16)
SERIES(loaded_rods, LOADED, 50, CHAIN, chain_50)
SERIES(rods, RODS, 200, CHAIN, chain_200)
SERIES(rods, RODS, 1000, CHAIN, chain_1000)
QUICK_KINDS(SERIES, 16, STAR, star_16)
QUICK_KINDS(SERIES, 200, STAR, star_200)
QUICK_KINDS(SERIES, 16, BINARY, binary_16)
QUICK_KINDS(SERIES, 64, BINARY, binary_64)
QUICK_KINDS(SERIES, 1000, BINARY, binary_1000)
QUICK_KINDS(SERIES, 200, LIMBS, limbs_200)
KINDS(RUN, 2, CHAIN, chain_2)
KINDS(RUN, 16, CHAIN, chain_16)
#define MEMBER(name, kind, n, shape, tree)                                                         \
    BENCH(bodies_members_##tree##_##name, "member") { members(bench, n, shape, kind); }
SOME_KINDS(MEMBER, 1, CHAIN, arm_1)
SOME_KINDS(MEMBER, 2, CHAIN, chain_2)
SOME_KINDS(MEMBER, 4, CHAIN, chain_4)
SOME_KINDS(MEMBER, 6, CHAIN, chain_6)
SOME_KINDS(MEMBER, 8, CHAIN, chain_8)
SOME_KINDS(MEMBER, 16, CHAIN, chain_16)
