/* Law: the fast form of the dynamics equals the paper's matrix form, for every small tree and for
 * random large ones.
 * Leaves to others: single trees with known answers (tests/core).
 * Invariant: exact answers in quadruple precision; errors are relative to the largest component. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { MOST = 200 };

/* the largest errors so far, and the tree with the largest: the seed reproduces the tree */
struct worst {
    double acc, force;
    int n;
    unsigned long long seed;
};

static void worst_note(struct worst *worst, double acc, double force, int n,
                       unsigned long long seed) {
    // written so that NaN counts as the largest
    if (!(fmax(acc, force) <= fmax(worst->acc, worst->force)) || isnan(acc + force))
        worst->n = n, worst->seed = seed;
    if (!(acc <= worst->acc)) worst->acc = acc;
    if (!(force <= worst->force)) worst->force = force;
}

static void worst_check(const struct worst *worst, double acc, double force, const char *what,
                        const char *file, int line) {
    test_check_residual(worst->acc, acc, what, file, line);
    test_check_residual(worst->force, force, what, file, line);
    test_check(worst->acc <= acc && worst->force <= force, file, line,
               "%s: the worst has %d arms and seed %llu", what, worst->n, worst->seed);
}
#define WORST_CHECK(worst, acc, force, what)                                                       \
    worst_check(worst, acc, force, what, __FILE__, __LINE__)

/* the fast form against quadruple precision */
static void worst_of(struct worst *worst, const struct test_tree *t, unsigned long long seed) {
    double acc[MOST], force[MOST];
    test_quad exact_acc[MOST], exact_force[MOST];
    test_tree_dynamics(t, TEST_LOADS(9.81), acc, force);
    test_quad_dynamics(t->tree, TEST_LOADS(9.81), t->phi, t->rate, exact_acc, exact_force);
    worst_note(worst, test_quad_gap(t->n, acc, exact_acc), test_quad_gap(t->n, force, exact_force),
               t->n, seed);
}

/* all parent lists of up to 8 arms, with random states */
static int worst_of_all(struct worst *worst, double spread, unsigned long long seed) {
    int count = 0;
    for (int n = 1; n <= 8; n++) {
        int parent[8];
        test_parents_first(n, parent);
        do {
            struct test_tree t;
            unsigned long long begin = seed;
            test_tree_init(&t, n, parent, spread, &seed);
            worst_of(worst, &t, begin);
            test_tree_clear(&t);
            count++;
        } while (test_parents_next(n, parent));
    }
    return count;
}

TEST(law_fast_form_is_the_matrix_form_for_all_5914_trees_of_up_to_8_arms) {
    struct worst worst = {0};
    CHECK_INT(worst_of_all(&worst, 0.3, 1), 5914);
    WORST_CHECK(&worst, 1e-13, 1e-13, "masses of 10^+-0.3, up to 8 arms");
}

TEST(law_fast_form_is_the_matrix_form_for_all_5914_trees_with_masses_16_decades_apart) {
    struct worst worst = {0};
    CHECK_INT(worst_of_all(&worst, 8, 2), 5914);
    WORST_CHECK(&worst, 2e-11, 2e-11, "masses of 10^+-8, up to 8 arms");
}

static struct worst worst_of_random(double spread, int trees, int largest,
                                    unsigned long long seed) {
    struct worst worst = {0};
    for (int i = 0; i < trees; i++) {
        OWN(test_tree, clear) t;
        unsigned long long begin = seed;
        int n = 1 + test_random_int(&seed, largest);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, spread, &seed);
        worst_of(&worst, &t, begin);
    }
    return worst;
}

TEST(law_fast_form_is_the_matrix_form_for_random_trees_of_up_to_50_arms) {
    struct worst worst = worst_of_random(0.3, 40 * TEST_TREE_KINDS, 50, 3);
    WORST_CHECK(&worst, 1e-13, 1e-13, "masses of 10^+-0.3, up to 50 arms");
    worst = worst_of_random(3, 40 * TEST_TREE_KINDS, 50, 4);
    WORST_CHECK(&worst, 1e-12, 1e-12, "masses of 10^+-3, up to 50 arms");
    worst = worst_of_random(8, 40 * TEST_TREE_KINDS, 50, 5);
    WORST_CHECK(&worst, 5e-12, 5e-12, "masses of 10^+-8, up to 50 arms");
}

TEST(law_fast_form_is_the_matrix_form_for_random_trees_of_200_arms) {
    struct worst narrow = {0}, wide = {0};
    unsigned long long seed = 6;
    for (int i = 0; i < 2 * TEST_TREE_KINDS; i++) {
        OWN(test_tree, clear) t;
        unsigned long long begin = seed;
        test_tree_random(&t, (enum test_tree_kind)(i / 2), MOST, i % 2 ? 8 : 0.3, &seed);
        worst_of(i % 2 ? &wide : &narrow, &t, begin);
    }
    WORST_CHECK(&narrow, 1e-13, 1e-13, "masses of 10^+-0.3, 200 arms");
    WORST_CHECK(&wide, 3e-13, 3e-13, "masses of 10^+-8, 200 arms");
}

TEST(law_fast_form_is_the_matrix_form_for_small_trees_with_masses_16_decades_apart) {
    // many small trees: light joints between heavy arms in every arrangement
    struct worst worst = worst_of_random(8, 4000 * TEST_TREE_KINDS, 6, 7);
    WORST_CHECK(&worst, 5e-11, 1e-10, "masses of 10^+-8, up to 6 arms");
}

/* largest entry of A v - square v of a linearization of n arms */
static double eigen_miss(int n, const double a[], const double v[], double square) {
    double worst = 0;
    for (int i = 0; i < n; i++) {
        double product = 0;
        for (int j = 0; j < n; j++) product += a[n * i + j] * v[j];
        worst = fmax(worst, fabs(product - square * v[i]));
    }
    return worst;
}

TEST(law_of_the_matrix_form_knows_the_papers_pendulums) {
    static const double one[] = {1, 1, 1};
    struct pend_tree *tree;
    double a[9], inverse[9], worst = 0, r = sqrt(1.5);
    // the double pendulum, in units of g / l
    REQUIRE(pend_tree_new(&tree, 2, one, one, (const int[]){-1, 0}, NULL) == PEND_OK);
    test_quad_linearization(tree, 1, a, NULL);
    for (int s = -1; s <= 1; s += 2)
        worst = fmax(worst, eigen_miss(2, a, (double[]){1, -s * sqrt(2)}, 2 + s * sqrt(2)));
    pend_tree_free(&tree);
    // two arms at one joint
    const double vector[3][3] = {{1, r, r}, {0, 1, -1}, {1, -r, -r}};
    const double square[3] = {3 - sqrt(6), 1, 3 + sqrt(6)};
    REQUIRE(pend_tree_new(&tree, 3, one, one, (const int[]){-1, 0, 0}, NULL) == PEND_OK);
    test_quad_linearization(tree, 1, a, inverse);
    for (int mode = 0; mode < 3; mode++) {
        worst = fmax(worst, eigen_miss(3, a, vector[mode], square[mode]));
        worst = fmax(worst, eigen_miss(3, inverse, vector[mode], 1 / square[mode]));
    }
    pend_tree_free(&tree);
    CHECK_RESIDUAL(worst, 1e-14, "A v = omega^2 v of the paper's double and non-standard triple");
}

TEST(law_of_the_matrix_form_notices_wrong_variants) {
    // each variant correctly computes something slightly different
    unsigned long long seed = 9;
    OWN(test_tree, clear) t;
    double acc[8], force[8];
    test_quad exact_acc[8], exact_force[8];
    test_tree_random(&t, TEST_TREE_ATTACHED, 8, 0.3, &seed);
    test_quad_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, exact_acc, exact_force);
    test_tree_dynamics(&t, TEST_LOADS(-9.81), acc, force);
    CHECK_SAYING(test_quad_gap(8, acc, exact_acc) > 1e-2, "gravity upwards goes unseen");
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
    for (int k = 0; k < 8; k++) force[k] = -force[k];
    CHECK_SAYING(test_quad_gap(8, force, exact_force) > 1e-2,
                 "tension taken for compression goes unseen");
    t.phi[3] += 1e-9;
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
    CHECK_SAYING(test_quad_gap(8, acc, exact_acc) > 1e-12,
                 "an angle that is off by 1e-9 goes unseen");
    CHECK_SAYING(test_quad_gap(8, force, exact_force) > 1e-12,
                 "an angle that is off by 1e-9 goes unseen");
}
