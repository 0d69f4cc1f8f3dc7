/* Tests of periodic orbits: the single pendulum's period, the double pendulum's two modes with
 * multipliers from 32 digits, modes of larger trees, driven pendulums with folds and doublings,
 * honest ends, and memory that fails.
 * Leaves to others: names and JSON (api).
 * Invariant: every orbit is checked by a motion of another kind than the search's. */
#include "core/orbits/orbits.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/extended/extended.h"
#include "core/orbits/orbit_form.h"
#include "tests/harness/test.h"

enum { MOST = 20, ROWS = 600, KINDS = 40 };

/* what a search has found */
struct found {
    struct pend_tree *tree;
    struct pend_orbit_problem problem;
    enum pend_status status;
    enum pend_orbits_end end;
    int rows, bifurcations;
    double phi[ROWS][MOST], low[ROWS][MOST], rate[ROWS][MOST], amplitude[ROWS][MOST];
    double re[ROWS][2 * MOST], im[ROWS][2 * MOST];
    double period[ROWS], energy[ROWS], value[ROWS], closure[ROWS];
    int stable[ROWS], after[KINDS];
    enum pend_orbits_kind kind[KINDS];
    double at[KINDS]; /* energy or value of a bifurcation */
};

static void found_keep(struct found *f, const struct pend_orbit *o) {
    size_t n = (size_t)f->tree->n, row = (size_t)f->rows++;
    REQUIRE(f->rows <= ROWS);
    memcpy(f->phi[row], o->phi, n * sizeof(double));
    memcpy(f->low[row], o->phi_low, n * sizeof(double));
    memcpy(f->rate[row], o->rate, n * sizeof(double));
    memcpy(f->amplitude[row], o->amplitude, n * sizeof(double));
    memcpy(f->re[row], o->re, 2 * n * sizeof(double));
    memcpy(f->im[row], o->im, 2 * n * sizeof(double));
    f->period[row] = o->period, f->energy[row] = o->energy, f->value[row] = o->value;
    f->closure[row] = o->closure, f->stable[row] = o->stable;
}

/* searches to the end; the tree stays */
static void found_search(struct found *f) {
    struct pend_orbits *search;
    struct pend_error error = {.code = PEND_OK};
    enum pend_orbits_found what = PEND_ORBITS_NOTHING;
    f->problem.tree = f->tree;
    f->rows = f->bifurcations = 0;
    f->status = pend_orbits_new(&search, &f->problem, &error);
    while (f->status == PEND_OK && what != PEND_ORBITS_END) {
        f->status = pend_orbits_next(search, &what, &error);
        if (f->status != PEND_OK) break;
        struct pend_orbit orbit = pend_orbits_orbit(search);
        if (what == PEND_ORBITS_ORBIT) found_keep(f, &orbit);
        if (what != PEND_ORBITS_BIFURCATION) continue;
        REQUIRE(f->bifurcations < KINDS);
        f->kind[f->bifurcations] = orbit.kind;
        f->after[f->bifurcations] = f->rows - 1;
        f->at[f->bifurcations++] = f->problem.driven ? orbit.value : orbit.energy;
    }
    if (f->status == PEND_OK) f->end = pend_orbits_end(search);
    pend_orbits_free(&search);
}

/* a chain of n arms of 1 m and 1 kg */
static struct found *found_chain(int n, int mode, double amplitude, int branch) {
    double length[MOST], mass[MOST];
    int parent[MOST];
    struct found *f = calloc(1, sizeof *f);
    CHECK(f && n <= MOST);
    for (int k = 0; k < n; k++) length[k] = mass[k] = 1, parent[k] = k - 1;
    CHECK(pend_tree_new(&f->tree, n, length, mass, parent, NULL) == PEND_OK);
    f->problem = (struct pend_orbit_problem){.loads = {.gravity = 9.81},
                                             .branch = branch,
                                             .points = 300,
                                             .step = branch ? 0.1 : 0.3,
                                             .mode = mode,
                                             .target = PEND_ORBIT_AMPLITUDE,
                                             .until = amplitude};
    return f;
}

static void found_free(struct found *f) {
    pend_tree_free(&f->tree);
    free(f);
}

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
        struct found *f = found_chain(1, 0, amplitude, 0);
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
        double period = 4 / sqrt(9.81) * elliptic(amplitude);
        CHECK(fabs(f->period[0] / period - 1) < 1e-12);
        CHECK(fabs(f->phi[0][0] + M_PI / 2 - amplitude) < 1e-14);
        CHECK(fabs(f->energy[0] / (9.81 * (1 - cos(amplitude))) - 1) < 1e-9);
        CHECK(f->stable[0] && f->re[0][0] == 1 && f->im[0][1] == 0);
        found_free(f);
    }
}

/* ---- multipliers in 32 digits */

/* the state after a time, as sums of two doubles, from a start moved by h along coordinate j */
static void moved(const struct found *f, int row, double time, int j, double h, double out[],
                  double out_low[]) {
    int n = f->tree->n;
    double state[4 * MOST];
    struct pend_extended *run;
    memset(state, 0, sizeof state);
    for (int k = 0; k < n; k++) {
        state[k] = f->phi[row][k], state[MOST + k] = f->low[row][k];
        state[2 * MOST + k] = f->rate[row][k];
    }
    // the low parts take the whole of h, so that it is exact
    if (j >= 0) state[(j < n ? MOST + j : 3 * MOST + j - n)] += h;
    struct pend_extended_state start = {state, state + MOST, state + 2 * MOST, state + 3 * MOST};
    struct pend_extended_state end = {out, out_low, out + n, out_low + n};
    REQUIRE(pend_extended_new(&run, f->tree, f->problem.loads.terms, 1e-28, 1e-30, 1,
                              pend_isa_best(), NULL) == PEND_OK);
    pend_extended_start(run, 0, &f->problem.loads, &start, 0, time);
    while (pend_extended_lane(run, 0) == PEND_EXTENDED_UNDER_WAY) (void)pend_extended_step(run);
    CHECK(pend_extended_lane(run, 0) == PEND_EXTENDED_STOPPED);
    pend_extended_end(run, 0, &end);
    pend_extended_free(&run);
}

/* the trace of the monodromy matrix, and that of its square, from central differences of motions
 * in 32 digits over the whole period */
static void traces(const struct found *f, int row, double *trace, double *square) {
    enum { ALL = 2 * MOST };
    int m = 2 * f->tree->n;
    static double matrix[ALL][ALL];
    double h = 1e-10, plus[ALL], plus_low[ALL], minus[ALL], minus_low[ALL];
    for (int j = 0; j < m; j++) {
        moved(f, row, f->period[row], j, h, plus, plus_low);
        moved(f, row, f->period[row], j, -h, minus, minus_low);
        for (int i = 0; i < m; i++)
            matrix[i][j] = ((plus[i] - minus[i]) + (plus_low[i] - minus_low[i])) / (2 * h);
    }
    *trace = *square = 0;
    for (int i = 0; i < m; i++) {
        *trace += matrix[i][i];
        for (int j = 0; j < m; j++) *square += matrix[i][j] * matrix[j][i];
    }
}

static void check_multipliers(const struct found *f, int row) {
    double trace, square, size = 1;
    double complex sum = 0, squares = 0;
    traces(f, row, &trace, &square);
    for (int j = 0; j < 2 * f->tree->n; j++) {
        double complex x = f->re[row][j] + I * f->im[row][j];
        sum += x, squares += x * x;
        size = fmax(size, cabs(x));
    }
    CHECK(fabs(creal(sum) - trace) < 1e-12 * size * size && fabs(cimag(sum)) < 1e-12 * size);
    CHECK(fabs(creal(squares) - square) < 1e-12 * size * size);
}

TEST(orbits_of_the_double_pendulum_have_the_multipliers_of_32_digits_up_to_2_rad) {
    for (int mode = 0; mode < 2; mode++) {
        struct found *f = found_chain(2, mode, 2, 1);
        found_search(f);
        CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 20);
        for (int i = 0; i < f->rows; i++) {
            CHECK(f->closure[i] < 1e-12);
            CHECK(!i || f->energy[i] > f->energy[i - 1]);
            if (i % 8 == 3 || i == f->rows - 1) check_multipliers(f, i);
        }
        double *last = f->amplitude[f->rows - 1];
        CHECK(fabs(fmax(last[0], last[1]) - 2) < 1e-12);
        // near rest the branch is the mode: omega^2 = (2 -+ sqrt 2) g / l, angles 1 : +- sqrt 2
        double omega = sqrt((2 + (mode ? M_SQRT2 : -M_SQRT2)) * 9.81);
        CHECK(fabs(f->period[0] * omega / (2 * M_PI) - 1) < 1e-3);
        CHECK(fabs(f->amplitude[0][1] / f->amplitude[0][0] - M_SQRT2) < 1e-3);
        CHECK(mode ? f->bifurcations == 1 && f->kind[0] == PEND_ORBITS_BRANCH && !f->stable[25]
                   : f->bifurcations == 0 && f->stable[f->rows - 1]);
        found_free(f);
    }
}

/* the largest angle from hanging after a part of the period, and the largest rate, in 32 digits */
static void seen_after(const struct found *f, double part, double *angle, double *rate) {
    int n = f->tree->n;
    double end[2 * MOST], low[2 * MOST];
    moved(f, 0, part * f->period[0], -1, 0, end, low);
    *angle = *rate = 0;
    for (int k = 0; k < n; k++) {
        *angle = fmax(*angle, fabs(end[k] + M_PI / 2));
        *rate = fmax(*rate, fabs(end[n + k]));
    }
}

/* between two rests, through the rest of the pendulum: arXiv:2505.13064 */
TEST(orbits_of_five_links_swing_between_two_rests_through_the_hanging_one) {
    for (int mode = 0; mode < 5; mode++) {
        struct found *f = found_chain(5, mode, 0.4, 0);
        double angle, rate;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED);
        seen_after(f, 0.25, &angle, &rate);
        CHECK(angle < 1e-12 && rate > 0.1);
        seen_after(f, 0.5, &angle, &rate);
        CHECK(fabs(angle - 0.4) < 1e-12 && rate < 1e-11);
        found_free(f);
    }
}

TEST(orbits_of_larger_chains_come_back) {
    struct found *f = found_chain(20, 0, 0.6, 0);
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
    CHECK(f->closure[0] < 1e-11 && fabs(f->amplitude[0][19] - 0.6) < 1e-12);
    for (int j = 0; j < 40; j++) CHECK(fabs(hypot(f->re[0][j], f->im[0][j]) - 1) < 1e-6);
    found_free(f);
    for (int mode = 0; mode < 5; mode++) {
        f = found_chain(5, mode, 0.5, 0);
        found_search(f);
        CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->closure[0] < 1e-11);
        check_multipliers(f, 0);
        found_free(f);
    }
}

TEST(orbits_up_to_an_energy_are_those_up_to_its_amplitude) {
    struct found *f = found_chain(3, 1, 1, 0), *g = found_chain(3, 1, 1, 0);
    found_search(f);
    REQUIRE(f->status == PEND_OK && f->rows == 1);
    g->problem.target = PEND_ORBIT_ENERGY, g->problem.until = f->energy[0];
    found_search(g);
    REQUIRE(g->status == PEND_OK && g->rows == 1);
    CHECK(fabs(g->period[0] / f->period[0] - 1) < 1e-11);
    for (int k = 0; k < 3; k++) CHECK(fabs(g->phi[0][k] - f->phi[0][k]) < 1e-11);
    found_free(g);
    found_free(f);
}

/* ---- real pendulums */

/* terms of one row */
static struct pend_terms *terms_of(int n, enum pend_term_row row, int harmonics) {
    static const int drives[] = {0};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    struct pend_terms *terms;
    int place[1];
    rows[row] = 1;
    CHECK(pend_terms_new(&terms, n, rows, ones, harmonics, drives, place) == PEND_OK);
    return terms;
}

TEST(orbits_about_a_rest_that_is_no_mirror_image_come_back_too) {
    struct found *f = found_chain(2, 0, 1, 1);
    struct pend_terms *terms = terms_of(2, PEND_TERM_STIFFNESS, 0);
    double value[8] = {0};
    for (int k = 0; k < 2; k++) {
        value[pend_terms_place(terms, PEND_TERM_STIFFNESS, k)] = 3 + k;
        value[pend_terms_place(terms, PEND_TERM_REST, k)] = 0.4 - 0.7 * k;
    }
    f->problem.loads.terms = terms, f->problem.loads.value = value;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 8);
    for (int i = 0; i < f->rows; i++) CHECK(f->closure[i] < 1e-11);
    check_multipliers(f, f->rows - 1);
    pend_terms_free(&terms);
    found_free(f);
}

/* an arm of 1 m and 1 kg in a field of 1 m/s^2, damped, with a torque a cos(w t) on it */
static struct found *driven(double damping, double torque, double omega, double value[]) {
    struct found *f = found_chain(1, 0, 1, 0);
    struct pend_terms *terms = terms_of(1, PEND_TERM_DAMPING, 1);
    static const double hanging[] = {-M_PI / 2}, still[] = {0};
    value[pend_terms_place(terms, PEND_TERM_DAMPING, 0)] = damping;
    value[terms->harmonic[0].at] = torque;
    value[terms->harmonic[0].at + 1] = omega, value[terms->harmonic[0].at + 2] = 0;
    f->problem.loads = (struct pend_loads){1, terms, value};
    f->problem.driven = f->problem.periods = 1;
    f->problem.phi = hanging, f->problem.rate = still;
    f->problem.step = 0.1;
    return f;
}

static void driven_free(struct found *f) {
    struct pend_terms *terms = (struct pend_terms *)f->problem.loads.terms;
    pend_terms_free(&terms);
    found_free(f);
}

TEST(orbits_of_a_driven_arm_fold_at_resonance_where_steps_in_frequency_see_a_jump) {
    double value[8];
    struct found *f = driven(0.05, 0.06, 0.5, value);
    f->problem.branch = 1, f->problem.vary = PEND_ORBIT_OMEGA, f->problem.to = 1.2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED);
    REQUIRE(f->bifurcations == 2);
    CHECK(f->kind[0] == PEND_ORBITS_FOLD && f->kind[1] == PEND_ORBITS_FOLD);
    CHECK(f->at[1] < f->at[0] && f->at[0] < 1);
    for (int i = 0; i < f->rows; i++) {
        CHECK(f->closure[i] < 1e-12);
        CHECK(f->stable[i] == (i <= f->after[0] - 1 || i > f->after[1] - 1));
        // what friction takes in a period is the same wherever it swings: exp(-c T)
        double product = f->re[i][0] * f->re[i][1] - f->im[i][0] * f->im[i][1];
        CHECK(fabs(product / exp(-0.05 * f->period[i]) - 1) < 1e-11);
    }
    driven_free(f);
}

TEST(orbits_of_a_driven_arm_double_their_period_and_the_doubled_ones_are_found) {
    double value[8];
    struct found *f = driven(0.5, 1.02, 2.0 / 3, value);
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
    // the motion itself goes to an orbit of two periods there
    value[f->problem.loads.terms->harmonic[0].at] = doubling + 0.005;
    f->problem.branch = 0, f->problem.vary = PEND_ORBIT_ALONE, f->problem.settle = 2000;
    f->problem.periods = 2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows == 1);
    CHECK(f->stable[0] && f->closure[0] < 1e-11);
    driven_free(f);
}

TEST(orbits_that_do_not_exist_are_not_found) {
    // beyond the energy of the upright arm it turns over, and no swing comes to rest
    struct found *f = found_chain(1, 0, 1, 1);
    f->problem.target = PEND_ORBIT_ENERGY, f->problem.until = 2.1 * 9.81;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end != PEND_ORBITS_REACHED && f->rows > 10);
    for (int i = 0; i < f->rows; i++) CHECK(f->energy[i] < 2 * 9.81);
    found_free(f);
    // an orbit of one period is none of two
    double value[8];
    f = driven(0.5, 0.1, 0.7, value);
    f->problem.periods = 2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_MEETS && f->rows == 0);
    driven_free(f);
    // more swings than allowed
    f = found_chain(2, 0, 2, 1);
    f->problem.points = 5;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_POINTS && f->rows == 5);
    found_free(f);
    // a standing arm has no mode that swings
    f = found_chain(1, 0, 1, 1);
    f->problem.loads.gravity = -1;
    found_search(f);
    CHECK(f->status == PEND_INVALID);
    found_free(f);
}

TEST(orbits_and_their_search_survive_any_allocation_that_fails) {
    double value[8];
    struct found *some[] = {found_chain(2, 1, 0.1, 1), driven(0.1, 0.1, 0.5, value)};
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
    found_free(some[0]);
    driven_free(some[1]);
}

TEST(the_period_that_drives_have_in_common_is_found_if_there_is_one) {
    struct pend_terms *terms;
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    static const int drives[] = {0, 0};
    int place[2];
    double value[6] = {1, 2, 0, 1, 3, 0}, omega = 0;
    REQUIRE(pend_terms_new(&terms, 1, rows, ones, 2, drives, place) == PEND_OK);
    struct pend_loads loads = {9.81, terms, value};
    CHECK(pend_orbit_drive(&loads, &omega) && fabs(omega - 1) < 1e-15);
    value[terms->harmonic[1].at + 1] = -6;
    CHECK(pend_orbit_drive(&loads, &omega) && fabs(omega - 2) < 1e-15);
    value[terms->harmonic[1].at + 1] = 2 * M_SQRT2;
    CHECK(!pend_orbit_drive(&loads, &omega));
    pend_terms_free(&terms);
}
