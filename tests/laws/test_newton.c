/* Laws: Newton's second law holds at every tip, energy is conserved, and small motions about
 * hanging are (lin).
 * Leaves to others: the matrix form (test_matrix_form), symmetries.
 * Invariant: accelerations and forces come from core/dynamics/dynamics, tip motion from
 * core/dynamics/kinematics. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { N = 120 };

/* Largest error of m (z'' + i g) = B [lambda u] over the tips, relative to the largest force on
 * any. */
static double newton_miss(const struct test_tree *t, double gravity, const double acc[],
                          const double force[]) {
    double re[N], im[N], most = 0, miss = 0;
    pend_kinematics_acceleration(t->tree, t->phi, t->rate, acc, re, im);
    for (int k = 0; k < t->n; k++) {
        re[k] = t->tree->mass[k] * re[k];
        im[k] = t->tree->mass[k] * (im[k] + gravity);
    }
    // B: an arm pushes its tip outwards and the tip that carries it back
    for (int k = 0; k < t->n; k++) {
        double push_re = force[k] * cos(t->phi[k]), push_im = force[k] * sin(t->phi[k]);
        int p = t->tree->parent[k];
        re[k] -= push_re, im[k] -= push_im;
        if (p >= 0) re[p] += push_re, im[p] += push_im;
        most = fmax(most, fabs(force[k]));
    }
    for (int k = 0; k < t->n; k++) {
        double here = hypot(re[k], im[k]) / most;
        if (!(here <= miss)) miss = here;
    }
    return miss;
}

TEST(law_newtons_second_law_holds_at_every_tip) {
    unsigned long long seed = 1;
    double worst = 0, spoilt = INFINITY;
    for (int i = 0; i < 20 * TEST_TREE_KINDS; i++) {
        OWN(test_tree, clear) t;
        double acc[N], force[N];
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                         2 + test_random_int(&seed, N - 1), 0.3, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        worst = fmax(worst, newton_miss(&t, 9.81, acc, force));
        // forces swapped between two arms
        double swap = force[0];
        force[0] = force[1], force[1] = swap;
        spoilt = fmin(spoilt, newton_miss(&t, 9.81, acc, force));
    }
    CHECK_RESIDUAL(worst, 1e-12, "m (z'' + i g) = B [lambda u]");
    CHECK_SAYING(spoilt > 1e-9, "exchanged forces go unseen: %g", spoilt);
}

/* |dE/dt| of a motion, relative to the powers of which it is the sum */
static double power_miss(const struct test_tree *t, double gravity, const double acc[]) {
    double v_re[N], v_im[N], a_re[N], a_im[N], power = 0, size = 0;
    pend_kinematics_velocity(t->tree, t->phi, t->rate, v_re, v_im);
    pend_kinematics_acceleration(t->tree, t->phi, t->rate, acc, a_re, a_im);
    for (int k = 0; k < t->n; k++) {
        double kinetic = t->tree->mass[k] * (v_re[k] * a_re[k] + v_im[k] * a_im[k]);
        double potential = t->tree->mass[k] * gravity * v_im[k];
        power += kinetic + potential;
        size += fabs(kinetic) + fabs(potential);
    }
    return fabs(power) / size;
}

TEST(law_the_accelerations_conserve_the_energy) {
    unsigned long long seed = 2;
    double worst = 0, spoilt = 0;
    for (int i = 0; i < 20 * TEST_TREE_KINDS; i++) {
        OWN(test_tree, clear) t;
        double acc[N], force[N];
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS),
                         1 + test_random_int(&seed, N), 0.3, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        worst = fmax(worst, power_miss(&t, 9.81, acc));
        for (int k = 0; k < t.n; k++) acc[k] *= 1 + 1e-9;
        spoilt = fmax(spoilt, power_miss(&t, 9.81, acc));
    }
    CHECK_RESIDUAL(worst, 1e-13, "dE/dt = 0");
    CHECK_SAYING(spoilt > 1e-11, "accelerations off by 1e-9 go unseen: %g", spoilt);
}

TEST(law_the_energy_stays_along_a_short_step) {
    // E(t + h) - E(t - h) by Taylor's formula: h E' vanishes and the remainder is proportional to
    // h^3
    unsigned long long seed = 3;
    double ratio_least = INFINITY, ratio_most = 0;
    for (int i = 0; i < 4 * TEST_TREE_KINDS; i++) {
        enum { SMALL = 6 };
        OWN(test_tree, clear) t;
        double acc[SMALL], force[SMALL], change[2], scale = 0;
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), SMALL, 0.3, &seed);
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        for (int half = 0; half < 2; half++) {
            double h = 1e-3 / (1 + half), total[2];
            for (int side = 0; side < 2; side++) {
                double s = side ? h : -h, phi[SMALL], rate[SMALL];
                for (int k = 0; k < SMALL; k++) {
                    phi[k] = t.phi[k] + s * t.rate[k];
                    rate[k] = t.rate[k] + s * acc[k];
                }
                struct pend_energy energy =
                    pend_kinematics_energy(t.tree, TEST_LOADS(9.81), phi, rate);
                total[side] = energy.kinetic + energy.potential;
                scale = pend_kinematics_energy_scale(t.tree, TEST_LOADS(9.81), energy.kinetic);
            }
            change[half] = (total[1] - total[0]) / scale;
        }
        // a smaller change is only rounding
        if (fabs(change[1]) > 1e-11) {
            ratio_least = fmin(ratio_least, change[0] / change[1]);
            ratio_most = fmax(ratio_most, change[0] / change[1]);
        }
    }
    CHECK_SAYING(ratio_least > 7 && ratio_most < 9,
                 "halving h divides the change by %g to %g, expected 8", ratio_least, ratio_most);
}

TEST(law_small_motions_about_hanging_are_the_linearization) {
    unsigned long long seed = 4;
    double worst = 0, spoilt = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        enum { SMALL = 20 };
        OWN(test_tree, clear) t;
        double a[SMALL * SMALL], acc[SMALL], force[SMALL], want[SMALL], theta[SMALL];
        test_tree_random(&t, (enum test_tree_kind)kind, SMALL, 0.3, &seed);
        for (int k = 0; k < SMALL; k++) {
            // phi is rounded; theta is its exact value plus pi/2 with twice a double's digits
            t.phi[k] = 1e-7 * (2 * test_random(&seed) - 1) - 1.5707963267948966;
            theta[k] = t.phi[k] + 1.5707963267948966 + 6.123233995736766e-17;
            t.rate[k] = 0;
        }
        test_quad_linearization(t.tree, 9.81, a, NULL);
        for (int i = 0; i < SMALL; i++) {
            want[i] = 0;
            for (int j = 0; j < SMALL; j++) want[i] -= a[i * SMALL + j] * theta[j];
        }
        test_tree_dynamics(&t, TEST_LOADS(9.81), acc, force);
        worst = fmax(worst, test_gap(SMALL, acc, want));
        for (int i = 0; i < SMALL; i++) want[i] = -want[i];
        spoilt = fmax(spoilt, test_gap(SMALL, acc, want));
    }
    CHECK_RESIDUAL(worst, 2e-11, "theta'' = -A theta for theta of 1e-7");
    CHECK_SAYING(spoilt > 1, "theta'' = +A theta goes unseen");
}
