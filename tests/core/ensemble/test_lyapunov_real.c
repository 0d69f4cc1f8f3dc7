/* Tests of exponents and sections of real pendulums: friction reduces the sum of the exponents by
 * the contraction of the volume; drives are evaluated at the motion's own time; stroboscopic
 * sections.
 * Leaves to others: ideal pendulums (test_lyapunov, test_section).
 * Invariant: references are closed forms or single runs. */
#include <math.h>
#include <string.h>

#include "core/ensemble/lyapunov.h"
#include "core/integrate/events/section.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* the damped driven pendulum of textbooks: theta'' + theta' / q + sin theta = g cos(w t) */
struct driven {
    struct pend_tree *tree;
    struct test_bodies b;
    double value[4];
};

static int driven_new(struct driven *d, double quality, double strength, double omega) {
    const double length[] = {1}, mass[] = {1};
    const int parent[] = {-1}, drives[] = {0};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int place;
    rows[PEND_TERM_DAMPING] = 1;
    if (!CHECK(pend_tree_new(&d->tree, 1, length, mass, parent, NULL) == PEND_OK)) return 0;
    if (!CHECK(pend_terms_new(&d->b.terms, 1, rows, ones, 1, drives, &place) == PEND_OK)) return 0;
    d->b.value = d->value;
    d->value[d->b.terms->row[PEND_TERM_DAMPING]] = 1 / quality;
    double *h = d->value + d->b.terms->harmonic[0].at;
    h[0] = strength, h[1] = omega, h[2] = 0;
    d->b.loads = (struct pend_loads){1, d->b.terms, d->value};
    return 1;
}

static void driven_free(struct driven *d) {
    pend_terms_free(&d->b.terms);
    pend_tree_free(&d->tree);
}

static void exponents(const struct pend_lyapunov_problem *problem, long transient, long intervals,
                      double exponent[]) {
    OWN(pend_lyapunov, free) *lyapunov;
    int done;
    if (!CHECK(pend_lyapunov_new(&lyapunov, problem, NULL) == PEND_OK)) return;
    for (long i = 0; i < transient + intervals; i += done) {
        if (!CHECK(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK)) break;
        if (done && i + 1 == transient) pend_lyapunov_forget(lyapunov);
    }
    pend_lyapunov_exponents(lyapunov, exponent);
}

/* a state after an interval by method taylor, with drives from `start` on */
static void driven_move(const struct driven *d, double start, double time, double state[2]) {
    const struct pend_problem problem = {
        .tree = d->tree,
        .loads = d->b.loads,
        .phi = &state[0],
        .rate = &state[1],
        .times = {.count = 2, .start = start, .span = time, .divisor = 1},
        .rtol = 1e-15};
    double at[2], phi[2], rate[2];
    struct pend_samples samples = {.cap = 2, .t = at, .phi = phi, .rate = rate};
    struct pend_run *run;
    int done = 0;
    REQUIRE(pend_run_new(&run, &pend_method_taylor, &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
    pend_run_free(&run);
    state[0] = phi[1], state[1] = rate[1];
}

/* the first exponent over `intervals` after `transient` others, by central differences of single
 * runs at a distance of 1e-5, correct to 1e-9; rates are divided by the frequency that exponents
 * use, sqrt(g / l) = 1 and that of the terms */
static double driven_growth(const struct driven *d, double start, double interval, int transient,
                            int intervals, double phi) {
    const double apart = 1e-5;
    double state[2] = {phi, 0}, way[2] = {1, 1}, sum = 0;
    double frequency = 1 + pend_terms_rate(d->b.terms, d->tree->parent, d->tree->len, d->tree->mass,
                                           d->value, NULL);
    for (int i = 0; i < transient + intervals; i++, start += interval) {
        double size = hypot(way[0], way[1] / frequency), side[2][2];
        for (int k = 0; k < 2; k++) {
            double step = (k ? -apart : apart) / size;
            side[k][0] = state[0] + step * way[0], side[k][1] = state[1] + step * way[1];
            driven_move(d, start, interval, side[k]);
        }
        driven_move(d, start, interval, state);
        for (int k = 0; k < 2; k++) way[k] = (side[0][k] - side[1][k]) / (2 * apart);
        if (i >= transient) sum += log(hypot(way[0], way[1] / frequency));
    }
    return sum / (interval * intervals);
}

/* A volume of angles and rates shrinks as e^{-t / q}. At q = 2, w = 2/3 (Baker and Gollub, Chaotic
 * Dynamics, Cambridge 1990) a drive of 0.9 gives an oscillation whose neighbours spiral towards it,
 * so that both exponents are half of that, up to the shape of their ellipse divided by the time;
 * 1.5 gives chaos, with the exponent that neighbours of single runs have. */
TEST(exponents_of_the_driven_pendulum_add_up_to_its_damping) {
    static const double strength[] = {0.9, 1.5};
    for (int i = 0; i < 2; i++) {
        OWN(driven, free) d;
        double phi = 0.2 - M_PI_2, rate = 0, exponent[2] = {0, 0};
        REQUIRE(driven_new(&d, 2, strength[i], 2.0 / 3));
        const struct pend_lyapunov_problem problem = {.tree = d.tree,
                                                      .loads = d.b.loads,
                                                      .phi = &phi,
                                                      .rate = &rate,
                                                      .count = 2,
                                                      .interval = 3,
                                                      .start = 1};
        exponents(&problem, 20, i ? 20 : 400, exponent);
        CHECK_RESIDUAL(fabs(exponent[0] + exponent[1] + 0.5), 1e-9, "the sum of both exponents");
        if (i) {
            double growth = driven_growth(&d, 1, 3, 20, 20, phi);
            CHECK_SAYING(growth > 0, "%g", growth);
            CHECK_RESIDUAL(fabs(exponent[0] - growth), 1e-8, "the exponent of single runs");
        } else {
            CHECK_RESIDUAL(fabs(exponent[0] + 0.25), 2e-3, "half of the damping");
        }
    }
}

/* a motion by method taylor with drives from `start` on, at the instants of a search */
static void alone(const struct test_tree *t, const struct test_bodies *b, double start, double time,
                  double phi[], double rate[]) {
    struct pend_problem problem = {
        .tree = t->tree,
        .loads = b->loads,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = 2, .start = start, .span = time, .divisor = 1},
        .rtol = 1e-15};
    double at[2], angle[2 * 8], speed[2 * 8];
    struct pend_samples samples = {.cap = 2, .t = at, .phi = angle, .rate = speed};
    struct pend_run *run;
    int done = 0, n = t->n;
    REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
    pend_run_free(&run);
    for (int k = 0; k < n; k++) {
        phi[k] = angle[n + t->tree->order[k]];
        rate[k] = speed[n + t->tree->order[k]];
    }
}

/* the motion of the exponents ends where method taylor ends, whatever acts on it */
TEST(exponents_follow_the_motion_of_a_real_pendulum_from_its_own_time) {
    unsigned long long seed = 12;
    for (int i = 0; i < 3; i++) {
        static const unsigned terms[] = {TEST_TERMS_PIVOT, TEST_TERMS_SPRINGS, TEST_TERMS_ALL};
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct pend_lyapunov *lyapunov;
        double phi[3], rate[3], want[3], speed[3], gap = 0;
        int done = 0;
        test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
        test_bodies_random(&b, t.tree, terms[i], &seed);
        t.phi[0] += 20; // whole turns, which springs distinguish
        const struct pend_lyapunov_problem problem = {.tree = t.tree,
                                                      .loads = b.loads,
                                                      .phi = t.phi,
                                                      .rate = t.rate,
                                                      .count = 6,
                                                      .interval = 0.25,
                                                      .start = 5.5};
        if (!CHECK(pend_lyapunov_new(&lyapunov, &problem, NULL) == PEND_OK)) continue;
        for (int j = 0; j < 2; j += done) {
            if (!CHECK(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK)) break;
            if (done && !j) pend_lyapunov_forget(lyapunov);
        }
        pend_lyapunov_state(lyapunov, phi, rate);
        pend_lyapunov_free(&lyapunov);
        alone(&t, &b, 5.5, 0.5, want, speed);
        for (int k = 0; k < 3; k++) {
            double turn = phi[k] - want[k];
            if (i == 0) turn = remainder(turn, 2 * M_PI);
            gap = fmax(gap, fmax(fabs(turn), fabs(rate[k] - speed[k])));
        }
        CHECK_RESIDUAL(gap, 1e-12, "the motion beside which the neighbours are");
    }
}

/* searches to the end; at most 64 passages */
static int search(const struct pend_section_problem *problem, long steps, double time[],
                  double phi[][3], double rate[][3]) {
    enum pend_found found = PEND_FOUND_NOTHING;
    OWN(pend_section, free) *section;
    struct pend_passage passage;
    int count = 0;
    if (!CHECK(pend_section_new(&section, problem, NULL) == PEND_OK)) return 0;
    while (count < 64) {
        if (!CHECK(pend_section_next(section, steps, &found, &passage, phi[count], rate[count],
                                     NULL) == PEND_OK))
            break;
        if (found == PEND_FOUND_END) break;
        if (found == PEND_FOUND_PASSAGE) time[count++] = passage.time;
    }
    return count;
}

TEST(stroboscopic_sections_have_the_states_of_single_runs_a_period_apart) {
    unsigned long long seed = 13;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    double time[64], phi[64][3], rate[64][3], again_time[64], again[64][3], other[64][3];
    double want[3], speed[3], gap = 0;
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_ALL, &seed);
    struct pend_section_problem problem = {.tree = t.tree,
                                           .loads = b.loads,
                                           .phi = t.phi,
                                           .rate = t.rate,
                                           .duration = 2,
                                           .rtol = 1e-15,
                                           .start = 4,
                                           .period = 0.3,
                                           .first = -0.5};
    // -0.5 + 0.3 k, from 0.1 on
    REQUIRE(search(&problem, 3, time, phi, rate) == 7);
    for (int i = 0; i < 7; i++) {
        CHECK(fabs(time[i] - (0.1 + 0.3 * i)) < 1e-15);
        alone(&t, &b, 4, time[i], want, speed);
        gap = fmax(gap, fmax(test_gap(3, phi[i], want), test_gap(3, rate[i], speed)));
    }
    CHECK_RESIDUAL(gap, 1e-12, "states of a stroboscopic section");
    CHECK_INT(search(&problem, 1000, again_time, again, other), 7);
    CHECK(!memcmp(phi, again, 7 * sizeof *phi) && !memcmp(rate, other, 7 * sizeof *rate));
    // a period far shorter than a step
    problem.period = 1e-3, problem.first = 0, problem.duration = 0.01;
    CHECK_INT(search(&problem, 1, time, phi, rate), 10);
    CHECK(time[9] == 0.01 && time[0] == 1e-3);
    struct pend_section *section;
    problem.period = -1;
    CHECK(pend_section_new(&section, &problem, NULL) == PEND_INVALID && !section);
    problem.period = 1e-300;
    CHECK(pend_section_new(&section, &problem, NULL) == PEND_INVALID && !section);
    problem.period = 1, problem.start = NAN;
    CHECK(pend_section_new(&section, &problem, NULL) == PEND_INVALID && !section);
}

/* the smallest change of the rate over any number of periods up to `most`, maximized over its
 * components, from passage `from` on */
static double least_change(double rate[][3], int from, int count, int most) {
    double least = INFINITY;
    for (int every = 1; every <= most; every++) {
        double change = 0;
        for (int j = from; j + every < count; j++)
            change = fmax(change, fabs(rate[j + every][0] - rate[j][0]));
        least = fmin(least, change);
    }
    return least;
}

/* Below the threshold of its first period doubling the driven pendulum repeats after each period:
 * after 40 periods a deviation is e^{-0.25 40 3 pi} of its size, and only errors of steps remain.
 * In chaos it never repeats. */
TEST(driven_pendulums_section_is_one_point_or_many_as_the_books_say) {
    static const double strength[] = {0.9, 1.5};
    for (int i = 0; i < 2; i++) {
        OWN(driven, free) d;
        double start = 0.2 - M_PI_2, still = 0, period = 3 * M_PI, time[64], phi[64][3],
               rate[64][3];
        REQUIRE(driven_new(&d, 2, strength[i], 2.0 / 3));
        const struct pend_section_problem problem = {.tree = d.tree,
                                                     .loads = d.b.loads,
                                                     .phi = &start,
                                                     .rate = &still,
                                                     .duration = 60 * period,
                                                     .period = period};
        int count = search(&problem, 1000, time, phi, rate);
        CHECK(count >= 59);
        double again = least_change(rate, 40, count, i ? 8 : 1);
        CHECK_SAYING(i ? again > 0.1 : again < 1e-10, "%g", again);
    }
}

TEST(sections_of_an_arm_with_springs_are_found_at_the_state_of_single_runs) {
    unsigned long long seed = 14;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    double time[64], phi[64][3], rate[64][3], want[3], speed[3], gap = 0;
    test_tree_random(&t, TEST_TREE_CHAIN, 3, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_SPRINGS | TEST_TERMS_PIVOT, &seed);
    t.phi[0] = -M_PI_2 + 7; // more than a turn: the spring pulls it back
    struct pend_section_problem problem = {.tree = t.tree,
                                           .loads = b.loads,
                                           .phi = t.phi,
                                           .rate = t.rate,
                                           .duration = 2,
                                           .rtol = 1e-15,
                                           .start = 4,
                                           .arm = 0,
                                           .angle = -M_PI_2,
                                           .ways = PEND_WAY_UP | PEND_WAY_DOWN};
    int count = search(&problem, 1000, time, phi, rate);
    CHECK(count >= 1);
    for (int i = 0; i < count; i++) {
        alone(&t, &b, 4, time[i], want, speed);
        gap = fmax(gap, fmax(test_gap(3, phi[i], want), test_gap(3, rate[i], speed)));
        gap = fmax(gap, fabs(remainder(phi[i][0] + M_PI_2, 2 * M_PI)));
    }
    CHECK_RESIDUAL(gap, 1e-12, "states at passages");
}
