/* Tests of core/modes/rest: equilibria in O(n) a step, against dense ones.
 * Leaves to others: motion about them (test_damped, test_response).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/rest.h"

#include <math.h>

#include "core/modes/damped.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 9 };

TEST(rest_is_where_dense_matrices_find_it) {
    unsigned long long seed = 1;
    double worst = 0;
    int found = 0;
    for (int i = 0; i < 60; i++) {
        struct test_tree t;
        struct test_bodies b;
        double near[ARMS], phi[ARMS];
        test_tree_random(&t, i % TEST_TREE_KINDS, ARMS, 0.5, &seed);
        test_bodies_random(&b, t.tree,
                           i % 3 ? TEST_TERMS_ALL : TEST_TERMS_ALL & ~TEST_TERMS_SPRINGS, &seed);
        for (int k = 0; k < ARMS; k++) near[k] = phi[k] = -M_PI_2;
        int steps = pend_damped_equilibrium(t.tree, &b.loads, near), stable = 0;
        enum pend_status status = pend_rest_find(t.tree, &b.loads, phi, &stable, NULL);
        CHECK((status == PEND_OK) == (steps >= 0));
        for (int k = 0; k < ARMS && status == PEND_OK; k++)
            worst = fmax(worst, fabs(near[k] - phi[k]));
        found += status == PEND_OK;
        test_bodies_clear(&b);
        test_tree_clear(&t);
    }
    CHECK(found > 50);
    CHECK_RESIDUAL(worst, 1e-13, "angles of equilibria, rad");
}

TEST(rest_knows_whether_it_is_stable) {
    unsigned long long seed = 2;
    for (int i = 0; i < 30; i++) {
        struct test_tree t;
        double phi[ARMS];
        int stable, standing = test_random_int(&seed, 1 << ARMS);
        test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.5, &seed);
        for (int k = 0; k < ARMS; k++) phi[k] = (standing >> k) & 1 ? M_PI_2 : -M_PI_2;
        REQUIRE(pend_rest_find(t.tree, TEST_LOADS(9.81), phi, &stable, NULL) == PEND_OK);
        CHECK_INT(stable, standing == 0);
        for (int k = 0; k < ARMS; k++) CHECK(fabs(phi[k]) == M_PI_2);
        test_tree_clear(&t);
    }
}

TEST(rest_of_nothing_that_pulls_is_where_it_is_and_a_torque_beyond_gravity_has_none) {
    const double l = 1, m = 1;
    const int parent = -1;
    struct pend_tree *tree;
    struct pend_terms *terms;
    struct pend_error error = {0};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    double phi = 0.3, torque = 20;
    int stable = 1;
    REQUIRE(pend_tree_new(&tree, 1, &l, &m, &parent, NULL) == PEND_OK);
    CHECK(pend_rest_find(tree, TEST_LOADS(0), &phi, &stable, NULL) == PEND_OK);
    CHECK(phi == 0.3 && !stable);
    rows[PEND_TERM_TORQUE] = 1;
    REQUIRE(pend_terms_new(&terms, 1, rows, ones, 0, NULL, NULL) == PEND_OK);
    const struct pend_loads loads = {9.81, terms, &torque};
    CHECK(pend_rest_find(tree, &loads, &phi, &stable, &error) == PEND_NOT_FINITE);
    CHECK(error.text[0] == 'n');
    torque = 9.81 * sin(0.5);
    phi = -M_PI_2;
    CHECK(pend_rest_find(tree, &loads, &phi, &stable, &error) == PEND_OK && stable);
    CHECK_RESIDUAL(fabs(phi + M_PI_2 - 0.5) + 1e-17, 1e-14, "a torque of m g l sin(1/2)");
    pend_terms_free(&terms);
    pend_tree_free(&tree);
}
