#include <math.h>
#include <stdlib.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* rtol = atol * 100; the error of each on the paper's example, over all 5 s */
static const struct {
    const char *method;
    double rtol, phi, rate, force;
} gsl_paper[] = {{"rkf45", 1e-13, 1e-10, 1e-10, 1e-9},
                 {"rk8pd", 1e-13, 2e-12, 4e-12, 4e-11},
                 {"msadams", 1e-13, 4e-11, 8e-11, 5e-10},
                 {"rk8pd", 1e-9, 2e-9, 4e-9, 4e-8},
                 {"msadams", 1e-6, 1e-2, 1e-2, 1e-1}};

TEST(gsl_methods_solve_the_papers_example) {
    OWN(test_paper, clear) paper = {0};
    struct test_paper_row exact[TEST_PAPER_ROWS];
    REQUIRE(test_paper_read(exact));
    test_paper_init(&paper, 501);
    for (size_t i = 0; i < sizeof gsl_paper / sizeof *gsl_paper; i++) {
        OWN(test_record, clear) record;
        paper.problem.rtol = gsl_paper[i].rtol;
        paper.problem.atol = gsl_paper[i].rtol / 100;
        test_record(&record, gsl_paper[i].method, &paper.problem);
        CHECK_INT(record.status, PEND_OK);
        struct test_record_gap gap = test_paper_gap(&record, 10, exact);
        CHECK_RESIDUAL(gap.phi, gsl_paper[i].phi, gsl_paper[i].method);
        CHECK_RESIDUAL(gap.rate, gsl_paper[i].rate, gsl_paper[i].method);
        CHECK_RESIDUAL(gap.force, gsl_paper[i].force, gsl_paper[i].method);
    }
}

/* instants so close that every step ends at one require their own steps, but no more: shortened
 * steps do not reduce the step size */
TEST(gsl_methods_keep_their_step_size_when_they_land) {
    static const char *const name[] = {"rkf45", "rk8pd", "msadams"};
    const double list[] = {0, 1, 1 + 1e-13, 1 + 2e-13, 2};
    OWN(test_paper, clear) paper;
    test_paper_init(&paper, 2);
    for (int i = 0; i < 3; i++) {
        OWN(test_record, clear) near, far;
        paper.problem.times = (struct pend_times){.count = 2, .span = 2, .divisor = 1};
        test_record(&far, name[i], &paper.problem);
        paper.problem.times = (struct pend_times){.count = 5, .list = list};
        test_record(&near, name[i], &paper.problem);
        CHECK_INT(near.status, PEND_OK);
        CHECK_SAYING(near.stats.steps <= far.stats.steps + far.stats.steps / 4,
                     "%s: %ld steps with, %ld without", name[i], near.stats.steps, far.stats.steps);
    }
}

/* a step of one unit in the last place is possible too */
TEST(gsl_methods_land_on_neighbouring_numbers) {
    static const char *const name[] = {"rkf45", "rk8pd", "msadams"};
    double list[20];
    OWN(test_paper, clear) paper;
    list[0] = 0.1;
    for (int i = 1; i < 20; i++) list[i] = nextafter(list[i - 1], 1);
    test_paper_init(&paper, 2);
    paper.problem.times = (struct pend_times){.count = 20, .list = list};
    for (int i = 0; i < 3; i++) {
        OWN(test_record, clear) record;
        test_record(&record, name[i], &paper.problem);
        CHECK_INT(record.status, PEND_OK);
        CHECK_INT(record.samples.count, 20);
    }
}

static int gsl_rest(double t, const double y[], double f[], void *context) {
    (void)t, (void)y, (void)context;
    f[0] = 0;
    return GSL_SUCCESS;
}

/* GSL's default handler would abort here, as it would if memory is short */
TEST(gsl_errors_do_not_end_the_process) {
    gsl_odeiv2_system system = {gsl_rest, NULL, 1, NULL};
    CHECK(!gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 0, 1e-6, 1e-6));
}

TEST(gsl_methods_say_when_numbers_overflow) {
    static const char *const name[] = {"rkf45", "rk8pd", "msadams"};
    OWN(test_paper, clear) paper;
    test_paper_init(&paper, 11);
    for (int i = 0; i < 4; i++) paper.rate[i] = 1e200;
    for (int i = 0; i < 3; i++) {
        double t[11];
        struct pend_samples samples = {.cap = 11, .t = t};
        struct pend_error error = {.text = ""};
        OWN(pend_run, free) *run;
        int done;
        REQUIRE(pend_run_new(&run, pend_method_find(name[i]), &paper.problem, NULL) == PEND_OK);
        CHECK_INT(pend_run_next(run, &samples, INFINITY, &done, &error), PEND_NOT_FINITE);
        CHECK_TEXT(error.text, "at t = 0 s: the accelerations ceased to be finite");
    }
}
