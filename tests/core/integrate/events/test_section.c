#include "core/integrate/events/section.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 4, MOST = 400 };

/* All results of a search. */
struct search {
    int count;
    struct pend_passage passage[MOST];
    double phi[MOST][ARMS], rate[MOST][ARMS];
};

static void tree_of(struct test_tree *t, int n, unsigned long long seed) {
    int parent[ARMS] = {-1};
    for (int k = 1; k < n; k++) parent[k] = test_random_int(&seed, k);
    test_tree_init(t, n, parent, 0.2, &seed);
    for (int k = 0; k < n; k++) {
        t->phi[k] = 4 * test_random(&seed) - 2;
        t->rate[k] = 6 * test_random(&seed) - 3;
    }
}

static struct pend_section_problem section_of(const struct test_tree *t, double duration, int arm,
                                              double angle, unsigned ways) {
    return (struct pend_section_problem){.tree = t->tree,
                                         .loads.gravity = 9.81,
                                         .phi = t->phi,
                                         .rate = t->rate,
                                         .duration = duration,
                                         .arm = arm,
                                         .angle = angle,
                                         .ways = ways};
}

static void search(struct search *found, const struct pend_section_problem *problem, long steps) {
    struct pend_section *section;
    enum pend_found what = PEND_FOUND_NOTHING;
    found->count = 0;
    if (!CHECK(pend_section_new(&section, problem, NULL) == PEND_OK)) return;
    while (what != PEND_FOUND_END && found->count < MOST) {
        int i = found->count;
        if (!CHECK(pend_section_next(section, steps, &what, &found->passage[i], found->phi[i],
                                     found->rate[i], NULL) == PEND_OK))
            break;
        found->count += what == PEND_FOUND_PASSAGE;
    }
    CHECK(pend_section_progress(section) == 1 && pend_section_steps(section) > 0);
    pend_section_free(&section);
    CHECK(!section);
}

/* the motion at equidistant instants; phi of the arm, by stored number */
static void watch(struct test_record *record, const struct test_tree *t, double duration,
                  long count) {
    const struct pend_problem problem = {
        .tree = t->tree,
        .loads.gravity = 9.81,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = count, .span = duration, .divisor = (double)(count - 1)}};
    test_record(record, "taylor", &problem);
}

static double turns(double phi, double angle) { return floor((phi - angle) / (2 * M_PI)); }

TEST(section_finds_as_many_passages_as_a_fine_look_at_the_motion) {
    enum { FINE = 40001 };
    long all = 0;
    for (int n = 1; n <= ARMS; n++)
        for (unsigned long long seed = 1; seed <= 5; seed++) {
            static struct search up, down, both;
            OWN(test_tree, clear) t;
            OWN(test_record, clear) record;
            tree_of(&t, n, seed);
            int arm = (int)(seed % (unsigned)n), ups = 0, downs = 0, caller = t.tree->order[arm];
            double angle = -1.5 + 0.3 * (double)seed;
            watch(&record, &t, 10, FINE);
            for (long i = 1; i < FINE; i++) {
                double before = turns(record.samples.phi[(i - 1) * n + caller], angle);
                double now = turns(record.samples.phi[i * n + caller], angle);
                ups += now > before;
                downs += now < before;
            }
            struct pend_section_problem problem = section_of(&t, 10, arm, angle, PEND_WAY_UP);
            search(&up, &problem, 1000);
            problem.ways = PEND_WAY_DOWN;
            search(&down, &problem, 1);
            problem.ways = PEND_WAY_UP | PEND_WAY_DOWN;
            search(&both, &problem, 3);
            CHECK_INT(up.count, ups);
            CHECK_INT(down.count, downs);
            CHECK_INT(both.count, ups + downs);
            for (int i = 1; i < both.count; i++)
                CHECK(both.passage[i].time > both.passage[i - 1].time);
            for (int i = 0; i < up.count; i++)
                CHECK(up.passage[i].way == PEND_WAY_UP && up.rate[i][arm] >= 0);
            for (int i = 0; i < down.count; i++)
                CHECK(down.passage[i].way == PEND_WAY_DOWN && down.rate[i][arm] <= 0);
            all += both.count;
        }
    CHECK_SAYING(all > 100, "%ld in all", all);
}

/* the arm is in the section, and the state is that of the motion at that instant */
TEST(section_passages_are_found_to_rounding) {
    double off = 0, gap = 0;
    for (unsigned long long seed = 1; seed <= 10; seed++) {
        static struct search both;
        OWN(test_tree, clear) t;
        struct test_record record;
        double times[MOST];
        tree_of(&t, 3, seed);
        const struct pend_section_problem problem =
            section_of(&t, 5, 1, 0.25, PEND_WAY_UP | PEND_WAY_DOWN);
        search(&both, &problem, 1000);
        for (int i = 0; i < both.count; i++) {
            double turned = remainder(both.phi[i][1] - 0.25, 2 * M_PI),
                   slope = fmax(1, fabs(both.rate[i][1]));
            off = fmax(off, fabs(turned) / slope / fmax(1, fabs(both.phi[i][1])));
            times[i] = both.passage[i].time;
        }
        const struct pend_problem motion = {.tree = t.tree,
                                            .loads.gravity = 9.81,
                                            .phi = t.phi,
                                            .rate = t.rate,
                                            .times = {.count = both.count, .list = times}};
        if (both.count) {
            /* a run starts at its first instant, so that of the start is added */
            double list[MOST + 1] = {0};
            memcpy(list + 1, times, (size_t)both.count * sizeof *list);
            struct pend_problem from_start = motion;
            from_start.times.count = both.count + 1;
            from_start.times.list = list;
            test_record(&record, "taylor", &from_start);
            for (int i = 0; i < both.count; i++)
                for (int k = 0; k < 3; k++)
                    gap = fmax(gap, fabs(record.samples.phi[(i + 1) * 3 + t.tree->order[k]] -
                                         both.phi[i][k]));
            test_record_clear(&record);
        }
    }
    CHECK_RESIDUAL(off, 2e-14, "distance from the section");
    CHECK_SAYING(gap <= 1e-9, "the states are off by %g", gap);
}

/* an arm released at theta = 1 returns to it and no further: a level just below is passed twice,
 * one just above never */
TEST(section_passages_that_graze_are_found_and_those_that_miss_are_not) {
    static const double hair[] = {1e-3, 1e-6, 1e-9, 1e-11};
    const int parent[] = {-1};
    unsigned long long seed = 1;
    for (int i = 0; i < 4; i++) {
        static struct search below, beyond;
        OWN(test_tree, clear) t;
        test_tree_init(&t, 1, parent, 0, &seed);
        t.length[0] = t.mass[0] = 1;
        test_tree_rebuild(&t);
        t.phi[0] = 1 - M_PI_2;
        t.rate[0] = 0;
        struct pend_section_problem problem =
            section_of(&t, 3.2, 0, 1 - hair[i] - M_PI_2, PEND_WAY_UP | PEND_WAY_DOWN);
        search(&below, &problem, 1000);
        /* the period is 2.14 s: once at the beginning, twice after one period */
        CHECK_INT(below.count, 3);
        if (below.count == 3)
            CHECK(below.passage[0].way == PEND_WAY_DOWN && below.passage[1].way == PEND_WAY_UP &&
                  below.passage[2].way == PEND_WAY_DOWN &&
                  fabs(below.passage[1].time - 2.14) < 0.05);
        problem.angle = 1 + hair[i] - M_PI_2;
        search(&beyond, &problem, 1000);
        CHECK_INT(beyond.count, 0);
    }
}

TEST(section_in_which_a_motion_starts_is_not_passed_by_that) {
    static struct search found;
    struct test_tree t;
    for (int way = -1; way <= 1; way += 2) {
        tree_of(&t, 1, 2);
        t.phi[0] = 0.5;
        t.rate[0] = way;
        const struct pend_section_problem problem =
            section_of(&t, 0.05, 0, 0.5, PEND_WAY_UP | PEND_WAY_DOWN);
        search(&found, &problem, 1000);
        CHECK_INT(found.count, 0);
        test_tree_clear(&t);
    }
}

TEST(section_whole_turns_do_not_matter) {
    static struct search plain, turned;
    OWN(test_tree, clear) t;
    tree_of(&t, 2, 3);
    struct pend_section_problem problem = section_of(&t, 10, 0, -0.5, PEND_WAY_UP);
    search(&plain, &problem, 1000);
    problem.angle += 4 * M_PI;
    search(&turned, &problem, 7);
    CHECK(plain.count > 3);
    CHECK_INT(turned.count, plain.count);
    for (int i = 0; i < plain.count && i < turned.count; i++)
        CHECK(fabs(turned.passage[i].time - plain.passage[i].time) < 1e-12);
}

TEST(sections_that_make_no_sense_are_refused) {
    OWN(test_tree, clear) t;
    struct pend_section *section;
    struct pend_error error;
    tree_of(&t, 2, 3);
    struct pend_section_problem good = section_of(&t, 1, 0, 0, PEND_WAY_UP), bad = good;
    bad.duration = 0;
    CHECK(pend_section_new(&section, &bad, &error) == PEND_INVALID && !section);
    bad = good, bad.arm = 2;
    CHECK(pend_section_new(&section, &bad, &error) == PEND_INVALID && !section);
    bad = good, bad.ways = 4;
    CHECK(pend_section_new(&section, &bad, &error) == PEND_INVALID && !section);
    bad = good, bad.loads.gravity = NAN;
    CHECK(pend_section_new(&section, &bad, &error) == PEND_INVALID && !section);
    bad = good, bad.angle = NAN;
    CHECK(pend_section_new(&section, &bad, &error) == PEND_INVALID && !section);
}

/* the passages of the motion in 32 digits agree with those found, for as long as these are reported
 * as accurate */
TEST(section_says_which_passages_hold) {
    int short_of = 0;
    for (int i = 0; i < 6; i++) {
        OWN(test_tree, clear) t;
        OWN(pend_section, free) *section;
        struct pend_passage passage;
        enum pend_found what = PEND_FOUND_NOTHING;
        double phi[ARMS], rate[ARMS], exact[ARMS], fast = 0, lost = 0;
        tree_of(&t, 2 + i % 3, 31 + (unsigned)i);
        struct pend_section_problem problem = section_of(&t, 15, 0, -M_PI_2, PEND_WAY_UP);
        problem.accuracy = 1e-6;
        REQUIRE(pend_section_new(&section, &problem, NULL) == PEND_OK);
        while (what != PEND_FOUND_END) {
            REQUIRE(pend_section_next(section, 1000, &what, &passage, phi, rate, NULL) == PEND_OK);
            if (what != PEND_FOUND_PASSAGE || lost > 0) continue;
            OWN(test_record, clear) record;
            const double list[] = {0, passage.time};
            const struct pend_problem motion = {.tree = t.tree,
                                                .loads.gravity = 9.81,
                                                .phi = t.phi,
                                                .rate = t.rate,
                                                .times = {.count = 2, .list = list}};
            test_record_blocks(&record, pend_method_taylor.extended, &motion, 2, INFINITY);
            for (int k = 0; k < t.n; k++) exact[k] = record.samples.phi[t.n + t.tree->order[k]];
            for (int k = 0; k < t.n; k++)
                fast = fabs(exact[k] - phi[k]) > problem.accuracy ? 1 : fast;
            if (fast > 0) lost = passage.time;
        }
        double held = pend_section_held(section);
        // passages are about a second apart
        CHECK_SAYING(lost ? held <= 1.1 * lost && held >= 0.6 * lost : held > 9,
                     "%d: held %g, lost %g", i, held, lost);
        short_of += held < 15;
    }
    CHECK_SAYING(short_of >= 2, "%d", short_of);
}
