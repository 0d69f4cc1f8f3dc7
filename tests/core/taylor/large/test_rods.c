/* Tests of core/taylor/large/rods: series of chains of rods against quadruple precision and against
 * the general kernel, with couples, a driven pivot, and bodies on the arms. Leaves to others: runs
 * of other pendulums (test_real_pendulums), the general kernel (laws). Invariant: residuals are
 * relative to the largest value among the arms. */
#include "core/taylor/large/rods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "core/taylor/jets/jets.h"
#include "tests/harness/bodies.h"
#include "tests/harness/quad_bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 104, ORDER = 20 };

/* the properties of a chain */
enum { RODS = 1, BODIES = 2, NO_TIPS = 4, COUPLES = 8, TORQUES = 16, PIVOT = 32, ALL = 64 };

/* a chain and a state; with `elsewhere` its arms state their attachment points, at the tips, so
 * that the general kernel is used */
struct scene {
    struct test_tree tree;
    struct pend_terms *terms;
    double *value;
    struct pend_loads loads;
    struct pend_jets jets;
    _Alignas(64) double phi[ARMS], low[ARMS], rate[ARMS];
    double work[ORDER], heat[ORDER];
    void *memory;
};

static double between(double low, double high, unsigned long long *seed) {
    return low + (high - low) * test_random(seed);
}

static void scene_terms(struct scene *s, unsigned what, int elsewhere) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int drives[4], place[4], count = 0, n = s->tree.n;
    rows[PEND_TERM_ROD] = (what & RODS) != 0;
    rows[PEND_TERM_BODY] = (what & BODIES) != 0;
    rows[PEND_TERM_AT_X] = elsewhere != 0;
    rows[PEND_TERM_DAMPING] = rows[PEND_TERM_STIFFNESS] = (what & COUPLES) != 0;
    rows[PEND_TERM_TORQUE] = (what & TORQUES) != 0;
    ones[PEND_TERM_PIVOT_ACCELERATION_X] = (what & PIVOT) != 0;
    if (what & TORQUES) drives[count++] = n / 2, drives[count++] = 0;
    if (what & PIVOT) drives[count++] = PEND_DRIVE_PIVOT_X, drives[count++] = PEND_DRIVE_PIVOT_Y;
    if (pend_terms_new(&s->terms, n, rows, ones, count, drives, place) != PEND_OK) abort();
    s->value = calloc((size_t)s->terms->count + 1, sizeof *s->value);
    if (!s->value) abort();
    pend_terms_clear(s->terms, s->tree.tree, s->value);
    s->loads = (struct pend_loads){9.81, s->terms, s->value};
}

/* numbers of the terms, the same for the same seed; masses 10^±spread */
static void scene_fill(struct scene *s, double spread, unsigned long long seed) {
    static const struct {
        enum pend_term_row row;
        double low, high;
    } rows[] = {{PEND_TERM_DAMPING, 0.05, 0.5},
                {PEND_TERM_STIFFNESS, 0.5, 2},
                {PEND_TERM_REST, -1, 1},
                {PEND_TERM_TORQUE, -1, 1}};
    const int *row = s->terms->row;
    for (int k = 0; k < s->tree.n; k++) {
        double l = s->tree.tree->len[k], body = pow(10, between(-spread, spread, &seed));
        double x = between(0.1, 0.9, &seed), wide = between(0.2, 0.5, &seed) * l;
        double rod = pow(10, between(-spread, spread, &seed));
        if (row[PEND_TERM_ROD] >= 0) s->value[row[PEND_TERM_ROD] + k] = rod;
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
            double number = between(rows[i].low, rows[i].high, &seed);
            if (row[rows[i].row] >= 0) s->value[row[rows[i].row] + k] = number;
        }
        if (row[PEND_TERM_BODY] < 0) continue;
        s->value[row[PEND_TERM_BODY] + k] = body;
        s->value[row[PEND_TERM_CENTER_X] + k] = x * l;
        s->value[row[PEND_TERM_INERTIA] + k] = body * wide * wide;
    }
    for (int i = 0; i < s->terms->harmonics; i++) {
        double *h = s->value + s->terms->harmonic[i].at;
        h[0] = between(0.05, 0.2, &seed), h[1] = between(1, 9, &seed), h[2] = between(-3, 3, &seed);
    }
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (s->terms->one[i] >= 0) s->value[s->terms->one[i]] = between(0.05, 0.5, &seed);
}

static void scene_expand(struct scene *s, enum pend_isa isa, double unit) {
    struct jets_state state = {
        .phi = s->phi, .phi_low = s->low, .rate = s->rate, .rate_low = s->low, .time = 11};
    for (int k = 0; k < s->tree.n; k++) s->phi[k] = s->tree.phi[k], s->rate[k] = s->tree.rate[k];
    s->memory = aligned_alloc(64, pend_jets_bytes(s->tree.tree, s->terms, ORDER));
    if (!s->memory) abort();
    pend_jets_init(&s->jets, s->tree.tree, &s->loads, ORDER, s->memory);
    s->jets.isa = isa;
    pend_jets_expand(&s->jets, &s->loads, unit, &state, ORDER);
    pend_jets_power(&s->jets, unit, ORDER, ORDER, s->work, s->heat);
    pend_jets_forces(&s->jets, ORDER);
}

/* angles to the parents are within ±swing */
static void scene_open(struct scene *s, int n, unsigned what, double spread, double swing,
                       int elsewhere, unsigned long long seed) {
    unsigned long long random = seed;
    memset(s, 0, sizeof *s);
    test_tree_random(&s->tree, TEST_TREE_CHAIN, n, spread, &random);
    for (int k = 0; k < n; k++) {
        if (what & NO_TIPS) s->tree.mass[k] = 0;
        double turn = between(-swing, swing, &random);
        s->tree.phi[k] = turn + (k ? s->tree.phi[k - 1] : -1.5);
    }
    if (what & NO_TIPS) {
        pend_tree_free(&s->tree.tree);
        unsigned char bare[ARMS];
        memset(bare, 1, sizeof bare);
        if (pend_tree_new_bare(&s->tree.tree, n, s->tree.length, s->tree.mass, bare, s->tree.parent,
                               NULL) != PEND_OK)
            abort();
    }
    scene_terms(s, what, elsewhere);
    scene_fill(s, spread, seed + 1);
}

static void scene_close(struct scene *s) {
    free(s->memory);
    free(s->value);
    pend_terms_free(&s->terms);
    test_tree_clear(&s->tree);
}

/* the sum of orders 0 .. last of a series at x */
static double sum_of(const double *at, size_t step, int last, double x) {
    double sum = 0;
    for (int j = last; j >= 0; j--) sum = sum * x + at[(size_t)j * step];
    return sum;
}

/* the largest errors, relative to the largest values */
struct errors {
    double acc, force, rates, forces, work, heat;
};

static void keep(double *worst, double gap) {
    if (!(gap <= *worst)) *worst = gap;
}

/* phi'' and lambda at the start against quadruple precision */
static void start_errors(struct errors *worst, const struct scene *s, double unit) {
    static test_quad phi[ARMS], rate[ARMS], acc[ARMS], force[4][ARMS];
    double own[ARMS], most = 0, gap = 0;
    int n = s->tree.n;
    for (int k = 0; k < n; k++) phi[k] = s->phi[k], rate[k] = s->rate[k];
    struct test_quad_state state = {phi, rate, 11};
    struct test_quad_forces forces = {force[0], force[1], force[2], force[3]};
    test_quad_bodies(s->tree.tree, &s->loads, &state, acc, &forces);
    for (int k = 0; k < n; k++) {
        size_t at = pend_jets_place(&s->jets, k, 0), next = pend_jets_place(&s->jets, k, 1);
        own[k] = s->jets.rate[next] / (unit * unit);
        gap = fmax(gap, (double)test_quad_abs(s->jets.force[at] / (unit * unit) - force[2][k]));
        for (int i = 0; i < 4; i++) most = fmax(most, (double)test_quad_abs(force[i][k]));
    }
    keep(&worst->acc, test_quad_gap(n, own, acc));
    keep(&worst->force, gap / most);
}

/* rates, lambda, work and heat a part of a step later against the general kernel */
static void series_errors(struct errors *worst, const struct scene *s, const struct scene *general,
                          double x) {
    double own[2][ARMS], want[2][ARMS], scale = 0;
    for (int k = 0; k < s->tree.n; k++) {
        size_t at = pend_jets_place(&s->jets, k, 0), step = pend_jets_place(&s->jets, k, 1) - at;
        own[0][k] = sum_of(s->jets.rate + at, step, ORDER, x);
        own[1][k] = sum_of(s->jets.force + at, step, ORDER - 1, x);
        want[0][k] = sum_of(general->jets.rate + at, step, ORDER, x);
        want[1][k] = sum_of(general->jets.force + at, step, ORDER - 1, x);
        scale = fmax(scale, fabs(want[0][k] * want[1][k]));
    }
    keep(&worst->rates, test_gap(s->tree.n, own[0], want[0]));
    keep(&worst->forces, test_gap(s->tree.n, own[1], want[1]));
    double work = sum_of(general->work, 1, ORDER - 1, x);
    double heat = sum_of(general->heat, 1, ORDER - 1, x);
    scale = fmax(scale, fmax(fabs(work), fabs(heat)));
    keep(&worst->work, fabs(sum_of(s->work, 1, ORDER - 1, x) - work) / scale);
    keep(&worst->heat, fabs(sum_of(s->heat, 1, ORDER - 1, x) - heat) / scale);
}

/* returns 0 for a chain that is not suitable */
static int chain_errors(struct errors *worst, int n, unsigned what, double spread, double swing,
                        enum pend_isa isa, unsigned long long seed) {
    struct scene quick, general;
    double unit = seed % 3 ? 0.0625 : -0.0625;
    scene_open(&quick, n, what, spread, swing, 0, seed);
    scene_open(&general, n, what, spread, swing, 1, seed);
    int suits = pend_rods_suit(quick.tree.tree, &quick.loads);
    scene_expand(&quick, isa, unit);
    scene_expand(&general, isa, unit);
    CHECK((quick.jets.system.rods != NULL) == suits && quick.jets.general == !suits);
    CHECK(general.jets.general);
    start_errors(worst, &quick, unit);
    double reach = pend_jets_reach(&quick.jets, ORDER, log2(1e-14), log2(1e-14));
    for (int i = 0; i <= 2; i++) series_errors(worst, &quick, &general, 0.5 * i * reach);
    scene_close(&quick);
    scene_close(&general);
    return suits;
}

TEST(rods_have_the_series_of_the_general_kernel_with_any_loads_that_they_take) {
    static const int arms[] = {9, 10, 15, 16, 17, 24, 25, 40, 64, 100};
    static const double swing[] = {3, 0.2, 1e-9, 0};
    struct errors worst = {0};
    unsigned long long seed = 1;
    for (unsigned what = RODS; what < ALL; what++)
        for (size_t i = 0; i < 2; i++, seed++) {
            int n = arms[seed % (sizeof arms / sizeof *arms)];
            if (!(what & (RODS | BODIES)) || (what & (RODS | NO_TIPS)) == NO_TIPS) continue;
            CHECK(chain_errors(&worst, n, what, 0.3, swing[seed / 2 % 4],
                               (enum pend_isa)(seed % ((unsigned)pend_isa_best() + 1)), seed));
        }
    CHECK_RESIDUAL(worst.acc, 1e-14, "phi'' against quadruple precision");
    CHECK_RESIDUAL(worst.force, 1e-14, "lambda against quadruple precision");
    CHECK_RESIDUAL(worst.rates, 1e-14, "rates within a step against the general kernel");
    CHECK_RESIDUAL(worst.forces, 1e-13, "lambda within a step against the general kernel");
    CHECK_RESIDUAL(worst.work, 1e-13, "work within a step against the general kernel");
    CHECK_RESIDUAL(worst.heat, 1e-14, "heat within a step against the general kernel");
}

TEST(rods_keep_the_digits_of_all_chains_that_suit_them) {
    struct errors worst = {0};
    int suited = 0;
    for (unsigned i = 0; i < 200; i++) {
        unsigned what = i % 3 ? RODS : RODS | BODIES | NO_TIPS;
        struct errors one = {0};
        if (!chain_errors(&one, 9 + (int)(i % 40), what, 1.8, i % 2 ? 3 : 0.1, pend_isa_best(), i))
            continue;
        suited++;
        keep(&worst.acc, one.acc);
        keep(&worst.force, one.force);
        keep(&worst.rates, one.rates);
        keep(&worst.forces, one.forces);
    }
    CHECK(suited >= 50 && suited < 200);
    CHECK_RESIDUAL(worst.acc, 1e-14, "phi'' against quadruple precision");
    CHECK_RESIDUAL(worst.force, 1e-14, "lambda against quadruple precision");
    CHECK_RESIDUAL(worst.rates, 1e-14, "rates within a step against the general kernel");
    CHECK_RESIDUAL(worst.forces, 1e-13, "lambda within a step against the general kernel");
}

/* the largest difference of two series after scaling, 0 = the same bits */
static int series_differ(const struct scene *one, const struct scene *other, double rate,
                         double force) {
    int differ = 0;
    for (int k = 0; k < one->tree.n; k++)
        for (int j = 0; j <= ORDER; j++) {
            size_t at = pend_jets_place(&one->jets, k, j);
            differ |= one->jets.rate[at] * rate != other->jets.rate[at];
            if (j < ORDER) differ |= one->jets.force[at] * force != other->jets.force[at];
        }
    return differ;
}

TEST(rods_have_the_same_bits_in_avx2_and_avx512) {
    enum pend_isa best = pend_isa_best(), least = best < PEND_ISA_AVX2 ? best : PEND_ISA_AVX2;
    for (unsigned what = RODS; what < ALL; what += 2) {
        struct scene one, other;
        scene_open(&one, 9 + (int)what, what, 0.3, 2, 0, what);
        scene_open(&other, 9 + (int)what, what, 0.3, 2, 0, what);
        scene_expand(&one, least, 0.0625);
        scene_expand(&other, best, 0.0625);
        CHECK(one.jets.system.rods && other.jets.system.rods);
        CHECK(!series_differ(&one, &other, 1, 1) && one.jets.rate[8] != 0);
        CHECK(!memcmp(one.work, other.work, sizeof one.work));
        CHECK(!memcmp(one.heat, other.heat, sizeof one.heat));
        scene_close(&one);
        scene_close(&other);
    }
}

/* powers of two are exact, so no digit may change */
TEST(rods_have_the_same_bits_in_any_unit_of_length_and_mass) {
    static const double units[][2] = {{0x1p-10, 1}, {0x1p10, 1},      {1, 0x1p-60},
                                      {1, 0x1p60},  {0x1p40, 0x1p90}, {0x1p-40, 0x1p-90}};
    OWN(scene, close) one;
    scene_open(&one, 29, RODS | BODIES, 0.3, 2, 0, 5);
    scene_expand(&one, pend_isa_best(), 0.0625);
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        double length = units[i][0], mass = units[i][1];
        OWN(scene, close) other;
        scene_open(&other, 29, RODS | BODIES, 0.3, 2, 0, 5);
        const int *row = other.terms->row;
        for (int k = 0; k < 29; k++) {
            other.tree.length[other.tree.tree->order[k]] *= length;
            other.tree.mass[other.tree.tree->order[k]] *= mass;
            other.value[row[PEND_TERM_ROD] + k] *= mass;
            other.value[row[PEND_TERM_BODY] + k] *= mass;
            other.value[row[PEND_TERM_CENTER_X] + k] *= length;
            other.value[row[PEND_TERM_INERTIA] + k] *= mass * length * length;
        }
        test_tree_rebuild(&other.tree);
        other.loads.gravity *= length;
        scene_expand(&other, pend_isa_best(), 0.0625);
        CHECK(other.jets.system.rods && !series_differ(&one, &other, 1, mass * length));
    }
}

TEST(rods_leave_what_they_do_not_suit_to_the_general_kernel) {
    enum { N = 12 };
    // the term whose number of arm 5 changes, and its new value; the last ones are suitable
    static const struct {
        enum pend_term_row row;
        double number;
        int suits;
    } cases[] = {{PEND_TERM_CENTER_Y, 0.01, 0}, {PEND_TERM_CENTER_X, -0.5, 0},
                 {PEND_TERM_CENTER_X, 9, 0},    {PEND_TERM_INERTIA, 1e4, 0},
                 {PEND_TERM_ROD, 1e4, 0},       {PEND_TERM_ROD, 0.5, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        OWN(scene, close) s;
        scene_open(&s, N, RODS | BODIES, 0.1, 2, 0, 3);
        CHECK(pend_rods_known(s.tree.tree, s.terms) && pend_rods_suit(s.tree.tree, &s.loads));
        if (cases[i].row == PEND_TERM_CENTER_X) s.value[s.terms->row[PEND_TERM_BODY] + 5] = 8;
        s.value[s.terms->row[cases[i].row] + 5] = cases[i].number;
        CHECK_INT(pend_rods_suit(s.tree.tree, &s.loads), cases[i].suits);
        scene_expand(&s, pend_isa_best(), 0.0625);
        CHECK_INT(s.jets.general, !cases[i].suits);
    }
    // a wheel at the pivot, and masses whose products overflow
    OWN(scene, close) s;
    scene_open(&s, N, RODS, 0.1, 2, 0, 3);
    s.value[s.terms->row[PEND_TERM_ROD]] = 1e4;
    CHECK(!pend_rods_suit(s.tree.tree, &s.loads));
    for (int k = 0; k < N; k++) {
        s.tree.mass[s.tree.tree->order[k]] = 1e-280;
        s.value[s.terms->row[PEND_TERM_ROD] + k] = 1e-280;
    }
    test_tree_rebuild(&s.tree);
    CHECK(!pend_rods_suit(s.tree.tree, &s.loads));
    scene_close(&s);
    // a point mass at any position of a massless arm
    scene_open(&s, N, BODIES | NO_TIPS, 0.1, 2, 0, 3);
    CHECK(pend_rods_suit(s.tree.tree, &s.loads));
    s.value[s.terms->row[PEND_TERM_CENTER_X] + 5] = 0.5 * s.tree.tree->len[5];
    s.value[s.terms->row[PEND_TERM_INERTIA] + 5] *= 1e-3;
    CHECK(!pend_rods_suit(s.tree.tree, &s.loads));
}

TEST(rods_write_nothing_behind_the_memory_that_they_ask_for) {
    enum { GUARD = 4096, NEAR = 4 };
    for (int n = 9; n <= 26; n++) {
        OWN(scene, close) s;
        scene_open(&s, n, RODS | COUPLES, 0.1, 2, 0, 3);
        size_t bytes = pend_jets_bytes(s.tree.tree, s.terms, NEAR), all = bytes + GUARD;
        struct jets_state state = {
            .phi = s.phi, .phi_low = s.low, .rate = s.rate, .rate_low = s.low};
        char *memory = s.memory = aligned_alloc(64, all);
        REQUIRE(memory);
        memset(memory, 0x55, all);
        pend_jets_init(&s.jets, s.tree.tree, &s.loads, NEAR, memory);
        CHECK(s.jets.system.rods);
        pend_jets_expand(&s.jets, &s.loads, 0.0625, &state, NEAR);
        pend_jets_forces(&s.jets, NEAR);
        size_t written = all;
        while (written > 0 && memory[written - 1] == 0x55) written--;
        CHECK(written <= bytes);
    }
}

/* angles and forces at ROWS instants of a run, and the drift of its energy's balance */
enum { ROWS = 11, RUN_ARMS = 20 };
struct path {
    double phi[ROWS * RUN_ARMS], force[ROWS * RUN_ARMS], drift;
};

extern const struct pend_method pend_method_taylor, pend_method_taylor_extended;

static void path_run(const struct scene *s, const struct pend_method *method, double rtol,
                     struct path *path) {
    double t[ROWS];
    int done = 0;
    OWN(pend_run, free) *run;
    struct pend_problem problem = {.tree = s->tree.tree,
                                   .loads = s->loads,
                                   .phi = s->tree.phi,
                                   .rate = s->tree.rate,
                                   .rtol = rtol};
    problem.times =
        (struct pend_times){.count = ROWS, .start = 2, .span = 0.5, .divisor = ROWS - 1};
    struct pend_samples samples = {.cap = ROWS, .t = t, .phi = path->phi, .force = path->force};
    REQUIRE(pend_run_new(&run, method, &problem, NULL) == PEND_OK);
    while (!done) REQUIRE(pend_run_next(run, &samples, 1e12, &done, NULL) == PEND_OK);
    path->drift = pend_run_stats(run).energy_drift;
}

TEST(rods_move_as_in_32_digits_and_balance_their_energy) {
    static struct path own, want;
    double angle = 0, force = 0, drift = 0;
    for (unsigned what = RODS; what < ALL; what += COUPLES) {
        OWN(scene, close) s;
        scene_open(&s, RUN_ARMS, what | (what / COUPLES % 2 ? BODIES : 0), 0.2, 0.5, 0, what);
        REQUIRE(pend_rods_suit(s.tree.tree, &s.loads));
        path_run(&s, &pend_method_taylor, 1e-15, &own);
        path_run(&s, &pend_method_taylor_extended, 1e-24, &want);
        angle = fmax(angle, test_gap(ROWS * RUN_ARMS, own.phi, want.phi));
        force = fmax(force, test_gap(ROWS * RUN_ARMS, own.force, want.force));
        drift = fmax(drift, own.drift);
    }
    CHECK_RESIDUAL(angle, 1e-13, "angles of a run against 32 digits");
    CHECK_RESIDUAL(force, 1e-12, "forces of a run against 32 digits");
    CHECK_RESIDUAL(drift, 1e-13, "drift of the energy's balance");
}
