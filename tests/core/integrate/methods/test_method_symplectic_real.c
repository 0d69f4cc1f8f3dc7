/* Tests of the symplectic method on conservative real pendulums: momenta, order, energy, reversal,
 * and refusals.
 * Leaves to others: ideal pendulums, and that a step is a symplectic map (test_method_symplectic).
 * Invariant: references are method taylor, the energies, or the map itself. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/integrate/methods/kernel_symplectic.h"
#include "core/integrate/methods/method.h"
#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { N = 5, KEEPS = TEST_TERMS_RODS | TEST_TERMS_SPRINGS };

/* the terms of test i: every second pendulum of two or more arms is on a cart */
static unsigned keeps(int i) { return i % N && i % 2 ? KEEPS | TEST_TERMS_CART : KEEPS; }

struct real {
    struct test_tree t;
    struct test_bodies b;
};

static void real_init(struct real *real, int n, unsigned what, unsigned long long *seed) {
    test_tree_random(&real->t, TEST_TREE_ATTACHED, n, 0.3, seed);
    test_bodies_random(&real->b, real->t.tree, what, seed);
}

static void real_clear(struct real *real) {
    test_bodies_clear(&real->b);
    test_tree_clear(&real->t);
}

static struct pend_problem real_problem(const struct real *real, double span, long count,
                                        double step) {
    return (struct pend_problem){
        .tree = real->t.tree,
        .loads = real->b.loads,
        .phi = real->t.phi,
        .rate = real->t.rate,
        .step = step,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)}};
}

/* the momenta follow from the kinetic energy, T = sum p phi' / 2, and give the rates back */
TEST(momenta_of_real_pendulums_are_those_of_their_energy_and_give_the_rates_back) {
    const struct symplectic_kernel *kernel = &pend_kernel_symplectic_base;
    unsigned long long seed = 31;
    double energy_gap = 0, rate_gap = 0;
    for (int i = 0; i < 20; i++) {
        OWN(real, clear) real;
        real_init(&real, 1 + i % N, keeps(i), &seed);
        const struct pend_tree *tree = real.t.tree;
        double p[N], low[N] = {0}, rate[N], scratch[4 * N], sum = 0;
        struct symplectic_system system = {.n = tree->n,
                                           .parent = tree->parent,
                                           .end = tree->end,
                                           .loads = real.b.loads,
                                           .subtree_mass = tree->subtree_mass};
        system.lanes =
            aligned_alloc(64, kernel->count(real.b.loads.terms, tree->n) * sizeof(double));
        REQUIRE(system.lanes);
        kernel->load(&system, tree->len, tree->mass);
        kernel->momenta(&system, real.t.phi, real.t.rate, p);
        for (int k = 0; k < tree->n; k++) sum += p[k] * real.t.rate[k] / 2;
        double kinetic =
            pend_kinematics_energy_at(tree, &real.b.loads, 0, real.t.phi, real.t.rate, scratch)
                .kinetic;
        energy_gap = fmax(energy_gap, fabs(sum - kinetic) / kinetic);
        struct symplectic_state state = {real.t.phi, low, p, low};
        kernel->rates(&system, &state, rate);
        rate_gap = fmax(rate_gap, test_gap(tree->n, rate, real.t.rate));
        free(system.lanes);
    }
    CHECK_RESIDUAL(energy_gap, 2e-14, "sum p phi' / 2 beside the kinetic energy");
    CHECK_RESIDUAL(rate_gap, 1e-13, "rates from momenta");
}

TEST(symplectic_motion_of_real_pendulums_is_that_of_method_taylor) {
    unsigned long long seed = 32;
    double gap = 0, drift = 0;
    for (int i = 0; i < 10; i++) {
        OWN(real, clear) real;
        OWN(test_record, clear) got, want;
        real_init(&real, 1 + i % N, keeps(i), &seed);
        struct pend_problem problem = real_problem(&real, 1, 41, 0);
        test_record(&got, "symplectic", &problem);
        problem.rtol = 1e-16;
        test_record(&want, "taylor", &problem);
        CHECK_SAYING(got.status == PEND_OK, "%s", got.error.text);
        // a cart, whose position is no angle, has no column
        int columns = real.t.n - (pend_terms_cart(real.b.terms) ? 1 : 0);
        gap = fmax(gap, test_gap(41 * columns, got.samples.phi, want.samples.phi));
        drift = fmax(drift, got.stats.energy_drift);
    }
    CHECK_RESIDUAL(gap, 1e-12, "phi beside method taylor");
    CHECK_RESIDUAL(drift, 1e-14, "energy");
}

/* two bars with a spring between them, which tumble */
static void bars_init(struct real *bars) {
    static const int parent[] = {-1, 0};
    unsigned long long seed = 33;
    test_tree_init(&bars->t, 2, parent, 0.3, &seed);
    for (int k = 0; k < 2; k++) bars->t.length[k] = bars->t.mass[k] = 1;
    test_tree_rebuild(&bars->t);
    test_bodies_random(&bars->b, bars->t.tree, KEEPS, &seed);
    const struct pend_terms *terms = bars->b.terms;
    pend_terms_clear(terms, bars->t.tree, bars->b.value);
    for (int k = 0; k < 2; k++) bars->b.value[terms->row[PEND_TERM_ROD] + k] = 1;
    bars->b.value[terms->row[PEND_TERM_STIFFNESS] + 1] = 5;
    bars->t.phi[0] = 2 - M_PI_2;
    bars->t.phi[1] = 2.5 - M_PI_2;
    bars->t.rate[0] = bars->t.rate[1] = 0;
}

static double bars_drift(const struct real *bars, double span, double step) {
    OWN(test_record, clear) record;
    struct pend_problem problem = real_problem(bars, span, 2, step);
    test_record(&record, "symplectic", &problem);
    CHECK_SAYING(record.status == PEND_OK, "%s", record.error.text);
    return record.stats.energy_drift;
}

TEST(symplectic_has_order_sixteen_on_bars_with_a_spring_and_keeps_their_energy) {
    OWN(real, clear) bars;
    bars_init(&bars);
    // over a longer time the two motions differ, by rounding and chaos
    double coarse = bars_drift(&bars, 12, 0.04), fine = bars_drift(&bars, 12, 0.03),
           order = log(coarse / fine) / log(4.0 / 3);
    CHECK_SAYING(order > 14 && order < 18, "order %.2f: error %g, then %g", order, coarse, fine);
    // the error of the energy oscillates with the motion, and does not grow with time
    double later = bars_drift(&bars, 600, 0.04);
    CHECK_SAYING(later < 20 * coarse, "%g in 600 s, %g in 12 s", later, coarse);
    CHECK_RESIDUAL(bars_drift(&bars, 300, 0.015), 1e-13, "energy over 20000 steps");
}

TEST(symplectic_runs_backwards_to_the_start_of_a_real_pendulum) {
    unsigned long long seed = 34;
    OWN(real, clear) real;
    OWN(test_record, clear) there, back = {0};
    real_init(&real, 4, KEEPS, &seed);
    // coarse steps: the reversal tests the map's own symmetry, not its accuracy
    struct pend_problem problem = real_problem(&real, 2, 2, 0.03125);
    double phi[4], rate[4], gap = 0;
    test_record(&there, "symplectic", &problem);
    REQUIRE(there.status == PEND_OK);
    for (int k = 0; k < 4; k++) {
        phi[k] = there.samples.phi[4 + real.t.tree->order[k]];
        rate[k] = there.samples.rate[4 + real.t.tree->order[k]];
    }
    problem.phi = phi;
    problem.rate = rate;
    problem.times.span = -2;
    test_record(&back, "symplectic", &problem);
    for (int k = 0; k < 4; k++) {
        gap = fmax(gap, fabs(back.samples.phi[4 + real.t.tree->order[k]] - real.t.phi[k]));
        gap = fmax(gap, fabs(back.samples.rate[4 + real.t.tree->order[k]] - real.t.rate[k]));
    }
    CHECK_RESIDUAL(gap, 1e-12, "phi and phi' after 64 steps there and back");
}

TEST(symplectic_refuses_what_does_not_keep_the_energy_and_says_what_to_use) {
    for (unsigned what = TEST_TERMS_DAMPING; what <= TEST_TERMS_PIVOT; what *= 2) {
        unsigned long long seed = 35;
        OWN(real, clear) real;
        OWN(pend_run, free) *run;
        struct pend_error error;
        real_init(&real, 2, what, &seed);
        struct pend_problem problem = real_problem(&real, 1, 2, 0);
        CHECK(pend_run_new(&run, &pend_method_symplectic, &problem, &error) == PEND_INVALID);
        CHECK_SAYING(strstr(error.text, "conserves the energy") && strstr(error.text, "use method"),
                     "%u: %s", what, error.text);
        // terms without effect are accepted
        pend_terms_clear(real.b.terms, real.t.tree, real.b.value);
        CHECK(pend_run_new(&run, &pend_method_symplectic, &problem, &error) == PEND_OK);
    }
}
