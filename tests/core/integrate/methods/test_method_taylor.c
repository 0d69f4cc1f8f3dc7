/* Tests of method_taylor: the paper's example, conserved energy, reversal, dense
 * output, odd scales.
 * Leaves to others: the series (test_jets), the time loop (test_run).
 * Invariant: the stepper is driven directly, through its descriptor. */
#include "core/integrate/methods/method.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

extern const struct pend_method pend_method_taylor;

enum { ARMS = 4, ROWS = 51, COLUMNS = 13 };

static const double paper_len[ARMS] = {2, 1.5, 0.75, 1.25}, paper_mass[ARMS] = {1, 1, 1, 0.1};
static const int paper_parent[ARMS] = {-1, 0, 1, 1};
static const double zero[ARMS];

/* a stepper on its way */
struct ride {
    struct pend_tree *tree;
    void *stepper;
    double reached;
};

static int ride_open(struct ride *ride, const struct pend_problem *problem) {
    ride->stepper = NULL;
    ride->reached = 0;
    return CHECK(pend_method_taylor.open(&ride->stepper, problem, NULL) == PEND_OK);
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

static int paper_rows(double row[ROWS][COLUMNS]) {
    FILE *file = fopen("tests/golden/paper_example.txt", "r");
    if (!file) return 0;
    char line[1024];
    int rows = 0;
    while (rows < ROWS && fgets(line, sizeof line, file)) {
        if (line[0] == '#') continue;
        char *at = line;
        for (int i = 0; i < COLUMNS; i++) row[rows][i] = strtod(at, &at);
        rows++;
    }
    fclose(file);
    return rows == ROWS;
}

/* the paper's example at 501 instants against the reference's 51: largest errors of phi, phi'
 * and lambda */
static void paper_errors(double rtol, double error[3]) {
    double row[ROWS][COLUMNS];
    struct ride ride;
    REQUIRE(paper_rows(row));
    REQUIRE(pend_tree_new(&ride.tree, ARMS, paper_len, paper_mass, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = rtol};
    REQUIRE(ride_open(&ride, &problem));
    for (int i = 0; i <= 500; i++) {
        double t = i / 100.0, phi[ARMS], rate[ARMS], acc[ARMS], force[ARMS];
        struct pend_points points = {phi, rate, acc, force, NULL};
        if (!ride_to(&ride, i ? t : 1e-9, 5)) break;
        pend_method_taylor.at(ride.stepper, &t, 1, &points);
        for (int k = 0; k < ARMS && i % 10 == 0; k++) {
            const double *want = row[i / 10] + 1 + ride.tree->order[k];
            error[0] = fmax(error[0], fabs(phi[k] - want[0]));
            error[1] = fmax(error[1], fabs(rate[k] - want[ARMS]));
            error[2] = fmax(error[2], fabs(force[k] - want[2 * ARMS]));
        }
    }
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_follows_the_paper_example_to_twelve_digits) {
    double error[3] = {0, 0, 0};
    paper_errors(1e-12, error);
    CHECK_RESIDUAL(error[0], 3e-11, "phi, rad");
    CHECK_RESIDUAL(error[1], 1e-10, "phi', rad/s");
    CHECK_RESIDUAL(error[2], 1e-9, "lambda, N");
}

TEST(taylor_error_follows_the_tolerance) {
    double last = 0;
    for (double rtol = 1e-12; rtol < 1e-2; rtol *= 100) {
        double error[3] = {0, 0, 0};
        paper_errors(rtol, error);
        CHECK_SAYING(error[0] < 3e3 * rtol * 30, "error %g at rtol %g", error[0], rtol);
        CHECK_SAYING(error[0] > last, "error %g at rtol %g is not above %g", error[0], rtol, last);
        last = error[0];
    }
}

/* J, of a double pendulum with unit lengths and masses */
static double double_energy(const double phi[], const double rate[]) {
    double kinetic =
        rate[0] * rate[0] + 0.5 * rate[1] * rate[1] + rate[0] * rate[1] * cos(phi[0] - phi[1]);
    return kinetic + 9.81 * (2 * sin(phi[0]) + sin(phi[1]));
}

static const double one[2] = {1, 1};
static const int chain[2] = {-1, 0};

TEST(taylor_keeps_the_energy_of_a_double_pendulum_for_a_thousand_seconds) {
    struct ride ride;
    double start[2] = {2 - acos(0), 2.5 - acos(0)}, rest[2] = {0, 0}, phi[2], rate[2], worst = 0;
    REQUIRE(pend_tree_new(&ride.tree, 2, one, one, chain, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = start, .rate = rest, .rtol = 1e-16};
    REQUIRE(ride_open(&ride, &problem));
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
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_runs_backwards_to_its_start) {
    struct ride ride;
    double phi[ARMS], rate[ARMS], t = 3, back = -3, there[2][ARMS], error = 0;
    REQUIRE(pend_tree_new(&ride.tree, ARMS, paper_len, paper_mass, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = 1e-15};
    struct pend_points points = {phi, rate, NULL, NULL, NULL};
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    pend_method_taylor.close(&ride.stepper);
    memcpy(there[0], phi, sizeof phi);
    memcpy(there[1], rate, sizeof rate);
    problem.phi = there[0];
    problem.rate = there[1];
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, back, back));
    pend_method_taylor.at(ride.stepper, &back, 1, &points);
    for (int k = 0; k < ARMS; k++) error = fmax(error, fmax(fabs(phi[k]), fabs(rate[k])));
    CHECK_RESIDUAL(error, 1e-13, "phi and phi' after there and back");
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_ends_a_step_where_the_next_begins) {
    struct ride ride;
    double phi[2][ARMS], rate[2][ARMS];
    REQUIRE(pend_tree_new(&ride.tree, ARMS, paper_len, paper_mass, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = 1e-10};
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, 0.1, 5));
    for (int i = 0; i < 30; i++) {
        double t = ride.reached;
        struct pend_points end = {phi[0], rate[0], NULL, NULL, NULL},
                           start = {phi[1], rate[1], NULL, NULL, NULL};
        pend_method_taylor.at(ride.stepper, &t, 1, &end);
        REQUIRE(!pend_method_taylor.step(ride.stepper, 5, &ride.reached, NULL));
        pend_method_taylor.at(ride.stepper, &t, 1, &start);
        CHECK(!memcmp(phi[0], phi[1], sizeof phi[0]) && !memcmp(rate[0], rate[1], sizeof rate[0]));
    }
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_gives_an_instant_the_same_bits_whatever_it_is_asked_with) {
    struct ride ride;
    enum { COUNT = 9 };
    double t[COUNT], phi[2][COUNT * ARMS], rate[2][COUNT * ARMS];
    REQUIRE(pend_tree_new(&ride.tree, ARMS, paper_len, paper_mass, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = 1e-10};
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, 0.5, 5));
    double step = 0.01;
    for (int i = 0; i < COUNT; i++) t[i] = ride.reached - step * (COUNT - 1 - i) / COUNT;
    struct pend_points all = {phi[0], rate[0], NULL, NULL, NULL};
    pend_method_taylor.at(ride.stepper, t, COUNT, &all);
    for (int i = 0; i < COUNT; i++) {
        struct pend_points single = {phi[1] + i * ARMS, rate[1] + i * ARMS, NULL, NULL, NULL};
        pend_method_taylor.at(ride.stepper, t + i, 1, &single);
    }
    CHECK(!memcmp(phi[0], phi[1], sizeof phi[0]) && !memcmp(rate[0], rate[1], sizeof rate[0]));
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

/* one arm from the horizontal; lengths scale times by the square root, to the last bit when it
 * is a power of two */
static int single_arm(double len, double gravity, double t, double *phi) {
    struct ride ride;
    double mass = 1, start = 0, rate = 0;
    int pivot = -1;
    if (pend_tree_new(&ride.tree, 1, &len, &mass, &pivot, NULL) != PEND_OK) return 0;
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = gravity, .phi = &start, .rate = &start, .rtol = 1e-14};
    struct pend_points points = {phi, &rate, NULL, NULL, NULL};
    int done = ride_open(&ride, &problem) && ride_to(&ride, t, t);
    if (done) pend_method_taylor.at(ride.stepper, &t, 1, &points);
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
    return done;
}

TEST(taylor_does_not_care_for_the_unit_of_length) {
    double phi, want, scale[] = {0x1p-200, 0x1p-40, 0x1p40, 0x1p200};
    REQUIRE(single_arm(1, 9.81, 3, &want));
    CHECK(fabs(want) > 0.1);
    for (int i = 0; i < 4; i++) {
        REQUIRE(single_arm(scale[i], 9.81, 3 * sqrt(scale[i]), &phi));
        CHECK_SAYING(phi == want, "%.17g instead of %.17g at length %g", phi, want, scale[i]);
    }
}

TEST(taylor_turns_freely_without_gravity) {
    struct ride ride;
    double phi, rate, t = 1e6, start = 0.5, spin = 1.25;
    struct pend_points points = {.phi = &phi, .rate = &rate};
    REQUIRE(pend_tree_new(&ride.tree, 1, one, one, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 0, .phi = &start, .rate = &spin, .rtol = 1e-12};
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    CHECK_SAYING(phi == 1250000.5 && rate == spin, "%.17g after 200 000 turns, %.17g", phi, rate);
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_stays_at_rest_when_hanging) {
    struct ride ride;
    double phi[2], rate[2], t = 100, hang[2] = {-M_PI / 2, -M_PI / 2};
    struct pend_points points = {phi, rate, NULL, NULL, NULL};
    REQUIRE(pend_tree_new(&ride.tree, 2, one, one, chain, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = hang, .rate = zero, .rtol = 1e-10};
    REQUIRE(ride_open(&ride, &problem) && ride_to(&ride, t, t));
    pend_method_taylor.at(ride.stepper, &t, 1, &points);
    CHECK_SAYING(fabs(phi[1] - hang[1]) < 1e-15, "%g", phi[1] - hang[1]);
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_says_when_and_which_arm_ceased_to_be_finite) {
    struct ride ride;
    double start[2] = {0, 1}, wild[2] = {1e200, 0};
    struct pend_error error = {0};
    REQUIRE(pend_tree_new(&ride.tree, 2, one, one, chain, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = start, .rate = wild, .rtol = 1e-10};
    REQUIRE(ride_open(&ride, &problem));
    enum pend_status status = pend_method_taylor.step(ride.stepper, 1, &ride.reached, &error);
    CHECK(status == PEND_OK || status == PEND_NOT_FINITE || status == PEND_STEP_TOO_SMALL);
    CHECK(status == PEND_OK || error.text[0]);
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
}

TEST(taylor_says_at_once_that_steps_are_too_short_to_end) {
    for (double wild = 1e20; wild <= 1e200; wild *= 1e30) {
        struct ride ride;
        double start[2] = {0, 1}, rate[2] = {wild, -wild};
        struct pend_error error = {0};
        REQUIRE(pend_tree_new(&ride.tree, 2, one, one, chain, NULL) == PEND_OK);
        struct pend_problem problem = {
            .tree = ride.tree, .loads.gravity = 9.81, .phi = start, .rate = rate, .rtol = 1e-10};
        REQUIRE(ride_open(&ride, &problem));
        enum pend_status status = PEND_OK;
        int steps = 0;
        for (; status == PEND_OK && steps < 100; steps++)
            status = pend_method_taylor.step(ride.stepper, 1, &ride.reached, &error);
        CHECK_SAYING(status == PEND_STEP_TOO_SMALL || status == PEND_NOT_FINITE,
                     "status %d at rate %g", status, wild);
        CHECK_SAYING(steps == 1 && error.text[0], "%d steps at rate %g", steps, wild);
        pend_method_taylor.close(&ride.stepper);
        pend_tree_free(&ride.tree);
    }
}

/* a tree cut into several blocks, branching at most joints */
TEST(taylor_steps_and_samples_of_a_large_tree_allocate_nothing) {
    enum { MANY = 90, INSTANTS = 100 };
    struct ride ride;
    double len[MANY], phi[MANY], rate[MANY], t[INSTANTS], energy = 0;
    double *rows = malloc(4 * sizeof(double) * MANY * INSTANTS);
    int parent[MANY];
    unsigned long long seed = 5;
    REQUIRE(rows != NULL);
    for (int k = 0; k < MANY; k++) {
        len[k] = 0.5 + test_random(&seed);
        phi[k] = 6 * test_random(&seed);
        rate[k] = 2 * test_random(&seed) - 1;
        parent[k] = k ? test_random_int(&seed, k) : -1;
    }
    REQUIRE(pend_tree_new(&ride.tree, MANY, len, len, parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = phi, .rate = rate, .rtol = 1e-10};
    size_t all = (size_t)MANY * INSTANTS;
    struct pend_points points = {rows, rows + all, rows + 2 * all, rows + 3 * all, NULL};
    REQUIRE(ride_open(&ride, &problem));
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
    pend_method_taylor.close(&ride.stepper);
    pend_tree_free(&ride.tree);
    free(rows);
}

TEST(taylor_open_fails_cleanly_without_memory) {
    struct ride ride;
    REQUIRE(pend_tree_new(&ride.tree, ARMS, paper_len, paper_mass, paper_parent, NULL) == PEND_OK);
    struct pend_problem problem = {
        .tree = ride.tree, .loads.gravity = 9.81, .phi = zero, .rate = zero, .rtol = 1e-10};
    struct pend_error error = {0};
    test_alloc_fail(1, 0);
    enum pend_status status = pend_method_taylor.open(&ride.stepper, &problem, &error);
    test_alloc_faults_off();
    CHECK(status == PEND_NO_MEMORY && !ride.stepper && error.code == PEND_NO_MEMORY);
    pend_tree_free(&ride.tree);
}
