/* Tests of the linear algebra of orbits.
 * Leaves to others: multipliers of orbits (test_orbits).
 * Invariant: references are closed forms. */
#include "core/orbits/orbit_algebra.h"

#include <math.h>

#include "tests/harness/test.h"

TEST(orbit_algebra_solves_equations_and_says_where_it_cannot) {
    enum { N = 6 };
    struct orbit_algebra *algebra;
    double A[N * N], x[2 * N], B[2 * N] = {0};
    unsigned long long seed = 41;
    REQUIRE(pend_orbit_algebra_new(&algebra, N) == PEND_OK);
    for (int i = 0; i < N * N; i++) A[i] = 2 * test_random(&seed) - 1;
    for (int i = 0; i < 2 * N; i++) x[i] = test_random(&seed);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++)
            for (int j = 0; j < 2; j++) B[2 * i + j] += A[i * N + k] * x[2 * k + j];
    CHECK(pend_orbit_solve(algebra, N, A, 2, B));
    for (int i = 0; i < 2 * N; i++) CHECK(fabs(B[i] - x[i]) < 1e-13);
    for (int i = 0; i < N; i++) A[i * N + 2] = 0;
    CHECK(!pend_orbit_solve(algebra, N, A, 2, B));
    A[0] = NAN;
    CHECK(!pend_orbit_solve(algebra, N, A, 1, B));
    pend_orbit_algebra_free(&algebra);
}

TEST(orbit_algebra_has_the_eigenvalues_of_a_ring) {
    enum { N = 5 };
    struct orbit_algebra *algebra;
    double A[N * N] = {0}, re[N], im[N], product = 1;
    REQUIRE(pend_orbit_algebra_new(&algebra, N) == PEND_OK);
    for (int i = 0; i < N; i++) A[i * N + (i + 1) % N] = 2;
    CHECK(pend_orbit_eigenvalues(algebra, N, A, re, im) == PEND_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(hypot(re[i], im[i]) - 2) < 1e-13);
        CHECK(fabs(sin(N * atan2(im[i], re[i]))) < 1e-12);
        product *= hypot(re[i] - 2, im[i]);
    }
    CHECK(product < 1e-11); // 2 is an eigenvalue
    A[0] = INFINITY;
    CHECK(pend_orbit_eigenvalues(algebra, N, A, re, im) == PEND_NO_CONVERGENCE);
    CHECK(pend_orbit_eigenvalues(algebra, 0, A, re, im) == PEND_OK);
    pend_orbit_algebra_free(&algebra);
}

/* Two oscillators of frequencies 1 and w, of which only the first moves: after a quarter of its
 * period the second has turned by w pi / 2, so that the half period's eigenvalue is cos(w pi). */
TEST(orbit_algebra_has_the_multipliers_of_two_oscillators) {
    struct orbit_algebra *algebra;
    const double w = 1.3, c = cos(w * M_PI / 2), s = sin(w * M_PI / 2);
    const double phi_by[] = {0, 0, 1, 0, 0, c, 0, s / w}, gradient[] = {0.3, 0};
    const double rate_by[] = {-1, 0, 0, 0, 0, -w * s, 0, c};
    double work[8 * 4], re[1], im[1];
    REQUIRE(pend_orbit_algebra_new(&algebra, 4) == PEND_OK);
    CHECK(pend_orbit_mirrored(algebra, 2, phi_by, rate_by, gradient, 2.5, work, re, im) == PEND_OK);
    CHECK(fabs(re[0] - cos(w * M_PI)) < 1e-14 && im[0] == 0);
    const double nothing[2] = {0};
    CHECK(pend_orbit_mirrored(algebra, 2, phi_by, rate_by, nothing, 2.5, work, re, im) ==
          PEND_NO_CONVERGENCE);
    pend_orbit_algebra_free(&algebra);
}
