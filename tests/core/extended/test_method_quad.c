#include <math.h>
#include <string.h>

#include "core/simd/quad_double.h"
#include "core/extended/trust.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* ---- the numbers: what cancels shows the digits that there are */

static double quad_size(quad x) { return fabs(x.part[0]); }

TEST(quads_have_62_digits) {
    unsigned long long seed = 62;
    double product = 0, quotient = 0, circle = 0, twice = 0;
    for (int i = 0; i < 300; i++) {
        quad x = {{test_random(&seed) + 0.5, 0, 0, 0}}, y = {{test_random(&seed) + 0.5, 0, 0, 0}},
             s, c, s2, c2;
        for (int j = 1; j < 4; j++) {
            x = quad_add(x, quad_of(ldexp(test_random(&seed) - 0.5, -54 * j)));
            y = quad_add(y, quad_of(ldexp(test_random(&seed) - 0.5, -54 * j)));
        }
        // (x + y)^2 - (x - y)^2 = 4 x y
        quad sum = quad_add(x, y), gap = quad_sub(x, y);
        quad squares = quad_sub(quad_mul(sum, sum), quad_mul(gap, gap));
        product = fmax(product, quad_size(quad_sub(squares, quad_scale(quad_mul(x, y), 4))));
        quotient = fmax(quotient, quad_size(quad_sub(quad_mul(quad_div(x, y), y), x)));
        quad angle = quad_mul(x, quad_of(i));
        quad_sincos(angle, &s, &c);
        quad_sincos(quad_scale(angle, 2), &s2, &c2);
        circle = fmax(circle, quad_size(quad_sub(quad_fma(s, s, quad_mul(c, c)), quad_of(1))));
        twice = fmax(twice, quad_size(quad_sub(quad_scale(quad_mul(s, c), 2), s2)));
        CHECK(fabs(s.part[0] - sin(angle.part[0])) < 2e-13 &&
              fabs(c.part[0] - cos(angle.part[0])) < 2e-13);
    }
    CHECK_RESIDUAL(product, 1e-60, "4 x y by squares");
    CHECK_RESIDUAL(quotient, 1e-60, "x / y times y");
    CHECK_RESIDUAL(circle, 1e-58, "sin^2 + cos^2 - 1");
    CHECK_RESIDUAL(twice, 1e-57, "sin of twice the angle");
}

/* ---- motions */

static int tumble_init(struct test_paper *paper, double stop, long count) {
    const double one[] = {1, 1};
    const int parent[] = {-1, 0};
    memset(paper, 0, sizeof *paper);
    paper->phi[0] = 0.42920367320510344, paper->phi[1] = 0.92920367320510344;
    if (pend_tree_new(&paper->tree, 2, one, one, parent, NULL) != PEND_OK) return 0;
    paper->problem = (struct pend_problem){
        .tree = paper->tree, .loads.gravity = 9.81, .phi = paper->phi, .rate = paper->rate};
    paper->problem.times =
        (struct pend_times){.count = count, .span = stop, .divisor = (double)(count - 1)};
    return 1;
}

/* the double pendulum after 50 s, where 32 digits are noise: by an independent program in 90
 * digits (9.776, -18.541) */
TEST(quad_follows_a_chaotic_motion_for_fifty_seconds) {
    struct test_paper tumble;
    struct test_record record;
    REQUIRE(tumble_init(&tumble, 50, 6));
    tumble.problem.rtol = 1e-46;
    test_record_blocks(&record, &pend_method_taylor_quad, &tumble.problem, 6, INFINITY);
    REQUIRE(record.status == PEND_OK);
    CHECK(fabs(record.samples.phi[10] - 9.776) < 5e-4 &&
          fabs(record.samples.phi[11] + 18.541) < 5e-4);
    // the state after 20 s, to all digits of a double
    CHECK(record.samples.phi[4] == -1.4164560416052849 &&
          record.samples.phi[5] == -43.45858340112293);
    test_record_clear(&record);
    pend_tree_free(&tumble.tree);
}

/* judged by itself with another tolerance, as 32 digits are */
TEST(quad_can_be_doubted) {
    struct test_paper tumble;
    struct pend_trust *trust;
    int done = 0;
    REQUIRE(tumble_init(&tumble, 16, 33));
    tumble.problem.rtol = 1e-17;
    REQUIRE(pend_trust_new(&trust, &pend_method_taylor_quad, &tumble.problem, 1e-10, NULL) ==
            PEND_OK);
    CHECK_INT(pend_trust_next(trust, INFINITY, &done, NULL), PEND_OK);
    CHECK_SAYING(done && pend_trust_until(trust) > 3 && pend_trust_until(trust) < 16, "%g",
                 pend_trust_until(trust));
    pend_trust_free(&trust);
    pend_tree_free(&tumble.tree);
}

TEST(quad_gives_what_extended_gives) {
    struct test_paper paper;
    struct test_record fine, extended;
    test_paper_init(&paper, 11);
    paper.problem.times.span = 2;
    paper.problem.rtol = 1e-28;
    test_record_blocks(&extended, pend_method_taylor.extended, &paper.problem, 11, INFINITY);
    test_record_blocks(&fine, &pend_method_taylor_quad, &paper.problem, 11, INFINITY);
    REQUIRE(extended.status == PEND_OK && fine.status == PEND_OK);
    struct test_record_gap gap = test_record_gap(&extended, &fine);
    CHECK_SAYING(gap.phi < 1e-15 && gap.rate < 4e-15 && gap.force < 1e-13, "%g %g %g", gap.phi,
                 gap.rate, gap.force);
    test_record_clear(&fine);
    test_record_clear(&extended);
    // cut after every step and carried on: the same bits
    paper.problem.rtol = 1e-20;
    test_record_blocks(&extended, &pend_method_taylor_quad, &paper.problem, 11, INFINITY);
    test_record_carried(&fine, &pend_method_taylor_quad, &paper.problem, 3, 1);
    CHECK(fine.calls > 5 && test_record_same(&fine, &extended));
    test_record_clear(&fine);
    test_record_clear(&extended);
    test_paper_clear(&paper);
}

TEST(quad_is_for_small_trees) {
    unsigned long long seed = 257;
    struct test_tree t;
    struct pend_run *run;
    struct pend_error error;
    test_tree_random(&t, TEST_TREE_ATTACHED, 257, 0.3, &seed);
    struct pend_problem problem = {
        .tree = t.tree, .loads.gravity = 9.81, .phi = t.phi, .rate = t.rate};
    problem.times = (struct pend_times){.count = 2, .span = 1, .divisor = 1};
    CHECK_INT(pend_run_new(&run, &pend_method_taylor_quad, &problem, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "at most 256 arms, got 257"), "%s", error.text);
    test_tree_clear(&t);
}

TEST(quad_fails_cleanly_without_memory) {
    struct test_paper tumble;
    struct pend_run *run;
    struct pend_error error;
    REQUIRE(tumble_init(&tumble, 1, 2));
    for (int i = 1; i <= 2; i++) {
        test_alloc_fail(i, 0);
        CHECK_INT(pend_run_new(&run, &pend_method_taylor_quad, &tumble.problem, &error),
                  PEND_NO_MEMORY);
        test_alloc_faults_off();
    }
    pend_tree_free(&tumble.tree);
}
