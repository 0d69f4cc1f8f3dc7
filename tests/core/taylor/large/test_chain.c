/* Tests of core/taylor/large/chain: whole runs of a chain of similar masses, their errors and their
 * units. Leaves to others: the coefficients (test_jets). Invariant: three pieces of eight arms. */
#include "core/taylor/large/chain.h"

#include <math.h>
#include <string.h>

#include "core/integrate/run/run.h"
#include "tests/harness/test.h"

extern const struct pend_method pend_method_taylor, pend_method_taylor_extended;

static const double GRAVITY = 9.81;

enum { COUNT = 41, RUN_ARMS = 24 };

/* angles of a chain released from horizontal at COUNT instants; lengths, masses and time in other
 * units */
static int run_chain(const struct pend_method *method, double rtol, const double unit[3],
                     double phi[]) {
    double len[RUN_ARMS], mass[RUN_ARMS], zero[RUN_ARMS] = {0}, t[COUNT];
    int parent[RUN_ARMS], done = 0;
    OWN(pend_tree, free) *tree;
    OWN(pend_run, free) *run = NULL;
    for (int k = 0; k < RUN_ARMS; k++) {
        len[k] = unit[0] * (1 + k % 3 * 0.25) / RUN_ARMS;
        mass[k] = unit[1] * (1 + k % 5 * 0.125);
        parent[k] = k - 1;
    }
    if (pend_tree_new(&tree, RUN_ARMS, len, mass, parent, NULL) != PEND_OK) return 0;
    struct pend_problem ask = {.tree = tree,
                               .loads.gravity = GRAVITY * unit[0] / unit[2] / unit[2],
                               .phi = zero,
                               .rate = zero,
                               .rtol = rtol};
    ask.times = (struct pend_times){.count = COUNT, .span = 0.8 * unit[2], .divisor = COUNT - 1};
    struct pend_samples samples = {.cap = COUNT, .t = t, .phi = phi};
    enum pend_status status = pend_run_new(&run, method, &ask, NULL);
    while (status == PEND_OK && !done) status = pend_run_next(run, &samples, 1e12, &done, NULL);
    return status == PEND_OK;
}

static const double plain[3] = {1, 1, 1};

TEST(chain_error_of_a_run_follows_the_tolerance) {
    static double want[COUNT * RUN_ARMS], phi[COUNT * RUN_ARMS];
    REQUIRE(run_chain(&pend_method_taylor_extended, 1e-24, plain, want));
    static const struct {
        double rtol, error;
    } cases[] = {{1e-6, 1e-6}, {1e-8, 1e-8}, {1e-10, 1e-10}, {1e-12, 1e-12}, {1e-16, 1e-14}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double worst = 0;
        REQUIRE(run_chain(&pend_method_taylor, cases[i].rtol, plain, phi));
        for (int j = 0; j < COUNT * RUN_ARMS; j++) worst = fmax(worst, fabs(phi[j] - want[j]));
        CHECK_RESIDUAL(worst, cases[i].error, "angles of a chain");
    }
}

/* powers of two are exact, so no digit may change */
TEST(chain_has_the_same_bits_in_any_unit_of_length_mass_and_time) {
    static double want[COUNT * RUN_ARMS], phi[COUNT * RUN_ARMS];
    REQUIRE(run_chain(&pend_method_taylor, 1e-9, plain, want));
    static const double unit[][3] = {{0x1p-10, 1, 1},         {0x1p10, 1, 1},  {1, 0x1p-60, 1},
                                     {1, 0x1p60, 1},          {1, 1, 0x1p-10}, {1, 1, 0x1p10},
                                     {0x1p40, 0x1p90, 0x1p30}};
    for (size_t i = 0; i < sizeof unit / sizeof *unit; i++) {
        REQUIRE(run_chain(&pend_method_taylor, 1e-9, unit[i], phi));
        CHECK(!memcmp(phi, want, sizeof phi) && phi[COUNT * RUN_ARMS - 1] != 0);
    }
}
