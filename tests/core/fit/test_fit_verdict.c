/* Tests of whether a model fits: the statistics by their textbook formulas; standard errors if the
 * noise is correlated or larger than stated, by many random draws.
 * Leaves to others: the search (test_fit), sentences (api/op/test_fits_words).
 * Invariant: the true values are known; random numbers are from seeds. */
#include "core/fit/fit_verdict.h"

#include <math.h>
#include <stdio.h>

#include "core/fit/fit.h"
#include "core/integrate/run/run.h"
#include "tests/harness/test.h"

enum { ROWS = 200, UNKNOWNS = 3, DRAWS = 200 };

static const double truth[UNKNOWNS] = {0.7, 1.2 - M_PI / 2, 0.3};

/* one arm, 8 s from 1.2 rad, whose length and start are unknown */
struct study {
    double length, mass, phi, rate, t[ROWS], angle[ROWS], data[ROWS], knee;
    double often; /* fraction of the measurements with ten times the error */
    int parent, order;
    struct pend_fit_column column;
    struct pend_fit_unknown unknown[UNKNOWNS];
    struct pend_fit_problem problem;
};

static void study_new(struct study *s, double sigma) {
    *s = (struct study){.length = truth[0], .mass = 1, .phi = truth[1], .rate = truth[2]};
    s->parent = -1;
    struct pend_tree *tree;
    struct pend_run *run;
    struct pend_samples samples = {.cap = ROWS, .t = s->t, .phi = s->angle};
    int done = 0;
    REQUIRE(pend_tree_new(&tree, 1, &s->length, &s->mass, &s->parent, NULL) == PEND_OK);
    struct pend_problem motion = {.tree = tree,
                                  .loads = {9.81, NULL, NULL},
                                  .phi = &s->phi,
                                  .rate = &s->rate,
                                  .times = {.count = ROWS, .span = 8, .divisor = ROWS - 1}};
    REQUIRE(pend_run_new(&run, &pend_method_taylor, &motion, NULL) == PEND_OK);
    CHECK(pend_run_next(run, &samples, INFINITY, &done, NULL) == PEND_OK && done);
    pend_run_free(&run);
    pend_tree_free(&tree);
    static const enum pend_parameter_kind kinds[UNKNOWNS] = {
        PEND_PARAMETER_LENGTH, PEND_PARAMETER_PHI, PEND_PARAMETER_RATE};
    for (int j = 0; j < UNKNOWNS; j++)
        s->unknown[j] = (struct pend_fit_unknown){
            -1, {kinds[j], 0}, 1.05 * truth[j], j ? -INFINITY : 0, INFINITY, 0};
    s->column = (struct pend_fit_column){PEND_FIT_PHI, 0, sigma, NULL, s->data, 0, 0, 0, 0};
    s->problem = (struct pend_fit_problem){.n = 1,
                                           .length = &s->length,
                                           .mass = &s->mass,
                                           .parent = &s->parent,
                                           .order = &s->order,
                                           .loads = {9.81, NULL, NULL},
                                           .phi = &s->phi,
                                           .rate = &s->rate,
                                           .camera = {1, 0, 0, 0},
                                           .rows = ROWS,
                                           .t = s->t,
                                           .columns = 1,
                                           .column = &s->column,
                                           .unknowns = UNKNOWNS,
                                           .unknown = s->unknown,
                                           .rtol = 1e-10,
                                           .iterations = 300,
                                           .step_cap = 100000};
}

/* noise of standard deviation 1 with the autocorrelation `alike` between rows */
static void study_noise(struct study *s, double size, double alike, unsigned long long *seed) {
    double noise = test_gauss(seed);
    for (int i = 0; i < ROWS; i++) {
        double far = s->often > 0 && test_random(seed) < s->often ? 10 : 1;
        s->data[i] = s->angle[i] + far * size * noise;
        noise = alike * noise + sqrt(1 - alike * alike) * test_gauss(seed);
    }
}

static struct pend_fit *fit_of(const struct study *s) {
    struct pend_fit *fit;
    int done = 0;
    CHECK(pend_fit_new(&fit, &s->problem, NULL) == PEND_OK);
    while (!done && CHECK(pend_fit_step(fit, &done, NULL) == PEND_OK)) continue;
    return fit;
}

/* over many draws: how many values are within one and two standard errors, by the reported error
 * and by the error before it was increased; how many models were rejected */
struct tally {
    double one, two, before, rejected, widened, error;
};

static struct tally drawn(struct study *s, double size, double alike, unsigned long long seed) {
    struct tally tally = {0};
    for (int d = 0; d < DRAWS; d++) {
        study_noise(s, size, alike, &seed);
        struct pend_fit *fit = fit_of(s);
        struct pend_fit_result r = pend_fit_result(fit);
        for (int j = 0; j < UNKNOWNS; j++) {
            double off = fabs(r.value[j] - truth[j]) / r.error[j];
            tally.one += (off < 1) / (double)(DRAWS * UNKNOWNS);
            tally.two += (off < 2) / (double)(DRAWS * UNKNOWNS);
            tally.before += (off * r.widened < 2) / (double)(DRAWS * UNKNOWNS);
        }
        CHECK(r.end <= PEND_FIT_STRANGE);
        tally.error += r.error[0] / DRAWS;
        tally.rejected += r.model == PEND_FIT_REJECTED, tally.widened += r.widened / DRAWS;
        pend_fit_free(&fit);
    }
    return tally;
}

/* one measurement in twenty has ten times the error */
TEST(standard_errors_of_robust_losses_hold_beside_outliers) {
    static const enum pend_fit_loss losses[] = {PEND_FIT_SOFT_L1, PEND_FIT_HUBER, PEND_FIT_CAUCHY};
    for (size_t i = 0; i < sizeof losses / sizeof *losses; i++) {
        struct study s;
        struct tally tally, plain;
        study_new(&s, 0.01);
        s.often = 0.05, s.knee = losses[i] == PEND_FIT_CAUCHY ? 2.385 : 1.345;
        plain = drawn(&s, 0.01, 0, 19);
        s.problem.loss = losses[i], s.problem.knee = &s.knee;
        tally = drawn(&s, 0.01, 0, 19);
        printf("  loss %d: %.3f within one, %.3f within two standard errors, %.2f as large\n",
               (int)losses[i], tally.one, tally.two, tally.error / plain.error);
        CHECK(tally.one > 0.64 && tally.one < 0.73);
        CHECK(tally.two > 0.93 && tally.two < 0.98);
        CHECK(tally.error < 0.6 * plain.error);
    }
}

/* the Durbin-Watson sum, and the tail of chi-squared by its series for an even number of degrees of
 * freedom */
TEST(tests_of_the_model_are_those_of_textbooks) {
    struct study s;
    unsigned long long seed = 7;
    study_new(&s, 0.01);
    study_noise(&s, 0.0105, 0.1, &seed);
    // 199 measurements, 196 degrees of freedom
    s.problem.rows = ROWS - 1;
    struct pend_fit *fit = fit_of(&s);
    struct pend_fit_result r = pend_fit_result(fit);
    double squares = 0, steps = 0, term = 1, sum = 0;
    for (int i = 0; i < ROWS - 1; i++) {
        squares += r.residual[i] * r.residual[i];
        if (i) steps += pow(r.residual[i] - r.residual[i - 1], 2);
    }
    CHECK_INT(r.freedom, ROWS - 1 - UNKNOWNS);
    for (int k = 0; k < r.freedom / 2; k++) sum += term, term *= squares / 2 / (k + 1);
    CHECK(r.p_value > 0.001 && r.p_value < 0.5);
    CHECK_RESIDUAL(fabs(r.p_value - exp(-squares / 2) * sum), 5e-14, "p-value");
    CHECK_RESIDUAL(fabs(r.watson - steps / squares), 1e-15, "Durbin and Watson's number");
    pend_fit_free(&fit);
}

TEST(standard_errors_hold_beside_noise_that_is_alike) {
    static const double alike[] = {0.5, 0.8, 0.9};
    for (size_t i = 0; i < sizeof alike / sizeof *alike; i++) {
        struct study s;
        study_new(&s, i == 1 ? 0.01 : 0);
        struct tally tally = drawn(&s, 0.01, alike[i], 11);
        printf("  alike by %.1f: %.3f within one, %.3f within two standard errors (%.3f before)\n",
               alike[i], tally.one, tally.two, tally.before);
        CHECK(tally.rejected >= 0.99 * DRAWS);
        CHECK(tally.one > 0.62 && tally.one < 0.74);
        CHECK(tally.two > 0.91 && tally.two < 0.98);
        CHECK(tally.before < 0.85);
    }
}

TEST(independent_noise_rejects_no_model_but_for_its_size) {
    struct study s;
    study_new(&s, 0.01);
    struct tally tally = drawn(&s, 0.01, 0, 13);
    CHECK(tally.rejected <= 2 && tally.widened < 1.002);
    CHECK(tally.one > 0.64 && tally.one < 0.72 && tally.two > 0.93);
    tally = drawn(&s, 0.015, 0, 17);
    CHECK(tally.rejected >= DRAWS - 2);
    CHECK(fabs(tally.widened - 1.5) < 0.02);
    CHECK(tally.one > 0.64 && tally.one < 0.72 && tally.two > 0.93);
}
