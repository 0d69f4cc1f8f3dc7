/* Tests of the derivatives of pendulums whose motion is computed once, by separate kernels: every
 * quantity with respect to every kind of parameter, against the general kernel, which computes the
 * same motion if a friction of 0 is added. Leaves to others: what derivatives are
 * (test_derivatives). Invariant: trees are random, from a seed; more parameters than two groups of
 * eight, and arms by every form of the orders. */
#include "core/derivatives/ideal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/derivatives/derivatives.h"
#include "core/derivatives/ideal_loads.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ROWS = 5, TALL = 20, MANY = 19, NUMBERS = ROWS * TALL * MANY };

/* a pendulum, ideal or with terms */
struct subject {
    const struct test_tree *t;
    struct pend_terms *terms;
    double gravity, value[PEND_TERM_ROWS * TALL + 16];
};

/* with terms a friction of 0 selects the general kernel */
static void subject_make(struct subject *x, const struct test_tree *t, int general,
                         const unsigned char wanted[], int pivot, unsigned long long seed) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    const int drives[] = {t->n - 1, PEND_DRIVE_PIVOT_X};
    int place[2];
    *x = (struct subject){.t = t, .gravity = 9.81};
    if (wanted) memcpy(rows, wanted, sizeof rows);
    if (general) rows[PEND_TERM_FRICTION] = 1;
    if (!wanted && !general) return;
    ones[PEND_TERM_PIVOT_ACCELERATION_X] = ones[PEND_TERM_PIVOT_ACCELERATION_Y] = pivot != 0;
    REQUIRE(pend_terms_new(&x->terms, t->n, rows, ones, pivot ? 2 : 0, drives, place) == PEND_OK);
    pend_terms_clear(x->terms, t->tree, x->value);
    for (int row = 0; row < PEND_TERM_ROWS; row++)
        for (int k = 0; k < t->n && wanted && wanted[row]; k++) {
            double *at = &x->value[x->terms->row[row] + k];
            *at = 0.1 + 0.9 * test_random(&seed);
            if (row == PEND_TERM_CENTER_X) *at *= t->tree->len[k];
            if (row == PEND_TERM_DAMPING || row == PEND_TERM_INERTIA) *at *= 0.1;
        }
    const double drive[2][3] = {{0.4, 3, 0.2}, {0.05, 4, 1}};
    for (int i = 0; i < 2 && pivot; i++)
        memcpy(&x->value[x->terms->harmonic[place[i]].at], drive[i], sizeof drive[i]);
    if (!pivot) return;
    x->value[x->terms->one[PEND_TERM_PIVOT_ACCELERATION_X]] = 0.7;
    x->value[x->terms->one[PEND_TERM_PIVOT_ACCELERATION_Y]] = -0.3;
}

/* all derivatives of all quantities, one after the other */
static void everything(const struct subject *x, const struct pend_parameter by[], double number[]) {
    struct pend_loads loads = {.gravity = x->gravity, .terms = x->terms, .value = x->value};
    OWN(pend_derivatives, free) *d;
    struct pend_derived_rows out = {{0}, {0}};
    long made = 0;
    for (int i = 0; i < PEND_DERIVED; i++) out.derivative[i] = number + (size_t)i * NUMBERS;
    struct pend_problem problem = {
        .tree = x->t->tree,
        .loads = loads,
        .phi = x->t->phi,
        .rate = x->t->rate,
        .times = {.count = ROWS, .start = 0.7, .span = -0.6, .divisor = ROWS - 1},
        .rtol = 1e-14};
    REQUIRE(pend_derivatives_new(&d, &problem, MANY, by, NULL) == PEND_OK);
    CHECK(pend_derivatives_next(d, &out, ROWS, INFINITY, &made, NULL) == PEND_OK && made == ROWS);
}

/* the largest gap of all quantities between two ways; checks that others are at most `most` */
static double ways_gap(double number[2][PEND_DERIVED * NUMBERS], int arms, int points) {
    double worst = 0;
    for (int what = 0; what < PEND_DERIVED; what++) {
        double most = 0;
        for (int j = 0; j < NUMBERS; j++) most = fmax(most, fabs(number[0][what * NUMBERS + j]));
        // arms without bodies exert forces along themselves only
        if (points && what == PEND_DERIVED_TIP_ACROSS) CHECK_SAYING(most < 1e-9, "%g", most);
        if (points && what == PEND_DERIVED_TIP_ACROSS) continue;
        double gap = test_gap(NUMBERS, number[0] + what * NUMBERS, number[1] + what * NUMBERS);
        CHECK_SAYING(gap < 1e-12, "%d arms, quantity %d: %g", arms, what, gap);
        worst = fmax(worst, gap);
    }
    return worst;
}

TEST(derivatives_of_ideal_pendulums_are_those_of_the_general_kernel) {
    static double number[2][PEND_DERIVED * NUMBERS];
    const int arms[] = {1, 2, 3, 4, 5, 8, 9, TALL, 1, 2};
    const size_t afloat = 8; // pendulums from this index on are without gravity
    unsigned long long seed = 41;
    double worst = 0;
    for (size_t i = 0; i < sizeof arms / sizeof *arms; i++) {
        OWN(test_tree, clear) t;
        struct pend_parameter by[MANY];
        test_tree_random(&t, TEST_TREE_ATTACHED, arms[i], 0.3, &seed);
        for (int j = 0; j < MANY; j++) {
            enum pend_parameter_kind kind = (enum pend_parameter_kind)(j % 5);
            int at = kind == PEND_PARAMETER_GRAVITY ? 0 : test_random_int(&seed, t.n);
            by[j] = (struct pend_parameter){kind, at};
        }
        memset(number, 0, sizeof number);
        for (int general = 0; general < 2; general++) {
            struct subject x;
            subject_make(&x, &t, general, NULL, 0, seed);
            if (i >= afloat) x.gravity = 0;
            everything(&x, by, number[general]);
            pend_terms_free(&x.terms);
        }
        worst = fmax(worst, ways_gap(number, arms[i], 1));
    }
    CHECK_RESIDUAL(worst, 1e-12, "derivatives of ideal pendulums by two kernels");
}

/* the same index in a list that has friction too, or lacks it */
static int place_in(const struct pend_terms *from, const struct pend_terms *to, int at) {
    for (int row = 0; row < PEND_TERM_ROWS; row++)
        if (from->row[row] >= 0 && at >= from->row[row] && at < from->row[row] + from->n)
            return to->row[row] + at - from->row[row];
    abort();
}

/* the gap between the two ways for a pendulum with rows of terms, for parameters of all kinds */
static double real_gap(int arms, const unsigned char rows[], int pivot, unsigned long long *seed) {
    static double number[2][PEND_DERIVED * NUMBERS];
    OWN(test_tree, clear) t;
    struct subject x[2];
    struct pend_parameter by[MANY];
    int center = -1;
    test_tree_random(&t, TEST_TREE_ATTACHED, arms, 0.3, seed);
    for (int general = 0; general < 2; general++)
        subject_make(&x[general], &t, general, rows, pivot, *seed);
    // bodies have their centers on their arms
    if (x[0].terms->row[PEND_TERM_CENTER_Y] >= 0) center = x[0].terms->row[PEND_TERM_CENTER_Y];
    int listed = x[0].terms->n;
    for (int row = 0; row < PEND_TERM_ROWS; row++)
        if (x[0].terms->row[row] + t.n > listed) listed = x[0].terms->row[row] + t.n;
    for (int j = 0; j < MANY; j++) {
        enum pend_parameter_kind kind = (enum pend_parameter_kind)(j % 8 > 5 ? 5 : j % 8);
        int at = kind == PEND_PARAMETER_GRAVITY ? 0 : test_random_int(seed, t.n);
        while (kind == PEND_PARAMETER_TERM && (at = test_random_int(seed, listed),
                                               center >= 0 && at >= center && at < center + t.n))
            continue;
        by[j] = (struct pend_parameter){kind, at};
    }
    memset(number, 0, sizeof number);
    CHECK(pend_ideal_suits(t.tree, &(struct pend_loads){9.81, x[0].terms, x[0].value}, MANY, by));
    everything(&x[0], by, number[0]);
    for (int j = 0; j < MANY; j++)
        if (by[j].kind == PEND_PARAMETER_TERM)
            by[j].at = place_in(x[0].terms, x[1].terms, by[j].at);
    CHECK(!pend_ideal_suits(t.tree, &(struct pend_loads){9.81, x[1].terms, x[1].value}, MANY, by));
    everything(&x[1], by, number[1]);
    double gap = ways_gap(number, arms, 0);
    for (int general = 0; general < 2; general++) pend_terms_free(&x[general].terms);
    return gap;
}

TEST(derivatives_of_real_pendulums_whose_motion_is_known_are_those_of_the_general_kernel) {
    const unsigned char rods[PEND_TERM_ROWS] = {[PEND_TERM_ROD] = 1, [PEND_TERM_DAMPING] = 1};
    const unsigned char bodies[PEND_TERM_ROWS] = {
        [PEND_TERM_ROD] = 1,     [PEND_TERM_BODY] = 1,      [PEND_TERM_CENTER_X] = 1,
        [PEND_TERM_INERTIA] = 1, [PEND_TERM_STIFFNESS] = 1, [PEND_TERM_REST] = 1,
        [PEND_TERM_TORQUE] = 1,  [PEND_TERM_DAMPING] = 1};
    const unsigned char points[PEND_TERM_ROWS] = {
        [PEND_TERM_DAMPING] = 1, [PEND_TERM_STIFFNESS] = 1, [PEND_TERM_REST] = 1};
    const unsigned char *rows[] = {rods, bodies, points};
    unsigned long long seed = 42;
    double worst = 0;
    for (int kind = 0; kind < 3; kind++)
        for (int arms = 1; arms <= 12; arms++)
            for (int pivot = 0; pivot < 2; pivot++)
                worst = fmax(worst, real_gap(arms, rows[kind], pivot, &seed));
    CHECK_RESIDUAL(worst, 1e-12, "derivatives of real pendulums by two kernels");
}

/* whether derivatives of two arms with respect to a parameter follow from the motion, for these
 * values */
static int suits(const struct subject *x, enum pend_parameter_kind kind, int at) {
    struct pend_parameter by = {kind, at};
    return pend_ideal_suits(x->t->tree, &(struct pend_loads){9.81, x->terms, x->value}, 1, &by);
}

TEST(derivatives_follow_from_the_motion_of_pendulums_whose_system_keeps_its_digits) {
    unsigned char rows[PEND_TERM_ROWS] = {
        [PEND_TERM_ROD] = 1, [PEND_TERM_BODY] = 1, [PEND_TERM_CENTER_X] = 1};
    unsigned long long seed = 43;
    OWN(test_tree, clear) t;
    struct subject x;
    test_tree_random(&t, TEST_TREE_ATTACHED, 2, 0.3, &seed);
    subject_make(&x, &t, 0, rows, 1, seed);
    const int *row = x.terms->row;
    CHECK(suits(&x, PEND_PARAMETER_PHI, 1) && suits(&x, PEND_PARAMETER_TERM, row[PEND_TERM_ROD]));
    CHECK(suits(&x, PEND_PARAMETER_TERM, row[PEND_TERM_INERTIA] + 1));
    // parameters that move centers off their arms, and drives
    CHECK(!suits(&x, PEND_PARAMETER_TERM, row[PEND_TERM_CENTER_Y]));
    CHECK(!suits(&x, PEND_PARAMETER_TERM, x.terms->harmonic[0].at));
    CHECK(!suits(&x, PEND_PARAMETER_TERM, x.terms->one[PEND_TERM_PIVOT_ACCELERATION_X]));
    x.value[row[PEND_TERM_CENTER_Y] + 1] = 1e-3;
    CHECK(!suits(&x, PEND_PARAMETER_PHI, 1));
    x.value[row[PEND_TERM_CENTER_Y] + 1] = 0;
    x.value[row[PEND_TERM_CENTER_X] + 1] = -2 * t.tree->len[1];
    CHECK(!suits(&x, PEND_PARAMETER_PHI, 1));
    x.value[row[PEND_TERM_CENTER_X] + 1] = -0.9 * t.tree->len[1];
    CHECK(suits(&x, PEND_PARAMETER_PHI, 1));
    // an arm that is negligible next to what hangs on it
    x.value[row[PEND_TERM_BODY] + 1] = 1e6;
    CHECK(!suits(&x, PEND_PARAMETER_PHI, 1));
    pend_terms_free(&x.terms);
    rows[PEND_TERM_AT_X] = rows[PEND_TERM_AT_Y] = 1;
    subject_make(&x, &t, 0, rows, 0, seed);
    CHECK(!suits(&x, PEND_PARAMETER_PHI, 1));
    pend_terms_free(&x.terms);
}

TEST(derivatives_of_a_light_rod_that_carries_a_heavy_one_keep_their_digits) {
    const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_ROD] = 1};
    static double number[2][PEND_DERIVED * NUMBERS];
    unsigned long long seed = 44;
    OWN(test_tree, clear) t;
    struct pend_parameter by[MANY];
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    for (int j = 0; j < MANY; j++)
        by[j] = (struct pend_parameter){(enum pend_parameter_kind)(j % 4), j / 4 % t.n};
    memset(number, 0, sizeof number);
    for (int general = 0; general < 2; general++) {
        struct subject x;
        subject_make(&x, &t, general, rows, 0, seed);
        x.value[x.terms->row[PEND_TERM_ROD] + 2] = 500 * t.tree->mass[1];
        x.value[x.terms->row[PEND_TERM_ROD] + 0] = 500 * t.tree->mass[1];
        CHECK(suits(&x, PEND_PARAMETER_PHI, 1) == !general);
        everything(&x, by, number[general]);
        pend_terms_free(&x.terms);
    }
    for (int what = 0; what < 2; what++) {
        double gap = test_gap(NUMBERS, number[0] + what * NUMBERS, number[1] + what * NUMBERS);
        CHECK_SAYING(gap < 1e-10, "quantity %d: %g", what, gap);
    }
}
