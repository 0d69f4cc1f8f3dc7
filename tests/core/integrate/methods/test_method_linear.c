#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/modes.h"
#include "tests/harness/quad.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

#define GRAVITY 9.81
#define QUARTER 1.57079632679489661923

/* a small swing about hanging of a random tree */
static void swing_init(struct test_tree *t, int n, double amplitude, unsigned long long seed) {
    test_tree_random(t, TEST_TREE_ATTACHED, n, 0.3, &seed);
    for (int k = 0; k < n; k++) {
        t->phi[k] = amplitude * (2 * test_random(&seed) - 1) - QUARTER;
        t->rate[k] = amplitude * (2 * test_random(&seed) - 1);
    }
}

static struct pend_problem swing_problem(const struct test_tree *t, double span, long count) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads.gravity = GRAVITY,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)}};
}

/* largest |theta'' + A theta| over all samples, relative to the largest |theta''| */
static double residual(const struct test_record *record, const struct pend_tree *tree,
                       const double a[]) {
    double worst = 0, largest = 0;
    int n = tree->n;
    for (long i = 0; i < record->samples.count; i++)
        for (int k = 0; k < n; k++) {
            double sum = record->samples.acc[i * n + tree->order[k]];
            largest = fmax(largest, fabs(sum));
            for (int j = 0; j < n; j++)
                sum += a[k * n + j] * (record->samples.phi[i * n + tree->order[j]] + QUARTER);
            worst = fmax(worst, fabs(sum));
        }
    return worst / largest;
}

TEST(linear_solves_the_linearised_equation) {
    enum { ARMS = 12 };
    double a[ARMS * ARMS];
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    swing_init(&t, ARMS, 0.5, 1);
    struct pend_problem problem = swing_problem(&t, 20, 101);
    test_record(&record, "linear", &problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK_INT(record.stats.steps, 1);
    test_quad_linearization(t.tree, GRAVITY, a, NULL);
    CHECK_RESIDUAL(residual(&record, t.tree, a), 5e-13, "theta'' + A theta");
}

/* rate and acc are the derivatives of phi: central differences of second order */
TEST(linear_differentiates_its_own_motion) {
    enum { ARMS = 5, COUNT = 4001 };
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    swing_init(&t, ARMS, 0.5, 3);
    struct pend_problem problem = swing_problem(&t, 1, COUNT);
    test_record(&record, "linear", &problem);
    double rate_gap = 0, acc_gap = 0, step = 1.0 / (COUNT - 1);
    for (long i = 1; i + 1 < COUNT; i++)
        for (int k = 0; k < ARMS; k++) {
            const double *phi = record.samples.phi + i * ARMS + k,
                         *rate = record.samples.rate + i * ARMS + k;
            rate_gap = fmax(rate_gap, fabs((phi[ARMS] - phi[-ARMS]) / (2 * step) - *rate));
            acc_gap = fmax(acc_gap, fabs((rate[ARMS] - rate[-ARMS]) / (2 * step) -
                                         record.samples.acc[i * ARMS + k]));
        }
    CHECK_RESIDUAL(rate_gap, 1e-4, "rate against differences of phi");
    CHECK_RESIDUAL(acc_gap, 1e-3, "acc against differences of rate");
}

/* the difference from the true motion is proportional to the cube of the amplitude */
TEST(linear_is_the_limit_of_small_swings) {
    enum { ARMS = 6 };
    double error[2];
    for (int i = 0; i < 2; i++) {
        OWN(test_tree, clear) t;
        OWN(test_record, clear) linear, full;
        swing_init(&t, ARMS, i ? 1e-4 : 1e-3, 5);
        struct pend_problem problem = swing_problem(&t, 3, 31);
        test_record(&linear, "linear", &problem);
        problem.rtol = 1e-14;
        problem.atol = 1e-18;
        test_record(&full, "rk8pd", &problem);
        CHECK_INT(full.status, PEND_OK);
        error[i] = test_record_gap(&linear, &full).phi;
    }
    CHECK_RESIDUAL(error[1], 1e-10, "phi at amplitude 1e-4");
    CHECK_SAYING(error[0] / error[1] > 900 && error[0] / error[1] < 1100, "ratio %g",
                 error[0] / error[1]);
}

/* the forces of the linear motion: hanging at rest each arm carries what hangs on it */
TEST(linear_forces_follow_from_its_motion) {
    enum { ARMS = 5 };
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    swing_init(&t, ARMS, 0, 7);
    struct pend_problem problem = swing_problem(&t, 1, 3);
    test_record(&record, "linear", &problem);
    double worst = 0;
    for (long i = 0; i < 3; i++)
        for (int k = 0; k < ARMS; k++) {
            double weight = GRAVITY * t.tree->subtree_mass[k];
            worst = fmax(worst,
                         fabs(record.samples.force[i * ARMS + t.tree->order[k]] + weight) / weight);
        }
    CHECK_RESIDUAL(worst, 1e-15, "force hanging at rest");
}

/* an arm after whole turns hangs as before */
TEST(linear_swings_about_the_nearest_hanging_position) {
    enum { ARMS = 4 };
    OWN(test_tree, clear) t;
    OWN(test_record, clear) plain, turned;
    swing_init(&t, ARMS, 0.2, 11);
    struct pend_problem problem = swing_problem(&t, 1, 11);
    test_record(&plain, "linear", &problem);
    for (int k = 0; k < ARMS; k++) t.phi[k] += (k - 1) * 4 * QUARTER;
    test_record(&turned, "linear", &problem);
    double gap = 0;
    for (long i = 0; i < 11; i++)
        for (int k = 0; k < ARMS; k++) {
            double turns = (t.tree->place[k] - 1) * 4 * QUARTER;
            gap = fmax(gap, fabs(turned.samples.phi[i * ARMS + k] - turns -
                                 plain.samples.phi[i * ARMS + k]));
        }
    CHECK_RESIDUAL(gap, 1e-14, "phi but for whole turns");
}

/* a motion that starts in one mode stays in it and repeats after that mode's period */
TEST(linear_repeats_after_the_period_of_a_mode) {
    enum { ARMS = 4 };
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record = {0};
    OWN(pend_modes, free) *modes;
    swing_init(&t, ARMS, 0, 9);
    REQUIRE(pend_modes_new(&modes, t.tree, TEST_LOADS(GRAVITY), 1, NULL) == PEND_OK);
    for (int k = 0; k < modes->count; k++)
        pend_modes_scale(modes, t.tree, k, PEND_NORMALIZE_MAX, -1);
    for (int k = 0; k < ARMS; k++) t.phi[k] = 0.1 * modes->vector[2 * ARMS + k] - QUARTER;
    struct pend_problem problem = swing_problem(&t, 8 * QUARTER / modes->omega[2], 3);
    test_record(&record, "linear", &problem);
    double half = 0, full = 0;
    for (int k = 0; k < ARMS; k++) {
        const double *phi = record.samples.phi + k;
        full = fmax(full, fabs(phi[2 * ARMS] - phi[0]));
        half = fmax(half, fabs(phi[ARMS] - phi[0]));
    }
    CHECK_RESIDUAL(fmax(full, 1e-16), 1e-14, "phi after two periods");
    CHECK_RESIDUAL(fmax(half, 1e-16), 1e-14, "phi after one period");
}
