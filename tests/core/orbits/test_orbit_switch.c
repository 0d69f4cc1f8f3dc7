/* Tests of branches that begin at bifurcations of others: orbits of twice the period, without the
 * symmetry of the previous branch, or that are never at rest.
 * Leaves to others: the branches that are left (test_orbits).
 * Invariant: an orbit of another branch is distinguished from one of the previous branch by an
 * independently computed motion. */
#include "core/orbits/orbit_switch.h"

#include <math.h>
#include <stdlib.h>

#include "tests/harness/found.h"
#include "tests/harness/test.h"

/* the distance of a row's start from the state after a fraction of its period, in 32 digits: rad,
 * and rates relative to the period's frequency; side -1: from its mirror image about hanging */
static double away_after(const struct found *f, int row, double part, int side) {
    int n = f->tree->n;
    double end[2 * FOUND_ARMS], low[2 * FOUND_ARMS], most = 0;
    found_moved(f, row, part * f->period[row], -1, 0, end, low);
    for (int k = 0; k < n; k++) {
        double rest = side < 0 ? M_PI / 2 : 0;
        double angle = end[k] + rest - side * (f->phi[row][k] + rest);
        double rate = (end[n + k] - side * f->rate[row][k]) * f->period[row] / (2 * M_PI);
        most = fmax(most, fmax(fabs(angle), fabs(rate)));
    }
    return most;
}

/* the largest rate at the start of a row, and half a period later, relative to its frequency */
static void rates_at(const struct found *f, int row, double *start, double *half) {
    int n = f->tree->n;
    double end[2 * FOUND_ARMS], low[2 * FOUND_ARMS], unit = f->period[row] / (2 * M_PI);
    found_moved(f, row, f->period[row] / 2, -1, 0, end, low);
    *start = *half = 0;
    for (int k = 0; k < n; k++) {
        *start = fmax(*start, fabs(f->rate[row][k]) * unit);
        *half = fmax(*half, fabs(end[n + k]) * unit);
    }
}

/* a torque grows on an arm: at first its swing to one side equals that to the other, half a period
 * later; then it does not; then it takes two periods, four, eight */
static struct found *cascade(int switches) {
    struct found *f = found_driven(0.5, 0.9, 2.0 / 3);
    f->problem.settle = 50, f->problem.branch = 1, f->problem.vary = PEND_ORBIT_PARAMETER;
    f->problem.by = (struct pend_parameter){PEND_PARAMETER_TERM, f->terms->harmonic[0].at};
    f->problem.to = 1.1;
    f->problem.switches = switches;
    for (int i = 0; i < switches; i++) f->problem.leave[i] = 1;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 8);
    return f;
}

TEST(orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says) {
    static const enum pend_orbits_kind kinds[] = {PEND_ORBITS_SYMMETRY, PEND_ORBITS_DOUBLING};
    double at[5], period = 3 * M_PI;
    for (int switches = 0; switches < 5; switches++) {
        OWN(found, free) *f = cascade(switches);
        int first = switches > 0;
        REQUIRE(f->bifurcations == 1 + first);
        CHECK(f->kind[first] == kinds[first]);
        CHECK(!first || (f->kind[0] == kinds[switches > 1] && f->at[0] == at[switches - 1]));
        at[switches] = f->at[first];
        CHECK(f->value[0] > (first ? at[switches - 1] : 0) && f->stable[0]);
        CHECK(!f->stable[f->rows - 1] && fabs(f->value[f->rows - 1] - 1.1) < 1e-14);
        if (switches > 1) period *= 2;
        for (int i = 0; i < f->rows; i++) {
            CHECK(f->closure[i] < 1e-10 && fabs(f->period[i] / period - 1) < 1e-14);
            double product = f->re[i][0] * f->re[i][1] - f->im[i][0] * f->im[i][1];
            CHECK(fabs(product - exp(-0.5 * period)) < 1e-9);
        }
    }
    // the first of these numbers are near the universal ratio
    CHECK(fabs((at[2] - at[1]) / (at[3] - at[2]) - 4.6692) < 0.02);
    CHECK(fabs((at[3] - at[2]) / (at[4] - at[3]) - 4.6692) < 0.02);
}

TEST(orbits_switch_to_orbits_that_take_two_periods_and_not_one) {
    OWN(found, free) *f = cascade(2);
    for (int i = 0; i < f->rows; i += 4) {
        OWN(found, free) *one = found_driven(0.5, f->value[i], 2.0 / 3);
        one->problem.branch = 0, one->problem.periods = 2, one->problem.settle = 0;
        one->problem.phi = f->phi[i], one->problem.rate = f->rate[i];
        found_search(one);
        // the same orbit is found directly, from its start, as one of two periods
        REQUIRE(one->status == PEND_OK && one->end == PEND_ORBITS_REACHED && one->rows == 1);
        CHECK(fabs(one->phi[0][0] - f->phi[i][0]) < 1e-10 && one->stable[0] == f->stable[i]);
    }
}

/* the two sides of a fork are mirror images, half a period apart */
TEST(orbits_switch_to_both_sides_of_a_fork) {
    OWN(found, free) *f = cascade(1), *g = found_driven(0.5, 0.9, 2.0 / 3);
    g->problem = f->problem;
    g->problem.loads.terms = g->terms, g->problem.loads.value = g->term;
    g->problem.leave[0] = -1;
    found_search(g);
    REQUIRE(g->status == PEND_OK && g->end == PEND_ORBITS_REACHED);
    int last = f->rows - 1, other = g->rows - 1;
    CHECK(fabs(f->phi[last][0] - g->phi[other][0]) > 0.1);
    CHECK(fabs(f->re[last][0] + f->re[last][1] - g->re[other][0] - g->re[other][1]) < 1e-9);
    CHECK(fabs(f->amplitude[last][0] - g->amplitude[other][0]) < 1e-3);
}

/* the fast mode of two arms becomes unstable at large amplitudes; the orbits that replace it are
 * never at rest */
TEST(orbits_switch_to_orbits_that_do_not_rest) {
    for (int mode = 0; mode < 2; mode++) {
        OWN(found, free) *f = found_chain(2, mode, 2.5, 1);
        f->problem.switches = f->problem.leave[0] = 1;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 5);
        CHECK(f->kind[0] == PEND_ORBITS_BRANCH && f->at[0] < f->energy[0]);
        for (int i = 0; i < f->rows; i += 4) {
            double start, half;
            rates_at(f, i, &start, &half);
            CHECK(f->closure[i] < 1e-11 && start > 1e-4 && half > 1e-4);
            CHECK(away_after(f, i, 1, 1) < 1e-11);
            CHECK(away_after(f, i, 0.5, -1) < 1e-11);
            found_check_multipliers(f, i);
        }
        CHECK(f->stable[0] && !f->stable[f->rows - 1]);
    }
}

/* three arms: orbits between two states of rest that are no longer mirror images of each other */
TEST(orbits_switch_to_orbits_between_rests_that_are_no_mirror_images) {
    OWN(found, free) *f = found_chain(3, 1, 2.5, 1);
    f->problem.switches = f->problem.leave[0] = 1;
    found_search(f);
    REQUIRE(f->status == PEND_OK && f->end == PEND_ORBITS_REACHED && f->rows > 10);
    CHECK(f->kind[0] == PEND_ORBITS_SYMMETRY);
    for (int i = 0; i < f->rows; i += 5) {
        double start, half;
        rates_at(f, i, &start, &half);
        CHECK(start == 0 && half < 1e-11 && away_after(f, i, 1, 1) < 1e-11);
        CHECK(away_after(f, i, 0.5, -1) > 1e-3);
        found_check_multipliers(f, i);
    }
}

TEST(orbits_switch_to_twice_the_period_without_a_drive_too) {
    for (int at = 1; at <= 2; at++) {
        OWN(found, free) *f = found_chain(3, 0, 2.5, 1);
        f->problem.switches = 2, f->problem.leave[0] = 1, f->problem.leave[1] = at;
        f->problem.points = 30;
        found_search(f);
        REQUIRE(f->status == PEND_OK && f->rows > 5);
        CHECK(f->kind[0] == PEND_ORBITS_DOUBLING);
        for (int i = 0; i < f->rows; i += 6) {
            CHECK(away_after(f, i, 1, 1) < 1e-10);
            CHECK(away_after(f, i, 0.5, 1) > 1e-4);
            found_check_multipliers(f, i);
        }
    }
}

/* once round, so that bifurcations on the way back are those on the way there */
TEST(orbits_switch_round_a_closed_branch) {
    static const enum pend_orbits_kind kinds[] = {PEND_ORBITS_SYMMETRY, PEND_ORBITS_DOUBLING,
                                                  PEND_ORBITS_DOUBLING, PEND_ORBITS_SYMMETRY};
    for (int side = -1; side <= 1; side += 2) {
        OWN(found, free) *f = found_chain(3, 0, 2.5, 1);
        f->problem.switches = 1, f->problem.leave[0] = side;
        found_search(f);
        CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_CLOSED);
        CHECK_SAYING(f->rows > 30 && f->rows < 80, "%d orbits", f->rows);
        CHECK(fabs(f->energy[f->rows - 1] - f->energy[0]) < 2);
        REQUIRE(f->bifurcations == 7);
        for (int i = 0; i < 4; i++) {
            double apart = fabs(f->at[i] - f->at[6 - i]);
            CHECK(f->kind[i] == kinds[i] && f->kind[6 - i] == kinds[i]);
            CHECK(f->turns[6 - i] == (i % 3 == 0));
            CHECK_SAYING(apart < (i ? 3e-7 : 1e-8), "bifurcation %d: %g J apart", i, apart);
        }
    }
}

/* searches to the end, in a new search after every `each` steps, into which the last checkpoint was
 * restored; returns their number */
static int orbits_in_turns(const struct found *f, long each, struct found *g) {
    struct pend_orbits *search = NULL, *next;
    struct pend_error error;
    enum pend_orbits_found what = PEND_ORBITS_NOTHING;
    long steps, begun = 0;
    int turns = 0;
    if (!CHECK(pend_orbits_new(&search, &f->problem, &error) == PEND_OK)) return 0;
    g->rows = 0;
    while (what != PEND_ORBITS_END) {
        if (!CHECK(pend_orbits_next(search, &what, &error) == PEND_OK)) break;
        if (what == PEND_ORBITS_ORBIT && CHECK(g->rows < FOUND_ROWS)) {
            struct pend_orbit orbit = pend_orbits_orbit(search);
            g->phi[g->rows][0] = orbit.phi[0], g->rate[g->rows][0] = orbit.rate[0];
            g->amplitude[g->rows][0] = orbit.amplitude[0];
            g->period[g->rows] = orbit.period, g->energy[g->rows++] = orbit.energy;
        }
        if (!pend_orbits_rests(search, &steps) || steps < begun + each) continue;
        struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
        CHECK(pend_orbits_carry(search, &checkpoint) == PEND_OK);
        char *bytes = malloc(checkpoint.used);
        checkpoint = (struct pend_checkpoint){
            .way = PEND_CHECKPOINT_TAKE, .at = bytes, .bytes = checkpoint.used};
        CHECK(bytes && pend_orbits_carry(search, &checkpoint) == PEND_OK);
        long maps, done = pend_orbits_steps(search, &maps), same;
        pend_orbits_free(&search);
        if (!CHECK(pend_orbits_new(&next, &f->problem, &error) == PEND_OK)) break;
        checkpoint.way = PEND_CHECKPOINT_PUT, checkpoint.used = 0;
        CHECK(pend_orbits_carry(next, &checkpoint) == PEND_OK);
        CHECK(pend_checkpoint_whole(&checkpoint));
        CHECK(pend_orbits_steps(next, &same) == done && same == maps);
        free(bytes);
        search = next, begun = steps, turns++;
    }
    g->end = pend_orbits_end(search);
    pend_orbits_free(&search);
    return turns;
}

TEST(orbits_switch_with_the_same_bits_after_any_number_of_checkpoints) {
    for (int i = 0; i < 4; i++) {
        OWN(found, free) *f = i == 2  ? cascade(2)
                              : i < 2 ? found_chain(2, 1, 2.2, 1)
                                      : found_trunk(4, 2, 2.2, 1);
        OWN(found, free) *g = found_chain(1, 0, 1, 1);
        if (i == 1) f->problem.switches = f->problem.leave[0] = 1;
        found_search(f);
        CHECK(orbits_in_turns(f, 1 + 2 * (i % 3), g) > 5);
        CHECK(g->rows == f->rows && g->end == f->end && f->rows > 5);
        for (int row = 0; row < f->rows; row++) {
            CHECK(g->phi[row][0] == f->phi[row][0] && g->rate[row][0] == f->rate[row][0]);
            CHECK(g->period[row] == f->period[row] && g->energy[row] == f->energy[row]);
            CHECK(g->amplitude[row][0] == f->amplitude[row][0]);
        }
    }
}

TEST(orbits_switch_nowhere_where_no_branch_begins) {
    // there is one bifurcation
    OWN(found, free) *f = found_chain(2, 1, 2, 1);
    f->problem.switches = 1, f->problem.leave[0] = 2;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_MISSING && f->rows == 0);
    found_free(&f);
    // at a fold no other branch begins
    f = found_driven(0.05, 0.06, 0.5);
    f->problem.branch = 1, f->problem.vary = PEND_ORBIT_OMEGA, f->problem.to = 1.2;
    f->problem.switches = f->problem.leave[0] = 1;
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_APART && f->rows == 0);
    CHECK(f->bifurcations == 1 && f->kind[0] == PEND_ORBITS_FOLD);
    found_free(&f);
    // more than eight periods
    f = found_driven(0.5, 0.9, 2.0 / 3);
    f->problem.settle = 50, f->problem.branch = 1, f->problem.vary = PEND_ORBIT_PARAMETER;
    f->problem.by = (struct pend_parameter){PEND_PARAMETER_TERM, f->terms->harmonic[0].at};
    f->problem.to = 1.1, f->problem.switches = 5;
    for (int i = 0; i < 5; i++) f->problem.leave[i] = 1;
    found_search(f);
    f->problem.leave[0] = -1; // mirror images
    found_search(f);
    CHECK(f->status == PEND_OK && f->end == PEND_ORBITS_APART && f->rows == 0);
    CHECK(f->bifurcations == 1 && f->kind[0] == PEND_ORBITS_DOUBLING);
}

TEST(orbits_switch_in_spite_of_any_allocation_that_fails) {
    OWN(found, free) *f = found_chain(2, 1, 2, 1);
    long failed = 0;
    f->problem.switches = f->problem.leave[0] = 1;
    f->problem.step = 0.4, f->problem.points = 30;
    for (long at = 1;; at += 1 + at / 8) {
        test_alloc_fail(at, 0);
        found_search(f);
        test_alloc_faults_off();
        if (f->status == PEND_OK) break;
        CHECK(f->status == PEND_NO_MEMORY);
        failed++;
    }
    CHECK(failed > 20 && f->rows >= 2);
}
