/* Closed forms of pendulums on a cart: small swings, momentum along the rail, a cart too heavy to
 * move, a slope on which everything falls equally.
 * Leaves to others: the equations against the dense form (test_bodies_quad), other closed forms
 * (test_closed_forms).
 * Invariant: stored arm 0 is the cart, the caller's last. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "core/modes/damped.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 4, INSTANTS = 41 };

/* arms of length 1 m and mass 1 kg on a cart, and samples of their motion */
struct rig {
    int arms;
    struct pend_tree *tree;
    struct pend_terms *terms;
    double value[16 * ARMS], phi[ARMS + 1], rate[ARMS + 1];
    struct pend_loads loads;
    double t[INSTANTS], angle[ARMS * INSTANTS], speed[ARMS * INSTANTS], zd_re[ARMS * INSTANTS],
        place[INSTANTS], pace[INSTANTS], reaction[INSTANTS];
};

/* parent: of the caller's arms, `arms` for the cart */
static void rig_open(struct rig *r, int arms, const int parent[], double cart, double angle) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {[PEND_TERM_RAIL] = 1};
    double length[ARMS + 1], mass[ARMS + 1];
    int carried[ARMS + 1];
    memset(r, 0, sizeof *r);
    for (int k = 0; k <= arms; k++) {
        length[k] = mass[k] = 1, r->phi[k] = k ? -M_PI_2 : 0;
        carried[k] = k < arms ? parent[k] : -1;
    }
    mass[arms] = cart;
    r->arms = arms;
    rows[PEND_TERM_STIFFNESS] = 1;
    REQUIRE(pend_tree_new(&r->tree, arms + 1, length, mass, carried, NULL) == PEND_OK);
    REQUIRE(pend_terms_new(&r->terms, arms + 1, rows, ones, 0, NULL, NULL) == PEND_OK);
    pend_terms_clear(r->terms, r->tree, r->value);
    r->value[r->terms->one[PEND_TERM_RAIL]] = angle;
    r->loads = (struct pend_loads){9.81, r->terms, r->value};
}

static void rig_close(struct rig *r) {
    pend_terms_free(&r->terms);
    pend_tree_free(&r->tree);
}

static void rig_run(struct rig *r, double span) {
    struct pend_problem problem = {
        .tree = r->tree,
        .loads = r->loads,
        .phi = r->phi,
        .rate = r->rate,
        .times = {.count = INSTANTS, .span = span, .divisor = INSTANTS - 1},
        .rtol = 1e-15,
        .atol = 1e-15,
        .atol_given = 1};
    struct pend_samples samples = {.cap = INSTANTS,
                                   .t = r->t,
                                   .phi = r->angle,
                                   .rate = r->speed,
                                   .zd_re = r->zd_re,
                                   .cart_place = r->place,
                                   .cart_speed = r->pace,
                                   .cart_reaction = r->reaction};
    OWN(pend_run, free) *run;
    int done = 0;
    REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
    CHECK(pend_run_stats(run).energy_drift < 1e-14);
}

TEST(law_a_pendulum_on_a_free_cart_swings_faster_by_the_root_of_one_plus_the_masses_ratio) {
    double worst = 0;
    for (double cart = 0.01; cart < 1000; cart *= 7) {
        const int parent[] = {1};
        OWN(rig, close) r;
        struct pend_damped *d;
        rig_open(&r, 1, parent, cart, 0);
        double omega = sqrt((1 + 1 / cart) * 9.81);
        REQUIRE(pend_damped_new(&d, r.tree, &r.loads, r.phi, NULL) == PEND_OK);
        CHECK_INT(d->count, 2);
        CHECK(d->omega[0] == 0 && d->decay[0] == 0 && d->decay[1] == 0);
        worst = fmax(worst, fabs(d->omega[1] / omega - 1));
        // the mass and the cart move in opposite directions
        CHECK(fabs(d->re[2] / d->re[3] + 1 / (1 + cart)) < 1e-13);
        pend_damped_free(&d);
        // the same in motion: after half a period a small swing is at its opposite end
        r.phi[1] += 1e-5;
        rig_run(&r, M_PI / omega);
        double turned = r.angle[INSTANTS - 1] + M_PI_2;
        CHECK(fabs(turned + 1e-5) < 1e-14);
    }
    CHECK_RESIDUAL(worst, 2e-14, "omega^2 = (1 + m/M) g / l");
}

TEST(law_what_hangs_on_a_free_cart_keeps_its_momentum_along_a_level_rail) {
    const int parent[ARMS] = {4, 0, 4, 2};
    OWN(rig, close) r;
    double worst = 0;
    rig_open(&r, ARMS, parent, 2, 0);
    for (int k = 1; k <= ARMS; k++) r.phi[k] = 0.7 * k, r.rate[k] = 1 - 0.4 * k;
    r.rate[0] = 0.3;
    rig_run(&r, 10);
    for (int i = 0; i < INSTANTS; i++) {
        double sum[2] = {2 * r.pace[0], 2 * r.pace[i]};
        for (int k = 0; k < ARMS; k++) sum[0] += r.zd_re[k], sum[1] += r.zd_re[i * ARMS + k];
        worst = fmax(worst, fabs(sum[1] - sum[0]));
    }
    CHECK(fabs(r.place[INSTANTS - 1]) > 0.1);
    CHECK_RESIDUAL(worst, 3e-13, "momentum, kg m/s");
}

TEST(law_a_cart_too_heavy_to_move_is_a_pivot_that_stands) {
    const int hung[] = {2, 0}, fixed[] = {-1, 0};
    const double length[] = {1, 1}, mass[] = {1, 1};
    OWN(rig, close) r;
    double t[INSTANTS], angle[2 * INSTANTS], worst = 0;
    rig_open(&r, 2, hung, 1e17, 0.3);
    r.loads.gravity = 9.81;
    r.value[pend_terms_place(r.terms, PEND_TERM_STIFFNESS, 0)] = 1e20; // keeps it on its slope
    r.value[pend_terms_place(r.terms, PEND_TERM_REST, 0)] = 9.81 * sin(0.3) * (1e17 + 2) / 1e20;
    r.phi[1] = 0.1, r.phi[2] = 0.2;
    rig_run(&r, 1);
    struct pend_tree *tree;
    REQUIRE(pend_tree_new(&tree, 2, length, mass, fixed, NULL) == PEND_OK);
    struct pend_problem problem = {.tree = tree,
                                   .loads = {.gravity = 9.81},
                                   .phi = r.phi + 1,
                                   .rate = r.rate + 1,
                                   .times = {.count = INSTANTS, .span = 1, .divisor = INSTANTS - 1},
                                   .rtol = 1e-15};
    struct pend_samples samples = {.cap = INSTANTS, .t = t, .phi = angle};
    struct pend_run *run;
    int done = 0;
    REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
    pend_run_free(&run);
    pend_tree_free(&tree);
    worst = test_gap(2 * INSTANTS, r.angle, angle);
    CHECK_RESIDUAL(worst, 1e-15, "angles on a heavy cart against a fixed pivot");
}

TEST(law_down_a_slope_without_friction_all_falls_alike_and_the_rail_carries_the_rest) {
    // in the falling frame the remaining gravity is perpendicular to the rail, and the arms rest
    // along it
    const double slope = -0.4;
    const int parent[] = {3, 0, 3};
    OWN(rig, close) r;
    double worst = 0, carried = 0;
    rig_open(&r, 3, parent, 2, slope);
    for (int k = 1; k <= 3; k++) r.phi[k] = slope - M_PI_2;
    rig_run(&r, 4);
    for (int i = 0; i < INSTANTS; i++) {
        double x = -9.81 * sin(slope) * r.t[i] * r.t[i] / 2;
        worst = fmax(worst, fabs(r.place[i] - x) / fmax(1, x));
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs(r.angle[3 * i + k] - (slope - M_PI_2)));
        carried = fmax(carried, fabs(r.reaction[i] / (5 * 9.81 * cos(slope)) - 1));
    }
    CHECK_RESIDUAL(worst, 1e-13, "place and angles");
    CHECK_SAYING(carried < 1e-14, "force across the rail: %g", carried);
}
