/* Tests of core/extended/extended and core/extended/method_extended: the reference's digits, laws
 * to 28 digits, every instruction set.
 * Leaves to others: single operations (test_pairs).
 * Invariant: compared numbers have more digits than a double, unless the test says otherwise. */
#include "core/extended/extended.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/harness/quad.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { MOST = 48 };

/* a state with its own memory */
struct full {
    double phi[MOST], phi_low[MOST], rate[MOST], rate_low[MOST];
};

static struct pend_extended_state full_view(struct full *full) {
    return (struct pend_extended_state){full->phi, full->phi_low, full->rate, full->rate_low};
}

/* largest difference of two states, with all digits */
static double full_gap(int n, const struct full *a, const struct full *b) {
    double gap = 0;
    for (int k = 0; k < n; k++) {
        gap = fmax(gap, fabs((a->phi[k] - b->phi[k]) + (a->phi_low[k] - b->phi_low[k])));
        gap = fmax(gap, fabs((a->rate[k] - b->rate[k]) + (a->rate_low[k] - b->rate_low[k])));
    }
    return gap;
}

/* the state after a time; *steps receives the number of steps, if not NULL */
static struct full follow(const struct pend_tree *tree, const struct full *start, double t,
                          double rtol, enum pend_isa isa, long *steps) {
    OWN(pend_extended, free) *extended;
    struct full from = *start, to = {{0}, {0}, {0}, {0}};
    struct pend_extended_state from_view = full_view(&from), to_view = full_view(&to);
    enum pend_extended_stage stage;
    long count = 1;
    if (!CHECK(pend_extended_new(&extended, tree, NULL, rtol, 0, isa, NULL) == PEND_OK)) return to;
    pend_extended_start(extended, TEST_LOADS(9.81), &from_view, 0, t);
    while ((stage = pend_extended_step(extended)) == PEND_EXTENDED_UNDER_WAY) count++;
    CHECK(stage == PEND_EXTENDED_STOPPED && pend_extended_time(extended) == t);
    pend_extended_end(extended, &to_view);
    if (steps) *steps = count;
    return to;
}

static struct full full_start(const struct test_tree *t) {
    struct full start = {{0}, {0}, {0}, {0}};
    memcpy(start.phi, t->phi, (size_t)t->tree->n * sizeof(double));
    memcpy(start.rate, t->rate, (size_t)t->tree->n * sizeof(double));
    return start;
}

/* ---- the reference's digits */

/* t (a double, and the difference to the decimal), phi[4], phi'[4] with all digits of a quad: sums
 * of two doubles from 25 digits of text */
static int reference_row(FILE *file, double *t, double *late, struct full *row) {
    char text[64];
    for (int i = 0; i < 13; i++) {
        if (fscanf(file, "%63s", text) != 1) return 0;
        test_quad x = test_quad_read(text);
        if (i == 0) *t = (double)x, *late = (double)(x - *t);
        if (i >= 1 && i < 5)
            row->phi[i - 1] = (double)x, row->phi_low[i - 1] = (double)(x - (double)x);
        if (i >= 5 && i < 9)
            row->rate[i - 5] = (double)x, row->rate_low[i - 5] = (double)(x - (double)x);
    }
    return 1;
}

TEST(extended_has_all_25_digits_of_the_reference) {
    OWN(test_paper, clear) paper;
    struct full row, got, start = {{0}, {0}, {0}, {0}};
    struct pend_extended *extended;
    struct pend_extended_state view = full_view(&start), got_view = full_view(&got);
    double t, late = 0, acc[4], worst = 0;
    int rows = 0;
    test_paper_init(&paper, 2);
    FILE *file = fopen("tests/golden/paper_example.txt", "r");
    REQUIRE(file);
    for (int c; (c = getc(file)) == '#';)
        while (c != '\n' && c != EOF) c = getc(file);
    fseek(file, -1, SEEK_CUR);
    REQUIRE(pend_extended_new(&extended, paper.tree, NULL, 1e-30, 0, pend_isa_best(), NULL) ==
            PEND_OK);
    pend_extended_start(extended, TEST_LOADS(9.81), &view, 0, 5);
    long allocations = test_alloc_count();
    while (reference_row(file, &t, &late, &row)) {
        while (pend_extended_time(extended) < t || t == 0) {
            pend_extended_step(extended);
            if (t == 0) break;
        }
        pend_extended_at(extended, 1, &t, &got_view, acc, NULL);
        struct full sorted = row;
        for (int k = 0; k < 4; k++) {
            int of = paper.tree->order[k];
            sorted.phi[k] = row.phi[of], sorted.phi_low[k] = row.phi_low[of];
            sorted.rate[k] = row.rate[of], sorted.rate_low[k] = row.rate_low[of];
            // from the double to the decimal, 1e-16 s later
            got.phi_low[k] += late * got.rate[k];
            got.rate_low[k] += late * acc[k];
        }
        worst = fmax(worst, full_gap(4, &got, &sorted));
        rows++;
    }
    CHECK_INT(test_alloc_count(), allocations);
    CHECK_INT(rows, TEST_PAPER_ROWS);
    CHECK_RESIDUAL(
        worst, 5e-24,
        "phi and phi' over all 51 instants; the reference has 25 digits of numbers up to 9");
    pend_extended_free(&extended);
    fclose(file);
}

/* ---- laws */

TEST(extended_there_and_back_ends_where_it_began) {
    unsigned long long seed = 1;
    double worst = 0;
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++)
        for (int n = 1; n <= 12; n++) {
            OWN(test_tree, clear) t;
            test_tree_random(&t, TEST_TREE_ATTACHED, n, 0.3, &seed);
            struct full start = full_start(&t);
            struct full there = follow(t.tree, &start, 1, 1e-30, (enum pend_isa)isa, NULL);
            struct full back = follow(t.tree, &there, -1, 1e-30, (enum pend_isa)isa, NULL);
            CHECK(full_gap(n, &start, &there) > 0.1);
            worst = fmax(worst, full_gap(n, &start, &back));
        }
    CHECK_RESIDUAL(worst, 1e-26, "1 s there and back, 1 to 12 arms, every instruction set");
}

static test_quad quad_energy(const struct pend_tree *tree, const struct full *state) {
    test_quad re[MOST], im[MOST], height[MOST], energy = 0;
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        test_quad phi = (test_quad)state->phi[k] + state->phi_low[k],
                  rate = (test_quad)state->rate[k] + state->rate_low[k];
        test_quad c = test_quad_cos(phi), s = test_quad_sin(phi), l = tree->len[k];
        re[k] = (p < 0 ? 0 : re[p]) - l * rate * s;
        im[k] = (p < 0 ? 0 : im[p]) + l * rate * c;
        height[k] = (p < 0 ? 0 : height[p]) + l * s;
        energy += tree->mass[k] * ((re[k] * re[k] + im[k] * im[k]) / 2 + 9.81 * height[k]);
    }
    return energy;
}

TEST(extended_keeps_the_energy_to_28_digits) {
    unsigned long long seed = 2;
    double worst = 0, plain = 0;
    for (int n = 2; n <= MOST; n += 9) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
        struct full start = full_start(&t),
                    end = follow(t.tree, &start, 0.5, 1e-30, pend_isa_best(), NULL), high = end;
        test_quad first = quad_energy(t.tree, &start), scale = 0;
        for (int k = 0; k < n; k++)
            scale += (test_quad)9.81 * t.tree->len[k] * t.tree->subtree_mass[k];
        worst = fmax(worst, (double)(test_quad_abs(quad_energy(t.tree, &end) - first) / scale));
        memset(high.phi_low, 0, sizeof high.phi_low);
        plain = fmax(plain, (double)(test_quad_abs(quad_energy(t.tree, &high) - first) / scale));
    }
    CHECK_RESIDUAL(worst, 1e-28, "energy after 0.5 s, relative to g sum l (S^T m)");
    CHECK(plain > 1e-18);
}

TEST(extended_error_follows_the_tolerance) {
    unsigned long long seed = 3;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, 3, 0.3, &seed);
    struct full start = full_start(&t),
                best = follow(t.tree, &start, 1, 1e-30, pend_isa_best(), NULL);
    long last = 0;
    double before = 0;
    for (double rtol = 1e-28; rtol < 1e-5; rtol *= 1e4) {
        long steps;
        struct full got = follow(t.tree, &start, 1, rtol, pend_isa_best(), &steps);
        double gap = full_gap(3, &got, &best);
        CHECK_SAYING(gap < 3e3 * rtol, "error %g at rtol %g", gap, rtol);
        CHECK_SAYING(gap > before, "error %g at rtol %g is not above %g", gap, rtol, before);
        before = gap;
        last = steps;
    }
    CHECK(last > 3);
}

/* the equations themselves, by the paper's matrices in quad precision */
TEST(extended_accelerations_and_forces_are_those_of_the_equations) {
    unsigned long long seed = 4;
    double worst[2] = {0, 0};
    for (int n = 1; n <= 16; n++) {
        OWN(test_tree, clear) t;
        OWN(pend_extended, free) *extended;
        struct full at;
        double acc[MOST], force[MOST], x;
        test_quad acc_want[MOST], force_want[MOST];
        test_tree_random(&t, TEST_TREE_ATTACHED, n, n % 3 ? 0.3 : 3, &seed);
        struct full start = full_start(&t);
        struct pend_extended_state view = full_view(&start), at_view = full_view(&at);
        REQUIRE(pend_extended_new(&extended, t.tree, NULL, 1e-28, 0, pend_isa_best(), NULL) ==
                PEND_OK);
        pend_extended_start(extended, TEST_LOADS(9.81), &view, 0, 1);
        pend_extended_step(extended);
        x = 0.5 * pend_extended_time(extended);
        pend_extended_at(extended, 1, &x, &at_view, acc, force);
        test_quad_dynamics(t.tree, TEST_LOADS(9.81), at.phi, at.rate, acc_want, force_want);
        worst[0] = fmax(worst[0], test_quad_gap(n, acc, acc_want));
        worst[1] = fmax(worst[1], test_quad_gap(n, force, force_want));
    }
    // states and results are rounded to doubles
    CHECK_RESIDUAL(worst[0], 1e-14, "phi''");
    CHECK_RESIDUAL(worst[1], 1e-14, "lambda");
}

TEST(extended_digits_are_the_same_in_every_instruction_set) {
    unsigned long long seed = 6;
    for (int n = 1; n <= 9; n++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, TEST_TREE_ATTACHED, n, 0.3, &seed);
        struct full start = full_start(&t);
        struct full best = follow(t.tree, &start, 0.5, 1e-30, pend_isa_best(), NULL);
        struct full base = follow(t.tree, &start, 0.5, 1e-30, PEND_ISA_BASE, NULL);
        CHECK_SAYING(full_gap(n, &best, &base) < 1e-27, "%d arms: %g", n,
                     full_gap(n, &best, &base));
    }
}

TEST(extended_refuses_tolerances_out_of_range_and_fails_cleanly_without_memory) {
    OWN(test_paper, clear) paper;
    struct pend_extended *extended;
    struct pend_error error;
    test_paper_init(&paper, 2);
    CHECK(pend_extended_new(&extended, paper.tree, NULL, 1e-31, 0, pend_isa_best(), &error) ==
              PEND_INVALID &&
          !extended);
    CHECK(pend_extended_new(&extended, paper.tree, NULL, 1e-20, -1, pend_isa_best(), &error) ==
              PEND_INVALID &&
          !extended);
    test_alloc_fail(1, 0);
    CHECK(pend_extended_new(&extended, paper.tree, NULL, 1e-20, 0, pend_isa_best(), &error) ==
              PEND_NO_MEMORY &&
          !extended);
    test_alloc_faults_off();
}

TEST(extended_refuses_trees_whose_series_would_fill_the_memory) {
    enum { ARMS = 100000 };
    OWN(pend_tree, free) *tree;
    struct pend_extended *extended;
    struct pend_error error;
    static double one[ARMS];
    static int parent[ARMS];
    for (int k = 0; k < ARMS; k++) one[k] = 1, parent[k] = k - 1;
    REQUIRE(pend_tree_new(&tree, ARMS, one, one, parent, NULL) == PEND_OK);
    /* with every instruction set */
    for (int isa = PEND_ISA_BASE; isa <= (int)pend_isa_best(); isa++) {
        CHECK(pend_extended_new(&extended, tree, NULL, 1e-20, 0, (enum pend_isa)isa, &error) ==
                  PEND_INVALID &&
              !extended);
        CHECK_SAYING(
            strstr(error.text, "32 digits are for smaller trees: the series of 100000 arms"), "%s",
            error.text);
    }
}

/* ---- as a method */

TEST(extended_method_gives_doubles_that_are_right_to_the_last_digit) {
    OWN(test_paper, clear) paper;
    struct test_paper_row row[TEST_PAPER_ROWS];
    OWN(test_record, clear) record = {0};
    test_paper_init(&paper, 501);
    REQUIRE(test_paper_read(row));
    test_record_blocks(&record, pend_method_find("taylor")->extended, &paper.problem, 64, 1000);
    CHECK_INT(record.status, PEND_OK);
    struct test_record_gap gap = test_paper_gap(&record, 10, row);
    // instants are doubles, the reference's are decimals: that affects the last digits of fast
    // motion
    CHECK_RESIDUAL(gap.phi, 2e-14, "phi");
    CHECK_RESIDUAL(gap.rate, 1e-13, "phi'");
    CHECK_RESIDUAL(gap.force, 1e-11, "lambda");
}

TEST(extended_method_says_when_numbers_overflow) {
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record;
    test_paper_init(&paper, 3);
    paper.rate[0] = 1e200;
    test_record_blocks(&record, pend_method_find("taylor")->extended, &paper.problem, 3, INFINITY);
    CHECK(record.status == PEND_NOT_FINITE || record.status == PEND_STEP_TOO_SMALL);
    CHECK(strstr(record.error.text, "at t = 0"));
}

TEST(extended_method_fails_cleanly_without_memory) {
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record = {0};
    test_paper_init(&paper, 3);
    for (long i = 1;; i++) {
        struct pend_run *run;
        test_alloc_fail(i, 0);
        enum pend_status status =
            pend_run_new(&run, pend_method_find("taylor")->extended, &paper.problem, NULL);
        test_alloc_faults_off();
        CHECK(status == PEND_OK ? run != NULL : status == PEND_NO_MEMORY && !run);
        pend_run_free(&run);
        if (status == PEND_OK) {
            CHECK(i > 2);
            break;
        }
    }
    test_record_blocks(&record, pend_method_find("taylor")->extended, &paper.problem, 3, INFINITY);
    CHECK_INT(record.status, PEND_OK);
}

TEST(extended_start_keeps_what_rounding_left_of_it) {
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) plain, moved;
    test_paper_init(&paper, 2);
    double low[4] = {1e-17, 0, 0, 0}, none[4] = {0, 0, 0, 0};
    for (int k = 0; k < 4; k++) paper.phi[k] = 0.5 * k;
    paper.problem.phi_low = none;
    test_record_blocks(&plain, pend_method_taylor.extended, &paper.problem, 2, INFINITY);
    paper.problem.phi_low = low;
    paper.problem.rate_low = none;
    test_record_blocks(&moved, pend_method_taylor.extended, &paper.problem, 2, INFINITY);
    // 1e-17 grows over 5 s to the size of a double's rounding
    double gap = test_record_gap(&plain, &moved).phi;
    CHECK_SAYING(gap > 0 && gap < 1e-12, "%g", gap);
}
