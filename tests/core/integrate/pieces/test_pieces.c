#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/run.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { INSTANTS = 121 };

/* a rod of 0.5 m and 0.6 kg without gravity, whose joint is driven by a table, and its samples */
struct driven {
    struct pend_tree *tree;
    struct pend_terms *terms;
    struct pend_table table;
    struct pend_rules rules;
    double value[8], t[INSTANTS], phi[INSTANTS], rate[INSTANTS], theta0, rate0;
    struct pend_problem problem;
};

static const double inertia = 0.6 * 0.5 * 0.5 / 3, knot[] = {-0.5, 0.3, 0.7, 1.2},
                    torque[] = {0.2, -0.5, 0.1, 0.4};

static void driven_open(struct driven *d, int linear, double first, double last) {
    const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_ROD] = 1, [PEND_TERM_INPUT] = 1},
                        ones[PEND_TERM_ONES] = {[PEND_TERM_PIECE] = 1}, bare = 1;
    double length = 0.5, mass = 0;
    int parent = -1;
    memset(d, 0, sizeof *d);
    if (pend_tree_new_bare(&d->tree, 1, &length, &mass, &bare, &parent, NULL) != PEND_OK) abort();
    if (pend_terms_new(&d->terms, 1, rows, ones, 0, NULL, NULL) != PEND_OK) abort();
    d->value[d->terms->row[PEND_TERM_ROD]] = 0.6;
    d->table = (struct pend_table){.count = 4, .linear = linear, .t = knot, .value = torque};
    d->rules = (struct pend_rules){.tables = 1, .table = &d->table};
    d->terms->rules = &d->rules;
    d->theta0 = 0.1, d->rate0 = 0.3;
    d->problem = (struct pend_problem){
        .tree = d->tree,
        .loads = {0, d->terms, d->value},
        .phi = &d->theta0,
        .rate = &d->rate0,
        .times = {
            .count = INSTANTS, .start = first, .span = last - first, .divisor = INSTANTS - 1}};
}

static void driven_close(struct driven *d) {
    pend_terms_free(&d->terms);
    pend_tree_free(&d->tree);
}

/* the motion in blocks of `cap` rows */
static enum pend_status driven_run(struct driven *d, int cap, struct pend_run_stats *stats,
                                   struct pend_error *error) {
    OWN(pend_run, free) *run;
    int done = 0;
    long row = 0;
    enum pend_status status = pend_run_new(&run, &pend_method_taylor, &d->problem, error);
    while (status == PEND_OK && !done) {
        struct pend_samples block = {.cap = cap < INSTANTS - row ? cap : INSTANTS - row,
                                     .t = d->t + row,
                                     .phi = d->phi + row,
                                     .rate = d->rate + row};
        status = pend_run_next(run, &block, 1, &done, error);
        row += block.count;
    }
    if (run && stats) *stats = pend_run_stats(run);
    return status;
}

/* angle and rate at t of a motion that begins at `from`: a parabola or a cubic in each piece */
static void driven_want(const struct driven *d, double from, double t, double *phi, double *rate) {
    *phi = d->theta0, *rate = d->rate0;
    for (int i = 0; i < 3; i++) {
        double a = fmax(from, knot[i]), b = fmin(t, knot[i + 1]), x = b - a;
        double rise = d->table.linear ? (torque[i + 1] - torque[i]) / (knot[i + 1] - knot[i]) : 0;
        double c = (torque[i] + rise * (a - knot[i])) / inertia, e = rise / inertia;
        if (x <= 0) continue;
        *phi += *rate * x + c * x * x / 2 + e * x * x * x / 6;
        *rate += c * x + e * x * x / 2;
    }
}

TEST(tables_of_torque_give_parabolas_and_cubics) {
    for (int linear = 0; linear < 2; linear++) {
        static struct driven d;
        struct pend_run_stats stats = {0};
        struct pend_error error;
        double worst = 0;
        driven_open(&d, linear, -0.45, 1.2);
        d.problem.accuracy = 1e-6;
        CHECK(driven_run(&d, INSTANTS, &stats, &error) == PEND_OK);
        for (int i = 0; i < INSTANTS; i++) {
            double phi, rate;
            driven_want(&d, -0.45, d.t[i], &phi, &rate);
            worst = fmax(worst, fmax(fabs(d.phi[i] - phi), fabs(d.rate[i] - rate)));
        }
        CHECK_RESIDUAL(worst, 2e-14, "torque by a table");
        CHECK_RESIDUAL(stats.energy_drift, 2e-14, "work of a table");
        CHECK(stats.horizon == d.t[INSTANTS - 1]);
        driven_close(&d);
    }
}

TEST(tables_go_backwards_as_they_went_forwards) {
    static struct driven d, back;
    struct pend_error error;
    driven_open(&d, 1, 0, 1.2);
    driven_open(&back, 1, 1.2, 0);
    CHECK(driven_run(&d, INSTANTS, NULL, &error) == PEND_OK);
    back.theta0 = d.phi[INSTANTS - 1], back.rate0 = d.rate[INSTANTS - 1];
    CHECK(driven_run(&back, INSTANTS, NULL, &error) == PEND_OK);
    double gap = fmax(fabs(back.phi[INSTANTS - 1] - d.theta0), fabs(back.rate[INSTANTS - 1] - 0.3));
    CHECK_RESIDUAL(gap, 2e-14, "back at the start");
    driven_close(&d);
    driven_close(&back);
}

TEST(pieces_give_the_same_bits_however_the_blocks_are_cut_and_carried) {
    static struct driven d;
    for (int extended = 0; extended < 2; extended++) {
        const struct pend_method *method =
            extended ? pend_method_taylor.extended : &pend_method_taylor;
        OWN(test_record, clear) whole, carried;
        driven_open(&d, 1, 0, 1.2);
        d.problem.accuracy = 1e-6;
        test_record_blocks(&whole, method, &d.problem, INSTANTS, INFINITY);
        test_record_carried(&carried, method, &d.problem, 3, 1);
        CHECK(whole.status == PEND_OK && carried.status == PEND_OK && carried.calls > 5);
        CHECK(test_record_same(&whole, &carried) && whole.stats.steps == carried.stats.steps);
        CHECK(whole.stats.horizon == 1.2);
        driven_close(&d);
    }
}

/* the same rod with dry friction by which it sticks, and a stop that it hits */
TEST(joints_that_stick_and_hit_give_the_same_bits_when_carried) {
    static struct driven d;
    OWN(test_record, clear) whole = {0}, carried = {0};
    const double sliding = 0.15, holding = 0.2, least = -0.3, most = INFINITY, bounces = 0.5;
    driven_open(&d, 1, 0, 1.2);
    pend_terms_free(&d.terms);
    const unsigned char rows[PEND_TERM_ROWS] =
        {[PEND_TERM_ROD] = 1, [PEND_TERM_INPUT] = 1, [PEND_TERM_SLIDE] = 1},
                        ones[PEND_TERM_ONES] = {[PEND_TERM_PIECE] = 1};
    REQUIRE(pend_terms_new(&d.terms, 1, rows, ones, 0, NULL, NULL) == PEND_OK);
    d.value[d.terms->row[PEND_TERM_ROD]] = 0.6;
    d.rules.sliding = &sliding, d.rules.holding = &holding;
    d.rules.least = &least, d.rules.most = &most, d.rules.restitution = &bounces;
    d.theta0 = -M_PI_2 + 0.1;
    d.terms->rules = &d.rules;
    d.problem.loads.terms = d.terms;
    test_record_blocks(&whole, &pend_method_taylor, &d.problem, INSTANTS, INFINITY);
    test_record_carried(&carried, &pend_method_taylor, &d.problem, 3, 1);
    CHECK(whole.status == PEND_OK && carried.status == PEND_OK && carried.calls > 5);
    CHECK(test_record_same(&whole, &carried) && whole.stats.steps == carried.stats.steps);
    CHECK(whole.stats.energy_drift < 1e-14 &&
          carried.stats.energy_drift == whole.stats.energy_drift);
    driven_close(&d);
}

TEST(pieces_are_refused_by_methods_that_have_none_and_beyond_their_tables) {
    static struct driven d;
    struct pend_run *run;
    struct pend_error error;
    driven_open(&d, 0, 0, 1.2);
    CHECK(pend_run_new(&run, &pend_method_ode23, &d.problem, &error) == PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "use method taylor"), "%s", error.text);
    driven_close(&d);
    driven_open(&d, 0, 0, 1.3);
    CHECK(driven_run(&d, INSTANTS, NULL, &error) == PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "extend the table"), "%s", error.text);
    driven_close(&d);
}

TEST(pieces_fail_cleanly_without_memory) {
    static struct driven d;
    struct pend_error error;
    enum pend_status status = PEND_NO_MEMORY;
    long count = 1;
    driven_open(&d, 1, 0, 1.2);
    for (; status != PEND_OK && count < 50; count++) {
        test_alloc_fail(count, 0);
        status = driven_run(&d, INSTANTS, NULL, &error);
        test_alloc_faults_off();
        if (status != PEND_OK) CHECK(status == PEND_NO_MEMORY && strstr(error.text, "memory"));
    }
    CHECK(count > 3 && count < 50);
    driven_close(&d);
}
