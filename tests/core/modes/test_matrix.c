/* Tests of core/modes/matrix: its rows against the full matrices of quad and tree, and against each
 * other about any equilibrium.
 * Leaves to others: those matrices themselves (test_matrix_form, test_tree).
 * Invariant: masses of 10^±0.3. */
#include "core/modes/matrix.h"

#include <math.h>
#include <stdlib.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { N = 25 };

TEST(matrix_rows_are_those_of_the_whole_matrices) {
    unsigned long long seed = 71;
    double worst_a = 0, worst_m = 0, other = 0;
    for (int round = 0; round < 60; round++) {
        int n = 1 + test_random_int(&seed, N);
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)(round % TEST_TREE_KINDS), n, 0.3, &seed);
        double a[N * N], m[N * N], im[N * N], s[N * N], b[N * N], row[N], zero[N] = {0}, size_a = 0,
                                                                          size_m = 0;
        test_quad_linearization(t.tree, 9.81, a, NULL);
        test_quad_inertia(t.tree, zero, m, im);
        pend_tree_path(t.tree, s);
        pend_tree_force_map(t.tree, b);
        for (int i = 0; i < n * n; i++)
            size_a = fmax(size_a, fabs(a[i])), size_m = fmax(size_m, fabs(m[i]));
        for (int i = 0; i < n; i++) {
            int at = t.tree->place[i];
            pend_matrix_row(t.tree, TEST_LOADS(9.81), NULL, PEND_MATRIX_A, i, row);
            for (int j = 0; j < n; j++)
                worst_a = fmax(worst_a, fabs(row[j] - a[at * n + t.tree->place[j]]) / size_a);
            pend_matrix_row(t.tree, TEST_LOADS(9.81), NULL, PEND_MATRIX_M, i, row);
            for (int j = 0; j < n; j++)
                worst_m = fmax(worst_m, fabs(row[j] - m[at * n + t.tree->place[j]]) / size_m);
            pend_matrix_row(t.tree, TEST_LOADS(9.81), NULL, PEND_MATRIX_S, i, row);
            for (int j = 0; j < n; j++) other = fmax(other, fabs(row[j] - s[i * n + j]));
            pend_matrix_row(t.tree, TEST_LOADS(9.81), NULL, PEND_MATRIX_B, i, row);
            for (int j = 0; j < n; j++) other = fmax(other, fabs(row[j] - b[i * n + j]));
        }
    }
    CHECK_RESIDUAL(worst_a, 5e-15, "rows of A");
    CHECK_RESIDUAL(worst_m, 1e-15, "rows of M against S^T diag(m) S");
    CHECK(other == 0);
}

TEST(matrix_a_times_m_is_the_stiffness_about_any_equilibrium) {
    unsigned long long seed = 72;
    double worst = 0;
    for (int round = 0; round < 60; round++) {
        int n = 1 + test_random_int(&seed, N);
        OWN(test_tree, clear) t;
        unsigned char up[N];
        double a[N][N], m[N][N], size = 0, wrong = 0;
        test_tree_random(&t, (enum test_tree_kind)(round % TEST_TREE_KINDS), n, 0.3, &seed);
        for (int k = 0; k < n; k++) up[k] = (unsigned char)(test_random(&seed) < 0.5);
        for (int i = 0; i < n; i++) {
            pend_matrix_row(t.tree, TEST_LOADS(9.81), up, PEND_MATRIX_A, i, a[i]);
            pend_matrix_row(t.tree, TEST_LOADS(9.81), up, PEND_MATRIX_M, i, m[i]);
        }
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                int k = t.tree->place[j];
                double sum = 0, terms = 0, pull = 9.81 * t.tree->len[k] * t.tree->subtree_mass[k];
                for (int p = 0; p < n; p++)
                    sum += m[i][p] * a[p][j], terms += fabs(m[i][p] * a[p][j]);
                wrong = fmax(wrong, fabs(sum - (i == j ? up[k] ? -pull : pull : 0)));
                size = fmax(size, terms);
            }
        worst = fmax(worst, wrong / size);
    }
    CHECK_RESIDUAL(worst, 1e-14, "M A = g diag(±l S^T m)");
}
