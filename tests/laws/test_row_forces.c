/* Laws: the forces in the rows of runs and of ensembles are as accurate as those of a state, also
 * if masses differ much and a series would lose digits. Leaves to others: forces of states
 * (test_bodies_quad, core/dynamics), events (core/integrate). Invariant: residuals are relative to
 * the largest force at any end of any arm. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 16, ROWS = 5, ENDS = 4 };

/* one row, stored order; forces: lambda, along and across at the joint, across at the tip */
struct row {
    double phi[ARMS], rate[ARMS], force[ENDS][ARMS];
};

/* the larger of two errors, or NaN if one is */
static double worse(double a, double b) { return b <= a ? a : b; }

/* the largest error of a row's forces over the largest force */
static double row_gap(const struct pend_tree *tree, const struct pend_loads *loads, double time,
                      const struct row *row) {
    test_quad exact[ENDS][ARMS], acc[ARMS], phi[ARMS], rate[ARMS];
    double most = 0, gap = 0;
    for (int k = 0; k < tree->n; k++) phi[k] = row->phi[k], rate[k] = row->rate[k];
    struct test_quad_state state = {phi, rate, time};
    struct test_quad_forces forces = {exact[1], exact[2], exact[0], exact[3]};
    if (loads->terms)
        test_quad_bodies(tree, loads, &state, acc, &forces);
    else
        test_quad_dynamics(tree, loads, row->phi, row->rate, acc, exact[0]);
    for (int i = 0; i < ENDS; i++)
        for (int k = 0; k < tree->n; k++) {
            // the forces at both ends of an ideal arm are equal along it, and 0 across
            test_quad here = loads->terms || !i ? exact[i][k] : i == 1 ? exact[0][k] : 0;
            most = fmax(most, (double)test_quad_abs(here));
            gap = worse(gap, (double)test_quad_abs(row->force[i][k] - here));
        }
    return gap / most;
}

/* the largest error of the rows within the first steps */
static double run_gap(const struct test_tree *t, const struct pend_loads *loads) {
    static double phi[ROWS * ARMS], rate[ROWS * ARMS], force[ENDS][ROWS * ARMS], time[ROWS];
    struct pend_samples samples = {.cap = ROWS,
                                   .t = time,
                                   .phi = phi,
                                   .rate = rate,
                                   .force = force[0],
                                   .joint_along = force[1],
                                   .joint_across = force[2],
                                   .across = force[3]};
    const struct pend_problem problem = {
        .tree = t->tree,
        .loads = *loads,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = ROWS, .start = 3, .span = 0x1p-9, .divisor = 1},
        .rtol = 1e-16};
    struct pend_run *run;
    double worst = 0;
    int done = 0;
    if (pend_run_new(&run, &pend_method_taylor, &problem, NULL) != PEND_OK) return NAN;
    enum pend_status status = pend_run_next(run, &samples, 1e12, &done, NULL);
    pend_run_free(&run);
    if (status != PEND_OK || !done) return NAN;
    for (int i = 1; i < ROWS; i++) {
        struct row row;
        for (int k = 0; k < t->n; k++) {
            int at = i * t->n + t->tree->order[k];
            row.phi[k] = phi[at], row.rate[k] = rate[at];
            for (int j = 0; j < ENDS; j++) row.force[j][k] = force[j][at];
        }
        worst = worse(worst, row_gap(t->tree, loads, time[i], &row));
    }
    return worst;
}

/* spreads the masses of rods and bodies over 10^±decades */
static void rods_spread(const struct test_bodies *b, double decades, unsigned long long *seed) {
    const int *row = b->terms->row;
    for (int k = 0; k < b->terms->n && row[PEND_TERM_ROD] >= 0; k++) {
        double body = pow(10, decades * (2 * test_random(seed) - 1));
        b->value[row[PEND_TERM_ROD] + k] *= pow(10, decades * (2 * test_random(seed) - 1));
        b->value[row[PEND_TERM_BODY] + k] *= body;
        b->value[row[PEND_TERM_INERTIA] + k] *= body;
    }
}

/* the largest error on random trees of all kinds; terms 0: ideal ones */
static double trees_gap(unsigned terms, double decades, int count, unsigned long long *seed) {
    double worst = 0;
    for (int i = 0; i < count; i++) {
        OWN(test_tree, clear) t;
        int n = 2 + test_random_int(seed, 12);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, decades, seed);
        if (terms) {
            OWN(test_bodies, clear) b;
            test_bodies_random(&b, t.tree, terms, seed);
            rods_spread(&b, decades, seed);
            worst = worse(worst, run_gap(&t, &b.loads));
        } else {
            worst = worse(worst, run_gap(&t, TEST_LOADS(9.81)));
        }
    }
    return worst;
}

TEST(law_rows_have_the_forces_of_quadruple_precision_where_masses_are_unlike) {
    enum { KINDS = 8, MANY = 280, SOME = 42 };
    static const struct {
        double decades, ideal, points, rods;
        const char *told[3];
    } far[] = {{0.3, 2e-13, 2e-13, 2e-13, {"of 10^-0.3 to 10^0.3 kg", "loaded", "with rods"}},
               {2, 2e-13, 1e-12, 2e-13, {"of 10^-2 to 10^2 kg", "loaded", "with rods"}},
               {4, 2e-13, 2e-12, 1e-12, {"of 10^-4 to 10^4 kg", "loaded", "with rods"}},
               {6, 1e-12, 2e-10, 3e-12, {"of 10^-6 to 10^6 kg", "loaded", "with rods"}}};
    unsigned long long seed = 41;
    for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
        double decades = far[i].decades, points = 0;
        double ideal = trees_gap(0, decades, MANY, &seed);
        for (int bit = 1; bit < KINDS; bit++)
            points = worse(points, trees_gap(1u << bit, decades, SOME, &seed));
        double rods = trees_gap(TEST_TERMS_RODS, decades, SOME, &seed);
        rods = worse(rods, trees_gap(TEST_TERMS_ALL, decades, SOME, &seed));
        CHECK_RESIDUAL(ideal, far[i].ideal, far[i].told[0]);
        CHECK_RESIDUAL(points, far[i].points, far[i].told[1]);
        CHECK_RESIDUAL(rods, far[i].rods, far[i].told[2]);
    }
}

/* a member, and the largest errors of its forces */
struct watched {
    const struct test_tree *t;
    double rows, ends;
};

static int watched_fetch(void *context, long i, struct pend_member *member) {
    const struct watched *w = context;
    memcpy(member->phi, w->t->phi, (size_t)w->t->n * sizeof(double));
    memcpy(member->rate, w->t->rate, (size_t)w->t->n * sizeof(double));
    member->rate[0] += (double)i;
    return 0;
}

static void watched_rows(void *context, long i, long first, int count, const double phi[],
                         const double rate[], const double force[], const double theta[]) {
    struct watched *w = context;
    int n = w->t->n;
    (void)i, (void)theta;
    for (int j = first ? 0 : 1; j < count; j++) {
        test_quad exact[ARMS], acc[ARMS];
        test_quad_dynamics(w->t->tree, TEST_LOADS(9.81), phi + j * n, rate + j * n, acc, exact);
        w->rows = worse(w->rows, test_quad_gap(n, force + j * n, exact));
    }
}

/* extremes at the end of a motion are the forces of the end */
static int watched_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct watched *w = context;
    test_quad exact[ARMS], acc[ARMS];
    double most = 0, gap = 0;
    (void)i;
    CHECK(outcome->status == PEND_OK);
    test_quad_dynamics(w->t->tree, TEST_LOADS(9.81), outcome->phi, outcome->rate, acc, exact);
    for (int k = 0; k < w->t->n; k++) {
        double force = (double)exact[k];
        most = fmax(most, fabs(force));
        if (outcome->force.most_time[k] == outcome->time)
            gap = worse(gap, fabs(outcome->force.most[k] - force));
        if (outcome->force.least_time[k] == outcome->time)
            gap = worse(gap, fabs(outcome->force.least[k] - force));
    }
    w->ends = worse(w->ends, gap / most);
    return 0;
}

TEST(law_rows_and_extremes_of_members_have_the_forces_of_quadruple_precision) {
    enum { TREES = 84 };
    static const double times[ROWS] = {0, 0x1p-9, 0x1p-8, 0x1.8p-8, 0x1p-7};
    static const struct {
        double decades, bound;
        const char *told[2];
    } far[] = {{0.3, 2e-13, {"rows of 10^-0.3 to 10^0.3 kg", "extremes"}},
               {6, 1e-12, {"rows of 10^-6 to 10^6 kg", "extremes"}}};
    unsigned long long seed = 43;
    for (size_t j = 0; j < sizeof far / sizeof *far; j++) {
        struct watched w = {NULL, 0, 0};
        for (int i = 0; i < TREES; i++) {
            OWN(test_tree, clear) t;
            OWN(pend_ensemble, free) *e;
            test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                             2 + test_random_int(&seed, 11), far[j].decades, &seed);
            w.t = &t;
            const struct pend_ensemble_problem problem = {.tree = t.tree,
                                                          .loads = *TEST_LOADS(9.81),
                                                          .duration = times[ROWS - 1],
                                                          .rtol = 1e-16,
                                                          .observe = PEND_OBSERVE_EXTREMES,
                                                          .times = times,
                                                          .times_count = ROWS,
                                                          .fetch = watched_fetch,
                                                          .deliver = watched_deliver,
                                                          .rows = watched_rows,
                                                          .context = &w};
            if (!CHECK(pend_ensemble_new(&e, &problem, pend_isa_best(), NULL) == PEND_OK)) return;
            CHECK(test_ensemble_run(e, 0, 3) == PEND_OK);
        }
        CHECK_RESIDUAL(w.rows, far[j].bound, far[j].told[0]);
        CHECK_RESIDUAL(w.ends, far[j].bound, far[j].told[1]);
    }
}
