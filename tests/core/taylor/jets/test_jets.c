/* Tests of core/taylor/jets/jets: the series satisfy the equations of motion throughout a step, for
 * every small tree and for extreme ones. Leaves to others: steps (test_method_taylor), the
 * equations themselves (test_dynamics). Invariant: residuals are relative to the largest value
 * among the arms. */
#include "core/taylor/jets/jets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS_MAX = 256, ORDER = 20 };

/* a tree, a state, and its series */
struct scene {
    struct pend_tree *tree;
    struct pend_loads loads;
    _Alignas(64) double phi[ARMS_MAX], low[ARMS_MAX], rate[ARMS_MAX];
    struct pend_jets jets;
    struct jets_state state;
    void *block, *work;
};

static int scene_open(struct scene *s, int n, const int parent[], double decades,
                      unsigned long long *seed) {
    double len[ARMS_MAX], mass[ARMS_MAX];
    memset(s, 0, sizeof *s);
    for (int k = 0; k < n; k++) {
        len[k] = 0.5 + test_random(seed);
        mass[k] = pow(10, decades * (2 * test_random(seed) - 1));
        s->phi[k] = 6.3 * test_random(seed);
        s->rate[k] = 4 * test_random(seed) - 2;
    }
    s->loads.gravity = 9.81;
    s->state =
        (struct jets_state){.phi = s->phi, .phi_low = s->low, .rate = s->rate, .rate_low = s->low};
    if (pend_tree_new(&s->tree, n, len, mass, parent, NULL) != PEND_OK) return 0;
    s->block = aligned_alloc(64, pend_jets_bytes(s->tree, NULL, ORDER));
    s->work = aligned_alloc(64, (pend_dynamics_work_bytes(n) + 63) / 64 * 64);
    if (!s->block || !s->work) return 0;
    pend_jets_init(&s->jets, s->tree, TEST_LOADS(0), ORDER, s->block);
    // all instruction sets in turn
    s->jets.isa = (enum pend_isa)test_random_int(seed, (int)pend_isa_best() + 1);
    return 1;
}

static void scene_close(struct scene *s) {
    free(s->block);
    free(s->work);
    pend_tree_free(&s->tree);
}

/* sum of a series of one arm at x; what = 0 phi - phi(0), 1 phi', 2 phi'', 3 lambda, all in
 * units of the series */
static double series_at(const struct pend_jets *jets, int order, int k, double x, int what) {
    double sum = 0;
    for (int j = order; j >= 0; j--) {
        double c = jets->rate[pend_jets_place(jets, k, j)];
        if (what == 0) sum = sum * x + c / (j + 1);
        if (what == 1) sum = sum * x + c;
        if (what == 2 && j) sum = sum * x + c * j;
        if (what == 3 && j < order) sum = sum * x + jets->force[pend_jets_place(jets, k, j)];
    }
    return what ? sum : sum * x;
}

/* the x at which the trailing terms are eps of the leading ones */
static double series_reach(const struct pend_jets *jets, int n, double eps) {
    double lead = 0, reach = INFINITY;
    for (int k = 0; k < n; k++)
        lead = fmax(lead, fabs(jets->rate[pend_jets_place(jets, k, 0)]) +
                              fabs(jets->rate[pend_jets_place(jets, k, 1)]));
    for (int j = ORDER - 3; j <= ORDER; j++) {
        for (int k = 0; k < n; k++) {
            double c = fabs(jets->rate[pend_jets_place(jets, k, j)]);
            if (c > 0) reach = fmin(reach, pow(eps * lead / c, 1.0 / j));
        }
    }
    return reach;
}

/* largest differences of phi'' and lambda between series and equations, x units after the start */
static void scene_residual(struct scene *s, double unit, double x, double residual[2]) {
    int n = s->tree->n;
    double phi[ARMS_MAX] = {0}, rate[ARMS_MAX] = {0}, acc[ARMS_MAX], force[ARMS_MAX],
           scale[2] = {0}, worst[2] = {0};
    for (int k = 0; k < n; k++) {
        phi[k] = s->phi[k] + series_at(&s->jets, ORDER, k, x, 0);
        rate[k] = series_at(&s->jets, ORDER, k, x, 1) / unit;
    }
    pend_dynamics(s->tree, &s->loads, phi, rate, s->work, acc, force);
    for (int k = 0; k < n; k++) {
        double series[2] = {series_at(&s->jets, ORDER, k, x, 2),
                            series_at(&s->jets, ORDER, k, x, 3)};
        double want[2] = {acc[k], force[k]};
        for (int i = 0; i < 2; i++) {
            scale[i] = fmax(scale[i], fabs(want[i]));
            double error = fabs(series[i] / unit / unit - want[i]);
            if (!(error <= worst[i])) worst[i] = error;
        }
    }
    for (int i = 0; i < 2; i++) {
        double relative = worst[i] / scale[i];
        if (!(relative <= residual[i])) residual[i] = relative;
    }
}

/* next parent list of n arms, parent[k] < k; 0 after the last */
static int next_parents(int n, int parent[]) {
    for (int k = n - 1; k > 0; k--) {
        if (++parent[k] < k) return 1;
        parent[k] = 0;
    }
    return 0;
}

TEST(jets_obey_the_equations_of_motion_on_every_tree_of_up_to_eight_arms) {
    unsigned long long seed = 1;
    double residual[2] = {0, 0};
    int trees = 0;
    for (int n = 1; n <= 8; n++) {
        int parent[8] = {-1, 0, 0, 0, 0, 0, 0, 0};
        do {
            struct scene s;
            REQUIRE(scene_open(&s, n, parent, 0.3, &seed));
            double unit = trees % 2 ? 0.125 : -0.125;
            pend_jets_expand(&s.jets, &s.loads, unit, &s.state, ORDER);
            double x = series_reach(&s.jets, n, 1e-14);
            for (int i = 0; i <= 2; i++) scene_residual(&s, unit, 0.5 * i * x, residual);
            scene_close(&s);
            trees++;
        } while (next_parents(n, parent));
    }
    CHECK_INT(trees, 5914);
    CHECK_RESIDUAL(residual[0], 1e-11, "phi'' of the series against the equations");
    CHECK_RESIDUAL(residual[1], 1e-11, "lambda of the series against the equations");
}

static void random_parents(int n, int parent[], unsigned long long *seed) {
    parent[0] = -1;
    for (int k = 1; k < n; k++) {
        int back = 1 + test_random_int(seed, k < 4 ? k : 4);
        parent[k] = k - back;
    }
}

TEST(jets_obey_the_equations_of_motion_on_large_random_trees) {
    unsigned long long seed = 2;
    double residual[2] = {0, 0};
    for (int i = 0; i < 60; i++) {
        int parent[ARMS_MAX], n = 9 + test_random_int(&seed, ARMS_MAX - 9);
        random_parents(n, parent, &seed);
        OWN(scene, close) s;
        REQUIRE(scene_open(&s, n, parent, 0.3, &seed));
        pend_jets_expand(&s.jets, &s.loads, 0.0625, &s.state, ORDER);
        scene_residual(&s, 0.0625, series_reach(&s.jets, n, 1e-14), residual);
    }
    CHECK_RESIDUAL(residual[0], 1e-12, "phi'' of the series against the equations");
    CHECK_RESIDUAL(residual[1], 1e-12, "lambda of the series against the equations");
}

/* blocks of eight arms: complete and incomplete ones, with few and many branches, links to near and
 * far blocks */
TEST(jets_obey_the_equations_of_motion_on_large_trees_of_every_kind) {
    unsigned long long seed = 5;
    static const int sizes[] = {9, 15, 16, 17, 40, 65, 72, 127, 200, 255};
    double residual[2] = {0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            int parent[ARMS_MAX];
            struct scene s;
            test_parents((enum test_tree_kind)kind, sizes[i], parent, &seed);
            for (enum pend_isa isa = 0; isa <= pend_isa_best(); isa++) {
                REQUIRE(scene_open(&s, sizes[i], parent, 0.3, &seed));
                s.jets.isa = isa;
                pend_jets_expand(&s.jets, &s.loads, 0.0625, &s.state, ORDER);
                scene_residual(&s, 0.0625, series_reach(&s.jets, sizes[i], 1e-14), residual);
                scene_close(&s);
            }
        }
    }
    CHECK_RESIDUAL(residual[0], 1e-12, "phi'' of the series against the equations");
    CHECK_RESIDUAL(residual[1], 1e-12, "lambda of the series against the equations");
}

TEST(jets_have_the_same_bits_in_avx2_and_avx512) {
    unsigned long long seed = 6;
    enum pend_isa best = pend_isa_best(), least = best < PEND_ISA_AVX2 ? best : PEND_ISA_AVX2;
    for (int i = 0; i < 60; i++) {
        int parent[ARMS_MAX], n = i < 16 ? 1 + i : 1 + test_random_int(&seed, ARMS_MAX - 1);
        OWN(scene, close) s;
        test_parents((enum test_tree_kind)(i % TEST_TREE_KINDS), n, parent, &seed);
        REQUIRE(scene_open(&s, n, parent, 0.3, &seed));
        OWN_MEMORY double *first = malloc(sizeof(double) * (ORDER + 1) * (size_t)n);
        REQUIRE(first != NULL);
        int differ = 0;
        for (enum pend_isa isa = least; isa <= best; isa++) {
            s.jets.isa = isa;
            pend_jets_expand(&s.jets, &s.loads, 0.0625, &s.state, ORDER);
            for (int k = 0; k < n; k++) {
                for (int j = 0; j <= ORDER; j++) {
                    double x = s.jets.rate[pend_jets_place(&s.jets, k, j)];
                    if (isa == least) first[k * (ORDER + 1) + j] = x;
                    differ += first[k * (ORDER + 1) + j] != x;
                }
            }
        }
        CHECK_SAYING(!differ && first[1] != 0, "%d coefficients of %d arms differ", differ, n);
    }
}

/* the largest differences of phi'' and lambda at order 0 from the equations, relative to the
 * largest values */
static void scene_start(struct scene *s, double residual[2]) {
    int n = s->tree->n;
    double acc[ARMS_MAX], force[ARMS_MAX], scale[2] = {0, 0}, worst[2] = {0, 0};
    pend_jets_expand(&s->jets, &s->loads, 0.0625, &s->state, PEND_JETS_ORDER_MIN);
    pend_dynamics(s->tree, &s->loads, s->phi, s->rate, s->work, acc, force);
    for (int k = 0; k < n; k++) {
        double first = s->jets.rate[pend_jets_place(&s->jets, k, 1)] * 256;
        double error[2] = {fabs(first - acc[k]),
                           fabs(s->jets.force[pend_jets_place(&s->jets, k, 0)] * 256 - force[k])};
        scale[0] = fmax(scale[0], fabs(acc[k]));
        scale[1] = fmax(scale[1], fabs(force[k]));
        for (int i = 0; i < 2; i++) {
            if (!(error[i] <= worst[i])) worst[i] = error[i];
        }
    }
    for (int i = 0; i < 2; i++) {
        if (!(worst[i] / scale[i] <= residual[i])) residual[i] = worst[i] / scale[i];
    }
}

TEST(jets_keep_their_digits_at_order_zero_when_masses_differ_by_16_decades) {
    unsigned long long seed = 3;
    double residual[2] = {0, 0};
    for (int i = 0; i < 300; i++) {
        int parent[ARMS_MAX], n = 2 + test_random_int(&seed, 60);
        random_parents(n, parent, &seed);
        OWN(scene, close) s;
        REQUIRE(scene_open(&s, n, parent, 8, &seed));
        scene_start(&s, residual);
    }
    CHECK_RESIDUAL(residual[0], 1e-10, "phi''");
    CHECK_RESIDUAL(residual[1], 1e-9, "lambda");
}

static void chain_parents(int n, int parent[]) {
    for (int k = 0; k < n; k++) parent[k] = k - 1;
}

/* pieces of eight arms: complete and incomplete ones, one to many */
TEST(jets_obey_the_equations_of_motion_on_chains_of_every_length) {
    unsigned long long seed = 8;
    double residual[2] = {0, 0};
    int parent[ARMS_MAX], strands = 0;
    for (int n = 2; n <= 70; n++) {
        struct scene s;
        chain_parents(n, parent);
        for (enum pend_isa isa = 0; isa <= pend_isa_best(); isa++) {
            REQUIRE(scene_open(&s, n, parent, 0.3, &seed));
            s.jets.isa = isa;
            strands += s.jets.system.chain != NULL;
            double unit = n % 2 ? 0.0625 : -0.0625;
            pend_jets_expand(&s.jets, &s.loads, unit, &s.state, ORDER);
            scene_residual(&s, unit, series_reach(&s.jets, n, 1e-14), residual);
            scene_close(&s);
        }
    }
    CHECK_INT(strands, 62 * ((int)pend_isa_best() + 1));
    CHECK_RESIDUAL(residual[0], 1e-12, "phi'' of the series against the equations");
    CHECK_RESIDUAL(residual[1], 1e-12, "lambda of the series against the equations");
}

/* the largest differences between a chain's coefficients and those of the same chain in blocks,
 * relative to the order's largest */
static int scene_compare(struct scene *s, double unit, double worst[2]) {
    int n = s->tree->n, isa = (int)s->jets.isa;
    struct scene other = {.tree = s->tree};
    other.block = aligned_alloc(64, pend_jets_bytes(s->tree, NULL, ORDER));
    other.work = aligned_alloc(64, pend_blocks_bytes(s->tree));
    if (!other.block || !other.work) return 0;
    pend_jets_init(&other.jets, s->tree, TEST_LOADS(0), ORDER, other.block);
    memset(other.work, 0, pend_blocks_bytes(s->tree));
    pend_blocks_init(&other.jets.blocks, s->tree, other.work);
    other.jets.system.blocks = &other.jets.blocks;
    other.jets.system.chain = NULL;
    other.jets.isa = (enum pend_isa)isa;
    pend_jets_expand(&s->jets, &s->loads, unit, &s->state, ORDER);
    pend_jets_expand(&other.jets, &s->loads, unit, &s->state, ORDER);
    for (int j = 0; j <= ORDER; j++) {
        double gap[2] = {0, 0}, scale[2] = {0, 0};
        for (int k = 0; k < n; k++) {
            size_t at = pend_jets_place(&s->jets, k, j);
            gap[0] = fmax(gap[0], fabs(s->jets.rate[at] - other.jets.rate[at]));
            scale[0] = fmax(scale[0], fabs(other.jets.rate[at]));
            gap[1] = fmax(gap[1], j < ORDER ? fabs(s->jets.force[at] - other.jets.force[at]) : 0);
            scale[1] = fmax(scale[1], j < ORDER ? fabs(other.jets.force[at]) : 1);
        }
        for (int i = 0; i < 2; i++) {
            double relative = gap[i] / scale[i];
            if (!(relative <= worst[i])) worst[i] = relative;
        }
    }
    free(other.block);
    free(other.work);
    return 1;
}

/* random directions, arms on one line up to 1 .. 1e-12 of a turn, and folded back onto each
 * other */
static void scene_align(struct scene *s, int i, unsigned long long *seed) {
    for (int k = 0; k < s->tree->n && i % 3; k++) {
        double off = pow(10, -(i % 13)) * test_random(seed);
        s->phi[k] = 1 + off + (i % 3 == 2 && k % 2 ? M_PI : 0);
    }
}

TEST(jets_of_a_chain_have_the_coefficients_that_blocks_have) {
    unsigned long long seed = 9;
    int parent[ARMS_MAX];
    double worst[2] = {0, 0};
    chain_parents(ARMS_MAX, parent);
    for (int i = 0; i < 300; i++) {
        OWN(scene, close) s;
        // masses up to eight times above or below their mean, the most that a chain allows
        REQUIRE(scene_open(&s, 9 + test_random_int(&seed, 60), parent, 0.9, &seed));
        REQUIRE(s.jets.system.chain != NULL);
        scene_align(&s, i, &seed);
        REQUIRE(scene_compare(&s, 0.03125, worst));
    }
    CHECK_RESIDUAL(worst[0], 1e-11, "coefficients of phi'");
    CHECK_RESIDUAL(worst[1], 1e-11, "coefficients of lambda");
}

TEST(jets_of_a_chain_whose_masses_are_unlike_or_that_branches_are_found_in_blocks) {
    int parent[ARMS_MAX];
    double len[ARMS_MAX], mass[ARMS_MAX];
    chain_parents(ARMS_MAX, parent);
    for (int k = 0; k < ARMS_MAX; k++) len[k] = mass[k] = 1;
    static const struct {
        int n, branch;
        double heavy;
        int suits;
    } cases[] = {{8, 0, 1, 0},         {9, 0, 1, 1},         {9, 0, 64, 1},  {9, 0, 65, 0},
                 {40, 0, 1 / 64.0, 1}, {40, 0, 1 / 65.0, 0}, {40, 39, 1, 0}, {40, 1, 1, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        OWN(pend_tree, free) *tree;
        mass[cases[i].n / 2] = cases[i].heavy;
        parent[39] = cases[i].branch == 39 ? 37 : 38;
        parent[2] = cases[i].branch == 1 ? 0 : 1;
        REQUIRE(pend_tree_new(&tree, cases[i].n, len, mass, parent, NULL) == PEND_OK);
        CHECK_INT(pend_chain_suits(tree), cases[i].suits);
        mass[cases[i].n / 2] = 1;
    }
}

TEST(jets_keep_their_digits_in_bushy_trees_too) {
    unsigned long long seed = 7;
    double residual[2] = {0, 0};
    for (int i = 0; i < 300; i++) {
        int parent[ARMS_MAX], n = 65 + test_random_int(&seed, ARMS_MAX - 65);
        test_parents(i % 8 ? TEST_TREE_ATTACHED : TEST_TREE_BINARY, n, parent, &seed);
        OWN(scene, close) s;
        REQUIRE(scene_open(&s, n, parent, 8, &seed));
        scene_start(&s, residual);
    }
    CHECK_RESIDUAL(residual[0], 1e-10, "phi''");
    CHECK_RESIDUAL(residual[1], 1e-11, "lambda");
}

TEST(jets_notice_a_wrong_coefficient) {
    unsigned long long seed = 4;
    int parent[4] = {-1, 0, 1, 1};
    OWN(scene, close) s;
    REQUIRE(scene_open(&s, 4, parent, 0.3, &seed));
    pend_jets_expand(&s.jets, &s.loads, 0.125, &s.state, ORDER);
    double x = series_reach(&s.jets, 4, 1e-14), residual[2] = {0, 0};
    s.jets.rate[pend_jets_place(&s.jets, 1, 7)] *= 1 + 1e-3;
    scene_residual(&s, 0.125, x, residual);
    CHECK_SAYING(residual[0] > 1e-9, "residual %g", residual[0]);
}

/* the growth of errors in one direction, from the series of two neighbours on both sides of the
 * motion, truncated where the linear equations are */
static double spread_by_neighbours(struct scene *s, const struct jets_spread *how,
                                   const double phi[], const double rate[], double to_phi[],
                                   double to_rate[]) {
    const double near = 1e-5, sign[2] = {1, -1}, unit = how->unit, x = how->x;
    double force[2][PEND_JETS_PAD], most = 0;
    int n = s->tree->n;
    for (int k = 0; k < n; k++) to_phi[k] = to_rate[k] = 0;
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < n; k++)
            s->phi[k] += sign[side] * near * phi[k], s->rate[k] += sign[side] * near * rate[k];
        pend_jets_expand(&s->jets, &s->loads, unit, &s->state, how->order);
        for (int k = 0; k < n; k++) {
            double share = sign[side] / (2 * near);
            to_phi[k] += share * (s->phi[k] + series_at(&s->jets, how->order, k, x, 0));
            to_rate[k] += share * series_at(&s->jets, how->order, k, x, 1) / unit;
            force[side][k] = s->jets.force[pend_jets_place(&s->jets, k, 0)] / (unit * unit);
        }
        for (int k = 0; k < n; k++)
            s->phi[k] -= sign[side] * near * phi[k], s->rate[k] -= sign[side] * near * rate[k];
    }
    for (int k = 0; k < n; k++) most = fmax(most, fabs(force[0][k] - force[1][k]) / (2 * near));
    return most;
}

TEST(jets_spread_errors_as_neighbours_part) {
    enum { TREES = 120 };
    unsigned long long seed = 31;
    for (int i = 0; i < TREES; i++) {
        _Alignas(64) double phi[PEND_JETS_PAD] = {0}, rate[PEND_JETS_PAD] = {0};
        _Alignas(64) double answers[4 * PEND_JETS_PAD * PEND_JETS_PAD];
        double to_phi[PEND_JETS_PAD], to_rate[PEND_JETS_PAD], unit = i % 2 ? -0.125 : 0.0625;
        double x = 0.7, size = 0;
        int n = 1 + i % PEND_JETS_PAD, parent[PEND_JETS_PAD] = {-1};
        OWN(scene, close) s;
        for (int k = 1; k < n; k++) parent[k] = test_random_int(&seed, k);
        if (!CHECK(scene_open(&s, n, parent, 0.5, &seed))) return;
        CHECK(pend_jets_answers_bytes(s.tree, NULL) <= sizeof answers &&
              !pend_jets_spreads(&s.jets));
        for (int k = 0; k < n; k++)
            phi[k] = 2 * test_random(&seed) - 1, rate[k] = 6 * test_random(&seed) - 3;
        struct jets_spread how = {.order = JETS_SPREAD + i % 9, .x = x, .unit = unit};
        double want = spread_by_neighbours(&s, &how, phi, rate, to_phi, to_rate);
        pend_jets_answers(&s.jets, answers);
        CHECK(pend_jets_spreads(&s.jets));
        pend_jets_expand(&s.jets, &s.loads, unit, &s.state, ORDER);
        double got = pend_jets_spread(&s.jets, &s.loads, &how, phi, rate);
        for (int k = 0; k < n; k++) size = fmax(size, fmax(fabs(to_phi[k]), fabs(to_rate[k])));
        CHECK_SAYING(fabs(got - want) <= 1e-6 * (1 + want),
                     "%d arms: forces off by %g, by neighbours %g", n, got, want);
        for (int k = 0; k < n; k++)
            CHECK_SAYING(fabs(phi[k] - to_phi[k]) + fabs(rate[k] - to_rate[k]) <= 1e-6 * size,
                         "%d arms, arm %d: %g and %g, by neighbours %g and %g", n, k, phi[k],
                         rate[k], to_phi[k], to_rate[k]);
    }
}

/* the predicted terms beyond the order of a step against the same terms of a longer series */
TEST(jets_foretell_what_a_step_leaves_out) {
    enum { SCENES = 60, STEP = ORDER - 8 };
    static const int sizes[] = {1, 2, 3, 5, 8, 20, 70};
    unsigned long long seed = 8;
    int near = 0, all = 0;
    for (int i = 0; i < SCENES; i++) {
        int n = sizes[i % 7], parent[ARMS_MAX] = {-1};
        OWN(scene, close) s;
        for (int k = 1; k < n; k++) parent[k] = i % 2 ? k - 1 : test_random_int(&seed, k);
        if (!CHECK(scene_open(&s, n, parent, 0.3, &seed))) return;
        size_t bytes = pend_jets_stride(n) * sizeof(double);
        double *rate = aligned_alloc(64, bytes), *phi = aligned_alloc(64, bytes), size = 0, off = 0,
               off_phi = 0;
        if (!CHECK(rate && phi)) return;
        pend_jets_expand(&s.jets, &s.loads, 0.0625, &s.state, ORDER);
        double x = pend_jets_reach(&s.jets, STEP, log2(1e-8), -INFINITY);
        pend_jets_left(&s.jets, STEP, 2, x, rate, phi);
        for (int k = 0; k < n; k++) {
            double want = 0, want_phi = 0;
            for (int j = ORDER; j > STEP; j--) {
                double term = s.jets.rate[pend_jets_place(&s.jets, k, j)] * pow(x, j);
                want += term, want_phi += term / (j + 1);
            }
            size = fmax(size, fabs(want));
            off = fmax(off, fabs(rate[k] - want));
            off_phi = fmax(off_phi, STEP * fabs(phi[k] - want_phi));
        }
        CHECK_SAYING(off <= size && off_phi <= size, "%d arms: off by %g and %g of %g", n, off,
                     off_phi, size);
        near += off <= 0.1 * size && off_phi <= 0.1 * size;
        all++;
        free(rate);
        free(phi);
    }
    CHECK_SAYING(near >= all * 3 / 4, "%d of %d", near, all);
}
