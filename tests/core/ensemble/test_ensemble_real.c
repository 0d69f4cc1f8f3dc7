/* Tests of ensembles of real pendulums: members end where single runs end, whatever numbers they
 * differ in; bits do not depend on the other members; the balance of energies, horizons and
 * neighbours.
 * Leaves to others: ideal pendulums (test_ensemble), the equations (test_bodies).
 * Invariant: every instruction set that this processor has is tested; pendulums are random, from
 * seeds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { MEMBERS = 21, ARMS = 8, VALUES = 256 };

/* members that differ in their starts, lengths, masses, gravity and all numbers of their terms */
struct crowd {
    const struct test_tree *t;
    const struct test_bodies *b;
    double start; /* s, for odd members */
    int rows;
    struct pend_outcome outcome[MEMBERS];
    double phi[MEMBERS][ARMS], rate[MEMBERS][ARMS], first[MEMBERS][ARMS], row[MEMBERS][ARMS],
        pull[MEMBERS][ARMS], most[MEMBERS][ARMS];
};

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    unsigned long long seed = (unsigned long long)i + 1;
    for (int k = 0; k < crowd->t->n; k++) {
        member->phi[k] = 4 * test_random(&seed) - 2 - M_PI / 2;
        member->rate[k] = 2 * test_random(&seed) - 1;
        member->length[k] *= 0.8 + 0.4 * test_random(&seed);
        member->mass[k] *= 0.8 + 0.4 * test_random(&seed);
    }
    member->loads.gravity = 5 + 10 * test_random(&seed);
    for (int j = 0; j < crowd->b->terms->count; j++)
        member->value[j] *= 0.7 + 0.6 * test_random(&seed);
    if (i % 2) member->start = crowd->start;
    return 0;
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct crowd *crowd = context;
    size_t bytes = (size_t)crowd->t->n * sizeof(double);
    crowd->outcome[i] = *outcome;
    memcpy(crowd->phi[i], outcome->phi, bytes);
    memcpy(crowd->rate[i], outcome->rate, bytes);
    if (outcome->first_crossing) memcpy(crowd->first[i], outcome->first_crossing, bytes);
    if (outcome->force.most) memcpy(crowd->most[i], outcome->force.most, bytes);
    return 0;
}

static void crowd_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    struct crowd *crowd = context;
    (void)rate, (void)theta, (void)first;
    crowd->rows += count;
    memcpy(crowd->pull[i], force, (size_t)crowd->t->n * sizeof(double));
    memcpy(crowd->row[i], phi, (size_t)crowd->t->n * sizeof(double));
}

static struct pend_ensemble_problem crowd_problem(struct crowd *crowd, double duration) {
    return (struct pend_ensemble_problem){.tree = crowd->t->tree,
                                          .loads = crowd->b->loads,
                                          .duration = duration,
                                          .rtol = 1e-15,
                                          .observe = PEND_OBSERVE_ENERGY,
                                          .fetch = crowd_fetch,
                                          .deliver = crowd_deliver,
                                          .rows = crowd_rows,
                                          .context = crowd};
}

static void crowd_run(const struct pend_ensemble_problem *problem, int isa, long first,
                      long count) {
    OWN(pend_ensemble, free) *ensemble;
    struct pend_error error = {0};
    enum pend_status status = pend_ensemble_new(&ensemble, problem, (enum pend_isa)isa, &error);
    CHECK_SAYING(status == PEND_OK, "%s", error.text);
    if (!ensemble) return;
    long allocations = test_alloc_count();
    CHECK(test_ensemble_run(ensemble, first, count) == PEND_OK);
    CHECK_INT(test_alloc_count(), allocations);
}

/* a member by method taylor: its state at the end, the largest forces at 4001 instants and those at
 * the middle one, and the time up to which it is accurate */
enum { LOOKS = 4001, MIDDLE = LOOKS / 2 };
struct alone {
    double phi[ARMS], rate[ARMS], most[ARMS], pull[ARMS], horizon;
};

static void alone_run(struct crowd *crowd, long i, double duration, double accuracy,
                      struct alone *alone) {
    double phi[ARMS], rate[ARMS], length[ARMS], mass[ARMS], value[VALUES];
    static double t[LOOKS], force[LOOKS * ARMS], angle[LOOKS * ARMS], speed[LOOKS * ARMS];
    static double place[LOOKS], pace[LOOKS];
    const struct pend_tree *tree = crowd->t->tree;
    int n = tree->n, done = 0;
    *alone = (struct alone){0};
    struct pend_member member = {.phi = phi,
                                 .rate = rate,
                                 .length = length,
                                 .mass = mass,
                                 .value = value,
                                 .loads = crowd->b->loads};
    member.loads.value = value;
    memcpy(length, tree->len, (size_t)n * sizeof(double));
    memcpy(mass, tree->mass, (size_t)n * sizeof(double));
    memcpy(value, crowd->b->value, (size_t)crowd->b->terms->count * sizeof(double));
    crowd_fetch(crowd, i, &member);
    struct pend_tree own = *tree;
    own.len = length, own.mass = mass;
    struct pend_problem problem = {
        .tree = &own,
        .loads = member.loads,
        .phi = phi,
        .rate = rate,
        .times = {.count = LOOKS, .start = member.start, .span = duration, .divisor = LOOKS - 1},
        .rtol = 1e-15,
        .accuracy = accuracy};
    struct pend_samples samples = {
        .cap = LOOKS, .t = t, .phi = angle, .rate = speed, .force = force};
    // samples of arms do not include a cart
    int cart = pend_terms_cart(crowd->b->terms), columns = n - cart;
    if (cart) samples.cart_place = place, samples.cart_speed = pace;
    struct pend_run *run;
    REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
    alone->horizon = pend_run_stats(run).horizon - member.start;
    pend_run_free(&run);
    alone->phi[0] = place[LOOKS - 1], alone->rate[0] = pace[LOOKS - 1];
    for (int k = cart; k < n; k++) {
        int at = tree->order[k] - (cart && tree->order[k] > tree->order[0]);
        alone->phi[k] = angle[(LOOKS - 1) * columns + at];
        alone->rate[k] = speed[(LOOKS - 1) * columns + at];
        alone->pull[k] = force[MIDDLE * columns + at];
        alone->most[k] = -INFINITY;
        for (int j = 0; j < LOOKS; j++)
            alone->most[k] = fmax(alone->most[k], force[j * columns + at]);
    }
}

/* all terms that the fast form for few arms supports */
enum {
    QUICK_TERMS = TEST_TERMS_SPRINGS | TEST_TERMS_DAMPING | TEST_TERMS_TORQUES | TEST_TERMS_PIVOT
};

/* the terms of test number i: each kind alone, then all, then a cart with all; then those of the
 * fast form together, without bodies and with them */
static unsigned crowd_terms(int i) {
    static const unsigned last[] = {TEST_TERMS_ALL, TEST_TERMS_CART_ALL, QUICK_TERMS,
                                    QUICK_TERMS | TEST_TERMS_RODS};
    return i < 8 ? 1u << i : last[i - 8];
}

TEST(members_that_differ_in_every_number_of_their_terms_end_where_single_runs_end) {
    unsigned long long seed = 5;
    double worst = 0, drift = 0, force = 0, pull = 0;
    for (int i = 0; i < 12; i++) {
        for (int n = i == 9 ? 4 : 1; n <= 7; n += i < 10 ? 3 : 1) {
            OWN(test_tree, clear) t;
            OWN(test_bodies, clear) b;
            double duration = n == 4 ? -0.25 : 1;
            test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
            test_bodies_random(&b, t.tree, crowd_terms(i), &seed);
            REQUIRE(b.terms->count <= VALUES);
            for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
                struct crowd crowd = {.t = &t, .b = &b, .start = 3.25};
                struct pend_ensemble_problem problem = crowd_problem(&crowd, duration);
                double instant[] = {duration / 2};
                problem.observe |= PEND_OBSERVE_EXTREMES;
                problem.times = instant, problem.times_count = 1;
                crowd_run(&problem, isa, 0, MEMBERS);
                for (long j = 0; j < MEMBERS; j += isa < (int)pend_isa_best() ? 5 : 1) {
                    struct alone alone;
                    alone_run(&crowd, j, duration, 0, &alone);
                    CHECK(crowd.outcome[j].stop == PEND_STOP_TIME);
                    drift = fmax(drift, crowd.outcome[j].energy_drift);
                    worst = fmax(worst, test_gap(n, crowd.phi[j], alone.phi));
                    worst = fmax(worst, test_gap(n, crowd.rate[j], alone.rate));
                    int cart = pend_terms_cart(b.terms);
                    force =
                        fmax(force, test_gap(n - cart, crowd.most[j] + cart, alone.most + cart));
                    pull = fmax(pull, test_gap(n - cart, crowd.pull[j] + cart, alone.pull + cart));
                }
            }
        }
    }
    CHECK_RESIDUAL(worst, 1e-11, "phi and phi' of a member against a single run");
    CHECK_RESIDUAL(drift, 4e-13, "the balance of a member's energy");
    CHECK_RESIDUAL(force, 1e-3, "the largest force against 4001 samples");
    CHECK_RESIDUAL(pull, 1e-11, "forces in the middle against a single run");
}

TEST(real_members_have_the_same_bits_in_any_company_and_instruction_set) {
    unsigned long long seed = 6;
    static struct crowd whole, parts, narrow;
    for (int i = 0; i < 11; i++) {
        static const int arms[] = {2, 7, 1, 3, 6, 1, 2, 3, 4, 6, 8};
        unsigned bodies = i < 5 ? 0 : TEST_TERMS_RODS;
        int n = arms[i];
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
        test_bodies_random(&b, t.tree, i < 2 ? TEST_TERMS_ALL : QUICK_TERMS | bodies, &seed);
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            memset(&whole, 0, sizeof whole), memset(&parts, 0, sizeof parts);
            whole.t = parts.t = &t, whole.b = parts.b = &b;
            struct pend_ensemble_problem x = crowd_problem(&whole, 2), y = crowd_problem(&parts, 2);
            x.bound = y.bound = M_PI, x.accuracy = y.accuracy = 1e-6;
            crowd_run(&x, isa, 0, MEMBERS);
            crowd_run(&y, isa, 13, 8);
            crowd_run(&y, isa, 2, 11);
            crowd_run(&y, isa, 0, 2);
            CHECK(!memcmp(whole.phi, parts.phi, sizeof whole.phi));
            CHECK(!memcmp(whole.rate, parts.rate, sizeof whole.rate));
            CHECK(!memcmp(whole.first, parts.first, sizeof whole.first));
            CHECK(whole.rate[0][0] != whole.rate[1][0]);
            for (int j = 0; j < MEMBERS; j++) {
                CHECK(whole.outcome[j].horizon == parts.outcome[j].horizon);
                CHECK(whole.outcome[j].energy_drift == parts.outcome[j].energy_drift);
            }
            if (isa == PEND_ISA_AVX512) CHECK(!memcmp(whole.phi, narrow.phi, sizeof whole.phi));
            narrow = whole;
        }
    }
}

TEST(horizons_of_real_members_are_those_of_single_runs) {
    unsigned long long seed = 8;
    int lost = 0;
    for (int i = 0; i < 4; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        static struct crowd crowd;
        // the last has friction, and stays accurate; the others drive chaos
        static const unsigned terms[4] = {TEST_TERMS_RODS, TEST_TERMS_PIVOT,
                                          TEST_TERMS_RODS | TEST_TERMS_TORQUES, TEST_TERMS_ALL};
        test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
        test_bodies_random(&b, t.tree, terms[i], &seed);
        crowd = (struct crowd){.t = &t, .b = &b, .start = 3.25};
        struct pend_ensemble_problem problem = crowd_problem(&crowd, 40);
        problem.accuracy = 1e-6;
        crowd_run(&problem, (int)pend_isa_best(), 0, MEMBERS);
        for (long j = 0; j < MEMBERS; j++) {
            struct alone alone;
            alone_run(&crowd, j, 40, 1e-6, &alone);
            double held = crowd.outcome[j].horizon;
            CHECK(held > 0 && held <= 40);
            if (held == 40 && alone.horizon > 39.9) continue;
            lost++;
            CHECK_SAYING(held > 0.6 * alone.horizon && alone.horizon > 0.6 * held,
                         "%.3f s, alone %.3f s", held, alone.horizon);
        }
    }
    CHECK(lost > 5);
}

/* a single damped arm: theta'' + 2 a theta' + w^2 sin theta = 0 decays as e^{-a t} near hanging */
static int damped_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    member->phi[0] = 1e-4 - M_PI / 2;
    member->value[crowd->b->terms->row[PEND_TERM_DAMPING]] = 0.05 * (double)(i + 1);
    return 0;
}

TEST(members_of_several_dampings_decay_as_the_closed_form_has_it) {
    double length[] = {1}, mass[] = {1};
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int parent[] = {-1};
    struct test_tree t = {.n = 1};
    struct test_bodies b;
    double value[1], most = 0, instant[] = {1.5};
    static struct crowd crowd;
    rows[PEND_TERM_DAMPING] = 1;
    REQUIRE(pend_tree_new(&t.tree, 1, length, mass, parent, NULL) == PEND_OK);
    REQUIRE(pend_terms_new(&b.terms, 1, rows, ones, 0, NULL, NULL) == PEND_OK);
    b.value = value, value[0] = 0;
    b.loads = (struct pend_loads){9.81, b.terms, value};
    crowd = (struct crowd){.t = &t, .b = &b};
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 3);
    problem.fetch = damped_fetch;
    problem.observe |= PEND_OBSERVE_LYAPUNOV;
    problem.times = instant, problem.times_count = 1;
    crowd_run(&problem, (int)pend_isa_best(), 0, MEMBERS);
    CHECK_INT(crowd.rows, MEMBERS);
    for (int i = 0; i < MEMBERS; i++) {
        double a = 0.05 * (i + 1) / 2, w = sqrt(9.81 - a * a), tau = instant[0];
        double want = 1e-4 * exp(-a * tau) * (cos(w * tau) + a / w * sin(w * tau));
        most = fmax(most, fabs(crowd.row[i][0] + M_PI / 2 - want) / 1e-4);
        // neighbours decay at the same rate, except for the phase of the swing at which they are
        // compared
        CHECK(fabs(crowd.outcome[i].lyapunov + a) < 0.3);
    }
    CHECK_RESIDUAL(most, 1e-8, "angles of small swings against the closed form");
    pend_terms_free(&b.terms);
    pend_tree_free(&t.tree);
}
