/* Tests of conditions on members of an ensemble: passages against samples in 32 digits, grazing and
 * simultaneous ones, ends, and bits that do not depend on the other members.
 * Leaves to others: the search in one motion (test_events), the starts of members (api).
 * Invariant: every instruction set that this processor has is tested; pendulums are random, from
 * seeds; EVENTS_RUNS in the environment sets a larger number of them. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/tree/turns.h"
#include "tests/harness/bodies.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/passages.h"
#include "tests/harness/test.h"

enum { MEMBERS = 5, ARMS = TEST_PASSAGES_ARMS, BOTH = PEND_WAY_UP | PEND_WAY_DOWN };

/* members of one pendulum with their own starts, and the passages found for each */
struct crowd {
    const struct test_tree *t;
    double phi[MEMBERS][ARMS], rate[MEMBERS][ARMS];
    struct test_passages *found; /* MEMBERS of them */
    struct pend_outcome outcome[MEMBERS];
    double flip[MEMBERS];
    int delivered;
};

static struct test_passages passages[MEMBERS], others[MEMBERS];

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    size_t bytes = (size_t)crowd->t->n * sizeof(double);
    memcpy(member->phi, crowd->phi[i], bytes);
    memcpy(member->rate, crowd->rate[i], bytes);
    crowd->found[i].count = 0;
    return 0;
}

static void crowd_hit(void *context, long i, const struct pend_hit *hit, const double phi[],
                      const double rate[]) {
    const struct crowd *crowd = context;
    struct test_passages *found = &crowd->found[i];
    if (!CHECK(found->count < TEST_PASSAGES_MOST)) return;
    int at = found->count++;
    found->hit[at] = *hit;
    memcpy(found->phi[at], phi, (size_t)crowd->t->n * sizeof(double));
    memcpy(found->rate[at], rate, (size_t)crowd->t->n * sizeof(double));
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct crowd *crowd = context;
    crowd->outcome[i] = *outcome;
    crowd->flip[i] = outcome->first_crossing ? outcome->first_crossing[0] : 0;
    crowd->delivered++;
    return 0;
}

/* the members' starts: that of the tree, and others near it */
static void crowd_init(struct crowd *crowd, const struct test_tree *t, struct test_passages *found,
                       unsigned long long *seed) {
    *crowd = (struct crowd){.t = t, .found = found};
    for (int i = 0; i < MEMBERS; i++)
        for (int k = 0; k < t->n; k++) {
            crowd->phi[i][k] = t->phi[k] + (i ? test_random(seed) - 0.5 : 0);
            crowd->rate[i][k] = t->rate[k] + (i ? test_random(seed) - 0.5 : 0);
        }
}

static struct pend_ensemble_problem crowd_problem(struct crowd *crowd,
                                                  const struct pend_loads *loads, int count,
                                                  const struct pend_event event[]) {
    return (struct pend_ensemble_problem){.tree = crowd->t->tree,
                                          .loads = *loads,
                                          .duration = test_passages_duration,
                                          .rtol = 1e-15,
                                          .events = count,
                                          .event = event,
                                          .fetch = crowd_fetch,
                                          .deliver = crowd_deliver,
                                          .hit = crowd_hit,
                                          .context = crowd};
}

static void crowd_run(const struct pend_ensemble_problem *problem, int isa, long first,
                      long count) {
    OWN(pend_ensemble, free) *ensemble;
    struct pend_error error = {0};
    struct crowd *crowd = problem->context;
    enum pend_status status = pend_ensemble_new(&ensemble, problem, (enum pend_isa)isa, &error);
    if (!CHECK_SAYING(status == PEND_OK, "%s", error.text)) return;
    long allocations = test_alloc_count();
    crowd->delivered = 0;
    CHECK(test_ensemble_run(ensemble, first, count) == PEND_OK);
    CHECK_INT(crowd->delivered, count);
    CHECK_INT(test_alloc_count(), allocations);
}

TEST(events_of_members_are_where_32_digits_have_them) {
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 5;
    unsigned long long seed = 11;
    double worst = 0;
    long hits = 0;
    for (int i = 0; i < runs; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        struct test_record grid;
        struct crowd crowd;
        struct pend_event event[TEST_PASSAGES_CONDITIONS];
        test_passages_random(&t, &b, &grid, event, i, &seed);
        test_record_clear(&grid);
        crowd_init(&crowd, &t, passages, &seed);
        struct pend_ensemble_problem problem =
            crowd_problem(&crowd, &b.loads, TEST_PASSAGES_CONDITIONS, event);
        crowd_run(&problem, i % ((int)pend_isa_best() + 1), 0, MEMBERS);
        for (int j = 0; j < MEMBERS; j++) {
            struct test_tree own = t;
            own.phi = crowd.phi[j], own.rate = crowd.rate[j];
            test_passages_grid(&grid, &own, &b.loads);
            worst = fmax(worst, test_passages_check(&passages[j], &own, &b.loads, &grid, event));
            hits += passages[j].count;
            test_record_clear(&grid);
        }
        if (i % 2) test_bodies_clear(&b);
    }
    CHECK(hits > runs * MEMBERS);
    // the largest error of 5e4 motions is 1.1e-13
    CHECK_RESIDUAL(worst, asked ? 3e-13 : 1e-13, "quantities at members' events, in 32 digits");
}

TEST(events_of_members_that_graze_in_any_quantity_come_in_pairs_or_not_at_all) {
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 8, grazing = 0;
    unsigned long long seed = 17;
    for (int i = 0; i < runs; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        struct test_record grid;
        struct crowd crowd;
        struct pend_event event[TEST_PASSAGES_CONDITIONS];
        double time[TEST_PASSAGES_EXTREMES];
        test_passages_random(&t, &b, &grid, event, i, &seed);
        int extremes = test_passages_grazing(event, time, &t, &b.loads, &grid, i % 2 == 0, &seed);
        if (extremes) {
            // the first member's motion is the one with known extremes
            crowd_init(&crowd, &t, passages, &seed);
            struct pend_ensemble_problem problem =
                crowd_problem(&crowd, &b.loads, TEST_PASSAGES_CONDITIONS, event);
            crowd_run(&problem, i % ((int)pend_isa_best() + 1), 0, MEMBERS);
            test_passages_grazed(&passages[0], time);
            grazing += extremes;
        }
        test_record_clear(&grid);
        if (i % 2) test_bodies_clear(&b);
    }
    CHECK_SAYING(grazing > 2 * runs, "%d extremes of %d pendulums", grazing, runs);
}

/* a rate of 0 is an extreme of the angle: a level 1e-10 beyond it is not reached, one 1e-10 before
 * it is passed twice */
TEST(events_of_members_that_graze_are_found_in_pairs_or_not_at_all) {
    enum { TURNS = 20 };
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 12, pairs = 0;
    unsigned long long seed = 12;
    for (int i = 0; i < runs; i++) {
        OWN(test_tree, clear) t;
        struct crowd crowd, again;
        struct pend_event level[2 * TURNS];
        int isa = i % ((int)pend_isa_best() + 1), turns;
        test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
        crowd_init(&crowd, &t, passages, &seed);
        struct pend_event rest = {
            .quantity = PEND_QUANTITY_RATE, .arm = 1, .ways = BOTH, .most = TURNS};
        struct pend_ensemble_problem problem = crowd_problem(&crowd, TEST_LOADS(9.81), 1, &rest);
        crowd_run(&problem, isa, 0, MEMBERS);
        turns = passages[0].count;
        for (int j = 0; j < 2 * turns; j++) {
            // the side of the level from which the angle comes, and the opposite side
            double inside = passages[0].hit[j / 2].way == PEND_WAY_DOWN ? -1e-10 : 1e-10;
            level[j] = rest;
            level[j].quantity = PEND_QUANTITY_PHI;
            level[j].level = passages[0].phi[j / 2][1] + (j % 2 ? -inside : inside);
        }
        again = crowd, again.found = others;
        problem = crowd_problem(&again, TEST_LOADS(9.81), 2 * turns, level);
        if (turns) crowd_run(&problem, isa, 0, MEMBERS);
        for (int j = 0; j < 2 * turns; j++) {
            int passed = 0;
            for (int k = 0; k < others[0].count; k++)
                passed += others[0].hit[k].event == j &&
                          fabs(others[0].hit[k].time - passages[0].hit[j / 2].time) < 1e-4;
            CHECK_SAYING(passed == (j % 2 ? 0 : 2), "%d passages %s an extreme", passed,
                         j % 2 ? "beyond" : "before");
            pairs += passed == 2;
        }
    }
    CHECK(pairs > runs / 2);
}

TEST(events_of_members_do_not_depend_on_the_company_and_simultaneous_ones_are_all_told) {
    unsigned long long seed = 13;
    OWN(test_tree, clear) t;
    struct crowd crowd, alone;
    struct pend_event event[3];
    int hits = 0;
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    crowd_init(&crowd, &t, passages, &seed);
    alone = crowd, alone.found = others;
    for (int i = 0; i < 3; i++)
        event[i] = (struct pend_event){
            .quantity = PEND_QUANTITY_PHI, .arm = 2, .level = t.phi[2] + 0.1, .ways = BOTH};
    event[0].most = event[1].most = 50, event[2].most = 1;
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        struct pend_ensemble_problem all = crowd_problem(&crowd, TEST_LOADS(9.81), 3, event),
                                     one = crowd_problem(&alone, TEST_LOADS(9.81), 3, event);
        all.duration = one.duration = 20;
        crowd_run(&all, isa, 0, MEMBERS);
        for (int i = MEMBERS - 1; i >= 0; i--) crowd_run(&one, isa, i, 1);
        for (int i = 0; i < MEMBERS; i++) {
            const struct test_passages *a = &passages[i], *b = &others[i];
            CHECK(a->count == b->count && (!a->count || a->count % 2 == 1));
            hits += a->count;
            for (int j = 0; j < a->count; j++) {
                int round = j < 3 ? 0 : 1 + (j - 3) / 2;
                CHECK(a->hit[j].time == b->hit[j].time && a->hit[j].way == b->hit[j].way);
                CHECK_INT(a->hit[j].event, round ? (j - 3) % 2 : j);
                CHECK(!memcmp(a->phi[j], b->phi[j], sizeof a->phi[j][0] * 3) &&
                      !memcmp(a->rate[j], b->rate[j], sizeof a->rate[j][0] * 3));
            }
        }
    }
    CHECK(hits > 6 * MEMBERS);
}

TEST(events_end_members_and_what_comes_later_is_not_noted) {
    unsigned long long seed = 14;
    OWN(test_tree, clear) t;
    struct crowd crowd, whole;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.1, &seed);
    crowd_init(&crowd, &t, passages, &seed);
    struct pend_event event = {
        .quantity = PEND_QUANTITY_RATE, .arm = 1, .ways = BOTH, .most = 1000, .stop = 3};
    struct pend_ensemble_problem problem = crowd_problem(&crowd, TEST_LOADS(9.81), 1, &event);
    problem.duration = 30, problem.bound = M_PI;
    crowd_run(&problem, (int)pend_isa_best(), 0, MEMBERS);
    struct pend_event last = event;
    last.stop = 0, last.most = 3;
    whole = crowd, whole.found = others;
    struct pend_ensemble_problem more = problem, told = problem;
    more.event = told.event = &last, told.until = PEND_UNTIL_TOLD;
    more.context = &whole;
    crowd_run(&more, (int)pend_isa_best(), 0, MEMBERS);
    for (int i = 0; i < MEMBERS; i++) {
        const struct pend_outcome *a = &crowd.outcome[i], *b = &whole.outcome[i];
        CHECK(a->stop == PEND_STOP_EVENT && passages[i].count == 3);
        CHECK(fabs(a->time - passages[i].hit[2].time) < 1e-14 && a->steps < b->steps);
        CHECK(b->stop == PEND_STOP_TIME && b->time == 30 && others[i].count == 3);
        CHECK(!memcmp(&passages[i].hit, &others[i].hit, 3 * sizeof passages[i].hit[0]));
        // an arm that turns over after the end is not counted
        if (whole.flip[i] > a->time) CHECK(isnan(crowd.flip[i]));
        if (whole.flip[i] < a->time) CHECK(crowd.flip[i] == whole.flip[i]);
    }
    long steps = whole.outcome[0].steps;
    told.context = &whole;
    crowd_run(&told, (int)pend_isa_best(), 0, MEMBERS);
    CHECK(whole.outcome[0].stop == PEND_STOP_EVENT && whole.outcome[0].steps < steps / 2);
}

/* a motion that began some hundreds of turns further on passes levels shifted by as much */
TEST(events_of_members_know_whole_turns) {
    const double turns = 400 * M_PI;
    unsigned long long seed = 15;
    OWN(test_tree, clear) t;
    struct crowd crowd, far;
    struct pend_event near[2], moved[2];
    double worst = 0x1p-60;
    int hits = 0;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.1, &seed);
    crowd_init(&crowd, &t, passages, &seed);
    far = crowd, far.found = others;
    for (int i = 0; i < MEMBERS; i++) far.phi[i][1] += turns;
    for (int i = 0; i < 2; i++) {
        near[i] = (struct pend_event){.quantity = (enum pend_quantity)i,
                                      .arm = 1,
                                      .level = t.phi[1] + 0.2,
                                      .ways = BOTH,
                                      .most = 10};
        moved[i] = near[i];
        moved[i].level += turns;
    }
    CHECK(fabs(far.phi[0][1]) > PEND_TURNS_FROM);
    struct pend_ensemble_problem problem = crowd_problem(&crowd, TEST_LOADS(9.81), 2, near);
    problem.duration = 3;
    crowd_run(&problem, (int)pend_isa_best(), 0, MEMBERS);
    problem.event = moved, problem.context = &far;
    crowd_run(&problem, (int)pend_isa_best(), 0, MEMBERS);
    for (int i = 0; i < MEMBERS; i++) {
        CHECK(passages[i].count == others[i].count);
        hits += passages[i].count;
        for (int j = 0; j < passages[i].count; j++) {
            worst = fmax(worst, fabs(passages[i].hit[j].time - others[i].hit[j].time));
            CHECK(fabs(others[i].phi[j][1] - passages[i].phi[j][1] - turns) < 1e-11);
        }
    }
    CHECK(hits > MEMBERS);
    CHECK_RESIDUAL(worst, 1e-10, "instants of passages whole turns further on, s");
}

TEST(events_of_members_that_make_no_sense_are_refused) {
    unsigned long long seed = 16;
    OWN(test_tree, clear) t;
    struct crowd crowd;
    struct pend_ensemble *ensemble;
    struct pend_error error;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.1, &seed);
    crowd_init(&crowd, &t, passages, &seed);
    struct pend_event event = {.quantity = PEND_QUANTITY_ENERGY, .ways = BOTH, .most = 1};
    struct pend_ensemble_problem good = crowd_problem(&crowd, TEST_LOADS(9.81), 1, &event), bad;
    bad = good, bad.until = PEND_UNTIL_FIRST, bad.bound = 1;
    CHECK(pend_ensemble_new(&ensemble, &bad, PEND_ISA_BASE, &error) == PEND_INVALID && !ensemble);
    bad = good, bad.events = 0, bad.until = PEND_UNTIL_TOLD;
    CHECK(pend_ensemble_new(&ensemble, &bad, PEND_ISA_BASE, &error) == PEND_INVALID);
    event.arm = 2;
    CHECK(pend_ensemble_new(&ensemble, &good, PEND_ISA_BASE, &error) == PEND_INVALID);
    event.arm = 0;
    test_alloc_fail(1, 0);
    CHECK(pend_ensemble_new(&ensemble, &good, PEND_ISA_BASE, &error) == PEND_NO_MEMORY);
    test_alloc_faults_off();
}
