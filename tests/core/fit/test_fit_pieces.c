/* Tests of fits to several chaotic runs of one pendulum, which are not divided into pieces: a
 * converged fit finds the true pendulum, and others report no minimum. Leaves to others: one run
 * (test_fit). Invariant: motions are random, from seeds; FITS in the environment sets a larger
 * number of them, and prints how many converge. */
#include "core/fit/fit_pieces.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit.h"
#include "core/integrate/run/run.h"
#include "tests/harness/test.h"

enum { ARMS = 2, RUNS = 3, ROWS = 200, ALL = RUNS * ROWS, UNKNOWNS = 3 + 2 * ARMS * RUNS };

static const double span = 10, sigma = 0.02;

/* three motions of a double pendulum, in the columns of common rows */
struct film {
    double length[ARMS], mass[ARMS], phi[RUNS * ARMS], rate[RUNS * ARMS], truth[UNKNOWNS];
    double t[ALL], data[ARMS][ALL];
    int run[ALL];
    struct pend_fit_column column[ARMS];
    struct pend_fit_unknown unknown[UNKNOWNS];
    struct pend_fit_problem problem;
};

static const int parents[ARMS] = {-1, 0}, in_order[ARMS] = {0, 1};

/* the angles of a run, with noise */
static void film_run(struct film *f, const struct pend_tree *tree, int run,
                     unsigned long long *seed) {
    static double t[ROWS], angle[ROWS * ARMS];
    struct pend_problem problem = {.tree = tree,
                                   .loads = {.gravity = 9.81},
                                   .phi = f->phi + run * ARMS,
                                   .rate = f->rate + run * ARMS,
                                   .times = {.count = ROWS, .span = span, .divisor = ROWS - 1}};
    struct pend_samples samples = {.cap = ROWS, .t = t, .phi = angle};
    struct pend_run *motion;
    int done = 0;
    REQUIRE(pend_run_new(&motion, &pend_method_taylor, &problem, NULL) == PEND_OK);
    CHECK(pend_run_next(motion, &samples, INFINITY, &done, NULL) == PEND_OK && done);
    pend_run_free(&motion);
    for (int i = 0; i < ROWS; i++) {
        int row = i * RUNS + run;
        f->t[row] = t[i], f->run[row] = run;
        for (int k = 0; k < ARMS; k++)
            f->data[k][row] = remainder(angle[i * ARMS + k] + sigma * test_gauss(seed), 2 * M_PI);
    }
}

static void film_add(struct film *f, enum pend_parameter_kind kind, int at, int run, double truth,
                     double start) {
    int j = f->problem.unknowns++;
    double low = kind == PEND_PARAMETER_LENGTH || kind == PEND_PARAMETER_MASS ? 0 : -INFINITY;
    f->truth[j] = truth;
    f->unknown[j] = (struct pend_fit_unknown){-1, {kind, at}, start, low, INFINITY, run};
}

/* lengths with initial errors of a quarter, the ratio of masses, and all starts */
static void film_unknowns(struct film *f, unsigned long long *seed) {
    for (int k = 0; k < ARMS; k++) {
        double off = test_random(seed) < 0.5 ? 0.75 : 1.25;
        film_add(f, PEND_PARAMETER_LENGTH, k, 0, f->length[k], f->length[k] * off);
    }
    film_add(f, PEND_PARAMETER_MASS, 1, 0, f->mass[1], f->mass[1] * 1.2);
    for (int run = 0; run < RUNS; run++)
        for (int k = 0; k < ARMS; k++) {
            film_add(f, PEND_PARAMETER_PHI, k, run, f->phi[run * ARMS + k], f->data[k][run]);
            film_add(f, PEND_PARAMETER_RATE, k, run, 0, 0);
        }
}

static void film_new(struct film *f, double swing, unsigned long long *seed) {
    struct pend_tree *tree;
    memset(f, 0, sizeof *f);
    for (int k = 0; k < ARMS; k++)
        f->length[k] = 0.2 + 0.3 * test_random(seed), f->mass[k] = 0.1 + 0.3 * test_random(seed);
    for (int i = 0; i < RUNS * ARMS; i++)
        f->phi[i] = swing * (2 * test_random(seed) - 1) - M_PI / 2;
    REQUIRE(pend_tree_new(&tree, ARMS, f->length, f->mass, parents, NULL) == PEND_OK);
    for (int run = 0; run < RUNS; run++) film_run(f, tree, run, seed);
    pend_tree_free(&tree);
    for (int k = 0; k < ARMS; k++)
        f->column[k] =
            (struct pend_fit_column){PEND_FIT_PHI, k, sigma, NULL, f->data[k], 0, 0, 0, 0, 0};
    f->problem = (struct pend_fit_problem){.n = ARMS,
                                           .length = f->length,
                                           .mass = f->mass,
                                           .parent = parents,
                                           .order = in_order,
                                           .loads = {.gravity = 9.81},
                                           .runs = RUNS,
                                           .phi = f->phi,
                                           .rate = f->rate,
                                           .camera = {1, 0, 0, 0},
                                           .rows = ALL,
                                           .t = f->t,
                                           .run = f->run,
                                           .columns = ARMS,
                                           .column = f->column,
                                           .unknown = f->unknown,
                                           .rtol = 1e-10,
                                           .iterations = 300,
                                           .step_cap = 100000};
    film_unknowns(f, seed);
}

/* whether a fit converges, and then how many of its values are beyond four standard errors */
static int film_fit(const struct film *f, int *beyond) {
    OWN(pend_fit, free) *fit;
    struct pend_error error = {0};
    int done = 0;
    *beyond = 0;
    CHECK_SAYING(pend_fit_new(&fit, &f->problem, &error) == PEND_OK, "%s", error.text);
    while (fit && !done)
        if (!CHECK_SAYING(pend_fit_step(fit, &done, &error) == PEND_OK, "%s", error.text)) break;
    if (!fit || !done) return 0;
    struct pend_fit_result result = pend_fit_result(fit);
    int good = result.end == PEND_FIT_CONVERGED;
    for (int j = 0; j < f->problem.unknowns && good; j++) {
        double gap = result.value[j] - f->truth[j];
        if (f->unknown[j].by.kind == PEND_PARAMETER_PHI) gap = remainder(gap, 2 * M_PI);
        *beyond += fabs(gap) > 4 * result.error[j];
    }
    if (good) CHECK(fabs(result.chi_squared / (double)result.freedom - 1) < 0.3);
    return good;
}

TEST(fits_of_several_chaotic_runs_find_the_pendulum_or_say_that_they_do_not) {
    const char *asked = getenv("FITS");
    int sets = asked ? atoi(asked) : 3, converged = 0, beyond = 0, off;
    for (int i = 0; i < sets; i++) {
        static struct film f;
        unsigned long long seed = 7919ull * (unsigned long long)(i + 1);
        film_new(&f, i % 2 ? 2.4 : 2, &seed);
        CHECK(!pend_fit_pieces_apt(&f.problem, 1));
        converged += film_fit(&f, &off);
        beyond += off;
    }
    if (asked) printf("  %d of %d converged, %d beyond 4 sigma\n", converged, sets, beyond);
    CHECK_SAYING(beyond == 0, "%d values", beyond);
    CHECK(converged > 0);
}
