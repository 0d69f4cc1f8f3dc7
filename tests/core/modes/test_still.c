/* Tests of core/modes/still: modes without a matrix, against dense ones, and their residuals for
 * many arms.
 * Leaves to others: friction (test_damped), ideal pendulums (test_modes).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/still.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/damped.h"
#include "core/modes/rest.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { STILL = TEST_TERMS_RODS | TEST_TERMS_SPRINGS };

/* omega^2 and vectors of a pendulum about the equilibrium found from hanging; phi is that
 * equilibrium */
static double *still_of(const struct test_tree *t, const struct pend_loads *loads, double phi[]) {
    size_t n = (size_t)t->n;
    double *square = malloc((n + n * n) * sizeof *square);
    OWN(pend_still, free) *still;
    for (int k = 0; k < t->n; k++) phi[k] = k || !pend_terms_cart(loads->terms) ? -M_PI_2 : 0;
    if (!(square != NULL)) abort();
    if (!(pend_rest_find(t->tree, loads, phi, NULL, NULL) == PEND_OK)) abort();
    if (!(pend_still_new(&still, t->tree, loads, phi) == PEND_OK)) abort();
    int steps = 1;
    while (!pend_still_step(still, square, square + n)) steps++;
    CHECK(t->n < 200 || steps > 20);
    return square;
}

/* the largest residual of K x = s M x and of x^T M x = 1, relative to the largest entries */
static double residual(const struct test_tree *t, const struct pend_loads *loads,
                       const double phi[], const double square[]) {
    size_t n = (size_t)t->n;
    double *mass = malloc(3 * n * n * sizeof *mass), *stiff = mass + 2 * n * n, worst = 0, most = 0;
    if (!(mass != NULL)) abort();
    if (!(pend_damped_matrices(t->tree, loads, phi, mass, mass + n * n, stiff) == PEND_OK)) abort();
    for (size_t j = 0; j < n; j++) most = fmax(most, fabs(square[j]));
    for (size_t j = 0; j < n; j++) {
        const double *x = square + n + j * n;
        for (size_t i = 0; i <= j; i += j < 40 || i + 3 > j ? 1 : 37) {
            const double *y = square + n + i * n;
            double product = 0, elastic = 0;
            for (size_t a = 0; a < n; a++) {
                double m = 0, k = 0;
                for (size_t b = 0; b < n; b++)
                    m += mass[a * n + b] * x[b], k += stiff[a * n + b] * x[b];
                product += y[a] * m, elastic += y[a] * k;
            }
            worst = fmax(worst, fabs(product - (i == j)));
            worst = fmax(worst, fabs(elastic - (i == j ? square[j] : 0)) / most);
        }
    }
    free(mass);
    return worst;
}

TEST(still_finds_the_modes_that_dense_matrices_have) {
    unsigned long long seed = 1;
    double worst = 0, left = 0;
    for (int i = 0; i < 36; i++) {
        enum { MOST = 24 };
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        OWN(pend_damped, free) *d;
        double phi[MOST], start[MOST];
        int n = 2 + i % (MOST - 2);
        test_tree_random(&t, i % TEST_TREE_KINDS, n, 0.5, &seed);
        test_bodies_random(&b, t.tree, STILL | (i % 3 ? 0 : TEST_TERMS_CART), &seed);
        OWN_MEMORY double *square = still_of(&t, &b.loads, phi);
        for (int k = 0; k < n; k++) start[k] = phi[k];
        REQUIRE(pend_damped_new(&d, t.tree, &b.loads, start, NULL) == PEND_OK);
        double most = fabs(square[n - 1]);
        for (int j = 0; j < n && d->count == n; j++)
            worst = fmax(worst, fabs(square[j] - d->omega[j] * d->omega[j]) / most);
        left = fmax(left, residual(&t, &b.loads, phi, square));
    }
    CHECK_RESIDUAL(worst, 1e-13, "omega^2 against dense matrices, of the largest");
    CHECK_RESIDUAL(left, 1e-11, "K x = s M x, x^T M x = 1");
}

TEST(still_finds_like_branches_and_what_stands) {
    // a star has n - 2 equal modes; those of upright arms grow
    enum { N = 12 };
    unsigned long long seed = 2;
    int parent[N];
    for (int k = 0; k < N; k++) parent[k] = k ? 0 : -1;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    double phi[N];
    test_tree_init(&t, N, parent, 0, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_SPRINGS, &seed);
    for (int k = 0; k < N; k++) {
        b.value[b.terms->row[PEND_TERM_STIFFNESS] + k] = 1;
        b.value[b.terms->row[PEND_TERM_REST] + k] = 0;
        t.length[k] = t.mass[k] = 1;
    }
    test_tree_rebuild(&t);
    double *square = still_of(&t, &b.loads, phi);
    CHECK_RESIDUAL(residual(&t, &b.loads, phi, square), 1e-13, "modes of a star");
    CHECK(square[1] > 0 && fabs(square[1] / square[N - 2] - 1) < 1e-13);
    free(square);
    OWN(pend_still, free) *still;
    for (int k = 0; k < N; k++) phi[k] = k % 2 ? M_PI_2 : -M_PI_2;
    b.loads.terms = NULL;
    REQUIRE(pend_still_new(&still, t.tree, &b.loads, phi) == PEND_OK);
    CHECK_INT(pend_still_below(still, 0), N / 2);
}

TEST(still_finds_all_modes_of_some_hundred_arms_with_springs_and_rods) {
    enum { N = 300 };
    unsigned long long seed = 3;
    static double phi[N];
    double left = 0;
    for (int i = 0; i < 2; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        test_tree_random(&t, i ? TEST_TREE_LIMBS : TEST_TREE_ATTACHED, N, 0.3, &seed);
        test_bodies_random(&b, t.tree, STILL, &seed);
        OWN_MEMORY double *square = still_of(&t, &b.loads, phi);
        for (int j = 1; j < N; j++) CHECK(square[j] >= square[j - 1] * (1 - 1e-9));
        left = fmax(left, residual(&t, &b.loads, phi, square));
    }
    CHECK_RESIDUAL(left, 3e-12, "K x = s M x, x^T M x = 1");
}

TEST(still_ends_where_nothing_pulls_back) {
    enum { N = 30, MOST = 100000 };
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    OWN(pend_still, free) *still = NULL;
    double phi[N], square[N];
    int steps = 0;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_RODS, &seed);
    b.loads.gravity = 0;
    for (int k = 0; k < N; k++) phi[k] = -M_PI_2;
    OWN_MEMORY double *vector = malloc(sizeof(double[N][N]));
    REQUIRE(vector && pend_still_new(&still, t.tree, &b.loads, phi) == PEND_OK);
    while (!pend_still_step(still, square, vector) && steps < MOST) steps++;
    CHECK_SAYING(steps < MOST, "%d steps", steps);
    for (int k = 0; k < N; k++) CHECK(fabs(square[k]) < 1e-12);
}
