/* Tests of motions with derivatives: central differences in 32 digits, the laws of flows, ends,
 * checkpoints and errors.
 * Leaves to others: the motion itself (laws), requests (api).
 * Invariant: pendulums are random, from seeds; arrays of a parameter are in the caller's order. */
#include "core/derivatives/derivatives.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/ensemble/lyapunov.h"
#include "core/extended/extended.h"
#include "core/integrate/run/run.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS = 6, PARAMETERS = 16, ROWS = 5 };

/* the parameters of a pendulum's state: all angles, then all rates */
static int state_parameters(int n, struct pend_parameter by[]) {
    for (int k = 0; k < n; k++) {
        by[k] = (struct pend_parameter){PEND_PARAMETER_PHI, k};
        by[n + k] = (struct pend_parameter){PEND_PARAMETER_RATE, k};
    }
    return 2 * n;
}

static struct pend_problem problem_of(const struct test_tree *t, const struct pend_loads *loads,
                                      double span) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads = *loads,
        .phi = t->phi,
        .rate = t->rate,
        .times = {.count = ROWS, .start = 0.7, .span = span, .divisor = ROWS - 1},
        .rtol = 1e-14};
}

/* rows of phi and rate: values [row n + arm], derivatives [(row n + arm) count + parameter] */
struct answer {
    double phi[ROWS * ARMS], rate[ROWS * ARMS];
    double phi_by[ROWS * ARMS * PARAMETERS], rate_by[ROWS * ARMS * PARAMETERS];
    double place_by[ROWS * PARAMETERS], speed_by[ROWS * PARAMETERS]; /* for a cart */
    long rows, steps;
};

static void answer_of(const struct pend_problem *problem, int count,
                      const struct pend_parameter by[], struct answer *a) {
    OWN(pend_derivatives, free) *d;
    struct pend_error error = {0};
    struct pend_derived_rows rows = {.value = {a->phi, a->rate},
                                     .derivative = {a->phi_by, a->rate_by}};
    a->rows = 0;
    if (pend_terms_cart(problem->loads.terms)) {
        rows.derivative[PEND_DERIVED_CART_PLACE] = a->place_by;
        rows.derivative[PEND_DERIVED_CART_SPEED] = a->speed_by;
    }
    CHECK_SAYING(pend_derivatives_new(&d, problem, count, by, &error) == PEND_OK, "%s", error.text);
    if (!d) return;
    CHECK_SAYING(pend_derivatives_next(d, &rows, ROWS, INFINITY, &a->rows, &error) == PEND_OK, "%s",
                 error.text);
    CHECK(pend_derivatives_progress(d) == 1);
    a->steps = pend_derivatives_steps(d);
}

/* ---- against differences in 32 digits */

/* the state at the end, as sums of two */
struct end {
    double phi[ARMS], phi_low[ARMS], rate[ARMS], rate_low[ARMS];
};

static void end_of(const struct test_tree *t, const struct pend_loads *loads, double span,
                   struct end *end) {
    OWN(pend_extended, free) *extended;
    struct pend_extended_state start = {t->phi, NULL, t->rate, NULL};
    struct pend_extended_state out = {end->phi, end->phi_low, end->rate, end->rate_low};
    REQUIRE(pend_extended_new(&extended, t->tree, loads->terms, 1e-24, 0, pend_isa_best(), NULL) ==
            PEND_OK);
    pend_extended_start(extended, loads, &start, 0.7, span);
    while (pend_extended_step(extended) == PEND_EXTENDED_UNDER_WAY) continue;
    pend_extended_end(extended, &out);
}

/* address of a parameter of the pendulum; an arm's own numbers are in the caller's order */
static double *parameter_of(struct test_tree *t, struct test_bodies *b, struct pend_parameter by) {
    switch (by.kind) {
    case PEND_PARAMETER_PHI:
        return &t->phi[by.at];
    case PEND_PARAMETER_RATE:
        return &t->rate[by.at];
    case PEND_PARAMETER_LENGTH:
        return &t->length[t->tree->order[by.at]];
    case PEND_PARAMETER_MASS:
        return &t->mass[t->tree->order[by.at]];
    case PEND_PARAMETER_GRAVITY:
        return &b->loads.gravity;
    case PEND_PARAMETER_TERM:
        return &b->value[by.at];
    }
    abort();
}

/* any parameter that the pendulum has */
static struct pend_parameter
parameter_random(const struct test_tree *t, const struct test_bodies *b, unsigned long long *seed) {
    for (;;) {
        enum pend_parameter_kind kind = (enum pend_parameter_kind)test_random_int(seed, 6);
        int at = 0;
        if (kind != PEND_PARAMETER_GRAVITY)
            at = test_random_int(seed, kind == PEND_PARAMETER_TERM ? b->terms->count : t->n);
        // arms that hang at a tip have no attachment point
        if (kind != PEND_PARAMETER_TERM || b->value[at] != 0)
            return (struct pend_parameter){kind, at};
    }
}

/* derivatives of the angle and the rate of a stored arm, or of a cart, at the end */
static void slopes_of(const struct test_tree *t, const struct test_bodies *b,
                      const struct answer *a, int k, int count, int column, double slope[2]) {
    int cart = pend_terms_cart(b->terms), place = t->tree->order[k];
    if (cart && place > t->tree->order[0]) place--;
    size_t row = (size_t)((ROWS - 1) * (t->n - cart) + place), last = ROWS - 1;
    size_t at = (cart && !k ? last : row) * (size_t)count + (size_t)column;
    slope[0] = cart && !k ? a->place_by[at] : a->phi_by[at];
    slope[1] = cart && !k ? a->speed_by[at] : a->rate_by[at];
}

/* the largest error of the derivatives with respect to a parameter at the end, relative to the
 * largest of them */
static double difference_gap(struct test_tree *t, struct test_bodies *b, struct pend_parameter by,
                             double span, const struct answer *a, int count, int column) {
    static struct end side[2];
    double *x = parameter_of(t, b, by), middle = *x, h = fmax(fabs(middle), 0.1) * 1e-8;
    double low = middle - h, high = middle + h, most = 0, gap = 0;
    for (int i = 0; i < 2; i++) {
        *x = i ? high : low;
        if (by.kind == PEND_PARAMETER_LENGTH || by.kind == PEND_PARAMETER_MASS)
            test_tree_rebuild(t);
        end_of(t, &b->loads, span, &side[i]);
    }
    *x = middle;
    if (by.kind == PEND_PARAMETER_LENGTH || by.kind == PEND_PARAMETER_MASS) test_tree_rebuild(t);
    for (int k = 0; k < t->n; k++) {
        double slope[2];
        slopes_of(t, b, a, k, count, column, slope);
        double phi = (side[1].phi[k] - side[0].phi[k]) + (side[1].phi_low[k] - side[0].phi_low[k]);
        double rate =
            (side[1].rate[k] - side[0].rate[k]) + (side[1].rate_low[k] - side[0].rate_low[k]);
        phi /= high - low, rate /= high - low;
        most = fmax(most, fmax(fabs(phi), fabs(rate)));
        gap = fmax(gap, fmax(fabs(slope[0] - phi), fabs(slope[1] - rate)));
    }
    // a derivative near 0 has the digits of the difference that it is compared with
    return gap / fmax(most, 1e-3);
}

TEST(derivatives_are_differences_in_32_digits_on_100_random_pendulums) {
    enum { TREES = 100, EACH = 2 };
    unsigned long long seed = 31;
    double worst = 0;
    for (int i = 0; i < TREES; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct pend_parameter by[EACH];
        static struct answer a;
        double span = i % 3 ? 0.3 : -0.2;
        int kind = i % 10, arms = kind > 8 ? 2 + i % 3 : 1 + i % 4;
        test_tree_random(&t, TEST_TREE_ATTACHED, arms, 0.3, &seed);
        test_bodies_random(&b, t.tree,
                           kind < 8    ? 1u << kind
                           : kind == 8 ? TEST_TERMS_ALL
                                       : TEST_TERMS_CART_ALL,
                           &seed);
        for (int j = 0; j < EACH; j++) by[j] = parameter_random(&t, &b, &seed);
        struct pend_problem problem = problem_of(&t, &b.loads, span);
        answer_of(&problem, EACH, by, &a);
        for (int j = 0; j < EACH; j++) {
            double gap = difference_gap(&t, &b, by[j], span, &a, EACH, j);
            if (!(gap <= worst)) worst = gap;
            CHECK_SAYING(gap < 1e-10, "pendulum %d, kind %d at %d: %g", i, (int)by[j].kind,
                         by[j].at, gap);
        }
    }
    CHECK_RESIDUAL(worst, 1e-11, "derivatives against differences in 32 digits");
}

/* ---- laws of flows */

/* entry i, j of the mass matrix, from kinetic energies of unit rates */
static double inertia(const struct pend_problem *problem, const double phi[], int i, int j) {
    double rate[ARMS] = {0}, scratch[4 * ARMS], sum = 0;
    for (int part = 0; part < 3; part++) {
        rate[i] = rate[j] = 0;
        if (part != 1) rate[i] += 1;
        if (part != 2) rate[j] += 1;
        double kinetic =
            pend_kinematics_energy_at(problem->tree, &problem->loads, 0, phi, rate, scratch)
                .kinetic;
        sum += part ? -kinetic : kinetic;
    }
    return sum;
}

/* The matrix of d(phi, p) with respect to d(phi, rate), p = M(phi) rate, all in stored order.
 * Turning an arm turns its row of M into the derivative with respect to its angle. */
static void canonical(const struct pend_problem *problem, const double phi[], const double rate[],
                      double m[2 * ARMS][2 * ARMS]) {
    int n = problem->tree->n;
    double turned[ARMS];
    memcpy(turned, phi, (size_t)n * sizeof(double));
    memset(m, 0, 4 * ARMS * ARMS * sizeof(double));
    for (int i = 0; i < n; i++) {
        m[i][i] = 1;
        for (int j = 0; j < n; j++) m[n + i][n + j] = inertia(problem, phi, i, j);
    }
    for (int i = 0; i < n; i++) {
        turned[i] += M_PI / 2;
        for (int j = 0; j < n; j++) {
            if (j == i) continue;
            double slope = inertia(problem, turned, i, j);
            m[n + i][i] += slope * rate[j];
            m[n + j][i] += slope * rate[i];
        }
        turned[i] = phi[i];
    }
}

/* a^T J b, J the symplectic form of 2 n numbers */
static double form(int n, const double a[], const double b[]) {
    double sum = 0;
    for (int k = 0; k < n; k++) sum += a[k] * b[n + k] - a[n + k] * b[k];
    return sum;
}

/* the columns of a matrix times those of D at the last row */
static void carried(const struct pend_tree *tree, const struct answer *a,
                    double m[2 * ARMS][2 * ARMS], double column[2 * ARMS][2 * ARMS]) {
    int n = tree->n, q = 2 * n;
    for (int j = 0; j < q; j++) {
        double d[2 * ARMS];
        for (int k = 0; k < n; k++) {
            size_t row = (size_t)((ROWS - 1) * n + tree->order[k]);
            d[k] = a->phi_by[row * (size_t)q + (size_t)j];
            d[n + k] = a->rate_by[row * (size_t)q + (size_t)j];
        }
        for (int r = 0; r < q; r++) {
            column[j][r] = 0;
            for (int k = 0; k < q; k++) column[j][r] += m[r][k] * d[k];
        }
    }
}

/* |D^T J D - J| / |D|^2 for D in (phi, p), which is (A_end D)^T J (A_end D) - A^T J A for D in
 * (phi, rate) */
static double symplectic_gap(const struct pend_problem *problem, const struct answer *a) {
    const struct pend_tree *tree = problem->tree;
    int n = tree->n;
    double phi[ARMS], rate[ARMS], size = 0, worst = 0;
    static double begin[2 * ARMS][2 * ARMS], end[2 * ARMS][2 * ARMS], column[2 * ARMS][2 * ARMS];
    for (int k = 0; k < n; k++) {
        phi[k] = a->phi[(ROWS - 1) * n + tree->order[k]];
        rate[k] = a->rate[(ROWS - 1) * n + tree->order[k]];
    }
    canonical(problem, problem->phi, problem->rate, begin);
    canonical(problem, phi, rate, end);
    carried(tree, a, end, column);
    for (int j = 0; j < 2 * n; j++)
        for (int r = 0; r < 2 * n; r++) size = fmax(size, fabs(column[j][r]));
    for (int j = 0; j < 2 * n; j++)
        for (int k = 0; k < 2 * n; k++) {
            double own[2][2 * ARMS];
            for (int r = 0; r < 2 * n; r++) own[0][r] = begin[r][j], own[1][r] = begin[r][k];
            double gap = form(n, column[j], column[k]) - form(n, own[0], own[1]);
            worst = fmax(worst, fabs(gap) / (size * size));
        }
    return worst;
}

TEST(derivatives_of_a_conservative_motion_are_symplectic) {
    static const unsigned whats[] = {0, TEST_TERMS_RODS, TEST_TERMS_SPRINGS,
                                     TEST_TERMS_RODS | TEST_TERMS_SPRINGS};
    unsigned long long seed = 5;
    double worst = 0;
    for (int i = 0; i < 32; i++) {
        OWN(test_tree, clear) t;
        struct test_bodies b = {.loads = {.gravity = 9.81}};
        struct pend_parameter by[PARAMETERS];
        static struct answer a;
        unsigned what = whats[i / 4 % 4];
        test_tree_random(&t, TEST_TREE_ATTACHED, 2 + i % 4, 0.3, &seed);
        if (what) test_bodies_random(&b, t.tree, what, &seed);
        struct pend_problem problem = problem_of(&t, &b.loads, i % 2 ? 1 : 2);
        answer_of(&problem, state_parameters(t.n, by), by, &a);
        double gap = symplectic_gap(&problem, &a);
        if (!(gap <= worst)) worst = gap;
        CHECK_SAYING(gap < 1e-13, "pendulum %d of %d arms: %g", i, t.n, gap);
        if (what) test_bodies_clear(&b);
    }
    CHECK_RESIDUAL(worst, 1e-13, "D^T J D - J over |D|^2");
}

/* a start moved along its own flow moves the end along the flow: D (phi', phi'')_0 = (phi',
 * phi'')_end if nothing depends on time */
TEST(derivatives_carry_the_flow_along_itself) {
    unsigned long long seed = 8;
    double worst = 0;
    for (int i = 0; i < 6; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct pend_parameter by[PARAMETERS];
        double phi[ROWS * ARMS], rate[ROWS * ARMS], acc[ROWS * ARMS];
        static double phi_by[ROWS * ARMS * PARAMETERS], rate_by[ROWS * ARMS * PARAMETERS];
        struct pend_derived_rows rows = {.value = {phi, rate, acc},
                                         .derivative = {phi_by, rate_by}};
        long made = 0;
        test_tree_random(&t, TEST_TREE_ATTACHED, 1 + i, 0.3, &seed);
        test_bodies_random(&b, t.tree, TEST_TERMS_ALL & ~(TEST_TERMS_TORQUES | TEST_TERMS_PIVOT),
                           &seed);
        struct pend_problem problem = problem_of(&t, &b.loads, 0.5);
        OWN(pend_derivatives, free) *d;
        int n = t.n, count = state_parameters(n, by);
        REQUIRE(pend_derivatives_new(&d, &problem, count, by, NULL) == PEND_OK);
        CHECK(pend_derivatives_next(d, &rows, ROWS, INFINITY, &made, NULL) == PEND_OK);
        double most = 0, gap = 0;
        for (int k = 0; k < n; k++) {
            int row = (ROWS - 1) * n + k;
            double turned = 0, faster = 0;
            for (int j = 0; j < n; j++) {
                int arm = t.tree->order[j];
                turned += phi_by[row * count + j] * rate[arm];
                turned += phi_by[row * count + n + j] * acc[arm];
                faster += rate_by[row * count + j] * rate[arm];
                faster += rate_by[row * count + n + j] * acc[arm];
            }
            most = fmax(most, fmax(fabs(rate[row]), fabs(acc[row])));
            gap = fmax(gap, fmax(fabs(turned - rate[row]), fabs(faster - acc[row])));
        }
        worst = fmax(worst, gap / most);
    }
    CHECK_RESIDUAL(worst, 1e-13, "D of the flow against the flow");
}

/* Multiplying lengths and gravity by the same factor changes the unit of length: angles stay, so
 * that the sum of l d/dl and g d/dg of them is 0. Likewise the sum of m d/dm is 0 for the
 * masses. */
TEST(derivatives_obey_a_change_of_units) {
    unsigned long long seed = 13;
    double worst = 0;
    for (int i = 0; i < 5; i++) {
        OWN(test_tree, clear) t;
        struct pend_parameter by[PARAMETERS];
        static struct answer a;
        int n = 2 + i;
        test_tree_random(&t, TEST_TREE_ATTACHED, n, 0.3, &seed);
        for (int k = 0; k < n; k++) {
            by[k] = (struct pend_parameter){PEND_PARAMETER_LENGTH, k};
            by[n + k] = (struct pend_parameter){PEND_PARAMETER_MASS, k};
        }
        by[2 * n] = (struct pend_parameter){PEND_PARAMETER_GRAVITY, 0};
        struct pend_problem problem = problem_of(&t, TEST_LOADS(9.81), 0.6);
        answer_of(&problem, 2 * n + 1, by, &a);
        for (int k = 0; k < n; k++) {
            const double *row = a.phi_by + ((ROWS - 1) * n + k) * (2 * n + 1);
            double length = 9.81 * row[2 * n], mass = 0, size = fabs(length);
            for (int j = 0; j < n; j++) {
                length += t.tree->len[j] * row[j];
                mass += t.tree->mass[j] * row[n + j];
                size = fmax(size, fabs(t.tree->len[j] * row[j]));
            }
            worst = fmax(worst, fmax(fabs(length), fabs(mass)) / size);
        }
    }
    CHECK_RESIDUAL(worst, 1e-13, "sums of scaled derivatives");
}

/* the largest exponent is the growth rate of the derivatives with respect to the state */
TEST(derivatives_grow_as_the_lyapunov_exponent_says) {
    const double length[] = {1, 1}, mass[] = {1, 1}, phi[] = {1, 1.3}, rate[] = {0, 0};
    const int parent[] = {-1, 0};
    enum { SPAN = 20 }; // s; after 25 s rounding has separated the two motions
    OWN(pend_tree, free) *tree;
    struct pend_parameter by[PARAMETERS];
    REQUIRE(pend_tree_new(&tree, 2, length, mass, parent, NULL) == PEND_OK);
    struct pend_problem problem = {.tree = tree,
                                   .loads = {.gravity = 9.81},
                                   .phi = phi,
                                   .rate = rate,
                                   .times = {.count = 2, .span = SPAN, .divisor = 1},
                                   .rtol = 1e-14};
    struct pend_lyapunov_problem other = {.tree = tree,
                                          .loads = {.gravity = 9.81},
                                          .phi = phi,
                                          .rate = rate,
                                          .count = 1,
                                          .interval = 1,
                                          .rtol = 1e-14};
    static struct answer a;
    answer_of(&problem, state_parameters(2, by), by, &a);
    double most = 0, exponent = 0, error = 0;
    for (int k = 8; k < 16; k++) most = fmax(most, fmax(fabs(a.phi_by[k]), fabs(a.rate_by[k])));
    OWN(pend_lyapunov, free) *lyapunov;
    REQUIRE(pend_lyapunov_new(&lyapunov, &other, NULL) == PEND_OK);
    for (int i = 0, done = 0; i < SPAN; i += done)
        REQUIRE(pend_lyapunov_go(lyapunov, 1000, &done, NULL) == PEND_OK);
    pend_lyapunov_exponents(lyapunov, &exponent);
    pend_lyapunov_errors(lyapunov, &error);
    // the growth contains a factor of a few besides e^(exponent t)
    CHECK_SAYING(exponent > 1 && fabs(log(most) / SPAN - exponent) < 3.0 / SPAN,
                 "growth %g 1/s, exponent %g +- %g 1/s", log(most) / SPAN, exponent, error);
}

/* ---- other quantities */

/* every quantity that a run has too: values against the run's, derivatives against differences of
 * pend_derivatives_state at other states */
static void check_values(unsigned what) {
    unsigned long long seed = 17;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    struct pend_parameter by[PARAMETERS];
    static double value[PEND_DERIVED][ROWS * ARMS], run_value[PEND_DERIVED][ROWS * ARMS];
    double times[ROWS], worst = 0;
    long made = 0;
    test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.3, &seed);
    test_bodies_random(&b, t.tree, what, &seed);
    struct pend_problem problem = problem_of(&t, &b.loads, 0.5);
    OWN(pend_derivatives, free) *d;
    struct pend_derived_rows rows = {{0}, {0}};
    REQUIRE(pend_derivatives_new(&d, &problem, state_parameters(ARMS, by), by, NULL) == PEND_OK);
    int cart = pend_terms_cart(b.terms), last = cart ? PEND_DERIVED : PEND_DERIVED_CART_PLACE;
    for (int i = 0; i < last; i++) rows.value[i] = value[i];
    CHECK(pend_derivatives_next(d, &rows, ROWS, INFINITY, &made, NULL) == PEND_OK && made == ROWS);
    struct pend_samples samples = {.cap = ROWS,
                                   .t = times,
                                   .phi = run_value[PEND_DERIVED_PHI],
                                   .rate = run_value[PEND_DERIVED_RATE],
                                   .acc = run_value[PEND_DERIVED_ACC],
                                   .force = run_value[PEND_DERIVED_FORCE],
                                   .z_re = run_value[PEND_DERIVED_Z_RE],
                                   .z_im = run_value[PEND_DERIVED_Z_IM],
                                   .zd_re = run_value[PEND_DERIVED_ZD_RE],
                                   .zd_im = run_value[PEND_DERIVED_ZD_IM],
                                   .joint_along = run_value[PEND_DERIVED_JOINT_ALONG],
                                   .joint_across = run_value[PEND_DERIVED_JOINT_ACROSS],
                                   .across = run_value[PEND_DERIVED_TIP_ACROSS],
                                   .kinetic = run_value[PEND_DERIVED_KINETIC],
                                   .potential = run_value[PEND_DERIVED_POTENTIAL]};
    if (cart) {
        samples.cart_place = run_value[PEND_DERIVED_CART_PLACE];
        samples.cart_speed = run_value[PEND_DERIVED_CART_SPEED];
        samples.cart_reaction = run_value[PEND_DERIVED_CART_REACTION];
    }
    OWN(pend_run, free) *run;
    int done = 0;
    REQUIRE(pend_run_new(&run, &pend_method_taylor, &problem, NULL) == PEND_OK);
    CHECK(pend_run_next(run, &samples, INFINITY, &done, NULL) == PEND_OK && done);
    for (int i = 0; i < last; i++) {
        int numbers = i < PEND_DERIVED_KINETIC ? ROWS * (ARMS - cart) : ROWS;
        if (i == PEND_DERIVED_ZDD_RE || i == PEND_DERIVED_ZDD_IM) continue;
        if (i == PEND_DERIVED_CART_ACC) continue; // a run has no such quantity
        double gap = test_gap(numbers, value[i], run_value[i]);
        CHECK_SAYING(gap < 1e-13, "quantity %d: %g", i, gap);
        worst = fmax(worst, gap);
    }
    CHECK_RESIDUAL(worst, 1e-13, "values of a motion with derivatives");
}

TEST(derivatives_have_the_values_of_a_run_in_every_quantity) {
    check_values(TEST_TERMS_ALL);
    check_values(TEST_TERMS_CART_ALL);
}

static void check_state(unsigned what) {
    unsigned long long seed = 23;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    struct pend_parameter by[PARAMETERS];
    static double value[2][PEND_DERIVED][ARMS], slope[PEND_DERIVED][ARMS * PARAMETERS];
    test_tree_random(&t, TEST_TREE_ATTACHED, 4, 0.3, &seed);
    test_bodies_random(&b, t.tree, what, &seed);
    int cart = pend_terms_cart(b.terms), last = cart ? PEND_DERIVED : PEND_DERIVED_CART_PLACE;
    int count = state_parameters(4, by);
    for (; count < PARAMETERS; count++) by[count] = parameter_random(&t, &b, &seed);
    double worst = 0;
    for (int j = 0; j < count; j++) {
        double *x = parameter_of(&t, &b, by[j]), middle = *x, h = fmax(fabs(middle), 0.1) * 1e-5;
        for (int side = 0; side < 3; side++) {
            OWN(pend_derivatives, free) *d;
            struct pend_derived_rows rows = {{0}, {0}};
            for (int i = 0; i < last; i++) {
                if (side < 2)
                    rows.value[i] = value[side][i];
                else
                    rows.derivative[i] = slope[i];
            }
            *x = side == 2 ? middle : side ? middle + h : middle - h;
            test_tree_rebuild(&t);
            struct pend_problem problem = problem_of(&t, &b.loads, 1);
            REQUIRE(pend_derivatives_new(&d, &problem, count, by, NULL) == PEND_OK);
            pend_derivatives_state(d, t.phi, NULL, t.rate, 0.9, &rows, 0);
        }
        for (int i = 0; i < last; i++) {
            double most = 0, gap = 0;
            for (int k = 0; k < (i < PEND_DERIVED_KINETIC ? 4 - cart : 1); k++) {
                double want = (value[1][i][k] - value[0][i][k]) / (2 * h);
                most = fmax(most, fabs(want) + fabs(value[0][i][k]));
                gap = fmax(gap, fabs(slope[i][k * count + j] - want));
            }
            worst = fmax(worst, gap / fmax(most, 1e-3));
        }
    }
    CHECK_RESIDUAL(worst, 1e-7, "derivatives of a state against differences in doubles");
}

TEST(derivatives_of_a_state_are_differences_in_every_quantity) {
    check_state(TEST_TERMS_ALL);
    check_state(TEST_TERMS_CART_ALL);
}

/* ---- passes, blocks, ends */

static void check_blocks(const struct pend_loads *loads) {
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    struct pend_parameter by[PARAMETERS];
    static struct answer a, other;
    static char bytes[1 << 16];
    test_tree_random(&t, TEST_TREE_ATTACHED, 4, 0.3, &seed);
    struct pend_problem problem = problem_of(&t, loads, 3);
    int count = state_parameters(4, by);
    answer_of(&problem, count, by, &a);
    CHECK(a.rows == ROWS && a.steps > ROWS);
    OWN(pend_derivatives, free) *d;
    REQUIRE(pend_derivatives_new(&d, &problem, count, by, NULL) == PEND_OK);
    for (long row = 0; row < ROWS;) {
        struct pend_derived_rows rows = {
            .value = {other.phi + row * 4, other.rate + row * 4},
            .derivative = {other.phi_by + row * 4 * count, other.rate_by + row * 4 * count}};
        struct pend_checkpoint take = {PEND_CHECKPOINT_TAKE, bytes, 0, sizeof bytes};
        long made = 0;
        CHECK(pend_derivatives_next(d, &rows, 1, 1, &made, NULL) == PEND_OK);
        row += made;
        CHECK(pend_derivatives_carry(d, &take) == PEND_OK && take.used < sizeof bytes);
        pend_derivatives_free(&d);
        REQUIRE(pend_derivatives_new(&d, &problem, count, by, NULL) == PEND_OK);
        struct pend_checkpoint put = {PEND_CHECKPOINT_PUT, bytes, 0, take.used};
        CHECK(pend_derivatives_carry(d, &put) == PEND_OK && pend_checkpoint_whole(&put));
    }
    CHECK(!memcmp(a.phi_by, other.phi_by, (size_t)(ROWS * 4 * count) * sizeof(double)));
    CHECK(!memcmp(a.rate_by, other.rate_by, (size_t)(ROWS * 4 * count) * sizeof(double)));
    CHECK(!memcmp(a.phi, other.phi, ROWS * 4 * sizeof(double)));
}

/* an ideal pendulum; one with rods, friction, a torque and a drive, whose motions are computed
 * first; and one for the general kernel with numbers and derivatives */
TEST(derivatives_have_the_same_bits_in_blocks_of_any_size_and_after_a_checkpoint) {
    check_blocks(TEST_LOADS(9.81));
    for (int general = 0; general < 2; general++) {
        const unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_ROD] = 1,
                                                    [PEND_TERM_DAMPING] = 1,
                                                    [PEND_TERM_TORQUE] = 1,
                                                    [PEND_TERM_FRICTION] = (unsigned char)general};
        static const unsigned char ones[PEND_TERM_ONES];
        const int drives[] = {1};
        int place;
        double value[8 * 4];
        OWN(pend_terms, free) *terms;
        REQUIRE(pend_terms_new(&terms, 4, rows, ones, 1, drives, &place) == PEND_OK);
        for (int i = 0; i < terms->count; i++) value[i] = 0.1 + 0.01 * i;
        double *drive = &value[terms->harmonic[place].at];
        drive[0] = 0.5, drive[1] = 4, drive[2] = 0.3;
        check_blocks(&(struct pend_loads){9.81, terms, value});
    }
}

TEST(derivatives_that_a_motion_does_not_have_are_zero_and_cost_no_steps) {
    const double length[] = {1}, mass[] = {2}, phi[] = {0.3}, rate[] = {0.5};
    const int parent[] = {-1};
    struct pend_parameter by[] = {{PEND_PARAMETER_RATE, 0}, {PEND_PARAMETER_MASS, 0}};
    OWN(pend_tree, free) *tree;
    static struct answer a, alone;
    REQUIRE(pend_tree_new(&tree, 1, length, mass, parent, NULL) == PEND_OK);
    struct pend_problem problem = {.tree = tree,
                                   .loads = {.gravity = 9.81},
                                   .phi = phi,
                                   .rate = rate,
                                   .times = {.count = ROWS, .span = 8, .divisor = 1}};
    answer_of(&problem, 2, by, &a);
    answer_of(&problem, 1, by, &alone);
    for (int i = 0; i < ROWS; i++) CHECK(fabs(a.phi_by[2 * i + 1]) < 1e-14);
    CHECK(fabs(a.phi_by[2 * (ROWS - 1)]) > 0.1);
    CHECK_SAYING(a.steps <= alone.steps + alone.steps / 10, "%ld steps, %ld steps", a.steps,
                 alone.steps);
}

TEST(derivatives_end_with_a_reason) {
    const double length[] = {1}, mass[] = {1}, phi[] = {0.3}, rate[] = {1e200};
    const int parent[] = {-1};
    struct pend_parameter by[] = {{PEND_PARAMETER_RATE, 0}};
    OWN(pend_tree, free) *tree;
    struct pend_derivatives *d;
    struct pend_error error = {0};
    double number[ROWS];
    long made = 0;
    struct pend_derived_rows rows = {.derivative = {number}};
    REQUIRE(pend_tree_new(&tree, 1, length, mass, parent, NULL) == PEND_OK);
    struct pend_problem problem = {.tree = tree,
                                   .loads = {.gravity = 9.81},
                                   .phi = phi,
                                   .rate = rate,
                                   .times = {.count = 2, .span = 1, .divisor = 1},
                                   .step_cap = 3};
    REQUIRE(pend_derivatives_new(&d, &problem, 1, by, NULL) == PEND_OK);
    for (int i = 0; i < 2; i++) {
        CHECK(pend_derivatives_next(d, &rows, 2, INFINITY, &made, &error) != PEND_OK);
        CHECK(error.text[0] != 0);
    }
    pend_derivatives_free(&d);
    CHECK(!d);
    problem.rtol = 2;
    CHECK(pend_derivatives_new(&d, &problem, 1, by, &error) == PEND_INVALID && !d);
    problem.rtol = 0;
    for (int i = 1; i <= 2; i++) {
        test_alloc_fail(i, 1);
        CHECK(pend_derivatives_new(&d, &problem, 1, by, &error) == PEND_NO_MEMORY && !d);
        test_alloc_faults_off();
    }
}
