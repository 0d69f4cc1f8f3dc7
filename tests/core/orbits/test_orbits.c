/* Tests of periodic orbits: the single pendulum's period, the double pendulum's two modes with
 * multipliers from 32 digits, modes of larger trees, driven pendulums with folds and doublings,
 * truthful ends, and lack of memory.
 * Leaves to others: names and JSON (api).
 * Invariant: every orbit is checked by a motion of another kind than the search's. */
#include "core/orbits/orbits.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_form.h"
#include "tests/harness/found.h"
#include "tests/harness/test.h"

/* the complete elliptic integral K(sin(a / 2)), by the arithmetic-geometric mean */
static double elliptic(double amplitude) {
    double a = 1, b = cos(amplitude / 2);
    for (int i = 0; i < 10; i++) {
        double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
    }
    return M_PI / (2 * a);
}

TEST(orbits_of_one_arm_have_the_elliptic_period_up_to_170_degrees) {
    static const double degrees[] = {0.1, 1, 10, 30, 60, 90, 120, 150, 165, 170};
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
        double amplitude = degrees[i] * M_PI / 180;
        OWN(found, free) *f = found_chain(1, 0, amplitude, 0);
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
        double period = 4 / sqrt(9.81) * elliptic(amplitude);
        CHECK(fabs(f->period[0] / period - 1) < 1e-12);
        CHECK(fabs(f->phi[0][0] + M_PI / 2 - amplitude) < 1e-14);
        CHECK(fabs(f->energy[0] / (9.81 * (1 - cos(amplitude))) - 1) < 1e-9);
        CHECK(f->stable[0] && f->re[0][0] == 1 && f->im[0][1] == 0);
    }
}

/* ---- multipliers in 32 digits */

TEST(orbits_of_the_double_pendulum_have_the_multipliers_of_32_digits_up_to_2_rad) {
    for (int mode = 0; mode < 2; mode++) {
        OWN(found, free) *f = found_chain(2, mode, 2, 1);
        found_search(f);
        CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 20);
        for (int i = 0; i < f->rows; i++) {
            CHECK(f->closure[i] < 1e-12);
            CHECK(!i || f->energy[i] > f->energy[i - 1]);
            if (i % 8 == 3 || i == f->rows - 1) found_check_multipliers(f, i);
        }
        double *last = f->amplitude[f->rows - 1];
        CHECK(fabs(fmax(last[0], last[1]) - 2) < 1e-12);
        // near equilibrium the branch is the mode: omega^2 = (2 -+ sqrt 2) g / l, angles 1 : +-
        // sqrt 2
        double omega = sqrt((2 + (mode ? M_SQRT2 : -M_SQRT2)) * 9.81);
        CHECK(fabs(f->period[0] * omega / (2 * M_PI) - 1) < 1e-3);
        CHECK(fabs(f->amplitude[0][1] / f->amplitude[0][0] - M_SQRT2) < 1e-3);
        CHECK(mode ? f->bifurcations == 1 && f->kind[0] == PEND_ORBITS_BRANCH && !f->stable[25]
                   : f->bifurcations == 0 && f->stable[f->rows - 1]);
    }
}

/* the double pendulum's second mode has a bifurcation at 1.08116 rad, between the last two steps */
TEST(a_branch_ends_once_where_a_bifurcation_lies_just_before_its_end) {
    static const double beyond[] = {1e-4, 3e-3, 3e-2};
    for (size_t i = 0; i < sizeof beyond / sizeof *beyond; i++) {
        double until = 1.08115598451 + beyond[i];
        OWN(found, free) *f = found_chain(2, 1, until, 1);
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 2);
        CHECK_INT(f->bifurcations, 1);
        for (int row = 0; row < f->rows; row++) {
            double most = fmax(f->amplitude[row][0], f->amplitude[row][1]);
            CHECK_SAYING(row == f->rows - 1 ? fabs(most - until) < 1e-12 : most < until - 1e-9,
                         "%g beyond: orbit %d of %d has %.17g of %.17g", beyond[i], row + 1,
                         f->rows, most, until);
        }
    }
}

/* the largest angle from hanging after a fraction of the period, and the largest rate, in 32
 * digits */
static void seen_after(const struct found *f, double part, double *angle, double *rate) {
    int n = f->tree->n;
    double end[2 * FOUND_ARMS], low[2 * FOUND_ARMS];
    found_moved(f, 0, part * f->period[0], -1, 0, end, low);
    *angle = *rate = 0;
    for (int k = 0; k < n; k++) {
        *angle = fmax(*angle, fabs(end[k] + M_PI / 2));
        *rate = fmax(*rate, fabs(end[n + k]));
    }
}

/* between two states of rest, through the hanging equilibrium: arXiv:2505.13064 */
TEST(orbits_of_five_links_swing_between_two_rests_through_the_hanging_one) {
    for (int mode = 0; mode < 5; mode++) {
        OWN(found, free) *f = found_chain(5, mode, 0.4, 0);
        double angle, rate;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED);
        seen_after(f, 0.25, &angle, &rate);
        CHECK(angle < 1e-12 && rate > 0.1);
        seen_after(f, 0.5, &angle, &rate);
        CHECK(fabs(angle - 0.4) < 1e-12 && rate < 1e-11);
    }
}

TEST(orbits_of_larger_chains_come_back) {
    struct found *f = found_chain(20, 0, 0.6, 0);
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
    CHECK(f->closure[0] < 1e-11 && fabs(f->amplitude[0][19] - 0.6) < 1e-12);
    for (int j = 0; j < 40; j++) CHECK(fabs(hypot(f->re[0][j], f->im[0][j]) - 1) < 1e-6);
    found_free(&f);
    for (int mode = 0; mode < 5; mode++) {
        f = found_chain(5, mode, 0.5, 0);
        found_search(f);
        CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->closure[0] < 1e-11);
        found_check_multipliers(f, 0);
        found_free(&f);
    }
}

TEST(orbits_up_to_an_energy_are_those_up_to_its_amplitude) {
    OWN(found, free) *f = found_chain(3, 1, 1, 0), *g = found_chain(3, 1, 1, 0);
    found_search(f);
    REQUIRE(f->status == PEND_OK && f->rows == 1);
    g->problem.target = PEND_ORBIT_ENERGY, g->problem.until = f->energy[0];
    found_search(g);
    REQUIRE(g->status == PEND_OK && g->rows == 1);
    CHECK(fabs(g->period[0] / f->period[0] - 1) < 1e-11);
    for (int k = 0; k < 3; k++) CHECK(fabs(g->phi[0][k] - f->phi[0][k]) < 1e-11);
}

/* Of three equal arms on a trunk two swing against each other, each as a single pendulum, and the
 * trunk hangs still. Linear theory does not determine the shape: the frequency occurs twice. */
TEST(orbits_of_equal_branches_that_swing_against_each_other_have_the_elliptic_period) {
    static const double amplitudes[] = {0.5, 1.2, 2.2};
    for (int i = 0; i < 9; i++) {
        int n = 4 + i % 3;
        double amplitude = amplitudes[i / 3], period = 4 * sqrt(0.7 / 9.81) * elliptic(amplitude);
        OWN(found, free) *f = found_trunk(n, n - 2, amplitude, i % 2);
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 0);
        int last = f->rows - 1;
        CHECK_SAYING(fabs(f->period[last] / period - 1) < 1e-12 && f->closure[last] < 1e-12,
                     "%d arms to %g rad: %.3g off", n, amplitude, f->period[last] / period - 1);
        for (int k = 0; k < n; k++) {
            double theta = k < n - 2 ? 0 : amplitude;
            CHECK(fabs(fabs(f->phi[last][k] + M_PI / 2) - theta) < 1e-13);
        }
        CHECK(fabs(f->phi[last][n - 2] + f->phi[last][n - 1] + M_PI) < 1e-13);
        found_check_multipliers(f, last);
    }
}

/* rods make them real pendulums, whose modes may be any shapes of that frequency */
TEST(orbits_of_equal_real_branches_swing_against_each_other_too) {
    for (int mode = 1; mode <= 2; mode++) {
        OWN(found, free) *f = found_trunk(4, mode, 1.2, 0);
        const struct pend_terms *terms = found_terms(f, PEND_TERM_ROD, 0);
        for (int k = 0; k < 4; k++) f->term[pend_terms_place(terms, PEND_TERM_ROD, k)] = 0.2;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
        // J / (m l) of a point mass and a rod on one joint
        double length = 0.7 * (0.6 + 0.2 / 3) / (0.6 + 0.1);
        CHECK(fabs(f->period[0] / (4 * sqrt(length / 9.81) * elliptic(1.2)) - 1) < 1e-12);
        CHECK(fabs(f->phi[0][0] + M_PI / 2) < 1e-13 && f->closure[0] < 1e-12);
    }
}

/* ---- real pendulums */

TEST(orbits_about_a_rest_that_is_no_mirror_image_come_back_too) {
    OWN(found, free) *f = found_chain(2, 0, 1, 1);
    const struct pend_terms *terms = found_terms(f, PEND_TERM_STIFFNESS, 0);
    for (int k = 0; k < 2; k++) {
        f->term[pend_terms_place(terms, PEND_TERM_STIFFNESS, k)] = 3 + k;
        f->term[pend_terms_place(terms, PEND_TERM_REST, k)] = 0.4 - 0.7 * k;
    }
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 8);
    for (int i = 0; i < f->rows; i++) CHECK(f->closure[i] < 1e-11);
    found_check_multipliers(f, f->rows - 1);
}

TEST(orbits_of_a_driven_arm_fold_at_resonance_where_steps_in_frequency_see_a_jump) {
    OWN(found, free) *f = found_driven(0.05, 0.06, 0.5);
    f->problem.branch = 1, f->problem.vary = PEND_ORBIT_OMEGA, f->problem.to = 1.2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED);
    REQUIRE(f->bifurcations == 2);
    CHECK(f->kind[0] == PEND_ORBITS_FOLD && f->kind[1] == PEND_ORBITS_FOLD);
    CHECK(f->at[1] < f->at[0] && f->at[0] < 1);
    for (int i = 0; i < f->rows; i++) {
        CHECK(f->closure[i] < 1e-12);
        CHECK(f->stable[i] == (i <= f->after[0] - 1 || i > f->after[1] - 1));
        // friction takes the same in a period everywhere: exp(-c T)
        double product = f->re[i][0] * f->re[i][1] - f->im[i][0] * f->im[i][1];
        CHECK(fabs(product / exp(-0.05 * f->period[i]) - 1) < 1e-11);
    }
}

TEST(orbits_of_a_driven_arm_double_their_period_and_the_doubled_ones_are_found) {
    OWN(found, free) *f = found_driven(0.5, 1.02, 2.0 / 3);
    f->problem.settle = 200, f->problem.branch = 1, f->problem.vary = PEND_ORBIT_PARAMETER;
    f->problem.by =
        (struct pend_parameter){PEND_PARAMETER_TERM, f->problem.loads.terms->harmonic[0].at};
    f->problem.to = 1.08;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED);
    REQUIRE(f->bifurcations == 1 && f->kind[0] == PEND_ORBITS_DOUBLING);
    CHECK(f->at[0] > 1.05 && f->at[0] < 1.075);
    double doubling = f->at[0];
    int last = f->rows - 1;
    CHECK(!f->stable[last] && fabs(f->value[last] - 1.08) < 1e-14);
    // the motion itself tends to an orbit of two periods there
    f->term[f->problem.loads.terms->harmonic[0].at] = doubling + 0.005;
    f->problem.branch = 0, f->problem.vary = PEND_ORBIT_ALONE, f->problem.settle = 2000;
    f->problem.periods = 2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
    CHECK(f->stable[0] && f->closure[0] < 1e-11);
}

TEST(orbits_that_do_not_exist_are_not_found) {
    // beyond the energy of the upright arm it turns over, and no swing comes to rest
    OWN(found, free) *f = found_chain(1, 0, 1, 1);
    f->problem.target = PEND_ORBIT_ENERGY, f->problem.until = 2.1 * 9.81;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end != PEND_ORBITS_REACHED && f->rows > 10);
    for (int i = 0; i < f->rows; i++) CHECK(f->energy[i] < 2 * 9.81);
    found_free(&f);
    // an orbit of one period is not one of two
    f = found_driven(0.5, 0.1, 0.7);
    f->problem.periods = 2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_MEETS && f->rows == 0);
    found_free(&f);
    // larger swings than allowed
    f = found_chain(2, 0, 2, 1);
    f->problem.points = 5;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_POINTS && f->rows == 5);
    found_free(&f);
    // an upright arm has no oscillating mode
    f = found_chain(1, 0, 1, 1);
    f->problem.loads.gravity = -1;
    found_search(f);
    CHECK(f->status == PEND_INVALID);
}

TEST(orbits_and_their_search_survive_any_allocation_that_fails) {
    struct found *some[] = {found_chain(2, 1, 0.1, 1), found_driven(0.1, 0.1, 0.5)};
    some[1]->problem.branch = 1, some[1]->problem.vary = PEND_ORBIT_OMEGA;
    some[1]->problem.to = 0.51, some[1]->problem.settle = 1;
    for (int i = 0; i < 2; i++) {
        long failed = 0;
        some[i]->problem.points = 3;
        for (long at = 1;; at++) {
            test_alloc_fail(at, 0);
            found_search(some[i]);
            test_alloc_faults_off();
            if (some[i]->status == PEND_OK) break;
            CHECK(some[i]->status == PEND_NO_MEMORY);
            failed++;
        }
        CHECK(failed > 10 && some[i]->status == PEND_OK && some[i]->rows >= 2);
    }
    found_free(&some[0]);
    found_free(&some[1]);
}

TEST(common_periods_are_found) {
    OWN(pend_terms, free) *terms;
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    static const int drives[] = {0, 0};
    int place[2];
    double value[6] = {1, 2, 0, 1, 3, 0}, omega = 0;
    REQUIRE(pend_terms_new(&terms, 1, rows, ones, 2, drives, place) == PEND_OK);
    struct pend_loads loads = {9.81, terms, value};
    CHECK(pend_orbit_drive(&loads, &omega) && fabs(omega - 1) < 1e-15);
    value[terms->harmonic[1].at + 1] = -6;
    CHECK(pend_orbit_drive(&loads, &omega) && fabs(omega - 2) < 1e-15);
    static const struct {
        double second;
        int common;
    } row[] = {{2 * M_SQRT2, 0}, {24, 1}, {26, 0}, {6 * (1 + 2e-12), 0}, {6 * (1 + 5e-13), 1}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        value[terms->harmonic[1].at + 1] = row[i].second;
        CHECK_INT(pend_orbit_drive(&loads, &omega), row[i].common);
    }
}
