/* Tests of the fast kernels of real pendulums (core/taylor/jets_loads): torques between arms, a
 * driven pivot and bodies, on all small trees, and without bodies on large ones divided in every
 * way, against quadruple precision and against the general kernel.
 * Leaves to others: ideal pendulums (test_jets), steps and runs (test_bodies_quad,
 * test_real_pendulums).
 * Invariant: residuals are relative to the largest value among the arms. */
#include "core/taylor/jets_loads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/taylor/jets/jets.h"
#include "tests/harness/bodies.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 104, ORDER = 20 };

static const unsigned loads[] = {TEST_TERMS_SPRINGS, TEST_TERMS_DAMPING, TEST_TERMS_TORQUES,
                                 TEST_TERMS_PIVOT,   TEST_TERMS_RODS,    TEST_TERMS_DRAG_PER_MASS};
enum { LOADS = sizeof loads / sizeof *loads };

/* a state and the series about it */
struct scene {
    struct pend_jets jets;
    _Alignas(64) double phi[ARMS], low[ARMS], rate[ARMS];
    double work[ORDER], heat[ORDER];
    struct jets_state state;
    void *memory;
};

static void scene_open(struct scene *s, const struct test_tree *t, const struct pend_loads *given,
                       double unit, enum pend_isa isa) {
    memset(s, 0, sizeof *s);
    memcpy(s->phi, t->phi, (size_t)t->n * sizeof(double));
    memcpy(s->rate, t->rate, (size_t)t->n * sizeof(double));
    s->state = (struct jets_state){
        .phi = s->phi, .phi_low = s->low, .rate = s->rate, .rate_low = s->low, .time = 11};
    s->memory = aligned_alloc(64, (pend_jets_bytes(t->tree, given->terms, ORDER) + 63) / 64 * 64);
    if (!s->memory) abort();
    pend_jets_init(&s->jets, t->tree, given, ORDER, s->memory);
    s->jets.isa = isa;
    pend_jets_expand(&s->jets, given, unit, &s->state, ORDER);
    pend_jets_power(&s->jets, unit, ORDER, ORDER, s->work, s->heat);
    pend_jets_forces(&s->jets, ORDER);
}

/* the same pendulum with a drag of 0, which only the general kernel supports */
struct twin {
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
};

static void twin_open(struct twin *twin, const struct test_bodies *b) {
    const struct pend_terms *own = b->terms;
    unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_DRAG] = 1}, ones[PEND_TERM_ONES] = {0};
    int drives[8], place[8];
    size_t bytes = (size_t)own->n * sizeof(double);
    for (int r = 0; r < PEND_TERM_ROWS; r++) rows[r] |= own->row[r] >= 0;
    for (int i = 0; i < PEND_TERM_ONES; i++) ones[i] = own->one[i] >= 0;
    for (int i = 0; i < own->harmonics; i++) drives[i] = own->harmonic[i].drives;
    if (pend_terms_new(&twin->terms, own->n, rows, ones, own->harmonics, drives, place) != PEND_OK)
        abort();
    memcpy(twin->terms->hung, own->hung, (size_t)own->n);
    twin->value = calloc((size_t)twin->terms->count, sizeof(double));
    if (!twin->value) abort();
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (own->row[r] >= 0)
            memcpy(twin->value + twin->terms->row[r], b->value + own->row[r], bytes);
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (own->one[i] >= 0) twin->value[twin->terms->one[i]] = b->value[own->one[i]];
    for (int i = 0; i < own->harmonics; i++)
        memcpy(twin->value + twin->terms->harmonic[i].at, b->value + own->harmonic[i].at,
               3 * sizeof(double));
    twin->loads = (struct pend_loads){b->loads.gravity, twin->terms, twin->value};
}

static void twin_close(struct twin *twin) {
    pend_terms_free(&twin->terms);
    free(twin->value);
}

/* the sum of orders 0 .. last of a series at x */
static double sum_of(const double *at, size_t step, int last, double x) {
    double sum = 0;
    for (int j = last; j >= 0; j--) sum = sum * x + at[(size_t)j * step];
    return sum;
}

/* the largest errors, relative to the largest values: phi'' and lambda at the start against
 * quadruple precision, and rates, lambda, work and heat a part of a step later against the general
 * kernel */
struct errors {
    double acc, force, rates, forces, work, heat;
    int chains, blocks; /* how often each division occurred */
};

static void keep(double *worst, double gap) {
    if (!(gap <= *worst)) *worst = gap;
}

static void start_errors(struct errors *worst, const struct test_tree *t,
                         const struct pend_loads *given, const struct scene *s, double unit) {
    test_quad phi[ARMS], rate[ARMS], acc[ARMS], force[4][ARMS];
    double own[ARMS], tip[ARMS], most = 0, gap = 0;
    for (int k = 0; k < t->n; k++) phi[k] = s->phi[k], rate[k] = s->rate[k];
    struct test_quad_state state = {phi, rate, 11};
    struct test_quad_forces forces = {force[0], force[1], force[2], force[3]};
    test_quad_bodies(t->tree, given, &state, acc, &forces);
    for (int k = 0; k < t->n; k++) {
        own[k] = s->jets.rate[pend_jets_place(&s->jets, k, 1)] / (unit * unit);
        tip[k] = s->jets.force[pend_jets_place(&s->jets, k, 0)] / (unit * unit);
        gap = fmax(gap, (double)test_quad_abs(tip[k] - force[2][k]));
        for (int i = 0; i < 4; i++) most = fmax(most, (double)test_quad_abs(force[i][k]));
    }
    keep(&worst->acc, test_quad_gap(t->n, own, acc));
    keep(&worst->force, gap / most);
}

static void series_errors(struct errors *worst, int n, const struct scene *s,
                          const struct scene *general, double x) {
    double own[2][ARMS], want[2][ARMS];
    for (int k = 0; k < n; k++) {
        size_t at = pend_jets_place(&s->jets, k, 0), to = pend_jets_place(&general->jets, k, 0);
        size_t step = pend_jets_place(&s->jets, k, 1) - at;
        size_t other = pend_jets_place(&general->jets, k, 1) - to;
        own[0][k] = sum_of(s->jets.rate + at, step, ORDER, x);
        own[1][k] = sum_of(s->jets.force + at, step, ORDER - 1, x);
        want[0][k] = sum_of(general->jets.rate + to, other, ORDER, x);
        want[1][k] = sum_of(general->jets.force + to, other, ORDER - 1, x);
    }
    keep(&worst->rates, test_gap(n, own[0], want[0]));
    keep(&worst->forces, test_gap(n, own[1], want[1]));
    double scale = 0, work = sum_of(general->work, 1, ORDER - 1, x);
    double heat = sum_of(general->heat, 1, ORDER - 1, x);
    for (int k = 0; k < n; k++) scale = fmax(scale, fabs(want[0][k] * want[1][k]));
    scale = fmax(scale, fmax(fabs(work), fabs(heat)));
    keep(&worst->work, fabs(sum_of(s->work, 1, ORDER - 1, x) - work) / scale);
    keep(&worst->heat, fabs(sum_of(s->heat, 1, ORDER - 1, x) - heat) / scale);
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

static void pendulum_errors(struct errors *worst, const struct test_tree *t, unsigned what,
                            double decades, enum pend_isa isa, unsigned long long *seed) {
    OWN(test_bodies, clear) b;
    OWN(twin, close) twin;
    struct scene quick, general;
    double unit = what % 3 ? 0.0625 : -0.0625;
    test_bodies_random(&b, t->tree, what, seed);
    if (decades > 0) bodies_spread(&b, decades, seed);
    twin_open(&twin, &b);
    scene_open(&quick, t, &b.loads, unit, isa);
    scene_open(&general, t, &twin.loads, unit, isa);
    CHECK(quick.jets.real && !quick.jets.general && general.jets.general);
    worst->chains += quick.jets.system.chain != NULL;
    worst->blocks += quick.jets.system.blocks != NULL;
    start_errors(worst, t, &b.loads, &quick, unit);
    double reach = pend_jets_reach(&quick.jets, ORDER, log2(1e-14), log2(1e-14));
    for (int i = 0; i <= 2; i++) series_errors(worst, t->n, &quick, &general, 0.5 * i * reach);
    free(quick.memory);
    free(general.memory);
}

TEST(quick_kernels_have_the_series_of_the_general_one_with_any_loads_on_all_small_trees) {
    unsigned long long seed = 1;
    struct errors worst = {0};
    int trees = 0;
    for (int n = 1; n <= 8; n++) {
        int parent[ARMS];
        test_parents_first(n, parent);
        // some of those with seven and eight arms
        for (int i = 0, more = 1; more; i++, more = test_parents_next(n, parent)) {
            if (n > 6 && i % 97) continue;
            unsigned what = 0;
            for (int bit = 0; bit < LOADS; bit++)
                if ((trees % 63 + 1) >> bit & 1) what |= loads[bit];
            struct test_tree t;
            test_tree_init(&t, n, parent, 0.3, &seed);
            pendulum_errors(&worst, &t, what, 0, (enum pend_isa)(trees % (pend_isa_best() + 1)),
                            &seed);
            test_tree_clear(&t);
            trees++;
        }
    }
    CHECK_INT(trees, 154 + 8 + 52);
    CHECK_RESIDUAL(worst.acc, 1e-13, "phi'' against quadruple precision");
    CHECK_RESIDUAL(worst.force, 1e-13, "lambda against quadruple precision");
    CHECK_RESIDUAL(worst.rates, 1e-13, "rates within a step against the general kernel");
    CHECK_RESIDUAL(worst.forces, 1e-12, "lambda within a step against the general kernel");
    CHECK_RESIDUAL(worst.work, 1e-12, "work within a step against the general kernel");
    CHECK_RESIDUAL(worst.heat, 1e-14, "heat within a step against the general kernel");
}

TEST(quick_kernels_keep_the_digits_of_bodies_whose_masses_differ_by_many_decades) {
    unsigned long long seed = 4;
    struct errors worst = {0};
    for (int i = 0; i < 200; i++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), 2 + i % 7, 4, &seed);
        pendulum_errors(&worst, &t, TEST_TERMS_RODS, 4, pend_isa_best(), &seed);
    }
    CHECK_RESIDUAL(worst.acc, 1e-13, "phi'' against quadruple precision");
    CHECK_RESIDUAL(worst.force, 1e-12, "lambda against quadruple precision");
    CHECK_RESIDUAL(worst.rates, 1e-13, "rates within a step against the general kernel");
    CHECK_RESIDUAL(worst.forces, 1e-12, "lambda within a step against the general kernel");
}

TEST(quick_kernels_of_large_trees_have_the_series_of_the_general_one_with_any_loads) {
    static const int arms[] = {9, 16, 23, 40, 64, 100};
    unsigned long long seed = 4;
    struct errors worst = {0};
    int i = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        for (size_t size = 0; size < sizeof arms / sizeof *arms; size++, i++) {
            unsigned what = 0;
            for (int bit = 0; bit < 4; bit++)
                if ((i % 15 + 1) >> bit & 1) what |= loads[bit];
            OWN(test_tree, clear) t;
            test_tree_random(&t, (enum test_tree_kind)kind, arms[size], 0.3, &seed);
            pendulum_errors(&worst, &t, what, 0, (enum pend_isa)(i % (pend_isa_best() + 1)), &seed);
        }
    CHECK(worst.chains >= 5 && worst.blocks >= 5);
    CHECK_RESIDUAL(worst.acc, 1e-13, "phi'' against quadruple precision");
    CHECK_RESIDUAL(worst.force, 1e-13, "lambda against quadruple precision");
    CHECK_RESIDUAL(worst.rates, 1e-13, "rates within a step against the general kernel");
    CHECK_RESIDUAL(worst.forces, 1e-12, "lambda within a step against the general kernel");
    CHECK_RESIDUAL(worst.work, 1e-12, "work within a step against the general kernel");
    CHECK_RESIDUAL(worst.heat, 1e-14, "heat within a step against the general kernel");
}

TEST(quick_kernels_with_loads_have_the_same_bits_in_avx2_and_avx512) {
    unsigned long long seed = 2;
    enum pend_isa best = pend_isa_best(), least = best < PEND_ISA_AVX2 ? best : PEND_ISA_AVX2;
    for (int i = 0; i < 60; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct scene one, other;
        int large = i % 3 == 2, n = large ? 9 + i : 1 + i % 8;
        unsigned what = loads[i % LOADS] | loads[i / LOADS % LOADS];
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, 0.3, &seed);
        test_bodies_random(&b, t.tree, large ? what & ~(unsigned)TEST_TERMS_RODS : what, &seed);
        scene_open(&one, &t, &b.loads, 0.0625, least);
        scene_open(&other, &t, &b.loads, 0.0625, best);
        int differ = memcmp(one.work, other.work, sizeof one.work) != 0 ||
                     memcmp(one.heat, other.heat, sizeof one.heat) != 0;
        for (int k = 0; k < t.n; k++)
            for (int j = 0; j <= ORDER; j++) {
                size_t at = pend_jets_place(&one.jets, k, j);
                differ |= memcmp(one.jets.rate + at, other.jets.rate + at, sizeof(double)) != 0;
                if (j == ORDER) continue;
                differ |= memcmp(one.jets.force + at, other.jets.force + at, sizeof(double)) != 0;
            }
        CHECK(!differ);
        free(one.memory);
        free(other.memory);
    }
}

TEST(quick_kernels_take_no_pendulum_with_any_other_term) {
    unsigned long long seed = 3;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
    int taken = 0;
    for (int i = 0; i < PEND_TERM_ROWS + PEND_TERM_ONES; i++) {
        unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
        OWN(pend_terms, free) *terms;
        if (i < PEND_TERM_ROWS)
            rows[i] = 1;
        else
            ones[i - PEND_TERM_ROWS] = 1;
        REQUIRE(pend_terms_new(&terms, 2, rows, ones, 0, NULL, NULL) == PEND_OK);
        taken += jets_loads_suit(t.tree, terms);
    }
    // all terms of masses and attachment points, damping, stiffness and rest, torque, drag per
    // mass, the two of the pivot's acceleration, and the four of a piece
    CHECK_INT(taken, 7 + 4 + 3 + 4);
}

TEST(quick_kernels_with_loads_write_nothing_behind_the_memory_that_they_ask_for) {
    enum { GUARD = 4096, NEAR = 4 };
    unsigned long long seed = 4;
    for (int n = 1; n <= 12; n++) {
        OWN(test_tree, clear) t;
        OWN(pend_terms, free) *terms;
        struct pend_jets jets;
        unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_DAMPING] = 1}, ones[PEND_TERM_ONES] = {0};
        test_tree_random(&t, TEST_TREE_CHAIN, n, 0.3, &seed);
        REQUIRE(pend_terms_new(&terms, n, rows, ones, 0, NULL, NULL) == PEND_OK);
        OWN_MEMORY double *value = calloc((size_t)terms->count, sizeof *value);
        size_t bytes = pend_jets_bytes(t.tree, terms, NEAR), all = (bytes + GUARD + 63) / 64 * 64;
        OWN_MEMORY char *memory = aligned_alloc(64, all);
        REQUIRE(value && memory);
        memset(memory, 0x55, all);
        const struct pend_loads given = {.gravity = 9.81, .terms = terms, .value = value};
        pend_jets_init(&jets, t.tree, &given, NEAR, memory);
        size_t written = all;
        while (written > 0 && memory[written - 1] == 0x55) written--;
        CHECK(written <= bytes);
    }
}
