/* Motions of real pendulums: the methods agree, the energy is balanced, forces and positions are
 * those of the dense form.
 * Leaves to others: accelerations at one state (test_bodies), closed forms (laws).
 * Invariant: all pendulums are random, from seeds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 12, INSTANTS = 3 };

/* samples of a motion, in the caller's order */
struct motion {
    double t[INSTANTS], phi[INSTANTS * ARMS], rate[INSTANTS * ARMS], acc[INSTANTS * ARMS],
        force[INSTANTS * ARMS], across[INSTANTS * ARMS], joint_along[INSTANTS * ARMS],
        joint_across[INSTANTS * ARMS], z_re[INSTANTS * ARMS], z_im[INSTANTS * ARMS],
        zd_re[INSTANTS * ARMS], zd_im[INSTANTS * ARMS], kinetic[INSTANTS], potential[INSTANTS],
        work[INSTANTS], heat[INSTANTS], cart_place[INSTANTS], cart_speed[INSTANTS];
    struct pend_run_stats stats;
};

static void motion_run(const char *method, double span, const struct test_tree *t,
                       const struct test_bodies *b, struct motion *m) {
    struct pend_problem problem = {
        .tree = t->tree,
        .loads = b->loads,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = INSTANTS, .start = 0.7, .span = span, .divisor = 2},
        .rtol = 1e-13,
        .atol = 1e-13,
        .atol_given = 1};
    struct pend_samples samples = {.cap = INSTANTS,
                                   .t = m->t,
                                   .phi = m->phi,
                                   .rate = m->rate,
                                   .acc = m->acc,
                                   .force = m->force,
                                   .across = m->across,
                                   .joint_along = m->joint_along,
                                   .joint_across = m->joint_across,
                                   .z_re = m->z_re,
                                   .z_im = m->z_im,
                                   .zd_re = m->zd_re,
                                   .zd_im = m->zd_im,
                                   .kinetic = m->kinetic,
                                   .potential = m->potential,
                                   .work = m->work,
                                   .heat = m->heat,
                                   .cart_place = m->cart_place,
                                   .cart_speed = m->cart_speed};
    OWN(pend_run, free) *run;
    struct pend_error error = {0};
    int done = 0;
    if (!strcmp(method, "taylor")) problem.accuracy = 1e-6;
    CHECK_SAYING(pend_run_new(&run, pend_method_find(method), &problem, &error) == PEND_OK, "%s",
                 error.text);
    if (!run) return;
    while (!done)
        if (pend_run_next(run, &samples, 1e9, &done, &error) != PEND_OK) break;
    CHECK_SAYING(done, "%s", error.text);
    m->stats = pend_run_stats(run);
}

/* the terms of test number i: each kind alone, then all, then a cart with all terms that it
 * supports */
static unsigned motion_terms(int i) {
    return i < 8 ? 1u << i : i == 8 ? TEST_TERMS_ALL : TEST_TERMS_CART_ALL;
}

/* the column of stored arm k among those of the samples, which have none for a cart */
static int motion_column(const struct test_tree *t, const struct test_bodies *b, int k) {
    const int *order = t->tree->order;
    return order[k] - (pend_terms_cart(b->terms) && order[k] > order[0]);
}

TEST(motions_of_real_pendulums_agree_with_gsl_and_keep_their_energys_balance) {
    unsigned long long seed = 7;
    double gap = 0, drift = 0, ends = 0, exchange = 0;
    for (int i = 0; i < 10; i++) {
        for (int n = i < 9 ? 1 : 4; n <= 10; n += 3) {
            OWN(test_tree, clear) t;
            OWN(test_bodies, clear) b;
            struct motion taylor, other;
            test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
            test_bodies_random(&b, t.tree, motion_terms(i), &seed);
            motion_run("taylor", n == 4 ? -0.25 : 1, &t, &b, &taylor);
            motion_run("rk8pd", n == 4 ? -0.25 : 1, &t, &b, &other);
            int cart = pend_terms_cart(b.terms);
            gap = fmax(gap, test_gap(INSTANTS * (n - cart), taylor.phi, other.phi));
            if (cart) gap = fmax(gap, test_gap(INSTANTS, taylor.cart_place, other.cart_place));
            if (cart) gap = fmax(gap, test_gap(INSTANTS, taylor.cart_speed, other.cart_speed));
            drift = fmax(drift, taylor.stats.energy_drift);
            drift = fmax(drift, other.stats.energy_drift);
            exchange = fmax(exchange, fabs(taylor.work[2] - other.work[2]));
            exchange = fmax(exchange, fabs(taylor.heat[2] - other.heat[2]));
            CHECK(taylor.stats.horizon == taylor.t[INSTANTS - 1]);
            // the balance at the last sample, from the samples alone
            double scale = taylor.kinetic[0] + fabs(taylor.potential[0]) + taylor.heat[2] + 1;
            double sum = taylor.kinetic[2] + taylor.potential[2] - taylor.work[2] + taylor.heat[2];
            ends = fmax(ends, fabs(sum - taylor.kinetic[0] - taylor.potential[0]) / scale);
        }
    }
    CHECK_RESIDUAL(gap, 1e-12, "angles by taylor and by rk8pd after a second");
    CHECK_RESIDUAL(drift, 4e-13, "drift of the energy's balance");
    CHECK_RESIDUAL(ends, 4e-13, "balance of the samples");
    CHECK_RESIDUAL(exchange, 2e-11, "work and heat by taylor and by rk8pd");
}

TEST(the_balance_of_energy_holds_over_a_thousand_seconds_with_everything_on) {
    unsigned long long seed = 3;
    double drift = 0;
    for (int n = 1; n <= 4; n++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct motion m;
        test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
        test_bodies_random(&b, t.tree, TEST_TERMS_ALL, &seed);
        motion_run("taylor", 1000, &t, &b, &m);
        CHECK_SAYING(m.heat[INSTANTS - 1] > 0 && m.work[INSTANTS - 1] != 0, "heat %g, work %g",
                     m.heat[INSTANTS - 1], m.work[INSTANTS - 1]);
        drift = fmax(drift, m.stats.energy_drift);
    }
    CHECK_RESIDUAL(drift, 1e-13, "drift of the energy's balance");
}

TEST(samples_of_real_pendulums_have_the_dense_forms_forces) {
    unsigned long long seed = 11;
    double worst = 0, place = 0;
    for (int i = 0; i < 10; i++) {
        enum { N = 5 };
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct motion m;
        test_tree_random(&t, TEST_TREE_ATTACHED, N, 0.3, &seed);
        test_bodies_random(&b, t.tree, motion_terms(i), &seed);
        motion_run("taylor", 1, &t, &b, &m);
        for (int row = 0; row < INSTANTS; row++) {
            double phi[N], rate[N], got[5][N], want[5][N], re[N], im[N];
            test_quad exact_phi[N], exact_rate[N], acc[N], force[4][N];
            struct test_quad_state state = {exact_phi, exact_rate, m.t[row]};
            struct test_quad_forces forces = {force[0], force[1], force[2], force[3]};
            int cart = pend_terms_cart(b.terms), columns = N - cart;
            phi[0] = m.cart_place[row], rate[0] = m.cart_speed[row];
            for (int k = cart; k < N; k++) {
                phi[k] = m.phi[row * columns + motion_column(&t, &b, k)];
                rate[k] = m.rate[row * columns + motion_column(&t, &b, k)];
            }
            for (int k = 0; k < N; k++) exact_phi[k] = phi[k], exact_rate[k] = rate[k];
            test_quad_bodies(t.tree, &b.loads, &state, acc, &forces);
            pend_kinematics_position_at(t.tree, &b.loads, m.t[row], phi, re, im);
            for (int k = cart; k < N; k++) {
                int at = row * columns + motion_column(&t, &b, k);
                double all[5] = {m.acc[at], m.joint_along[at], m.joint_across[at], m.force[at],
                                 m.across[at]};
                double dense[5] = {(double)acc[k], (double)force[0][k], (double)force[1][k],
                                   (double)force[2][k], (double)force[3][k]};
                for (int j = 0; j < 5; j++) got[j][k] = all[j], want[j][k] = dense[j];
                place = fmax(place, fabs(m.z_re[at] - re[k]) + fabs(m.z_im[at] - im[k]));
            }
            for (int j = 0; j < 5; j++) {
                double gap = 0, most = 1;
                for (int k = cart; k < N; k++) {
                    gap = fmax(gap, fabs(got[j][k] - want[j][k]));
                    most = fmax(most, fabs(want[j][k]));
                }
                worst = fmax(worst, gap / most);
            }
        }
    }
    CHECK_RESIDUAL(worst, 2e-12, "accelerations and forces of samples");
    CHECK(place == 0);
}

TEST(methods_without_terms_refuse_real_pendulums_in_words) {
    static const char *const name[] = {"symplectic", "linear"};
    unsigned long long seed = 3;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_DAMPING, &seed);
    for (int i = 0; i < 2; i++) {
        struct pend_problem problem = {.tree = t.tree,
                                       .loads = b.loads,
                                       .phi = t.phi,
                                       .rate = t.rate,
                                       .times = {.count = 2, .span = 1, .divisor = 1}};
        struct pend_run *run;
        struct pend_error error;
        CHECK(pend_run_new(&run, pend_method_find(name[i]), &problem, &error) == PEND_INVALID);
        CHECK(strstr(error.text, "use method taylor") != NULL);
    }
}

/* jobs are carried from part to part: the work, the heat and the drift of the balance too */
TEST(motions_of_real_pendulums_carried_after_every_call_have_the_same_bits) {
    const struct pend_method *method[] = {pend_method_find("taylor"), pend_method_find("rkf45"),
                                          pend_method_find("rk8pd"), pend_method_find("ode23"),
                                          pend_method_find("taylor")->extended};
    unsigned long long seed = 17;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    test_tree_random(&t, TEST_TREE_LIMBS, 3, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_ALL, &seed);
    for (int i = 0; i < 5; i++) {
        struct pend_problem problem = {.tree = t.tree,
                                       .loads = b.loads,
                                       .phi = t.phi,
                                       .rate = t.rate,
                                       .times = {.count = 9, .start = 3, .span = 1, .divisor = 8},
                                       .rtol = i == 3 ? 1e-5 : 1e-9};
        OWN(test_record, clear) whole, carried;
        test_record_blocks(&whole, method[i], &problem, 2, 1);
        test_record_carried(&carried, method[i], &problem, 2, 1);
        CHECK_SAYING(whole.status == PEND_OK && test_record_same(&whole, &carried), "%d", i);
        CHECK_SAYING(
            carried.stats.energy_drift == whole.stats.energy_drift && whole.stats.energy_drift > 0,
            "%s: %g, %g", method[i]->name, carried.stats.energy_drift, whole.stats.energy_drift);
    }
}
