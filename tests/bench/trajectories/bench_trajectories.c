/* Single trajectories at equal accuracy: ours against GSL, SUNDIALS, MuJoCo and the paper's code in
 * GNU Octave.
 * Leaves to others: the peers (peers).
 * Invariant: a peer that is not installed is reported as skipped; each solver is timed at a
 * tolerance with which its error, compared with 32 digits, is small enough; the runs are
 * interleaved, so that a slow spell affects all equally, and the smallest time counts. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/integrate/methods/method.h"
#include "core/integrate/run/run.h"
#include "tests/bench/trajectories/peers.h"
#include "tests/harness/ensembles.h"

extern const struct pend_method pend_method_taylor_extended;

/* ---- problems */

struct start {
    double length[PROBLEM_ARMS_MAX], mass[PROBLEM_ARMS_MAX], theta[PROBLEM_ARMS_MAX],
        rate[PROBLEM_ARMS_MAX];
    int parent[PROBLEM_ARMS_MAX];
};

static void broken(const char *what) {
    fprintf(stderr, "broken: %s\n", what);
    exit(1);
}

static void finish(struct problem *problem, int n, const struct start *start) {
    problem->loads.gravity = 9.81;
    if (pend_tree_new(&problem->tree, n, start->length, start->mass, start->parent, NULL) !=
        PEND_OK)
        broken("tree");
    for (int k = 0; k < n; k++) {
        problem->phi[k] = start->theta[problem->tree->order[k]] - M_PI_2;
        problem->rate[k] = start->rate[problem->tree->order[k]];
    }
}

static void make_paper(struct problem *problem) {
    struct start start = {
        .length = {2, 1.5, 0.75, 1.25}, .mass = {1, 1, 1, 0.1}, .parent = {-1, 0, 1, 1}};
    for (int k = 0; k < 4; k++) start.theta[k] = M_PI_2;
    finish(problem, 4, &start);
}

static void make_double(struct problem *problem) {
    struct start start = {.length = {1, 1}, .mass = {1, 1}, .theta = {2, 2.5}, .parent = {-1, 0}};
    finish(problem, 2, &start);
}

static void make_chain(struct problem *problem) {
    struct start start = {.rate = {0}};
    for (int k = 0; k < 32; k++) {
        start.length[k] = start.mass[k] = 1 / 32.0;
        start.theta[k] = M_PI_2;
        start.parent[k] = k - 1;
    }
    finish(problem, 32, &start);
}

static double uniform(unsigned long long *seed) {
    *seed = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*seed >> 11) * 0x1p-53;
}

/* the parent of each arm is a random earlier arm; lengths and masses 10^+-0.3, any angle, rates up
 * to 2 rad/s */
static void make_tree(struct problem *problem) {
    unsigned long long seed = 7;
    struct start start = {.rate = {0}};
    for (int k = 0; k < 200; k++) {
        start.parent[k] = k ? (int)(uniform(&seed) * k) : -1;
        start.length[k] = pow(10, 0.6 * uniform(&seed) - 0.3);
        start.mass[k] = pow(10, 0.6 * uniform(&seed) - 0.3);
        start.theta[k] = M_PI * (2 * uniform(&seed) - 1);
        start.rate[k] = 2 * (2 * uniform(&seed) - 1);
    }
    finish(problem, 200, &start);
}

/* rods whose joints have the damping and stiffness of the tables; 0 for none */
static void make_rods(struct problem *problem, int n, const int parent[], double damping,
                      double stiffness) {
    static const enum pend_term_row rows[] = {PEND_TERM_ROD, PEND_TERM_DAMPING,
                                              PEND_TERM_STIFFNESS};
    const double number[] = {1, damping, stiffness};
    unsigned char has[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0}, bare[8];
    struct pend_terms *terms;
    double length[8], mass[8] = {0};
    for (int i = 0; i < 3; i++) has[rows[i]] = number[i] > 0;
    for (int k = 0; k < n; k++) bare[k] = 1, length[k] = 1 - 0.05 * k;
    if (pend_tree_new_bare(&problem->tree, n, length, mass, bare, parent, NULL) != PEND_OK ||
        pend_terms_new(&terms, n, has, ones, 0, NULL, NULL) != PEND_OK)
        broken("rods");
    double *value = calloc((size_t)terms->count, sizeof *value);
    if (!value) broken("memory");
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < n && has[rows[i]]; k++)
            value[terms->row[rows[i]] + k] = number[i] * (1 - 0.1 * k);
    problem->loads = (struct pend_loads){9.81, terms, value};
    for (int k = 0; k < n; k++) problem->phi[k] = 2 + 0.5 * k - M_PI_2;
}

static void make_two_rods(struct problem *problem) { make_rods(problem, 2, (int[]){-1, 0}, 0, 0); }

static void make_six_rods(struct problem *problem) {
    make_rods(problem, 6, (int[]){-1, 0, 1, 1, 0, 4}, 0.05, 2);
}

static const struct {
    struct problem problem;
    void (*make)(struct problem *problem);
} cases[] = {
    {{.name = "paper's example", .count = 501, .stop = 5, .until = 5, .error = 1e-12}, make_paper},
    {{.name = "paper's example, to draw", .count = 501, .stop = 5, .until = 5, .error = 1e-6},
     make_paper},
    {{.name = "double pendulum", .count = 2001, .stop = 20, .until = 5, .error = 1e-12},
     make_double},
    {{.name = "double pendulum, to draw", .count = 2001, .stop = 20, .until = 5, .error = 1e-6},
     make_double},
    {{.name = "double pendulum in lanes",
      .count = 5,
      .stop = 20,
      .until = 5,
      .error = 1e-12,
      .members = 64},
     make_double},
    {{.name = "chain of 32", .count = 201, .stop = 2, .until = 1.5, .error = 1e-9}, make_chain},
    {{.name = "chain of 32, to draw", .count = 201, .stop = 2, .until = 1.5, .error = 1e-4},
     make_chain},
    {{.name = "two rods", .count = 2001, .stop = 20, .until = 5, .error = 1e-12}, make_two_rods},
    {{.name = "two rods, to draw", .count = 2001, .stop = 20, .until = 5, .error = 1e-6},
     make_two_rods},
    {{.name = "six damped rods on springs", .count = 501, .stop = 5, .until = 5, .error = 1e-11},
     make_six_rods},
    {{.name = "six of them, to draw", .count = 501, .stop = 5, .until = 5, .error = 1e-6},
     make_six_rods},
    {{.name = "random tree of 200", .count = 101, .stop = 1, .until = 1, .error = 1e-9}, make_tree},
    {{.name = "random tree of 200, to draw", .count = 101, .stop = 1, .until = 1, .error = 1e-6},
     make_tree},
};

/* ---- ours */

static int solve(const struct pend_method *method, const struct problem *problem, double tolerance,
                 double phi[]) {
    static double t[4096];
    struct pend_problem ask = {.tree = problem->tree,
                               .loads = problem->loads,
                               .phi = problem->phi,
                               .rate = problem->rate,
                               .rtol = tolerance};
    ask.times = (struct pend_times){
        .count = problem->count, .span = problem->stop, .divisor = problem->count - 1};
    struct pend_samples samples = {.cap = problem->count, .t = t, .phi = phi};
    struct pend_run *run;
    int done = 0;
    enum pend_status status = pend_run_new(&run, method, &ask, NULL);
    if (status != PEND_OK) return 1;
    while (status == PEND_OK && !done) status = pend_run_next(run, &samples, 1e12, &done, NULL);
    pend_run_free(&run);
    return status != PEND_OK;
}

static int ours(const struct problem *problem, double tolerance, double phi[]) {
    return solve(pend_method_find("taylor"), problem, tolerance, phi);
}

/* ---- ours, many members in lanes: all identical, so that one represents all */

struct crowd {
    const struct problem *problem;
    double *phi;
};

static int crowd_fetch(void *context, long i, struct pend_member *member) {
    const struct crowd *crowd = context;
    (void)i;
    memcpy(member->phi, crowd->problem->phi, (size_t)crowd->problem->tree->n * sizeof(double));
    memcpy(member->rate, crowd->problem->rate, (size_t)crowd->problem->tree->n * sizeof(double));
    return 0;
}

static int crowd_deliver(void *context, long i, const struct pend_outcome *outcome) {
    (void)context, (void)i;
    return outcome->status != PEND_OK;
}

static void crowd_rows(void *context, long i, long first, int count, const double phi[],
                       const double rate[], const double force[], const double theta[]) {
    struct crowd *crowd = context;
    size_t n = (size_t)crowd->problem->tree->n;
    (void)rate, (void)force, (void)theta;
    if (!i) memcpy(crowd->phi + (size_t)first * n, phi, (size_t)count * n * sizeof *phi);
}

static int lanes(const struct problem *problem, double tolerance, double phi[]) {
    double t[16];
    struct crowd crowd = {problem, phi};
    struct pend_ensemble *ensemble;
    for (int i = 0; i < problem->count; i++) t[i] = problem_time(problem, i);
    struct pend_ensemble_problem ask = {.tree = problem->tree,
                                        .loads = problem->loads,
                                        .duration = problem->stop,
                                        .rtol = fmax(tolerance, 1e-16),
                                        .times = t,
                                        .times_count = problem->count,
                                        .fetch = crowd_fetch,
                                        .deliver = crowd_deliver,
                                        .rows = crowd_rows,
                                        .context = &crowd};
    if (pend_ensemble_new(&ensemble, &ask, pend_isa_best(), NULL) != PEND_OK) return 1;
    enum pend_status status = test_ensemble_run(ensemble, 0, problem->members);
    pend_ensemble_free(&ensemble);
    return status != PEND_OK;
}

/* ---- the participants */

struct contestant {
    const char *name;
    problem_solver *solver;
    double tolerance, error, best; /* best: s, 0 = does not take part */
};

/* the largest error up to the instant that counts; ours are in the caller's order of arms, the
 * peers' as stored */
static double gap(const struct problem *problem, const double phi[], const double want[],
                  int callers) {
    double worst = 0;
    int n = problem->tree->n;
    for (int i = 0; i < problem->count && problem_time(problem, i) <= problem->until * (1 + 1e-12);
         i++) {
        for (int k = 0; k < n; k++) {
            int at = callers ? k : problem->tree->order[k];
            double error = fabs(phi[i * n + k] - want[i * n + at]);
            if (!(error <= worst)) worst = error;
        }
    }
    return worst;
}

/* s of this thread's processor time: other processes have little influence on it */
static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* the loosest tolerance, in steps of half a decade, that reaches the error */
static void tune(const struct problem *problem, struct contestant *who, double phi[],
                 const double want[]) {
    for (double tolerance = problem->error * 30; tolerance > 0.9e-16; tolerance /= sqrt(10)) {
        double begin = now();
        if (who->solver(problem, fmin(tolerance, 1e-3), phi)) return;
        who->best = now() - begin;
        who->tolerance = fmin(tolerance, 1e-3);
        who->error = gap(problem, phi, want, who->solver == ours);
        if (who->error <= problem->error) return;
        if (who->best > 10) break;
    }
    who->best = 0;
}

static void race(const struct problem *problem, struct contestant who[], int count, double phi[]) {
    enum { ROUNDS_MAX = 80 };
    double begin = now();
    for (int round = 0; round < ROUNDS_MAX && now() - begin < 3; round++) {
        for (int i = 0; i < count; i++) {
            // slow participants run only in the first passes
            if (!who[i].best || (who[i].best > 0.3 && round > 1)) continue;
            // short runs are repeated, so that the clock and the cold cache have no influence
            int times = who[i].best < 2e-3 ? 4 : 1;
            while (times--) {
                double start = now();
                if (who[i].solver(problem, who[i].tolerance, phi)) broken(who[i].name);
                who[i].best = fmin(who[i].best, now() - start);
            }
        }
    }
}

static void compare(const struct problem *problem) {
    struct contestant who[] = {{.name = "ours", .solver = problem->members ? lanes : ours},
                               {.name = "GSL rk8pd, matrix", .solver = peer_rk8pd_matrix},
                               {.name = "GSL msadams, matrix", .solver = peer_msadams_matrix},
                               {.name = "GSL rk8pd, our O(n)", .solver = peer_rk8pd},
                               {.name = "GSL msadams, our O(n)", .solver = peer_msadams},
                               {.name = "CVODE Adams, our O(n)", .solver = peer_cvode},
                               {.name = "ARKODE ERK 8, our O(n)", .solver = peer_arkode},
                               {.name = "MuJoCo RK4", .solver = peer_mujoco}};
    enum { COUNT = sizeof who / sizeof *who };
    size_t numbers = (size_t)problem->count * (size_t)problem->tree->n;
    double *phi = malloc(numbers * sizeof *phi), *want = malloc(numbers * sizeof *want);
    if (!phi || !want || solve(&pend_method_taylor_extended, problem, 1e-24, want))
        broken("reference");
    for (int i = 0; i < COUNT; i++) tune(problem, &who[i], phi, want);
    race(problem, who, COUNT, phi);
    if (problem->members) who->best /= problem->members;
    for (int i = 1; i < COUNT; i++) {
        // a form that does not apply to this pendulum, or a missing peer
        if (!who[i].tolerance) continue;
        printf("%-28s %9.3f %8.0e  %-24s", problem->name, who->best * 1e3, who->error, who[i].name);
        if (who[i].best)
            printf(" %10.3f %8.0e %8.1f\n", who[i].best * 1e3, who[i].error,
                   who[i].best / who->best);
        else
            printf(" %10s %8.0e\n", "-", who[i].error);
    }
    fflush(stdout);
    free(phi);
    free(want);
}

/* ---- the paper's code in GNU Octave, with its bracket corrected */

static const char octave_script[] =
    "L=[2;1.5;.75;1.25];m=[1;1;1;.1];S=[1 0 0 0;1 1 0 0;1 1 1 0;1 1 0 1];g=9.81;N=4;\n"
    "M=@(p) diag(exp(-1i*p).*L)*S'*diag(m)*S*diag(L.*exp(1i*p));\n"
    "function d=rhs(y,M,g,L,S,m,N) p=y(1:N);w=y(N+1:2*N);A=M(p);"
    "d=[w;real(A)\\(imag(A)*(w.^2)-g*cos(p).*L.*(S'*m))];end\n"
    "f=@(t,y) rhs(y,M,g,L,S,m,N);t=linspace(0,5,501);y0=zeros(8,1);\n"
    "[t1,y]=ode23(f,[0 .01],y0);c=cputime;[t1,y]=ode23(f,t,y0);printf('%g "
    "',cputime-c);printf('%.17g ',y(:,1:N)');\n";

static void octave(const struct problem *problem) {
    char path[] = "/tmp/bench-octave-XXXXXX", command[128];
    size_t numbers = (size_t)problem->count * (size_t)problem->tree->n;
    double *phi = malloc(numbers * sizeof *phi), *want = malloc(numbers * sizeof *want),
           seconds = 0, best = INFINITY;
    int file = mkstemp(path);
    FILE *script = file < 0 ? NULL : fdopen(file, "w");
    if (!script || !phi || !want) broken("octave's script");
    fputs(octave_script, script);
    fclose(script);
    snprintf(command, sizeof command, "octave-cli --norc --quiet %s 2>/dev/null", path);
    FILE *answer = popen(command, "r");
    int there = answer && fscanf(answer, "%lf", &seconds) == 1;
    for (size_t i = 0; i < numbers && there; i++) there = fscanf(answer, "%lf", &phi[i]) == 1;
    if (answer) pclose(answer);
    remove(path);
    if (there && !solve(&pend_method_taylor_extended, problem, 1e-24, want)) {
        double error = gap(problem, phi, want, 1), tolerance = 1e-1;
        double reached = INFINITY;
        for (; reached > error && tolerance > 1e-12; tolerance /= 10) {
            double *mine = malloc(numbers * sizeof *mine);
            for (int i = 0; i < 200 && mine; i++) {
                double start = now();
                if (ours(problem, tolerance, mine)) broken("ours");
                best = i ? fmin(best, now() - start) : now() - start;
            }
            if (!mine) broken("memory");
            reached = gap(problem, mine, want, 1);
            free(mine);
        }
        printf("%-28s %9.3f %8.0e  %-24s %10.3f %8.0e %8.1f\n", problem->name, best * 1e3, reached,
               "paper's ode23 in Octave", seconds * 1e3, error, seconds / best);
    }
    free(phi);
    free(want);
}

/* usage: run [PART-OF-A-NAME] */
int main(int argc, char **argv) {
    peers_open();
    if (!peer_sundials_there()) printf("SUNDIALS was not installed when this was built.\n");
    if (!peer_mujoco_there()) printf("MuJoCo is not installed.\n");
    printf("%-28s %9s %8s  %-24s %10s %8s %8s\n", "", "ours, ms", "error", "peer", "peer, ms",
           "error", "ratio");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct problem problem = cases[i].problem;
        if (argc > 1 && !strstr(problem.name, argv[1])) continue;
        cases[i].make(&problem);
        compare(&problem);
        if (i == 0) octave(&problem);
        struct pend_terms *terms = (struct pend_terms *)problem.loads.terms;
        free((double *)problem.loads.value);
        pend_terms_free(&terms);
        pend_tree_free(&problem.tree);
    }
}
