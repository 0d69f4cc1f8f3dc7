#include "core/extended/trust.h"

#include <math.h>
#include <stdlib.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* a double pendulum that tumbles: errors grow by about e^(1.6 t), t in s */
static void tumble_init(struct test_tree *t) {
    unsigned long long seed = 1;
    const int parent[] = {-1, 0};
    test_tree_init(t, 2, parent, 0.3, &seed);
    for (int k = 0; k < 2; k++) t->length[k] = t->mass[k] = 1;
    test_tree_rebuild(t);
    t->phi[0] = 2 - M_PI_2, t->phi[1] = 2.5 - M_PI_2;
    t->rate[0] = t->rate[1] = 0;
}

static struct pend_problem tumble_problem(const struct test_tree *t, double span, long count) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads.gravity = 9.81,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)}};
}

static double tumble_until(const struct pend_problem *problem, double tolerance, double work) {
    struct pend_trust *trust;
    int done = 0;
    if (!CHECK(pend_trust_new(&trust, &pend_method_taylor, problem, tolerance, NULL) == PEND_OK))
        return NAN;
    while (!done)
        if (!CHECK(pend_trust_next(trust, work, &done, NULL) == PEND_OK)) break;
    double until = pend_trust_until(trust);
    pend_trust_free(&trust);
    CHECK(!trust);
    return until;
}

TEST(trust_ends_at_the_last_instant_where_the_digits_hold) {
    OWN(test_tree, clear) t;
    OWN(test_record, clear) plain, exact;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 25, 501);
    double until = tumble_until(&problem, 1e-6, INFINITY);
    test_record(&plain, "taylor", &problem);
    test_record_blocks(&exact, pend_method_taylor.extended, &problem, 501, INFINITY);
    long i = 0;
    while (i < 501 && fabs(plain.samples.phi[2 * i] - exact.samples.phi[2 * i]) <= 1e-6 &&
           fabs(plain.samples.phi[2 * i + 1] - exact.samples.phi[2 * i + 1]) <= 1e-6)
        i++;
    REQUIRE(i > 100 && i < 501);
    CHECK_SAYING(until == plain.samples.t[i - 1], "%g instead of %g", until,
                 plain.samples.t[i - 1]);
}

TEST(trust_does_not_depend_on_how_it_is_cut) {
    OWN(test_tree, clear) t;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 25, 501);
    CHECK(tumble_until(&problem, 1e-6, 1) == tumble_until(&problem, 1e-6, INFINITY));
    CHECK(tumble_until(&problem, 1e-6, 100) < tumble_until(&problem, 1e-2, 100));
}

/* carried into a new comparison after every call */
TEST(trust_carried_says_the_same) {
    OWN(test_tree, clear) t;
    struct pend_trust *trust, *next;
    int done = 0, carried = 0;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 25, 501);
    REQUIRE(pend_trust_new(&trust, &pend_method_taylor, &problem, 1e-6, NULL) == PEND_OK);
    for (; !done; carried++) {
        struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
        REQUIRE(pend_trust_next(trust, 300, &done, NULL) == PEND_OK);
        CHECK(pend_trust_carry(trust, &checkpoint) == PEND_OK);
        checkpoint = (struct pend_checkpoint){
            .way = PEND_CHECKPOINT_TAKE, .bytes = checkpoint.used, .at = malloc(checkpoint.used)};
        REQUIRE(checkpoint.at && pend_trust_carry(trust, &checkpoint) == PEND_OK &&
                pend_checkpoint_whole(&checkpoint));
        REQUIRE(pend_trust_new(&next, &pend_method_taylor, &problem, 1e-6, NULL) == PEND_OK);
        checkpoint.way = PEND_CHECKPOINT_PUT;
        checkpoint.used = 0;
        CHECK(pend_trust_carry(next, &checkpoint) == PEND_OK && pend_checkpoint_whole(&checkpoint));
        CHECK(pend_trust_progress(next) == pend_trust_progress(trust));
        free(checkpoint.at);
        pend_trust_free(&trust);
        trust = next;
    }
    CHECK_SAYING(carried > 50, "%d", carried);
    CHECK(pend_trust_until(trust) == tumble_until(&problem, 1e-6, INFINITY));
    pend_trust_free(&trust);
}

TEST(trust_grows_with_the_accuracy_of_the_method) {
    OWN(test_tree, clear) t;
    double last = 0;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 30, 121);
    for (problem.rtol = 1e-4; problem.rtol > 1e-14; problem.rtol *= 1e-3) {
        double until = tumble_until(&problem, 1e-6, INFINITY);
        CHECK_SAYING(until > last, "%g at rtol %g, %g before", until, problem.rtol, last);
        last = until;
    }
}

TEST(trust_says_what_either_run_says) {
    OWN(test_tree, clear) t;
    OWN(pend_trust, free) *trust;
    struct pend_error error = {0};
    int done = 0;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 30, 121);
    problem.rtol = 2;
    CHECK(pend_trust_new(&trust, &pend_method_taylor, &problem, 1e-6, &error) == PEND_INVALID &&
          !trust);
    problem.rtol = 0;
    problem.step_cap = 20;
    REQUIRE(pend_trust_new(&trust, &pend_method_taylor, &problem, 1e-6, NULL) == PEND_OK);
    CHECK(pend_trust_next(trust, INFINITY, &done, &error) == PEND_TOO_MANY_STEPS && !done);
}

TEST(trust_fails_cleanly_without_memory) {
    OWN(test_tree, clear) t;
    tumble_init(&t);
    struct pend_problem problem = tumble_problem(&t, 1, 3);
    for (long i = 1;; i++) {
        struct pend_trust *trust;
        test_alloc_fail(i, 0);
        enum pend_status status = pend_trust_new(&trust, &pend_method_taylor, &problem, 1e-6, NULL);
        test_alloc_faults_off();
        CHECK(status == PEND_OK ? trust != NULL : status == PEND_NO_MEMORY && !trust);
        pend_trust_free(&trust);
        if (status == PEND_OK) {
            CHECK(i > 4);
            break;
        }
    }
}
