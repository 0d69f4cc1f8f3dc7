/* Tests of whether a model fits: the statistics by their textbook formulas; standard errors if the
 * noise is correlated or larger than stated, by many random draws.
 * Leaves to others: the search (test_fit), sentences (api/op/test_fits_words).
 * Invariant: the true values are known; random numbers are from seeds. */
#include "core/fit/fit_verdict.h"

#include <math.h>
#include <stdio.h>

#include "core/fit/fit.h"
#include "core/fit/fit_bounds.h"
#include "core/fit/fit_end.h"
#include "core/fit/fit_start.h"
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
    s->column = (struct pend_fit_column){PEND_FIT_PHI, 0, sigma, NULL, s->data, 0, 0, 0, 0, 0};
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
        OWN(pend_fit, free) *fit = fit_of(s);
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
    OWN(pend_fit, free) *fit = fit_of(&s);
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

/* one data set, whose sigma shrinks until chi-squared rejects the model */
TEST(p_values_reject_models) {
    struct study s;
    unsigned long long seed = 7;
    int seen[2] = {0};
    study_new(&s, 0.01);
    study_noise(&s, 0.01, 0, &seed);
    for (s.column.sigma = 0.0105; s.column.sigma > 0.007; s.column.sigma *= 0.995) {
        OWN(pend_fit, free) *fit = fit_of(&s);
        struct pend_fit_result r = pend_fit_result(fit);
        int in = r.p_value > 1.1e-3 && r.p_value < 2.5e-3;
        int out = r.p_value > 4e-4 && r.p_value < 9e-4;
        if (in || out) CHECK_INT(r.model, in ? PEND_FIT_ACCEPTED : PEND_FIT_REJECTED);
        seen[0] += in, seen[1] += out;
    }
    CHECK(seen[0] > 0 && seen[1] > 0);
}

/* rows at equal distances of a motion with noise of unknown size */
TEST(models_are_judged_by_what_rows_allow) {
    static const struct {
        int rows;
        double size, alike;
        int tested, model, end;
    } row[] = {{17, 0.001, 0, 1, PEND_FIT_ACCEPTED, PEND_FIT_CONVERGED}, // FIT_PAIRS
               {16, 0.001, 0, 0, PEND_FIT_ACCEPTED, PEND_FIT_CONVERGED},
               {6, 0.001, 0, 0, PEND_FIT_ACCEPTED, PEND_FIT_CONVERGED}, // FIT_FREEDOM
               {5, 0.001, 0, 0, PEND_FIT_UNDECIDED, PEND_FIT_CONVERGED},
               {ROWS, 0.2, 0.35, 1, PEND_FIT_REJECTED, PEND_FIT_CONVERGED}, // fit_common
               {ROWS, 0.2, 0.75, 1, PEND_FIT_REJECTED, PEND_FIT_STRANGE},
               {ROWS, 0, 0, 1, PEND_FIT_ACCEPTED, PEND_FIT_CONVERGED}}; // fit_known_best
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct study s;
        unsigned long long seed = 11;
        study_new(&s, 0);
        study_noise(&s, row[i].size, row[i].alike, &seed);
        for (int k = 0, by = ROWS / row[i].rows; k < row[i].rows; k++)
            s.t[k] = s.t[k * by], s.data[k] = s.data[k * by];
        s.problem.rows = row[i].rows;
        OWN(pend_fit, free) *fit = fit_of(&s);
        struct pend_fit_result r = pend_fit_result(fit);
        CHECK_SAYING((isfinite(r.alike) != 0) == row[i].tested && (int)r.model == row[i].model &&
                         (int)r.end == row[i].end,
                     "row %zu: %g, model %d, end %d", i, r.alike, (int)r.model, (int)r.end);
        // the largest angle is that of the start, -1.6 to -1.3 rad
        if (row[i].size == 0) CHECK(r.spread[0] > 1e-6 && r.spread[0] < 4e-6);
    }
}

/* ---- fits at the edges of the constants of their state and of their start */

static struct pend_fit *fit_begun(struct study *s, double sigma, enum pend_parameter_kind sought) {
    struct pend_fit *fit = NULL;
    study_new(s, sigma);
    for (int i = 0; i < ROWS; i++) s->data[i] = s->angle[i];
    s->unknown[0].by.kind = sought, s->problem.unknowns = 1;
    CHECK(pend_fit_new(&fit, &s->problem, NULL) == PEND_OK);
    return fit;
}

TEST(small_steps_are_negligible) {
    static const struct {
        double sigma, rtol, variance, gain;
        int flat;
    } row[] = {{1, 1e-10, 1, 2e-4, 0},  {1, 1e-10, 1, 5e-5, 1},  // fit_step
               {0, 1e-10, 0, 2e-15, 0}, {0, 1e-10, 0, 5e-16, 1}, // fit_loose, squared
               {0, 1e-3, 0, 2e-12, 0},  {0, 1e-3, 0, 5e-13, 1}}; // fit_exact
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct study s;
        OWN(pend_fit, free) *fit = fit_begun(&s, row[i].sigma, PEND_PARAMETER_LENGTH);
        fit->variance = row[i].variance, fit->problem.rtol = row[i].rtol;
        double size = row[i].sigma > 0 ? 1 : pend_fit_state_size(fit);
        CHECK_SAYING(pend_fit_state_flat(fit, row[i].gain * size, 0) == row[i].flat, "row %zu", i);
    }
}

/* a mass, on which no angle depends */
TEST(unknowns_far_away_are_reported) {
    for (int near = 0; near < 2; near++) {
        struct study s;
        OWN(pend_fit, free) *fit = fit_begun(&s, 0.01, PEND_PARAMETER_MASS);
        fit->window = ROWS;
        fit->inner[0] = fit_bounds_inner(s.unknown, (near ? 5e5 : 2e6) * s.unknown[0].start);
        CHECK(pend_fit_end(fit, NULL) == PEND_OK);
        CHECK_INT(pend_fit_result(fit).away, -near);
    }
}

/* omega = sqrt(g / l), whose central differences are off by 5 / 8 of the squared relative step */
TEST(slopes_of_frequencies_are_exact) {
    struct study s;
    OWN(pend_fit, free) *fit;
    study_new(&s, 1);
    s.column.kind = PEND_FIT_MODE, s.data[0] = 1, s.problem.rows = s.problem.unknowns = 1;
    REQUIRE(pend_fit_new(&fit, &s.problem, NULL) == PEND_OK);
    CHECK(pend_fit_state_look(fit, 1, NULL) == PEND_OK);
    double off = fabs(fit->slope[0] / (-sqrt(9.81) / 2) - 1);
    CHECK_SAYING(off > 3e-9 && off < 1.3e-8, "%g", off);
}

/* angles every second, the last one again for all others, and the rate at the first */
TEST(starts_come_from_five_rows) {
    static const struct {
        double angle[6], rate;
    } row[] = {{{0, 0.1, 0.2, 0.3, 0.4, 9}, 0.1},        // not from the sixth
               {{0, 0.1, 0.2, 0.3, 0.44, 0}, 0.11},      // from the fifth
               {{0, 0.05, 0.1, 0.15, 0.14, 0}, 0.035},   // nearly straight: fit_bent
               {{0, 0.2, 0.3, 0.3, 0.2, 0}, 0.25},       // a parabola
               {{0, 0.8, 0.8, 1, 1, 1}, 1.2},            // fit_outlier: as long as four steps
               {{0, 1.2, 1.2, 1.4, 1.4, 1.4}, 0.2 / 3}}; // as six: without the first
    struct study s;
    double phi, rate, residual[ROWS], noise = 8.0 / 3 / sqrt(35.0 / 18) * sqrt(M_PI / 2);
    study_new(&s, 0);
    for (int k = 0; k < ROWS; k++) s.t[k] = k;
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        for (int k = 0; k < ROWS; k++) s.data[k] = row[i].angle[k < 6 ? k : 5];
        CHECK(pend_fit_start_state(&s.problem, 0, 0, &phi, &rate) == PEND_FIT_START_BOTH);
        CHECK_SAYING(fabs(rate - row[i].rate) < 1e-12, "row %zu: %.17g", i, rate);
    }
    // every other row off by 1 from a line: fit_noisy
    for (int times = 5; times <= 20; times += 15) {
        for (int i = 0; i < ROWS; i++) s.data[i] = i % 2, residual[i] = times * noise / 2;
        CHECK_INT(pend_fit_start_noisy(&s.problem, residual), times > 10);
    }
    s.column.kind = PEND_FIT_PASSAGE; // fit_swing_rate, of a swing of sqrt(g / l)
    CHECK(pend_fit_start_state(&s.problem, 0, 0, &phi, &rate) == PEND_FIT_START_BOTH);
    CHECK_SAYING(rate > 0.15 * sqrt(9.81 / 0.7) && rate < 0.6 * sqrt(9.81 / 0.7), "%g", rate);
}
