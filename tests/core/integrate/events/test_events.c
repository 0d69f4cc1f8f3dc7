/* Tests of events: passages against samples in 32 digits, grazing and simultaneous ones.
 * Leaves to others: sections (test_section).
 * Invariant: all pendulums are random, from seeds; EVENTS_RUNS in the environment sets a larger
 * number of them. */
#include "core/integrate/events/events.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/bodies.h"
#include "tests/harness/passages.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum {
    ARMS = TEST_PASSAGES_ARMS,
    MOST = TEST_PASSAGES_MOST,
    CONDITIONS = TEST_PASSAGES_CONDITIONS
};

static void search(struct test_passages *found, const struct pend_events_problem *problem,
                   long steps) {
    struct pend_events *events;
    struct pend_error error = {0};
    enum pend_found what = PEND_FOUND_NOTHING;
    found->count = 0;
    if (!CHECK_SAYING(pend_events_new(&events, problem, &error) == PEND_OK, "%s", error.text))
        return;
    while (what != PEND_FOUND_END && found->count < MOST) {
        int i = found->count;
        if (!CHECK_SAYING(pend_events_next(events, steps, &what, &found->hit[i], found->phi[i],
                                           found->rate[i], &error) == PEND_OK,
                          "%s", error.text))
            break;
        found->count += what == PEND_FOUND_PASSAGE;
    }
    found->stopped = pend_events_stopped(events);
    CHECK(pend_events_progress(events) <= 1 && pend_events_steps(events) > 0);
    pend_events_free(&events);
    CHECK(!events);
}

static struct pend_events_problem problem_of(const struct test_tree *t,
                                             const struct pend_loads *loads, int count,
                                             const struct pend_event event[]) {
    return (struct pend_events_problem){.tree = t->tree,
                                        .loads = *loads,
                                        .phi = t->phi,
                                        .rate = t->rate,
                                        .duration = test_passages_duration,
                                        .count = count,
                                        .event = event};
}

TEST(events_are_where_32_digits_have_them) {
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 12;
    unsigned long long seed = 1;
    static struct test_passages found;
    double worst = 0;
    long hits = 0;
    for (int i = 0; i < runs; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        struct test_record grid;
        struct pend_event event[CONDITIONS];
        test_passages_random(&t, &b, &grid, event, i, &seed);
        struct pend_events_problem problem = problem_of(&t, &b.loads, CONDITIONS, event);
        problem.rtol = 1e-15;
        search(&found, &problem, 1 + i);
        worst = fmax(worst, test_passages_check(&found, &t, &b.loads, &grid, event));
        hits += found.count;
        test_record_clear(&grid);
        if (i % 2) test_bodies_clear(&b);
    }
    CHECK(hits > runs);
    CHECK_RESIDUAL(worst, 1e-12, "quantities at their events, in 32 digits");
}

/* a rate of 0 is an extreme of the angle: a level 1e-10 beyond it is not reached, one 1e-10 before
 * it is passed twice */
TEST(events_that_graze_are_found_in_pairs_or_not_at_all) {
    static struct test_passages turns, near;
    unsigned long long seed = 2;
    int pairs = 0;
    for (int i = 0; i < 30; i++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
        struct pend_event rest = {PEND_QUANTITY_RATE,          1,    0, 0, 0,
                                  PEND_WAY_UP | PEND_WAY_DOWN, MOST, 0};
        struct pend_events_problem problem = problem_of(&t, TEST_LOADS(9.81), 1, &rest);
        search(&turns, &problem, 7);
        for (int j = 0; j < turns.count; j++) {
            // the side of the level from which the angle comes
            double inside = turns.hit[j].way == PEND_WAY_DOWN ? -1e-10 : 1e-10;
            int passed[2] = {0, 0};
            for (int beyond = 0; beyond < 2; beyond++) {
                struct pend_event level = rest;
                level.quantity = PEND_QUANTITY_PHI;
                level.level = turns.phi[j][1] + (beyond ? -inside : inside);
                problem.event = &level;
                search(&near, &problem, 7);
                for (int k = 0; k < near.count; k++)
                    passed[beyond] += fabs(near.hit[k].time - turns.hit[j].time) < 1e-4;
            }
            pairs += passed[0] == 2;
            CHECK_SAYING(passed[1] == 0 && passed[0] == 2, "%d and %d passages at an extreme",
                         passed[0], passed[1]);
        }
    }
    CHECK(pairs > 30);
}

TEST(events_that_graze_in_any_quantity_come_in_pairs_or_not_at_all) {
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 12, grazing = 0;
    unsigned long long seed = 6;
    static struct test_passages found;
    double worst = 0;
    for (int i = 0; i < runs; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        struct test_record grid;
        struct pend_event event[CONDITIONS];
        double time[TEST_PASSAGES_EXTREMES];
        test_passages_random(&t, &b, &grid, event, i, &seed);
        int extremes = test_passages_grazing(event, time, &t, &b.loads, &grid, i % 2 == 0, &seed);
        if (extremes) {
            struct pend_events_problem problem = problem_of(&t, &b.loads, CONDITIONS, event);
            problem.rtol = 1e-15;
            search(&found, &problem, 1 + i);
            test_passages_grazed(&found, time);
            worst = fmax(worst, test_passages_check(&found, &t, &b.loads, &grid, event));
            grazing += extremes;
        }
        test_record_clear(&grid);
        if (i % 2) test_bodies_clear(&b);
    }
    CHECK_SAYING(grazing > 2 * runs, "%d extremes of %d pendulums", grazing, runs);
    CHECK_RESIDUAL(worst, asked ? 3e-13 : 1e-13,
                   "quantities at events beside extremes, in 32 digits");
}

TEST(events_that_are_simultaneous_are_all_told_in_the_order_of_the_conditions) {
    enum { ALIKE = 5 };
    static struct test_passages found, alone;
    unsigned long long seed = 3;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    struct pend_event event[ALIKE];
    for (int i = 0; i < ALIKE; i++)
        event[i] = (struct pend_event){.quantity = PEND_QUANTITY_PHI,
                                       .arm = 2,
                                       .level = t.phi[2] + 0.1,
                                       .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                                       .most = 3};
    event[4].most = 1;
    struct pend_events_problem problem = problem_of(&t, TEST_LOADS(9.81), ALIKE, event);
    problem.duration = 20;
    search(&found, &problem, 1);
    problem.count = 1;
    search(&alone, &problem, 1000);
    CHECK(alone.count == 3 && found.count == 4 * 3 + 1);
    for (int i = 0; i < found.count; i++) {
        int round = i < 5 ? 0 : 1 + (i - 5) / 4;
        CHECK(found.hit[i].time == alone.hit[round].time &&
              found.hit[i].way == alone.hit[round].way);
        CHECK_INT(found.hit[i].event, round ? (i - 5) % 4 : i);
        CHECK(!memcmp(found.phi[i], alone.phi[round], sizeof found.phi[i][0] * 3));
    }
}

TEST(events_of_a_bound_go_out_and_in_on_both_sides_and_may_end_the_motion) {
    static struct test_passages found;
    const double length = 1, mass = 1;
    const int parent = -1;
    double phi = -M_PI_2 + 1, rate = 0;
    struct test_tree t = {.n = 1, .phi = &phi, .rate = &rate};
    REQUIRE(pend_tree_new(&t.tree, 1, &length, &mass, &parent, NULL) == PEND_OK);
    // the position of the tip for a swing of 1 rad: out at x = -1/2, in, out at 1/2 and so on
    struct pend_event event = {PEND_QUANTITY_X, 0, 0, 0.5, 1, PEND_WAY_UP, MOST, 0};
    struct pend_events_problem problem = problem_of(&t, TEST_LOADS(9.81), 1, &event);
    problem.duration = 10;
    search(&found, &problem, 3);
    CHECK(found.count > 5);
    for (int i = 0; i < found.count; i++) {
        double x = cos(found.phi[i][0]), v = -sin(found.phi[i][0]) * found.rate[i][0];
        CHECK_SAYING(fabs(fabs(x) - 0.5) < 1e-13 && x * v > 0 && (x < 0) == (i % 2 == 0),
                     "passage %d at %g, with %g m/s", i, x, v);
    }
    double third = found.hit[2].time;
    event.stop = 3;
    search(&found, &problem, 3);
    CHECK(found.count == 3 && found.stopped == third);
    // and backwards: the motion from rest is an even function of time
    problem.duration = -10;
    search(&found, &problem, 3);
    CHECK(found.count == 3);
    CHECK_RESIDUAL(fabs(found.stopped + third) + 1e-16, 1e-13, "a stop backwards in time");
    pend_tree_free(&t.tree);
}

/* a quantity that equals its value from the start on, up to rounding, has not reached it */
TEST(events_are_none_while_a_quantity_stays_where_it_began) {
    static struct test_passages found;
    unsigned long long seed = 8;
    struct test_tree t;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
    struct pend_problem motion = {.tree = t.tree,
                                  .loads = *TEST_LOADS(9.81),
                                  .phi = t.phi,
                                  .rate = t.rate,
                                  .times = {.count = 1, .divisor = 1}};
    struct test_record start;
    test_record(&start, "taylor", &motion);
    double energy = start.samples.kinetic[0] + start.samples.potential[0];
    test_record_clear(&start);
    // the distance of the second arm's tip from the first one's, and the energy of a conservative
    // pendulum
    struct pend_event event[] = {
        {PEND_QUANTITY_DISTANCE, 0, 1, t.tree->len[1], 0, PEND_WAY_UP | PEND_WAY_DOWN, MOST, 0},
        {PEND_QUANTITY_ENERGY, 0, 0, energy, 0, PEND_WAY_UP | PEND_WAY_DOWN, MOST, 0},
    };
    struct pend_events_problem problem = problem_of(&t, TEST_LOADS(9.81), 2, event);
    problem.duration = 60;
    search(&found, &problem, 1);
    CHECK_INT(found.count, 0);
    test_tree_clear(&t);
    // upright, from where it falls after a while, and returns
    const double length = 1, mass = 1;
    const int parent = -1;
    double phi = M_PI_2, rate = 0;
    struct test_tree up = {.n = 1, .phi = &phi, .rate = &rate};
    REQUIRE(pend_tree_new(&up.tree, 1, &length, &mass, &parent, NULL) == PEND_OK);
    struct pend_event top = {PEND_QUANTITY_PHI, 0, 0, phi, 0, PEND_WAY_UP | PEND_WAY_DOWN, MOST, 0};
    problem = problem_of(&up, TEST_LOADS(9.81), 1, &top);
    problem.duration = 12;
    search(&found, &problem, 1);
    CHECK_SAYING(!found.count, "%d passages, the first at %g s", found.count, found.hit[0].time);
    struct pend_event below = top;
    below.level = -1;
    problem.event = &below, problem.duration = 20;
    search(&found, &problem, 1);
    CHECK(found.count >= 1 && found.hit[0].time > 1);
    pend_tree_free(&up.tree);
}

TEST(events_that_make_no_sense_are_refused_and_memory_may_be_short) {
    unsigned long long seed = 5;
    OWN(test_tree, clear) t;
    OWN(pend_events, free) *events;
    struct pend_error error;
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    struct pend_event event = {PEND_QUANTITY_ENERGY, 0, 0, 1, 0, PEND_WAY_UP, 1, 0}, bad = event;
    struct pend_events_problem problem = problem_of(&t, TEST_LOADS(9.81), 1, &bad);
    bad.arm = 3;
    CHECK(pend_events_new(&events, &problem, &error) == PEND_INVALID && !events);
    bad = event, bad.level = NAN;
    CHECK(pend_events_new(&events, &problem, &error) == PEND_INVALID);
    bad = event, bad.most = 0;
    CHECK(pend_events_new(&events, &problem, &error) == PEND_INVALID);
    bad = event, problem.duration = 0;
    CHECK(pend_events_new(&events, &problem, &error) == PEND_INVALID);
    problem.duration = 1;
    int failed = 0;
    for (long i = 1;; i++, failed++) {
        test_alloc_fail(i, 0);
        enum pend_status status = pend_events_new(&events, &problem, &error);
        test_alloc_faults_off();
        if (status == PEND_OK) break;
        CHECK(status == PEND_NO_MEMORY && !events);
    }
    CHECK_INT(failed, 2);
}

enum { MANY = 12 };

/* the error of the force of arm k at its first passage of a level, relative to the largest force
 * then; 0 if there is none */
static double force_gap(const struct test_tree *t, const struct pend_loads *loads, int k,
                        double level, void *work) {
    struct pend_event event = {PEND_QUANTITY_FORCE,         k, 0, level, 0,
                               PEND_WAY_UP | PEND_WAY_DOWN, 1, 1};
    struct pend_events_problem problem = problem_of(t, loads, 1, &event);
    struct pend_events *events;
    struct pend_hit hit;
    enum pend_found found;
    double phi[MANY], rate[MANY], acc[MANY], force[MANY], most = 0;
    problem.rtol = 1e-16, problem.duration = 0x1p-5;
    if (!CHECK(pend_events_new(&events, &problem, NULL) == PEND_OK)) return NAN;
    enum pend_status status = pend_events_next(events, 100000, &found, &hit, phi, rate, NULL);
    pend_events_free(&events);
    CHECK(status == PEND_OK && found != PEND_FOUND_NOTHING);
    if (found != PEND_FOUND_PASSAGE) return 0;
    pend_dynamics_at(t->tree, loads, hit.time, phi, rate, work, acc, force);
    for (int l = 0; l < t->n; l++) most = fmax(most, fabs(force[l]));
    return fabs(force[k] - level) / most;
}

/* the error of a force from its series is the rounding of the largest mass times an acceleration */
TEST(events_of_forces_keep_their_digits_where_masses_are_unlike) {
    unsigned long long seed = 11;
    double worst = 0;
    long hits = 0;
    for (int i = 0; i < 60; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        double acc[MANY], force[MANY];
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), MANY, 6, &seed);
        if (i % 4 == 3) test_bodies_random(&b, t.tree, TEST_TERMS_DAMPING, &seed);
        void *work = aligned_alloc(64, (pend_dynamics_at_bytes(t.tree, &b.loads) + 63) / 64 * 64);
        if (!work) abort();
        pend_dynamics_at(t.tree, &b.loads, 0, t.phi, t.rate, work, acc, force);
        for (int k = 0; k < 2 * MANY; k++) {
            double level = force[k / 2] * (k % 2 ? 1.0001 : 0.9999);
            double gap = force_gap(&t, &b.loads, k / 2, level, work);
            hits += gap != 0;
            if (!(gap <= worst)) worst = gap;
        }
        free(work);
        if (i % 4 == 3) test_bodies_clear(&b);
    }
    CHECK_SAYING(hits > 200, "%ld passages", hits);
    CHECK_RESIDUAL(worst, 2e-13, "forces at their events, of the largest");
}
