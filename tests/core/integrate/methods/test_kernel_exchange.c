/* Tests of kernel_exchange: work and heat at nodes against the integrals of the power's series, and
 * with fast drives against the energy.
 * Leaves to others: motions with friction and slow drives (tests/laws/test_real_pendulums).
 * Invariant: all pendulums are random, from seeds. */
#include "core/integrate/methods/kernel_exchange.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/methods/exchange.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 40, ORDER = 24 };

static const struct exchange_kernel *kernel_of(enum pend_isa isa) {
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_kernel_exchange_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_exchange_avx2;
#endif
    (void)isa;
    return &pend_kernel_exchange_base;
}

/* the state about which a pendulum's series are computed, and their memory */
struct scene {
    _Alignas(64) double state[4][ARMS + 8];
    struct jets_state start;
    struct pend_jets jets;
    void *memory;
};

static void scene_open(struct scene *s, const struct test_tree *t, const struct test_bodies *b) {
    size_t bytes = pend_jets_bytes(t->tree, b->terms, ORDER);
    memset(s, 0, sizeof *s);
    s->memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!s->memory) abort();
    memcpy(s->state[0], t->phi, (size_t)t->n * sizeof(double));
    memcpy(s->state[2], t->rate, (size_t)t->n * sizeof(double));
    s->start = (struct jets_state){.phi = s->state[0],
                                   .phi_low = s->state[1],
                                   .rate = s->state[2],
                                   .rate_low = s->state[3],
                                   .time = 2};
    pend_jets_init(&s->jets, t->tree, &b->loads, ORDER, s->memory);
}

/* the largest error of a kernel relative to the exchanged energy, in a part of a step in which the
 * product of two series is accurate to rounding */
static double gap_of(const struct test_tree *t, const struct test_bodies *b, int *taken) {
    struct scene s;
    double worst = 0;
    scene_open(&s, t, b);
    *taken = pend_exchange_at_nodes(&s.jets);
    struct exchange_given first[PEND_ISA_COUNT];
    for (enum pend_isa isa = PEND_ISA_BASE; *taken && isa <= pend_isa_best(); isa++) {
        const double unit = -0x1p-4;
        struct pend_exchange series = {.order = ORDER, .unit = unit};
        s.jets.isa = isa;
        pend_jets_expand(&s.jets, &b->loads, unit, &s.start, ORDER);
        double x = pend_jets_reach(&s.jets, ORDER, log2(1e-12), log2(1e-12)) / 8;
        pend_jets_power(&s.jets, unit, ORDER, ORDER, series.work.series, series.heat.series);
        pend_exchange_take(&series, x);
        first[isa] = kernel_of(isa)->given(&s.jets, &b->loads, unit, ORDER, x);
        double most = fabs(series.work.end) + fabs(series.heat.end);
        double gap =
            fmax(fabs(first[isa].work - series.work.end), fabs(first[isa].heat - series.heat.end));
        if (!(gap <= worst * most)) worst = gap / most;
        CHECK(most > 0);
    }
    if (*taken && pend_isa_best() == PEND_ISA_AVX512)
        CHECK(!memcmp(&first[PEND_ISA_AVX2], &first[PEND_ISA_AVX512], sizeof *first));
    free(s.memory);
    return worst;
}

TEST(exchange_at_nodes_is_the_integral_of_the_powers_series_in_every_instruction_set) {
    static const unsigned terms[] = {TEST_TERMS_DAMPING,
                                     TEST_TERMS_TORQUES,
                                     TEST_TERMS_PIVOT,
                                     TEST_TERMS_DAMPING | TEST_TERMS_PIVOT | TEST_TERMS_SPRINGS,
                                     TEST_TERMS_DAMPING | TEST_TERMS_TORQUES | TEST_TERMS_PIVOT,
                                     TEST_TERMS_RODS | TEST_TERMS_DAMPING};
    unsigned long long seed = 5;
    double worst = 0;
    int all = 0;
    for (int i = 0; i < 240; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        int n = i % 3 ? 1 + test_random_int(&seed, 8) : 9 + test_random_int(&seed, 31), taken;
        test_tree_random(&t, (enum test_tree_kind)(i % TEST_TREE_KINDS), n, 0.3, &seed);
        test_bodies_random(&b, t.tree, terms[i / 3 % 6], &seed);
        double gap = gap_of(&t, &b, &taken);
        if (!(gap <= worst)) worst = gap;
        all += taken;
    }
    CHECK_SAYING(all > 150, "%d pendulums at nodes", all);
    CHECK_RESIDUAL(worst, 1e-12, "work and heat at nodes");
}

/* the other properties of a chain on a fast pivot: points, rods, drag */
static double quick_drift(int n, int rods, int drag, unsigned long long *seed) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int drives[1] = {PEND_DRIVE_PIVOT_Y}, place[1], done = 0;
    double t[2], phi[2 * ARMS], value[2 * ARMS + 3];
    OWN(test_tree, clear) tree;
    OWN(pend_terms, free) *terms;
    test_tree_random(&tree, TEST_TREE_CHAIN, n, 0.1, seed);
    rows[PEND_TERM_ROD] = rods != 0, rows[PEND_TERM_DRAG] = drag != 0;
    if (!CHECK(pend_terms_new(&terms, n, rows, ones, 1, drives, place) == PEND_OK)) return NAN;
    if (!CHECK(terms->count <= (int)(sizeof value / sizeof *value))) return NAN;
    for (int i = 0; i < terms->count; i++) value[i] = 0.5;
    double *harmonic = value + terms->harmonic[0].at;
    harmonic[0] = 0.02, harmonic[1] = 1000, harmonic[2] = 0.3;
    const struct pend_problem problem = {.tree = tree.tree,
                                         .loads = {9.81, terms, value},
                                         .phi = tree.phi,
                                         .rate = tree.rate,
                                         .times = {.count = 2, .span = 1, .divisor = 1},
                                         .rtol = 1e-12};
    struct pend_samples samples = {.cap = 2, .t = t, .phi = phi};
    OWN(pend_run, free) *run;
    if (!CHECK(pend_run_new(&run, &pend_method_taylor, &problem, NULL) == PEND_OK)) return NAN;
    CHECK(pend_run_next(run, &samples, 1e12, &done, NULL) == PEND_OK && done);
    return pend_run_stats(run).energy_drift;
}

/* A product of two series to order 25 lost 5e-9 of the scale with a drive of 1000 rad/s. */
TEST(exchange_with_quick_drives_keeps_the_balance_of_energy) {
    unsigned long long seed = 6;
    double worst[3] = {0};
    for (int n = 1; n <= 16; n = n < 3 ? n + 1 : 16 * n / 3)
        for (int i = 0; i < 3; i++) {
            double drift = quick_drift(n, i == 1, i == 2, &seed);
            if (!(drift <= worst[i])) worst[i] = drift;
        }
    CHECK_RESIDUAL(worst[0], 2e-12, "drift of the balance with a drive of 1000 rad/s");
    CHECK_RESIDUAL(worst[1], 2e-12, "of rods");
    CHECK_RESIDUAL(worst[2], 1e-11, "with drag");
}

/* the largest error of a damped pendulum's heat, of 2 ORDER - 1 orders, relative to the sum of the
 * absolute values of the products of rates that it consists of */
static double product_gap(const struct test_tree *t, const struct test_bodies *b) {
    const double unit = -0x1p-4;
    double work[2 * ORDER], heat[2 * ORDER], worst = 0;
    struct scene s;
    scene_open(&s, t, b);
    CHECK(s.jets.general);
    pend_jets_expand(&s.jets, &b->loads, unit, &s.start, ORDER);
    pend_jets_power(&s.jets, unit, ORDER, 2 * ORDER - 1, work, heat);
    for (int k = 0; k < 2 * ORDER - 1; k++) {
        double sum = 0, size = 0;
        for (int a = 0; a < t->n; a++) {
            int p = pend_terms_holder(b->terms, t->tree->parent, a);
            double c = unit * pend_terms_get(b->terms, b->loads.value, PEND_TERM_DAMPING, a);
            double slip[ORDER];
            for (int j = 0; j < ORDER; j++) {
                const double *rate = s.jets.bodies.rate + (size_t)j * s.jets.bodies.stride;
                slip[j] = rate[bodies_row(&s.jets.bodies, a)];
                if (p >= 0) slip[j] -= rate[bodies_row(&s.jets.bodies, p)];
            }
            for (int j = k < ORDER ? 0 : k - ORDER + 1; j <= k && j < ORDER; j++) {
                sum += c * slip[j] * slip[k - j];
                size += fabs(c * slip[j] * slip[k - j]);
            }
        }
        if (!(fabs(heat[k] - sum) <= worst * size)) worst = fabs(heat[k] - sum) / size;
        CHECK(work[k] == 0);
    }
    free(s.memory);
    return worst;
}

/* When runs truncated them at the orders of their factors, the balance of one arm with dry friction
 * drifted twice as far. */
TEST(the_powers_of_a_general_pendulum_have_all_orders_of_a_product) {
    unsigned long long seed = 7;
    double worst = 0;
    for (int i = 0; i < 40; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        test_tree_random(&t, TEST_TREE_LIMBS, 2 + i % 11, 0.3, &seed);
        test_bodies_random(&b, t.tree, TEST_TERMS_CART | TEST_TERMS_RODS | TEST_TERMS_DAMPING,
                           &seed);
        double gap = product_gap(&t, &b);
        if (!(gap <= worst)) worst = gap;
    }
    CHECK_RESIDUAL(worst, 1e-13, "heat as a product of series");
}
