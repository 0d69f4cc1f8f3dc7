/* Motions of double pendulums over 20 s at round-off accuracy: in an ensemble, one by one, and with
 * GSL on the same O(n) equations; with observables; damped and driven; the usual flip map. Leaves
 * to others: single trajectories. Invariant: all lines start from angles near (2, 2.5); one core;
 * the figure is ns per member: 66 667 is 15 000 members per second. */
#include <math.h>

#include "core/integrate/run/run.h"
#include "tests/bench/parts/bench.h"
#include "tests/harness/ensembles.h"

enum { MEMBERS = 64, SIDE = 256 };

static const double duration = 20;

static struct pend_tree *pendulum(int n) {
    double length[64], mass[64];
    int parent[64];
    struct pend_tree *tree;
    for (int k = 0; k < n; k++) {
        length[k] = mass[k] = n == 2 ? 1 : 1.0 / n;
        parent[k] = k - 1;
    }
    if (pend_tree_new(&tree, n, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    return tree;
}

static void start(long i, double phi[2]) {
    phi[0] = 2 + 1e-3 * (double)(i % 1000) - M_PI_2;
    phi[1] = 2.5 - M_PI_2;
}

static int near_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    start(i, member->phi);
    return 0;
}

static int alone_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    member->phi[0] = 2 + 1e-3 * (double)(i % 1000) - M_PI_2;
    return 0;
}

/* members spread over the whole map */
static int map_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    long place = i * 40503 % ((long)SIDE * SIDE);
    member->phi[0] = 2 * M_PI * ((double)(place % SIDE) + 0.5) / SIDE - 1.5 * M_PI;
    member->phi[1] = 2 * M_PI * ((double)place / SIDE + 0.5 / SIDE) / SIDE - 1.5 * M_PI;
    return 0;
}

static int rest_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    member->phi[0] = 1e-3 * (double)i;
    return 0;
}

static int drop(void *context, long i, const struct pend_outcome *outcome) {
    (void)context, (void)i;
    return outcome->status != PEND_OK;
}

static void ensemble(struct bench *bench, struct pend_ensemble_problem problem, int n,
                     long members) {
    struct pend_tree *tree = pendulum(n);
    struct pend_ensemble *work;
    problem.tree = tree;
    problem.loads.gravity = 9.81;
    problem.deliver = drop;
    if (pend_ensemble_new(&work, &problem, pend_isa_best(), NULL) != PEND_OK)
        bench_broken("ensemble");
    long first = 0;
    while (bench_go(bench, members)) {
        if (test_ensemble_run(work, first, members) != PEND_OK) bench_broken("ensemble");
        first += members;
    }
    pend_ensemble_free(&work);
    pend_tree_free(&tree);
}

static struct pend_ensemble_problem near_problem(unsigned observe, double bound) {
    return (struct pend_ensemble_problem){.duration = duration,
                                          .rtol = 1e-15,
                                          .fetch = near_fetch,
                                          .observe = observe,
                                          .bound = bound};
}

BENCH(ensemble_20_s, "member") { ensemble(bench, near_problem(0, 0), 2, 8 * MEMBERS); }
BENCH(ensemble_20_s_flips, "member") { ensemble(bench, near_problem(0, M_PI), 2, 8 * MEMBERS); }
BENCH(ensemble_20_s_extremes, "member") {
    ensemble(bench, near_problem(PEND_OBSERVE_EXTREMES, 0), 2, 8 * MEMBERS);
}
BENCH(ensemble_20_s_signs, "member") {
    ensemble(bench, near_problem(PEND_OBSERVE_SIGNS, 0), 2, 8 * MEMBERS);
}
BENCH(ensemble_20_s_lyapunov, "member") {
    ensemble(bench, near_problem(PEND_OBSERVE_LYAPUNOV, 0), 2, 4 * MEMBERS);
}

BENCH(ensemble_flip_map, "member") {
    struct pend_ensemble_problem problem = {
        .duration = duration, .rtol = 1e-15, .fetch = map_fetch, .bound = M_PI};
    problem.until = PEND_UNTIL_FIRST;
    problem.spare = 1;
    ensemble(bench, problem, 2, 64 * MEMBERS);
}

BENCH(ensemble_32_arms_1_s, "member") {
    ensemble(bench,
             (struct pend_ensemble_problem){.duration = 1, .rtol = 1e-9, .fetch = rest_fetch}, 32,
             16);
}

/* each member has its own damping and drive, with amplitudes and frequencies over the range of a
 * resonance map */
static int driven_fetch(void *context, long i, struct pend_member *member) {
    const struct pend_terms *terms = member->loads.terms;
    (void)context;
    member->phi[0] = 2 + 1e-3 * (double)(i % 1000) - M_PI_2;
    for (int k = 1; k < terms->n; k++) member->phi[k] = 2.5 - M_PI_2;
    for (int k = 0; k < terms->n; k++)
        member->value[terms->row[PEND_TERM_DAMPING] + k] = 0.05 + 0.05 * (double)(i % 7);
    double *drive = member->value + terms->harmonic[0].at;
    drive[0] = 3 + 0.5 * (double)(i % 13), drive[1] = 1.5 + 0.1 * (double)(i % 17);
    return 0;
}

/* the same with a shaken pivot: a map of Kapitza's pendulum */
static int shaken_fetch(void *context, long i, struct pend_member *member) {
    const struct pend_terms *terms = member->loads.terms;
    (void)context;
    member->phi[0] = 0.1 + 1e-4 * (double)(i % 1000) + M_PI_2;
    for (int k = 0; k < terms->n; k++)
        member->value[terms->row[PEND_TERM_DAMPING] + k] = 0.05 + 0.05 * (double)(i % 7);
    double *drive = member->value + terms->harmonic[0].at;
    drive[0] = 0.2 + 0.02 * (double)(i % 13), drive[1] = 12 + 0.5 * (double)(i % 17);
    return 0;
}

/* damped driven chains, and ideal ones with the same initial states */
static void driven(struct bench *bench, int n, int real) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    const int first = real < 2 ? 0 : PEND_DRIVE_PIVOT_Y;
    int place;
    double value[8] = {0};
    struct pend_terms *terms;
    struct pend_ensemble_problem problem = near_problem(0, 0);
    rows[PEND_TERM_DAMPING] = 1;
    if (pend_terms_new(&terms, n, rows, ones, 1, &first, &place) != PEND_OK) bench_broken("terms");
    if (real) {
        problem.loads.terms = terms, problem.loads.value = value;
        problem.fetch = real < 2 ? driven_fetch : shaken_fetch;
    } else {
        problem.fetch = n == 2 ? near_fetch : alone_fetch;
    }
    ensemble(bench, problem, n, 8 * MEMBERS);
    pend_terms_free(&terms);
}

BENCH(ensemble_20_s_one_arm, "member") { driven(bench, 1, 0); }
BENCH(ensemble_20_s_one_arm_damped_driven, "member") { driven(bench, 1, 1); }
BENCH(ensemble_20_s_one_arm_damped_shaken, "member") { driven(bench, 1, 2); }
BENCH(ensemble_20_s_damped_driven, "member") { driven(bench, 2, 1); }

/* the same members by a method of single trajectories */
static void singly(struct bench *bench, const char *name, double tolerance) {
    struct pend_tree *tree = pendulum(2);
    long i = 0;
    while (bench_go(bench, 1)) {
        double t[2], phi[4], rate[4], from[2], rest[2] = {0, 0};
        struct pend_problem problem = {
            .tree = tree, .loads.gravity = 9.81, .phi = from, .rate = rest};
        struct pend_samples samples = {.cap = 2, .t = t, .phi = phi, .rate = rate};
        struct pend_run *run;
        int done = 0;
        start(i++, from);
        problem.times = (struct pend_times){.count = 2, .span = duration, .divisor = 1};
        problem.rtol = problem.atol = tolerance;
        if (pend_run_new(&run, pend_method_find(name), &problem, NULL) != PEND_OK)
            bench_broken(name);
        while (!done)
            if (pend_run_next(run, &samples, 1e9, &done, NULL) != PEND_OK) bench_broken(name);
        pend_run_free(&run);
    }
    pend_tree_free(&tree);
}

BENCH(singly_taylor_20_s, "member") { singly(bench, "taylor", 1e-15); }
BENCH(singly_rk8pd_20_s, "member") { singly(bench, "rk8pd", 1e-14); }
