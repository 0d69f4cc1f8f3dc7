/* Tests of radau: its coefficients, the paper's example, real pendulums, and stiff motions with
 * known closed forms.
 * Leaves to others: what holds for every method (test_run, tests/laws/test_tolerances).
 * Invariant: results are compared with closed forms, method taylor, or 32 digits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/derivatives/complex_factor.h"
#include "core/derivatives/radau.h"
#include "tests/harness/bodies.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { S = RADAU_STAGES, POLES = RADAU_POLES };

/* the collocation conditions: powers of time up to the 7th are integrated exactly; and the last
 * row, to the 13th */
TEST(radau_table_integrates_powers_of_time) {
    double stages = 0, end = 0;
    for (int power = 0; power < 2 * S - 1; power++)
        for (int i = 0; i < S; i++) {
            double sum = 0, exact = pow(radau_node[i], power + 1) / (power + 1);
            for (int j = 0; j < S; j++) sum += radau_through[i][j] * pow(radau_node[j], power);
            if (power < S) stages = fmax(stages, fabs(sum - exact));
            if (i == S - 1) end = fmax(end, fabs(sum - exact));
        }
    CHECK(radau_node[S - 1] == 1);
    CHECK_RESIDUAL(stages, 4e-16, "integrals of powers at the nodes");
    CHECK_RESIDUAL(end, 4e-16, "integrals of powers over the step");
}

/* z = t^k has the derivative 1 at the start for k = 1, else 0: the embedded formula has its
 * order */
TEST(radau_embedded_formula_is_exact_for_powers_up_to_the_stages) {
    double most = 0, beyond = 0;
    for (int power = 1; power <= S + 1; power++) {
        double sum = power == 1 ? 1 / radau_pole[0][0] : 0;
        for (int i = 0; i < S; i++) sum += radau_error[i] * pow(radau_node[i], power);
        *(power <= S ? &most : &beyond) = fmax(fabs(sum), power <= S ? most : beyond);
    }
    CHECK_RESIDUAL(most, 4e-15, "the embedded formula's difference");
    CHECK(beyond > 1e-6);
}

TEST(radau_table_has_the_eigenvectors_of_its_inverse) {
    double values = 0, product = 0;
    for (int p = 0; p < POLES; p++)
        for (int i = 0; i < S; i++) {
            // from = mu a from
            double re = 0, im = 0, mr = radau_pole[0][p], mi = radau_pole[1][p];
            for (int j = 0; j < S; j++) {
                re += radau_through[i][j] * radau_from[0][p][j];
                im += radau_through[i][j] * radau_from[1][p][j];
            }
            values = fmax(values, fabs(mr * re - mi * im - radau_from[0][p][i]));
            values = fmax(values, fabs(mr * im + mi * re - radau_from[1][p][i]));
        }
    for (int i = 0; i < S; i++)
        for (int j = 0; j < S; j++) {
            double sum = i == j ? -1 : 0;
            for (int p = 0; p < POLES; p++)
                sum += (p ? 2 : 1) * (radau_from[0][p][i] * radau_to[0][p][j] -
                                      radau_from[1][p][i] * radau_to[1][p][j]);
            product = fmax(product, fabs(sum));
        }
    CHECK_RESIDUAL(values, 1e-15, "right eigenvectors of 1/a");
    CHECK_RESIDUAL(product, 1e-13, "from to");
}

TEST(complex_systems_are_solved_and_singular_ones_told) {
    enum { N = 9 };
    double re[N * N], im[N * N], fre[N * N], fim[N * N], x[N], y[N], gap = 0;
    int swap[N];
    unsigned long long seed = 5;
    for (int i = 0; i < N * N; i++) {
        fre[i] = re[i] = test_random(&seed) - 0.5;
        fim[i] = im[i] = test_random(&seed) - 0.5;
    }
    for (int i = 0; i < N; i++) x[i] = i, y[i] = 1 - i;
    REQUIRE(complex_factor(N, fre, fim, swap));
    complex_solve(N, fre, fim, swap, x, y);
    for (int i = 0; i < N; i++) {
        double a = -i, b = i - 1;
        for (int j = 0; j < N; j++) {
            a += re[i * N + j] * x[j] - im[i * N + j] * y[j];
            b += re[i * N + j] * y[j] + im[i * N + j] * x[j];
        }
        gap = fmax(gap, fmax(fabs(a), fabs(b)));
    }
    CHECK_RESIDUAL(gap, 2e-13, "residual of nine complex equations");
    memset(fre, 0, sizeof fre);
    memset(fim, 0, sizeof fim);
    CHECK(!complex_factor(N, fre, fim, swap));
}

TEST(radau_solves_the_papers_example) {
    OWN(test_paper, clear) paper = {0};
    struct test_paper_row exact[TEST_PAPER_ROWS];
    REQUIRE(test_paper_read(exact));
    test_paper_init(&paper, 501);
    paper.problem.rtol = 1e-13;
    OWN(test_record, clear) record;
    test_record(&record, "radau", &paper.problem);
    CHECK_INT(record.status, PEND_OK);
    struct test_record_gap gap = test_paper_gap(&record, 10, exact);
    CHECK_RESIDUAL(gap.phi, 1e-10, "phi");
    CHECK_RESIDUAL(gap.rate, 1e-10, "phi'");
    CHECK_RESIDUAL(gap.force, 1e-9, "lambda");
}

/* one arm and its terms; named terms have the given numbers, others 0 or 1 */
struct lone {
    struct pend_tree *tree;
    struct pend_terms *terms;
    double value[16], phi, rate;
    struct pend_problem problem;
};

static int lone_init(struct lone *lone, double gravity, double theta, double rate, double stop,
                     long count) {
    unsigned char rows[PEND_TERM_ROWS] = {[PEND_TERM_DAMPING] = 1, [PEND_TERM_FRICTION] = 1};
    const unsigned char ones[PEND_TERM_ONES] = {0};
    const double length = 1, mass = 1;
    const int parent = -1;
    *lone = (struct lone){.phi = theta - M_PI_2, .rate = rate};
    if (pend_tree_new(&lone->tree, 1, &length, &mass, &parent, NULL) != PEND_OK ||
        pend_terms_new(&lone->terms, 1, rows, ones, 0, NULL, NULL) != PEND_OK)
        return 0;
    pend_terms_clear(lone->terms, lone->tree, lone->value);
    lone->problem = (struct pend_problem){
        .tree = lone->tree,
        .loads = {.gravity = gravity, .terms = lone->terms, .value = lone->value},
        .phi = &lone->phi,
        .rate = &lone->rate,
        .times = {.count = count, .span = stop, .divisor = (double)(count - 1)}};
    return 1;
}

static void lone_set(struct lone *lone, enum pend_term_row row, double x) {
    lone->value[pend_terms_place(lone->terms, row, 0)] = x;
}

static void lone_clear(struct lone *lone) {
    pend_terms_free(&lone->terms);
    pend_tree_free(&lone->tree);
}

/* without gravity phi' = e^{-c t}, until it has decayed */
TEST(radau_follows_a_rate_that_dies_out_at_once) {
    double angle = 0, rate = 0;
    long most = 0;
    for (double c = 1; c < 2e12; c *= 1e4) {
        OWN(lone, clear) lone;
        OWN(test_record, clear) record = {0};
        REQUIRE(lone_init(&lone, 0, 1, 1, 10 / c, 33));
        lone_set(&lone, PEND_TERM_DAMPING, c);
        test_record(&record, "radau", &lone.problem);
        CHECK_INT(record.status, PEND_OK);
        for (long i = 0; i < record.samples.count; i++) {
            double x = c * record.samples.t[i];
            angle = fmax(angle, fabs((record.samples.phi[i] + M_PI_2) - 1 + expm1(-x) / c) * c);
            rate = fmax(rate, fabs(record.samples.rate[i] - exp(-x)));
        }
        most = record.stats.steps > most ? record.stats.steps : most;
    }
    CHECK_RESIDUAL(rate, 1e-9, "e^{-c t}");
    CHECK_RESIDUAL(angle, 1e-3, "its integral, from 1 rad on, in units of 1 / c");
    CHECK_SAYING(most <= 40, "%ld steps", most);
}

/* In a viscous fluid tan(theta / 2) decays as e^{-m g l t / c}; inertia changes that by (m g l I /
 * c^2), 1e-15 of it. The number of steps does not depend on c, and the work of the fall becomes
 * heat. */
TEST(radau_creeps_in_syrup_with_steps_of_the_creeping) {
    double gap = 0, rate = 0, balance = 0;
    long most = 0;
    // rates of 1e-11 rad/s would be near the least atol
    for (double c = 1e8; c < 2e10; c *= 100) {
        OWN(lone, clear) lone;
        OWN(test_record, clear) record = {0};
        REQUIRE(lone_init(&lone, 9.81, 2, 0, c, 65));
        lone_set(&lone, PEND_TERM_DAMPING, c);
        lone.problem.accuracy = 1e-6;
        test_record(&record, "radau", &lone.problem);
        CHECK_INT(record.status, PEND_OK);
        for (long i = 1; i < record.samples.count; i++) {
            double theta = 2 * atan(tan(1) * exp(-9.81 * record.samples.t[i] / c));
            gap = fmax(gap, fabs((record.samples.phi[i] + M_PI_2) - theta));
            rate = fmax(rate, fabs(record.samples.rate[i] * c / 9.81 + sin(theta)));
        }
        balance = fmax(balance, record.stats.energy_drift);
        CHECK(record.stats.horizon == lone.problem.times.span);
        most = record.stats.steps > most ? record.stats.steps : most;
    }
    CHECK_RESIDUAL(gap, 1e-9, "the angle of a pendulum in syrup");
    CHECK_RESIDUAL(rate, 1e-9, "its rate, over m g l / c");
    CHECK_RESIDUAL(balance, 1e-8, "the balance of the energies, heat among them");
    CHECK_SAYING(most <= 80, "%ld steps", most);
}

/* A stuck joint creeps at s artanh(m g l sin theta / f), an effect of the smoothing; it reaches
 * that rate in I s / f seconds. */
TEST(radau_holds_a_stuck_joint) {
    double gap = 0;
    long most = 0;
    for (double s = 1e-3; s > 0.5e-12; s /= 1e3) {
        OWN(lone, clear) lone;
        OWN(test_record, clear) record = {0};
        REQUIRE(lone_init(&lone, 9.81, 0.5, 0, 10, 11));
        lone_set(&lone, PEND_TERM_FRICTION, 8);
        lone_set(&lone, PEND_TERM_FRICTION_SPEED, s);
        test_record(&record, "radau", &lone.problem);
        CHECK_INT(record.status, PEND_OK);
        for (long i = 1; i < record.samples.count; i++) {
            double creep = s * atanh(9.81 * sin((record.samples.phi[i] + M_PI_2)) / 8);
            gap = fmax(gap, fabs(record.samples.rate[i] / creep + 1));
        }
        most = record.stats.steps > most ? record.stats.steps : most;
    }
    CHECK_RESIDUAL(gap, 1e-5, "the rate of a stuck joint, relative");
    CHECK_SAYING(most <= 60, "%ld steps", most);
}

/* a pendulum that swings against dry friction until it sticks: its turning points are corners */
TEST(radau_goes_round_the_corners_of_dry_friction) {
    OWN(lone, clear) lone;
    OWN(test_record, clear) record = {0}, exact = {0};
    REQUIRE(lone_init(&lone, 9.81, 1, 0, 6, 25));
    lone_set(&lone, PEND_TERM_FRICTION, 1);
    lone_set(&lone, PEND_TERM_FRICTION_SPEED, 1e-4);
    test_record(&record, "radau", &lone.problem);
    lone.problem.rtol = 1e-14;
    test_record(&exact, "taylor", &lone.problem);
    CHECK_INT(record.status, PEND_OK);
    CHECK_INT(exact.status, PEND_OK);
    struct test_record_gap gap = test_record_gap(&record, &exact);
    CHECK_RESIDUAL(gap.phi, 1e-8, "phi");
    CHECK_RESIDUAL(gap.rate, 1e-8, "phi'");
}

/* the springs of a random pendulum are a million times as stiff, and its dampers stronger, so that
 * fast motion decays: 32 digits with thousands of steps are the reference */
TEST(radau_agrees_with_32_digits_on_stiff_springs) {
    unsigned long long seed = 12;
    double phi = 0, rate = 0;
    for (int n = 1; n <= 4; n++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        OWN(test_record, clear) record, exact;
        test_tree_random(&t, TEST_TREE_ATTACHED, n, 0.3, &seed);
        test_bodies_random(&b, t.tree, TEST_TERMS_RODS | TEST_TERMS_SPRINGS | TEST_TERMS_DAMPING,
                           &seed);
        for (int k = 0; k < n; k++) {
            b.value[pend_terms_place(b.terms, PEND_TERM_STIFFNESS, k)] *= k ? 1e6 : 1;
            b.value[pend_terms_place(b.terms, PEND_TERM_DAMPING, k)] *= k ? 1e5 : 1;
        }
        struct pend_problem problem = {.tree = t.tree,
                                       .loads = b.loads,
                                       .phi = t.phi,
                                       .rate = t.rate,
                                       .times = {.count = 17, .span = 1, .divisor = 16}};
        test_record(&record, "radau", &problem);
        test_record_blocks(&exact, pend_method_taylor.extended, &problem, 17, INFINITY);
        CHECK_INT(record.status, PEND_OK);
        CHECK_INT(exact.status, PEND_OK);
        struct test_record_gap gap = test_record_gap(&record, &exact);
        phi = fmax(phi, gap.phi), rate = fmax(rate, gap.rate);
        if (n > 1) CHECK(record.stats.steps < exact.stats.steps / 3);
    }
    CHECK_RESIDUAL(phi, 1e-8, "phi beside 32 digits");
    CHECK_RESIDUAL(rate, 1e-8, "phi' beside 32 digits");
}

/* work, heat, carts, drives and air, compared with taylor */
TEST(radau_agrees_with_taylor_on_random_real_pendulums) {
    unsigned long long seed = 77;
    double phi = 0, rate = 0, balance = 0;
    for (int i = 0; i < 12; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        OWN(test_record, clear) record, exact;
        test_tree_random(&t, TEST_TREE_ATTACHED, 1 + i % 5, 0.3, &seed);
        test_bodies_random(&b, t.tree, i % 5 && i % 2 ? TEST_TERMS_CART_ALL : TEST_TERMS_ALL,
                           &seed);
        struct pend_problem problem = {.tree = t.tree,
                                       .loads = b.loads,
                                       .phi = t.phi,
                                       .rate = t.rate,
                                       .rtol = 1e-12,
                                       .times = {.count = 9, .span = 0.5, .divisor = 8}};
        test_record(&record, "radau", &problem);
        test_record(&exact, "taylor", &problem);
        CHECK_INT(record.status, PEND_OK);
        // a cart has no column among the arms
        int numbers = 9 * (t.tree->n - pend_terms_cart(b.terms));
        phi = fmax(phi, test_gap(numbers, record.samples.phi, exact.samples.phi));
        rate = fmax(rate, test_gap(numbers, record.samples.rate, exact.samples.rate));
        balance = fmax(balance, record.stats.energy_drift);
    }
    CHECK_RESIDUAL(phi, 1e-11, "phi by radau and by taylor");
    CHECK_RESIDUAL(rate, 2e-11, "phi' by radau and by taylor");
    CHECK_RESIDUAL(balance, 1e-9, "the balance of the energies, work and heat among them");
}

/* an angle that grows as e^{s t} backwards would be damped */
TEST(radau_refuses_to_go_back_where_energy_was_taken) {
    OWN(lone, clear) lone;
    struct pend_error error = {.text = ""};
    struct pend_run *run = NULL;
    REQUIRE(lone_init(&lone, 9.81, 1, 0, -1, 3));
    REQUIRE(pend_run_new(&run, &pend_method_radau, &lone.problem, &error) == PEND_OK);
    pend_run_free(&run);
    lone_set(&lone, PEND_TERM_DAMPING, 0.1);
    CHECK_INT(pend_run_new(&run, &pend_method_radau, &lone.problem, &error), PEND_INVALID);
    CHECK(strstr(error.text, "forwards"));
}
