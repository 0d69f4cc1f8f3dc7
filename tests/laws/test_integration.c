/* Laws of motion for every method, each within its tolerance. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_sf_elljac.h>

#include "tests/harness/runs.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

/* the methods that solve the equations of motion, and the tolerances of these laws for each */
static const struct {
    const char *name;
    double rtol, atol;
    double back;  /* rad, rad/s: 1 s there and back, six arms */
    double drift; /* relative energy drift over 2 s, six arms */
    double swing; /* rad: three periods of a pendulum */
    double unit;  /* rad: the same motion in another unit of time, in which atol is different */
} law_method[] = {
    {"taylor", 1e-13, 0, 1e-11, 1e-14, 1e-12, 1e-14},
    {"ode23", 1e-6, 1e-8, 1e-2, 1e-6, 1e-3, 1e-8},
    {"rkf45", 1e-12, 1e-14, 2e-9, 1e-12, 2e-9, 1e-11},
    {"rk8pd", 1e-13, 1e-15, 1e-11, 1e-13, 1e-11, 1e-13},
    {"msadams", 1e-12, 1e-14, 2e-9, 1e-12, 1e-10, 1e-11},
    {"symplectic", 0, 0, 1e-11, 1e-14, 1e-12, 1e-13},
};

enum { LAW_METHODS = sizeof law_method / sizeof *law_method, ARMS = 6 };

static struct pend_problem law_problem(const struct test_tree *t, int method, double span,
                                       long count) {
    return (struct pend_problem){
        .tree = t->tree,
        .loads.gravity = 9.81,
        .phi = t->phi,
        .rate = t->rate,
        .rtol = law_method[method].rtol,
        .atol = law_method[method].atol,
        .times = {.count = count, .span = span, .divisor = (double)(count - 1)}};
}

/* the state of a record's last sample, in stored order */
static void last_state(const struct test_record *record, const struct pend_tree *tree, double phi[],
                       double rate[]) {
    long last = (record->samples.count - 1) * record->n;
    for (int k = 0; k < tree->n; k++) {
        phi[k] = record->samples.phi[last + tree->order[k]];
        rate[k] = record->samples.rate[last + tree->order[k]];
    }
}

TEST(integration_there_and_back_ends_where_it_began) {
    unsigned long long seed = 1;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, ARMS, 0.3, &seed);
    for (int m = 0; m < LAW_METHODS; m++) {
        double phi[ARMS], rate[ARMS], moved = 0, gap = 0;
        OWN(test_record, clear) there, back;
        struct pend_problem problem = law_problem(&t, m, 1, 3);
        test_record(&there, law_method[m].name, &problem);
        last_state(&there, t.tree, phi, rate);
        for (int k = 0; k < ARMS; k++) moved = fmax(moved, fabs(phi[k] - t.phi[k]));
        problem.phi = phi;
        problem.rate = rate;
        problem.times.start = 1;
        problem.times.span = -1;
        test_record(&back, law_method[m].name, &problem);
        last_state(&back, t.tree, phi, rate);
        for (int k = 0; k < ARMS; k++)
            gap = fmax(gap, fmax(fabs(phi[k] - t.phi[k]), fabs(rate[k] - t.rate[k])));
        CHECK(moved > 0.5);
        CHECK_RESIDUAL(gap, law_method[m].back, law_method[m].name);
    }
}

TEST(integration_keeps_the_energy_to_its_tolerance) {
    unsigned long long seed = 2;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_LIMBS, ARMS, 0.3, &seed);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) record;
        struct pend_problem problem = law_problem(&t, m, 2, 21);
        test_record(&record, law_method[m].name, &problem);
        CHECK_INT(record.status, PEND_OK);
        CHECK_RESIDUAL(record.stats.energy_drift, law_method[m].drift, law_method[m].name);
    }
}

/* ---- a single pendulum, theta = phi + pi/2, w = sqrt(g/l): Jacobi's elliptic functions */

static const double law_quarter = 1.57079632679489661923, law_length = 0.7;

static void single_init(struct test_tree *t, double theta, double rate) {
    unsigned long long seed = 3;
    const int parent[] = {-1};
    test_tree_init(t, 1, parent, 0.3, &seed);
    t->length[0] = law_length;
    test_tree_rebuild(t);
    t->phi[0] = theta - law_quarter;
    t->rate[0] = rate;
}

TEST(integration_of_a_swinging_pendulum_is_elliptic) {
    const double theta = 2.5, w = sqrt(9.81 / law_length), k = sin(theta / 2), m1 = cos(theta / 2);
    OWN(test_tree, clear) t;
    single_init(&t, theta, 0);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) record;
        struct pend_problem problem = law_problem(&t, m, 6, 121);
        double angle = 0, rate = 0;
        test_record(&record, law_method[m].name, &problem);
        CHECK_INT(record.samples.count, 121);
        for (long i = 0; i < record.samples.count; i++) {
            double sn, cn, dn;
            gsl_sf_elljac_e(w * record.samples.t[i], k * k, &sn, &cn, &dn);
            /* sin(theta/2) = k cd, theta' = -2 k k' w sd */
            angle = fmax(angle, fabs(record.samples.phi[i] + law_quarter - 2 * asin(k * cn / dn)));
            rate = fmax(rate, fabs(record.samples.rate[i] + 2 * k * m1 * w * sn / dn));
        }
        CHECK_RESIDUAL(angle, law_method[m].swing, law_method[m].name);
        CHECK_RESIDUAL(rate, 10 * law_method[m].swing, law_method[m].name);
    }
}

/* with enough energy it turns over: theta = 2 am(v t), v half the rate at the bottom, modulus
 * w/v */
TEST(integration_of_a_turning_pendulum_is_elliptic) {
    const double w = sqrt(9.81 / law_length), v = 1.2 * w;
    OWN(test_tree, clear) t;
    single_init(&t, 0, 2 * v);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) record;
        struct pend_problem problem = law_problem(&t, m, 4, 81);
        double gap = 0, largest = 0;
        test_record(&record, law_method[m].name, &problem);
        CHECK_INT(record.samples.count, 81);
        for (long i = 0; i < record.samples.count; i++) {
            double sn, cn, dn, half = (record.samples.phi[i] + law_quarter) / 2;
            gsl_sf_elljac_e(v * record.samples.t[i], (w / v) * (w / v), &sn, &cn, &dn);
            gap = fmax(gap, fmax(fabs(sin(half) - sn), fabs(cos(half) - cn)));
            largest = fmax(largest, half);
        }
        CHECK(largest > 8);
        CHECK_RESIDUAL(gap, law_method[m].swing, law_method[m].name);
    }
}

/* ---- order of convergence: the error against the number of steps */

static const struct {
    const char *name;
    double least, most,
        rtol[2]; /* rk8pd has not quite reached its limit when rounding ends the comparison */
} law_order[] = {{"ode23", 2.7, 3.3, {1e-5, 1e-8}},
                 {"rkf45", 4.6, 5.4, {1e-7, 1e-11}},
                 {"rk8pd", 7.5, 9.5, {1e-8, 1e-12}}};

/* error at the last instant, and steps */
static double order_error(const struct test_tree *t, int i, double rtol, double *steps) {
    OWN(test_record, clear) got, exact;
    struct pend_problem problem = law_problem(t, 0, 6, 2);
    test_record(&exact, "taylor", &problem);
    problem.rtol = rtol;
    problem.atol = rtol;
    test_record(&got, law_order[i].name, &problem);
    double error = test_record_gap(&got, &exact).phi;
    *steps = (double)got.stats.steps;
    return error;
}

TEST(integration_converges_with_the_order_of_its_method) {
    OWN(test_tree, clear) t;
    single_init(&t, 2.5, 1);
    for (size_t i = 0; i < sizeof law_order / sizeof *law_order; i++) {
        double steps[2], coarse = order_error(&t, (int)i, law_order[i].rtol[0], &steps[0]);
        double fine = order_error(&t, (int)i, law_order[i].rtol[1], &steps[1]);
        double order = log(coarse / fine) / log(steps[1] / steps[0]);
        CHECK_SAYING(order > law_order[i].least && order < law_order[i].most,
                     "%s: order %.2f (%g, %g steps)", law_order[i].name, order, steps[0], steps[1]);
    }
}

/* ---- units and origins: powers of two, so that not one bit may change */

TEST(integration_does_not_care_for_the_unit_of_mass) {
    unsigned long long seed = 4;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_CATERPILLAR, ARMS, 0.3, &seed);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) light, heavy;
        struct pend_problem problem = law_problem(&t, m, 1, 11);
        test_record(&light, law_method[m].name, &problem);
        for (int k = 0; k < ARMS; k++) t.mass[k] *= 1024;
        test_tree_rebuild(&t);
        problem.tree = t.tree;
        test_record(&heavy, law_method[m].name, &problem);
        for (int k = 0; k < ARMS; k++) t.mass[k] /= 1024;
        test_tree_rebuild(&t);
        struct test_record_gap gap = test_record_gap(&light, &heavy);
        CHECK_SAYING(gap.phi == 0 && gap.rate == 0, "%s: %g %g", law_method[m].name, gap.phi,
                     gap.rate);
        for (int i = 0; i < 11 * ARMS; i++)
            CHECK(heavy.samples.force[i] == 1024 * light.samples.force[i]);
    }
}

TEST(integration_does_not_care_when_it_begins) {
    unsigned long long seed = 5;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_BINARY, ARMS, 0.3, &seed);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) early, late;
        struct pend_problem problem = law_problem(&t, m, 1, 65);
        test_record(&early, law_method[m].name, &problem);
        problem.times.start = 4096;
        test_record(&late, law_method[m].name, &problem);
        CHECK(late.samples.t[0] == 4096 && late.samples.t[64] == 4097);
        struct test_record_gap gap = test_record_gap(&early, &late);
        CHECK_SAYING(gap.phi == 0 && gap.rate == 0 && gap.force == 0, "%s", law_method[m].name);
    }
}

/* a quarter of the gravity, half of the rates: the same motion in twice the time, up to the
 * tolerance for the rates */
TEST(integration_does_not_care_for_the_unit_of_time) {
    unsigned long long seed = 6;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_STAR, ARMS, 0.3, &seed);
    for (int m = 0; m < LAW_METHODS; m++) {
        OWN(test_record, clear) fast, slow;
        struct pend_problem problem = law_problem(&t, m, 1, 11);
        problem.loads.gravity = 8;
        test_record(&fast, law_method[m].name, &problem);
        for (int k = 0; k < ARMS; k++) t.rate[k] /= 2;
        problem.loads.gravity = 2;
        problem.times.span = 2;
        test_record(&slow, law_method[m].name, &problem);
        for (int k = 0; k < ARMS; k++) t.rate[k] *= 2;
        CHECK_RESIDUAL(fmax(test_record_gap(&fast, &slow).phi, 1e-16), law_method[m].unit,
                       law_method[m].name);
    }
}

/* ---- against each other */

TEST(integration_by_any_method_gives_one_motion) {
    unsigned long long seed = 7;
    double phi = 0, force = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)kind, 8, 0.3, &seed);
        struct pend_problem problem = law_problem(&t, 0, 0.5, 6);
        OWN(test_record, clear) taylor, rk8pd;
        test_record(&taylor, "taylor", &problem);
        problem.atol = 1e-15;
        test_record(&rk8pd, "rk8pd", &problem);
        struct test_record_gap gap = test_record_gap(&taylor, &rk8pd);
        CHECK_SAYING(gap.phi < 1e-9, "%s: %g", test_tree_kind_name((enum test_tree_kind)kind),
                     gap.phi);
        phi = fmax(phi, gap.phi);
        force = fmax(force, gap.force);
    }
    CHECK_RESIDUAL(phi, 1e-13, "phi of taylor and rk8pd, every kind of tree");
    CHECK_RESIDUAL(force, 1e-10, "force of taylor and rk8pd, every kind of tree");
}
