/* Tests of core/ensemble: equal to single runs, the same bits in any lane, crossings at their exact time, failures
 * apart. Leaves to others: the series (test_jets), the step rule (test_method_taylor). Invariant: every instruction set
 * that this processor has is tested. */
#include "core/ensemble.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/method.h"
#include "tests/harness/test.h"

extern const struct pend_method pend_method_taylor;

enum { MEMBERS = 40, ARMS_MAX = 6 };

/* members of random starts, and what came back */
struct crowd {
    struct pend_tree *tree;
    double length[ARMS_MAX], mass[ARMS_MAX]; /* spread of the members' own, 0 = the tree's */
    int vary, broken, stop_after;
    int delivered, status[MEMBERS], arm[MEMBERS];
    double phi[MEMBERS][ARMS_MAX], rate[MEMBERS][ARMS_MAX], time[MEMBERS], first[MEMBERS][ARMS_MAX];
    long crossings[MEMBERS][ARMS_MAX];
};

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    unsigned long long seed = (unsigned long long)i + 1;
    for (int k = 0; k < crowd->tree->n; k++) {
        member->phi[k] = 6 * test_random(&seed) - 3 - M_PI / 2;
        member->rate[k] = 2 * test_random(&seed) - 1;
        if (!crowd->vary) continue;
        member->length[k] = 0.5 + test_random(&seed);
        member->mass[k] = 0.5 + test_random(&seed);
        member->gravity = 5 + 10 * test_random(&seed);
    }
    if (crowd->broken == i) member->rate[0] = NAN;
    return 0;
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct crowd *crowd = context;
    int n = crowd->tree->n;
    crowd->delivered++;
    crowd->status[i] = (int)outcome->status;
    crowd->arm[i] = outcome->arm;
    crowd->time[i] = outcome->time;
    for (int k = 0; k < n; k++) {
        crowd->phi[i][k] = outcome->phi[k];
        crowd->rate[i][k] = outcome->rate[k];
        if (!outcome->crossings) continue;
        crowd->first[i][k] = outcome->first_crossing[k];
        crowd->crossings[i][k] = outcome->crossings[k];
    }
    return crowd->stop_after && crowd->delivered >= crowd->stop_after;
}

static int crowd_tree(struct crowd *crowd, int n) {
    static const int parent[ARMS_MAX] = {-1, 0, 0, 1, 3, 1};
    static const double length[ARMS_MAX] = {1, 0.8, 0.7, 0.9, 0.5, 0.6}, mass[ARMS_MAX] = {1, 0.5, 0.7, 1.2, 0.4, 0.9};
    memset(crowd, 0, sizeof *crowd);
    crowd->broken = -1;
    return CHECK(pend_tree_new(&crowd->tree, n, length, mass, parent, NULL) == PEND_OK);
}

static struct pend_ensemble_problem crowd_problem(struct crowd *crowd, double duration) {
    return (struct pend_ensemble_problem){.tree = crowd->tree,
                                          .gravity = 9.81,
                                          .duration = duration,
                                          .rtol = 1e-15,
                                          .fetch = crowd_fetch,
                                          .deliver = crowd_deliver,
                                          .context = crowd};
}

static int crowd_run(const struct pend_ensemble_problem *problem, enum pend_isa isa, long first, long count) {
    struct pend_ensemble *ensemble;
    if (!CHECK(pend_ensemble_new(&ensemble, problem, isa, NULL) == PEND_OK)) return 0;
    long allocations = test_alloc_count();
    int done = CHECK(pend_ensemble_run(ensemble, first, count) == PEND_OK);
    CHECK_INT(test_alloc_count(), allocations);
    pend_ensemble_free(&ensemble);
    return done;
}

/* one member by the single method at rtol 1e-15: the state at the end */
static void crowd_single(struct crowd *crowd, long i, double duration, double phi[], double rate[]) {
    double start[2][ARMS_MAX], length[ARMS_MAX], mass[ARMS_MAX], reached = 0;
    int n = crowd->tree->n, parent[ARMS_MAX];
    struct pend_member member = {start[0], start[1], length, mass, 9.81};
    memcpy(length, crowd->tree->len, (size_t)n * sizeof(double));
    memcpy(mass, crowd->tree->mass, (size_t)n * sizeof(double));
    memcpy(parent, crowd->tree->parent, (size_t)n * sizeof(int));
    crowd_fetch(crowd, i, &member);
    struct pend_tree *tree;
    REQUIRE(pend_tree_new(&tree, n, length, mass, parent, NULL) == PEND_OK);
    double from[2][ARMS_MAX];
    for (int k = 0; k < n; k++) {
        from[0][k] = start[0][tree->order[k]];
        from[1][k] = start[1][tree->order[k]];
    }
    struct pend_problem problem = {
        .tree = tree, .gravity = member.gravity, .phi = from[0], .rate = from[1], .rtol = 1e-15};
    void *stepper;
    REQUIRE(pend_method_taylor.open(&stepper, &problem, NULL) == PEND_OK);
    while (fabs(reached) < fabs(duration) && !pend_method_taylor.step(stepper, duration, &reached, NULL)) {
    }
    double at[2][ARMS_MAX];
    struct pend_points points = {at[0], at[1], NULL, NULL};
    pend_method_taylor.at(stepper, &duration, 1, &points);
    pend_method_taylor.close(&stepper);
    for (int k = 0; k < n; k++) {
        phi[tree->order[k]] = at[0][k];
        rate[tree->order[k]] = at[1][k];
    }
    pend_tree_free(&tree);
}

TEST(ensemble_members_end_where_single_runs_end) {
    double worst = 0;
    for (int n = 1; n <= ARMS_MAX; n++) {
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            struct crowd crowd;
            double phi[ARMS_MAX], rate[ARMS_MAX], duration = n % 2 ? 1 : -1;
            REQUIRE(crowd_tree(&crowd, n));
            crowd.vary = isa % 2 || n == 4;
            struct pend_ensemble_problem problem = crowd_problem(&crowd, duration);
            REQUIRE(crowd_run(&problem, (enum pend_isa)isa, 0, MEMBERS));
            CHECK_INT(crowd.delivered, MEMBERS);
            for (long i = 0; i < MEMBERS; i++) {
                crowd_single(&crowd, i, duration, phi, rate);
                CHECK(crowd.time[i] == duration && crowd.status[i] == PEND_OK && crowd.arm[i] == -1);
                for (int k = 0; k < n; k++) {
                    double error = fmax(fabs(phi[k] - crowd.phi[i][k]), fabs(rate[k] - crowd.rate[i][k]) / 10);
                    if (!(error <= worst)) worst = error;
                }
            }
            pend_tree_free(&crowd.tree);
        }
    }
    CHECK_RESIDUAL(worst, 1e-11, "phi and phi' / 10 of a member against a single run");
}

TEST(ensemble_members_have_the_same_bits_in_any_lane_and_any_company) {
    for (int n = 2; n <= ARMS_MAX; n += 3) {
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            struct crowd whole, parts;
            REQUIRE(crowd_tree(&whole, n) && crowd_tree(&parts, n));
            struct pend_ensemble_problem a = crowd_problem(&whole, 2), b = crowd_problem(&parts, 2);
            a.bound = b.bound = M_PI;
            REQUIRE(crowd_run(&a, (enum pend_isa)isa, 0, MEMBERS));
            // in pieces that put every member into another lane
            REQUIRE(crowd_run(&b, (enum pend_isa)isa, 29, 11) && crowd_run(&b, (enum pend_isa)isa, 3, 26));
            REQUIRE(crowd_run(&b, (enum pend_isa)isa, 0, 3));
            CHECK(!memcmp(whole.phi, parts.phi, sizeof whole.phi));
            CHECK(!memcmp(whole.rate, parts.rate, sizeof whole.rate));
            CHECK(!memcmp(whole.crossings, parts.crossings, sizeof whole.crossings));
            CHECK(whole.rate[0][0] != whole.rate[1][0]);
            pend_tree_free(&whole.tree);
            pend_tree_free(&parts.tree);
        }
    }
}

TEST(ensemble_gives_the_same_bits_with_avx2_and_avx512) {
    struct crowd narrow, broad;
    if (pend_isa_best() < PEND_ISA_AVX512) {
        test_skip("this processor has no AVX-512");
        return;
    }
    for (int n = 2; n <= ARMS_MAX; n += 2) {
        REQUIRE(crowd_tree(&narrow, n) && crowd_tree(&broad, n));
        struct pend_ensemble_problem a = crowd_problem(&narrow, 2), b = crowd_problem(&broad, 2);
        REQUIRE(crowd_run(&a, PEND_ISA_AVX2, 0, MEMBERS) && crowd_run(&b, PEND_ISA_AVX512, 0, MEMBERS));
        CHECK(!memcmp(narrow.phi, broad.phi, sizeof narrow.phi) &&
              !memcmp(narrow.rate, broad.rate, sizeof narrow.rate));
        pend_tree_free(&narrow.tree);
        pend_tree_free(&broad.tree);
    }
}

/* a single arm with energy to turn over: theta' from theta, and the time between by the period's integral */
static int spin_fetch(void *context, long i, struct pend_member *member) {
    const double *rate = context;
    member->phi[0] = -M_PI / 2;
    member->rate[0] = i ? -*rate : *rate;
    return 0;
}

struct spin_result {
    double rate, first[2], time[2];
    long crossings[2];
};

static int spin_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct spin_result *result = context;
    result->first[i] = outcome->first_crossing[0];
    result->crossings[i] = outcome->crossings[0];
    result->time[i] = outcome->time;
    return 0;
}

/* time from hanging to upright: the integral of d theta / theta' by the midpoint rule, exact for a smooth period */
static double spin_time(double rate) {
    double sum = 0;
    enum { POINTS = 4000 };
    for (int i = 0; i < POINTS; i++) {
        double theta = M_PI * (i + 0.5) / POINTS;
        sum += 1 / sqrt(rate * rate - 2 * 9.81 * (1 - cos(theta)));
    }
    return sum * M_PI / POINTS;
}

TEST(ensemble_times_the_flips_of_a_spinning_arm) {
    struct spin_result result = {.rate = 7};
    double one = 1, want = spin_time(result.rate);
    int pivot = -1;
    struct pend_tree *tree;
    REQUIRE(pend_tree_new(&tree, 1, &one, &one, &pivot, NULL) == PEND_OK);
    struct pend_ensemble_problem problem = {.tree = tree, .gravity = 9.81, .duration = 6.5 * want, .rtol = 1e-15};
    problem.bound = M_PI;
    problem.fetch = spin_fetch;
    problem.deliver = spin_deliver;
    problem.context = &result;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
    // upright at 1, 3 and 5 times the time to get there
    CHECK_INT(result.crossings[0], 3);
    CHECK_INT(result.crossings[1], 3);
    CHECK_RESIDUAL(fabs(result.first[0] / want - 1), 1e-13, "time of the first flip");
    CHECK(fabs(result.first[0] - result.first[1]) < 1e-14);
    problem.until = PEND_UNTIL_FIRST;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
    CHECK(result.time[0] == result.first[0] && result.crossings[0] == 1);
    pend_tree_free(&tree);
}

TEST(ensemble_sees_an_arm_that_only_touches_its_bound) {
    struct spin_result result = {.rate = 3};
    double one = 1, top = acos(1 - 9 / (2 * 9.81));
    int pivot = -1;
    struct pend_tree *tree;
    REQUIRE(pend_tree_new(&tree, 1, &one, &one, &pivot, NULL) == PEND_OK);
    for (int i = 0; i < 2; i++) {
        // the turning point is inside a step; a hair below it is touched, a hair above is not
        struct pend_ensemble_problem problem = {.tree = tree, .gravity = 9.81, .duration = 1, .rtol = 1e-15};
        problem.bound = top + (i ? 1e-9 : -1e-9);
        problem.fetch = spin_fetch;
        problem.deliver = spin_deliver;
        problem.context = &result;
        REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
        CHECK_INT(result.crossings[0], i ? 0 : 2);
        CHECK_INT(result.crossings[1], i ? 0 : 2);
        CHECK(isnan(result.first[0]) == i);
    }
    pend_tree_free(&tree);
}

TEST(ensemble_delivers_a_broken_member_as_failed_and_the_others_whole) {
    struct crowd sound, ill;
    REQUIRE(crowd_tree(&sound, 3) && crowd_tree(&ill, 3));
    ill.broken = 7;
    struct pend_ensemble_problem a = crowd_problem(&sound, 1), b = crowd_problem(&ill, 1);
    REQUIRE(crowd_run(&a, pend_isa_best(), 0, MEMBERS) && crowd_run(&b, pend_isa_best(), 0, MEMBERS));
    CHECK_INT(ill.delivered, MEMBERS);
    CHECK_INT(ill.status[7], PEND_NOT_FINITE);
    for (int i = 0; i < MEMBERS; i++) {
        if (i != 7) CHECK(ill.status[i] == PEND_OK && !memcmp(sound.phi[i], ill.phi[i], sizeof sound.phi[i]));
    }
    pend_tree_free(&sound.tree);
    pend_tree_free(&ill.tree);
}

TEST(ensemble_obeys_its_step_limit_and_its_callbacks) {
    struct crowd crowd;
    struct pend_ensemble *ensemble;
    REQUIRE(crowd_tree(&crowd, 2));
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 10);
    problem.step_cap = 5;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
    CHECK(crowd.status[0] == PEND_TOO_MANY_STEPS && crowd.time[0] > 0 && crowd.time[0] < 10);
    crowd.delivered = 0;
    crowd.stop_after = 9;
    REQUIRE(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK);
    CHECK(pend_ensemble_run(ensemble, 0, MEMBERS) == PEND_CANCELLED);
    CHECK(crowd.delivered >= 9 && crowd.delivered < 9 + 8);
    pend_ensemble_free(&ensemble);
    pend_tree_free(&crowd.tree);
}

TEST(ensemble_refuses_what_it_cannot_do) {
    struct crowd crowd;
    struct pend_ensemble *ensemble;
    struct pend_error error;
    REQUIRE(crowd_tree(&crowd, 2));
    for (int i = 0; i < 5; i++) {
        struct pend_ensemble_problem problem = crowd_problem(&crowd, 1);
        if (i == 0) problem.rtol = 0;
        if (i == 1) problem.atol = -1;
        if (i == 2) problem.bound = NAN;
        if (i == 3) problem.duration = INFINITY;
        if (i == 4) test_alloc_fail(1, 0);
        enum pend_status status = pend_ensemble_new(&ensemble, &problem, pend_isa_best(), &error);
        test_alloc_faults_off();
        CHECK(status == (i == 4 ? PEND_NO_MEMORY : PEND_INVALID) && !ensemble && error.text[0]);
    }
    pend_tree_free(&crowd.tree);
}
