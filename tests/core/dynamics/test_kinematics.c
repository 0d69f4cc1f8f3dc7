/* Tests of core/dynamics/kinematics: positions, velocities, accelerations, energies and forces
 * against their definitions.
 * Leaves to others: conservation and balance of forces (laws).
 * Invariant: definitions are written out with S, through pend_tree_path, tip by tip. */
#include "core/dynamics/kinematics.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { N = 40 };

/* S times a vector over the arms, all in stored order */
static void sum_over_paths(const struct test_tree *t, const double complex arm[],
                           double complex tip[]) {
    double path[N * N];
    const int *order = t->tree->order;
    pend_tree_path(t->tree, path);
    for (int k = 0; k < t->n; k++) {
        tip[k] = 0;
        for (int j = 0; j < t->n; j++) tip[k] += path[order[k] * t->n + order[j]] * arm[j];
    }
}

static double gap_complex(int n, const double re[], const double im[],
                          const double complex want[]) {
    double most = 0, gap = 0;
    for (int k = 0; k < n; k++) {
        most = fmax(most, cabs(want[k]));
        gap = fmax(gap, hypot(re[k] - creal(want[k]), im[k] - cimag(want[k])));
    }
    return gap / most;
}

TEST(kinematics_of_tips_is_the_sum_over_their_paths) {
    unsigned long long seed = 1;
    double worst[3] = {0}, spoilt = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        double complex z[N], zd[N], zdd[N], tip[N];
        double re[N], im[N], acc[N], force[N];
        test_tree_random(&t, (enum test_tree_kind)kind, N, 1, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        for (int k = 0; k < N; k++) {
            z[k] = t.tree->len[k] * cexp(I * t.phi[k]);
            zd[k] = I * t.rate[k] * z[k];
            zdd[k] = (I * acc[k] - t.rate[k] * t.rate[k]) * z[k];
        }
        sum_over_paths(&t, z, tip);
        pend_kinematics_position(t.tree, t.phi, re, im);
        worst[0] = fmax(worst[0], gap_complex(N, re, im, tip));
        spoilt = fmax(spoilt, gap_complex(N, im, re, tip));
        sum_over_paths(&t, zd, tip);
        pend_kinematics_velocity(t.tree, t.phi, t.rate, re, im);
        worst[1] = fmax(worst[1], gap_complex(N, re, im, tip));
        sum_over_paths(&t, zdd, tip);
        pend_kinematics_acceleration(t.tree, t.phi, t.rate, acc, re, im);
        worst[2] = fmax(worst[2], gap_complex(N, re, im, tip));
    }
    CHECK_RESIDUAL(worst[0], 1e-15, "z = S [l e^{i phi}]");
    CHECK_RESIDUAL(worst[1], 1e-15, "z' = S [i phi' l e^{i phi}]");
    CHECK_RESIDUAL(worst[2], 1e-15, "z'' = S [(i phi'' - phi'^2) l e^{i phi}]");
    CHECK_SAYING(spoilt > 0.1, "exchanging re and im goes unseen: %g", spoilt);
}

TEST(kinematics_energy_is_the_sum_over_tips) {
    unsigned long long seed = 2;
    double worst = 0, worst_potential = 0;
    for (int i = 0; i < 20 * TEST_TREE_KINDS; i++) {
        OWN(test_tree, clear) t;
        double z_re[N], z_im[N], re[N], im[N];
        long double kinetic = 0, potential = 0, size = 0;
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                         1 + test_random_int(&seed, N), 1, &seed);
        pend_kinematics_position(t.tree, t.phi, z_re, z_im);
        pend_kinematics_velocity(t.tree, t.phi, t.rate, re, im);
        for (int k = 0; k < t.n; k++) {
            long double m = t.tree->mass[k];
            kinetic += m * ((long double)re[k] * re[k] + (long double)im[k] * im[k]) / 2;
            potential += 9.81L * m * z_im[k];
            size += 9.81L * m * fabs(z_im[k]);
        }
        struct pend_energy energy = pend_kinematics_energy(t.tree, TEST_LOADS(9.81), t.phi, t.rate);
        worst = fmax(worst, fabs((double)((energy.kinetic - kinetic) / kinetic)));
        worst_potential =
            fmax(worst_potential, fabs((double)((energy.potential - potential) / size)));
    }
    CHECK_RESIDUAL(worst, 1e-14, "kinetic energy = sum m |z'|^2 / 2");
    CHECK_RESIDUAL(worst_potential, 1e-14, "potential energy = g sum m Im z");
}

TEST(kinematics_energies_of_several_states_are_those_of_each) {
    enum { STATES = 7 };
    unsigned long long seed = 4;
    int same = 0;
    for (int n = 1; n <= N; n++) {
        OWN(test_tree, clear) t;
        double phi[STATES * N], rate[STATES * N];
        struct pend_energy energy[STATES];
        test_tree_random(&t, (enum test_tree_kind)(n % TEST_TREE_KINDS), n, 1, &seed);
        for (int i = 0; i < STATES * n; i++) {
            // some angles are beyond the range of the vectorized sines
            phi[i] = (i % 11 ? 1 : 1e7) * (test_random(&seed) - 0.5) * 6;
            rate[i] = test_random(&seed) - 0.5;
        }
        pend_kinematics_energies(t.tree, TEST_LOADS(9.81), STATES, phi, rate, energy);
        for (int i = 0; i < STATES; i++) {
            struct pend_energy alone =
                pend_kinematics_energy(t.tree, TEST_LOADS(9.81), phi + i * n, rate + i * n);
            same += alone.kinetic == energy[i].kinetic && alone.potential == energy[i].potential;
        }
    }
    CHECK_INT(same, STATES * N);
}

TEST(kinematics_kinetic_energy_is_the_quadratic_form_of_re_m) {
    unsigned long long seed = 3;
    double worst = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        double re[N * N], im[N * N], form = 0;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 0.3, &seed);
        test_quad_inertia(t.tree, t.phi, re, im);
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) form += t.rate[i] * re[i * N + j] * t.rate[j] / 2;
        worst = fmax(
            worst,
            fabs(pend_kinematics_energy(t.tree, TEST_LOADS(9.81), t.phi, t.rate).kinetic / form -
                 1));
    }
    CHECK_RESIDUAL(worst, 1e-13, "kinetic energy = phi'^T Re M phi' / 2");
}

TEST(kinematics_energy_keeps_its_digits_in_a_long_chain) {
    // a straight horizontal chain that rotates as a whole: the energies are known sums of integers
    enum { LONG = 100000 };
    double *one = malloc(3 * LONG * sizeof *one), *zero = one + LONG, *rate = zero + LONG;
    OWN_MEMORY int *parent = malloc(LONG * sizeof *parent);
    OWN(pend_tree, free) *tree = NULL;
    REQUIRE(one && parent);
    for (int k = 0; k < LONG; k++) one[k] = 1, zero[k] = 0, rate[k] = 3, parent[k] = k - 1;
    REQUIRE(pend_tree_new(&tree, LONG, one, one, parent, NULL) == PEND_OK);
    double n = LONG, squares = n * (n + 1) * (2 * n + 1) / 6;
    struct pend_energy energy = pend_kinematics_energy(tree, TEST_LOADS(9.81), zero, rate);
    CHECK(energy.kinetic == 4.5 * squares);
    CHECK(energy.potential == 0);
    for (int k = 0; k < LONG; k++) zero[k] = 1.5707963267948966;
    energy = pend_kinematics_energy(tree, TEST_LOADS(9.81), zero, rate);
    CHECK(fabs(energy.potential / (9.81 * n * (n + 1) / 2) - 1) < 1e-15);
    CHECK_RESIDUAL(fabs(pend_kinematics_energy_scale(tree, TEST_LOADS(-9.81), 7) /
                            (9.81 * n * (n + 1) / 2 + 7) -
                        1),
                   1e-15, "energy scale of a chain");
    free(one);
}

TEST(kinematics_energy_keeps_its_digits_in_a_wide_star) {
    enum { WIDE = 200000 };
    unsigned long long seed = 6;
    OWN(test_tree, clear) t = {0};
    long double kinetic = 0, moment = 0, size = 0;
    OWN_MEMORY double *v = malloc(4 * WIDE * sizeof *v);
    REQUIRE(v);
    test_tree_random(&t, TEST_TREE_STAR, WIDE, 1, &seed);
    pend_kinematics_velocity(t.tree, t.phi, t.rate, v, v + WIDE);
    pend_kinematics_position(t.tree, t.phi, v + 2 * WIDE, v + 3 * WIDE);
    for (int k = 0; k < WIDE; k++) {
        double square = t.tree->mass[k] * (v[k] * v[k] + v[WIDE + k] * v[WIDE + k]);
        kinetic += square / 2;
        moment += (long double)t.tree->mass[k] * v[3 * WIDE + k];
        size += (long double)t.tree->mass[k] * fabs(v[3 * WIDE + k]);
    }
    struct pend_energy energy = pend_kinematics_energy(t.tree, TEST_LOADS(1), t.phi, t.rate);
    CHECK_RESIDUAL(fabs((double)(energy.kinetic / kinetic - 1)), 1e-15,
                   "kinetic energy of 200000 arms");
    CHECK_RESIDUAL(fabs((double)((energy.potential - moment) / size)), 1e-14,
                   "potential energy of 200000 arms");
}

TEST(kinematics_force_is_bbb_for_any_accelerations) {
    unsigned long long seed = 4;
    double worst = 0, worst_any = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        double acc[N], force[N], got[N], want[N], re[N * N], im[N * N];
        test_tree_random(&t, (enum test_tree_kind)kind, N, 0.3, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        pend_kinematics_force(t.tree, TEST_LOADS(9.81), t.phi, t.rate, acc, got);
        worst = fmax(worst, test_gap(N, got, force));

        // arbitrary accelerations: lambda = g sin(phi) (S^T m) - l^-1 [ Im phi'' + Re phi'^2 ]
        test_quad_inertia(t.tree, t.phi, re, im);
        for (int k = 0; k < N; k++) acc[k] = 20 * test_random(&seed) - 10;
        for (int i = 0; i < N; i++) {
            double sum = 0;
            for (int j = 0; j < N; j++)
                sum += im[i * N + j] * acc[j] + re[i * N + j] * t.rate[j] * t.rate[j];
            want[i] = 9.81 * sin(t.phi[i]) * t.tree->subtree_mass[i] - sum / t.tree->len[i];
        }
        pend_kinematics_force(t.tree, TEST_LOADS(9.81), t.phi, t.rate, acc, got);
        worst_any = fmax(worst_any, test_gap(N, got, want));
    }
    CHECK_RESIDUAL(worst, 1e-13, "forces of a motion that obeys (aaa)");
    CHECK_RESIDUAL(worst_any, 1e-14, "forces of a motion that obeys nothing");
}

TEST(kinematics_allocates_nothing) {
    unsigned long long seed = 5;
    OWN(test_tree, clear) t;
    double acc[N], force[N], re[N], im[N];
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 1, &seed);
    test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
    long before = test_alloc_count();
    pend_kinematics_position(t.tree, t.phi, re, im);
    pend_kinematics_velocity(t.tree, t.phi, t.rate, re, im);
    pend_kinematics_acceleration(t.tree, t.phi, t.rate, acc, re, im);
    pend_kinematics_energy(t.tree, TEST_LOADS(9.81), t.phi, t.rate);
    pend_kinematics_force(t.tree, TEST_LOADS(9.81), t.phi, t.rate, acc, force);
    CHECK_INT(test_alloc_count(), before);
}
