/* Up to when members of an ensemble are accurate; the estimate itself: test_horizon.c. */
#include <math.h>
#include <string.h>

#include "tests/harness/ensembles.h"
#include "tests/harness/motions.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* up to when each member is accurate, and its end */
struct horizon_bag {
    const struct test_tree *t;
    double horizon[24], final[24][4];
};

static int horizon_fetch(void *context, long i, struct pend_member *member) {
    const struct horizon_bag *bag = context;
    for (int k = 0; k < bag->t->n; k++) member->phi[k] = sin(3.7 * (double)i + k) * 3;
    return 0;
}

static int horizon_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct horizon_bag *bag = context;
    bag->horizon[i] = outcome->horizon;
    memcpy(bag->final[i], outcome->phi, sizeof(double) * (size_t)bag->t->n);
    return 0;
}

static void horizon_run(struct horizon_bag *bag, double accuracy, double duration,
                        enum pend_isa isa) {
    OWN(pend_ensemble, free) *ensemble;
    const struct pend_ensemble_problem problem = {.tree = bag->t->tree,
                                                  .loads.gravity = 9.81,
                                                  .duration = duration,
                                                  .rtol = 1e-12,
                                                  .accuracy = accuracy,
                                                  .fetch = horizon_fetch,
                                                  .deliver = horizon_deliver,
                                                  .context = bag};
    if (!CHECK(pend_ensemble_new(&ensemble, &problem, isa, NULL) == PEND_OK)) return;
    CHECK(test_ensemble_run(ensemble, 0, 24) == PEND_OK);
}

/* the same members alone, whose horizons test_horizon compares with the true ones */
TEST(ensemble_horizons_are_near_those_of_single_runs) {
    unsigned long long seed = 5;
    int short_of = 0;
    for (int n = 2; n <= 4; n++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, TEST_TREE_CHAIN, n, 0.2, &seed);
        struct horizon_bag plain = {.t = &t}, told = {.t = &t}, narrow = {.t = &t};
        double duration = n == 3 ? -12 : 12;
        horizon_run(&plain, 0, duration, pend_isa_best());
        horizon_run(&told, 1e-6, duration, pend_isa_best());
        horizon_run(&narrow, 1e-6, duration, PEND_ISA_BASE);
        for (int i = 0; i < 24; i++) {
            OWN(test_record, clear) record;
            struct pend_member start = {.phi = t.phi};
            (void)horizon_fetch(&told, i, &start);
            memset(t.rate, 0, (size_t)n * sizeof(double));
            const struct pend_problem alone = {
                .tree = t.tree,
                .loads.gravity = 9.81,
                .phi = t.phi,
                .rate = t.rate,
                .rtol = 1e-12,
                .accuracy = 1e-6,
                .times = {.count = 1201, .span = duration, .divisor = 1200}};
            test_record(&record, "taylor", &alone);
            double want = fabs(record.stats.horizon), got = fabs(told.horizon[i]);
            // two computations diverge by their own errors
            CHECK_SAYING(got > 0.6 * want && got < 1.5 * want, "%d arms, member %d: %g, alone %g",
                         n, i, got, want);
            CHECK(isnan(plain.horizon[i]) &&
                  !memcmp(plain.final[i], told.final[i], sizeof plain.final[i]));
            CHECK(fabs(narrow.horizon[i]) > 0.6 * want && fabs(narrow.horizon[i]) < 1.5 * want);
            short_of += got < 12;
        }
    }
    CHECK_SAYING(short_of > 20 && short_of < 72, "%d", short_of);
}

static int motion_fetch(void *context, long i, struct pend_member *member) {
    const struct test_motion *motion = context;
    (void)i;
    memcpy(member->phi, motion->phi, sizeof(double) * (size_t)motion->tree->n);
    memcpy(member->rate, motion->rate, sizeof(double) * (size_t)motion->tree->n);
    return 0;
}

static double motion_told;

static int motion_deliver(void *context, long i, const struct pend_outcome *outcome) {
    (void)context, (void)i;
    motion_told = outcome->horizon;
    return 0;
}

/* motions of every kind, whose single runs test_horizon compares with the true horizon */
TEST(ensemble_horizons_of_motions_of_every_kind_are_near_those_of_single_runs) {
    enum { EACH = 6 };
    for (int i = 0; i < EACH * TEST_MOTION_KINDS; i++) {
        enum test_motion_kind kind = (enum test_motion_kind)(i % TEST_MOTION_KINDS);
        OWN(test_motion, clear) motion;
        OWN(test_record, clear) record;
        OWN(pend_ensemble, free) *ensemble;
        test_motion_init(&motion, kind, 2000 + i);
        const struct pend_problem alone = {
            .tree = motion.tree,
            .loads = test_motion_loads(&motion),
            .phi = motion.phi,
            .rate = motion.rate,
            .rtol = 1e-12,
            .accuracy = 1e-6,
            .times = {.count = 401, .span = motion.span, .divisor = 400}};
        const struct pend_ensemble_problem problem = {.tree = motion.tree,
                                                      .loads = alone.loads,
                                                      .duration = motion.span,
                                                      .rtol = 1e-12,
                                                      .accuracy = 1e-6,
                                                      .fetch = motion_fetch,
                                                      .deliver = motion_deliver,
                                                      .context = &motion};
        test_record(&record, "taylor", &alone);
        enum pend_isa isa = i % 2 ? pend_isa_best() : PEND_ISA_BASE;
        if (!CHECK(pend_ensemble_new(&ensemble, &problem, isa, NULL) == PEND_OK)) return;
        CHECK(test_ensemble_run(ensemble, 0, 1) == PEND_OK);
        double want = record.stats.horizon;
        CHECK_SAYING(motion_told > 0.6 * want && motion_told < 1.5 * want,
                     "%s motion %d: %g, alone %g of %g", test_motion_name(kind), i, motion_told,
                     want, motion.span);
    }
}
