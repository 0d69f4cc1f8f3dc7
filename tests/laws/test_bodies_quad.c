/* Laws: the general kernel has the accelerations and forces of the Lagrangian equations in
 * quadruple precision, on all small trees, with every term alone and all together, and on trees
 * that break less careful forms.
 * Leaves to others: motions (test_real_pendulums).
 * Invariant: residuals are relative to the largest value among the arms unless stated otherwise. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/taylor/jets/jets.h"
#include "tests/harness/bodies.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 200 };

/* the general kernel's answer */
struct answer {
    double acc[ARMS], force[4][ARMS];
};

/* the exact one */
struct truth {
    test_quad acc[ARMS], force[4][ARMS];
};

/* the largest errors of phi'' and of the forces */
struct gaps {
    double acc, force;
};

static void answer_of(const struct test_tree *t, const struct pend_loads *loads, double time,
                      struct answer *a) {
    struct bodies_state state = {t->phi, NULL, t->rate, time, 0};
    struct bodies_forces forces = {a->force[0], a->force[1], a->force[2], a->force[3]};
    OWN_MEMORY void *work =
        aligned_alloc(64, (pend_bodies_bytes(t->tree, loads->terms) + 63) / 64 * 64);
    if (!work) abort();
    pend_bodies_at(t->tree, loads, &state, work, a->acc, &forces);
}

static void truth_of(const struct test_tree *t, const struct pend_loads *loads, double time,
                     struct truth *exact) {
    test_quad phi[ARMS], rate[ARMS];
    for (int k = 0; k < t->n; k++) phi[k] = t->phi[k], rate[k] = t->rate[k];
    struct test_quad_state state = {phi, rate, time};
    struct test_quad_forces forces = {exact->force[0], exact->force[1], exact->force[2],
                                      exact->force[3]};
    test_quad_bodies(t->tree, loads, &state, exact->acc, &forces);
}

/* the largest error of the forces, relative to the largest force at any end of any arm */
static double force_gap(int n, const struct answer *a, const struct truth *exact) {
    double most = 0, gap = 0;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < n; k++) {
            double size = (double)test_quad_abs(exact->force[i][k]);
            double here = (double)test_quad_abs(a->force[i][k] - exact->force[i][k]);
            if (size > most) most = size;
            if (!(here <= gap)) gap = here;
        }
    return gap / most;
}

static struct gaps gaps_of(const struct test_tree *t, const struct pend_loads *loads, double time,
                           const struct truth *exact) {
    struct answer a;
    answer_of(t, loads, time, &a);
    return (struct gaps){test_quad_gap(t->n, a.acc, exact->acc), force_gap(t->n, &a, exact)};
}

static void gaps_keep(struct gaps *most, struct gaps here) {
    if (!(here.acc <= most->acc)) most->acc = here.acc;
    if (!(here.force <= most->force)) most->force = here.force;
}

/* each kind of term alone, then all, a cart alone, a cart with all terms that it supports, a
 * piece */
static unsigned terms_of(unsigned what) {
    if (what == 8) return TEST_TERMS_ALL;
    if (what == 11) return TEST_TERMS_ALL | TEST_TERMS_PIECES;
    return what < 8 ? 1u << what : what == 9 ? TEST_TERMS_CART : TEST_TERMS_CART_ALL;
}

TEST(law_bodies_have_the_accelerations_and_forces_of_quadruple_precision_on_all_small_trees) {
    unsigned long long seed = 21;
    struct gaps quick = {0};
    int trees = 0;
    for (unsigned what = 0; what <= 11; what++) {
        unsigned terms = terms_of(what);
        for (int n = 1; n <= (what == 8 ? 6 : 5); n++) {
            int parent[ARMS];
            test_parents_first(n, parent);
            do {
                struct test_tree t;
                struct test_bodies b;
                struct truth exact;
                double time = 100 * test_random(&seed) - 50;
                test_tree_init(&t, n, parent, 0.5, &seed);
                test_bodies_random(&b, t.tree, terms, &seed);
                truth_of(&t, &b.loads, time, &exact);
                gaps_keep(&quick, gaps_of(&t, &b.loads, time, &exact));
                test_bodies_clear(&b);
                test_tree_clear(&t);
                trees++;
            } while (test_parents_next(n, parent));
        }
    }
    CHECK_INT(trees, 11 * 34 + 154);
    CHECK_RESIDUAL(quick.acc, 1e-13, "phi'' of the general kernel");
    CHECK_RESIDUAL(quick.force, 1e-13, "forces of the general kernel");
}

/* spreads the masses of rods and bodies over 10^±decades */
static void bodies_spread(const struct test_bodies *b, double decades, unsigned long long *seed) {
    const int *row = b->terms->row;
    for (int k = 0; k < b->terms->n && row[PEND_TERM_ROD] >= 0; k++) {
        double body = pow(10, decades * (2 * test_random(seed) - 1));
        b->value[row[PEND_TERM_ROD] + k] *= pow(10, decades * (2 * test_random(seed) - 1));
        b->value[row[PEND_TERM_BODY] + k] *= body;
        b->value[row[PEND_TERM_INERTIA] + k] *= body;
    }
}

/* the largest errors over random trees of all kinds with up to `most` arms */
static struct gaps gaps_wild(unsigned what, double decades, int least, int most, int count,
                             unsigned long long *seed) {
    struct gaps worst = {0, 0};
    for (int i = 0; i < count; i++) {
        static struct truth exact;
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        int n = least + test_random_int(seed, most - least + 1);
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, decades, seed);
        test_bodies_random(&b, t.tree, what, seed);
        bodies_spread(&b, decades, seed);
        truth_of(&t, &b.loads, 3, &exact);
        gaps_keep(&worst, gaps_of(&t, &b.loads, 3, &exact));
    }
    return worst;
}

/* the largest errors on all trees of up to 5 arms whose masses differ by 10^±decades */
static struct gaps gaps_small(unsigned what, double decades, unsigned long long *seed) {
    struct gaps worst = {0, 0};
    for (int n = 1; n <= 5; n++) {
        int parent[ARMS];
        test_parents_first(n, parent);
        do {
            static struct truth exact;
            OWN(test_tree, clear) t;
            OWN(test_bodies, clear) b;
            test_tree_init(&t, n, parent, decades, seed);
            test_bodies_random(&b, t.tree, what, seed);
            bodies_spread(&b, decades, seed);
            truth_of(&t, &b.loads, 5, &exact);
            gaps_keep(&worst, gaps_of(&t, &b.loads, 5, &exact));
        } while (test_parents_next(n, parent));
    }
    return worst;
}

/* A heavy point mass on a light joint is pulled by a force that is small compared with its mass
 * times any acceleration from which it is computed: m (l chi + a) had errors of 2e-8 of the largest
 * force. */
TEST(law_forces_between_heavy_masses_and_light_joints_keep_their_digits) {
    static const struct {
        double decades, bound, rods_bound;
        const char *points, *rods;
    } far[] = {{4, 3e-12, 1e-13, "forces of loaded points of 10^-4 to 10^4 kg", "of rods, too"},
               {6, 3e-12, 3e-12, "forces of loaded points of 10^-6 to 10^6 kg", "of rods, too"}};
    unsigned long long seed = 26;
    for (int i = 0; i < 2; i++) {
        double points = 0, rods = 0;
        for (unsigned what = 0; what <= 8; what++) {
            struct gaps small = gaps_small(terms_of(what), far[i].decades, &seed);
            struct gaps large = gaps_wild(terms_of(what), far[i].decades, 2, 13, 42, &seed);
            double most = fmax(small.force, large.force);
            if (terms_of(what) & TEST_TERMS_RODS)
                rods = fmax(rods, most);
            else
                points = fmax(points, most);
        }
        CHECK_RESIDUAL(points, far[i].bound, far[i].points);
        CHECK_RESIDUAL(rods, far[i].rods_bound, far[i].rods);
    }
}

TEST(law_bodies_keep_their_digits_in_long_trees_of_rods_and_where_masses_differ_by_many_decades) {
    unsigned long long seed = 22;
    struct gaps rods = gaps_wild(TEST_TERMS_RODS, 0.3, 40, 80, 14, &seed);
    struct gaps unlike = gaps_wild(TEST_TERMS_RODS, 4, 2, 13, 210, &seed);
    const unsigned loaded = TEST_TERMS_ALL & ~(unsigned)TEST_TERMS_RODS;
    struct gaps points = gaps_wild(loaded, 2, 2, 13, 210, &seed);
    struct gaps far = gaps_wild(loaded, 6, 2, 13, 210, &seed);
    CHECK_RESIDUAL(rods.acc, 1e-14, "phi'' of rods in trees of 40 to 80 arms");
    CHECK_RESIDUAL(rods.force, 2e-14, "their forces");
    CHECK_RESIDUAL(unlike.acc, 1e-13, "phi'' of rods and bodies of 10^-4 to 10^4 kg");
    CHECK_RESIDUAL(unlike.force, 1e-13, "their forces");
    CHECK_RESIDUAL(points.acc, 1e-13, "phi'' of loaded arms of 10^-2 to 10^2 kg");
    CHECK_RESIDUAL(points.force, 1e-13, "their forces");
    CHECK_RESIDUAL(far.acc, 1e-12, "phi'' of loaded arms of 10^-6 to 10^6 kg");
    CHECK_RESIDUAL(far.force, 1e-12, "their forces");
}

TEST(law_an_ideal_tree_whose_terms_are_all_zero_moves_as_without_them) {
    unsigned long long seed = 23;
    struct gaps paper = {0, 0};
    double acc = 0, tip = 0, across = 0;
    for (int n = 1; n <= 6; n++) {
        int parent[ARMS];
        test_parents_first(n, parent);
        do {
            OWN(test_tree, clear) t;
            OWN(test_bodies, clear) b;
            struct answer quick, ideal;
            test_quad exact_acc[ARMS], exact_tip[ARMS];
            test_tree_init(&t, n, parent, 0.3, &seed);
            test_bodies_random(&b, t.tree, TEST_TERMS_ALL | TEST_TERMS_PIECES, &seed);
            pend_terms_clear(b.terms, t.tree, b.value);
            memset(b.terms->hung, 0, (size_t)n);
            answer_of(&t, &b.loads, 7, &quick);
            test_tree_dynamics(&t, TEST_LOADS(9.81), ideal.acc, ideal.force[2]);
            test_quad_dynamics(t.tree, TEST_LOADS(9.81), t.phi, t.rate, exact_acc, exact_tip);
            acc = fmax(acc, test_gap(n, quick.acc, ideal.acc));
            tip = fmax(tip, test_gap(n, quick.force[2], ideal.force[2]));
            gaps_keep(&paper, (struct gaps){test_quad_gap(n, quick.acc, exact_acc),
                                            test_quad_gap(n, quick.force[2], exact_tip)});
            // an ideal arm transmits no force across it, and the same along it at both ends
            for (int k = 0; k < n; k++) {
                double most = fabs(quick.force[2][k]) + fabs(quick.force[3][k]);
                across = fmax(across, fabs(quick.force[1][k]) / most);
                across = fmax(across, fabs(quick.force[0][k] - quick.force[2][k]) / most);
            }
        } while (test_parents_next(n, parent));
    }
    CHECK_RESIDUAL(acc, 1e-13, "phi'' with and without terms");
    CHECK_RESIDUAL(tip, 1e-13, "forces with and without terms");
    CHECK_RESIDUAL(paper.acc, 1e-13, "phi'' against the paper's form");
    CHECK_RESIDUAL(paper.force, 1e-13, "forces against the paper's form");
    CHECK_RESIDUAL(across, 1e-14, "force across, and difference of the forces along an arm");
}

/* a step of a series: its errors against the dense form in quadruple precision */
struct step {
    double phi, rate; /* errors of the changes over the step, relative to the largest change */
    double known;     /* the exact change */
};

static void step_keep(struct step *worst, const struct test_tree *t, const struct test_bodies *b,
                      double unit) {
    enum { ORDER = 24 };
    _Alignas(64) double from[4][PEND_JETS_PAD] = {{0}}, to[4][PEND_JETS_PAD] = {{0}};
    test_quad phi[PEND_JETS_PAD], rate[PEND_JETS_PAD];
    size_t bytes = pend_jets_bytes(t->tree, b->terms, ORDER);
    void *memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!memory) abort();
    struct pend_jets jets;
    struct jets_state start = {
        .phi = from[0], .phi_low = from[1], .rate = from[2], .rate_low = from[3], .time = 11};
    struct jets_state end = {.phi = to[0], .phi_low = to[1], .rate = to[2], .rate_low = to[3]};
    for (int k = 0; k < t->n; k++) {
        phi[k] = from[0][k] = t->phi[k];
        rate[k] = from[2][k] = t->rate[k];
    }
    pend_jets_init(&jets, t->tree, &b->loads, ORDER, memory);
    pend_jets_expand(&jets, &b->loads, unit, &start, ORDER);
    double x = pend_jets_reach(&jets, ORDER, log2(1e-17), log2(1e-17));
    pend_jets_advance(&jets, ORDER, x, unit, &start, &end);
    free(memory);
    double known = test_quad_move(t->tree, &b->loads, phi, rate, 11, (test_quad)x * unit, 2);
    double error[2] = {0, 0}, most[2] = {0, 0};
    for (int k = 0; k < t->n; k++) {
        test_quad change[2] = {phi[k] - from[0][k], rate[k] - from[2][k]};
        test_quad gap[2] = {phi[k] - to[0][k] - to[1][k], rate[k] - to[2][k] - to[3][k]};
        for (int i = 0; i < 2; i++) {
            most[i] = fmax(most[i], (double)test_quad_abs(change[i]));
            if (!((double)test_quad_abs(gap[i]) <= error[i]))
                error[i] = (double)test_quad_abs(gap[i]);
        }
    }
    worst->known = fmax(worst->known, known / most[0]);
    if (!(error[0] / most[0] <= worst->phi)) worst->phi = error[0] / most[0];
    if (!(error[1] / most[1] <= worst->rate)) worst->rate = error[1] / most[1];
}

TEST(law_a_step_of_a_series_is_the_motion_of_the_dense_form_in_quadruple_precision) {
    unsigned long long seed = 24;
    struct step worst = {0, 0, 0};
    int steps = 0;
    for (unsigned what = 0; what <= 10; what++) {
        unsigned terms = terms_of(what);
        for (int n = 1; n <= (what == 8 ? 4 : 3); n++) {
            int parent[ARMS];
            test_parents_first(n, parent);
            do {
                struct test_tree t;
                struct test_bodies b;
                test_tree_init(&t, n, parent, 0.3, &seed);
                test_bodies_random(&b, t.tree, terms, &seed);
                step_keep(&worst, &t, &b, steps % 2 ? 0.125 : -0.125);
                test_bodies_clear(&b);
                test_tree_clear(&t);
                steps++;
            } while (test_parents_next(n, parent));
        }
    }
    CHECK_INT(steps, 10 * 4 + 10);
    CHECK(worst.known < 1e-18);
    CHECK_RESIDUAL(worst.phi, 1e-14, "angles after a step, of their largest change");
    CHECK_RESIDUAL(worst.rate, 1e-14, "rates after a step, of their largest change");
}
