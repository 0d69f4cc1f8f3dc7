/* Tests of the derivatives of ideal pendulums by kernels of their own: every quantity by every kind
 * of parameter against the general kernel, to which damping of 0 sends the same motion. Leaves to
 * others: what derivatives are (test_derivatives). Invariant: trees are random, from a seed; more
 * parameters than two groups of eight, and arms by every form of the orders. */
#include "core/derivatives/ideal.h"

#include <math.h>
#include <string.h>

#include "core/derivatives/derivatives.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ROWS = 5, TALL = 20, MANY = 19, NUMBERS = ROWS * TALL * MANY };

/* all derivatives of all quantities, one after the other; with damping of 0 by the general kernel
 */
static void everything(const struct test_tree *t, int general, const struct pend_parameter by[],
                       double number[]) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    static double none[TALL];
    struct pend_loads loads = {.gravity = 9.81};
    struct pend_terms *terms = NULL;
    struct pend_derivatives *d;
    struct pend_derived_rows out = {{0}, {0}};
    long made = 0;
    rows[PEND_TERM_DAMPING] = 1;
    if (general) {
        REQUIRE(pend_terms_new(&terms, t->n, rows, ones, 0, NULL, NULL) == PEND_OK);
        loads.terms = terms, loads.value = none;
    }
    for (int i = 0; i < PEND_DERIVED; i++) out.derivative[i] = number + (size_t)i * NUMBERS;
    struct pend_problem problem = {
        .tree = t->tree,
        .loads = loads,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = ROWS, .start = 0.7, .span = -0.6, .divisor = ROWS - 1},
        .rtol = 1e-14};
    REQUIRE(pend_derivatives_new(&d, &problem, MANY, by, NULL) == PEND_OK);
    CHECK(pend_derivatives_next(d, &out, ROWS, INFINITY, &made, NULL) == PEND_OK && made == ROWS);
    pend_derivatives_free(&d);
    pend_terms_free(&terms);
}

TEST(derivatives_of_ideal_pendulums_are_those_of_the_general_kernel) {
    static double number[2][PEND_DERIVED * NUMBERS];
    const int arms[] = {1, 2, 3, 4, 5, 8, 9, TALL};
    unsigned long long seed = 41;
    double worst = 0;
    for (size_t i = 0; i < sizeof arms / sizeof *arms; i++) {
        struct test_tree t;
        struct pend_parameter by[MANY];
        test_tree_random(&t, TEST_TREE_ATTACHED, arms[i], 0.3, &seed);
        for (int j = 0; j < MANY; j++) {
            enum pend_parameter_kind kind = (enum pend_parameter_kind)(j % 5);
            int at = kind == PEND_PARAMETER_GRAVITY ? 0 : test_random_int(&seed, t.n);
            by[j] = (struct pend_parameter){kind, at};
        }
        memset(number, 0, sizeof number);
        for (int general = 0; general < 2; general++) everything(&t, general, by, number[general]);
        for (int what = 0; what < PEND_DERIVED; what++) {
            double most = 0;
            for (int j = 0; j < NUMBERS; j++)
                most = fmax(most, fabs(number[0][what * NUMBERS + j]));
            // arms without bodies push their tips along themselves
            if (what == PEND_DERIVED_TIP_ACROSS) CHECK_SAYING(most < 1e-9, "%g", most);
            if (what == PEND_DERIVED_TIP_ACROSS) continue;
            double gap = test_gap(NUMBERS, number[0] + what * NUMBERS, number[1] + what * NUMBERS);
            CHECK_SAYING(gap < 1e-12, "%d arms, quantity %d: %g", arms[i], what, gap);
            worst = fmax(worst, gap);
        }
        test_tree_clear(&t);
    }
    CHECK_RESIDUAL(worst, 1e-12, "derivatives of ideal pendulums by two kernels");
}
