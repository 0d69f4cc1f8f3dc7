#include "core/integrate/run/run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* a random tree, with randomly numbered arms so that the caller's order differs from the stored
 * one, and a problem with it */
struct bench {
    struct test_tree tree;
    struct pend_problem problem;
};

static void bench_init(struct bench *bench, int n, unsigned long long seed) {
    test_tree_random(&bench->tree, TEST_TREE_ATTACHED, n, 0.3, &seed);
    bench->problem =
        (struct pend_problem){.tree = bench->tree.tree,
                              .loads.gravity = 9.81,
                              .phi = bench->tree.phi,
                              .rate = bench->tree.rate,
                              .times = {.count = 31, .start = 2, .span = 0.75, .divisor = 30}};
}

static void bench_clear(struct bench *bench) { test_tree_clear(&bench->tree); }

/* ---- what is handed out */

TEST(run_hands_out_every_instant_once_and_in_order) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 1);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) record;
        test_record(&record, method->name, &bench.problem);
        CHECK_INT(record.status, PEND_OK);
        CHECK_INT(record.samples.count, 31);
        CHECK_INT(record.calls, 1);
        int right = 0;
        for (long i = 0; i < record.samples.count; i++)
            right += record.samples.t[i] == pend_times_at(&bench.problem.times, i);
        CHECK_INT(right, 31);
        CHECK_TEXT(record.stats.method, method->name);
        CHECK(record.stats.steps >= 1);
    }
}

TEST(run_begins_with_the_start_itself_in_the_callers_order) {
    OWN(bench, clear) bench;
    bench_init(&bench, 7, 3);
    const struct pend_method *method;
    int moved = 0;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) record;
        test_record(&record, method->name, &bench.problem);
        REQUIRE(record.status == PEND_OK);
        for (int k = 0; k < 7; k++) {
            int arm = bench.tree.tree->order[k];
            CHECK(record.samples.phi[arm] == bench.tree.phi[k]);
            CHECK(record.samples.rate[arm] == bench.tree.rate[k]);
            moved |= arm != k;
        }
    }
    CHECK(moved);
}

/* row i of a record, in stored order */
static void row_stored(const struct test_record *record, const struct pend_tree *tree,
                       const double rows[], long i, double row[]) {
    for (int k = 0; k < tree->n; k++) row[k] = rows[i * record->n + tree->order[k]];
}

/* largest error of the quantities that follow from phi and rate at every sample, relative to the
 * largest of the same kind */
struct derived {
    double acc, force, position, velocity, energy;
};

enum { DERIVED_ARMS = 6 };

static struct derived derived_gap(const struct test_record *record,
                                  const struct pend_problem *problem) {
    const struct pend_tree *tree = problem->tree;
    int n = tree->n;
    struct derived worst = {0, 0, 0, 0, 0};
    double phi[DERIVED_ARMS], rate[DERIVED_ARMS], got[DERIVED_ARMS], re[DERIVED_ARMS],
        im[DERIVED_ARMS];
    double acc[DERIVED_ARMS], force[DERIVED_ARMS];
    OWN_MEMORY void *work = aligned_alloc(64, (pend_dynamics_work_bytes(n) + 63) / 64 * 64);
    if (!work) abort();
    for (long i = 0; i < record->samples.count; i++) {
        row_stored(record, tree, record->samples.phi, i, phi);
        row_stored(record, tree, record->samples.rate, i, rate);
        pend_dynamics(tree, &problem->loads, phi, rate, work, acc, force);
        row_stored(record, tree, record->samples.acc, i, got);
        worst.acc = fmax(worst.acc, test_gap(n, got, acc));
        row_stored(record, tree, record->samples.force, i, got);
        worst.force = fmax(worst.force, test_gap(n, got, force));
        pend_kinematics_position(tree, phi, re, im);
        row_stored(record, tree, record->samples.z_re, i, got);
        worst.position = fmax(worst.position, test_gap(n, got, re));
        row_stored(record, tree, record->samples.z_im, i, got);
        worst.position = fmax(worst.position, test_gap(n, got, im));
        pend_kinematics_velocity(tree, phi, rate, re, im);
        row_stored(record, tree, record->samples.zd_re, i, got);
        worst.velocity = fmax(worst.velocity, test_gap(n, got, re));
        row_stored(record, tree, record->samples.zd_im, i, got);
        worst.velocity = fmax(worst.velocity, test_gap(n, got, im));
        struct pend_energy energy = pend_kinematics_energy(tree, &problem->loads, phi, rate);
        worst.energy = fmax(worst.energy, fabs(record->samples.kinetic[i] - energy.kinetic));
        worst.energy = fmax(worst.energy, fabs(record->samples.potential[i] - energy.potential));
    }
    return worst;
}

TEST(run_derives_everything_from_the_state_at_the_instant) {
    OWN(bench, clear) bench;
    bench_init(&bench, DERIVED_ARMS, 5);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) record;
        test_record(&record, method->name, &bench.problem);
        REQUIRE(record.status == PEND_OK);
        struct derived gap = derived_gap(&record, &bench.problem);
        CHECK_SAYING(gap.position == 0 && gap.velocity == 0 && gap.energy == 0, "%s", method->name);
        if (!(method->flags & (PEND_METHOD_LINEAR | PEND_METHOD_SERIES)))
            CHECK(gap.acc == 0 && gap.force == 0);
        if (method->flags & PEND_METHOD_SERIES) CHECK_RESIDUAL(gap.acc, 1e-10, method->name);
        if (method->flags & PEND_METHOD_SERIES) CHECK_RESIDUAL(gap.force, 1e-11, method->name);
    }
}

/* the arrays of a block, all or one of them */
enum {
    WANT_PHI,
    WANT_RATE,
    WANT_ACC,
    WANT_FORCE,
    WANT_Z_RE,
    WANT_Z_IM,
    WANT_ZD_RE,
    WANT_ZD_IM,
    WANT_KINETIC,
    WANT_COUNT
};

static double **want_at(struct pend_samples *samples, int i) {
    double **const array[WANT_COUNT] = {&samples->phi,   &samples->rate,  &samples->acc,
                                        &samples->force, &samples->z_re,  &samples->z_im,
                                        &samples->zd_re, &samples->zd_im, &samples->kinetic};
    return array[i];
}

TEST(run_gives_the_same_bits_whatever_else_is_wanted) {
    enum { ARMS = 4, COUNT = 31 };
    OWN(bench, clear) bench;
    bench_init(&bench, ARMS, 7);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) all;
        test_record(&all, method->name, &bench.problem);
        for (int want = 0; want < WANT_COUNT; want++) {
            double t[COUNT], out[COUNT * ARMS];
            struct pend_samples one = {.cap = COUNT, .t = t};
            OWN(pend_run, free) *run;
            int done;
            *want_at(&one, want) = out;
            REQUIRE(pend_run_new(&run, method, &bench.problem, NULL) == PEND_OK);
            CHECK_INT(pend_run_next(run, &one, INFINITY, &done, NULL), PEND_OK);
            CHECK(done);
            size_t values = want == WANT_KINETIC ? COUNT : COUNT * ARMS;
            CHECK_SAYING(!memcmp(out, *want_at(&all.samples, want), values * sizeof(double)),
                         "%s, array %d", method->name, want);
        }
    }
}

TEST(run_leaves_what_is_of_a_cart_alone_where_there_is_none) {
    enum { COUNT = 31 };
    OWN(bench, clear) bench;
    OWN(pend_run, free) *run;
    struct pend_error error = {.text = ""};
    double t[COUNT], cart[3][COUNT];
    int done = 0, left = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < COUNT; k++) cart[i][k] = NAN;
    struct pend_samples samples = {.cap = COUNT,
                                   .t = t,
                                   .cart_place = cart[0],
                                   .cart_speed = cart[1],
                                   .cart_reaction = cart[2]};
    bench_init(&bench, 3, 5);
    REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &bench.problem, &error) == PEND_OK);
    while (!done && CHECK_SAYING(pend_run_next(run, &samples, 1e9, &done, &error) == PEND_OK, "%s",
                                 error.text))
        ;
    CHECK_INT(samples.count, COUNT);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < COUNT; k++) left += isnan(cart[i][k]) != 0;
    CHECK_INT(left, 3 * COUNT);
}

TEST(run_works_for_a_single_instant) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 9);
    bench.problem.times = (struct pend_times){.count = 1, .start = -4, .span = 0, .divisor = 1};
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) record;
        test_record(&record, method->name, &bench.problem);
        CHECK_INT(record.status, PEND_OK);
        CHECK_INT(record.samples.count, 1);
        CHECK(record.samples.t[0] == -4);
        CHECK_INT(record.stats.steps, 0);
        CHECK(record.stats.progress == 1);
    }
}

/* from rest the motion backwards equals the motion forwards, and every operation on the way is
 * mirrored too */
TEST(run_goes_backwards_from_rest_as_it_goes_forwards) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 11);
    for (int k = 0; k < 5; k++) bench.tree.rate[k] = 0;
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) forth, back;
        bench.problem.times = (struct pend_times){.count = 31, .span = 0.75, .divisor = 30};
        test_record(&forth, method->name, &bench.problem);
        bench.problem.times.span = -0.75;
        test_record(&back, method->name, &bench.problem);
        CHECK_INT(back.status, PEND_OK);
        CHECK(back.samples.t[30] == -0.75);
        double odd = 0, even = 0;
        for (int i = 0; i < 31 * 5; i++) {
            even = fmax(even, fabs(forth.samples.phi[i] - back.samples.phi[i]));
            odd = fmax(odd, fabs(forth.samples.rate[i] + back.samples.rate[i]));
        }
        CHECK_SAYING(even < 1e-14 && odd < 1e-13, "%s: %g %g", method->name, even, odd);
    }
}

/* ---- blocks, work, progress */

TEST(run_gives_the_same_bits_however_the_blocks_are_cut) {
    static const long block[] = {1, 2, 7, 30, 200};
    static const double work[] = {0, 50, 1e3, INFINITY};
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 13);
    bench.problem.times = (struct pend_times){.count = 201, .start = 1, .span = 2, .divisor = 200};
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) whole;
        test_record(&whole, method->name, &bench.problem);
        CHECK_INT(whole.samples.count, 201);
        for (int i = 0; i < 20; i++) {
            OWN(test_record, clear) cut;
            test_record_blocks(&cut, method, &bench.problem, block[i % 5], work[i / 5]);
            CHECK_SAYING(test_record_same(&whole, &cut), "%s in blocks of %ld, work %g",
                         method->name, block[i % 5], work[i / 5]);
            CHECK(cut.stats.energy_drift == whole.stats.energy_drift);
        }
    }
}

TEST(run_comes_back_when_its_work_is_used_up) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 15);
    bench.problem.times = (struct pend_times){.count = 2, .span = 3, .divisor = 1};
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        if (method->flags & PEND_METHOD_LINEAR) continue;
        OWN(test_record, clear) small, large;
        test_record_blocks(&small, method, &bench.problem, 2, 0);
        test_record_blocks(&large, method, &bench.problem, 2, 1000);
        double total = (double)large.stats.evaluations * 5, share = total / (double)large.calls;
        CHECK_SAYING(small.calls >= small.stats.steps, "%s: %ld calls, %ld steps", method->name,
                     small.calls, small.stats.steps);
        CHECK_SAYING(share > 400 && share < 1600, "%s: %g a call", method->name, share);
    }
}

/* many instants in one step count as work too */
TEST(run_comes_back_between_groups_of_samples) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 17);
    bench.problem.times = (struct pend_times){.count = 10000, .span = 3, .divisor = 9999};
    OWN(test_record, clear) record;
    test_record_blocks(&record, pend_method_find("linear"), &bench.problem, 10000, 0);
    CHECK_INT(record.samples.count, 10000);
    CHECK(record.calls > 100);
}

TEST(run_progress_rises_from_nothing_to_all) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 19);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        double t[4], before = 0;
        struct pend_samples samples = {.cap = 4, .t = t};
        OWN(pend_run, free) *run;
        int done = 0, rises = 1;
        REQUIRE(pend_run_new(&run, method, &bench.problem, NULL) == PEND_OK);
        CHECK(pend_run_stats(run).progress == 0);
        while (!done) {
            REQUIRE(pend_run_next(run, &samples, 100, &done, NULL) == PEND_OK);
            double now = pend_run_stats(run).progress;
            rises &= now >= before && now <= 1;
            before = now;
        }
        CHECK(rises);
        CHECK(before == 1);
    }
}

TEST(run_allocates_nothing_while_it_goes) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 21);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        double t[31];
        struct pend_samples samples = {.cap = 31, .t = t};
        OWN(pend_run, free) *run;
        int done;
        REQUIRE(pend_run_new(&run, method, &bench.problem, NULL) == PEND_OK);
        long before = test_alloc_count();
        CHECK_INT(pend_run_next(run, &samples, INFINITY, &done, NULL), PEND_OK);
        CHECK_INT(test_alloc_count(), before);
        pend_run_free(&run);
        CHECK(!run);
    }
}

/* ---- the energy's drift */

/* if every step ends at a requested instant, the drift is the largest over the samples */
TEST(run_measures_the_drift_at_every_step) {
    OWN(bench, clear) bench;
    bench_init(&bench, 4, 23);
    bench.problem.times = (struct pend_times){.count = 401, .span = 0.4, .divisor = 400};
    bench.problem.rtol = 1e-6;
    bench.problem.atol = 1e-6;
    OWN(test_record, clear) record;
    test_record(&record, "rkf45", &bench.problem);
    CHECK_INT(record.stats.steps, 400);
    double drift = 0, start = record.samples.kinetic[0] + record.samples.potential[0];
    double scale =
        pend_kinematics_energy_scale(bench.tree.tree, TEST_LOADS(9.81), record.samples.kinetic[0]);
    for (long i = 0; i < 401; i++)
        drift = fmax(drift,
                     fabs(record.samples.kinetic[i] + record.samples.potential[i] - start) / scale);
    CHECK(drift > 1e-16);
    CHECK(record.stats.energy_drift == drift);
    test_record_clear(&record);
    test_record(&record, "linear", &bench.problem);
    CHECK(record.stats.energy_drift == 0);
}

TEST(run_drift_is_nought_where_nobody_asks_and_all_else_is_the_same) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 27);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(test_record, clear) asked, unasked;
        bench.problem.no_drift = 0;
        test_record(&asked, method->name, &bench.problem);
        bench.problem.no_drift = 1;
        test_record(&unasked, method->name, &bench.problem);
        CHECK(unasked.stats.energy_drift == 0);
        CHECK(method->flags & PEND_METHOD_LINEAR || asked.stats.energy_drift > 0);
        CHECK(test_record_same(&asked, &unasked));
        CHECK_INT(unasked.stats.steps, asked.stats.steps);
    }
}

TEST(run_drift_is_nought_where_there_is_no_energy) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 25);
    bench.problem.loads.gravity = 0;
    for (int k = 0; k < 3; k++) bench.tree.rate[k] = 0;
    OWN(test_record, clear) record;
    test_record(&record, "rk8pd", &bench.problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK(record.stats.energy_drift == 0);
    CHECK(record.samples.phi[30 * 3] == record.samples.phi[0]);
}

/* ---- what is refused */

static void check_refused(const struct pend_method *method, const struct pend_problem *problem,
                          const char *word) {
    struct pend_run *run = (struct pend_run *)1;
    struct pend_error error = {.text = ""};
    CHECK_INT(pend_run_new(&run, method, problem, &error), PEND_INVALID);
    CHECK(!run);
    CHECK_SAYING(strstr(error.text, word), "\"%s\" does not say \"%s\"", error.text, word);
    CHECK_INT(pend_run_new(&run, method, problem, NULL), PEND_INVALID);
}

static void check_times_refused(struct bench *bench, struct pend_times times, const char *word) {
    struct pend_problem problem = bench->problem;
    problem.times = times;
    check_refused(pend_method_at(0), &problem, word);
}

TEST(run_refuses_times_that_are_not_strictly_monotonic) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 27);
    check_times_refused(&bench, (struct pend_times){.count = 3, .list = (double[]){0, 1, 1}},
                        "instant 3 (1 s)");
    check_times_refused(&bench, (struct pend_times){.count = 3, .list = (double[]){0, 0, 1}},
                        "instant 2 (0 s)");
    check_times_refused(&bench, (struct pend_times){.count = 3, .list = (double[]){0, 2, 1}},
                        "instant 3 (1 s)");
    check_times_refused(
        &bench, (struct pend_times){.count = 4, .list = (double[]){0, -1, -0.5, -2}}, "instant 3");
    check_times_refused(&bench, (struct pend_times){.count = 2, .list = (double[]){5, 5}},
                        "strictly");
    check_times_refused(
        &bench, (struct pend_times){.count = 2, .start = 1, .span = 0, .divisor = 1}, "strictly");
    /* a grid finer than the spacing of doubles at 1e9 s */
    check_times_refused(
        &bench, (struct pend_times){.count = 101, .start = 1e9, .span = 1e-6, .divisor = 100},
        "strictly");
}

TEST(run_accepts_a_grid_as_fine_as_the_numbers) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 29);
    bench.problem.times =
        (struct pend_times){.count = 5, .start = 1, .span = 4 * 0x1p-52, .divisor = 4};
    OWN(test_record, clear) record;
    test_record(&record, "taylor", &bench.problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK_INT(record.samples.count, 5);
}

TEST(run_refuses_times_that_are_not_finite) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 31);
    check_times_refused(&bench, (struct pend_times){.count = 0, .span = 1, .divisor = 1},
                        "at least one");
    check_times_refused(&bench, (struct pend_times){.count = 3, .list = (double[]){0, NAN, 1}},
                        "finite");
    check_times_refused(&bench, (struct pend_times){.count = 2, .list = (double[]){0, INFINITY}},
                        "finite");
    check_times_refused(
        &bench, (struct pend_times){.count = 2, .start = NAN, .span = 1, .divisor = 1}, "finite");
    check_times_refused(&bench, (struct pend_times){.count = 2, .span = INFINITY, .divisor = 1},
                        "finite");
    check_times_refused(&bench, (struct pend_times){.count = 2, .span = 1, .divisor = 0},
                        "divisor");
    check_times_refused(&bench, (struct pend_times){.count = 2, .span = 1, .divisor = NAN},
                        "finite");
    check_times_refused(&bench, (struct pend_times){.count = 2, .list = (double[]){-1e308, 1e308}},
                        "too long");
}

TEST(run_refuses_tolerances_out_of_the_methods_range) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 33);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
        const double bad_rtol[] = {-1e-6, method->rtol_min / 2, method->rtol_max * 2, NAN,
                                   INFINITY};
        const double bad_atol[] = {-1e-6, method->atol_max * 2, NAN, INFINITY};
        for (int i = 0; i < 5; i++) {
            struct pend_problem problem = bench.problem;
            problem.rtol = bad_rtol[i];
            check_refused(method, &problem, "rtol");
        }
        for (int i = 0; i < 4; i++) {
            struct pend_problem problem = bench.problem;
            problem.atol = bad_atol[i];
            check_refused(method, &problem, "atol");
        }
    }
}

TEST(run_refuses_a_start_or_gravity_that_is_not_finite) {
    OWN(bench, clear) bench;
    bench_init(&bench, 3, 35);
    bench.tree.phi[1] = NAN;
    check_refused(pend_method_at(0), &bench.problem, "start of arm");
    bench.tree.phi[1] = 0;
    bench.tree.rate[2] = -INFINITY;
    check_refused(pend_method_at(0), &bench.problem, "start of arm");
    bench.tree.rate[2] = 0;
    bench.problem.loads.gravity = NAN;
    check_refused(pend_method_at(0), &bench.problem, "gravity");
    bench.problem.loads.gravity = 9.81;
    bench.problem.step_cap = -1;
    check_refused(pend_method_at(0), &bench.problem, "step limit");
    bench.problem.step_cap = 0;
    bench.problem.loads.gravity = 0;
    check_refused(pend_method_find("linear"), &bench.problem, "gravity");
}

/* ---- how a run fails */

TEST(run_stops_at_its_step_limit_and_stays_stopped) {
    OWN(bench, clear) bench;
    bench_init(&bench, 4, 37);
    bench.problem.times =
        (struct pend_times){.count = 101, .start = 10, .span = 50, .divisor = 100};
    bench.problem.step_cap = 20;
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        double t[101];
        struct pend_samples samples = {.cap = 101, .t = t};
        OWN(pend_run, free) *run = NULL;
        struct pend_error error, again;
        int done;
        if (method->flags & PEND_METHOD_LINEAR) continue;
        REQUIRE(pend_run_new(&run, method, &bench.problem, NULL) == PEND_OK);
        CHECK_INT(pend_run_next(run, &samples, INFINITY, &done, &error), PEND_TOO_MANY_STEPS);
        CHECK(!done);
        CHECK_INT(pend_run_stats(run).steps, 20);
        CHECK(samples.count >= 1 && samples.count < 101);
        CHECK_SAYING(error.time >= t[samples.count - 1] && error.time < t[samples.count - 1] + 0.5,
                     "%s: %g", method->name, error.time);
        CHECK(strstr(error.text, "limit of 20 steps"));
        CHECK_INT(pend_run_next(run, &samples, INFINITY, &done, &again), PEND_TOO_MANY_STEPS);
        CHECK_INT(samples.count, 0);
        CHECK_TEXT(again.text, error.text);
    }
}

/* the squares of such rates overflow; only a method that scales its time could continue, by 1e-200
 * s per step */
TEST(run_ends_where_numbers_overflow_and_says_when) {
    OWN(bench, clear) bench;
    bench_init(&bench, 4, 39);
    bench.problem.step_cap = 1000;
    for (int k = 0; k < 4; k++) bench.tree.rate[k] = 1e200;
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        double t[31];
        struct pend_samples samples = {.cap = 31, .t = t};
        OWN(pend_run, free) *run = NULL;
        struct pend_error error;
        int done;
        if (method->flags & PEND_METHOD_LINEAR) continue;
        enum pend_status status = pend_run_new(&run, method, &bench.problem, &error);
        if (!CHECK_INT(status, PEND_OK)) continue;
        status = pend_run_next(run, &samples, INFINITY, &done, &error);
        enum pend_status want =
            method->flags & PEND_METHOD_SERIES ? PEND_STEP_TOO_SMALL : PEND_NOT_FINITE;
        CHECK_SAYING(status == want, "%s: %s", method->name, error.text);
        CHECK_INT(samples.count, 1);
        CHECK(error.code == status && error.time >= 2 && error.time < 2.1);
        CHECK_SAYING(strstr(error.text, "at t = 2 s"), "%s", error.text);
    }
}

/* the end of one block of a run of a single arm */
struct outcome {
    enum pend_status status;
    long count;
    struct pend_error error;
};

static struct outcome outcome_of(double length, double gravity, double rate, long count,
                                 struct pend_samples samples) {
    const int parent = -1;
    const double mass = 1, phi = 1;
    double t[11];
    struct outcome outcome = {.status = PEND_BUG, .error = {.text = ""}};
    OWN(pend_tree, free) *tree;
    OWN(pend_run, free) *run = NULL;
    int done;
    if (pend_tree_new(&tree, 1, &length, &mass, &parent, NULL) != PEND_OK) return outcome;
    struct pend_problem problem = {.tree = tree,
                                   .loads.gravity = gravity,
                                   .phi = &phi,
                                   .rate = &rate,
                                   .times = {.count = count, .span = 1, .divisor = 10}};
    samples.cap = 11;
    samples.t = t;
    if (pend_run_new(&run, pend_method_find("rk8pd"), &problem, NULL) == PEND_OK)
        outcome.status = pend_run_next(run, &samples, INFINITY, &done, &outcome.error);
    outcome.count = samples.count;
    return outcome;
}

/* ---- from one process to another */

/* the same problem carried after every block and nearly every step, and in one run, bit for bit */
static void carried_is_whole(const struct pend_method *method, const struct pend_problem *problem,
                             long block) {
    OWN(test_record, clear) whole, carried;
    test_record_blocks(&whole, method, problem, problem->times.count, INFINITY);
    test_record_carried(&carried, method, problem, block, 1);
    CHECK_INT(whole.status, PEND_OK);
    CHECK_INT(carried.status, PEND_OK);
    CHECK_SAYING(carried.calls > 5, "%s was carried %ld times", method->name, carried.calls);
    CHECK_SAYING(test_record_same(&whole, &carried), "%s is another one when carried",
                 method->name);
    CHECK_INT(carried.stats.steps, whole.stats.steps);
    CHECK_INT(carried.stats.rejected, whole.stats.rejected);
    CHECK_INT(carried.stats.evaluations, whole.stats.evaluations);
    CHECK(carried.stats.energy_drift == whole.stats.energy_drift);
}

TEST(run_carried_after_every_step_hands_out_the_same_bits) {
    const struct pend_method *method;
    int arms[] = {1, 5, 19}, carries = 0;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        if (!pend_run_carries(method)) CHECK_TEXT(method->name, "msadams");
        carries += pend_run_carries(method);
        for (int i = 0; i < 6 && pend_run_carries(method); i++) {
            OWN(bench, clear) bench;
            bench_init(&bench, arms[i % 3], 50 + (unsigned long long)i);
            if (i >= 3) bench.problem.times.span = -bench.problem.times.span;
            if (method == pend_method_find("ode23")) bench.problem.rtol = 1e-5;
            carried_is_whole(method, &bench.problem, 1 + i % 4);
            if (method->extended) carried_is_whole(method->extended, &bench.problem, 1 + i % 4);
        }
    }
    CHECK_INT(carries, 7);
}

TEST(run_does_not_go_on_from_what_is_not_its_own) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 61);
    OWN(pend_run, free) *run;
    double t[31];
    struct pend_samples samples = {.cap = 7, .t = t};
    int done;
    REQUIRE(pend_run_new(&run, &pend_method_taylor, &bench.problem, NULL) == PEND_OK);
    CHECK(pend_run_next(run, &samples, INFINITY, &done, NULL) == PEND_OK && !done);
    struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
    CHECK(pend_run_carry(run, &checkpoint) == PEND_OK);
    OWN_MEMORY char *bytes = malloc(checkpoint.used);
    REQUIRE(bytes);
    size_t all = checkpoint.used;
    /* every wrong length is detected */
    for (size_t less = 0; less < all; less += 7) {
        checkpoint =
            (struct pend_checkpoint){.way = PEND_CHECKPOINT_TAKE, .bytes = less, .at = bytes};
        CHECK(pend_run_carry(run, &checkpoint) == PEND_OK && !pend_checkpoint_whole(&checkpoint) &&
              checkpoint.used == all);
    }
    checkpoint = (struct pend_checkpoint){.way = PEND_CHECKPOINT_TAKE, .bytes = all, .at = bytes};
    CHECK(pend_run_carry(run, &checkpoint) == PEND_OK && pend_checkpoint_whole(&checkpoint));
    /* `next`, the second part of the error */
    long next = 1000;
    memcpy(bytes + sizeof(double), &next, sizeof next);
    checkpoint = (struct pend_checkpoint){.way = PEND_CHECKPOINT_PUT, .bytes = all, .at = bytes};
    CHECK_INT(pend_run_carry(run, &checkpoint), PEND_INVALID);
}

/* Saves a run half-way, restores it with some bytes altered and continues: for any bytes it is
 * refused, or continues, or fails with a reason. Returns how many were refused. */
static long altered_are_harmless(const struct pend_method *method,
                                 const struct pend_problem *problem) {
    static const long long alter[] = {-1, 12345, 0x7fffffff, 0x7fffffffffffffff,
                                      -0x7fffffffffffffff - 1};
    enum { ALTERS = sizeof alter / sizeof *alter };
    double t[64];
    struct pend_samples samples = {.cap = 7, .t = t};
    struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
    struct pend_run *run;
    long refused = 0;
    int done;
    if (!CHECK(pend_run_new(&run, method, problem, NULL) == PEND_OK)) return 0;
    CHECK(pend_run_next(run, &samples, INFINITY, &done, NULL) == PEND_OK && !done);
    CHECK(pend_run_carry(run, &checkpoint) == PEND_OK);
    size_t bytes = checkpoint.used;
    char *whole = malloc(bytes), *altered = malloc(bytes);
    checkpoint = (struct pend_checkpoint){.way = PEND_CHECKPOINT_TAKE, .bytes = bytes, .at = whole};
    CHECK(whole && altered && pend_run_carry(run, &checkpoint) == PEND_OK &&
          pend_checkpoint_whole(&checkpoint));
    pend_run_free(&run);
    for (size_t at = 0; at < bytes; at++)
        for (size_t i = 0; i < (at % 8 ? 1 : ALTERS + 1); i++) {
            size_t size = at % 8 ? sizeof(int) : sizeof alter[0];
            memcpy(altered, whole, bytes);
            if (i == ALTERS || at % 4)
                altered[at] = (char)~altered[at];
            else
                memcpy(altered + at, &alter[i], size < bytes - at ? size : bytes - at);
            if (pend_run_new(&run, method, problem, NULL) != PEND_OK) continue;
            checkpoint =
                (struct pend_checkpoint){.way = PEND_CHECKPOINT_PUT, .bytes = bytes, .at = altered};
            int good =
                pend_run_carry(run, &checkpoint) == PEND_OK && pend_checkpoint_whole(&checkpoint);
            refused += !good;
            for (int turn = 0; good && turn < 3; turn++)
                good = pend_run_next(run, &samples, 200, &done, NULL) == PEND_OK && !done;
            pend_run_free(&run);
        }
    free(whole);
    free(altered);
    return refused;
}

TEST(run_put_back_from_altered_bytes_is_refused_or_goes_on) {
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++) {
        OWN(bench, clear) bench = {0};
        if (!pend_run_carries(method)) continue;
        bench_init(&bench, 3, 61);
        bench.problem.step_cap = 100000;
        if (method->flags & PEND_METHOD_FIXED_STEP) bench.problem.step = 0.02;
        CHECK_SAYING(altered_are_harmless(method, &bench.problem) > 10, "%s refuses nothing",
                     method->name);
        if (method->extended) CHECK(altered_are_harmless(method->extended, &bench.problem) > 10);
    }
}

/* a motion may be finite while derived quantities are not: energy is proportional to the square of
 * the length */
TEST(run_hands_out_no_number_that_is_not_finite) {
    double x[11], y[11];
    struct outcome outcome = outcome_of(1e200, 0, 1, 11, (struct pend_samples){.rate = x});
    CHECK_INT(outcome.status, PEND_OK);
    CHECK_INT(outcome.count, 11);
    outcome = outcome_of(1e200, 0, 1, 11, (struct pend_samples){.kinetic = x});
    CHECK_INT(outcome.status, PEND_NOT_FINITE);
    CHECK_INT(outcome.count, 0);
    CHECK_INT(outcome.error.arm, -1);
    CHECK_TEXT(outcome.error.text, "at t = 0 s: the energy is too large a number");
    outcome = outcome_of(1, 0, 1e200, 1, (struct pend_samples){.rate = x});
    CHECK_INT(outcome.status, PEND_OK);
    outcome = outcome_of(1, 0, 1e200, 1, (struct pend_samples){.force = x});
    CHECK_INT(outcome.status, PEND_NOT_FINITE);
    CHECK_INT(outcome.error.arm, 0);
    CHECK_TEXT(outcome.error.text, "at t = 0 s: the force of arm 1 is too large a number");
    // it rises until its height times its weight overflows: the earlier rows remain valid
    outcome = outcome_of(1.4e155, 1.4e153, 1, 11, (struct pend_samples){.rate = x, .potential = y});
    CHECK_INT(outcome.status, PEND_NOT_FINITE);
    CHECK_INT(outcome.count, 2);
    CHECK_TEXT(outcome.error.text, "at t = 0.2 s: the energy is too large a number");
}

TEST(run_fails_cleanly_without_memory) {
    OWN(bench, clear) bench;
    bench_init(&bench, 5, 41);
    const struct pend_method *method;
    for (int m = 0; (method = pend_method_at(m)); m++)
        for (int for_good = 0; for_good < 2; for_good++) {
            enum pend_status status = PEND_NO_MEMORY;
            long count = 1;
            for (; status != PEND_OK && count < 50; count++) {
                struct pend_run *run = (struct pend_run *)1;
                struct pend_error error = {.text = ""};
                test_alloc_fail(count, for_good);
                status = pend_run_new(&run, method, &bench.problem, &error);
                test_alloc_faults_off();
                if (status == PEND_OK) {
                    pend_run_free(&run);
                    continue;
                }
                CHECK_INT(status, PEND_NO_MEMORY);
                CHECK_INT(error.code, PEND_NO_MEMORY);
                CHECK(!run && strstr(error.text, "memory"));
            }
            CHECK_SAYING(count > 3 && count < 50, "%s: %ld", method->name, count);
        }
}

TEST(run_names_the_mass_or_length_that_is_too_small) {
    const double small[] = {1, 5e-324}, one[] = {1, 1}, phi[] = {1, 1}, rate[] = {0, 0};
    const int parent[] = {-1, 0};
    for (int i = 0; i < 2; i++) {
        OWN(pend_tree, free) *tree;
        struct pend_error error;
        struct pend_run *run;
        REQUIRE(pend_tree_new(&tree, 2, i ? small : one, i ? one : small, parent, NULL) == PEND_OK);
        struct pend_problem problem = {
            .tree = tree, .loads.gravity = 9.81, .phi = phi, .rate = rate};
        problem.times = (struct pend_times){.count = 2, .span = 1, .divisor = 1};
        CHECK_INT(pend_run_new(&run, &pend_method_taylor, &problem, &error), PEND_INVALID);
        CHECK_INT(error.arm, 1);
        CHECK_SAYING(strstr(error.text, i ? "the length of arm 2 is 4.94065645841247e-324 m"
                                          : "the mass of arm 2 is 4.94065645841247e-324 kg"),
                     "%s", error.text);
    }
}
