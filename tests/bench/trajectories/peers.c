#include "tests/bench/trajectories/peers.h"

#include <dlfcn.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics.h"

#if __has_include(<cvode/cvode.h>) && __has_include(<arkode/arkode_erkstep.h>)
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#define PEERS_SUNDIALS 1
#endif

/* below this size LAPACK is not faster */
enum { PEERS_SMALL = 24 };

typedef void peers_dposv_fn(const char *, const int *, const int *, double *, const int *, double *,
                            const int *, int *);

static peers_dposv_fn *peers_dposv;

void peers_open(void) {
    void *library = dlopen("libopenblas.so.0", RTLD_NOW);
    void (*threads)(int) = NULL;
    gsl_set_error_handler_off();
    if (!library) return;
    *(void **)&peers_dposv = dlsym(library, "dposv_");
    *(void **)&threads = dlsym(library, "openblas_set_num_threads");
    if (threads) threads(1);
}

/* ---- right-hand sides: y contains phi and phi' */

struct peers_system {
    const struct problem *problem;
    int n;
    void *work;                 /* of the O(n) form */
    double *gram, *hung;        /* diag(l) S^T diag(m) S diag(l), l S^T m */
    double *cosine, *sine, *re; /* of the matrix form */
};

static int peers_fast(double t, const double y[], double f[], void *context) {
    struct peers_system *x = context;
    const struct pend_loads *loads = &x->problem->loads;
    size_t n = (size_t)x->n;
    memcpy(f, y + n, n * sizeof *f);
    if (loads->terms) {
        struct bodies_state state = {.phi = y, .rate = y + n, .time = t};
        pend_bodies_at(x->problem->tree, loads, &state, x->work, f + n, NULL);
        return 0;
    }
    pend_dynamics(x->problem->tree, &x->problem->loads, y, y + n, x->work, f + n, NULL);
    return 0;
}

/* solves re x = b, b becomes x; the lower triangle by rows, which is LAPACK's upper one by
 * columns */
static void peers_solve(int n, double re[], double b[]) {
    if (n > PEERS_SMALL && peers_dposv) {
        int one = 1, info;
        peers_dposv("U", &n, &one, re, &n, b, &n, &info);
        return;
    }
    for (int j = 0; j < n; j++) {
        double *row = re + j * n, d = row[j], x = b[j];
        for (int k = 0; k < j; k++) d -= row[k] * row[k], x -= row[k] * b[k];
        row[j] = 1 / sqrt(d);
        b[j] = x * row[j];
        for (int i = j + 1; i < n; i++) {
            double q = re[i * n + j];
            for (int k = 0; k < j; k++) q -= re[i * n + k] * row[k];
            re[i * n + j] = q * row[j];
        }
    }
    for (int j = n - 1; j >= 0; j--) {
        for (int k = j + 1; k < n; k++) b[j] -= re[k * n + j] * b[k];
        b[j] *= re[j * n + j];
    }
}

/* (aaa): Re phi'' = Im phi'^2 - g cos(phi) l (S^T m), M_ij = gram_ij e^{i (phi_j - phi_i)} */
static int peers_matrix(double t, const double y[], double f[], void *context) {
    struct peers_system *x = context;
    int n = x->n;
    const double *w = y + n;
    double *c = x->cosine, *s = x->sine, *b = f + n;
    (void)t;
    for (int i = 0; i < n; i++) {
        sincos(y[i], &s[i], &c[i]);
        f[i] = w[i];
    }
    for (int i = 0; i < n; i++) {
        const double *gram = x->gram + (size_t)i * (size_t)n;
        double *re = x->re + (size_t)i * (size_t)n,
               sum = -x->problem->loads.gravity * c[i] * x->hung[i];
        for (int j = 0; j < n; j++) sum += gram[j] * (c[i] * s[j] - s[i] * c[j]) * w[j] * w[j];
        for (int j = 0; j <= i; j++) re[j] = gram[j] * (c[i] * c[j] + s[i] * s[j]);
        b[i] = sum;
    }
    peers_solve(n, x->re, b);
    return 0;
}

static void peers_system_clear(struct peers_system *x) {
    free(x->work);
    free(x->gram);
}

static int peers_system_init(struct peers_system *x, const struct problem *problem) {
    const struct pend_tree *tree = problem->tree;
    size_t n = (size_t)tree->n;
    *x = (struct peers_system){.problem = problem, .n = tree->n};
    const struct pend_terms *terms = problem->loads.terms;
    size_t bytes = terms ? pend_bodies_bytes(tree, terms) : pend_dynamics_work_bytes(tree->n);
    x->work = aligned_alloc(64, (bytes + 63) / 64 * 64);
    x->gram = calloc(2 * n * n + 3 * n, sizeof(double));
    if (!x->work || !x->gram) {
        peers_system_clear(x);
        return 1;
    }
    x->re = x->gram + n * n;
    x->hung = x->re + n * n;
    x->cosine = x->hung + n;
    x->sine = x->cosine + n;
    for (int k = 0; k < tree->n; k++) {
        x->hung[k] = tree->len[k] * tree->subtree_mass[k];
        for (int i = k; i >= 0; i = tree->parent[i])
            for (int j = k; j >= 0; j = tree->parent[j])
                x->gram[(size_t)i * n + (size_t)j] += tree->mass[k] * tree->len[i] * tree->len[j];
    }
    return 0;
}

/* ---- the GNU Scientific Library */

typedef int peers_rhs(double t, const double y[], double f[], void *context);

static int peers_gsl(const struct problem *problem, double tolerance, double phi[], peers_rhs *rhs,
                     const gsl_odeiv2_step_type *type) {
    size_t n = (size_t)problem->tree->n;
    struct peers_system x;
    double y[2 * PROBLEM_ARMS_MAX], t = 0;
    if (peers_system_init(&x, problem)) return 1;
    gsl_odeiv2_system system = {rhs, NULL, 2 * n, &x};
    gsl_odeiv2_driver *driver =
        gsl_odeiv2_driver_alloc_y_new(&system, type, 1e-3, tolerance, tolerance);
    int failed = !driver;
    memcpy(y, problem->phi, n * sizeof *y);
    memcpy(y + n, problem->rate, n * sizeof *y);
    memcpy(phi, y, n * sizeof *y);
    for (int i = 1; i < problem->count && !failed; i++) {
        failed = gsl_odeiv2_driver_apply(driver, &t, problem_time(problem, i), y) != GSL_SUCCESS;
        memcpy(phi + (size_t)i * n, y, n * sizeof *y);
    }
    if (driver) gsl_odeiv2_driver_free(driver);
    peers_system_clear(&x);
    return failed;
}

int peer_rk8pd_matrix(const struct problem *problem, double tolerance, double phi[]) {
    if (problem->loads.terms) return 1;
    return peers_gsl(problem, tolerance, phi, peers_matrix, gsl_odeiv2_step_rk8pd);
}

int peer_msadams_matrix(const struct problem *problem, double tolerance, double phi[]) {
    if (problem->loads.terms) return 1;
    return peers_gsl(problem, tolerance, phi, peers_matrix, gsl_odeiv2_step_msadams);
}

int peer_rk8pd(const struct problem *problem, double tolerance, double phi[]) {
    return peers_gsl(problem, tolerance, phi, peers_fast, gsl_odeiv2_step_rk8pd);
}

int peer_msadams(const struct problem *problem, double tolerance, double phi[]) {
    return peers_gsl(problem, tolerance, phi, peers_fast, gsl_odeiv2_step_msadams);
}

/* ---- SUNDIALS */

#ifdef PEERS_SUNDIALS

#if SUNDIALS_VERSION_MAJOR < 7
#define PEERS_NO_COMM NULL
#define PEERS_QUIET(context) ((void)0)
#else
#define PEERS_NO_COMM SUN_COMM_NULL
#define PEERS_QUIET(context) SUNContext_ClearErrHandlers(context)
#endif

static int peers_sundials(sunrealtype t, N_Vector y, N_Vector f, void *context) {
    return peers_fast(t, NV_DATA_S(y), NV_DATA_S(f), context);
}

/* Adams up to order 12, its own interpolation at the instants */
static int peers_cvode(const struct problem *problem, double tolerance, double phi[], N_Vector y,
                       struct peers_system *x, SUNContext context) {
    size_t n = (size_t)x->n;
    void *cvode = CVodeCreate(CV_ADAMS, context);
    SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
    int failed = CVodeInit(cvode, peers_sundials, 0, y) || CVodeSetUserData(cvode, x) ||
                 CVodeSStolerances(cvode, tolerance, tolerance) ||
                 CVodeSetMaxNumSteps(cvode, 10000000) || CVodeSetNonlinearSolver(cvode, solver);
#if SUNDIALS_VERSION_MAJOR < 7
    CVodeSetErrFile(cvode, NULL);
#endif
    for (int i = 1; i < problem->count && !failed; i++) {
        sunrealtype t;
        failed = CVode(cvode, problem_time(problem, i), y, &t, CV_NORMAL) < 0;
        memcpy(phi + (size_t)i * n, NV_DATA_S(y), n * sizeof *phi);
    }
    CVodeFree(&cvode);
    SUNNonlinSolFree(solver);
    return failed;
}

/* explicit Runge-Kutta of order 8; its interpolation is of order 5, so every instant ends a step */
static int peers_arkode(const struct problem *problem, double tolerance, double phi[], N_Vector y,
                        struct peers_system *x, SUNContext context) {
    size_t n = (size_t)x->n;
    void *arkode = ERKStepCreate(peers_sundials, 0, y, context);
    int failed = ERKStepSetUserData(arkode, x) ||
                 ERKStepSStolerances(arkode, tolerance, tolerance) || ERKStepSetOrder(arkode, 8) ||
                 ERKStepSetMaxNumSteps(arkode, 10000000);
#if SUNDIALS_VERSION_MAJOR < 7
    ERKStepSetErrFile(arkode, NULL);
#endif
    for (int i = 1; i < problem->count && !failed; i++) {
        sunrealtype t, wanted = problem_time(problem, i);
        failed = ERKStepSetStopTime(arkode, wanted) ||
                 ERKStepEvolve(arkode, wanted, y, &t, ARK_NORMAL) < 0;
        memcpy(phi + (size_t)i * n, NV_DATA_S(y), n * sizeof *phi);
    }
    ERKStepFree(&arkode);
    return failed;
}

typedef int peers_sundials_fn(const struct problem *problem, double tolerance, double phi[],
                              N_Vector y, struct peers_system *x, SUNContext context);

static int peers_with_sundials(const struct problem *problem, double tolerance, double phi[],
                               peers_sundials_fn *run) {
    size_t n = (size_t)problem->tree->n;
    struct peers_system x;
    SUNContext context;
    if (SUNContext_Create(PEERS_NO_COMM, &context)) return 1;
    PEERS_QUIET(context);
    int failed = peers_system_init(&x, problem);
    if (!failed) {
        N_Vector y = N_VNew_Serial(2 * (sunindextype)n, context);
        memcpy(NV_DATA_S(y), problem->phi, n * sizeof *phi);
        memcpy(NV_DATA_S(y) + n, problem->rate, n * sizeof *phi);
        memcpy(phi, problem->phi, n * sizeof *phi);
        failed = run(problem, tolerance, phi, y, &x, context);
        N_VDestroy(y);
        peers_system_clear(&x);
    }
    SUNContext_Free(&context);
    return failed;
}

int peer_cvode(const struct problem *problem, double tolerance, double phi[]) {
    return peers_with_sundials(problem, tolerance, phi, peers_cvode);
}

int peer_arkode(const struct problem *problem, double tolerance, double phi[]) {
    return peers_with_sundials(problem, tolerance, phi, peers_arkode);
}

int peer_sundials_there(void) { return 1; }

#else

int peer_cvode(const struct problem *problem, double tolerance, double phi[]) {
    (void)problem, (void)tolerance, (void)phi;
    return 1;
}

int peer_arkode(const struct problem *problem, double tolerance, double phi[]) {
    (void)problem, (void)tolerance, (void)phi;
    return 1;
}

int peer_sundials_there(void) { return 0; }

#endif
