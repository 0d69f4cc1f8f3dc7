/* Tests of method_symplectic and its kernel: order, symplecticity, reversal, energy over 1e5
 * periods, the grid.
 * Leaves to others: laws that all methods share (tests/laws/test_integration).
 * Invariant: references are motions in 32 digits or the map itself. */
#include "core/integrate/methods/method.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/integrate/methods/gauss_table.h"
#include "core/integrate/methods/kernel_symplectic.h"
#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { MOST = 8 };

static struct pend_problem tree_problem(const struct test_tree *t, double span, long count,
                                        double step) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads.gravity = 9.81,
        .phi = t->phi,
        .rate = t->rate,
        .step = step,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)}};
}

TEST(gauss_tableau_is_exactly_symplectic_and_symmetric) {
    double sum = 0;
    for (int i = 0; i < GAUSS_STAGES; i++) {
        sum += gauss_weight[i];
        for (int j = 0; j < GAUSS_STAGES; j++) {
            CHECK(gauss_through[i][j] + gauss_through[j][i] == 1);
            CHECK(gauss_through[7 - i][7 - j] == gauss_through[j][i]);
        }
        // stage i: the nodes' distance from the start, twice
        double node = 0, mirror = 0;
        for (int j = 0; j < GAUSS_STAGES; j++) {
            node += gauss_weight[j] * gauss_through[j][i];
            mirror += gauss_weight[j] * gauss_through[j][7 - i];
        }
        CHECK(fabs(node + mirror - 1) < 1e-15);
    }
    CHECK(fabs(sum - 1) < 1e-15);
}

/* ---- the map of one step, in canonical coordinates */

static const struct symplectic_kernel *kernel_of(int isa) {
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_kernel_symplectic_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_symplectic_avx2;
#endif
    (void)isa;
    return &pend_kernel_symplectic_base;
}

/* the argument of the map */
struct map {
    const struct pend_tree *tree;
    struct pend_loads loads;
};

/* a step of length h of z = (phi, p), 2 n values */
static void map_step(int isa, const struct map *map, double h, const double z[], double out[]) {
    const struct symplectic_kernel *kernel = kernel_of(isa);
    const struct pend_tree *tree = map->tree;
    double low[2][MOST] = {{0}}, phi[MOST], p[MOST];
    struct symplectic_system system = {
        .n = tree->n,
        .parent = tree->parent,
        .end = tree->end,
        .loads = map->loads,
        .subtree_mass = tree->subtree_mass,
        .length = fabs(h),
        .lanes = aligned_alloc(64, kernel->count(map->loads.terms, tree->n) * sizeof(double))};
    if (!system.lanes) abort();
    size_t bytes = (size_t)tree->n * sizeof(double);
    memcpy(phi, z, bytes);
    memcpy(p, z + tree->n, bytes);
    for (int j = 0; j < GAUSS_STAGES; j++) system.weight[j] = h * gauss_weight[j];
    struct symplectic_state from = {phi, low[0], p, low[0]},
                            to = {out, low[1], out + tree->n, low[1]};
    kernel->load(&system, tree->len, tree->mass);
    CHECK(kernel->step(&system, &from, &to) == 1);
    free(system.lanes);
}

/* rates to momenta (way = 1) or back, in place */
static void map_turn(int isa, const struct map *map, double z[], int way) {
    const struct symplectic_kernel *kernel = kernel_of(isa);
    const struct pend_tree *tree = map->tree;
    double low[MOST] = {0}, in[MOST];
    struct symplectic_system system = {.n = tree->n,
                                       .parent = tree->parent,
                                       .end = tree->end,
                                       .loads = map->loads,
                                       .subtree_mass = tree->subtree_mass};
    system.lanes = aligned_alloc(64, kernel->count(map->loads.terms, tree->n) * sizeof(double));
    if (!system.lanes) abort();
    memcpy(in, z + tree->n, (size_t)tree->n * sizeof(double));
    kernel->load(&system, tree->len, tree->mass);
    struct symplectic_state state = {z, low, in, low};
    if (way)
        kernel->momenta(&system, z, in, z + tree->n);
    else
        kernel->rates(&system, &state, z + tree->n);
    free(system.lanes);
}

/* the Jacobian by differences of order 8: column c of 2 n; in (phi, phi') if `rates` is set */
static void map_jacobian(int isa, const struct map *map, double h, const double z[], int rates,
                         double jacobian[]) {
    static const double weight[4] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
    int m = 2 * map->tree->n;
    memset(jacobian, 0, (size_t)(m * m) * sizeof *jacobian);
    for (int c = 0; c < m; c++)
        for (int i = -4; i <= 4; i++) {
            double at[2 * MOST], out[2 * MOST], d = 0.004;
            if (i == 0) continue;
            memcpy(at, z, (size_t)m * sizeof *at);
            at[c] += i * d;
            if (rates) map_turn(isa, map, at, 1);
            map_step(isa, map, h, at, out);
            if (rates) map_turn(isa, map, out, 0);
            for (int r = 0; r < m; r++)
                jacobian[r * m + c] += (i > 0 ? 1 : -1) * weight[abs(i) - 1] * out[r] / d;
        }
}

/* largest entry of J^T Omega J - Omega */
static double map_defect(int n, const double jacobian[]) {
    double worst = 0;
    int m = 2 * n;
    for (int a = 0; a < m; a++)
        for (int b = 0; b < m; b++) {
            double sum = b == a + n ? -1 : a == b + n ? 1 : 0;
            for (int k = 0; k < n; k++)
                sum += jacobian[k * m + a] * jacobian[(k + n) * m + b] -
                       jacobian[(k + n) * m + a] * jacobian[k * m + b];
            if (!(fabs(sum) <= worst)) worst = fabs(sum);
        }
    return worst;
}

/* the largest defect of coarse steps in canonical coordinates, and the smallest in angles and
 * rates; what: of enum test_terms, 0 = ideal */
static void map_defects(unsigned what, double *worst, double *plain) {
    unsigned long long seed = 1;
    *worst = 0, *plain = INFINITY;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            OWN(test_tree, clear) t;
            struct test_bodies b = {0};
            double z[2 * MOST], jacobian[4 * MOST * MOST];
            test_tree_random(&t, (enum test_tree_kind)kind, 5, 0.3, &seed);
            struct map map = {t.tree, {.gravity = 9.81}};
            if (what) test_bodies_random(&b, t.tree, what, &seed);
            if (what) map.loads = b.loads;
            memcpy(z, t.phi, 5 * sizeof *z);
            memcpy(z + 5, t.rate, 5 * sizeof *z);
            // the coarse step is far from the motion, but symplectic
            map_turn(isa, &map, z, 1);
            map_jacobian(isa, &map, 0.1, z, 0, jacobian);
            *worst = fmax(*worst, map_defect(5, jacobian));
            map_turn(isa, &map, z, 0);
            map_jacobian(isa, &map, 0.1, z, 1, jacobian);
            *plain = fmin(*plain, map_defect(5, jacobian));
            if (what) test_bodies_clear(&b);
        }
}

TEST(symplectic_step_is_a_symplectic_map) {
    static const unsigned what[] = {0, TEST_TERMS_RODS | TEST_TERMS_SPRINGS,
                                    TEST_TERMS_RODS | TEST_TERMS_SPRINGS | TEST_TERMS_CART};
    for (int i = 0; i < 3; i++) {
        double worst, plain;
        map_defects(what[i], &worst, &plain);
        CHECK_RESIDUAL(worst, 1e-9, "J^T Omega J - Omega in (phi, p)");
        CHECK_SAYING(plain > 1e-3,
                     "angles and rates are no canonical coordinates, but their defect is %g",
                     plain);
    }
}

TEST(symplectic_kernels_agree) {
    unsigned long long seed = 2;
    for (int n = 1; n <= MOST; n++) {
        OWN(test_tree, clear) t;
        double z[2 * MOST], out[PEND_ISA_COUNT][2 * MOST];
        test_tree_random(&t, TEST_TREE_ATTACHED, n, 0.3, &seed);
        memcpy(z, t.phi, (size_t)n * sizeof *z);
        memcpy(z + n, t.rate, (size_t)n * sizeof *z);
        const struct map map = {t.tree, {.gravity = 9.81}};
        map_turn(PEND_ISA_BASE, &map, z, 1);
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++)
            map_step(isa, &map, 0.02, z, out[isa]);
        for (int i = 0; i < 2 * n && pend_isa_best() > PEND_ISA_BASE; i++)
            CHECK(fabs(out[0][i] - out[1][i]) < 1e-12 * (1 + fabs(out[0][i])));
        if (pend_isa_best() == PEND_ISA_AVX512)
            CHECK(!memcmp(out[1], out[2], (size_t)(2 * n) * sizeof(double)));
        CHECK(out[0][0] != z[0]);
    }
}

/* ---- accuracy */

/* a double pendulum that swings widely without tumbling */
static void pair_init(struct test_tree *t) {
    unsigned long long seed = 3;
    const int parent[] = {-1, 0};
    test_tree_init(t, 2, parent, 0.3, &seed);
    for (int k = 0; k < 2; k++) t->length[k] = t->mass[k] = 1;
    test_tree_rebuild(t);
    t->phi[0] = t->phi[1] = 1 - M_PI_2;
    t->rate[0] = t->rate[1] = 0;
}

static double pair_error(const struct test_tree *t, double step, long count) {
    OWN(test_record, clear) got, want;
    struct pend_problem problem = tree_problem(t, 2, count, step), exact = problem;
    test_record(&got, "symplectic", &problem);
    CHECK_INT(got.status, PEND_OK);
    exact.rtol = 1e-20;
    test_record_blocks(&want, pend_method_find("taylor")->extended, &exact, count, INFINITY);
    return test_record_gap(&got, &want).phi;
}

/* largest error of the energy of a tumbling double pendulum: proportional to the sixteenth power of
 * the step, although chaos changes the angles */
static double pair_drift(struct test_tree *t, double step) {
    OWN(test_record, clear) record;
    t->phi[0] = 2 - M_PI_2;
    t->phi[1] = 2.5 - M_PI_2;
    struct pend_problem problem = tree_problem(t, 150, 2, step);
    test_record(&record, "symplectic", &problem);
    CHECK_INT(record.status, PEND_OK);
    return record.stats.energy_drift;
}

TEST(symplectic_has_order_sixteen) {
    OWN(test_tree, clear) t;
    pair_init(&t);
    double coarse = pair_drift(&t, 0.03), fine = pair_drift(&t, 0.02),
           order = log(coarse / fine) / log(1.5);
    CHECK_SAYING(order > 14.5 && order < 17.5, "order %.2f: error %g, then %g", order, coarse,
                 fine);
}

TEST(symplectic_step_of_its_own_is_accurate_at_every_instant) {
    OWN(test_tree, clear) t;
    pair_init(&t);
    CHECK_RESIDUAL(pair_error(&t, 0, 777), 1e-13, "phi at 777 instants of 2 s");
}

TEST(symplectic_steps_do_not_depend_on_the_instants) {
    OWN(test_tree, clear) t;
    OWN(test_record, clear) few, many;
    pair_init(&t);
    struct pend_problem problem = tree_problem(&t, 8, 9, 0.0625);
    test_record(&few, "symplectic", &problem);
    problem = tree_problem(&t, 8, 801, 0.0625);
    test_record(&many, "symplectic", &problem);
    CHECK_INT(few.stats.steps, 128);
    CHECK_INT(many.stats.steps, 128);
    for (int i = 0; i < 9; i++)
        CHECK(!memcmp(few.samples.phi + (size_t)i * 2, many.samples.phi + (size_t)i * 200,
                      2 * sizeof(double)));
}

TEST(symplectic_runs_backwards_to_its_start) {
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    OWN(test_record, clear) there, back = {0};
    test_tree_random(&t, TEST_TREE_ATTACHED, 4, 0.3, &seed);
    // coarse steps: the reversal tests the map's own symmetry, not its accuracy
    struct pend_problem problem = tree_problem(&t, 2, 2, 0.03125);
    double phi[4], rate[4], gap = 0;
    test_record(&there, "symplectic", &problem);
    REQUIRE(there.status == PEND_OK);
    for (int k = 0; k < 4; k++) {
        phi[k] = there.samples.phi[4 + t.tree->order[k]];
        rate[k] = there.samples.rate[4 + t.tree->order[k]];
    }
    problem.phi = phi;
    problem.rate = rate;
    problem.times.span = -2;
    test_record(&back, "symplectic", &problem);
    for (int k = 0; k < 4; k++) {
        gap = fmax(gap, fabs(back.samples.phi[4 + t.tree->order[k]] - t.phi[k]));
        gap = fmax(gap, fabs(back.samples.rate[4 + t.tree->order[k]] - t.rate[k]));
    }
    CHECK_RESIDUAL(gap, 1e-10, "phi and phi' after 64 steps there and back");
}

/* ---- very long runs */

/* mean and largest deviation of the energy over some steps of a running stepper */
static void long_stretch(void *stepper, const struct test_tree *t, long steps, double start,
                         double *mean, double *most) {
    double sum = 0, reached;
    *most = 0;
    for (long i = 0; i < steps; i++) {
        double phi, rate;
        if (!CHECK(!pend_method_symplectic.step(stepper, 1e9, &reached, NULL))) return;
        struct pend_points points = {.phi = &phi, .rate = &rate};
        pend_method_symplectic.at(stepper, &reached, 1, &points);
        double energy = 0.5 * rate * rate * t->length[0] + 9.81 * sin(phi);
        sum += energy - start;
        *most = fmax(*most, fabs(energy - start));
    }
    *mean = sum / (double)steps;
}

/* steps between the stretches; fewer for sanitizers and debuggers */
#ifdef NDEBUG
enum { LONG_STEPS = 580000 };
#else
enum { LONG_STEPS = 20000 };
#endif

TEST(symplectic_energy_does_not_drift_in_a_hundred_thousand_periods) {
    OWN(test_tree, clear) t;
    unsigned long long seed = 5;
    const int parent[] = {-1};
    test_tree_init(&t, 1, parent, 0.3, &seed);
    t.length[0] = t.mass[0] = 1;
    test_tree_rebuild(&t);
    t.phi[0] = 1.5 - M_PI_2;
    t.rate[0] = 0;
    // 5.8 steps per period of 2.33 s: the energy oscillates with it, and must do so in the same way
    // at the end
    struct pend_problem problem = tree_problem(&t, 1e6, 2, 0.4);
    void *stepper;
    double reached, start = 9.81 * sin(t.phi[0]), mean[2], most[2];
    REQUIRE(pend_method_symplectic.open(&stepper, &problem, NULL) == PEND_OK);
    long allocations = test_alloc_count();
    long_stretch(stepper, &t, 6000, start, &mean[0], &most[0]);
    for (long i = 0; i < LONG_STEPS; i++)
        REQUIRE(!pend_method_symplectic.step(stepper, 1e9, &reached, NULL));
    long_stretch(stepper, &t, 6000, start, &mean[1], &most[1]);
    CHECK_INT(test_alloc_count(), allocations);
    CHECK_RESIDUAL(fmax(most[0], most[1]) / 9.81, 1e-8, "energy, relative to g l m");
    CHECK_SAYING(most[1] < 1.1 * most[0], "%g at the end, %g at the start", most[1], most[0]);
    CHECK_RESIDUAL(fabs(mean[1] - mean[0]) / 9.81, 1e-12,
                   "drift of the mean energy, relative to g l m");
    pend_method_symplectic.close(&stepper);
}

/* ---- refusals */

TEST(symplectic_says_when_its_step_is_too_long) {
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    pair_init(&t);
    struct pend_problem problem = tree_problem(&t, 100, 2, 5);
    test_record(&record, "symplectic", &problem);
    CHECK_INT(record.status, PEND_STEP_TOO_SMALL);
    CHECK_SAYING(strstr(record.error.text, "a step of 5 s is too long"), "%s", record.error.text);
    // the step that the message names works
    const char *named = strstr(record.error.text, "at this instant ");
    REQUIRE(named);
    problem.step = strtod(named + strlen("at this instant "), NULL);
    problem.times = (struct pend_times){.count = 2, .span = problem.step, .divisor = 1};
    test_record_clear(&record);
    test_record(&record, "symplectic", &problem);
    CHECK_SAYING(problem.step > 0.01 && record.status == PEND_OK, "%g s: %s", problem.step,
                 record.error.text);
}

TEST(symplectic_open_fails_cleanly_without_memory) {
    OWN(test_tree, clear) t;
    pair_init(&t);
    struct pend_problem problem = tree_problem(&t, 1, 2, 0);
    for (long i = 1;; i++) {
        void *stepper = NULL;
        test_alloc_fail(i, 0);
        enum pend_status status = pend_method_symplectic.open(&stepper, &problem, NULL);
        test_alloc_faults_off();
        CHECK(status == PEND_OK ? stepper != NULL : status == PEND_NO_MEMORY && !stepper);
        if (status == PEND_OK || i > 20) {
            CHECK(i > 2 && i <= 20);
            pend_method_symplectic.close(&stepper);
            break;
        }
    }
}

TEST(symplectic_stays_where_nothing_moves) {
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    pair_init(&t);
    t.phi[0] = t.phi[1] = -M_PI_2;
    struct pend_problem problem = tree_problem(&t, 10, 5, 0);
    test_record(&record, "symplectic", &problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK(fabs(record.samples.phi[9] + M_PI_2) < 1e-15);
    // without gravity and motion there is no time scale
    problem.loads.gravity = 0;
    test_record_clear(&record);
    test_record(&record, "symplectic", &problem);
    CHECK_INT(record.status, PEND_OK);
}

/* a start at rest with an upright arm shows the first steps no motion, and falls by rounding */
TEST(symplectic_chooses_a_step_that_works_from_an_unstable_equilibrium) {
    const double one[] = {1, 1}, rate[2] = {0};
    // theta = (0, 180) degrees, to 32 digits
    const double phi[] = {-0x1.921fb54442d18p+0, 0x1.921fb54442d18p+0};
    const double low[] = {-0x1.1a62633145c07p-54, 0x1.1a62633145c07p-54};
    const int parent[] = {-1, 0};
    OWN(pend_tree, free) *tree;
    OWN(test_record, clear) record = {0};
    REQUIRE(pend_tree_new(&tree, 2, one, one, parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = tree, .loads.gravity = 9.81, .phi = phi, .phi_low = low, .rate = rate};
    problem.times = (struct pend_times){.count = 61, .span = 60, .divisor = 60};
    test_record(&record, "symplectic", &problem);
    CHECK_SAYING(record.status == PEND_OK, "%s", record.error.text);
    CHECK_SAYING(record.stats.energy_drift < 1e-13, "%g", record.stats.energy_drift);
}

/* stages of long chains need not converge with the steps that the series predict, and their
 * rounding errors are those of long sums */
TEST(symplectic_chooses_a_step_that_works_for_long_chains) {
    unsigned long long seed = 300;
    for (int i = 0; i < 3; i++) {
        OWN(test_tree, clear) t;
        OWN(test_record, clear) record;
        test_tree_random(&t, TEST_TREE_CHAIN, 300, 0.3, &seed);
        struct pend_problem problem = {
            .tree = t.tree, .loads.gravity = 9.81, .phi = t.phi, .rate = t.rate};
        problem.times = (struct pend_times){.count = 3, .span = 0.05, .divisor = 2};
        test_record(&record, "symplectic", &problem);
        CHECK_SAYING(record.status == PEND_OK, "%s", record.error.text);
        CHECK_SAYING(record.stats.energy_drift < 1e-11, "%g", record.stats.energy_drift);
    }
}

/* rounding keeps the stages of chains of thousands of arms a few hundred millionths apart: they
 * come no closer, and no step is refused or divided because of it */
TEST(symplectic_chooses_a_step_that_works_for_chains_of_thousands) {
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    OWN(test_record, clear) record;
    test_tree_random(&t, TEST_TREE_CHAIN, 5000, 0.3, &seed);
    struct pend_problem problem = {
        .tree = t.tree, .loads.gravity = 9.81, .phi = t.phi, .rate = t.rate};
    problem.times = (struct pend_times){.count = 2, .span = 0.004, .divisor = 1};
    test_record(&record, "symplectic", &problem);
    CHECK_SAYING(record.status == PEND_OK, "%s", record.error.text);
    CHECK_SAYING(record.stats.energy_drift < 1e-10, "%g", record.stats.energy_drift);
    CHECK_SAYING(record.stats.steps < 50 && record.stats.evaluations < 8000,
                 "%ld steps, %ld evaluations", record.stats.steps, record.stats.evaluations);
}
