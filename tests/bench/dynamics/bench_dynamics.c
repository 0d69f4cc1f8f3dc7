/* Accelerations and forces of given states against MuJoCo's smooth dynamics and against the paper's
 * dense form with LAPACK (OpenBLAS, one thread). The runs are interleaved; the smallest of many
 * times counts.
 * Leaves to others: correctness against exact answers (tests/laws), integration.
 * Invariant: the same trees every time; a peer's accelerations agree before it is timed; a peer
 * that is not installed is reported as skipped. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/dynamics/dynamics.h"
#include "core/dynamics/dynamics_careful.h"
#include "tests/harness/quad.h"

#if __has_include(<mujoco/mujoco.h>)
#include <mujoco/mujoco.h>
#define MUJOCO 1
#endif

#define GRAVITY 9.81
static const struct pend_loads loads = {.gravity = GRAVITY};

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void *must(void *memory) {
    if (memory) return memory;
    fprintf(stderr, "no memory\n");
    exit(1);
}

static void *room(size_t bytes) { return must(aligned_alloc(64, (bytes + 63) / 64 * 64)); }

static double random_number(unsigned long long *state) {
    unsigned long long x = (*state += 0x9e3779b97f4a7c15ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

/* a tree in a state, with the arrays of all forms, in stored order */
struct subject {
    int n;
    struct pend_tree *tree;
    double *phi, *rate, *acc, *force;                     /* n each */
    double *lane_phi, *lane_rate, *lane_acc, *lane_force; /* 8 n each */
    double *matrix;                                       /* n x n */
    void *work, *lane_work;
#ifdef MUJOCO
    mjModel *model;
    mjData *data;
#endif
};

typedef void dposv_fn(const char *, const int *, const int *, double *, const int *, double *,
                      const int *, int *);
typedef void threads_fn(int);

static dposv_fn *dposv;

/* a chain, or a tree in which the parent of each arm is a random earlier arm */
static void subject_init(struct subject *s, int n, int chain) {
    unsigned long long seed = 7;
    size_t bytes = (size_t)n * sizeof(double);
    double *length = room(bytes), *mass = room(bytes);
    int *parent = room((size_t)n * sizeof *parent);
    for (int i = 0; i < n; i++) {
        length[i] = pow(10, 0.6 * random_number(&seed) - 0.3);
        mass[i] = pow(10, 0.6 * random_number(&seed) - 0.3);
        parent[i] = i == 0 ? -1 : chain ? i - 1 : (int)(random_number(&seed) * i);
    }
    memset(s, 0, sizeof *s);
    s->n = n;
    if (pend_tree_new(&s->tree, n, length, mass, parent, NULL)) exit(1);
    s->phi = room(bytes), s->rate = room(bytes), s->acc = room(bytes), s->force = room(bytes);
    s->work = room(pend_dynamics_work_bytes(n));
    for (int k = 0; k < n; k++) {
        s->phi[k] = 6.28 * random_number(&seed);
        s->rate[k] = 6 * random_number(&seed) - 3;
        s->acc[k] = s->force[k] = 0;
    }
    free(length);
    free(mass);
    free(parent);
}

static void subject_lanes(struct subject *s) {
    size_t bytes = 8 * (size_t)s->n * sizeof(double);
    s->lane_phi = room(bytes), s->lane_rate = room(bytes), s->lane_acc = room(bytes),
    s->lane_force = room(bytes);
    s->lane_work = room(pend_dynamics_vec_bytes(s->n));
    for (int k = 0; k < s->n; k++)
        for (int i = 0; i < 8; i++) {
            s->lane_phi[8 * k + i] = s->phi[k] + 0.1 * i;
            s->lane_rate[8 * k + i] = s->rate[k] * (1 + 0.01 * i);
        }
}

/* each form evaluates its state, or states, once */

static void run_ours(struct subject *s) {
    pend_dynamics(s->tree, &loads, s->phi, s->rate, s->work, s->acc, s->force);
}

static void run_careful(struct subject *s) {
    pend_dynamics_careful(s->tree, &loads, s->phi, s->rate, s->work, s->acc, s->force);
}

static void run_lanes(struct subject *s) {
    pend_dynamics_vec(s->tree, &loads, s->lane_phi, s->lane_rate, s->lane_work, s->lane_acc,
                      s->lane_force);
}

/* equation (aaa) as printed; Re M and Im M are assembled from sub-tree masses: arm i is on the path
 * to arm j for j from i to end[i] */
static void run_dense(struct subject *s) {
    const struct pend_tree *t = s->tree;
    int n = s->n, one = 1, info;
    size_t stride = (size_t)n;
    memset(s->matrix, 0, stride * stride * sizeof *s->matrix);
    for (int k = 0; k < n; k++)
        s->acc[k] = -GRAVITY * cos(s->phi[k]) * t->len[k] * t->subtree_mass[k];
    for (int i = 0; i < n; i++) {
        s->matrix[(size_t)i * stride + (size_t)i] = t->len[i] * t->len[i] * t->subtree_mass[i];
        for (int j = i + 1; j < t->end[i]; j++) {
            double size = t->len[i] * t->len[j] * t->subtree_mass[j], angle = s->phi[j] - s->phi[i];
            double im = size * sin(angle);
            s->matrix[(size_t)i * stride + (size_t)j] = size * cos(angle);
            s->acc[i] += im * s->rate[j] * s->rate[j];
            s->acc[j] -= im * s->rate[i] * s->rate[i];
        }
    }
    // the lower triangle in C's row order is the upper one in Fortran's column order
    dposv("L", &n, &one, s->matrix, &n, s->acc, &n, &info);
}

static double gap(const struct subject *s, const double want[]) {
    double most = 0, worst = 0;
    for (int k = 0; k < s->n; k++) {
        most = fmax(most, fabs(want[k]));
        worst = fmax(worst, fabs(want[k] - s->acc[k]));
    }
    return worst / most;
}

static int begin_dense(struct subject *s) {
    double *want = room((size_t)s->n * sizeof *want);
    if (!dposv) {
        free(want);
        return 0;
    }
    s->matrix = room((size_t)s->n * (size_t)s->n * sizeof *s->matrix);
    run_ours(s);
    memcpy(want, s->acc, (size_t)s->n * sizeof *want);
    run_dense(s);
    if (!(gap(s, want) < 1e-9)) {
        fprintf(stderr, "broken: the dense form's accelerations differ by %g\n", gap(s, want));
        exit(1);
    }
    free(want);
    return 1;
}

#ifdef MUJOCO
/* functions of libmujoco, which is opened at run time, with the types of its header */
#define MUJOCO_CALLS(X)                                                                            \
    X(mj_defaultVFS)                                                                               \
    X(mj_makeEmptyFileVFS)                                                                         \
    X(mj_loadXML)                                                                                  \
    X(mj_makeData)                                                                                 \
    X(mj_fwdPosition) X(mj_fwdVelocity) X(mj_fwdAcceleration) X(mj_deleteData) X(mj_deleteModel)
static struct {
#define MUJOCO_MEMBER(name) __typeof__(&name) name;
    MUJOCO_CALLS(MUJOCO_MEMBER)
} mujoco;

static int mujoco_open(void) {
    void *library = dlopen("libmujoco.so", RTLD_NOW);
    int missing = !library;
#define MUJOCO_SYMBOL(name)                                                                        \
    mujoco.name = library ? (__typeof__(&name))dlsym(library, #name) : NULL;                       \
    missing |= !mujoco.name;
    MUJOCO_CALLS(MUJOCO_SYMBOL)
    return !missing;
}

/* smooth dynamics alone: no contacts, no constraints, no integration; MuJoCo returns no forces */
static void run_mujoco(struct subject *s) {
    mujoco.mj_fwdPosition(s->model, s->data);
    mujoco.mj_fwdVelocity(s->model, s->data);
    mujoco.mj_fwdAcceleration(s->model, s->data);
}

/* the tree as a MuJoCo model: a hinge at the base of every arm, a point at its tip */
static char *mujoco_text(const struct pend_tree *t, size_t *bytes) {
    char *text = must(malloc(400 * (size_t)t->n + 1000)), *at = text;
    int *open = must(malloc((size_t)t->n * sizeof *open)), depth = 0;
    at += sprintf(
        at,
        "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 %.17g 0\"><flag "
        "constraint=\"disable\" contact=\"disable\" equality=\"disable\" frictionloss=\"disable\" "
        "limit=\"disable\" passive=\"disable\" actuation=\"disable\"/></option><worldbody>\n",
        -GRAVITY);
    for (int k = 0; k < t->n; k++) {
        while (depth && open[depth - 1] != t->parent[k]) at += sprintf(at, "</body>"), depth--;
        at += sprintf(at,
                      "<body pos=\"%.17g 0 0\"><joint type=\"hinge\" axis=\"0 0 1\"/><inertial "
                      "pos=\"%.17g 0 0\" mass=\"%.17g\" diaginertia=\"1e-13 1e-13 1e-13\"/>\n",
                      k ? t->len[t->parent[k]] : 0.0, t->len[k], t->mass[k]);
        open[depth++] = k;
    }
    while (depth--) at += sprintf(at, "</body>");
    at += sprintf(at, "</worldbody></mujoco>\n");
    *bytes = (size_t)(at - text);
    free(open);
    return text;
}

static void mujoco_load(struct subject *s) {
    char error[500] = "";
    size_t bytes;
    char *text = mujoco_text(s->tree, &bytes);
    mjVFS *files = must(malloc(sizeof *files));
    mujoco.mj_defaultVFS(files);
    mujoco.mj_makeEmptyFileVFS(files, "tree.xml", (int)bytes);
    memcpy(files->filedata[0], text, bytes);
    s->model = mujoco.mj_loadXML("tree.xml", files, error, sizeof error);
    if (!s->model || s->model->nv != s->n) {
        fprintf(stderr, "broken: MuJoCo refuses the tree: %s\n", error);
        exit(1);
    }
    s->data = must(mujoco.mj_makeData(s->model));
    free(files->filedata[0]);
    free(files);
    free(text);
}

static int begin_mujoco(struct subject *s) {
    static int opened;
    const struct pend_tree *t = s->tree;
    if (!opened) opened = mujoco_open() ? 1 : -1;
    if (opened < 0) return 0;
    mujoco_load(s);
    for (int k = 0; k < s->n; k++) {
        s->data->qpos[k] = s->phi[k] - (k ? s->phi[t->parent[k]] : 0);
        s->data->qvel[k] = s->rate[k] - (k ? s->rate[t->parent[k]] : 0);
    }
    run_mujoco(s);
    double *want = room((size_t)s->n * sizeof *want);
    for (int k = 0; k < s->n; k++) want[k] = s->data->qacc_smooth[k] + (k ? want[t->parent[k]] : 0);
    run_ours(s);
    double miss = gap(s, want);
    free(want);
    if (miss < 1e-6) return 1;
    fprintf(stderr, "broken: MuJoCo's accelerations differ by %g\n", miss);
    exit(1);
}
#else
static void run_mujoco(struct subject *s) { (void)s; }
static int begin_mujoco(struct subject *s) {
    (void)s;
    return 0;
}
#endif

static void subject_clear(struct subject *s) {
    double *arrays[] = {s->phi,       s->rate,     s->acc,        s->force, s->lane_phi,
                        s->lane_rate, s->lane_acc, s->lane_force, s->matrix};
    pend_tree_free(&s->tree);
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) free(arrays[i]);
    free(s->work);
    free(s->lane_work);
#ifdef MUJOCO
    if (s->data) mujoco.mj_deleteData(s->data);
    if (s->model) mujoco.mj_deleteModel(s->model);
#endif
}

static int begin_nothing(struct subject *s) {
    (void)s;
    return 1;
}

typedef void run_fn(struct subject *);

/* a peer's begin function returns whether the peer is available */
static const struct line {
    const char *name;
    int n, chain;
    run_fn *ours, *peers;
    int states, peers_states; /* evaluated by one run */
    int (*begin)(struct subject *);
} lines[] = {
    {"random tree of 4, one state / the careful form", 4, 0, run_ours, run_careful, 1, 1,
     begin_nothing},
    {"random tree of 10, one state / MuJoCo", 10, 0, run_ours, run_mujoco, 1, 1, begin_mujoco},
    {"random tree of 64, one state / MuJoCo", 64, 0, run_ours, run_mujoco, 1, 1, begin_mujoco},
    {"random tree of 1024, one state / MuJoCo", 1024, 0, run_ours, run_mujoco, 1, 1, begin_mujoco},
    {"chain of 64, one state / MuJoCo", 64, 1, run_ours, run_mujoco, 1, 1, begin_mujoco},
    {"random tree of 64, one state / matrix form, LAPACK", 64, 0, run_ours, run_dense, 1, 1,
     begin_dense},
    {"random tree of 1024, one state / matrix form, LAPACK", 1024, 0, run_ours, run_dense, 1, 1,
     begin_dense},
    {"random tree of 64, one state / the careful form", 64, 0, run_ours, run_careful, 1, 1,
     begin_nothing},
    {"random tree of 64, 8 states in lanes / one at a time", 64, 0, run_lanes, run_ours, 8, 1,
     begin_nothing},
    {"chain of 64, 8 states in lanes / one at a time", 64, 1, run_lanes, run_ours, 8, 1,
     begin_nothing},
    {"chain of 1024, one state / the careful form", 1024, 1, run_ours, run_careful, 1, 1,
     begin_nothing},
    {"random tree of 1000000, one state / the careful form", 1000000, 0, run_ours, run_careful, 1,
     1, begin_nothing},
};

/* s, of `turns` runs */
static double once(run_fn *run, struct subject *s, long turns) {
    double begin = now();
    for (long i = 0; i < turns; i++) run(s);
    return (now() - begin) / (double)turns;
}

/* a pass takes about a tenth of a millisecond, so that some passes are likely to be undisturbed */
static long turns_for(run_fn *run, struct subject *s) {
    double time = once(run, s, 1);
    time = fmin(time, once(run, s, 1));
    return time > 1e-4 ? 1 : (long)(1e-4 / time) + 1;
}

/* largest trees whose exact accelerations and forces take less than a second */
enum { EXACT_ARMS = 256 };

/* Our errors relative to the largest component, compared with quadruple precision, or with the
 * careful form if that takes too long. */
static void errors(struct subject *s, const struct line *line, double *acc, double *force) {
    size_t n = (size_t)s->n;
    test_quad *exact_acc = must(malloc(n * sizeof *exact_acc)),
              *exact_force = must(malloc(n * sizeof *exact_force));
    if (s->n <= EXACT_ARMS) {
        test_quad_dynamics(s->tree, &loads, s->phi, s->rate, exact_acc, exact_force);
    } else {
        run_careful(s);
        for (size_t k = 0; k < n; k++) exact_acc[k] = s->acc[k], exact_force[k] = s->force[k];
    }
    line->ours(s);
    // the first lane contains the state itself
    for (size_t k = 0; k < n && line->ours == run_lanes; k++)
        s->acc[k] = s->lane_acc[8 * k], s->force[k] = s->lane_force[8 * k];
    *acc = test_quad_gap(s->n, s->acc, exact_acc);
    *force = test_quad_gap(s->n, s->force, exact_force);
    free(exact_acc);
    free(exact_force);
}

static void run_line(const struct line *line) {
    struct subject s;
    subject_init(&s, line->n, line->chain);
    if (line->ours == run_lanes) subject_lanes(&s);
    if (line->begin(&s)) {
        long turns = turns_for(line->ours, &s), peers_turns = turns_for(line->peers, &s);
        double ours = INFINITY, peers = INFINITY, begin = now();
        do {
            ours = fmin(ours, once(line->ours, &s, turns));
            peers = fmin(peers, once(line->peers, &s, peers_turns));
        } while (now() - begin < 2);
        ours *= 1e9 / ((double)line->n * line->states),
            peers *= 1e9 / ((double)line->n * line->peers_states);
        double acc, force;
        errors(&s, line, &acc, &force);
        printf("%-58s %10.2f %10.2f %8.1f  ns an arm and state   %.0e %.0e\n", line->name, ours,
               peers, peers / ours, acc, force);
    } else {
        printf("%-58s skipped: the peer is not installed\n", line->name);
    }
    subject_clear(&s);
}

/* usage: run [PART-OF-A-NAME ...] */
int main(int argc, char **argv) {
    void *blas = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_GLOBAL);
    threads_fn *threads = blas ? (threads_fn *)dlsym(blas, "openblas_set_num_threads") : NULL;
    if (threads) threads(1);
    if (blas) dposv = (dposv_fn *)dlsym(blas, "dposv_");
    printf("%-58s %10s %10s %8s  unit                  errors of our phi'', lambda\n", "", "ours",
           "peer's", "ratio");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        int wanted = argc < 2;
        for (int j = 1; j < argc; j++) wanted |= strstr(lines[i].name, argv[j]) != NULL;
        if (wanted) run_line(&lines[i]);
    }
}
