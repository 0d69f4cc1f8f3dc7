/* Tests of core/ensemble/ensemble: equality with single runs, the same bits in any lane, crossings
 * at their exact time, failures that do not affect others. Leaves to others: the series
 * (test_jets), the step rule (test_method_taylor). Invariant: every instruction set that this
 * processor has is tested. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/methods/method.h"
#include "core/integrate/run/run.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/test.h"

extern const struct pend_method pend_method_taylor;

enum { MEMBERS = 40, ARMS_MAX = 6 };

/* members with random starts, and their results */
struct crowd {
    struct pend_tree *tree;
    double length[ARMS_MAX], mass[ARMS_MAX]; /* spread of the members' own lengths and masses, 0 =
                                              * the tree's */
    int vary, broken, stop_after;
    int delivered, status[MEMBERS], arm[MEMBERS];
    double phi[MEMBERS][ARMS_MAX], rate[MEMBERS][ARMS_MAX], time[MEMBERS], first[MEMBERS][ARMS_MAX];
    long crossings[MEMBERS][ARMS_MAX];
};

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    unsigned long long seed = (unsigned long long)i + 1;
    for (int k = 0; k < crowd->tree->n; k++) {
        member->phi[k] = 6 * test_random(&seed) - 3 - M_PI / 2;
        member->rate[k] = 2 * test_random(&seed) - 1;
        if (!crowd->vary) continue;
        member->length[k] = 0.5 + test_random(&seed);
        member->mass[k] = 0.5 + test_random(&seed);
        member->loads.gravity = 5 + 10 * test_random(&seed);
    }
    if (crowd->broken == i) member->rate[0] = NAN;
    return 0;
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct crowd *crowd = context;
    int n = crowd->tree->n;
    crowd->delivered++;
    crowd->status[i] = (int)outcome->status;
    crowd->arm[i] = outcome->arm;
    crowd->time[i] = outcome->time;
    for (int k = 0; k < n; k++) {
        crowd->phi[i][k] = outcome->phi[k];
        crowd->rate[i][k] = outcome->rate[k];
        if (!outcome->crossings) continue;
        crowd->first[i][k] = outcome->first_crossing[k];
        crowd->crossings[i][k] = outcome->crossings[k];
    }
    return crowd->stop_after && crowd->delivered >= crowd->stop_after;
}

static int crowd_tree(struct crowd *crowd, int n) {
    static const int parent[ARMS_MAX] = {-1, 0, 0, 1, 3, 1};
    static const double length[ARMS_MAX] = {1, 0.8, 0.7, 0.9, 0.5, 0.6},
                        mass[ARMS_MAX] = {1, 0.5, 0.7, 1.2, 0.4, 0.9};
    memset(crowd, 0, sizeof *crowd);
    crowd->broken = -1;
    return CHECK(pend_tree_new(&crowd->tree, n, length, mass, parent, NULL) == PEND_OK);
}

static struct pend_ensemble_problem crowd_problem(struct crowd *crowd, double duration) {
    return (struct pend_ensemble_problem){.tree = crowd->tree,
                                          .loads.gravity = 9.81,
                                          .duration = duration,
                                          .rtol = 1e-15,
                                          .fetch = crowd_fetch,
                                          .deliver = crowd_deliver,
                                          .context = crowd};
}

static int crowd_run(const struct pend_ensemble_problem *problem, enum pend_isa isa, long first,
                     long count) {
    OWN(pend_ensemble, free) *ensemble;
    if (!CHECK(pend_ensemble_new(&ensemble, problem, isa, NULL) == PEND_OK)) return 0;
    long allocations = test_alloc_count();
    int done = CHECK(test_ensemble_run(ensemble, first, count) == PEND_OK);
    CHECK_INT(test_alloc_count(), allocations);
    return done;
}

/* one member by the single method at rtol 1e-15: the state at the end */
static void crowd_single(struct crowd *crowd, long i, double duration, double phi[],
                         double rate[]) {
    double start[2][ARMS_MAX], length[ARMS_MAX], mass[ARMS_MAX], reached = 0;
    int n = crowd->tree->n, parent[ARMS_MAX];
    struct pend_member member = {
        .phi = start[0], .rate = start[1], .length = length, .mass = mass, .loads.gravity = 9.81};
    memcpy(length, crowd->tree->len, (size_t)n * sizeof(double));
    memcpy(mass, crowd->tree->mass, (size_t)n * sizeof(double));
    memcpy(parent, crowd->tree->parent, (size_t)n * sizeof(int));
    crowd_fetch(crowd, i, &member);
    OWN(pend_tree, free) *tree;
    REQUIRE(pend_tree_new(&tree, n, length, mass, parent, NULL) == PEND_OK);
    double from[2][ARMS_MAX];
    for (int k = 0; k < n; k++) {
        from[0][k] = start[0][tree->order[k]];
        from[1][k] = start[1][tree->order[k]];
    }
    struct pend_problem problem = {
        .tree = tree, .loads = member.loads, .phi = from[0], .rate = from[1], .rtol = 1e-15};
    void *stepper;
    REQUIRE(pend_method_taylor.open(&stepper, &problem, NULL) == PEND_OK);
    while (fabs(reached) < fabs(duration) &&
           !pend_method_taylor.step(stepper, duration, &reached, NULL)) {
    }
    double at[2][ARMS_MAX];
    struct pend_points points = {.phi = at[0], .rate = at[1]};
    pend_method_taylor.at(stepper, &duration, 1, &points);
    pend_method_taylor.close(&stepper);
    for (int k = 0; k < n; k++) {
        phi[tree->order[k]] = at[0][k];
        rate[tree->order[k]] = at[1][k];
    }
}

TEST(ensemble_members_end_where_single_runs_end) {
    double worst = 0;
    for (int n = 1; n <= ARMS_MAX; n++) {
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            struct crowd crowd;
            double phi[ARMS_MAX], rate[ARMS_MAX], duration = n % 2 ? 1 : -1;
            REQUIRE(crowd_tree(&crowd, n));
            crowd.vary = isa % 2 || n == 4;
            struct pend_ensemble_problem problem = crowd_problem(&crowd, duration);
            REQUIRE(crowd_run(&problem, (enum pend_isa)isa, 0, MEMBERS));
            CHECK_INT(crowd.delivered, MEMBERS);
            for (long i = 0; i < MEMBERS; i++) {
                crowd_single(&crowd, i, duration, phi, rate);
                CHECK(crowd.time[i] == duration && crowd.status[i] == PEND_OK &&
                      crowd.arm[i] == -1);
                for (int k = 0; k < n; k++) {
                    double error =
                        fmax(fabs(phi[k] - crowd.phi[i][k]), fabs(rate[k] - crowd.rate[i][k]) / 10);
                    if (!(error <= worst)) worst = error;
                }
            }
            pend_tree_free(&crowd.tree);
        }
    }
    CHECK_RESIDUAL(worst, 1e-11, "phi and phi' / 10 of a member against a single run");
}

TEST(ensemble_members_have_the_same_bits_in_any_lane_and_any_company) {
    for (int n = 2; n <= ARMS_MAX; n += 3) {
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            struct crowd whole, parts;
            REQUIRE(crowd_tree(&whole, n) && crowd_tree(&parts, n));
            struct pend_ensemble_problem a = crowd_problem(&whole, 2), b = crowd_problem(&parts, 2);
            a.bound = b.bound = M_PI;
            REQUIRE(crowd_run(&a, (enum pend_isa)isa, 0, MEMBERS));
            // in pieces that put every member into another lane
            REQUIRE(crowd_run(&b, (enum pend_isa)isa, 29, 11) &&
                    crowd_run(&b, (enum pend_isa)isa, 3, 26));
            REQUIRE(crowd_run(&b, (enum pend_isa)isa, 0, 3));
            CHECK(!memcmp(whole.phi, parts.phi, sizeof whole.phi));
            CHECK(!memcmp(whole.rate, parts.rate, sizeof whole.rate));
            CHECK(!memcmp(whole.crossings, parts.crossings, sizeof whole.crossings));
            CHECK(whole.rate[0][0] != whole.rate[1][0]);
            pend_tree_free(&whole.tree);
            pend_tree_free(&parts.tree);
        }
    }
}

TEST(ensemble_gives_the_same_bits_with_avx2_and_avx512) {
    struct crowd narrow, broad;
    if (pend_isa_best() < PEND_ISA_AVX512) {
        test_skip("this processor has no AVX-512");
        return;
    }
    for (int n = 2; n <= ARMS_MAX; n += 2) {
        REQUIRE(crowd_tree(&narrow, n) && crowd_tree(&broad, n));
        struct pend_ensemble_problem a = crowd_problem(&narrow, 2), b = crowd_problem(&broad, 2);
        REQUIRE(crowd_run(&a, PEND_ISA_AVX2, 0, MEMBERS) &&
                crowd_run(&b, PEND_ISA_AVX512, 0, MEMBERS));
        CHECK(!memcmp(narrow.phi, broad.phi, sizeof narrow.phi) &&
              !memcmp(narrow.rate, broad.rate, sizeof narrow.rate));
        pend_tree_free(&narrow.tree);
        pend_tree_free(&broad.tree);
    }
}

/* a single arm with enough energy to turn over: theta' from theta, and the time between from the
 * period's integral */
static int spin_fetch(void *context, long i, struct pend_member *member) {
    const double *rate = context;
    member->phi[0] = -M_PI / 2;
    member->rate[0] = i ? -*rate : *rate;
    return 0;
}

struct spin_result {
    double rate, first[2], time[2];
    long crossings[2];
};

static int spin_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct spin_result *result = context;
    result->first[i] = outcome->first_crossing[0];
    result->crossings[i] = outcome->crossings[0];
    result->time[i] = outcome->time;
    return 0;
}

/* time from hanging to upright: the integral of d theta / theta' by the midpoint rule, exact for
 * a smooth period */
static double spin_time(double rate) {
    double sum = 0;
    enum { POINTS = 4000 };
    for (int i = 0; i < POINTS; i++) {
        double theta = M_PI * (i + 0.5) / POINTS;
        sum += 1 / sqrt(rate * rate - 2 * 9.81 * (1 - cos(theta)));
    }
    return sum * M_PI / POINTS;
}

TEST(ensemble_times_the_flips_of_a_spinning_arm) {
    struct spin_result result = {.rate = 7};
    double one = 1, want = spin_time(result.rate);
    int pivot = -1;
    OWN(pend_tree, free) *tree;
    REQUIRE(pend_tree_new(&tree, 1, &one, &one, &pivot, NULL) == PEND_OK);
    struct pend_ensemble_problem problem = {
        .tree = tree, .loads.gravity = 9.81, .duration = 6.5 * want, .rtol = 1e-15};
    problem.bound = M_PI;
    problem.fetch = spin_fetch;
    problem.deliver = spin_deliver;
    problem.context = &result;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
    // upright at 1, 3 and 5 times the time to reach the top
    CHECK_INT(result.crossings[0], 3);
    CHECK_INT(result.crossings[1], 3);
    CHECK_RESIDUAL(fabs(result.first[0] / want - 1), 1e-13, "time of the first flip");
    CHECK(fabs(result.first[0] - result.first[1]) < 1e-14);
    problem.until = PEND_UNTIL_FIRST;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
    CHECK(result.time[0] == result.first[0] && result.crossings[0] == 1);
}

TEST(ensemble_sees_an_arm_that_only_touches_its_bound) {
    struct spin_result result = {.rate = 3};
    double one = 1, top = acos(1 - 9 / (2 * 9.81));
    int pivot = -1;
    OWN(pend_tree, free) *tree;
    REQUIRE(pend_tree_new(&tree, 1, &one, &one, &pivot, NULL) == PEND_OK);
    for (int i = 0; i < 2; i++) {
        // the turning point is inside a step; an angle just below is reached, one above is not
        struct pend_ensemble_problem problem = {
            .tree = tree, .loads.gravity = 9.81, .duration = 1, .rtol = 1e-15};
        problem.bound = top + (i ? 1e-9 : -1e-9);
        problem.fetch = spin_fetch;
        problem.deliver = spin_deliver;
        problem.context = &result;
        REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 2));
        CHECK_INT(result.crossings[0], i ? 0 : 2);
        CHECK_INT(result.crossings[1], i ? 0 : 2);
        CHECK(isnan(result.first[0]) == i);
    }
}

TEST(ensemble_delivers_a_broken_member_as_failed_and_the_others_whole) {
    struct crowd sound, ill;
    REQUIRE(crowd_tree(&sound, 3) && crowd_tree(&ill, 3));
    ill.broken = 7;
    struct pend_ensemble_problem a = crowd_problem(&sound, 1), b = crowd_problem(&ill, 1);
    REQUIRE(crowd_run(&a, pend_isa_best(), 0, MEMBERS) &&
            crowd_run(&b, pend_isa_best(), 0, MEMBERS));
    CHECK_INT(ill.delivered, MEMBERS);
    CHECK_INT(ill.status[7], PEND_NOT_FINITE);
    for (int i = 0; i < MEMBERS; i++) {
        if (i != 7)
            CHECK(ill.status[i] == PEND_OK &&
                  !memcmp(sound.phi[i], ill.phi[i], sizeof sound.phi[i]));
    }
    pend_tree_free(&sound.tree);
    pend_tree_free(&ill.tree);
}

static int rest_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    (void)i;
    // pi / 2 as a sum of two doubles: no force acts, and all terms of the series are 0
    for (int k = 0; k < crowd->tree->n; k++)
        member->phi[k] = -0x1.921fb54442d18p+0, member->phi_low[k] = -0x1.1a62633145c07p-54;
    return 0;
}

TEST(ensemble_members_that_hang_at_rest_stay_there) {
    struct crowd crowd;
    REQUIRE(crowd_tree(&crowd, 3));
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 10);
    problem.fetch = rest_fetch;
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        REQUIRE(crowd_run(&problem, (enum pend_isa)isa, 0, 3));
        for (int i = 0; i < 3; i++)
            CHECK(crowd.status[i] == PEND_OK && crowd.time[i] == 10 &&
                  crowd.phi[i][2] == -M_PI / 2 && crowd.rate[i][2] == 0);
    }
    pend_tree_free(&crowd.tree);
}

TEST(ensemble_obeys_its_step_limit_and_its_callbacks) {
    struct crowd crowd;
    struct pend_ensemble *ensemble;
    REQUIRE(crowd_tree(&crowd, 2));
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 10);
    problem.step_cap = 5;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
    CHECK(crowd.status[0] == PEND_TOO_MANY_STEPS && crowd.time[0] > 0 && crowd.time[0] < 10);
    crowd.delivered = 0;
    crowd.stop_after = 9;
    REQUIRE(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK);
    CHECK(test_ensemble_run(ensemble, 0, MEMBERS) == PEND_CANCELLED);
    CHECK(crowd.delivered >= 9 && crowd.delivered < 9 + 8);
    pend_ensemble_free(&ensemble);
    pend_tree_free(&crowd.tree);
}

TEST(ensemble_refuses_what_it_cannot_do) {
    struct crowd crowd;
    struct pend_ensemble *ensemble;
    struct pend_error error;
    REQUIRE(crowd_tree(&crowd, 2));
    for (int i = 0; i < 5; i++) {
        struct pend_ensemble_problem problem = crowd_problem(&crowd, 1);
        if (i == 0) problem.rtol = 0;
        if (i == 1) problem.atol = -1;
        if (i == 2) problem.bound = NAN;
        if (i == 3) problem.duration = INFINITY;
        if (i == 4) test_alloc_fail(1, 0);
        enum pend_status status = pend_ensemble_new(&ensemble, &problem, pend_isa_best(), &error);
        test_alloc_faults_off();
        CHECK(status == (i == 4 ? PEND_NO_MEMORY : PEND_INVALID) && !ensemble && error.text[0]);
    }
    pend_tree_free(&crowd.tree);
}

/* a member's extremes and crossings against those of a single run in many small samples */
enum { FINE = 20001 };

struct notes {
    struct crowd *crowd;
    int n;
    double most[MEMBERS][ARMS_MAX], most_time[MEMBERS][ARMS_MAX], least[MEMBERS][ARMS_MAX];
    double least_time[MEMBERS][ARMS_MAX], change[MEMBERS][ARMS_MAX], drift[MEMBERS],
        lyapunov[MEMBERS];
    long rows[MEMBERS];
    double phi[MEMBERS][8][ARMS_MAX], rate[MEMBERS][8][ARMS_MAX], force[MEMBERS][8][ARMS_MAX];
};

static int notes_fetch(void *context, long i, struct pend_member *member) {
    return crowd_fetch(((struct notes *)context)->crowd, i, member);
}

static int notes_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct notes *notes = context;
    for (int k = 0; k < notes->n; k++) {
        if (outcome->force.most) {
            notes->most[i][k] = outcome->force.most[k];
            notes->most_time[i][k] = outcome->force.most_time[k];
            notes->least[i][k] = outcome->force.least[k];
            notes->least_time[i][k] = outcome->force.least_time[k];
        }
        if (outcome->sign_change) notes->change[i][k] = outcome->sign_change[k];
    }
    notes->drift[i] = outcome->energy_drift;
    notes->lyapunov[i] = outcome->lyapunov;
    return 0;
}

static void notes_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    struct notes *notes = context;
    (void)theta;
    for (int row = 0; row < count; row++) {
        for (int k = 0; k < notes->n; k++) {
            notes->phi[i][first + row][k] = phi[row * notes->n + k];
            notes->rate[i][first + row][k] = rate[row * notes->n + k];
            notes->force[i][first + row][k] = force[row * notes->n + k];
        }
    }
    notes->rows[i] += count;
}

/* angles, rates and forces of member i at `count` equidistant instants of the duration, the first
 * at 0; in stored order of a tree whose stored order is the caller's */
static int notes_samples(struct crowd *crowd, long i, double duration, int count, double phi[],
                         double rate[], double force[]) {
    double start[4][ARMS_MAX], *t = malloc((size_t)count * sizeof(double));
    struct pend_member member = {.phi = start[0],
                                 .rate = start[1],
                                 .length = start[2],
                                 .mass = start[3],
                                 .loads.gravity = 9.81};
    memcpy(start[2], crowd->tree->len, (size_t)crowd->tree->n * sizeof(double));
    memcpy(start[3], crowd->tree->mass, (size_t)crowd->tree->n * sizeof(double));
    crowd_fetch(crowd, i, &member);
    struct pend_problem problem = {.tree = crowd->tree,
                                   .loads = member.loads,
                                   .phi = start[0],
                                   .rate = start[1],
                                   .rtol = 1e-15};
    problem.times =
        (struct pend_times){.count = count, .start = 0, .span = duration, .divisor = count - 1};
    struct pend_samples samples = {.cap = count, .t = t, .phi = phi, .rate = rate, .force = force};
    OWN(pend_run, free) *run;
    int done = 0, fine = pend_run_new(&run, &pend_method_taylor, &problem, NULL) == PEND_OK;
    while (fine && !done) fine = pend_run_next(run, &samples, 1e12, &done, NULL) == PEND_OK;
    free(t);
    return CHECK(fine && samples.count == count);
}

/* a crowd of chains, whose stored order is the caller's */
static int notes_new(struct notes *notes, struct crowd *crowd, int n, double duration,
                     unsigned observe, struct pend_ensemble_problem *problem) {
    static const int parent[ARMS_MAX] = {-1, 0, 1, 2, 3, 4};
    static const double length[ARMS_MAX] = {1, 0.8, 0.7, 0.9, 0.5, 0.6},
                        mass[ARMS_MAX] = {1, 0.5, 0.7, 1.2, 0.4, 0.9};
    memset(crowd, 0, sizeof *crowd);
    memset(notes, 0, sizeof *notes);
    crowd->broken = -1;
    notes->crowd = crowd;
    notes->n = n;
    *problem = crowd_problem(crowd, duration);
    problem->observe = observe;
    problem->fetch = notes_fetch;
    problem->deliver = notes_deliver;
    problem->rows = notes_rows;
    problem->context = notes;
    int made = CHECK(pend_tree_new(&crowd->tree, n, length, mass, parent, NULL) == PEND_OK);
    problem->tree = crowd->tree;
    return made;
}

/* the vertex of the parabola through three equidistant samples: its value, and its position in
 * steps from the middle */
static double vertex(double a, double b, double c, double *at) {
    *at = 0.5 * (a - c) / (a - 2 * b + c);
    return b - 0.25 * (a - c) * *at;
}

TEST(ensemble_knows_the_true_extremes_of_the_forces) {
    static struct notes notes;
    double worst[2] = {0, 0}, duration = 4, step = duration / (FINE - 1);
    for (int n = 1; n <= ARMS_MAX; n += n < 2 ? 1 : 4) {
        struct crowd crowd;
        struct pend_ensemble_problem problem;
        double *samples[3];
        REQUIRE(notes_new(&notes, &crowd, n, duration, PEND_OBSERVE_EXTREMES, &problem));
        REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
        for (int a = 0; a < 3; a++) samples[a] = malloc(sizeof(double) * FINE * (size_t)n);
        for (long i = 0; i < MEMBERS; i += 5) {
            if (!notes_samples(&crowd, i, duration, FINE, samples[0], samples[1], samples[2]))
                break;
            for (int k = 0; k < n; k++) {
                const double *force = samples[2] + k;
                for (int sign = -1; sign <= 1; sign += 2) {
                    int best = 0;
                    for (int j = 0; j < FINE; j++)
                        if (force[j * n] * sign > force[best * n] * sign) best = j;
                    double at = 0, value = force[best * n], size = fabs(force[0]) + 10;
                    if (best > 0 && best < FINE - 1)
                        value = vertex(force[(best - 1) * n], force[best * n],
                                       force[(best + 1) * n], &at);
                    double got = sign > 0 ? notes.most[i][k] : notes.least[i][k];
                    double time = sign > 0 ? notes.most_time[i][k] : notes.least_time[i][k];
                    CHECK((got - force[best * n]) * sign >= -1e-10 * size);
                    // a single arm repeats its extremes, and the forces of six arms change too fast
                    // for parabolas
                    if (n != 2) continue;
                    worst[0] = fmax(worst[0], fabs(got - value) / size);
                    worst[1] = fmax(worst[1], fabs(time - (best + at) * step));
                }
            }
        }
        for (int a = 0; a < 3; a++) free(samples[a]);
        pend_tree_free(&crowd.tree);
    }
    CHECK_RESIDUAL(worst[0], 1e-7, "extreme of a force against the parabola through fine samples");
    CHECK_RESIDUAL(worst[1], 1e-5, "its time, s");
}

TEST(ensemble_knows_when_a_rod_first_changes_from_push_to_pull) {
    static struct notes notes;
    struct crowd crowd;
    struct pend_ensemble_problem problem;
    double worst = 0, duration = 4, step = duration / (FINE - 1);
    int changed = 0, stayed = 0;
    REQUIRE(notes_new(&notes, &crowd, 2, duration, PEND_OBSERVE_SIGNS, &problem));
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
    double *samples[3];
    for (int a = 0; a < 3; a++) samples[a] = malloc(sizeof(double) * FINE * 2);
    for (long i = 0; i < MEMBERS; i++) {
        if (!notes_samples(&crowd, i, duration, FINE, samples[0], samples[1], samples[2])) break;
        for (int k = 0; k < 2; k++) {
            const double *force = samples[2] + k;
            int j = 1;
            while (j < FINE && (force[2 * j] > 0) == (force[0] > 0)) j++;
            if (!CHECK(isnan(notes.change[i][k]) == (j == FINE))) continue;
            if (j == FINE) {
                stayed++;
                continue;
            }
            changed++;
            double want = (j - force[2 * j] / (force[2 * j] - force[2 * j - 2])) * step;
            worst = fmax(worst, fabs(notes.change[i][k] - want));
        }
    }
    CHECK(changed > 10 && stayed > 3);
    CHECK_RESIDUAL(worst, 1e-5, "time of a change of sign against fine samples, s");
    for (int a = 0; a < 3; a++) free(samples[a]);
    pend_tree_free(&crowd.tree);
}

/* released from the horizontal, a rod's force starts at 0 and has a sign at once */
static int level_fetch(void *context, long i, struct pend_member *member) {
    (void)context, (void)i, (void)member;
    return 0;
}

TEST(ensemble_does_not_take_the_start_at_zero_for_a_change_of_sign) {
    static struct notes notes;
    struct crowd crowd;
    struct pend_ensemble_problem problem;
    for (int n = 1; n <= ARMS_MAX; n++) {
        REQUIRE(notes_new(&notes, &crowd, n, 1, PEND_OBSERVE_SIGNS, &problem));
        problem.fetch = level_fetch;
        REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 1));
        for (int k = 0; k < n; k++) CHECK(isnan(notes.change[0][k]) || notes.change[0][k] > 0.1);
        // a single arm is level again at half its period, 1.18 s: its force touches 0 and does not
        // change sign
        problem.duration = 3;
        REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 1));
        CHECK(n > 1 || isnan(notes.change[0][0]));
        pend_tree_free(&crowd.tree);
    }
}

TEST(ensemble_rows_are_those_of_single_runs) {
    static struct notes notes;
    double worst = 0;
    for (int n = 1; n <= ARMS_MAX; n++) {
        struct crowd crowd;
        struct pend_ensemble_problem problem;
        double duration = n % 2 ? 1.4 : -1.4, times[8], phi[8 * ARMS_MAX], rate[8 * ARMS_MAX],
               force[8 * ARMS_MAX];
        REQUIRE(notes_new(&notes, &crowd, n, duration, 0, &problem));
        for (int j = 0; j < 8; j++) times[j] = 0 + duration * j / 7;
        problem.times = times;
        problem.times_count = 8;
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            memset(notes.rows, 0, sizeof notes.rows);
            REQUIRE(crowd_run(&problem, (enum pend_isa)isa, 0, MEMBERS));
            for (long i = 0; i < MEMBERS; i += 3) {
                CHECK_INT(notes.rows[i], 8);
                if (!notes_samples(&crowd, i, duration, 8, phi, rate, force)) return;
                for (int j = 0; j < 8 * n; j++) {
                    double gap = fabs(notes.phi[i][j / n][j % n] - phi[j]) +
                                 fabs(notes.rate[i][j / n][j % n] - rate[j]) / 10 +
                                 fabs(notes.force[i][j / n][j % n] - force[j]) / 100;
                    if (!(gap <= worst)) worst = gap;
                }
            }
        }
        pend_tree_free(&crowd.tree);
    }
    CHECK_RESIDUAL(worst, 1e-10, "rows of a member against a single run");
}

TEST(ensemble_observes_the_same_bits_with_avx2_and_avx512_and_in_any_lane) {
    static struct notes notes[3];
    if (pend_isa_best() < PEND_ISA_AVX512) {
        test_skip("this processor has no AVX-512");
        return;
    }
    const unsigned all =
        PEND_OBSERVE_EXTREMES | PEND_OBSERVE_SIGNS | PEND_OBSERVE_ENERGY | PEND_OBSERVE_LYAPUNOV;
    static const double times[8] = {0, 0.1, 0.2, 0.9, 1.3, 1.4, 1.5, 2};
    for (int n = 2; n <= ARMS_MAX; n += 4) {
        for (int i = 0; i < 3; i++) {
            struct crowd crowd;
            struct pend_ensemble_problem problem;
            enum pend_isa isa = i == 1 ? PEND_ISA_AVX2 : PEND_ISA_AVX512;
            REQUIRE(notes_new(&notes[i], &crowd, n, 2, all, &problem));
            problem.bound = M_PI;
            problem.times = times;
            problem.times_count = 8;
            REQUIRE(crowd_run(&problem, isa, 0, i == 2 ? 7 : MEMBERS));
            if (i == 2) REQUIRE(crowd_run(&problem, isa, 7, MEMBERS - 7));
            pend_tree_free(&crowd.tree);
            notes[i].crowd = NULL;
        }
        CHECK(!memcmp(&notes[0], &notes[1], sizeof notes[0]) &&
              !memcmp(&notes[0], &notes[2], sizeof notes[0]));
        CHECK(notes[0].lyapunov[3] != 0 && notes[0].most[3][1] > notes[0].least[3][1]);
    }
}

TEST(ensemble_energy_hardly_drifts) {
    static struct notes notes;
    struct crowd crowd;
    struct pend_ensemble_problem problem;
    double worst = 0;
    REQUIRE(notes_new(&notes, &crowd, 3, 10, PEND_OBSERVE_ENERGY, &problem));
    crowd.vary = 1;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
    for (int i = 0; i < MEMBERS; i++) worst = fmax(worst, notes.drift[i]);
    CHECK_RESIDUAL(worst, 1e-13, "relative drift of the energy over 10 s");
    problem.rtol = 1e-4;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, MEMBERS));
    CHECK(notes.drift[0] > 1e-12);
    pend_tree_free(&crowd.tree);
}

/* an arm that stands upright leaves at the rate sqrt(g / l); one that hangs does not */
static int upright_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    member->phi[0] = i ? -M_PI / 2 : M_PI / 2;
    return 0;
}

TEST(ensemble_lyapunov_estimate_is_the_exponent_where_that_is_known) {
    static struct notes notes;
    struct crowd crowd;
    struct pend_ensemble_problem problem;
    double exponent[2];
    REQUIRE(notes_new(&notes, &crowd, 1, 4, PEND_OBSERVE_LYAPUNOV, &problem));
    problem.fetch = upright_fetch;
    for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
        // the difference of two durations does not contain the first direction's transient
        for (int j = 0; j < 2; j++) {
            problem.duration = 4 + 2 * j;
            REQUIRE(crowd_run(&problem, (enum pend_isa)isa, 0, 2));
            exponent[j] = notes.lyapunov[0] * problem.duration;
            CHECK(fabs(notes.lyapunov[1]) < 0.5);
        }
        CHECK(fabs((exponent[1] - exponent[0]) / 2 / sqrt(9.81) - 1) < 1e-12);
    }
    pend_tree_free(&crowd.tree);
}

/* the growth of a difference by the variational equation of a double pendulum, by the classical
 * Runge-Kutta method */
static void double_rate(const double y[4], double d[4]) {
    double s = sin(y[0] - y[1]), c = cos(y[0] - y[1]), g = 9.81;
    double p = -s * y[3] * y[3] - 2 * g * sin(y[0]), q = s * y[2] * y[2] - g * sin(y[1]),
           det = 2 - c * c;
    d[0] = y[2], d[1] = y[3], d[2] = (p - c * q) / det, d[3] = (2 * q - c * p) / det;
}

static int double_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    member->phi[0] = 2 + 0.1 * (double)i - M_PI / 2;
    member->phi[1] = 2.5 - M_PI / 2;
    return 0;
}

static void double_step(double y[4], double h) {
    double k[4][4], x[4];
    static const double part[4] = {0, 0.5, 0.5, 1},
                        weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int j = 0; j < 4; j++) {
        for (int a = 0; a < 4; a++) x[a] = y[a] + (j ? part[j] * h * k[j - 1][a] : 0);
        double_rate(x, k[j]);
    }
    for (int j = 0; j < 4; j++)
        for (int a = 0; a < 4; a++) y[a] += h * weight[j] * k[j][a];
}

TEST(ensemble_lyapunov_estimate_is_the_growth_of_a_small_difference) {
    static struct notes notes;
    struct crowd crowd;
    struct pend_ensemble_problem problem;
    double worst = 0, duration = 4, frequency = sqrt(9.81 / 2), one[2] = {1, 1};
    int parent[2] = {-1, 0};
    REQUIRE(notes_new(&notes, &crowd, 2, duration, PEND_OBSERVE_LYAPUNOV, &problem));
    pend_tree_free(&crowd.tree);
    REQUIRE(pend_tree_new(&crowd.tree, 2, one, one, parent, NULL) == PEND_OK);
    problem.tree = crowd.tree;
    problem.fetch = double_fetch;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 8));
    for (int i = 0; i < 8; i++) {
        // central differences of two neighbours, at a distance of 1e-6 on either side in the
        // ensemble's own direction
        double y[2][4], sum = 0, gap = 0;
        for (int k = 0; k < 2; k++) sum += pow(cos(k + 1), 2) + pow(sin(3 * k + 2), 2);
        for (int side = 0; side < 2; side++) {
            double eps = (side ? 1e-7 : -1e-7) / sqrt(sum);
            for (int k = 0; k < 2; k++) {
                y[side][k] = (k ? 2.5 : 2 + 0.1 * i) + eps * cos(k + 1);
                y[side][2 + k] = eps * frequency * sin(3 * k + 2);
            }
            for (int j = 0; j < 16000; j++) double_step(y[side], duration / 16000);
        }
        for (int a = 0; a < 4; a++) gap += pow((y[1][a] - y[0][a]) / (a < 2 ? 1 : frequency), 2);
        worst = fmax(worst, fabs(notes.lyapunov[i] - log(sqrt(gap) / 2e-7) / duration));
        CHECK(notes.lyapunov[i] > 0.05);
    }
    CHECK_RESIDUAL(worst, 1e-4, "exponent against central differences, 1/s");
    pend_tree_free(&crowd.tree);
}

TEST(ensemble_spares_only_members_that_never_cross) {
    for (int n = 1; n <= ARMS_MAX; n++) {
        struct crowd all, some;
        REQUIRE(crowd_tree(&all, n) && crowd_tree(&some, n));
        all.vary = some.vary = n % 2;
        struct pend_ensemble_problem a = crowd_problem(&all, 3), b = crowd_problem(&some, 3);
        a.bound = b.bound = M_PI;
        b.spare = 1;
        for (int until = PEND_UNTIL_TIME; until <= PEND_UNTIL_ALL; until++) {
            a.until = b.until = (enum pend_until)until;
            REQUIRE(crowd_run(&a, pend_isa_best(), 0, MEMBERS) &&
                    crowd_run(&b, pend_isa_best(), 0, MEMBERS));
            // bits of the times, NaN if there was none
            CHECK(!memcmp(all.first, some.first, sizeof all.first));
            CHECK(!memcmp(all.arm, some.arm, sizeof all.arm));
        }
        pend_tree_free(&all.tree);
        pend_tree_free(&some.tree);
    }
}

/* two arms straight up, and slightly to either side */
static int balance_fetch(void *context, long i, struct pend_member *member) {
    (void)context;
    double theta = i % 2 ? M_PI : -M_PI, aside = i / 2 == 0 ? 0 : i / 2 == 1 ? 0.3 : -0.3;
    member->phi[0] = theta - M_PI / 2;
    member->rate[0] = aside;
    return 0;
}

TEST(ensemble_does_not_count_the_start_on_the_bound_as_a_flip) {
    struct crowd crowd;
    REQUIRE(crowd_tree(&crowd, 1));
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 0.5);
    problem.bound = M_PI;
    problem.fetch = balance_fetch;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 6));
    for (int i = 0; i < 6; i++) CHECK_INT(crowd.crossings[i][0], 0);
    // half a second later it has fallen far, and has passed the top again after one turn
    problem.duration = 6;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 2, 4));
    for (int i = 2; i < 6; i++) CHECK(crowd.crossings[i][0] >= 1 && crowd.first[i][0] > 1);
    pend_tree_free(&crowd.tree);
}

TEST(ensemble_takes_trees_of_hundreds_of_arms) {
    enum { N = 200 };
    double length[N], mass[N];
    int parent[N];
    unsigned long long seed = 5;
    for (int k = 0; k < N; k++) {
        length[k] = 1.0 / N;
        mass[k] = 1.0 / N;
        parent[k] = k ? test_random_int(&seed, k) : -1;
    }
    struct crowd crowd = {.broken = -1};
    REQUIRE(pend_tree_new(&crowd.tree, N, length, mass, parent, NULL) == PEND_OK);
    struct pend_ensemble_problem problem = crowd_problem(&crowd, 0.1);
    struct notes notes = {.crowd = &crowd};
    problem.fetch = level_fetch;
    problem.deliver = notes_deliver;
    problem.context = &notes;
    problem.observe = PEND_OBSERVE_ENERGY;
    REQUIRE(crowd_run(&problem, pend_isa_best(), 0, 9));
    for (int i = 0; i < 9; i++)
        CHECK(notes.drift[i] >= 0 && notes.drift[i] < 1e-12 && notes.drift[i] == notes.drift[0]);
    pend_tree_free(&crowd.tree);
}
