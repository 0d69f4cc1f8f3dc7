/* Whole turns of a start change nothing but the reported angles, for any number of turns. */
#include <math.h>
#include <string.h>

#include "core/ensemble/lyapunov.h"
#include "core/extended/trust.h"
#include "core/integrate/events/section.h"
#include "core/modes/modes.h"
#include "core/tree/turns.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"

enum { ARMS = 2, INSTANTS = 11, STARTS = 5 };

static const double huge_phi[STARTS][ARMS] = {
    {1e4, -1e4 + 1}, {1e7, -1e7 + 1}, {1e15, -1e15 + 1}, {1e22, 1}, {-1e300, 1.7e308}};
static const double huge_rate[ARMS] = {1, 2};

struct pair {
    struct pend_tree *tree;
    double rest[ARMS], rest_low[ARMS];
};

static int pair_init(struct pair *pair, const double phi[ARMS]) {
    const double one[ARMS] = {1, 1};
    const int parent[ARMS] = {-1, 0};
    for (int k = 0; k < ARMS; k++) {
        struct pend_sum rest = pend_turns_rest(phi[k], 0, NULL);
        pair->rest[k] = rest.high, pair->rest_low[k] = rest.low;
    }
    return pend_tree_new(&pair->tree, ARMS, one, one, parent, NULL) == PEND_OK;
}

static struct pend_problem pair_problem(const struct pair *pair, const double phi[ARMS],
                                        double stop) {
    int rest = phi == pair->rest;
    return (struct pend_problem){
        .tree = pair->tree,
        .loads.gravity = 9.81,
        .phi = phi,
        .phi_low = rest ? pair->rest_low : NULL,
        .rate = huge_rate,
        .times = {.count = INSTANTS, .span = stop, .divisor = INSTANTS - 1}};
}

/* all numbers of two runs are the same except the angles, which differ by the turns */
static void check_turned(const struct test_record *huge, const struct test_record *rest,
                         const double phi[ARMS], const char *what) {
    size_t bytes = sizeof(double[INSTANTS * ARMS]);
    REQUIRE(huge->status == PEND_OK && rest->status == PEND_OK && huge->samples.count == INSTANTS);
    CHECK_SAYING(!memcmp(huge->samples.rate, rest->samples.rate, bytes), "rates, %s", what);
    CHECK_SAYING(!memcmp(huge->samples.force, rest->samples.force, bytes), "forces, %s", what);
    CHECK_SAYING(!memcmp(huge->samples.z_re, rest->samples.z_re, bytes), "positions, %s", what);
    CHECK(huge->stats.energy_drift == rest->stats.energy_drift);
    for (int i = 0; i < INSTANTS; i++)
        for (int k = 0; k < ARMS; k++) {
            double told = huge->samples.phi[i * ARMS + k],
                   moved = rest->samples.phi[i * ARMS + k] - rest->samples.phi[k];
            CHECK_SAYING(fabs(told - (phi[k] + moved)) <= 2e-15 + 0x1p-52 * fabs(phi[k]),
                         "angle %.17g, %s", told, what);
        }
    CHECK(!memcmp(huge->samples.phi, phi, sizeof(double[ARMS])));
}

TEST(whole_turns_do_not_matter_to_any_method) {
    for (int i = 0; i < STARTS; i++) {
        struct pair pair;
        REQUIRE(pair_init(&pair, huge_phi[i]));
        for (int m = 0; pend_method_at(m); m++)
            for (int extended = 0; extended <= (pend_method_at(m)->extended != NULL); extended++) {
                const struct pend_method *method =
                    extended ? pend_method_at(m)->extended : pend_method_at(m);
                OWN(test_record, clear) huge, rest;
                struct pend_problem problem = pair_problem(&pair, huge_phi[i], 2);
                test_record_blocks(&huge, method, &problem, INSTANTS, INFINITY);
                problem = pair_problem(&pair, pair.rest, 2);
                test_record_blocks(&rest, method, &problem, INSTANTS, INFINITY);
                check_turned(&huge, &rest, huge_phi[i], method->name);
            }
        pend_tree_free(&pair.tree);
    }
}

/* angles of many turns have few digits at 1e9, and 32 digits do not count that against doubles */
TEST(whole_turns_do_not_end_the_trust) {
    for (int i = 0; i < STARTS; i++) {
        struct pair pair;
        struct pend_trust *trust;
        int done = 0;
        REQUIRE(pair_init(&pair, huge_phi[i]));
        struct pend_problem problem = pair_problem(&pair, huge_phi[i], 2);
        REQUIRE(pend_trust_new(&trust, &pend_method_taylor, &problem, 1e-9, NULL) == PEND_OK);
        CHECK_INT(pend_trust_next(trust, INFINITY, &done, NULL), PEND_OK);
        CHECK(done && pend_trust_until(trust) == 2);
        pend_trust_free(&trust);
        pend_tree_free(&pair.tree);
    }
}

/* ---- members */

struct crowd {
    const double *phi[2];
    double end[2][ARMS], rate[2][ARMS], row[2][ARMS], flip[2];
};

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    memcpy(member->phi, ((struct crowd *)context)->phi[i], sizeof(double[ARMS]));
    memcpy(member->rate, huge_rate, sizeof huge_rate);
    return 0;
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct crowd *crowd = context;
    CHECK_INT(outcome->stop, PEND_STOP_TIME);
    memcpy(crowd->end[i], outcome->phi, sizeof(double[ARMS]));
    memcpy(crowd->rate[i], outcome->rate, sizeof(double[ARMS]));
    crowd->flip[i] = outcome->first;
    return 0;
}

static void crowd_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    (void)rate, (void)force, (void)theta, (void)first, (void)count;
    memcpy(((struct crowd *)context)->row[i], phi, sizeof(double[ARMS]));
}

TEST(whole_turns_do_not_matter_to_members) {
    const double times[] = {0, 2};
    for (int i = 0; i < STARTS; i++) {
        struct pair pair;
        struct pend_ensemble *ensemble;
        REQUIRE(pair_init(&pair, huge_phi[i]));
        struct crowd crowd = {.phi = {huge_phi[i], pair.rest}};
        struct pend_ensemble_problem problem = {.tree = pair.tree,
                                                .loads.gravity = 9.81,
                                                .duration = 2,
                                                .rtol = 1e-12,
                                                .bound = M_PI,
                                                .times = times,
                                                .times_count = 1,
                                                .fetch = crowd_fetch,
                                                .deliver = crowd_deliver,
                                                .rows = crowd_rows,
                                                .context = &crowd};
        REQUIRE(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK);
        CHECK_INT(test_ensemble_run(ensemble, 0, 2), PEND_OK);
        CHECK(!memcmp(crowd.row[0], huge_phi[i], sizeof(double[ARMS])));
        for (int k = 0; k < ARMS; k++) {
            double moved = crowd.end[1][k] - pair.rest[k];
            // members do not store the low part of their start's remainder
            CHECK(fabs(crowd.rate[0][k] - crowd.rate[1][k]) < 1e-12);
            CHECK(fabs(crowd.end[0][k] - (huge_phi[i][k] + moved)) <=
                  1e-12 + 0x1p-52 * fabs(huge_phi[i][k]));
        }
        CHECK(crowd.flip[0] == crowd.flip[1] || fabs(crowd.flip[0] - crowd.flip[1]) < 1e-12 ||
              (isnan(crowd.flip[0]) && isnan(crowd.flip[1])));
        pend_ensemble_free(&ensemble);
        pend_tree_free(&pair.tree);
    }
}

/* ---- sections, exponents, modes */

static double first_passage(const struct pair *pair, const double phi[ARMS],
                            double state[2 * ARMS]) {
    struct pend_section_problem problem = {.tree = pair->tree,
                                           .loads.gravity = 9.81,
                                           .phi = phi,
                                           .rate = huge_rate,
                                           .duration = 10,
                                           .arm = 1,
                                           .angle = -M_PI_2,
                                           .ways = PEND_WAY_UP | PEND_WAY_DOWN};
    OWN(pend_section, free) *section;
    struct pend_passage passage = {0};
    enum pend_found found = PEND_FOUND_NOTHING;
    if (pend_section_new(&section, &problem, NULL) != PEND_OK) return NAN;
    enum pend_status status = PEND_OK;
    while (status == PEND_OK && found == PEND_FOUND_NOTHING)
        status = pend_section_next(section, 100, &found, &passage, state, state + ARMS, NULL);
    return found == PEND_FOUND_PASSAGE ? passage.time : NAN;
}

static double exponent(const struct pair *pair, const double phi[ARMS]) {
    struct pend_lyapunov_problem problem = {.tree = pair->tree,
                                            .loads.gravity = 9.81,
                                            .phi = phi,
                                            .rate = huge_rate,
                                            .interval = 0.5,
                                            .count = 1};
    OWN(pend_lyapunov, free) *lyapunov;
    int done = 0;
    double found = NAN;
    if (pend_lyapunov_new(&lyapunov, &problem, NULL) != PEND_OK) return NAN;
    if (pend_lyapunov_go(lyapunov, 100000, &done, NULL) == PEND_OK && done)
        pend_lyapunov_exponents(lyapunov, &found);
    return found;
}

TEST(whole_turns_do_not_matter_to_sections_exponents_and_modes) {
    for (int i = 0; i < STARTS; i++) {
        struct pair pair;
        double state[2][2 * ARMS];
        REQUIRE(pair_init(&pair, huge_phi[i]));
        double time = first_passage(&pair, huge_phi[i], state[0]);
        CHECK(time > 0 && fabs(time - first_passage(&pair, pair.rest, state[1])) < 1e-11);
        for (int k = 0; k < ARMS; k++) {
            CHECK(fabs(state[0][ARMS + k] - state[1][ARMS + k]) < 1e-10);
            CHECK(fabs(state[0][k] - (huge_phi[i][k] + (state[1][k] - pair.rest[k]))) <=
                  1e-10 + 0x1p-52 * fabs(huge_phi[i][k]));
            CHECK(fabs(remainder(pend_modes_theta(huge_phi[i][k], 0) - pair.rest[k] - M_PI_2,
                                 2 * M_PI)) < 1e-15);
        }
        CHECK(fabs(exponent(&pair, huge_phi[i]) - exponent(&pair, pair.rest)) < 1e-5);
        pend_tree_free(&pair.tree);
    }
}

/* ---- a free spin */

static int spin_fetch(void *context, long i, struct pend_member *member) {
    (void)context, (void)i;
    member->phi[0] = 0.5;
    member->rate[0] = 1.25;
    return 0;
}

static int spin_deliver(void *context, long i, const struct pend_outcome *outcome) {
    (void)i;
    memcpy(context, outcome->phi, sizeof(double));
    return 0;
}

/* a million radians without gravity: the only error is the rounding of the reported angle */
TEST(whole_turns_of_a_free_spin_add_up) {
    const double one = 1, start = 0.5, spin = 1.25, end = 1000000.5;
    const int parent = -1;
    OWN(pend_tree, free) *tree;
    double phi = 0;
    REQUIRE(pend_tree_new(&tree, 1, &one, &one, &parent, NULL) == PEND_OK);
    struct pend_problem problem = {.tree = tree, .phi = &start, .rate = &spin};
    problem.times = (struct pend_times){.count = 3, .span = 8e5, .divisor = 2};
    for (int extended = 0; extended < 2; extended++) {
        OWN(test_record, clear) record;
        test_record_blocks(&record, extended ? pend_method_taylor.extended : &pend_method_taylor,
                           &problem, 3, INFINITY);
        CHECK_INT(record.status, PEND_OK);
        CHECK_SAYING(record.samples.phi[2] == end, "%.17g", record.samples.phi[2]);
        CHECK(record.samples.phi[1] == 500000.5 && record.samples.rate[2] == spin);
    }
    struct pend_ensemble_problem many = {.tree = tree,
                                         .duration = 8e5,
                                         .rtol = 1e-12,
                                         .fetch = spin_fetch,
                                         .deliver = spin_deliver,
                                         .context = &phi};
    OWN(pend_ensemble, free) *ensemble;
    REQUIRE(pend_ensemble_new(&ensemble, &many, pend_isa_best(), NULL) == PEND_OK);
    CHECK_INT(test_ensemble_run(ensemble, 0, 1), PEND_OK);
    CHECK_SAYING(phi == end, "%.17g", phi);
}

/* Arms in one line rotate like one rigid body without gravity: every step is like the last, with
 * the same rounding. They drifted by 5e-6 rad in this time. */
TEST(arms_that_turn_as_one_do_so_to_rounding) {
    enum { MOST = 3 };
    const double length[MOST] = {1, 1.3, 1.6}, mass[MOST] = {1, 0.5, 1 / 3.0},
                 phi[MOST] = {0.3, 0.3, 0.3}, rate[MOST] = {1, 1, 1};
    const int parent[MOST] = {-1, 0, 1};
    for (int n = 2; n <= MOST; n++) {
        OWN(pend_tree, free) *tree;
        OWN(test_record, clear) record = {0};
        REQUIRE(pend_tree_new(&tree, n, length, mass, parent, NULL) == PEND_OK);
        struct pend_problem problem = {.tree = tree, .phi = phi, .rate = rate};
        problem.times = (struct pend_times){.count = 2, .span = 2e5, .divisor = 1};
        test_record(&record, "taylor", &problem);
        REQUIRE(record.status == PEND_OK);
        for (int k = 0; k < n; k++) {
            double off = record.samples.phi[n + k] - 200000.3;
            CHECK_SAYING(fabs(off) <= 1e-9, "arm %d of %d: %g rad", k + 1, n, off);
        }
        CHECK_SAYING(record.stats.energy_drift < 1e-14, "%g", record.stats.energy_drift);
    }
}
