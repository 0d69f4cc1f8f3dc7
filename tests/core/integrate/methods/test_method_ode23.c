#include <math.h>
#include <string.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* The results of a separate transcription of MATLAB's ode23 (another language, the paper's matrix
 * form, Gaussian elimination) for the paper's example over 0:.01:5 with RelTol 1e-3 and AbsTol
 * 1e-6. */
enum { MATLAB_STEPS = 197, MATLAB_FAILED = 22, MATLAB_EVALUATIONS = 658 };
static const double matlab_end[8] = {-0.9410172426987587, -2.4566853708000975, 4.621912896678883,
                                     5.668938767737061,   -3.1310259317365894, 2.3210535153049103,
                                     -3.088956172845715,  4.640701477489687};

TEST(ode23_is_matlabs_on_the_papers_example) {
    OWN(test_paper, clear) paper = {0};
    struct test_paper_row exact[TEST_PAPER_ROWS];
    OWN(test_record, clear) record = {0};
    REQUIRE(test_paper_read(exact));
    test_paper_init(&paper, 501);
    test_record(&record, "ode23", &paper.problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK_INT(record.stats.steps, MATLAB_STEPS);
    CHECK_INT(record.stats.rejected, MATLAB_FAILED);
    CHECK_INT(record.stats.evaluations, MATLAB_EVALUATIONS);
    const double *phi = record.samples.phi + 4 * 500, *rate = record.samples.rate + 4 * 500;
    double gap = 0, error = 0;
    for (int i = 0; i < 4; i++) {
        gap = fmax(gap, fmax(fabs(phi[i] - matlab_end[i]), fabs(rate[i] - matlab_end[4 + i])));
        error = fmax(error, fabs(phi[i] - exact[50].phi[i]));
    }
    CHECK_RESIDUAL(gap, 2e-9, "state at t = 5 against the transcription");
    CHECK_SAYING(error > 0.1 && error < 0.3, "error at t = 5 is %g rad", error);
}

/* a record of the paper's example over the instants of a list */
static void record_list(struct test_record *record, struct test_paper *paper, const double list[],
                        long count) {
    paper->problem.times = (struct pend_times){.count = count, .list = list};
    test_record(record, "ode23", &paper->problem);
}

TEST(ode23_takes_the_same_steps_whatever_lies_in_between) {
    const double rough[] = {0, 0.01, 5},
                 fine[] = {0, 1e-7, 0.02, 0.5, 1.25, 1.2500001, 3, 4.999, 5};
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) a, b;
    test_paper_init(&paper, 2);
    record_list(&a, &paper, rough, 3);
    record_list(&b, &paper, fine, 9);
    CHECK_INT(a.stats.evaluations, b.stats.evaluations);
    CHECK(!memcmp(a.samples.phi + 2 * 4, b.samples.phi + 8 * 4, sizeof(double[4])));
}

/* MATLAB's first step depends on |y'| only: h = 0.8 rtol^(1/3) threshold / |phi''|, here 0.08 *
 * 1e-3 / (g / l_1) */
TEST(ode23_begins_with_matlabs_first_step) {
    const double first = 0.08e-3 / (9.81 / 2), list[] = {0, first * 0.999999, first * 1.000001, 5};
    OWN(test_paper, clear) paper;
    OWN(pend_run, free) *run;
    double t[4], work = 0;
    int done;
    struct pend_samples samples = {.cap = 4, .t = t};
    test_paper_init(&paper, 2);
    paper.problem.times = (struct pend_times){.count = 4, .list = list};
    CHECK_INT(pend_run_new(&run, pend_method_find("ode23"), &paper.problem, NULL), PEND_OK);
    /* the start; the first step; its result */
    for (int i = 0; i < 3; i++) CHECK_INT(pend_run_next(run, &samples, work, &done, NULL), PEND_OK);
    CHECK_INT(pend_run_stats(run).steps, 1);
    CHECK_INT(samples.count, 1);
    CHECK(t[0] == list[1]);
    /* no further instant is reached */
    CHECK_INT(pend_run_next(run, &samples, work, &done, NULL), PEND_OK);
    CHECK_INT(samples.count, 0);
    CHECK_INT(pend_run_stats(run).steps, 2);
}

/* No step is longer than a tenth of the time, as in MATLAB. Unlike in MATLAB, the first gap between
 * requested instants limits no step. */
TEST(ode23_limits_its_steps_by_the_span_alone) {
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record;
    const double near[] = {0, 1e-9, 5};
    test_paper_init(&paper, 2);
    record_list(&record, &paper, near, 3);
    CHECK_INT(record.stats.steps, MATLAB_STEPS);
    test_record_clear(&record);
    /* hanging at rest: only the limit ends a step */
    for (int i = 0; i < 4; i++) paper.phi[i] = -1.57079632679489661923;
    paper.problem.times = (struct pend_times){.count = 2, .span = 1, .divisor = 1};
    test_record(&record, "ode23", &paper.problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK_INT(record.stats.steps, 10); /* the last one is lengthened by the rounding errors of the
                                        * others */
}

/* equally spaced instants inside one step lie on one cubic: fourth differences vanish, third do
 * not */
TEST(ode23_interpolates_with_a_cubic) {
    enum { COUNT = 9 };
    double list[COUNT + 2], third = 0, fourth = 0;
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record;
    test_paper_init(&paper, 2);
    list[0] = 0;
    for (int i = 0; i < COUNT; i++) list[1 + i] = 1.0e-1 + i * 0.25e-3;
    list[COUNT + 1] = 5;
    record_list(&record, &paper, list, COUNT + 2);
    for (int i = 1; i + 4 <= COUNT; i++) {
        const double *y = record.samples.rate + (size_t)i * 4; /* for the first arm */
        third = fmax(third, fabs(y[12] - 3 * y[8] + 3 * y[4] - y[0]));
        fourth = fmax(fourth, fabs(y[16] - 4 * y[12] + 6 * y[8] - 4 * y[4] + y[0]));
    }
    CHECK(third > 1e-14);
    CHECK_RESIDUAL(fourth, 2e-15, "fourth differences");
}

TEST(ode23_meets_no_tolerance_where_numbers_overflow) {
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record;
    test_paper_init(&paper, 11);
    for (int i = 0; i < 4; i++) paper.rate[i] = 1e200;
    test_record(&record, "ode23", &paper.problem);
    CHECK(record.status == PEND_NOT_FINITE || record.status == PEND_STEP_TOO_SMALL);
}
