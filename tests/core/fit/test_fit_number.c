/* Tests of measurements as functions of the motion: their derivatives with respect to every unknown
 * are those of their values.
 * Leaves to others: fits (test_fit), reading requests (tests/api/op/fit).
 * Invariant: the derivatives are compared with central differences of residuals, which come from
 * another integrator. */
#include "core/fit/fit_number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_model.h"
#include "tests/harness/test.h"

enum { ROWS = 5, MOST = 12, UNKNOWNS = 20 };

static const double t[ROWS] = {0.1, 0.35, 0.6, 0.9, 1.3};

/* a pendulum with a cart or without, and every kind of measurement that it supports */
struct motion {
    int n;
    double length[3], mass[3], phi[3], rate[3], value[1];
    double data[MOST][ROWS], zero[MOST];
    struct pend_terms *terms;
    struct pend_fit_column column[MOST];
    struct pend_fit_unknown unknown[UNKNOWNS];
    struct pend_fit_problem problem;
};

static const int alone[1] = {-1}, chain[2] = {-1, 0}, on_cart[2] = {1, -1}, in_order[2] = {0, 1},
                 cart_first[2] = {1, 0};

static void motion_column(struct motion *m, enum pend_fit_kind kind, int arm, double at) {
    int c = m->problem.columns++;
    for (int i = 0; i < ROWS; i++) m->data[c][i] = kind == PEND_FIT_PASSAGE ? -1.5 : 0.1;
    m->column[c] = (struct pend_fit_column){
        .kind = kind, .arm = arm, .sigma = 1, .data = m->data[c], .at = at, .zero = c + 1};
}

static void motion_unknown(struct motion *m, int camera, enum pend_parameter_kind kind, int at,
                           double start) {
    m->unknown[m->problem.unknowns++] =
        (struct pend_fit_unknown){camera, {kind, at}, start, -INFINITY, INFINITY, 0};
}

/* arms: 1 or 2; with a cart one arm hangs on it */
static void motion_new(struct motion *m, int arms, int cart) {
    unsigned char row[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    static const double camera[PEND_FIT_CAMERA] = {300, 0.1, 200, 100, 0.05, 0.2, -0.3, 0.1, 0.07};
    *m = (struct motion){.n = arms + cart, .length = {0.6, 0.4}, .mass = {1, 0.7}};
    if (cart) m->length[1] = 1;
    for (int k = 0; k < m->n; k++)
        m->phi[k] = cart && !k ? 0.2 : -M_PI / 2 + 0.5 + 0.2 * k, m->rate[k] = 0.3 - k;
    ones[PEND_TERM_RAIL] = (unsigned char)cart;
    if (cart) REQUIRE(pend_terms_new(&m->terms, m->n, row, ones, 0, NULL, NULL) == PEND_OK);
    m->problem = (struct pend_fit_problem){.n = m->n,
                                           .length = m->length,
                                           .mass = m->mass,
                                           .parent = cart       ? on_cart
                                                     : arms > 1 ? chain
                                                                : alone,
                                           .order = cart ? cart_first : in_order,
                                           .loads = {9.81, m->terms, m->value},
                                           .phi = m->phi,
                                           .rate = m->rate,
                                           .center = {210, 20},
                                           .reach = 250,
                                           .zeros = MOST,
                                           .zero = m->zero,
                                           .rows = ROWS,
                                           .t = t,
                                           .column = m->column,
                                           .unknown = m->unknown,
                                           .rtol = 1e-13,
                                           .iterations = 1};
    memcpy(m->problem.camera, camera, sizeof camera);
    motion_unknown(m, -1, PEND_PARAMETER_LENGTH, cart, m->length[0]);
    motion_unknown(m, -1, PEND_PARAMETER_GRAVITY, 0, 9.81);
    for (int k = 0; k < m->n; k++) {
        motion_unknown(m, -1, PEND_PARAMETER_PHI, k, m->phi[k]);
        motion_unknown(m, -1, PEND_PARAMETER_RATE, k, m->rate[k]);
    }
}

/* compares the derivatives of all residuals with differences */
static void check_slopes(struct motion *m) {
    const struct pend_fit_problem *p = &m->problem;
    int q = p->unknowns, count = ROWS * p->columns;
    double *slope = calloc((size_t)(count * (q + 2)), sizeof *slope), *residual = slope + count * q;
    double *beside = residual + count, value[UNKNOWNS];
    struct fit_model model;
    size_t bytes = pend_fit_model_lay(&model, p, NULL);
    OWN_MEMORY char *memory = aligned_alloc(64, bytes);
    memset(memory, 0, bytes);
    (void)pend_fit_model_lay(&model, p, memory);
    for (int j = 0; j < q; j++) value[j] = p->unknown[j].start;
    REQUIRE(pend_fit_model_at(&model, value, ROWS, residual, slope, NULL) == PEND_OK);
    for (int j = 0; j < q; j++) {
        double step = 1e-5 * fmax(fabs(value[j]), 0.1), *side[2] = {residual, beside};
        for (int k = 0; k < 2; k++) {
            double own = value[j];
            value[j] += k ? step : -step;
            REQUIRE(pend_fit_model_at(&model, value, ROWS, side[k], NULL, NULL) == PEND_OK);
            value[j] = own;
        }
        for (int i = 0; i < count; i++) {
            double by = (beside[i] - residual[i]) / (2 * step), told = slope[i * q + j];
            CHECK_SAYING(fabs(by - told) < 1e-6 * (1 + fabs(by)),
                         "column %d of row %d by unknown %d: %.12g, differences give %.12g",
                         i % p->columns, i / p->columns, j, told, by);
        }
    }
    free(slope);
}

/* one arm, two arms, an arm on a cart; without accelerations the shift is an unknown too */
TEST(measurements_have_the_derivatives_of_their_values) {
    for (int which = 0; which < 4; which++) {
        struct motion m;
        int cart = which == 3, last = which % 2, forces = which < 2;
        motion_new(&m, cart ? 1 : 1 + last, cart);
        for (int i = 0; i < PEND_FIT_CAMERA; i++)
            if (!forces || i != PEND_FIT_SHIFT) motion_unknown(&m, i, 0, 0, m.problem.camera[i]);
        if (cart) last = 0;
        motion_column(&m, PEND_FIT_PHI, last, -1);
        motion_column(&m, PEND_FIT_X, last, -1);
        motion_column(&m, PEND_FIT_Y, last, -1);
        motion_column(&m, PEND_FIT_RATE, last, -1);
        motion_column(&m, PEND_FIT_PASSAGE, 0, -1);
        if (cart) motion_column(&m, PEND_FIT_CART, 1, -1);
        for (int k = 0; k < 4 && forces; k++) {
            motion_column(&m, k % 2 ? PEND_FIT_ACROSS : PEND_FIT_ALONG, k < 2 ? 0 : last,
                          k < 2 ? 0.25 : -1);
            m.column[m.problem.columns - 1].still = k == 3;
        }
        if (which == 0) motion_column(&m, PEND_FIT_AMPLITUDE, 0, -1);
        if (which == 0) motion_column(&m, PEND_FIT_PERIOD, 0, -1);
        motion_unknown(&m, PEND_FIT_CAMERA + 3, 0, 0, 0.2);
        check_slopes(&m);
        pend_terms_free(&m.terms);
    }
}

/* gravity at rest, a period from K(sin 45 deg) = 1.854, an amplitude from the energy, a missed
 * gate */
TEST(measurements_of_states_are_those_of_textbooks) {
    struct motion m;
    double phi[1] = {-M_PI / 2}, rate[1] = {0}, acc[1] = {0}, place[1] = {0}, omega[1] = {2};
    struct fit_number number;
    motion_new(&m, 1, 0);
    static const enum pend_fit_kind kinds[] = {PEND_FIT_ALONG, PEND_FIT_PERIOD, PEND_FIT_AMPLITUDE,
                                               PEND_FIT_PASSAGE};
    for (int k = 0; k < 4; k++) motion_column(&m, kinds[k], 0, 0.3);
    struct fit_seen seen = {.problem = &m.problem, .length = m.length, .zero = m.zero};
    seen.omega = omega, seen.gravity = 9.81, seen.swing = 3;
    seen.value[PEND_DERIVED_PHI] = phi, seen.value[PEND_DERIVED_RATE] = rate;
    seen.value[PEND_DERIVED_ACC] = acc;
    seen.value[PEND_DERIVED_ZDD_RE] = seen.value[PEND_DERIVED_ZDD_IM] = place;
    pend_fit_number(&seen, &m.column[0], 0, 0, &number);
    CHECK(fabs(number.value + 9.81) < 1e-14);
    phi[0] = 0;
    pend_fit_number(&seen, &m.column[1], 0, 0, &number);
    CHECK(fabs(number.value - 2 * 1.8540746773013719) < 1e-13);
    phi[0] = -M_PI / 2, rate[0] = 4 * sin(0.4);
    pend_fit_number(&seen, &m.column[2], 0, 0, &number);
    CHECK(fabs(number.value - 0.8) < 1e-13);
    // 0.01 rad beyond the gate at 2 rad/s: the passage was 5 ms earlier
    phi[0] = -M_PI / 2 + 0.01, rate[0] = 2;
    pend_fit_number(&seen, &m.column[3], -M_PI / 2, 0, &number);
    CHECK(fabs(number.value + 0.005) < 1e-6);
}
