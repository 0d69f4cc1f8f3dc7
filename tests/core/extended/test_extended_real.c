/* Tests of real pendulums in 32 digits: three motions whose digits another program has computed.
 * Leaves to others: ideal pendulums (test_extended), doubles (laws).
 * Invariant: the table has at least 40 digits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/extended/extended.h"
#include "core/extended/trust.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 2, SYSTEMS = 3, VALUES = 32, PARTS = 3 };

/* a pendulum whose arms form a chain, with its terms and its start; the time of its drives begins
 * at 0.5 s */
struct real {
    struct pend_tree *tree;
    struct pend_terms *terms;
    double value[VALUES], phi[ARMS], rate[ARMS];
    struct pend_loads loads;
};

static const double began = 0.5;

static void real_new(struct real *r, int n, const unsigned char rows[], const unsigned char ones[],
                     int harmonics, const int drives[]) {
    static const double length[] = {0.75, 1.25};
    const double mass[] = {n == 1 ? 1.25 : 0.5, 0.25};
    const int parent[] = {-1, 0};
    int place[2];
    memset(r, 0, sizeof *r);
    REQUIRE(pend_tree_new(&r->tree, n, length, mass, parent, NULL) == PEND_OK);
    REQUIRE(pend_terms_new(&r->terms, n, rows, ones, harmonics, drives, place) == PEND_OK);
    REQUIRE(r->terms->count <= VALUES);
    pend_terms_clear(r->terms, r->tree, r->value);
    r->loads = (struct pend_loads){9.75, r->terms, r->value};
    r->phi[0] = -0.5, r->rate[0] = 1.5;
    if (n == 2) r->phi[1] = 0.75, r->rate[1] = -0.5;
}

static void real_free(struct real *r) {
    pend_terms_free(&r->terms);
    pend_tree_free(&r->tree);
}

static void real_set(struct real *r, enum pend_term_row row, double first, double second) {
    r->value[r->terms->row[row]] = first;
    if (r->terms->n == 2) r->value[r->terms->row[row] + 1] = second;
}

static void real_drive(struct real *r, int i, double amplitude, double omega, double phase) {
    double *h = r->value + r->terms->harmonic[i].at;
    h[0] = amplitude, h[1] = omega, h[2] = phase;
}

/* a spring, two kinds of friction, a constant and an oscillating torque */
static void real_joint(struct real *r) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    const int drives[] = {0};
    rows[PEND_TERM_DAMPING] = rows[PEND_TERM_FRICTION] = rows[PEND_TERM_STIFFNESS] = 1;
    rows[PEND_TERM_TORQUE] = 1;
    real_new(r, 1, rows, ones, 1, drives);
    real_set(r, PEND_TERM_DAMPING, 0.125, 0);
    real_set(r, PEND_TERM_FRICTION, 0.25, 0);
    real_set(r, PEND_TERM_FRICTION_SPEED, 0.5, 0);
    real_set(r, PEND_TERM_STIFFNESS, 1.5, 0);
    real_set(r, PEND_TERM_REST, 0.25, 0);
    real_set(r, PEND_TERM_TORQUE, 0.375, 0);
    real_drive(r, 0, 2, 3, 0.5);
}

/* air, and a pivot that oscillates in both directions and accelerates */
static void real_air(struct real *r) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {1, 1, 1};
    const int drives[] = {PEND_DRIVE_PIVOT_Y, PEND_DRIVE_PIVOT_X};
    rows[PEND_TERM_DRAG] = rows[PEND_TERM_DRAG_QUADRATIC] = 1;
    real_new(r, 1, rows, ones, 2, drives);
    real_set(r, PEND_TERM_DRAG, 0.125, 0);
    real_set(r, PEND_TERM_DRAG_QUADRATIC, 0.25, 0);
    real_set(r, PEND_TERM_DRAG_SPEED, 0.5, 0);
    r->value[r->terms->one[PEND_TERM_DRAG_PER_MASS]] = 0.0625;
    r->value[r->terms->one[PEND_TERM_PIVOT_ACCELERATION_X]] = 0.375;
    r->value[r->terms->one[PEND_TERM_PIVOT_ACCELERATION_Y]] = -0.25;
    for (int i = 0; i < 2; i++) {
        if (r->terms->harmonic[i].drives == PEND_DRIVE_PIVOT_Y)
            real_drive(r, i, 0.125, 7, 0.5);
        else
            real_drive(r, i, 0.25, 5, -1);
    }
}

/* two rods and a body, the second attached beside the first's axis, with springs and dampers */
static void real_rods(struct real *r) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    rows[PEND_TERM_ROD] = rows[PEND_TERM_BODY] = rows[PEND_TERM_AT_X] = 1;
    rows[PEND_TERM_STIFFNESS] = rows[PEND_TERM_DAMPING] = 1;
    real_new(r, 2, rows, ones, 0, NULL);
    real_set(r, PEND_TERM_ROD, 1.25, 0.75);
    real_set(r, PEND_TERM_BODY, 0, 0.5);
    real_set(r, PEND_TERM_CENTER_X, 0, 0.25);
    real_set(r, PEND_TERM_CENTER_Y, 0, -0.125);
    real_set(r, PEND_TERM_INERTIA, 0, 0.0625);
    real_set(r, PEND_TERM_AT_X, 0, 0.5);
    real_set(r, PEND_TERM_AT_Y, 0, 0.125);
    real_set(r, PEND_TERM_STIFFNESS, 0.5, 1.5);
    real_set(r, PEND_TERM_REST, 0.25, 0.5);
    real_set(r, PEND_TERM_DAMPING, 0.125, 0.0625);
    r->terms->hung[1] = 1;
}

static void (*const real_make[SYSTEMS])(struct real *) = {real_joint, real_air, real_rods};

/* The states a second later, as sums of two doubles and more: from Newton's or Lagrange's
 * equations, written out for each system, by extrapolation of the midpoint rule (22 columns, 48
 * steps) in 70 digits with mpmath 1.3; with 40 steps the results differ by less than 1e-41. */
static const struct {
    double phi[ARMS][PARTS], rate[ARMS][PARTS];
} known[SYSTEMS] = {
    {.phi = {{-0x1.5c51a0fac2f2bp+1, -0x1.45d0e271e860fp-53, -0x1.f2ab2b42c1f2ap-108}},
     .rate = {{0x1.d61bf2d1bbcbbp-1, -0x1.d0f905c0a737cp-55, 0x1.d8a736d2eed71p-109}}},
    {.phi = {{-0x1.2cca809509a62p+1, 0x1.18c4aa1256bc8p-53, 0x1.f678a678ae05fp-109}},
     .rate = {{0x1.615a559d9d490p+0, 0x1.38264ac8f05e7p-54, -0x1.a7d8d4130facdp-108}}},
    {.phi = {{-0x1.447291a77b798p+1, 0x1.3133d76479a0fp-55, 0x1.6b987056cc775p-109},
             {-0x1.6ba42b1b13886p+1, 0x1.c3c8f6b529af7p-54, 0x1.aaf77d12dfd99p-110}},
     .rate = {{-0x1.c16ca5d872913p+1, -0x1.2682656effe4bp-54, -0x1.8c418f9ca714ep-108},
              {-0x1.3fa4d0d62a064p+1, 0x1.cfa98fdfa3e45p-53, 0x1.a0e082e25b889p-108}}}};

/* difference between a sum of two doubles and a number of the table */
static double gap_of(double high, double low, const double exact[PARTS]) {
    return fabs((double)((test_quad)high - exact[0] + ((test_quad)low - exact[1]) - exact[2]));
}

/* ---- 32 digits */

TEST(extended_has_28_digits_of_three_real_pendulums_and_doubles_have_theirs) {
    double worst = 0, plain = 0;
    for (int i = 0; i < SYSTEMS; i++) {
        OWN(real, free) r;
        struct pend_extended *extended;
        double phi[ARMS], low[ARMS], rate[ARMS], rate_low[ARMS];
        struct pend_extended_state end = {phi, low, rate, rate_low}, start = {0};
        real_make[i](&r);
        start.phi = r.phi, start.rate = r.rate;
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            REQUIRE(pend_extended_new(&extended, r.tree, r.terms, 1e-30, 0, (enum pend_isa)isa,
                                      NULL) == PEND_OK);
            pend_extended_start(extended, &r.loads, &start, began, 1);
            while (pend_extended_step(extended) == PEND_EXTENDED_UNDER_WAY) continue;
            pend_extended_end(extended, &end);
            pend_extended_free(&extended);
            for (int k = 0; k < r.tree->n; k++) {
                worst = fmax(worst, gap_of(phi[k], low[k], known[i].phi[k]));
                worst = fmax(worst, gap_of(rate[k], rate_low[k], known[i].rate[k]));
            }
        }
        struct pend_problem problem = {
            .tree = r.tree,
            .loads = r.loads,
            .phi = r.phi,
            .rate = r.rate,
            .times = {.count = 2, .start = began, .span = 1, .divisor = 1},
            .rtol = 1e-15};
        double t[2], angle[2 * ARMS], speed[2 * ARMS];
        struct pend_samples samples = {.cap = 2, .t = t, .phi = angle, .rate = speed};
        struct pend_run *run;
        int done = 0, n = r.tree->n;
        REQUIRE(pend_run_new(&run, pend_method_find("taylor"), &problem, NULL) == PEND_OK);
        while (!done) REQUIRE(pend_run_next(run, &samples, 1e9, &done, NULL) == PEND_OK);
        pend_run_free(&run);
        for (int k = 0; k < n; k++) {
            plain = fmax(plain, fabs(angle[n + k] - known[i].phi[k][0]));
            plain = fmax(plain, fabs(speed[n + k] - known[i].rate[k][0]));
        }
    }
    CHECK_RESIDUAL(worst, 1e-28, "32 digits after a second");
    CHECK_RESIDUAL(plain, 1e-14, "doubles after a second");
}

/* ---- the methods */

TEST(trust_of_real_pendulums_reaches_the_end_where_digits_hold_and_not_where_chaos_takes_them) {
    static const double tolerance[] = {1e-9, 1e-13};
    unsigned long long seed = 31;
    double until[2] = {0, 0};
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    test_tree_random(&t, TEST_TREE_CHAIN, 2, 0.3, &seed);
    test_bodies_random(&b, t.tree, TEST_TERMS_RODS | TEST_TERMS_PIVOT, &seed);
    for (int i = 0; i < 2; i++) {
        const struct pend_problem problem = {
            .tree = t.tree,
            .loads = b.loads,
            .phi = t.phi,
            .rate = t.rate,
            .times = {.count = 201, .start = 3, .span = 20, .divisor = 200}};
        OWN(pend_trust, free) *trust;
        int done = 0;
        REQUIRE(pend_trust_new(&trust, pend_method_find("taylor"), &problem, tolerance[i], NULL) ==
                PEND_OK);
        while (!done) REQUIRE(pend_trust_next(trust, 1e6, &done, NULL) == PEND_OK);
        until[i] = pend_trust_until(trust);
    }
    CHECK_SAYING(until[0] > 10 && until[1] >= 3 && until[1] < until[0], "%g s, %g s", until[0],
                 until[1]);
}
