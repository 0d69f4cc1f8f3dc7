/* Tests of core/bodies/tiles: series by tables of eight arms against the sweeps from arm to arm, on
 * trees of every kind, with bodies, arms hung anywhere, friction and drives.
 * Leaves to others: both against quadruple precision (laws, test_jets_loads).
 * Invariant: residuals are relative to the largest value among the arms. */
#include "core/bodies/tiles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/taylor/jets/jets.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 104, ORDER = 20 };

/* rates, forces, work and heat of half a step */
struct answer {
    double rate[ARMS], force[ARMS], gain[2];
};

/* the sum of orders 0 .. last of a series at x */
static double sum_of(const double *at, size_t step, int last, double x) {
    double sum = 0;
    for (int j = last; j >= 0; j--) sum = sum * x + at[(size_t)j * step];
    return sum;
}

/* a series in tiles, or by sweeps from arm to arm */
static void answer_of(const struct test_tree *t, const struct test_bodies *b, int tiled, double *x,
                      struct answer *a) {
    static _Alignas(64) double phi[ARMS], low[ARMS], rate[ARMS];
    struct jets_state state = {.phi = phi, .phi_low = low, .rate = rate, .rate_low = low};
    struct pend_jets jets;
    double work[ORDER], heat[ORDER];
    void *memory = aligned_alloc(64, pend_jets_bytes(t->tree, b->terms, ORDER));
    if (!memory) abort();
    state.time = 3;
    for (int k = 0; k < t->n; k++) phi[k] = t->phi[k], rate[k] = t->rate[k];
    pend_jets_init(&jets, t->tree, &b->loads, ORDER, memory);
    CHECK(jets.general && (jets.bodies.tiles != NULL) == pend_tiles_suit(t->tree));
    if (!tiled) jets.bodies.tiles = NULL;
    pend_jets_expand(&jets, &b->loads, 0.0625, &state, ORDER);
    pend_jets_power(&jets, 0.0625, ORDER, ORDER, work, heat);
    pend_jets_forces(&jets, ORDER);
    if (tiled) *x = 0.5 * pend_jets_reach(&jets, ORDER, log2(1e-14), log2(1e-14));
    for (int k = 0; k < t->n; k++) {
        size_t at = pend_jets_place(&jets, k, 0), step = pend_jets_place(&jets, k, 1) - at;
        a->rate[k] = sum_of(jets.rate + at, step, ORDER, *x);
        a->force[k] = sum_of(jets.force + at, step, ORDER - 1, *x);
    }
    a->gain[0] = sum_of(work, 1, ORDER - 1, *x);
    a->gain[1] = sum_of(heat, 1, ORDER - 1, *x);
    free(memory);
}

TEST(tiles_have_the_series_of_sweeps_from_arm_to_arm_on_trees_of_every_kind) {
    static const int arms[] = {9, 10, 11, 14, 16, 20, 23, 32, 40};
    static const unsigned terms[] = {TEST_TERMS_RODS, TEST_TERMS_RODS | TEST_TERMS_FRICTION,
                                     TEST_TERMS_ALL & ~TEST_TERMS_DRAG,
                                     TEST_TERMS_RODS | TEST_TERMS_PIVOT};
    unsigned long long seed = 9;
    double rates = 0, forces = 0, gains = 0;
    int i = 0, tiled = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        for (size_t size = 0; size < sizeof arms / sizeof *arms; size++, i++) {
            struct test_tree t;
            struct test_bodies b;
            struct answer one, other;
            double x = 0;
            test_tree_random(&t, (enum test_tree_kind)kind, arms[size], 0.3, &seed);
            test_bodies_random(&b, t.tree, terms[(i + i / 4) % 4], &seed);
            tiled += pend_tiles_suit(t.tree);
            answer_of(&t, &b, 1, &x, &one);
            answer_of(&t, &b, 0, &x, &other);
            rates = fmax(rates, test_gap(t.n, one.rate, other.rate));
            forces = fmax(forces, test_gap(t.n, one.force, other.force));
            gains = fmax(gains, test_gap(2, one.gain, other.gain));
            test_bodies_clear(&b);
            test_tree_clear(&t);
        }
    CHECK(tiled >= 5);
    CHECK_RESIDUAL(rates, 1e-14, "rates within a step");
    CHECK_RESIDUAL(forces, 1e-14, "forces within a step");
    CHECK_RESIDUAL(gains, 1e-14, "work and heat within a step");
}
