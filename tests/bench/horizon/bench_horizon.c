/* Reported horizons compared with the true ones: 504 random motions of every kind (chaotic,
 * regular, damped, stiff, stuck, driven, on a cart) with three methods; 200 chaotic ones, 500
 * members of ensembles, 50 sections, with the cost of the estimate; 2 to 6 arms.
 * Leaves to others: quick checks of the same (tests/core/integrate/run/test_horizon,
 * test_ensemble_horizon, test_section).
 * Invariant: the truth is the same motion in 32 digits, used only up to its own horizon; motions
 * that are accurate up to there or to their end are counted separately. The cost is the smallest of
 * several times, with and without the estimate, interleaved. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/integrate/events/section.h"
#include "core/integrate/run/run.h"
#include "tests/harness/ensembles.h"
#include "tests/harness/motions.h"

enum {
    ARMS_MAX = TEST_MOTION_ARMS,
    MOTIONS = 200,
    KIND = 72, /* motions of each kind */
    INSTANTS = 1001,
    TREES = 5,
    MEMBERS = 100,
    SECTIONS = 50,
    TURNS = 5,
    RATIOS = 600
};

static const double accuracy = 1e-6, gravity = 9.81, spacing = 0.05;

static unsigned long long seed = 2026;

static double draw(double from, double to) {
    unsigned long long z = seed += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return from + (to - from) * (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static void check(int good, const char *what) {
    if (good) return;
    fprintf(stderr, "bench_horizon: %s failed\n", what);
    exit(1);
}

static void *room(size_t numbers) {
    void *memory = calloc(numbers + 1, sizeof(double));
    check(memory != NULL, "memory");
    return memory;
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- the reported horizon, relative to the true one */

static struct tally {
    int parted, held, late;
    double ratio[RATIOS], plain, told; /* s of computation, without and with the estimate */
} tally;

static int tally_order(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* parted: the true horizon is `truth`; otherwise it may be later */
static void tally_add(double told, double truth, int parted) {
    tally.held += !parted;
    if (!parted || truth == 0) return;
    double ratio = told / truth;
    tally.late += ratio > 1.1;
    tally.ratio[tally.parted++] = ratio;
}

static void tally_print(const char *name) {
    int n = tally.parted;
    qsort(tally.ratio, (size_t)n, sizeof *tally.ratio, tally_order);
    printf("%-14s %4d parted, %4d held; told over true: least %.2f, 10 %% %.2f, median %.2f, 90 %% "
           "%.2f, most %.2f; late by over a tenth: %d; cost %+.0f %%\n",
           name, n, tally.held, tally.ratio[0], tally.ratio[n / 10], tally.ratio[n / 2],
           tally.ratio[n * 9 / 10], tally.ratio[n - 1], tally.late,
           100 * (tally.told / tally.plain - 1));
    memset(&tally, 0, sizeof tally);
}

/* ---- motions */

struct motion {
    struct pend_tree *tree;
    double phi[ARMS_MAX], rate[ARMS_MAX];
};

static struct pend_tree *draw_tree(int n) {
    double length[ARMS_MAX], mass[ARMS_MAX];
    int parent[ARMS_MAX];
    struct pend_tree *tree;
    for (int k = 0; k < n; k++) {
        length[k] = pow(10, draw(-0.3, 0.3));
        mass[k] = pow(10, draw(-0.3, 0.3));
        parent[k] = k ? (int)draw(0, k) : -1;
    }
    check(pend_tree_new(&tree, n, length, mass, parent, NULL) == PEND_OK, "a tree");
    return tree;
}

static void draw_start(struct motion *motion) {
    for (int k = 0; k < ARMS_MAX; k++) {
        motion->phi[k] = draw(-M_PI, M_PI);
        motion->rate[k] = draw(-1, 1);
    }
}

static struct motion draw_motion(int i) {
    struct motion motion = {.tree = draw_tree(2 + i % (ARMS_MAX - 1))};
    draw_start(&motion);
    return motion;
}

static struct pend_problem problem_of(const struct motion *motion, double duration) {
    long count = 1 + (long)ceil(duration / spacing);
    return (struct pend_problem){
        .tree = motion->tree,
        .loads.gravity = gravity,
        .phi = motion->phi,
        .rate = motion->rate,
        .times = {.count = count, .span = duration, .divisor = (double)(count - 1)}};
}

/* rows of angles, rates and forces in the caller's order */
struct rows {
    long count;
    double *t, *value[3], horizon;
};

static struct rows rows_new(long count) {
    struct rows rows = {.count = count, .t = room((size_t)count)};
    for (int i = 0; i < 3; i++) rows.value[i] = room((size_t)count * ARMS_MAX);
    return rows;
}

static void rows_free(struct rows *rows) {
    free(rows->t);
    for (int i = 0; i < 3; i++) free(rows->value[i]);
}

static double run(const struct pend_method *method, const struct pend_problem *problem,
                  struct rows *rows) {
    struct pend_samples samples = {.cap = rows->count,
                                   .t = rows->t,
                                   .phi = rows->value[0],
                                   .rate = rows->value[1],
                                   .force = rows->value[2]};
    struct pend_run *made;
    int done = 0;
    double begun = seconds();
    check(pend_run_new(&made, method, problem, NULL) == PEND_OK, "a run");
    check(pend_run_next(made, &samples, INFINITY, &done, NULL) == PEND_OK && done, "a run");
    rows->horizon = pend_run_stats(made).horizon;
    pend_run_free(&made);
    return seconds() - begun;
}

/* the last instant up to which rows, or their angles alone, agree with more exact ones; parted:
 * they disagree at a later instant within the horizon of the exact ones */
static double rows_truth(const struct rows *rows, const struct rows *exact, int n, int kinds,
                         int *parted) {
    double largest[3] = {1, 0, 0}, truth = 0;
    *parted = 0;
    for (long i = 0; i < rows->count && rows->t[i] <= exact->horizon; i++) {
        for (int kind = 1; kind < kinds; kind++)
            for (long k = i * n; k < (i + 1) * n; k++)
                largest[kind] = fmax(largest[kind], fabs(exact->value[kind][k]));
        for (int kind = 0; kind < kinds; kind++)
            for (long k = i * n; k < (i + 1) * n; k++)
                *parted |= !(fabs(rows->value[kind][k] - exact->value[kind][k]) <=
                             accuracy * largest[kind]);
        if (*parted) return truth;
        truth = rows->t[i];
    }
    return truth;
}

static void study_motions(const char *name, double rtol) {
    const struct pend_method *method = pend_method_find(name);
    for (int i = 0; i < MOTIONS; i++) {
        struct motion motion = draw_motion(i);
        struct pend_problem problem = problem_of(&motion, draw(5, 100));
        struct rows rows = rows_new(problem.times.count), exact = rows_new(problem.times.count);
        double least[2] = {INFINITY, INFINITY};
        problem.accuracy = accuracy;
        (void)run(pend_method_taylor.extended, &problem, &exact);
        problem.rtol = rtol;
        for (int turn = 0; turn < 2 * TURNS; turn++) {
            problem.accuracy = turn % 2 ? accuracy : 0;
            least[turn % 2] = fmin(least[turn % 2], run(method, &problem, &rows));
        }
        tally.plain += least[0];
        tally.told += least[1];
        int parted;
        double truth = rows_truth(&rows, &exact, motion.tree->n, 3, &parted);
        tally_add(rows.horizon, truth, parted);
        rows_free(&rows);
        rows_free(&exact);
        pend_tree_free(&motion.tree);
    }
    char title[40];
    snprintf(title, sizeof title, rtol > 0 ? "%s %.0e" : "%s", name, rtol);
    tally_print(title);
}

/* ---- members of ensembles */

struct members {
    struct motion start[MEMBERS];
    struct rows rows[MEMBERS];
    double horizon[MEMBERS];
    int n;
};

static int members_fetch(void *context, long i, struct pend_member *member) {
    const struct members *members = context;
    memcpy(member->phi, members->start[i].phi, (size_t)members->n * sizeof(double));
    memcpy(member->rate, members->start[i].rate, (size_t)members->n * sizeof(double));
    return 0;
}

static int members_deliver(void *context, long i, const struct pend_outcome *outcome) {
    ((struct members *)context)->horizon[i] = outcome->horizon;
    return 0;
}

static void members_rows(void *context, long i, long first, int count, const double phi[],
                         const double rate[], const double force[], const double theta[]) {
    (void)theta;
    const struct members *members = context;
    const int *order = members->start[i].tree->order;
    const double *from[3] = {phi, rate, force};
    for (int row = 0; row < count; row++)
        for (int kind = 0; kind < 3; kind++)
            for (int k = 0; k < members->n; k++)
                members->rows[i].value[kind][(first + row) * members->n + order[k]] =
                    from[kind][row * members->n + k];
}

static double members_run(const struct pend_ensemble_problem *problem) {
    struct pend_ensemble *ensemble;
    double begun = seconds();
    check(pend_ensemble_new(&ensemble, problem, pend_isa_best(), NULL) == PEND_OK, "an ensemble");
    check(test_ensemble_run(ensemble, 0, MEMBERS) == PEND_OK, "an ensemble");
    pend_ensemble_free(&ensemble);
    return seconds() - begun;
}

static void members_judge(struct members *members, double duration) {
    for (int i = 0; i < MEMBERS; i++) {
        struct pend_problem problem = problem_of(&members->start[i], duration);
        struct rows exact = rows_new(problem.times.count);
        int parted;
        problem.accuracy = accuracy;
        (void)run(pend_method_taylor.extended, &problem, &exact);
        memcpy(members->rows[i].t, exact.t, (size_t)exact.count * sizeof(double));
        double truth = rows_truth(&members->rows[i], &exact, members->n, 3, &parted);
        tally_add(members->horizon[i], truth, parted);
        rows_free(&exact);
        rows_free(&members->rows[i]);
    }
}

static void study_members(void) {
    static struct members members;
    for (int i = 0; i < TREES; i++) {
        struct pend_tree *tree = draw_tree(2 + i);
        double duration = draw(8, 20), least[2] = {INFINITY, INFINITY};
        members.n = tree->n;
        for (int j = 0; j < MEMBERS; j++) {
            members.start[j].tree = tree;
            draw_start(&members.start[j]);
        }
        struct pend_problem alone = problem_of(&members.start[0], duration);
        struct pend_ensemble_problem problem = {.tree = tree,
                                                .loads.gravity = gravity,
                                                .duration = duration,
                                                .rtol = 1e-12,
                                                .fetch = members_fetch,
                                                .deliver = members_deliver,
                                                .rows = members_rows,
                                                .context = &members};
        for (int turn = 0; turn < 2 * TURNS; turn++) {
            problem.accuracy = turn % 2 ? accuracy : 0;
            least[turn % 2] = fmin(least[turn % 2], members_run(&problem));
        }
        tally.plain += least[0];
        tally.told += least[1];
        double *times = room((size_t)alone.times.count);
        pend_times_list(&alone.times, 0, (int)alone.times.count, times);
        for (int j = 0; j < MEMBERS; j++) members.rows[j] = rows_new(alone.times.count);
        problem.times = times;
        problem.times_count = alone.times.count;
        (void)members_run(&problem);
        members_judge(&members, duration);
        free(times);
        pend_tree_free(&tree);
    }
    tally_print("members");
}

/* ---- sections */

static double section_run(const struct pend_section_problem *problem, struct rows *rows) {
    enum pend_found found = PEND_FOUND_NOTHING;
    struct pend_passage passage;
    struct pend_section *section;
    const int *order = problem->tree->order;
    int n = problem->tree->n;
    double phi[ARMS_MAX], rate[ARMS_MAX], begun = seconds();
    check(pend_section_new(&section, problem, NULL) == PEND_OK, "a section");
    for (long i = 1; found != PEND_FOUND_END && i < rows->count; i += found == PEND_FOUND_PASSAGE) {
        check(pend_section_next(section, 1000, &found, &passage, phi, rate, NULL) == PEND_OK,
              "a section");
        if (found != PEND_FOUND_PASSAGE) continue;
        rows->t[i] = passage.time;
        for (int k = 0; k < n; k++) rows->value[0][i * n + order[k]] = phi[k];
        rows->horizon = (double)(i + 1);
    }
    double took = seconds() - begun;
    rows->count = (long)rows->horizon;
    rows->horizon = pend_section_held(section);
    pend_section_free(&section);
    return took;
}

static void study_sections(void) {
    enum { MOST = 4000 };
    for (int i = 0; i < SECTIONS; i++) {
        struct motion motion = draw_motion(i);
        struct rows rows = {.count = 0}, exact;
        double least[2] = {INFINITY, INFINITY};
        struct pend_section_problem problem = {.tree = motion.tree,
                                               .loads.gravity = gravity,
                                               .phi = motion.phi,
                                               .rate = motion.rate,
                                               .duration = draw(10, 60),
                                               .angle = -M_PI_2,
                                               .ways = PEND_WAY_UP | PEND_WAY_DOWN};
        for (int turn = 0; turn < 2 * TURNS; turn++) {
            if (turn) rows_free(&rows);
            rows = rows_new(MOST);
            rows.horizon = 1;
            problem.accuracy = turn % 2 ? accuracy : 0;
            least[turn % 2] = fmin(least[turn % 2], section_run(&problem, &rows));
        }
        tally.plain += least[0];
        tally.told += least[1];
        // the start is row 0
        for (int k = 0; k < motion.tree->n; k++)
            rows.value[0][motion.tree->order[k]] = motion.phi[k];
        struct pend_problem alone = problem_of(&motion, 1);
        alone.times = (struct pend_times){.count = rows.count, .list = rows.t};
        alone.accuracy = accuracy;
        exact = rows_new(rows.count);
        (void)run(pend_method_taylor.extended, &alone, &exact);
        int parted;
        double truth = rows_truth(&rows, &exact, motion.tree->n, 1, &parted), told = 0;
        // the horizon is rounded down to a passage, as the truth is
        for (long row = 0; row < rows.count && rows.t[row] <= rows.horizon; row++)
            told = rows.t[row];
        tally_add(told, truth, parted);
        rows_free(&rows);
        rows_free(&exact);
        pend_tree_free(&motion.tree);
    }
    tally_print("sections");
}

/* ---- motions of every kind */

/* prints the quantiles of the reported horizons, relative to the true ones */
static void kinds_print(const char *name, double ratio[], int n) {
    int low = 0, high = 0;
    qsort(ratio, (size_t)n, sizeof *ratio, tally_order);
    if (!n) return;
    for (int i = 0; i < n; i++) low += ratio[i]<0.5, high += ratio[i]> 1.1;
    printf("%-8s %3d: told over true: 1 %% %.3f, 10 %% %.3f, median %.3f, 90 %% %.3f, 99 %% %.3f; "
           "below half %d, above 1.1 %d\n",
           name, n, ratio[n / 100], ratio[n / 10], ratio[n / 2], ratio[n * 9 / 10],
           ratio[n - 1 - n / 100], low, high);
}

static struct pend_problem problem_of_kind(const struct test_motion *motion) {
    return (struct pend_problem){
        .tree = motion->tree,
        .loads = test_motion_loads(motion),
        .phi = motion->phi,
        .rate = motion->rate,
        .times = {.count = INSTANTS, .span = motion->span, .divisor = INSTANTS - 1}};
}

struct kind_member {
    const struct test_motion *motion;
    struct rows *rows;
};

static int kind_fetch(void *context, long i, struct pend_member *member) {
    const struct kind_member *of = context;
    (void)i;
    size_t n = (size_t)of->motion->tree->n;
    memcpy(member->phi, of->motion->phi, n * sizeof(double));
    memcpy(member->rate, of->motion->rate, n * sizeof(double));
    return 0;
}

static int kind_deliver(void *context, long i, const struct pend_outcome *outcome) {
    (void)i;
    ((struct kind_member *)context)->rows->horizon = outcome->horizon;
    return 0;
}

static void kind_rows(void *context, long i, long first, int count, const double phi[],
                      const double rate[], const double force[], const double theta[]) {
    (void)theta, (void)i;
    const struct kind_member *of = context;
    const int *order = of->motion->tree->order, n = of->motion->tree->n;
    int arms = test_motion_arms(of->motion), cart = n - arms;
    const double *from[3] = {phi, rate, force};
    for (int row = 0; row < count; row++)
        for (int kind = 0; kind < 3; kind++)
            for (int k = cart; k < n; k++)
                of->rows->value[kind][(first + row) * arms + order[k] - cart] =
                    from[kind][row * n + k];
}

/* as the only member of an ensemble */
static void kind_ensemble(const struct test_motion *motion, const struct pend_problem *alone,
                          struct rows *rows) {
    struct kind_member of = {motion, rows};
    struct pend_ensemble *ensemble;
    pend_times_list(&alone->times, 0, INSTANTS, rows->t);
    struct pend_ensemble_problem problem = {.tree = motion->tree,
                                            .loads = alone->loads,
                                            .duration = motion->span,
                                            .rtol = 1e-12,
                                            .accuracy = accuracy,
                                            .fetch = kind_fetch,
                                            .deliver = kind_deliver,
                                            .rows = kind_rows,
                                            .times = rows->t,
                                            .times_count = INSTANTS,
                                            .context = &of};
    check(pend_ensemble_new(&ensemble, &problem, pend_isa_best(), NULL) == PEND_OK, "an ensemble");
    check(test_ensemble_run(ensemble, 0, 1) == PEND_OK, "an ensemble");
    pend_ensemble_free(&ensemble);
}

/* method: NULL = a member of an ensemble; returns the reported horizon relative to the true one, 0
 * if the true one is the start */
static double kind_ratio(const char *method, enum test_motion_kind kind, int i) {
    struct test_motion motion;
    int parted;
    test_motion_init(&motion, kind, i);
    struct pend_problem problem = problem_of_kind(&motion);
    struct rows rows = rows_new(INSTANTS), exact = rows_new(INSTANTS);
    problem.accuracy = accuracy;
    if (method)
        (void)run(pend_method_find(method), &problem, &rows);
    else
        kind_ensemble(&motion, &problem, &rows);
    problem.accuracy = 0;
    (void)run(pend_method_taylor.extended, &problem, &exact);
    exact.horizon = INFINITY; // doubles part from the truth long before 32 digits do
    double truth = rows_truth(&rows, &exact, test_motion_arms(&motion), 3, &parted),
           ratio = truth > 0 ? rows.horizon / truth : 0;
    if (truth > 0 && (ratio < 0.6 || ratio > 1.05))
        printf("  %s %d: %d arms, %g told, %g true, of %g s\n", test_motion_name(kind), i,
               motion.tree->n, rows.horizon, truth, motion.span);
    rows_free(&rows);
    rows_free(&exact);
    test_motion_clear(&motion);
    return ratio;
}

static void study_kinds(const char *method) {
    static double all[KIND * TEST_MOTION_KINDS], ratio[KIND];
    int total = 0;
    printf("%s, motions of every kind:\n", method ? method : "ensembles");
    for (int kind = 0; kind < TEST_MOTION_KINDS; kind++) {
        int count = 0;
        for (int i = 0; i < KIND; i++) {
            double x = kind_ratio(method, (enum test_motion_kind)kind, i);
            if (x > 0) all[total++] = ratio[count++] = x;
        }
        kinds_print(test_motion_name((enum test_motion_kind)kind), ratio, count);
    }
    kinds_print("all", all, total);
}

int main(int count, char **words) {
    setvbuf(stdout, NULL, _IOLBF, 0);
    static const char *const methods[] = {"taylor", "rk8pd", NULL};
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) study_kinds(methods[i]);
    if (count > 1 && !strcmp(words[1], "kinds")) return 0;
    study_motions("taylor", 0);
    study_motions("taylor", 1e-9);
    study_motions("rk8pd", 0);
    study_members();
    study_sections();
    return 0;
}
