/* Tests of core/integrate/events: passages against samples in 32 digits, grazing and simultaneous
 * ones.
 * Leaves to others: sections (test_section).
 * Invariant: all pendulums are random, from seeds; EVENTS_RUNS in the environment makes there more
 * of them. */
#include "core/integrate/events.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 4, MOST = 4000, CONDITIONS = 12, GRID = 120 };
static const double duration = 1.5;

/* All that a search finds. */
struct search {
    int count;
    struct pend_hit hit[MOST];
    double phi[MOST][ARMS], rate[MOST][ARMS];
    double stopped;
};

static void search(struct search *found, const struct pend_events_problem *problem, long steps) {
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
                                        .duration = duration,
                                        .count = count,
                                        .event = event};
}

/* the quantity of a condition in row i of a record */
static double quantity(const struct test_record *r, const struct test_tree *t,
                       const struct pend_event *event, long i) {
    const struct pend_samples *s = &r->samples;
    long at = i * t->n + t->tree->order[event->arm], to = i * t->n + t->tree->order[event->other];
    switch (event->quantity) {
    case PEND_QUANTITY_THETA:
        return s->phi[at] + M_PI_2;
    case PEND_QUANTITY_PHI:
        return s->phi[at];
    case PEND_QUANTITY_RATE:
        return s->rate[at];
    case PEND_QUANTITY_FORCE:
        return s->force[at];
    case PEND_QUANTITY_X:
        return s->z_re[at];
    case PEND_QUANTITY_Y:
        return s->z_im[at];
    case PEND_QUANTITY_DISTANCE:
        return hypot(s->z_re[at] - s->z_re[to], s->z_im[at] - s->z_im[to]);
    case PEND_QUANTITY_KINETIC:
        return s->kinetic[i];
    case PEND_QUANTITY_POTENTIAL:
        return s->potential[i];
    default:
        return s->kinetic[i] + s->potential[i];
    }
}

/* samples in 32 digits at instants after the start, which is the first of them */
static void exactly(struct test_record *record, const struct test_tree *t,
                    const struct pend_loads *loads, long count, const double time[]) {
    struct pend_problem problem = {.tree = t->tree,
                                   .loads = *loads,
                                   .phi = t->phi,
                                   .rate = t->rate,
                                   .times = {.count = count, .divisor = 1, .list = time}};
    test_record_blocks(record, pend_method_taylor.extended, &problem, count, 1e18);
    CHECK_SAYING(record->status == PEND_OK, "%s", record->error.text);
}

/* conditions of all kinds on values that the motion takes; a level is the quantity at a random
 * instant of the grid */
static void conditions(struct pend_event event[CONDITIONS], const struct test_tree *t,
                       const struct test_record *grid, int conserves, unsigned long long *seed) {
    for (int i = 0; i < CONDITIONS; i++) {
        int arm = test_random_int(seed, t->n);
        event[i] = (struct pend_event){.quantity = (enum pend_quantity)(i % PEND_QUANTITIES),
                                       .arm = arm,
                                       .other = t->n > 1 ? (arm + 1) % t->n : 0,
                                       .ways = PEND_WAY_UP | PEND_WAY_DOWN,
                                       .most = MOST};
        // the energy of what conserves it is no condition
        if (event[i].quantity == PEND_QUANTITY_ENERGY && conserves)
            event[i].quantity = PEND_QUANTITY_PHI;
        if (event[i].quantity == PEND_QUANTITY_DISTANCE && t->n == 1)
            event[i].quantity = PEND_QUANTITY_X;
        double a = quantity(grid, t, &event[i], test_random_int(seed, GRID - 1) + 1);
        double b = quantity(grid, t, &event[i], test_random_int(seed, GRID - 1) + 1);
        event[i].level = a + (b - a) * test_random(seed);
    }
}

/* the largest part of its scale by which a quantity misses its level at the hits of a condition,
 * and whether it is on the side of each hit's way between it and the next */
static double levels(const struct search *found, const struct test_tree *t,
                     const struct pend_loads *loads, const struct pend_event *event, int which) {
    static double time[2 * MOST + 1];
    static int hit[MOST];
    struct test_record record;
    long count = 1;
    int hits = 0;
    double worst = 0;
    time[0] = 0;
    for (int i = 0; i < found->count; i++)
        if (found->hit[i].event == which) hit[hits++] = i;
    for (int i = 0; i < hits; i++) {
        double at = found->hit[hit[i]].time;
        double next = i + 1 < hits ? found->hit[hit[i + 1]].time : duration;
        if (at > time[count - 1]) time[count++] = at;
        if ((at + next) / 2 > time[count - 1]) time[count++] = (at + next) / 2;
    }
    if (!hits) return 0;
    exactly(&record, t, loads, count, time);
    long row = 1;
    for (int i = 0; i < hits; i++) {
        const struct pend_hit *h = &found->hit[hit[i]];
        if (i) CHECK_SAYING(h->way != found->hit[hit[i - 1]].way, "twice the same way");
        if (record.samples.t[row] != h->time) continue;
        double gap = quantity(&record, t, event, row++) - event->level;
        worst = fmax(worst, fabs(gap) / (1 + fabs(event->level)));
        if (row >= count || i + 1 >= hits || record.samples.t[row] == found->hit[hit[i + 1]].time)
            continue;
        gap = quantity(&record, t, event, row++) - event->level;
        CHECK_SAYING((gap > 0) == (h->way == PEND_WAY_UP) || fabs(gap) < 1e-9,
                     "not on its side: %g", gap);
    }
    test_record_clear(&record);
    return worst;
}

/* changes of side from instant to instant of the grid, which are the parity of the hits between */
static void parity(const struct search *found, const struct test_tree *t,
                   const struct test_record *grid, const struct pend_event *event, int which) {
    int next = 0;
    for (long i = 1; i < GRID; i++) {
        double before = quantity(grid, t, event, i - 1) - event->level;
        double after = quantity(grid, t, event, i) - event->level;
        int hits = 0;
        while (next < found->count && found->hit[next].time <= grid->samples.t[i])
            hits += found->hit[next++].event == which;
        if (fmin(fabs(before), fabs(after)) < 1e-9 * (1 + fabs(event->level))) continue;
        CHECK_SAYING((hits % 2 != 0) == ((before > 0) != (after > 0)),
                     "%d hits of quantity %d between %g and %g s, from %g to %g", hits,
                     event->quantity, grid->samples.t[i - 1], grid->samples.t[i], before, after);
    }
}

TEST(events_are_where_32_digits_have_them) {
    const char *asked = getenv("EVENTS_RUNS");
    int runs = asked ? atoi(asked) : 12;
    unsigned long long seed = 1;
    static struct search found;
    double worst = 0, time[GRID];
    long hits = 0;
    for (int i = 0; i < GRID; i++) time[i] = duration * i / (GRID - 1);
    for (int i = 0; i < runs; i++) {
        struct test_tree t;
        struct test_bodies b = {.loads = *TEST_LOADS(9.81)};
        struct test_record grid;
        struct pend_event event[CONDITIONS];
        int real = i % 2;
        test_tree_random(&t, TEST_TREE_ATTACHED, 1 + i % ARMS, 0.3, &seed);
        if (real) test_bodies_random(&b, t.tree, TEST_TERMS_ALL & ~TEST_TERMS_FRICTION, &seed);
        exactly(&grid, &t, &b.loads, GRID, time);
        conditions(event, &t, &grid, !real, &seed);
        struct pend_events_problem problem = problem_of(&t, &b.loads, CONDITIONS, event);
        problem.rtol = 1e-15;
        search(&found, &problem, 1 + i);
        for (int j = 1; j < found.count; j++) CHECK(found.hit[j].time >= found.hit[j - 1].time);
        for (int j = 0; j < CONDITIONS; j++) {
            parity(&found, &t, &grid, &event[j], j);
            worst = fmax(worst, levels(&found, &t, &b.loads, &event[j], j));
        }
        hits += found.count;
        test_record_clear(&grid);
        if (real) test_bodies_clear(&b);
        test_tree_clear(&t);
    }
    CHECK(hits > runs);
    CHECK_RESIDUAL(worst, 1e-11, "quantities at their events, in 32 digits");
}

/* a rate of 0 is an extreme of the angle: a level beyond it by 1e-10 is not reached, one before it
 * by as much is passed twice */
TEST(events_that_graze_are_found_in_pairs_or_not_at_all) {
    static struct search turns, near;
    unsigned long long seed = 2;
    int pairs = 0;
    for (int i = 0; i < 30; i++) {
        struct test_tree t;
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
        test_tree_clear(&t);
    }
    CHECK(pairs > 30);
}

TEST(events_that_are_simultaneous_are_all_told_in_the_order_of_the_conditions) {
    enum { ALIKE = 5 };
    static struct search found, alone;
    unsigned long long seed = 3;
    struct test_tree t;
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
    test_tree_clear(&t);
}

TEST(events_of_a_bound_go_out_and_in_on_both_sides_and_may_end_the_motion) {
    static struct search found;
    const double length = 1, mass = 1;
    const int parent = -1;
    double phi = -M_PI_2 + 1, rate = 0;
    struct test_tree t = {.n = 1, .phi = &phi, .rate = &rate};
    REQUIRE(pend_tree_new(&t.tree, 1, &length, &mass, &parent, NULL) == PEND_OK);
    // the tip's way to either side, of 1 rad: out at x = -1/2, in, out at 1/2 and so on
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
    // and backwards: the motion from rest is even in time
    problem.duration = -10;
    search(&found, &problem, 3);
    CHECK(found.count == 3);
    CHECK_RESIDUAL(fabs(found.stopped + third) + 1e-16, 1e-13, "a stop backwards in time");
    pend_tree_free(&t.tree);
}

TEST(events_that_make_no_sense_are_refused_and_memory_may_be_short) {
    unsigned long long seed = 5;
    struct test_tree t;
    struct pend_events *events;
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
    pend_events_free(&events);
    test_tree_clear(&t);
}
