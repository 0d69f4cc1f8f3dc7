/* Tests of core/dynamics/reference: the paper's matrices against quadruple precision and known
 * answers.
 * Leaves to others: agreement of the fast form (laws).
 * Invariant: masses of 10^±0.3, where a dense double factorization keeps 11 digits. */
#include "core/dynamics/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { N = 30 };

TEST(reference_dynamics_agree_with_quadruple_precision) {
    unsigned long long seed = 1;
    double worst_acc = 0, worst_force = 0;
    for (int i = 0; i < 20 * TEST_TREE_KINDS; i++) {
        struct test_tree t;
        double acc[N], force[N], alone[N];
        test_quad exact_acc[N], exact_force[N];
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                         1 + test_random_int(&seed, N), 0.3, &seed);
        REQUIRE(pend_reference_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, acc, force) ==
                PEND_OK);
        REQUIRE(pend_reference_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, alone, NULL) ==
                PEND_OK);
        test_quad_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, exact_acc, exact_force);
        worst_acc = fmax(worst_acc, test_quad_gap(t.n, acc, exact_acc));
        worst_force = fmax(worst_force, test_quad_gap(t.n, force, exact_force));
        CHECK(!memcmp(acc, alone, (size_t)t.n * sizeof *acc));
        test_tree_clear(&t);
    }
    CHECK_RESIDUAL(worst_acc, 1e-12, "(aaa) in doubles");
    CHECK_RESIDUAL(worst_force, 1e-12, "(bbb) in doubles");
}

TEST(reference_mass_matrix_is_hermitian_with_the_hanging_masses_on_its_diagonal) {
    unsigned long long seed = 2;
    double worst = 0, worst_diagonal = 0, largest_imaginary = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        struct test_tree t;
        double re[N * N], im[N * N];
        test_tree_random(&t, (enum test_tree_kind)kind, N, 0.3, &seed);
        REQUIRE(pend_reference_mass_matrix(t.tree, t.phi, re, im) == PEND_OK);
        for (int i = 0; i < N; i++) {
            double diagonal = t.tree->len[i] * t.tree->len[i] * t.tree->subtree_mass[i];
            worst_diagonal = fmax(worst_diagonal, fabs(re[i * N + i] / diagonal - 1));
            for (int j = 0; j < N; j++) {
                double size = sqrt(re[i * N + i] * re[j * N + j]);
                worst = fmax(worst, fabs(re[i * N + j] - re[j * N + i]) / size);
                worst = fmax(worst, fabs(im[i * N + j] + im[j * N + i]) / size);
                largest_imaginary = fmax(largest_imaginary, fabs(im[i * N + j]) / size);
            }
        }
        test_tree_clear(&t);
    }
    CHECK_RESIDUAL(worst, 4e-16, "M is Hermitian");
    CHECK_RESIDUAL(worst_diagonal, 2e-14, "M_kk = l_k^2 (S^T m)_k");
    CHECK(largest_imaginary > 0.1);
}

TEST(reference_inverse_of_a_has_the_lengths_on_its_diagonal) {
    unsigned long long seed = 3;
    double worst = 0, worst_product = 0, spoilt = 0;
    for (int i = 0; i < 6 * TEST_TREE_KINDS; i++) {
        struct test_tree t;
        double a[N * N], inverse[N * N], gravity = 1 + 20 * test_random(&seed);
        int n = 1 + test_random_int(&seed, N);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, 0.3, &seed);
        REQUIRE(pend_reference_linearization(t.tree, TEST_LOADS(gravity), a, inverse) == PEND_OK);
        for (int k = 0; k < n; k++) {
            worst = fmax(worst, fabs(inverse[k * n + k] / (t.tree->len[k] / gravity) - 1));
            for (int j = 0; j < n; j++) {
                double product = 0, transposed = 0, size = 0;
                for (int p = 0; p < n; p++) {
                    product += a[k * n + p] * inverse[p * n + j];
                    transposed += a[k * n + p] * inverse[j * n + p];
                    size += fabs(a[k * n + p] * inverse[p * n + j]);
                }
                worst_product = fmax(worst_product, fabs(product - (k == j)) / fmax(size, 1));
                spoilt = fmax(spoilt, fabs(transposed - (k == j)));
            }
        }
        test_tree_clear(&t);
    }
    CHECK_RESIDUAL(worst, 1e-14, "(A^-1)_kk = l_k / g");
    CHECK_RESIDUAL(worst_product, 1e-12, "A A^-1 = I");
    CHECK_SAYING(spoilt > 0.1, "A A^-T = I goes unseen");
}

TEST(reference_linearization_knows_the_papers_pendulums) {
    // the double: A v = omega^2 v with omega^2 = 2 -+ sqrt 2 and v = (1, +-sqrt 2), in units of g/l
    static const double one[] = {1, 1, 1};
    struct pend_tree *tree;
    double a[9], worst = 0;
    REQUIRE(pend_tree_new(&tree, 2, one, one, (const int[]){-1, 0}, NULL) == PEND_OK);
    REQUIRE(pend_reference_linearization(tree, TEST_LOADS(1), a, NULL) == PEND_OK);
    for (int s = -1; s <= 1; s += 2)
        for (int i = 0; i < 2; i++) {
            double v[] = {1, -s * sqrt(2)}, square = 2 + s * sqrt(2);
            worst = fmax(worst, fabs(a[2 * i] * v[0] + a[2 * i + 1] * v[1] - square * v[i]));
        }
    pend_tree_free(&tree);

    // two arms at one joint: omega^2 = 3 -+ sqrt 6 with (1, +-r, +-r), and 1 with (0, 1, -1), r =
    // sqrt(3/2)
    double r = sqrt(1.5);
    const double vector[3][3] = {{1, r, r}, {0, 1, -1}, {1, -r, -r}};
    const double square[3] = {3 - sqrt(6), 1, 3 + sqrt(6)};
    REQUIRE(pend_tree_new(&tree, 3, one, one, (const int[]){-1, 0, 0}, NULL) == PEND_OK);
    REQUIRE(pend_reference_linearization(tree, TEST_LOADS(1), a, NULL) == PEND_OK);
    for (int mode = 0; mode < 3; mode++)
        for (int i = 0; i < 3; i++) {
            double product = 0;
            for (int j = 0; j < 3; j++) product += a[3 * i + j] * vector[mode][j];
            worst = fmax(worst, fabs(product - square[mode] * vector[mode][i]));
        }
    pend_tree_free(&tree);
    CHECK_RESIDUAL(worst, 1e-14, "A v = omega^2 v of the paper's double and non-standard triple");
}

TEST(reference_says_what_it_cannot_do) {
    static const double one[] = {1, 1, 1}, huge[] = {1e200, 1e200, 1e200}, zero[] = {0, 0, 0};
    static const int parent[] = {-1, 0, 1};
    struct pend_tree *tree;
    double a[9], acc[3], force[3];
    REQUIRE(pend_tree_new(&tree, 3, one, one, parent, NULL) == PEND_OK);
    CHECK_INT(pend_reference_linearization(tree, TEST_LOADS(0), a, a), PEND_INVALID);
    CHECK_INT(pend_reference_linearization(tree, TEST_LOADS(0), a, NULL), PEND_OK);
    pend_tree_free(&tree);
    REQUIRE(pend_tree_new(&tree, 3, huge, one, parent, NULL) == PEND_OK);
    CHECK_INT(pend_reference_dynamics(tree, TEST_LOADS(9.81), zero, zero, acc, force),
              PEND_NOT_FINITE);
    CHECK_INT(pend_reference_linearization(tree, TEST_LOADS(9.81), a, NULL), PEND_NOT_FINITE);
    pend_tree_free(&tree);
}

TEST(reference_survives_any_allocation_that_fails) {
    static const double one[] = {1, 1, 1}, angle[] = {0.1, 0.2, 0.3};
    struct pend_tree *tree;
    double re[9], im[9], acc[3], force[3];
    REQUIRE(pend_tree_new(&tree, 3, one, one, (const int[]){-1, 0, 1}, NULL) == PEND_OK);
    int failures = 0;
    for (int for_good = 0; for_good < 2; for_good++)
        for (int call = 0; call < 3; call++)
            for (long count = 1;; count++) {
                enum pend_status status;
                test_alloc_fail(count, for_good);
                if (call == 0)
                    status = pend_reference_mass_matrix(tree, angle, re, im);
                else if (call == 1)
                    status =
                        pend_reference_dynamics(tree, TEST_LOADS(9.81), angle, angle, acc, force);
                else
                    status = pend_reference_linearization(tree, TEST_LOADS(9.81), re, im);
                test_alloc_faults_off();
                if (status == PEND_OK) break;
                CHECK_INT(status, PEND_NO_MEMORY);
                failures++;
            }
    CHECK_INT(failures, 12);
    CHECK(pend_tree_valid(tree));
    pend_tree_free(&tree);
}
