/* Tests of method_taylor: the paper's example, conserved energy, reversal, dense output, extreme
 * scales.
 * Leaves to others: the series (test_jets), the time loop (test_run).
 * Invariant: the stepper is driven directly, through its descriptor. */
#include "core/integrate/methods/method.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { ARMS = 4 };

static const double paper_len[ARMS] = {2, 1.5, 0.75, 1.25}, paper_mass[ARMS] = {1, 1, 1, 0.1};
static const int paper_parent[ARMS] = {-1, 0, 1, 1};
static const double zero[ARMS], one[2] = {1, 1};
static const int chain[2] = {-1, 0};

/* a running stepper */
struct ride {
    struct pend_tree *tree;
    void *stepper;
    double reached;
};

static int ride_open(struct ride *ride, int n, const double len[], const double mass[],
                     const int parent[], struct pend_problem problem) {
    *ride = (struct ride){.stepper = NULL};
    if (!CHECK(pend_tree_new(&ride->tree, n, len, mass, parent, NULL) == PEND_OK)) return 0;
    problem.tree = ride->tree;
    return CHECK(pend_method_taylor.open(&ride->stepper, &problem, NULL) == PEND_OK);
}

/* the paper's example */
static int ride_paper(struct ride *ride, double rtol) {
    return ride_open(
        ride, ARMS, paper_len, paper_mass, paper_parent,
        (struct pend_problem){.loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = rtol});
}

/* two arms of unit lengths and masses */
static int ride_double(struct ride *ride, const double phi[], const double rate[], double rtol) {
    return ride_open(
        ride, 2, one, one, chain,
        (struct pend_problem){.loads.gravity = 9.81, .phi = phi, .rate = rate, .rtol = rtol});
}

static void ride_close(struct ride *ride) {
    pend_method_taylor.close(&ride->stepper);
    pend_tree_free(&ride->tree);
}

static int ride_to(struct ride *ride, double t, double limit) {
    struct pend_error error = {0};
    while (fabs(ride->reached) < fabs(t)) {
        if (!CHECK_SAYING(!pend_method_taylor.step(ride->stepper, limit, &ride->reached, &error),
                          "%s", error.text)) {
            return 0;
        }
    }
    return 1;
}

/* the paper's example at 501 instants against the reference's 51 */
static struct test_record_gap paper_gap(double rtol) {
    struct test_paper_row row[TEST_PAPER_ROWS];
    OWN(test_paper, clear) paper;
    OWN(test_record, clear) record;
    CHECK(test_paper_read(row));
    test_paper_init(&paper, 501);
    paper.problem.rtol = rtol;
    test_record(&record, "taylor", &paper.problem);
    return test_paper_gap(&record, 10, row);
}

TEST(taylor_follows_the_paper_example_to_twelve_digits) {
    struct test_record_gap gap = paper_gap(1e-12);
    CHECK_RESIDUAL(gap.phi, 3e-11, "phi, rad");
    CHECK_RESIDUAL(gap.rate, 1e-10, "phi', rad/s");
    CHECK_RESIDUAL(gap.force, 1e-9, "lambda, N");
}

TEST(taylor_error_follows_the_tolerance) {
    double last = 0;
    for (double rtol = 1e-12; rtol < 1e-2; rtol *= 100) {
        double error = paper_gap(rtol).phi;
        CHECK_SAYING(error < 3e3 * rtol * 30, "error %g at rtol %g", error, rtol);
        CHECK_SAYING(error > last, "error %g at rtol %g is not above %g", error, rtol, last);
        last = error;
    }
}

/* J, of a double pendulum with unit lengths and masses */
static double double_energy(const double phi[], const double rate[]) {
    double kinetic =
        rate[0] * rate[0] + 0.5 * rate[1] * rate[1] + rate[0] * rate[1] * cos(phi[0] - phi[1]);
    return kinetic + 9.81 * (2 * sin(phi[0]) + sin(phi[1]));
}

TEST(taylor_keeps_the_energy_of_a_double_pendulum_for_a_thousand_seconds) {
    OWN(ride, close) ride;
    double start[2] = {2 - acos(0), 2.5 - acos(0)}, rest[2] = {0, 0}, phi[2], rate[2], worst = 0;
    REQUIRE(ride_double(&ride, start, rest, 1e-16));
    double energy = double_energy(start, rest), fastest = 0;
    long allocations = test_alloc_count();
    while (ride.reached < 1000) {
        if (pend_method_taylor.step(ride.stepper, 1000, &ride.reached, NULL)) break;
        struct pend_points points = {phi, rate, NULL, NULL, NULL};
        pend_method_taylor.at(ride.stepper, &ride.reached, 1, &points);
        worst = fmax(worst, fabs(double_energy(phi, rate) - energy));
        fastest = fmax(fastest, fabs(rate[1]));
    }
    CHECK_INT(test_alloc_count(), allocations);
    CHECK(ride.reached >= 1000 && fastest > 5);
    CHECK_RESIDUAL(worst / (3 * 9.81), 1e-12,
                   "energy drift over 1000 s, relative to g sum l (S^T m)");
}

TEST(taylor_runs_backwards_to_its_start) {
    OWN(ride, close) ride;
    double phi[ARMS], rate[ARMS], t = 3, back = -3, there[2][ARMS], error = 0;
    struct pend_points points = {phi, rate, NULL, NULL, NULL};
    REQUIRE(ride_paper(&ride, 1e-15) && ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    ride_close(&ride);
    memcpy(there[0], phi, sizeof phi);
    memcpy(there[1], rate, sizeof rate);
    REQUIRE(
        ride_open(&ride, ARMS, paper_len, paper_mass, paper_parent,
                  (struct pend_problem){
                      .loads.gravity = 9.81, .phi = there[0], .rate = there[1], .rtol = 1e-15}) &&
        ride_to(&ride, back, back));
    pend_method_taylor.at(ride.stepper, &back, 1, &points);
    for (int k = 0; k < ARMS; k++) error = fmax(error, fmax(fabs(phi[k]), fabs(rate[k])));
    CHECK_RESIDUAL(error, 1e-13, "phi and phi' after there and back");
}

TEST(taylor_ends_a_step_where_the_next_begins) {
    OWN(ride, close) ride;
    double phi[2][ARMS], rate[2][ARMS];
    REQUIRE(ride_paper(&ride, 1e-10) && ride_to(&ride, 0.1, 5));
    for (int i = 0; i < 30; i++) {
        double t = ride.reached;
        struct pend_points end = {phi[0], rate[0], NULL, NULL, NULL},
                           start = {phi[1], rate[1], NULL, NULL, NULL};
        pend_method_taylor.at(ride.stepper, &t, 1, &end);
        REQUIRE(!pend_method_taylor.step(ride.stepper, 5, &ride.reached, NULL));
        pend_method_taylor.at(ride.stepper, &t, 1, &start);
        CHECK(!memcmp(phi[0], phi[1], sizeof phi[0]) && !memcmp(rate[0], rate[1], sizeof rate[0]));
    }
}

TEST(taylor_gives_an_instant_the_same_bits_whatever_it_is_asked_with) {
    OWN(ride, close) ride;
    enum { COUNT = 9 };
    double t[COUNT], phi[2][COUNT * ARMS], rate[2][COUNT * ARMS];
    REQUIRE(ride_paper(&ride, 1e-10) && ride_to(&ride, 0.5, 5));
    double step = 0.01;
    for (int i = 0; i < COUNT; i++) t[i] = ride.reached - step * (COUNT - 1 - i) / COUNT;
    struct pend_points all = {phi[0], rate[0], NULL, NULL, NULL};
    pend_method_taylor.at(ride.stepper, t, COUNT, &all);
    for (int i = 0; i < COUNT; i++) {
        struct pend_points single = {phi[1] + i * ARMS, rate[1] + i * ARMS, NULL, NULL, NULL};
        pend_method_taylor.at(ride.stepper, t + i, 1, &single);
    }
    CHECK(!memcmp(phi[0], phi[1], sizeof phi[0]) && !memcmp(rate[0], rate[1], sizeof rate[0]));
}

/* one arm from the horizontal; scaling lengths scales times by the square root, to the last bit if
 * it is a power of two */
static int single_arm(double len, double t, double *phi) {
    OWN(ride, close) ride;
    double rate;
    struct pend_points points = {phi, &rate, NULL, NULL, NULL};
    int done = ride_open(&ride, 1, &len, one, chain,
                         (struct pend_problem){
                             .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = 1e-14}) &&
               ride_to(&ride, t, t);
    if (done) pend_method_taylor.at(ride.stepper, &t, 1, &points);
    return done;
}

TEST(taylor_does_not_care_for_the_unit_of_length) {
    double phi, want, scale[] = {0x1p-200, 0x1p-40, 0x1p40, 0x1p200};
    REQUIRE(single_arm(1, 3, &want));
    CHECK(fabs(want) > 0.1);
    for (int i = 0; i < 4; i++) {
        REQUIRE(single_arm(scale[i], 3 * sqrt(scale[i]), &phi));
        CHECK_SAYING(phi == want, "%.17g instead of %.17g at length %g", phi, want, scale[i]);
    }
}

TEST(taylor_turns_freely_without_gravity) {
    OWN(ride, close) ride;
    double phi, rate, t = 1e6, start = 0.5, spin = 1.25;
    struct pend_points points = {.phi = &phi, .rate = &rate};
    REQUIRE(ride_open(&ride, 1, one, one, paper_parent,
                      (struct pend_problem){
                          .loads.gravity = 0, .phi = &start, .rate = &spin, .rtol = 1e-12}) &&
            ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    CHECK_SAYING(phi == 1250000.5 && rate == spin, "%.17g after 200 000 turns, %.17g", phi, rate);
}

TEST(taylor_stays_at_rest_when_hanging) {
    OWN(ride, close) ride;
    double phi[2], rate[2], t = 100, hang[2] = {-M_PI / 2, -M_PI / 2};
    struct pend_points points = {phi, rate, NULL, NULL, NULL};
    REQUIRE(ride_double(&ride, hang, zero, 1e-10) && ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    CHECK_SAYING(fabs(phi[1] - hang[1]) < 1e-15, "%g", phi[1] - hang[1]);
}

TEST(taylor_says_when_and_which_arm_ceased_to_be_finite) {
    OWN(ride, close) ride;
    double start[2] = {0, 1}, wild[2] = {1e200, 0};
    struct pend_error error = {0};
    REQUIRE(ride_double(&ride, start, wild, 1e-10));
    enum pend_status status = pend_method_taylor.step(ride.stepper, 1, &ride.reached, &error);
    CHECK(status == PEND_OK || status == PEND_NOT_FINITE || status == PEND_STEP_TOO_SMALL);
    CHECK(status == PEND_OK || error.text[0]);
}

TEST(taylor_says_at_once_that_steps_are_too_short_to_end) {
    for (double wild = 1e20; wild <= 1e200; wild *= 1e30) {
        OWN(ride, close) ride;
        double start[2] = {0, 1}, rate[2] = {wild, -wild};
        struct pend_error error = {0};
        REQUIRE(ride_double(&ride, start, rate, 1e-10));
        enum pend_status status = PEND_OK;
        int steps = 0;
        for (; status == PEND_OK && steps < 100; steps++)
            status = pend_method_taylor.step(ride.stepper, 1, &ride.reached, &error);
        CHECK_SAYING(status == PEND_STEP_TOO_SMALL || status == PEND_NOT_FINITE,
                     "status %d at rate %g", status, wild);
        CHECK_SAYING(steps == 1 && error.text[0], "%d steps at rate %g", steps, wild);
    }
}

/* a tree divided into several blocks, which branches at most joints */
TEST(taylor_steps_and_samples_of_a_large_tree_allocate_nothing) {
    enum { MANY = 90, INSTANTS = 100 };
    OWN(ride, close) ride = {0};
    double len[MANY], phi[MANY], rate[MANY], t[INSTANTS], energy = 0;
    OWN_MEMORY double *rows = malloc(4 * sizeof(double) * MANY * INSTANTS);
    int parent[MANY];
    unsigned long long seed = 5;
    REQUIRE(rows != NULL);
    for (int k = 0; k < MANY; k++) {
        len[k] = 0.5 + test_random(&seed);
        phi[k] = 6 * test_random(&seed);
        rate[k] = 2 * test_random(&seed) - 1;
        parent[k] = k ? test_random_int(&seed, k) : -1;
    }
    size_t all = (size_t)MANY * INSTANTS;
    struct pend_points points = {rows, rows + all, rows + 2 * all, rows + 3 * all, NULL};
    REQUIRE(ride_open(
        &ride, MANY, len, len, parent,
        (struct pend_problem){.loads.gravity = 9.81, .phi = phi, .rate = rate, .rtol = 1e-10}));
    long allocations = test_alloc_count();
    double from = 0;
    for (int i = 0; i < 10; i++, from = ride.reached) {
        REQUIRE(!pend_method_taylor.step(ride.stepper, 1, &ride.reached, NULL));
        for (int j = 0; j < INSTANTS; j++) t[j] = from + (ride.reached - from) * (j + 1) / INSTANTS;
        pend_method_taylor.at(ride.stepper, t, INSTANTS, &points);
        energy = fmax(energy, fabs(rows[all + 1]));
    }
    CHECK_INT(test_alloc_count(), allocations);
    CHECK(ride.reached > 0.01 && energy > 0);
}

TEST(taylor_open_fails_cleanly_without_memory) {
    OWN(test_paper, clear) paper;
    struct pend_error error = {0};
    void *stepper;
    test_paper_init(&paper, 2);
    paper.problem.rtol = 1e-10;
    test_alloc_fail(1, 0);
    enum pend_status status = pend_method_taylor.open(&stepper, &paper.problem, &error);
    test_alloc_faults_off();
    CHECK(status == PEND_NO_MEMORY && !stepper && error.code == PEND_NO_MEMORY);
}
