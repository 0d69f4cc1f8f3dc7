/* Work and precision: the true error of every method with tolerances, relative to the tolerance,
 * for seventeen motions, three of them of real pendulums.
 * Leaves to others: how fast methods are at equal accuracy (bench_trajectories).
 * Invariant: the truth is the same motion in 32 digits; errors after the horizon, when an initial
 * deviation has grown by a factor HORIZON_GROWTH, are not counted, because they depend on the
 * motion and not on the method. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/run/run.h"

enum {
    ARMS_MAX = 200,
    IDEAL = 14,
    SYSTEMS = 17,
    INSTANTS = 31,
    NEIGHBOURS = 3,
    TOLERANCES = 10,
    RATIOS = SYSTEMS * TOLERANCES
};

static const double HORIZON_GROWTH = 30;

struct bench_system {
    const char *name;
    struct pend_tree *tree;
    double *phi, *rate;
    struct pend_problem problem;
    double *truth;           /* INSTANTS rows of n angles, the caller's order */
    double growth[INSTANTS]; /* how far neighbours have parted, over how far they were, largest so
                                far */
};

static void broken(const char *what) {
    fprintf(stderr, "broken: %s\n", what);
    exit(1);
}

static void *room(size_t bytes) {
    void *block = calloc(1, bytes);
    if (!block) broken("memory");
    return block;
}

/* ---- motions */

static void system_init(struct bench_system *s, const char *name, int n, const double length[],
                        const double mass[], const int parent[], double stop) {
    *s = (struct bench_system){.name = name};
    if (pend_tree_new(&s->tree, n, length, mass, parent, NULL) != PEND_OK) broken(name);
    s->phi = room((size_t)n * sizeof(double));
    s->rate = room((size_t)n * sizeof(double));
    s->problem = (struct pend_problem){
        .tree = s->tree, .loads.gravity = 9.81, .phi = s->phi, .rate = s->rate};
    s->problem.times =
        (struct pend_times){.count = INSTANTS, .span = stop, .divisor = INSTANTS - 1};
}

/* uniform in [0, 1), the same on every machine */
static double uniform(unsigned long long *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

/* the parent of each arm is a random earlier arm; lengths and masses within a factor of 4 */
static void system_random(struct bench_system *s, const char *name, int n, double stop,
                          unsigned long long *seed) {
    double length[ARMS_MAX], mass[ARMS_MAX];
    int parent[ARMS_MAX];
    for (int k = 0; k < n; k++) {
        parent[k] = k ? (int)(k * uniform(seed)) : -1;
        length[k] = exp2(2 * uniform(seed) - 1);
        mass[k] = exp2(2 * uniform(seed) - 1);
    }
    system_init(s, name, n, length, mass, parent, stop);
    for (int k = 0; k < n; k++) {
        s->phi[k] = M_PI * (2 * uniform(seed) - 1);
        s->rate[k] = 3 * (2 * uniform(seed) - 1);
    }
}

/* gives a system the first `count` of these terms, the same number for all arms */
static void system_terms(struct bench_system *s, int count, const enum pend_term_row rows[],
                         const double number[]) {
    unsigned char has[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    struct pend_terms *terms;
    int n = s->tree->n;
    for (int i = 0; i < count; i++) has[rows[i]] = 1;
    if (pend_terms_new(&terms, n, has, ones, 0, NULL, NULL) != PEND_OK) broken(s->name);
    double *value = room((size_t)terms->count * sizeof *value);
    pend_terms_clear(terms, s->tree, value);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < n; k++) value[terms->row[rows[i]] + k] = number[i];
    s->problem.loads.terms = terms;
    s->problem.loads.value = value;
}

static void systems_real(struct bench_system system[3]) {
    static const enum pend_term_row rows[] = {
        PEND_TERM_ROD,      PEND_TERM_DAMPING, PEND_TERM_STIFFNESS,
        PEND_TERM_FRICTION, PEND_TERM_DRAG,    PEND_TERM_DRAG_QUADRATIC,
    };
    static const double number[] = {1, 0.05, 1, 0.05, 0.02, 0.02};
    static const int chain[] = {-1, 0}, tree[] = {-1, 0, 1, 1, 0, 4};
    double one[6] = {1, 1, 1, 1, 1, 1};
    system_init(&system[0], "two rods, 3 s", 2, one, one, chain, 3);
    system_init(&system[1], "six damped rods on springs, 3 s", 6, one, one, tree, 3);
    system_init(&system[2], "six rods in air with dry friction, 3 s", 6, one, one, tree, 3);
    for (int i = 0; i < 3; i++) {
        system_terms(&system[i], i == 2 ? 6 : 1 + 2 * i, rows, number);
        for (int k = 0; k < system[i].tree->n; k++) system[i].phi[k] = 0.5 + 0.5 * k;
    }
}

static void systems_init(struct bench_system system[SYSTEMS]) {
    static const double paper_length[] = {2, 1.5, 0.75, 1.25}, paper_mass[] = {1, 1, 1, 0.1};
    static const int paper_parent[] = {-1, 0, 1, 1};
    double one[32];
    int chain[32];
    unsigned long long seed = 15;
    for (int k = 0; k < 32; k++) one[k] = 1, chain[k] = k - 1;
    system_init(&system[0], "paper's example, 5 s", 4, paper_length, paper_mass, paper_parent, 5);
    system_init(&system[1], "double pendulum, 3 s", 2, one, one, chain, 3);
    system[1].phi[0] = 2 - M_PI_2, system[1].phi[1] = 2.5 - M_PI_2;
    system_init(&system[2], "chain of 32, 1.2 s", 32, one, one, chain, 1.2);
    system_random(&system[3], "tree of 200, 0.5 s", 200, 0.5, &seed);
    system_init(&system[4], "one arm, 10 s", 1, one, one, chain, 10);
    system[4].phi[0] = 2 - M_PI_2;
    for (int i = 5; i < IDEAL; i++)
        system_random(&system[i], "random tree, 3 s", 2 + (i - 5) % 7, 3, &seed);
    systems_real(system + IDEAL);
}

/* ---- runs */

/* INSTANTS rows of angles in the caller's order; non-zero on success */
static int run_all(const struct pend_method *method, const struct pend_problem *problem,
                   double phi[], struct pend_run_stats *stats, struct pend_error *error) {
    struct pend_run *run;
    double t[INSTANTS];
    struct pend_samples samples = {.cap = INSTANTS, .t = t, .phi = phi};
    int done = 0;
    if (pend_run_new(&run, method, problem, error) != PEND_OK) return 0;
    enum pend_status status = pend_run_next(run, &samples, INFINITY, &done, error);
    *stats = pend_run_stats(run);
    pend_run_free(&run);
    return status == PEND_OK && samples.count == INSTANTS;
}

static double row_gap(int n, const double a[], const double b[]) {
    double gap = 0;
    for (int k = 0; k < n; k++) gap = fmax(gap, fabs(a[k] - b[k]));
    return gap;
}

static void system_solve(struct bench_system *s) {
    const double apart = 1e-10;
    int n = s->tree->n;
    struct pend_run_stats stats;
    double *near = room((size_t)(INSTANTS * n) * sizeof(double));
    double *phi = room((size_t)n * sizeof(double)), *rate = room((size_t)n * sizeof(double));
    struct pend_problem problem = s->problem;
    unsigned long long seed = 4;
    s->truth = room((size_t)(INSTANTS * n) * sizeof(double));
    if (!run_all(pend_method_taylor.extended, &problem, s->truth, &stats, NULL)) broken(s->name);
    problem.phi = phi;
    problem.rate = rate;
    for (int i = 0; i < NEIGHBOURS; i++) {
        for (int k = 0; k < n; k++) {
            phi[k] = s->phi[k] + apart * (2 * uniform(&seed) - 1);
            rate[k] = s->rate[k] + apart * (2 * uniform(&seed) - 1);
        }
        if (!run_all(pend_method_taylor.extended, &problem, near, &stats, NULL)) broken(s->name);
        for (int j = 0; j < INSTANTS; j++)
            s->growth[j] = fmax(s->growth[j], row_gap(n, s->truth + j * n, near + j * n) / apart);
    }
    for (int j = 1; j < INSTANTS; j++) s->growth[j] = fmax(s->growth[j], s->growth[j - 1]);
    free(near), free(phi), free(rate);
}

/* ---- the table */

struct ratio {
    double over; /* the largest error before the horizon, over rtol */
    const char *name;
    double rtol;
    long evaluations;
};

static int ascending(const void *left, const void *right) {
    double a = ((const struct ratio *)left)->over, b = ((const struct ratio *)right)->over;
    return (a > b) - (a < b);
}

static struct ratio measure(const struct bench_system *s, const struct pend_method *method,
                            double rtol, double atol, int given) {
    int n = s->tree->n;
    double *phi = room((size_t)(INSTANTS * n) * sizeof(double));
    struct pend_problem problem = s->problem;
    struct pend_run_stats stats = {0};
    struct pend_error error;
    problem.rtol = rtol;
    problem.atol = atol;
    problem.atol_given = given;
    struct ratio ratio = {.over = NAN, .name = s->name, .rtol = rtol};
    if (run_all(method, &problem, phi, &stats, &error)) {
        double worst = 0;
        for (int j = 0; j < INSTANTS && s->growth[j] <= HORIZON_GROWTH; j++)
            worst = fmax(worst, row_gap(n, phi + j * n, s->truth + j * n));
        ratio.over = worst / rtol;
        ratio.evaluations = stats.evaluations;
    } else {
        ratio.over = INFINITY;
        printf("%s, %s, rtol %g, atol %g: %s\n", method->name, s->name, rtol, atol, error.text);
    }
    free(phi);
    return ratio;
}

static void print_line(const char *method, const char *atol, struct ratio ratio[], int count) {
    if (!count) return;
    long evaluations = 0;
    for (int i = 0; i < count; i++) evaluations += ratio[i].evaluations;
    qsort(ratio, (size_t)count, sizeof *ratio, ascending);
    const struct ratio *worst = &ratio[count - 1];
    printf("%-12s %-14s %9.2g %9.2g %9.2g   %s, rtol %.0e  (%ld evaluations)\n", method, atol,
           ratio[count / 2].over, ratio[count * 9 / 10].over, worst->over, worst->name, worst->rtol,
           evaluations);
    fflush(stdout);
}

int main(int argc, char **argv) {
    static struct bench_system system[SYSTEMS];
    static struct ratio ratio[RATIOS];
    static const char *const atols[] = {"0", "rtol", "default"};
    systems_init(system);
    for (int i = 0; i < SYSTEMS; i++) {
        system_solve(&system[i]);
        int j = INSTANTS - 1;
        while (system[i].growth[j] > HORIZON_GROWTH) j--;
        printf("%-38s %3d arms: growth %.3g, horizon %g s\n", system[i].name, system[i].tree->n,
               system[i].growth[INSTANTS - 1], pend_times_at(&system[i].problem.times, j));
    }
    printf("%-12s %-14s %9s %9s %9s   the largest\n", "error / rtol", "atol", "median", "90 %",
           "largest");
    for (int i = -1; i < 0 || pend_method_at(i); i++) {
        // i = -1: the method of the truth, in 32 digits, with looser tolerances
        const struct pend_method *method = i < 0 ? pend_method_taylor.extended : pend_method_at(i);
        const char *name = i < 0 ? "extended" : method->name;
        if (argc > 1 && !strstr(name, argv[1])) continue;
        if (!(method->flags & PEND_METHOD_TOLERANCES)) continue;
        for (int a = 0; a < 3; a++) {
            int count = 0;
            for (int j = 0; j < SYSTEMS; j++)
                for (int e = 4; e <= 13; e++) {
                    double rtol = pow(10, -e);
                    ratio[count++] = measure(&system[j], method, rtol, a == 1 ? rtol : 0, a < 2);
                }
            print_line(name, atols[a], ratio, count);
        }
    }
    return 0;
}
