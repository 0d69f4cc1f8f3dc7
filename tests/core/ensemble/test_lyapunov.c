#include "core/ensemble/lyapunov.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/ensembles.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 6 };

static void tree_of(struct test_tree *t, int n, unsigned long long seed) {
    int parent[ARMS] = {-1};
    for (int k = 1; k < n; k++) parent[k] = test_random_int(&seed, k);
    test_tree_init(t, n, parent, 0.3, &seed);
    for (int k = 0; k < n; k++) {
        t->phi[k] = 4 * test_random(&seed) - 2;
        t->rate[k] = 2 * test_random(&seed) - 1;
    }
}

/* a double pendulum that tumbles */
static void tumble(struct test_tree *t) {
    unsigned long long seed = 1;
    const int parent[] = {-1, 0};
    test_tree_init(t, 2, parent, 0.3, &seed);
    for (int k = 0; k < 2; k++) t->length[k] = t->mass[k] = 1;
    test_tree_rebuild(t);
    t->phi[0] = 2 - M_PI_2, t->phi[1] = 2.5 - M_PI_2;
    t->rate[0] = t->rate[1] = 0;
}

/* `intervals` intervals, interrupted after `steps` steps; returns the exponents, and the state of
 * the motion */
static int run(const struct test_tree *t, int count, double interval, long intervals, long steps,
               double exponent[], double phi[], double rate[]) {
    struct pend_lyapunov *lyapunov;
    const struct pend_lyapunov_problem problem = {.tree = t->tree,
                                                  .loads.gravity = 9.81,
                                                  .phi = t->phi,
                                                  .rate = t->rate,
                                                  .count = count,
                                                  .interval = interval};
    if (!CHECK(pend_lyapunov_new(&lyapunov, &problem, NULL) == PEND_OK)) return 0;
    int good = 1;
    for (long i = 0; i < intervals && good;) {
        int done;
        good = CHECK(pend_lyapunov_go(lyapunov, steps, &done, NULL) == PEND_OK);
        i += done;
    }
    pend_lyapunov_exponents(lyapunov, exponent);
    pend_lyapunov_state(lyapunov, phi, rate);
    CHECK(pend_lyapunov_steps(lyapunov) > intervals);
    pend_lyapunov_free(&lyapunov);
    CHECK(!lyapunov);
    return good;
}

/* log det of Re M(phi), by elimination */
static double log_inertia(const struct pend_tree *tree, const double phi[]) {
    double re[ARMS * ARMS], im[ARMS * ARMS], sum = 0;
    int n = tree->n;
    test_quad_inertia(tree, phi, re, im);
    for (int k = 0; k < n; k++) {
        sum += log(re[k * n + k]);
        for (int i = k + 1; i < n; i++)
            for (int j = n - 1; j >= k; j--)
                re[i * n + j] -= re[i * n + k] / re[k * n + k] * re[k * n + j];
    }
    return sum;
}

/* Liouville: the volume in angles and momenta Re M phi' is constant, so that in angles and rates is
 * proportional to 1 / det Re M */
TEST(lyapunov_exponents_add_up_to_what_liouville_says) {
    double worst = 0, largest = 0;
    for (int n = 1; n <= ARMS; n++)
        for (unsigned long long seed = 1; seed <= 4; seed++) {
            OWN(test_tree, clear) t;
            double exponent[2 * ARMS], phi[ARMS], rate[ARMS], sum = 0;
            tree_of(&t, n, seed);
            if (run(&t, 2 * n, 0.05, 40, 1000, exponent, phi, rate)) {
                for (int i = 0; i < 2 * n; i++) sum += 2 * exponent[i];
                double wanted = log_inertia(t.tree, t.phi) - log_inertia(t.tree, phi);
                worst = fmax(worst, fabs(sum - wanted));
                largest = fmax(largest, fabs(wanted));
            }
        }
    CHECK(largest > 0.5);
    CHECK_RESIDUAL(worst, 1e-7, "exponents");
}

/* the result after a time does not depend on how often the directions were made orthonormal */
TEST(lyapunov_exponents_do_not_depend_on_the_interval) {
    static const double interval[] = {0.05, 0.02, 0.1, 0.5, 4};
    OWN(test_tree, clear) t;
    double exponent[5][4], phi[2], rate[2], worst = 0;
    tumble(&t);
    for (int i = 0; i < 5; i++)
        run(&t, 4, interval[i], lrint(4 / interval[i]), 1000, exponent[i], phi, rate);
    for (int i = 1; i < 5; i++)
        for (int k = 0; k < 4; k++) worst = fmax(worst, fabs(exponent[i][k] - exponent[0][k]));
    CHECK(exponent[0][0] > 0.5);
    CHECK_RESIDUAL(worst, 1e-7, "exponents");
}

TEST(lyapunov_exponents_of_chaos_come_in_pairs_and_two_vanish) {
    OWN(test_tree, clear) t;
    double exponent[4], phi[2], rate[2];
    tumble(&t);
    run(&t, 4, 0.1, 4000, 1000, exponent, phi, rate);
    CHECK_SAYING(exponent[0] > 1 && exponent[0] < 3, "the largest is %g", exponent[0]);
    CHECK_SAYING(fabs(exponent[0] + exponent[3]) < 0.03, "%g and %g", exponent[0], exponent[3]);
    CHECK_SAYING(fabs(exponent[1]) < 0.05 && fabs(exponent[2]) < 0.05, "%g and %g", exponent[1],
                 exponent[2]);
}

/* for the ensembles' own estimate */
struct estimate {
    const struct test_tree *t;
    double value;
};

static int fetch(void *context, long i, struct pend_member *member) {
    const struct estimate *estimate = context;
    (void)i;
    memcpy(member->phi, estimate->t->phi, 2 * sizeof(double));
    memcpy(member->rate, estimate->t->rate, 2 * sizeof(double));
    return 0;
}

static int deliver(void *context, long i, const struct pend_outcome *outcome) {
    (void)i;
    ((struct estimate *)context)->value = outcome->lyapunov;
    return 0;
}

TEST(lyapunov_exponent_is_about_the_one_of_an_ensembles_member) {
    OWN(test_tree, clear) t;
    double exponent[1], phi[2], rate[2];
    tumble(&t);
    struct estimate estimate = {.t = &t};
    const struct pend_ensemble_problem problem = {.tree = t.tree,
                                                  .loads.gravity = 9.81,
                                                  .duration = 400,
                                                  .rtol = 1e-12,
                                                  .observe = PEND_OBSERVE_LYAPUNOV,
                                                  .fetch = fetch,
                                                  .deliver = deliver,
                                                  .context = &estimate};
    struct pend_ensemble *ensemble;
    REQUIRE(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK);
    CHECK(test_ensemble_run(ensemble, 0, 1) == PEND_OK);
    pend_ensemble_free(&ensemble);
    run(&t, 1, 0.1, 4000, 1000, exponent, phi, rate);
    CHECK_SAYING(fabs(exponent[0] - estimate.value) < 0.15 * estimate.value, "%g and %g",
                 exponent[0], estimate.value);
}

TEST(lyapunov_exponents_of_one_arm_vanish) {
    OWN(test_tree, clear) t;
    double exponent[2], phi[1], rate[1];
    tree_of(&t, 1, 3);
    run(&t, 2, 0.25, 4000, 1000, exponent, phi, rate);
    /* neighbours diverge linearly in time: log(1000) / 1000 */
    CHECK_SAYING(fabs(exponent[0]) < 0.02 && fabs(exponent[1]) < 0.02, "%g and %g", exponent[0],
                 exponent[1]);
    CHECK(exponent[0] > 0.001 && exponent[1] < -0.001);
}

TEST(lyapunov_exponents_are_the_same_bits_however_they_are_cut) {
    OWN(test_tree, clear) t;
    double one[8], two[8], phi[2][4], rate[2][4];
    tree_of(&t, 4, 5);
    run(&t, 8, 0.1, 20, 1, one, phi[0], rate[0]);
    run(&t, 8, 0.1, 20, 100000, two, phi[1], rate[1]);
    CHECK(!memcmp(one, two, sizeof one) && !memcmp(phi[0], phi[1], sizeof phi[0]) &&
          !memcmp(rate[0], rate[1], sizeof rate[0]));
    CHECK(one[0] != 0);
}

TEST(lyapunov_forgets_a_transient) {
    OWN(test_tree, clear) t;
    struct pend_lyapunov *lyapunov;
    double whole[1], first[1], rest[1];
    tumble(&t);
    const struct pend_lyapunov_problem problem = {.tree = t.tree,
                                                  .loads.gravity = 9.81,
                                                  .phi = t.phi,
                                                  .rate = t.rate,
                                                  .count = 1,
                                                  .interval = 0.1};
    REQUIRE(pend_lyapunov_new(&lyapunov, &problem, NULL) == PEND_OK);
    for (int i = 0, done; i < 20; i += done)
        REQUIRE(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK);
    pend_lyapunov_exponents(lyapunov, first);
    pend_lyapunov_forget(lyapunov);
    pend_lyapunov_exponents(lyapunov, rest);
    CHECK(rest[0] == 0);
    for (int i = 0, done; i < 60; i += done)
        REQUIRE(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK);
    pend_lyapunov_exponents(lyapunov, rest);
    pend_lyapunov_free(&lyapunov);
    double phi[2], rate[2];
    run(&t, 1, 0.1, 80, 1000, whole, phi, rate);
    CHECK(fabs(8 * whole[0] - 2 * first[0] - 6 * rest[0]) < 1e-12);
    CHECK(fabs(first[0] - rest[0]) > 0.01);
}

TEST(lyapunov_problems_that_make_no_sense_are_refused) {
    OWN(test_tree, clear) t;
    OWN(pend_lyapunov, free) *lyapunov;
    struct pend_error error;
    tumble(&t);
    struct pend_lyapunov_problem problem = {.tree = t.tree,
                                            .loads.gravity = 9.81,
                                            .phi = t.phi,
                                            .rate = t.rate,
                                            .count = 5,
                                            .interval = 0.1};
    CHECK(pend_lyapunov_new(&lyapunov, &problem, &error) == PEND_INVALID && !lyapunov);
    problem.count = 1, problem.interval = 0;
    CHECK(pend_lyapunov_new(&lyapunov, &problem, &error) == PEND_INVALID && !lyapunov);
    problem.interval = 1, problem.rtol = 2;
    CHECK(pend_lyapunov_new(&lyapunov, &problem, &error) == PEND_INVALID && !lyapunov);
    problem.rtol = 0, problem.loads.gravity = INFINITY;
    CHECK(pend_lyapunov_new(&lyapunov, &problem, &error) == PEND_INVALID && !lyapunov);
    problem.loads.gravity = 9.81;
    /* a motion that cannot be computed fails, and keeps failing */
    t.rate[0] = 1e300;
    problem.rtol = 0;
    REQUIRE(pend_lyapunov_new(&lyapunov, &problem, &error) == PEND_OK);
    int done;
    for (int i = 0; i < 2; i++) {
        enum pend_status status = PEND_OK;
        for (int tries = 0; status == PEND_OK && tries < 100000; tries++)
            status = pend_lyapunov_go(lyapunov, 1000, &done, &error);
        CHECK(status != PEND_OK && strlen(error.text) > 5);
    }
}

/* the largest exponent over 400 s compared with that over 3000 s: most are within the error, nearly
 * all within twice of it; for small swings, which tend to 0, within twice of it from 0 */
TEST(lyapunov_errors_are_of_the_size_of_the_scatter) {
    enum { STARTS = 6 };
    int within = 0, twice = 0;
    for (int i = 0; i < STARTS; i++) {
        static const int parent[] = {-1, 0};
        static const double aside[STARTS][2] = {{2, 2.5},  {3, 3},     {2.2, 1},
                                                {2.5, -2}, {0.3, 0.3}, {0.5, 0.2}};
        unsigned long long seed = 1;
        OWN(test_tree, clear) t;
        OWN(pend_lyapunov, free) *lyapunov;
        double exponent = 0, error = 0, last = 0, last_error = 0;
        test_tree_init(&t, 2, parent, 0.3, &seed);
        for (int k = 0; k < 2; k++) t.length[k] = t.mass[k] = 1;
        test_tree_rebuild(&t);
        for (int k = 0; k < 2; k++) t.phi[k] = aside[i][k] - M_PI_2, t.rate[k] = 0;
        const struct pend_lyapunov_problem problem = {.tree = t.tree,
                                                      .loads.gravity = 9.81,
                                                      .phi = t.phi,
                                                      .rate = t.rate,
                                                      .count = 1,
                                                      .interval = 0.25,
                                                      .rtol = 1e-10};
        int tame = i >= 4, long_run = tame ? 1600 : 8000;
        REQUIRE(pend_lyapunov_new(&lyapunov, &problem, NULL) == PEND_OK);
        pend_lyapunov_errors(lyapunov, &error);
        CHECK(error == 0);
        for (int step = 1; step <= long_run; step++) {
            int done = 0;
            while (!done) REQUIRE(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK);
            if (step != 1600) continue;
            pend_lyapunov_exponents(lyapunov, &exponent);
            pend_lyapunov_errors(lyapunov, &error);
        }
        pend_lyapunov_exponents(lyapunov, &last);
        pend_lyapunov_errors(lyapunov, &last_error);
        double off = tame ? exponent : exponent - last;
        CHECK_SAYING(fabs(off) <= 3 * error && error < (tame ? 0.05 : 0.25),
                     "%g +- %g, then %g +- %g", exponent, error, last, last_error);
        CHECK(tame || last_error < error);
        within += fabs(off) <= error;
        twice += fabs(off) <= 2 * error;
    }
    CHECK_SAYING(within >= STARTS / 2 && twice >= STARTS - 1, "%d and %d", within, twice);
}
