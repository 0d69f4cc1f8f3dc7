/* Tests of core/modes/damped: equilibria, matrices and damped modes of real pendulums.
 * Leaves to others: modes of ideal pendulums (test_modes).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/damped.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/modes/modes.h"
#include "core/modes/rest.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 7 };

/* conservative terms, then damping: no drives that depend on time */
enum { STILL = TEST_TERMS_RODS | TEST_TERMS_SPRINGS };
enum {
    LOSES = STILL | TEST_TERMS_DAMPING | TEST_TERMS_FRICTION | TEST_TERMS_DRAG |
            TEST_TERMS_DRAG_PER_MASS
};

static void accelerations(const struct test_tree *t, const struct test_bodies *b,
                          const double phi[], const double rate[], double acc[]) {
    struct bodies_state state = {phi, NULL, rate, 0, 0};
    OWN_MEMORY void *work =
        aligned_alloc(64, (pend_bodies_bytes(t->tree, b->terms) + 63) / 64 * 64);
    if (!work) abort();
    pend_bodies_at(t->tree, &b->loads, &state, work, acc, NULL);
}

/* the largest difference of M times the derivatives of accelerations with respect to angles, rates
 * or torques, from K, C or B, relative to the matrix's largest entry */
static double matrix_wrong(const struct test_tree *t, struct test_bodies *b, const double phi[],
                           enum pend_matrix which, const double mass[], const double want[]) {
    const double step = which == PEND_MATRIX_B ? 1 : 0x1p-17;
    const int n = t->tree->n, *order = t->tree->order;
    double worst = 0, size = 0;
    for (int k = 0; k < n; k++) {
        double acc[2][ARMS], at[ARMS], rate[ARMS] = {0};
        double *torque = b->value + pend_terms_place(b->terms, PEND_TERM_TORQUE, k), kept = *torque;
        for (int side = 0; side < 2; side++) {
            double move = side ? step : -step;
            memcpy(at, phi, (size_t)n * sizeof *at);
            if (which == PEND_MATRIX_K) at[k] += move;
            if (which == PEND_MATRIX_C) rate[k] = move;
            if (which == PEND_MATRIX_B) *torque = kept + move;
            accelerations(t, b, at, rate, acc[side]);
        }
        *torque = kept;
        for (int i = 0; i < n; i++) {
            double entry = want[order[i] * n + order[k]], sum = 0;
            for (int j = 0; j < n; j++)
                sum += mass[order[i] * n + order[j]] * (acc[1][j] - acc[0][j]) / (2 * step);
            worst = fmax(worst, fabs((which == PEND_MATRIX_B ? sum : -sum) - entry));
            size = fmax(size, fabs(entry));
        }
    }
    return worst / size;
}

TEST(damped_matrices_are_the_derivatives_of_accelerations_at_a_rest) {
    static const enum pend_matrix which[] = {PEND_MATRIX_K, PEND_MATRIX_C, PEND_MATRIX_B};
    unsigned long long seed = 12;
    double worst[3] = {0}, product = 0, value[4][ARMS * ARMS];
    for (int round = 0; round < 60; round++) {
        int n = 2 + round % (ARMS - 1);
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        double phi[ARMS], size = 0, wrong = 0;
        test_tree_random(&t, round % TEST_TREE_KINDS, n, 0.3, &seed);
        unsigned terms = LOSES | TEST_TERMS_TORQUES | (round % 2 ? TEST_TERMS_CART : 0);
        test_bodies_random(&b, t.tree, terms, &seed);
        for (int h = 0; h < b.terms->harmonics; h++) b.value[b.terms->harmonic[h].at] = 0;
        for (int k = 0; k < n; k++) phi[k] = 6 * test_random(&seed) - 3;
        REQUIRE(pend_rest_find(t.tree, &b.loads, phi, NULL, NULL) == PEND_OK);
        REQUIRE(pend_damped_matrix(t.tree, &b.loads, phi, PEND_MATRIX_M, value[3]) == PEND_OK);
        for (int i = 0; i < 3; i++) {
            REQUIRE(pend_damped_matrix(t.tree, &b.loads, phi, which[i], value[i]) == PEND_OK);
            worst[i] = fmax(worst[i], matrix_wrong(&t, &b, phi, which[i], value[3], value[i]));
        }
        REQUIRE(pend_damped_matrix(t.tree, &b.loads, phi, PEND_MATRIX_A, value[1]) == PEND_OK);
        for (int i = 0; i < n * n; i++) {
            double sum = -value[0][i];
            for (int j = 0; j < n; j++) sum += value[3][i / n * n + j] * value[1][j * n + i % n];
            wrong = fmax(wrong, fabs(sum));
            size = fmax(size, fabs(value[0][i]));
        }
        product = fmax(product, wrong / size);
    }
    CHECK_RESIDUAL(worst[0], 1e-8, "K against differences of accelerations");
    CHECK_RESIDUAL(worst[1], 1e-8, "C against the same");
    CHECK_RESIDUAL(worst[2], 1e-11, "B against the same");
    CHECK_RESIDUAL(product, 1e-13, "M A against K");
}

TEST(damped_modes_stand_at_a_rest_of_the_equations_of_motion) {
    unsigned long long seed = 1;
    double worst = 0;
    for (int i = 0; i < 40; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct pend_error error = {0};
        OWN(pend_damped, free) *d;
        double zero[ARMS] = {0}, acc[ARMS], start[ARMS];
        test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.3, &seed);
        test_bodies_random(&b, t.tree, (i % 2 ? STILL : LOSES) | (i % 3 ? 0 : TEST_TERMS_CART),
                           &seed);
        for (int k = 0; k < ARMS; k++) start[k] = i % 3 || k ? -M_PI_2 : 0;
        CHECK_SAYING(pend_damped_new(&d, t.tree, &b.loads, start, &error) == PEND_OK, "%s",
                     error.text);
        if (!d) continue;
        accelerations(&t, &b, d->phi, zero, acc);
        for (int k = 0; k < ARMS; k++) worst = fmax(worst, fabs(acc[k]));
    }
    CHECK_RESIDUAL(worst, 1e-11, "accelerations at the equilibrium, rad/s^2");
}

/* phi'' of the linearized motion in a mode's direction, by differences of the equations of
 * motion */
TEST(damped_modes_solve_the_equations_of_motion_near_their_rest) {
    unsigned long long seed = 2;
    double worst = 0;
    for (int i = 0; i < 12; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct pend_error error = {0};
        OWN(pend_damped, free) *d;
        double start[ARMS];
        test_tree_random(&t, TEST_TREE_LIMBS, ARMS, 0.3, &seed);
        test_bodies_random(&b, t.tree, (i % 2 ? STILL : LOSES) | (i % 3 ? 0 : TEST_TERMS_CART),
                           &seed);
        for (int k = 0; k < ARMS; k++) start[k] = i % 3 || k ? -M_PI_2 : 0;
        REQUIRE(pend_damped_new(&d, t.tree, &b.loads, start, &error) == PEND_OK);
        int pairs = 0;
        for (int j = 0; j < d->count; j++) {
            double most = 0; // a cart's position may exceed 1
            for (int k = 0; k < ARMS; k++)
                most = fmax(most, hypot(d->re[j * ARMS + k], d->im[j * ARMS + k]));
            const double step = 1e-6 / most;
            double complex value = d->decay[j] + I * d->omega[j];
            double acc[2][2][ARMS];
            pairs += d->omega[j] > 0 ? 2 : 1;
            // real and imaginary parts of the shape, each in both directions
            for (int part = 0; part < 2; part++) {
                for (int side = 0; side < 2; side++) {
                    double phi[ARMS], rate[ARMS];
                    for (int k = 0; k < ARMS; k++) {
                        double complex x = d->re[j * ARMS + k] + I * d->im[j * ARMS + k];
                        double complex v = value * x;
                        double move = side ? -step : step;
                        phi[k] = d->phi[k] + move * (part ? cimag(x) : creal(x));
                        rate[k] = move * (part ? cimag(v) : creal(v));
                    }
                    accelerations(&t, &b, phi, rate, acc[part][side]);
                }
            }
            for (int k = 0; k < ARMS; k++) {
                double complex x = d->re[j * ARMS + k] + I * d->im[j * ARMS + k];
                double complex got = (acc[0][0][k] - acc[0][1][k]) / (2 * step) +
                                     I * (acc[1][0][k] - acc[1][1][k]) / (2 * step);
                double size = most * fmax(1, creal(value * conj(value)));
                worst = fmax(worst, cabs(got - value * value * x) / size);
            }
        }
        CHECK_INT(pairs, 2 * ARMS);
    }
    CHECK_RESIDUAL(worst, 1e-7, "lambda^2 x = phi'' of a small motion in a mode");
}

TEST(damped_modes_of_ideal_pendulums_are_those_without_matrices) {
    unsigned long long seed = 3;
    double worst = 0;
    for (int i = 0; i < 20; i++) {
        OWN(test_tree, clear) t;
        struct pend_error error = {0};
        OWN(pend_damped, free) *d;
        OWN(pend_modes, free) *modes = NULL;
        double start[ARMS];
        test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.5, &seed);
        for (int k = 0; k < ARMS; k++) start[k] = -M_PI_2 + 0.1;
        REQUIRE(pend_damped_new(&d, t.tree, TEST_LOADS(9.81), start, &error) == PEND_OK);
        REQUIRE(pend_modes_new(&modes, t.tree, TEST_LOADS(9.81), 0, &error) == PEND_OK);
        CHECK_INT(d->count, ARMS);
        for (int k = 0; k < ARMS; k++) {
            worst = fmax(worst, fabs(d->omega[k] / modes->omega[k] - 1));
            CHECK(d->decay[k] == 0);
        }
    }
    CHECK_RESIDUAL(worst, 1e-11, "frequencies of ideal pendulums");
}

TEST(damped_modes_of_one_arm_are_the_textbooks) {
    const double l = 0.7, m = 1.3, g = 9.81, damping[] = {0.05, 0.5, 20};
    OWN(pend_tree, free) *tree;
    int parent = -1;
    REQUIRE(pend_tree_new(&tree, 1, &l, &m, &parent, NULL) == PEND_OK);
    for (int i = 0; i < 3; i++) {
        unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
        OWN(pend_terms, free) *terms;
        struct pend_error error;
        OWN(pend_damped, free) *d = NULL;
        double start = -1.2, rate = damping[i] / (2 * m * l * l), square = g / l;
        rows[PEND_TERM_DAMPING] = 1;
        REQUIRE(pend_terms_new(&terms, 1, rows, ones, 0, NULL, NULL) == PEND_OK);
        struct pend_loads loads = {g, terms, &damping[i]};
        REQUIRE(pend_damped_new(&d, tree, &loads, &start, &error) == PEND_OK);
        CHECK_RESIDUAL(fabs(d->phi[0] + M_PI_2) + 1e-16, 2e-15, "the arm hangs");
        if (rate * rate < square) {
            CHECK_INT(d->count, 1);
            CHECK(fabs(d->omega[0] - sqrt(square - rate * rate)) < 1e-13);
            CHECK(fabs(d->decay[0] + rate) < 1e-13);
        } else {
            double root = sqrt(rate * rate - square);
            CHECK_INT(d->count, 2);
            CHECK(fabs(d->decay[0] - (root - rate)) < 1e-12);
            CHECK(fabs(d->decay[1] + root + rate) < 1e-12);
        }
    }
}
