#include "core/integrate/run/horizon.h"

#include <math.h>
#include <stdlib.h>

#include "tests/harness/motions.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

static const double accuracy = 1e-6;

/* two unit arms released at rest from so far aside that they tumble */
static void tumble_init(struct test_tree *t, double aside) {
    unsigned long long seed = 1;
    const int parent[] = {-1, 0};
    test_tree_init(t, 2, parent, 0.3, &seed);
    for (int k = 0; k < 2; k++) t->length[k] = t->mass[k] = 1;
    test_tree_rebuild(t);
    t->phi[0] = 2 * aside - M_PI_2, t->phi[1] = 2.5 * aside - M_PI_2;
    t->rate[0] = t->rate[1] = 0;
}

static struct pend_problem tumble_problem(const struct test_tree *t, double span, long count) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads.gravity = 9.81,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)},
        .accuracy = accuracy};
}

/* the last instant up to which all numbers of a record agree with a more accurate one */
static double truth(const struct test_record *record, const struct test_record *exact, int n) {
    double fastest = 0, strongest = 0, until = NAN;
    for (long i = 0; i < record->samples.count; i++) {
        const struct pend_samples *a = &record->samples, *b = &exact->samples;
        for (long k = i * n; k < (i + 1) * n; k++) {
            fastest = fmax(fastest, fabs(b->rate[k]));
            strongest = fmax(strongest, fabs(b->force[k]));
        }
        for (long k = i * n; k < (i + 1) * n; k++) {
            if (!(fabs(a->phi[k] - b->phi[k]) <= accuracy)) return until;
            if (!(fabs(a->rate[k] - b->rate[k]) <= accuracy * fastest)) return until;
            if (!(fabs(a->force[k] - b->force[k]) <= accuracy * strongest)) return until;
        }
        until = a->t[i];
    }
    return until;
}

static double true_horizon(const struct test_record *record, const struct pend_problem *problem) {
    OWN(test_record, clear) exact;
    struct pend_problem better = *problem;
    better.rtol = better.atol = better.step = better.accuracy = 0;
    test_record_blocks(&exact, pend_method_taylor.extended, &better, problem->times.count,
                       INFINITY);
    return truth(record, &exact, record->n - pend_terms_cart(problem->loads.terms));
}

TEST(horizon_is_where_the_digits_end) {
    static const struct {
        const char *method;
        double rtol, least;
    } list[] = {{"taylor", 0, 0.9},     {"taylor", 1e-8, 0.75}, {"taylor", 1e-15, 0.75},
                {"symplectic", 0, 0.7}, {"rk8pd", 0, 0.85},     {"rkf45", 0, 0.85},
                {"msadams", 0, 0.85},   {"ode23", 1e-9, 0.6},   {"rk8pd", 1e-12, 0.85},
                {"radau", 0, 0.6},      {"radau", 1e-12, 0.6}};
    OWN(test_tree, clear) t;
    tumble_init(&t, 1);
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        struct pend_problem problem = tumble_problem(&t, 18, 901);
        OWN(test_record, clear) record;
        problem.rtol = list[i].rtol;
        test_record(&record, list[i].method, &problem);
        double until = true_horizon(&record, &problem), told = record.stats.horizon;
        CHECK_SAYING(until > 0.5 && until < 17 && told <= 1.1 * until &&
                         told >= list[i].least * until,
                     "%s, rtol %g: %g told, %g true", list[i].method, list[i].rtol, told, until);
    }
}

TEST(horizon_of_32_digits_is_four_times_as_far) {
    OWN(test_tree, clear) t;
    tumble_init(&t, 1);
    struct pend_problem problem = tumble_problem(&t, 50, 501);
    OWN(test_record, clear) record;
    test_record_blocks(&record, pend_method_taylor.extended, &problem, 501, INFINITY);
    // the motion in 90 digits and this one differ by 1e-6 rad at 32.5 s
    CHECK_SAYING(record.stats.horizon <= 1.1 * 32.5 && record.stats.horizon >= 0.8 * 32.5, "%g",
                 record.stats.horizon);
}

TEST(horizon_of_random_trees_is_seldom_late_and_never_by_a_tenth) {
    enum { TREES = 24 };
    unsigned long long seed = 15;
    double ratio[TREES];
    int parted = 0, early = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        OWN(test_record, clear) record;
        test_tree_random(&t, TEST_TREE_ATTACHED, 2 + i % 5, 0.3, &seed);
        for (int k = 0; k < t.n; k++) t.rate[k] /= 3;
        struct pend_problem problem = tumble_problem(&t, 14, 701);
        if (i % 3 == 1) problem.times.span = -14;
        test_record(&record, "taylor", &problem);
        double until = true_horizon(&record, &problem), told = record.stats.horizon;
        if (fabs(until) < 14) {
            ratio[parted] = told / until;
            CHECK_SAYING(ratio[parted] <= 1.1, "tree %d: %g told, %g true", i, told, until);
            early += ratio[parted++] < 0.8;
        }
    }
    CHECK_SAYING(parted >= TREES / 2 && early <= parted / 4, "%d parted, %d early", parted, early);
}

/* Truncation errors of steps may nearly cancel, over many steps: then their first terms alone are
 * not enough. */
TEST(horizon_of_steps_that_nearly_cancel_is_not_late) {
    enum { ARMS = 3 };
    static const struct {
        int parent[ARMS];
        double length[ARMS], mass[ARMS], phi[ARMS], rate[ARMS], span;
    } list[] = {{{-1, 0, 0},
                 {0.89587342739772458, 0.88748648721612278, 1.420236328182183},
                 {1.1057964963259868, 0.91653348491594411, 1.3716044845707431},
                 {-1.169209451465927, 2.1805162367786446, 0.27270700336197917},
                 {0.10762021590217752, -0.79092796224863138, 0.60602116626402913},
                 53.85},
                {{-1, 0, 1},
                 {0.5620931320492929, 1.0483695542691398, 1.4996269586448137},
                 {1.2085125993574668, 0.50224751948914403, 1.2883925920065586},
                 {-2.4202925753642837, -2.1764703621719561, 2.2914665914569703},
                 {-0.49931374292094888, 0.85682961971651039, -0.71036379709818287},
                 35.2}};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        unsigned long long seed = 1;
        OWN(test_tree, clear) t;
        OWN(test_record, clear) record;
        test_tree_init(&t, ARMS, list[i].parent, 0.3, &seed);
        for (int k = 0; k < ARMS; k++) {
            t.length[k] = list[i].length[k], t.mass[k] = list[i].mass[k];
            t.phi[k] = list[i].phi[k], t.rate[k] = list[i].rate[k];
        }
        test_tree_rebuild(&t);
        struct pend_problem problem =
            tumble_problem(&t, list[i].span, 1 + (long)(list[i].span * 20));
        problem.rtol = 1e-9;
        test_record(&record, "taylor", &problem);
        double until = true_horizon(&record, &problem), told = record.stats.horizon;
        CHECK_SAYING(until < 25 && told <= 1.1 * until && told >= 0.7 * until,
                     "motion %zu: %g told, %g true", i, told, until);
    }
}

TEST(horizon_of_a_small_swing_is_its_end) {
    static const char *const methods[] = {"taylor", "symplectic", "rk8pd"};
    OWN(test_tree, clear) t;
    tumble_init(&t, 0.05);
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        struct pend_problem problem = tumble_problem(&t, 60, 61);
        OWN(test_record, clear) record;
        problem.rtol = 0;
        test_record(&record, methods[i], &problem);
        CHECK_SAYING(record.stats.horizon == 60, "%s: %g", methods[i], record.stats.horizon);
    }
}

TEST(horizon_of_a_loose_tolerance_is_the_start) {
    OWN(test_tree, clear) t;
    tumble_init(&t, 1);
    struct pend_problem problem = tumble_problem(&t, 5, 51);
    OWN(test_record, clear) record;
    problem.times.start = 7;
    test_record(&record, "ode23", &problem);
    CHECK_SAYING(record.stats.horizon == 7, "%g", record.stats.horizon);
    test_record_clear(&record);
    problem.accuracy = 0;
    test_record(&record, "ode23", &problem);
    CHECK(isnan(record.stats.horizon));
}

/* trees for each form of the orders: small ones, blocks, chains */
TEST(horizon_does_not_change_the_motion) {
    static const char *const methods[] = {"taylor", "ode23", "rk8pd", "symplectic"};
    static const struct {
        enum test_tree_kind kind;
        int n;
    } trees[] = {{TEST_TREE_CHAIN, 1},     {TEST_TREE_ATTACHED, 2}, {TEST_TREE_ATTACHED, 4},
                 {TEST_TREE_ATTACHED, 7},  {TEST_TREE_CHAIN, 12},   {TEST_TREE_ATTACHED, 20},
                 {TEST_TREE_ATTACHED, 80}, {TEST_TREE_CHAIN, 200},  {TEST_TREE_BINARY, 100}};
    unsigned long long seed = 3;
    for (size_t i = 0; i < sizeof trees / sizeof *trees; i++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, trees[i].kind, trees[i].n, 0.3, &seed);
        for (size_t j = 0; j < (trees[i].n < 30 ? sizeof methods / sizeof *methods : 1); j++) {
            OWN(test_record, clear) plain, told;
            struct pend_problem problem = tumble_problem(&t, trees[i].n < 30 ? 1 : 0.2, 41);
            test_record(&told, methods[j], &problem);
            problem.accuracy = 0;
            test_record(&plain, methods[j], &problem);
            CHECK_SAYING(test_record_same(&plain, &told) && plain.stats.steps == told.stats.steps &&
                             plain.stats.evaluations == told.stats.evaluations,
                         "%s of %d arms", methods[j], trees[i].n);
        }
    }
}

TEST(horizon_carried_says_the_same) {
    static const char *const methods[] = {"taylor", "symplectic", "ode23"};
    OWN(test_tree, clear) t;
    tumble_init(&t, 1);
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        OWN(test_record, clear) whole, carried;
        struct pend_problem problem = tumble_problem(&t, 12, 121);
        if (i == 2) problem.rtol = 1e-8;
        test_record(&whole, methods[i], &problem);
        test_record_carried(&carried, pend_method_find(methods[i]), &problem, 7, 500);
        CHECK(test_record_same(&whole, &carried));
        CHECK_SAYING(whole.stats.horizon == carried.stats.horizon && whole.stats.horizon < 12,
                     "%s: %g and %g", methods[i], whole.stats.horizon, carried.stats.horizon);
    }
}

TEST(horizon_fails_cleanly_without_memory) {
    OWN(test_tree, clear) t;
    tumble_init(&t, 1);
    struct pend_problem problem = tumble_problem(&t, 1, 3);
    for (long i = 1;; i++) {
        struct pend_run *run;
        test_alloc_fail(i, 0);
        enum pend_status status = pend_run_new(&run, &pend_method_taylor, &problem, NULL);
        test_alloc_faults_off();
        CHECK(status == PEND_OK ? run != NULL : status == PEND_NO_MEMORY && !run);
        pend_run_free(&run);
        if (status == PEND_OK) {
            CHECK(i > 3);
            break;
        }
        REQUIRE(i < 100);
    }
}

/* the linear motion is not accurate for the pendulum itself, and reports no horizon */
TEST(horizon_of_the_linear_motion_is_not_told) {
    OWN(test_tree, clear) t;
    tumble_init(&t, 0.1);
    struct pend_problem problem = tumble_problem(&t, 60, 101);
    OWN(test_record, clear) record;
    test_record(&record, "linear", &problem);
    CHECK(isnan(record.stats.horizon) && isnan(record.stats.held));
}

static struct pend_problem motion_problem(const struct test_motion *motion, long count) {
    return (struct pend_problem){
        .tree = motion->tree,
        .loads = test_motion_loads(motion),
        .phi = motion->phi,
        .rate = motion->rate,
        .accuracy = accuracy,
        .times = {.count = count, .span = motion->span, .divisor = (double)(count - 1)}};
}

/* damped, stiff, stuck, driven, regular and chaotic ones, by the step's own series and by one
 * computed for the estimate */
TEST(horizon_is_from_half_of_the_truth_to_a_tenth_beyond_it_for_motions_of_every_kind) {
    enum { EACH = 9 };
    int parted = 0, held = 0;
    for (int i = 0; i < EACH * TEST_MOTION_KINDS; i++) {
        enum test_motion_kind kind = (enum test_motion_kind)(i % TEST_MOTION_KINDS);
        OWN(test_motion, clear) motion;
        OWN(test_record, clear) record;
        test_motion_init(&motion, kind, 1000 + i);
        struct pend_problem problem = motion_problem(&motion, 401);
        test_record(&record, i % 3 == 2 ? "rk8pd" : "taylor", &problem);
        double until = true_horizon(&record, &problem), told = record.stats.horizon;
        CHECK_SAYING(told >= 0.5 * until && told <= fmax(1.1 * until, motion.span / 400),
                     "%s motion %d, %s: %g told, %g true of %g s", test_motion_name(kind), i,
                     record.stats.method, told, until, motion.span);
        if (until == motion.span)
            held++;
        else
            parted++;
    }
    CHECK_SAYING(parted >= EACH / 2 && held >= EACH * TEST_MOTION_KINDS / 2, "%d, %d", parted,
                 held);
}

/* one arm that sticks, one with 16 times critical damping, and a swing over 1000 periods */
TEST(horizon_of_an_arm_that_rests_or_swings_for_long_is_its_end) {
    static const struct {
        double damping, friction, speed, start, span;
        const char *method;
    } list[] = {{0, 1, 0.1, 1, 60, "taylor"},   {0, 1, 0.1, 1, 60, "rk8pd"},
                {0, 1, 1e-3, 1, 3, "taylor"},   {100, 0, 1, 0.8, 20, "taylor"},
                {15, 0, 1, 0.8, 60, "taylor"},  {7, 0, 1, 0.8, 60, "rk8pd"},
                {0, 0, 1, 2.5, 3000, "taylor"}, {0, 0, 1, 2.5, 3000, "symplectic"}};
    const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_DAMPING] = 1, [PEND_TERM_FRICTION] = 1},
                        ones[PEND_TERM_ONES] = {0};
    OWN(pend_terms, free) *terms;
    unsigned long long seed = 1;
    OWN(test_tree, clear) t;
    test_tree_init(&t, 1, (const int[]){-1}, 0, &seed);
    t.length[0] = t.mass[0] = 1;
    test_tree_rebuild(&t);
    if (!CHECK(pend_terms_new(&terms, 1, rows, ones, 0, NULL, NULL) == PEND_OK)) return;
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        double value[8];
        OWN(test_record, clear) record;
        struct pend_problem problem = tumble_problem(&t, list[i].span, 4);
        pend_terms_clear(terms, t.tree, value);
        value[terms->row[PEND_TERM_DAMPING]] = list[i].damping;
        value[terms->row[PEND_TERM_FRICTION]] = list[i].friction;
        value[terms->row[PEND_TERM_FRICTION_SPEED]] = list[i].speed;
        t.phi[0] = list[i].start - M_PI_2, t.rate[0] = 0;
        if (list[i].damping > 0 || list[i].friction > 0)
            problem.loads.terms = terms, problem.loads.value = value;
        test_record(&record, list[i].method, &problem);
        CHECK_SAYING(record.stats.horizon == list[i].span, "%zu, %s: %g", i, list[i].method,
                     record.stats.horizon);
    }
}
