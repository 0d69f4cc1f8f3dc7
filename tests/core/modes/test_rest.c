/* Tests of core/modes/rest: equilibria in O(n) per step, against the dense equations of motion.
 * Leaves to others: motion about them (test_damped, test_response).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/rest.h"

#include <math.h>

#include "tests/harness/bodies.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 9 };

TEST(rest_is_where_the_dense_form_has_no_acceleration) {
    unsigned long long seed = 1;
    double worst = 0;
    int found = 0, missed = 0;
    for (int i = 0; i < 80; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        double phi[ARMS];
        test_quad angle[ARMS], rate[ARMS] = {0}, acc[ARMS];
        unsigned terms = i % 4 == 3 ? TEST_TERMS_CART_ALL : TEST_TERMS_ALL;
        test_tree_random(&t, i % TEST_TREE_KINDS, ARMS, 0.5, &seed);
        test_bodies_random(&b, t.tree, i % 3 ? terms : terms & ~TEST_TERMS_SPRINGS, &seed);
        // terms that depend on time are ignored, and a cart without a spring rests only on a
        // horizontal rail
        for (int h = 0; h < b.terms->harmonics; h++) b.value[b.terms->harmonic[h].at] = 0;
        if (pend_terms_cart(b.terms) && i % 3 == 0) {
            b.value[b.terms->one[PEND_TERM_RAIL]] = 0;
            b.value[pend_terms_place(b.terms, PEND_TERM_TORQUE, 0)] = 0;
        }
        for (int k = 0; k < ARMS; k++) phi[k] = -M_PI_2;
        struct test_quad_state state = {angle, rate, 0};
        if (pend_rest_find(t.tree, &b.loads, phi, NULL, NULL) == PEND_OK) {
            for (int k = 0; k < ARMS; k++) angle[k] = phi[k];
            test_quad_bodies(t.tree, &b.loads, &state, acc, NULL);
            for (int k = 0; k < ARMS; k++) worst = fmax(worst, fabs((double)acc[k]));
            found++;
        } else if (i % 3) {
            missed++;
        }
    }
    // if each joint has a spring there is an equilibrium
    CHECK_INT(missed, 0);
    CHECK(found > 70);
    CHECK_RESIDUAL(worst, 1e-11, "accelerations at rest, rad/s^2");
}

TEST(rest_with_springs_is_found_from_anywhere_without_weight_too) {
    unsigned long long seed = 4;
    for (int i = 0; i < 400; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        double phi[ARMS];
        int stable;
        test_tree_random(&t, i % TEST_TREE_KINDS, 1 + i % ARMS, 0.5, &seed);
        test_bodies_random(&b, t.tree, i % 2 ? TEST_TERMS_ALL : TEST_TERMS_SPRINGS, &seed);
        for (int h = 0; h < b.terms->harmonics; h++) b.value[b.terms->harmonic[h].at] = 0;
        if (i % 2 == 0) b.loads.gravity = 0;
        for (int k = 0; k < t.tree->n; k++) phi[k] = 12 * test_random(&seed) - 6;
        CHECK(pend_rest_find(t.tree, &b.loads, phi, &stable, NULL) == PEND_OK);
        // without weight the springs' potential has one minimum and no other stationary point
        if (i % 2 == 0) CHECK(stable);
    }
}

TEST(rest_knows_whether_it_is_stable) {
    unsigned long long seed = 2;
    for (int i = 0; i < 30; i++) {
        OWN(test_tree, clear) t;
        double phi[ARMS];
        int stable, standing = test_random_int(&seed, 1 << ARMS);
        test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.5, &seed);
        for (int k = 0; k < ARMS; k++) phi[k] = (standing >> k) & 1 ? M_PI_2 : -M_PI_2;
        REQUIRE(pend_rest_find(t.tree, TEST_LOADS(9.81), phi, &stable, NULL) == PEND_OK);
        CHECK_INT(stable, standing == 0);
        for (int k = 0; k < ARMS; k++) CHECK(fabs(phi[k]) == M_PI_2);
    }
}

TEST(rest_of_nothing_that_pulls_is_where_it_is_and_a_torque_beyond_gravity_has_none) {
    const double l = 1, m = 1;
    const int parent = -1;
    OWN(pend_tree, free) *tree;
    OWN(pend_terms, free) *terms = NULL;
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
}
