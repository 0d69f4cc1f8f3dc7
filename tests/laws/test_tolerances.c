/* The meaning of tolerances: as long as a motion does not amplify errors, the error of a run is at
 * most 30 times its tolerance. */
#include <math.h>
#include <string.h>

#include "core/extended/extended.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { INSTANTS = 7, ARMS_MAX = 32 };

/* a motion up to the instant at which a deviation of its start has grown thirtyfold (make
 * bench-precision prints it) */
struct motion {
    const char *name;
    int n;
    double phi, phi_next, stop; /* the angles of the first arm and of the others */
    struct pend_tree *tree;
    double start[ARMS_MAX], rest[ARMS_MAX];
    struct pend_problem problem;
    struct test_record exact;
};

static int motion_init(struct motion *m) {
    static const double paper_length[] = {2, 1.5, 0.75, 1.25}, paper_mass[] = {1, 1, 1, 0.1};
    static const int paper_parent[] = {-1, 0, 1, 1};
    double one[ARMS_MAX];
    int chain[ARMS_MAX], paper = m->n == 4;
    for (int k = 0; k < ARMS_MAX; k++) one[k] = 1, chain[k] = k - 1;
    for (int k = 0; k < m->n; k++) m->start[k] = k ? m->phi_next : m->phi, m->rest[k] = 0;
    if (pend_tree_new(&m->tree, m->n, paper ? paper_length : one, paper ? paper_mass : one,
                      paper ? paper_parent : chain, NULL) != PEND_OK)
        return 0;
    m->problem = (struct pend_problem){
        .tree = m->tree, .loads.gravity = 9.81, .phi = m->start, .rate = m->rest};
    m->problem.times =
        (struct pend_times){.count = INSTANTS, .span = m->stop, .divisor = INSTANTS - 1};
    test_record_blocks(&m->exact, pend_method_taylor.extended, &m->problem, INSTANTS, INFINITY);
    return m->exact.status == PEND_OK;
}

static void motion_clear(struct motion *m) {
    test_record_clear(&m->exact);
    pend_tree_free(&m->tree);
}

/* atol of a case: 0, equal to rtol, the default */
enum atol_kind { ATOL_ZERO, ATOL_RTOL, ATOL_DEFAULT, ATOL_KINDS };

static double motion_error(const struct motion *m, const struct pend_method *method, double rtol,
                           enum atol_kind atol) {
    struct pend_problem problem = m->problem;
    OWN(test_record, clear) record;
    problem.rtol = rtol;
    problem.atol = atol == ATOL_RTOL ? rtol : 0;
    problem.atol_given = atol != ATOL_DEFAULT;
    test_record_blocks(&record, method, &problem, INSTANTS, INFINITY);
    double gap = record.status == PEND_OK ? test_record_gap(&record, &m->exact).phi : INFINITY;
    CHECK_SAYING(record.status == PEND_OK, "%s, %s: %s", method->name, m->name, record.error.text);
    return gap;
}

TEST(tolerances_bound_the_error_of_a_run) {
    struct motion motion[] = {{.name = "the paper's example", .n = 4, .stop = 4},
                              {.name = "double pendulum",
                               .n = 2,
                               .phi = 2 - M_PI_2,
                               .phi_next = 2.5 - M_PI_2,
                               .stop = 2.5},
                              {.name = "chain of 32", .n = 32, .stop = 1},
                              {.name = "one arm", .n = 1, .phi = 2 - M_PI_2, .stop = 10}};
    const double rtol[] = {1e-4, 1e-7, 1e-10, 1e-13};
    for (size_t i = 0; i < sizeof motion / sizeof *motion; i++) {
        REQUIRE(motion_init(&motion[i]));
        const struct pend_method *method;
        for (int k = 0; (method = pend_method_at(k)); k++) {
            if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
            // ode23 takes a million steps for the last tolerance, which the next test uses once
            int tolerances = method == &pend_method_ode23 ? 3 : 4;
            for (int j = 0; j < tolerances; j++)
                for (int a = 0; a < ATOL_KINDS; a++) {
                    double over =
                        motion_error(&motion[i], method, rtol[j], (enum atol_kind)a) / rtol[j];
                    CHECK_SAYING(over <= 30, "%s, %s, rtol %g, atol %d: the error is %.3g rtol",
                                 method->name, motion[i].name, rtol[j], a, over);
                }
        }
        motion_clear(&motion[i]);
    }
}

/* even the smallest tolerance of a method is met as far as doubles allow, and the run ends */
TEST(tolerances_can_be_the_tightest_of_a_method) {
    OWN(motion, clear) motion = {.name = "double pendulum",
                                 .n = 2,
                                 .phi = 2 - M_PI_2,
                                 .phi_next = 2.5 - M_PI_2,
                                 .stop = 2.5};
    REQUIRE(motion_init(&motion));
    const struct pend_method *method;
    for (int k = 0; (method = pend_method_at(k)); k++) {
        if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
        double error = motion_error(&motion, method, method->rtol_min, ATOL_ZERO);
        CHECK_SAYING(error <= 3e-12, "%s: %g", method->name, error);
    }
}

/* an absolute tolerance of a radian is loose, but the result is still a motion */
TEST(tolerances_as_loose_as_they_may_be_end_a_run_well) {
    OWN(motion, clear) motion = {.name = "double pendulum",
                                 .n = 2,
                                 .phi = 2 - M_PI_2,
                                 .phi_next = 2.5 - M_PI_2,
                                 .stop = 2.5};
    REQUIRE(motion_init(&motion));
    const struct pend_method *method;
    for (int k = 0; (method = pend_method_at(k)); k++) {
        if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
        OWN(test_record, clear) record;
        motion.problem.atol = method->atol_max;
        test_record(&record, method->name, &motion.problem);
        CHECK_SAYING(record.status == PEND_OK, "%s: %s", method->name, record.error.text);
        CHECK(record.stats.energy_drift < 0.5);
    }
}

/* ---- the same rule in lanes: members and 32 digits */

struct member_end {
    const struct motion *motion;
    double phi[ARMS_MAX];
};

static int member_fetch(void *context, long i, struct pend_member *member) {
    const struct motion *m = ((struct member_end *)context)->motion;
    (void)i;
    memcpy(member->phi, m->start, (size_t)m->n * sizeof(double));
    return 0;
}

static int member_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct member_end *end = context;
    (void)i;
    memcpy(end->phi, outcome->phi, (size_t)end->motion->n * sizeof(double));
    return 0;
}

static double member_gap(const struct member_end *end) {
    const double *exact =
        end->motion->exact.samples.phi + (size_t)(INSTANTS - 1) * (size_t)end->motion->n;
    double gap = 0;
    for (int k = 0; k < end->motion->n; k++) gap = fmax(gap, fabs(end->phi[k] - exact[k]));
    return gap;
}

TEST(tolerances_of_members_and_of_32_digits_are_those_of_taylor) {
    OWN(motion, clear) motion = {.name = "double pendulum",
                                 .n = 2,
                                 .phi = 2 - M_PI_2,
                                 .phi_next = 2.5 - M_PI_2,
                                 .stop = 2.5};
    REQUIRE(motion_init(&motion));
    for (int e = 4; e <= 12; e += 4) {
        double rtol = pow(10, -e);
        struct member_end end = {.motion = &motion};
        struct pend_ensemble_problem problem = {.tree = motion.tree,
                                                .loads.gravity = 9.81,
                                                .duration = motion.stop,
                                                .rtol = rtol,
                                                .atol = rtol,
                                                .fetch = member_fetch,
                                                .deliver = member_deliver,
                                                .context = &end};
        struct pend_ensemble *ensemble;
        OWN(pend_extended, free) *extended = NULL;
        double rate[ARMS_MAX] = {0};
        struct pend_extended_state start = {.phi = motion.start, .rate = rate};
        REQUIRE(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK);
        CHECK_INT(test_ensemble_run(ensemble, 0, 1), PEND_OK);
        CHECK_SAYING(member_gap(&end) <= 30 * rtol, "a member, %g: %g", rtol,
                     member_gap(&end) / rtol);
        pend_ensemble_free(&ensemble);
        REQUIRE(pend_extended_new(&extended, motion.tree, NULL, rtol, rtol, pend_isa_best(),
                                  NULL) == PEND_OK);
        pend_extended_start(extended, TEST_LOADS(9.81), &start, 0, motion.stop);
        while (pend_extended_step(extended) == PEND_EXTENDED_UNDER_WAY) continue;
        pend_extended_end(extended, &(struct pend_extended_state){.phi = end.phi, .rate = rate});
        CHECK_SAYING(member_gap(&end) <= 30 * rtol, "32 digits, %g: %g", rtol,
                     member_gap(&end) / rtol);
    }
}
