/* Modes against LAPACK (OpenBLAS, one thread), ARPACK and GSL. The runs are interleaved; the
 * smallest of several times counts.
 * Leaves to others: correctness (tests/core/modes/test_modes*.c).
 * Invariant: the same trees every time; a peer that is not installed is reported as skipped. */
#include <dlfcn.h>
#include <gsl/gsl_eigen.h>
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "core/modes/modes.h"

#define GRAVITY 9.81

typedef void dsyevd_fn(const char *, const char *, const int *, double *, const int *, double *,
                       double *, const int *, int *, const int *, int *);
typedef void dsygvd_fn(const int *, const char *, const char *, const int *, double *, const int *,
                       double *, const int *, double *, double *, const int *, int *, const int *,
                       int *);
typedef void dstemr_fn(const char *, const char *, const int *, double *, double *, const double *,
                       const double *, const int *, const int *, int *, double *, double *,
                       const int *, const int *, int *, int *, double *, const int *, int *,
                       const int *, int *);
typedef void dsaupd_fn(int *, const char *, const int *, const char *, const int *, const double *,
                       double *, const int *, double *, const int *, int *, int *, double *,
                       double *, const int *, int *);
typedef void threads_fn(int);

static struct {
    dsyevd_fn *dsyevd;
    dsygvd_fn *dsygvd;
    dstemr_fn *dstemr;
    dsaupd_fn *dsaupd;
} peer;

/* a tree as arrays, parents first, and as the core's tree */
struct subject {
    int n;
    double *length, *mass;
    int *parent;
    struct pend_tree *tree;
    double *a, *b, *room, *omega; /* n x n, n x n, LAPACK's workspace */
    int *numbers;
};

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void *must(void *memory) {
    if (memory) return memory;
    fprintf(stderr, "no memory\n");
    exit(1);
}

static double random_number(unsigned long long *state) {
    unsigned long long x = (*state += 0x9e3779b97f4a7c15ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

enum { BINARY = 0, CHAIN = 1, STAR = -1 };
enum { RANDOM_ARMS, EQUAL_ARMS, NEARLY_EQUAL_ARMS };

static double subject_number(int alike, unsigned long long *seed) {
    if (alike == EQUAL_ARMS) return 1;
    double x = random_number(seed);
    return alike == RANDOM_ARMS ? pow(10, 0.6 * x - 0.3) : 1 + 1e-6 * x;
}

/* reach: how many arms before its child a parent may be; 1 makes a chain */
static void subject_init(struct subject *s, int n, int reach, int alike, int dense) {
    unsigned long long seed = 7;
    size_t square = (size_t)n * (size_t)n;
    s->n = n;
    s->length = must(malloc((size_t)n * sizeof *s->length));
    s->mass = must(malloc((size_t)n * sizeof *s->mass));
    s->parent = must(malloc((size_t)n * sizeof *s->parent));
    for (int i = 0; i < n; i++) {
        s->length[i] = subject_number(alike, &seed);
        s->mass[i] = subject_number(alike, &seed);
        if (i && reach > 0)
            s->parent[i] = i - 1 - (int)(random_number(&seed) * (i < reach ? i : reach));
        if (i && reach <= 0) s->parent[i] = reach == STAR ? 0 : (i - 1) / 2;
        if (!i) s->parent[i] = -1;
    }
    if (pend_tree_new(&s->tree, n, s->length, s->mass, s->parent, NULL)) exit(1);
    s->a = s->b = s->room = NULL;
    s->omega = must(malloc((size_t)n * sizeof *s->omega));
    s->numbers = must(malloc((3 + 10 * (size_t)n) * sizeof *s->numbers));
    if (!dense) return;
    s->a = must(malloc(square * sizeof *s->a));
    s->b = must(malloc(square * sizeof *s->b));
    s->room = must(malloc((1 + 18 * (size_t)n + 2 * square) * sizeof *s->room));
}

static void subject_clear(struct subject *s) {
    pend_tree_free(&s->tree);
    free(s->length);
    free(s->mass);
    free(s->parent);
    free(s->a);
    free(s->b);
    free(s->room);
    free(s->omega);
    free(s->numbers);
}

/* ours: all or part */
static double time_modes(const struct subject *s, struct pend_modes_request request) {
    struct pend_modes *modes;
    request.loads.gravity = GRAVITY;
    double begin = now();
    if (pend_modes_select(&modes, s->tree, &request, NULL)) exit(1);
    double time = now() - begin;
    pend_modes_free(&modes);
    return time;
}

/* M^-1/2 L M^-1/2 */
static void fill_scaled(const struct subject *s) {
    int n = s->n;
    const struct pend_tree *t = s->tree;
    memset(s->a, 0, (size_t)n * (size_t)n * sizeof *s->a);
    for (int k = 0; k < n; k++) {
        int p = t->parent[k];
        double spring = GRAVITY * t->subtree_mass[k] / t->len[k];
        s->a[(size_t)k * n + k] += spring / t->mass[k];
        if (p < 0) continue;
        s->a[(size_t)p * n + p] += spring / t->mass[p];
        s->a[(size_t)k * n + p] = s->a[(size_t)p * n + k] = -spring / sqrt(t->mass[k] * t->mass[p]);
    }
}

static double time_gsl(const struct subject *s) {
    size_t n = (size_t)s->n;
    double begin = now();
    fill_scaled(s);
    gsl_matrix_view matrix = gsl_matrix_view_array(s->a, n, n);
    gsl_matrix *vectors = gsl_matrix_alloc(n, n);
    gsl_vector *value = gsl_vector_alloc(n);
    gsl_eigen_symmv_workspace *work = gsl_eigen_symmv_alloc(n);
    if (gsl_eigen_symmv(&matrix.matrix, value, vectors, work)) exit(1);
    gsl_eigen_symmv_free(work);
    gsl_vector_free(value);
    gsl_matrix_free(vectors);
    return now() - begin;
}

static double time_dsyevd(const struct subject *s, int vectors) {
    int n = s->n, room = (int)(1 + 6 * n + 2 * n * n), numbers = 3 + 5 * n, info;
    fill_scaled(s);
    double begin = now();
    peer.dsyevd(vectors ? "V" : "N", "L", &n, s->a, &n, s->omega, s->room, &room, s->numbers,
                &numbers, &info);
    return now() - begin;
}

/* the paper's own pair: g diag(l S^T m) and Re(0) */
static double time_dsygvd(const struct subject *s) {
    int n = s->n, type = 1, room = 1 + 6 * n + 2 * n * n, numbers = 3 + 5 * n, info;
    const struct pend_tree *t = s->tree;
    memset(s->a, 0, (size_t)n * (size_t)n * sizeof *s->a);
    memset(s->b, 0, (size_t)n * (size_t)n * sizeof *s->b);
    for (int k = 0; k < n; k++) {
        s->a[(size_t)k * n + k] = GRAVITY * t->len[k] * t->subtree_mass[k];
        for (int j = k; j >= 0; j = t->parent[j])
            s->b[(size_t)k * n + j] = s->b[(size_t)j * n + k] =
                t->len[j] * t->len[k] * t->subtree_mass[k];
    }
    double begin = now();
    peer.dsygvd(&type, "V", "L", &n, s->a, &n, s->b, &n, s->omega, s->room, &room, s->numbers,
                &numbers, &info);
    return now() - begin;
}

/* a chain is tridiagonal */
static double time_dstemr(const struct subject *s) {
    int n = s->n, one = 1, found, rac = 1, room = 18 * n, numbers = 10 * n, info;
    const struct pend_tree *t = s->tree;
    double *diagonal = s->room + 18 * n, *beside = diagonal + n, zero = 0;
    int *support = must(malloc(2 * (size_t)n * sizeof *support));
    for (int k = 0; k < n; k++) {
        double spring = GRAVITY * t->subtree_mass[k] / t->len[k];
        double next = k + 1 < n ? GRAVITY * t->subtree_mass[k + 1] / t->len[k + 1] : 0;
        diagonal[k] = (spring + next) / t->mass[k];
        beside[k] = k + 1 < n ? -next / sqrt(t->mass[k] * t->mass[k + 1]) : 0;
    }
    double begin = now();
    peer.dstemr("V", "A", &n, diagonal, beside, &zero, &zero, &one, &n, &found, s->omega, s->a, &n,
                &n, support, &rac, s->room, &room, s->numbers, &numbers, &info);
    double time = now() - begin;
    free(support);
    return time;
}

/* x = M^1/2 L^-1 M^1/2 x by two sweeps over the tree */
static void solve_by_sweeps(const struct pend_tree *t, const double in[], double out[]) {
    for (int k = 0; k < t->n; k++) out[k] = sqrt(t->mass[k]) * in[k];
    for (int k = t->n - 1; k > 0; k--) out[t->parent[k]] += out[k];
    for (int k = 0; k < t->n; k++) {
        double stretch = out[k] * t->len[k] / (GRAVITY * t->subtree_mass[k]);
        out[k] = (k ? out[t->parent[k]] : 0) + stretch;
    }
    for (int k = 0; k < t->n; k++) out[k] *= sqrt(t->mass[k]);
}

/* ARPACK's Lanczos iteration for the k slowest modes, to 1e-12 */
static double time_arpack(const struct subject *s, int k) {
    int n = s->n, basis = 2 * k + 20, length = basis * (basis + 8), ido = 0, info = 0;
    int parameters[11] = {1, 0, 3000, 1, 0, 0, 1}, pointers[11];
    double tolerance = 1e-12, *residual = must(malloc((size_t)n * sizeof *residual));
    double *vectors = must(malloc((size_t)n * (size_t)basis * sizeof *vectors));
    double *work = must(malloc(3 * (size_t)n * sizeof *work)),
           *room = must(malloc((size_t)length * sizeof *room));
    double begin = now();
    do {
        peer.dsaupd(&ido, "I", &n, "LM", &k, &tolerance, residual, &basis, vectors, &n, parameters,
                    pointers, work, room, &length, &info);
        if (ido == 1 || ido == -1)
            solve_by_sweeps(s->tree, work + pointers[0] - 1, work + pointers[1] - 1);
    } while (ido == 1 || ido == -1);
    double time = now() - begin;
    free(residual);
    free(vectors);
    free(work);
    free(room);
    return time;
}

enum peer_kind { DSYEVD, DSYEVD_VALUES, DSYGVD, DSTEMR, GSL, ARPACK, ALONE };

/* one line of the table */
struct line {
    const char *name;
    int n, reach, alike;
    struct pend_modes_request request;
    enum peer_kind peer;
    int passes, ours; /* ours: number of our runs for each run of the peer */
};

static int peer_there(enum peer_kind kind) {
    switch (kind) {
    case DSYEVD:
    case DSYEVD_VALUES:
        return peer.dsyevd != NULL;
    case DSYGVD:
        return peer.dsygvd != NULL;
    case DSTEMR:
        return peer.dstemr != NULL;
    case ARPACK:
        return peer.dsaupd != NULL;
    default:
        return 1;
    }
}

static double time_peer(const struct line *line, const struct subject *s) {
    switch (line->peer) {
    case DSYEVD:
        return time_dsyevd(s, 1);
    case DSYEVD_VALUES:
        return time_dsyevd(s, 0);
    case DSYGVD:
        return time_dsygvd(s);
    case DSTEMR:
        return time_dstemr(s);
    case GSL:
        return time_gsl(s);
    case ARPACK:
        return time_arpack(s, line->request.count);
    default:
        return 0;
    }
}

/* tip displacements of a mode */
static void tips_of(const struct subject *s, const struct pend_modes *modes, int mode, double x[]) {
    const double *theta = modes->vector + (size_t)mode * (size_t)s->n;
    for (int k = 0; k < s->n; k++)
        x[k] = (k ? x[s->tree->parent[k]] : 0) + s->tree->len[k] * theta[k];
}

/* |(L - omega^2 M) x| in the norm of M^-1 */
static double residual_of(const struct subject *s, const struct pend_modes *modes, int mode,
                          const double x[]) {
    const double *theta = modes->vector + (size_t)mode * (size_t)s->n;
    double *force = must(malloc((size_t)s->n * sizeof *force)), sum = 0;
    for (int k = 0; k < s->n; k++)
        force[k] = -modes->omega[mode] * modes->omega[mode] * s->tree->mass[k] * x[k];
    for (int k = 0; k < s->n; k++) {
        double pull = GRAVITY * s->tree->subtree_mass[k] * theta[k];
        force[k] += pull;
        if (k) force[s->tree->parent[k]] -= pull;
    }
    for (int k = 0; k < s->n; k++) sum += force[k] * force[k] / s->tree->mass[k];
    free(force);
    return sqrt(sum);
}

/* our errors: inner products of neighbouring modes with the masses as weights, residuals relative
 * to the norm; or the error of the sum of 1/omega^2 */
static void print_accuracy(const struct line *line, const struct subject *s) {
    struct pend_modes_request request = line->request, last = {.loads.gravity = GRAVITY,
                                                               .select = PEND_SELECT_FASTEST,
                                                               .count = 1};
    struct pend_modes *modes, *fastest;
    double trace = 0, orthogonality = 0, residual = 0,
           *x = must(malloc(2 * (size_t)s->n * sizeof *x)), *y = x + s->n;
    request.loads.gravity = GRAVITY;
    if (pend_modes_select(&modes, s->tree, &request, NULL)) exit(1);
    if (pend_modes_select(&fastest, s->tree, &last, NULL)) exit(1);
    for (int i = modes->count - 1; i >= 0; i--)
        trace += GRAVITY / (modes->omega[i] * modes->omega[i]);
    for (int i = 0; modes->vector && i < modes->count; i++) {
        double dot = 0;
        tips_of(s, modes, i, i % 2 ? y : x);
        for (int k = 0; i && k < s->n; k++) dot += s->tree->mass[k] * x[k] * y[k];
        orthogonality = fmax(orthogonality, fabs(dot));
        residual = fmax(residual, residual_of(s, modes, i, i % 2 ? y : x));
    }
    if (modes->vector)
        printf("%60s neighbours' products %.1e, residuals %.1e\n", "", orthogonality,
               residual / (fastest->omega[0] * fastest->omega[0]));
    else
        printf("%60s sum of g/omega^2 over l_tot - 1: %.1e\n", "",
               fabs(trace / s->tree->length_total - 1));
    pend_modes_free(&modes);
    pend_modes_free(&fastest);
    free(x);
}

/* GB */
static double memory_so_far(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) ? NAN : (double)usage.ru_maxrss * 1024e-9;
}

static void run_line(const struct line *line) {
    struct subject s;
    double ours = INFINITY, theirs = INFINITY;
    if (!peer_there(line->peer)) {
        printf("%-58s skipped: the peer is not installed\n", line->name);
        return;
    }
    subject_init(&s, line->n, line->reach, line->alike,
                 line->peer != ALONE && line->peer != ARPACK);
    for (int pass = 0; pass < line->passes; pass++) {
        for (int i = 0; i < line->ours; i++) ours = fmin(ours, time_modes(&s, line->request));
        if (line->peer != ALONE) theirs = fmin(theirs, time_peer(line, &s));
    }
    if (line->peer == ALONE)
        printf("%-58s %10.3f %10s %8s  ms, largest memory so far %.2f GB\n", line->name, 1e3 * ours,
               "-", "-", memory_so_far());
    else
        printf("%-58s %10.3f %10.3f %8.1f  ms\n", line->name, 1e3 * ours, 1e3 * theirs,
               theirs / ours);
    print_accuracy(line, &s);
    fflush(stdout);
    subject_clear(&s);
}

#define ALL                                                                                        \
    { .vectors = 1 }
#define VALUES                                                                                     \
    { .vectors = 0 }
#define SLOWEST(k)                                                                                 \
    { .vectors = 1, .select = PEND_SELECT_SLOWEST, .count = k }

static const struct line lines[] = {
    {"random_100 all with vectors / dsyevd", 100, 100, 0, ALL, DSYEVD, 20, 5},
    {"random_100 all with vectors / GSL symmv", 100, 100, 0, ALL, GSL, 10, 5},
    {"random_1000 all with vectors / dsyevd", 1000, 1000, 0, ALL, DSYEVD, 6, 5},
    {"random_1000 all with vectors / dsygvd", 1000, 1000, 0, ALL, DSYGVD, 3, 3},
    {"random_1000 frequencies / dsyevd", 1000, 1000, 0, VALUES, DSYEVD_VALUES, 6, 5},
    {"random_1000 all with vectors / GSL symmv", 1000, 1000, 0, ALL, GSL, 1, 3},
    {"chain_4000 all with vectors / dstemr", 4000, CHAIN, 0, ALL, DSTEMR, 2, 2},
    {"binary_511 all with vectors / dsyevd", 511, BINARY, EQUAL_ARMS, ALL, DSYEVD, 5, 20},
    {"binary_511 off by 1e-6 all with vectors / dsyevd", 511, BINARY, NEARLY_EQUAL_ARMS, ALL,
     DSYEVD, 3, 3},
    {"star_400 off by 1e-6 all with vectors / dsyevd", 400, STAR, NEARLY_EQUAL_ARMS, ALL, DSYEVD, 5,
     5},
    {"star_2000 equal arms all with vectors / dsyevd", 2000, STAR, EQUAL_ARMS, ALL, DSYEVD, 1, 5},
    {"random_100000 20 slowest with vectors / ARPACK", 100000, 100000, 0, SLOWEST(20), ARPACK, 1,
     3},
    {"random_1000000 20 slowest with vectors", 1000000, 1000000, 0, SLOWEST(20), ALONE, 2, 1},
    {"random_4000 frequencies / dsyevd", 4000, 4000, 0, VALUES, DSYEVD_VALUES, 1, 4},
    {"random_4000 all with vectors / dsyevd", 4000, 4000, 0, ALL, DSYEVD, 1, 4},
};

static void *symbol(void *library, const char *name) {
    return library ? dlsym(library, name) : NULL;
}

/* usage: run [PART-OF-A-NAME ...] */
int main(int argc, char **argv) {
    /* freed memory is reused, except very large blocks; LAPACK's matrices exist beforehand too */
    (void)mallopt(M_MMAP_THRESHOLD, 32 << 20);
    (void)mallopt(M_TRIM_THRESHOLD, 1 << 30);
    void *blas = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_GLOBAL),
         *arpack = dlopen("libarpack.so.2", RTLD_NOW);
    threads_fn *threads = (threads_fn *)symbol(blas, "openblas_set_num_threads");
    if (threads) threads(1);
    peer.dsyevd = (dsyevd_fn *)symbol(blas, "dsyevd_");
    peer.dsygvd = (dsygvd_fn *)symbol(blas, "dsygvd_");
    peer.dstemr = (dstemr_fn *)symbol(blas, "dstemr_");
    peer.dsaupd = (dsaupd_fn *)symbol(arpack, "dsaupd_");
    printf("%-58s %10s %10s %8s  unit\n", "", "ours", "peer's", "ratio");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        int wanted = argc < 2;
        for (int j = 1; j < argc; j++) wanted |= strstr(lines[i].name, argv[j]) != NULL;
        if (wanted) run_line(&lines[i]);
    }
}
