#include <math.h>
#include <string.h>

#include "core/tree/rules.h"
#include "tests/harness/test.h"

static const double t[] = {-1, 0.5, 2}, value[] = {3, -1, 5};

/* a pendulum of two arms with a table on its second one */
static struct pend_terms *rules_terms(double list[8]) {
    const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_INPUT] = 1},
                        ones[PEND_TERM_ONES] = {[PEND_TERM_PIECE] = 1};
    struct pend_terms *terms;
    if (pend_terms_new(&terms, 2, rows, ones, 0, NULL, NULL) != PEND_OK) return NULL;
    for (int i = 0; i < 8; i++) list[i] = 77;
    return terms;
}

TEST(inputs_end_at_the_instants_of_tables_in_either_direction) {
    const struct pend_table table = {.drives = 1, .count = 3, .t = t, .value = value};
    const struct pend_rules rules = {.tables = 1, .table = &table};
    CHECK(pend_rules_next(&rules, -2, 1) == -1 && pend_rules_next(&rules, -1, 1) == 0.5);
    CHECK(pend_rules_next(&rules, 0.5, 1) == 2 && pend_rules_next(&rules, 2, 1) == INFINITY);
    CHECK(pend_rules_next(&rules, 3, -1) == 2 && pend_rules_next(&rules, 2, -1) == 0.5);
    CHECK(pend_rules_next(&rules, -1, -1) == -INFINITY);
}

TEST(inputs_are_those_of_the_piece_on_that_side) {
    static const struct {
        int linear, way;
        enum pend_outside outside;
        double now, input, rise;
    } tries[] = {{0, 1, 0, -1, 3, 0},   {0, 1, 0, 0.5, -1, 0},        {0, -1, 0, 0.5, 3, 0},
                 {0, 1, 1, 2, 5, 0},    {0, 1, 2, 2, 0, 0},           {0, -1, 1, 2, -1, 0},
                 {1, 1, 1, 0.5, -1, 4}, {1, -1, 1, 0.5, -1, -8. / 3}, {1, 1, 1, 1.25, 2, 4},
                 {1, 1, 1, -5, 3, 0},   {1, 1, 2, -5, 0, 0},          {1, -1, 1, 2, 5, 4}};
    double list[8];
    OWN(pend_terms, free) *terms = rules_terms(list);
    REQUIRE(terms);
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        const struct pend_table table = {.drives = 1,
                                         .count = 3,
                                         .linear = tries[i].linear,
                                         .outside = tries[i].outside,
                                         .t = t,
                                         .value = value};
        const struct pend_rules rules = {.tables = 1, .table = &table};
        pend_rules_inputs(&rules, terms, tries[i].now, tries[i].way, list, 1);
        CHECK(list[terms->row[PEND_TERM_INPUT]] == 0);
        CHECK(list[terms->one[PEND_TERM_PIECE]] == tries[i].now);
        CHECK(fabs(list[terms->row[PEND_TERM_INPUT] + 1] - tries[i].input) < 1e-15);
        CHECK(fabs(list[terms->row[PEND_TERM_INPUT_RATE] + 1] - tries[i].rise) < 1e-15);
    }
}

TEST(motions_beyond_a_table_are_refused_unless_it_says_what_it_gives_there) {
    static const int order[] = {1, 0};
    struct pend_table table = {.drives = 1, .count = 3, .t = t, .value = value};
    const struct pend_rules rules = {.tables = 1, .table = &table};
    struct pend_error error;
    CHECK(pend_rules_check(&rules, order, -1, 2, &error) == PEND_OK);
    CHECK(pend_rules_check(&rules, order, 2, -1, &error) == PEND_OK);
    CHECK(pend_rules_check(&rules, order, 0, 2.5, &error) == PEND_INVALID);
    CHECK_SAYING(error.arm == 0 && strstr(error.text, "extend the table"), "%s", error.text);
    CHECK(pend_rules_check(&rules, order, 2, -1.5, &error) == PEND_INVALID);
    table.outside = PEND_OUTSIDE_HOLD;
    CHECK(pend_rules_check(&rules, order, -9, 9, &error) == PEND_OK);
}

/* flights of which each takes e or 1 / e times as long as the previous one, as long as the
 * motion */
TEST(pieces_are_counted_by_samples_instants_and_impacts) {
    static const struct {
        double gap, e, span, rate;
    } tries[] = {
        {1e-6, 1, 0.5, 2}, {1e-3, 0.9, 1, 1}, {INFINITY, 0.999, 100, 3}, {INFINITY, 0.5, 10, 3}};
    const struct pend_table table = {.count = 3, .t = t, .value = value};
    const struct pend_controller controller = {.period = 0.01};
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        double least = 0, most = tries[i].gap, e = tries[i].e, span = tries[i].span,
               rate = tries[i].rate;
        struct pend_rules rules = {.least = &least, .most = &most, .restitution = &e};
        double pieces = pend_rules_pieces(&rules, 1, span, rate), flight = fmin(most, M_PI) / rate,
               sum = 0;
        long count = 0;
        for (; (sum += flight) < span && flight > 1e-6 * (most > 1); count++)
            flight *= most > 1 ? e : 1 / e;
        CHECK_SAYING(fabs(pieces - (double)count) <= 2 + span * rate, "%g for %ld", pieces, count);
        rules.tables = rules.controllers = 1, rules.table = &table, rules.controller = &controller;
        CHECK(fabs(pend_rules_pieces(&rules, 1, span, rate) - pieces - 3 - span / 0.01) < 1e-6);
    }
}
