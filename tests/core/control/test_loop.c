/* Tests of core/control: gains against the quadratic equation of a single state, margins against
 * simulated loops, modes that symmetry hides from an actuator.
 * Leaves to others: gains of larger systems against SciPy (tests/rules/gains.py).
 * Invariant: all systems are random, from seeds. */
#include "core/control/loop.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/control/riccati.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 4, ROWS = 2 * ARMS + 4 };

TEST(gains_of_one_state_solve_the_quadratic_equation) {
    unsigned long long seed = 3;
    double worst = 0;
    for (int i = 0; i < 500; i++) {
        double a = 4 * test_random(&seed) - 2, b = 0.1 + test_random(&seed), gain;
        double q = 0.01 + test_random(&seed), r = 0.01 + test_random(&seed);
        REQUIRE(pend_riccati(1, 1, &a, &b, &q, &r, &gain) == PEND_OK);
        // b^2 x^2 + (r - a^2 r - q b^2) x - q r = 0
        double half = (r - a * a * r - q * b * b) / (2 * b * b);
        double x = -half + sqrt(half * half + q * r / (b * b));
        worst = fmax(worst, fabs(gain - a * b * x / (r + b * b * x)));
    }
    CHECK_RESIDUAL(worst, 1e-13, "gains of one state");
    double a = 2, b = 0, q = 1, r = 1, gain;
    CHECK(pend_riccati(1, 1, &a, &b, &q, &r, &gain) == PEND_NO_CONVERGENCE);
}

/* the largest multiplier if gains of actuator 0 are multiplied by `factor` */
static double multiplied(const struct pend_loop *loop, const double gains[], double factor) {
    double some[ROWS * 2], re[ROWS], im[ROWS];
    for (int i = 0; i < loop->rows * loop->inputs; i++)
        some[i] = gains[i] * (i < loop->rows ? factor : 1);
    if (pend_loop_multipliers(loop, some, -1, re, im) != PEND_OK) return NAN;
    return hypot(re[0], im[0]);
}

TEST(gains_hold_upright_arms_within_their_margins) {
    unsigned long long seed = 5;
    double worst = 0;
    for (int round = 0; round < 60; round++) {
        OWN(test_tree, clear) t;
        OWN(pend_loop, free) *loop;
        struct pend_margins margins;
        int n = 1 + round % ARMS, delay = round % 3, inputs = 1 + (round % 2 && n > 1);
        int input[] = {0, n - 1};
        double phi[ARMS], q[2 * ARMS] = {0}, r[] = {0.1, 0.2}, gains[ROWS * 2];
        test_tree_random(&t, TEST_TREE_CHAIN, n, 0.3, &seed);
        for (int k = 0; k < n; k++) phi[k] = M_PI_2, q[k] = 1;
        REQUIRE(pend_loop_new(&loop, t.tree, TEST_LOADS(9.81), phi, inputs, input, 0.01, delay) ==
                PEND_OK);
        REQUIRE(pend_loop_gains(loop, q, r, gains) == PEND_OK);
        CHECK(multiplied(loop, gains, 1) < 1);
        REQUIRE(pend_loop_margins(loop, gains, 0, &margins) == PEND_OK);
        for (int side = 0; side < 2; side++) {
            double bound = margins.gain[side];
            if (bound > 0 && isfinite(bound))
                worst = fmax(worst, fabs(multiplied(loop, gains, bound) - 1));
            double within = side ? fmin(bound, 100) * 0.999 : bound + 0.001 * (1 - bound);
            CHECK(multiplied(loop, gains, within) < 1);
        }
        CHECK(margins.phase > 0.2 && margins.phase < M_PI && margins.delay > 0);
    }
    CHECK_RESIDUAL(worst, 1e-11, "multipliers at the margins of gain, less 1");
}

TEST(a_delay_of_a_margin_makes_the_loop_unstable) {
    OWN(test_tree, clear) t;
    unsigned long long seed = 6;
    struct pend_loop *loop, *late;
    struct pend_margins margins;
    double phi = M_PI_2, q[] = {1, 0}, r = 1e-3, gains[2 + 40] = {0}, re[50], im[50];
    int parent = -1, input = 0;
    test_tree_init(&t, 1, &parent, 0.1, &seed);
    REQUIRE(pend_loop_new(&loop, t.tree, TEST_LOADS(9.81), &phi, 1, &input, 0.01, 0) == PEND_OK);
    REQUIRE(pend_loop_gains(loop, q, &r, gains) == PEND_OK);
    REQUIRE(pend_loop_margins(loop, gains, 0, &margins) == PEND_OK);
    // the same gains without prediction, delayed by whole samples
    int samples = (int)(margins.delay / 0.01);
    for (int i = 0; i < 2; i++) {
        REQUIRE(pend_loop_new(&late, t.tree, TEST_LOADS(9.81), &phi, 1, &input, 0.01,
                              samples + 2 * i - 1) == PEND_OK);
        double some[50] = {gains[0], gains[1]};
        REQUIRE(samples > 1 && samples < 40);
        REQUIRE(pend_loop_multipliers(late, some, -1, re, im) == PEND_OK);
        CHECK_INT(hypot(re[0], im[0]) > 1, i);
        pend_loop_free(&late);
    }
    pend_loop_free(&loop);
}

TEST(symmetry_hides_modes_from_an_actuator) {
    OWN(pend_tree, free) *tree;
    OWN(pend_damped, free) *modes = NULL;
    struct pend_loop *loop;
    const int parent[] = {-1, 0, 0}, input[] = {0, 1};
    double phi[] = {-M_PI_2, -M_PI_2, -M_PI_2}, reach[6];
    REQUIRE(pend_tree_new(&tree, 3, (double[]){1, 0.5, 0.5}, (double[]){1, 2, 2}, parent, NULL) ==
            PEND_OK);
    REQUIRE(pend_damped_new(&modes, tree, TEST_LOADS(9.81), phi, NULL) == PEND_OK);
    for (int inputs = 1; inputs <= 2; inputs++) {
        int hidden = 0;
        REQUIRE(pend_loop_new(&loop, tree, TEST_LOADS(9.81), phi, inputs, input, 0.01, 0) ==
                PEND_OK);
        REQUIRE(pend_loop_reach(loop, modes, inputs, loop->joint, reach) == PEND_OK);
        for (int j = 0; j < modes->count; j++) hidden += reach[j] < PEND_LOOP_REACHED;
        // the two branches swing against each other; a motor at one of them acts on that mode too
        CHECK_INT(hidden, 2 - inputs);
        pend_loop_free(&loop);
    }
}

TEST(modes_of_one_frequency_are_reached_one_by_each_actuator) {
    OWN(pend_tree, free) *tree;
    OWN(pend_damped, free) *modes = NULL;
    struct pend_loop *loop;
    const int parent[] = {-1, 0, 0, 0, 0}, input[] = {1, 2, 3, 4};
    double phi[5], reach[10];
    for (int k = 0; k < 5; k++) phi[k] = -M_PI_2;
    REQUIRE(pend_tree_new(&tree, 5, (double[]){1, 0.5, 0.5, 0.5, 0.5}, (double[]){1, 2, 2, 2, 2},
                          parent, NULL) == PEND_OK);
    REQUIRE(pend_damped_new(&modes, tree, TEST_LOADS(9.81), phi, NULL) == PEND_OK);
    for (int inputs = 1; inputs <= 4; inputs++) {
        int hidden = 0;
        REQUIRE(pend_loop_new(&loop, tree, TEST_LOADS(9.81), phi, inputs, input, 0.01, 0) ==
                PEND_OK);
        REQUIRE(pend_loop_reach(loop, modes, inputs, loop->joint, reach) == PEND_OK);
        for (int j = 0; j < modes->count; j++) hidden += reach[j] < PEND_LOOP_REACHED;
        CHECK_INT(hidden, inputs < 3 ? 3 - inputs : 0);
        pend_loop_free(&loop);
    }
}

TEST(gains_and_margins_survive_any_allocation_that_fails) {
    OWN(test_tree, clear) t;
    unsigned long long seed = 8;
    double phi[2] = {M_PI_2, M_PI_2}, q[] = {1, 1, 0, 0}, r = 1, gains[5];
    int parent[] = {-1, 0}, input = 0;
    test_tree_init(&t, 2, parent, 0.1, &seed);
    for (long at = 1; at < 200; at++) {
        struct pend_loop *loop = NULL;
        struct pend_margins margins;
        test_alloc_fail(at, 0);
        enum pend_status status =
            pend_loop_new(&loop, t.tree, TEST_LOADS(9.81), phi, 1, &input, 0.01, 1);
        if (status == PEND_OK) status = pend_loop_gains(loop, q, &r, gains);
        if (status == PEND_OK) status = pend_loop_margins(loop, gains, 0, &margins);
        test_alloc_faults_off();
        pend_loop_free(&loop);
        CHECK(status == PEND_OK || status == PEND_NO_MEMORY);
        if (status == PEND_OK) break;
        CHECK(at < 199);
    }
}
