/* rkf45, rk8pd and msadams: GSL's steppers and step control on the O(n) equations.
 * Leaves to others: the time loop (run).
 * Invariant: y and t are the end of the last accepted step; no call of GSL ends the process. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics.h"
#include "core/integrate/methods/method.h"

/* the best accuracy of GSL's methods: the rounding error of an angle of one radian */
static const double GSL_RTOL_LEAST = 1e-16;

struct gsl_stepper {
    const struct pend_tree *tree;
    struct pend_loads loads;
    gsl_odeiv2_system system;
    gsl_odeiv2_driver driver; /* built member by member, because gsl_odeiv2_driver_alloc does not
                               * check its allocations */
    gsl_odeiv2_control control;
    double atol, rtol;
    double t, size; /* s: end of the last step, relative to the first instant; signed length of the
                     * next step */
    struct pend_stepper_counts counts;
    long rejected; /* number of steps rejected before GSL was last restarted */
    double start;  /* s, the first instant in the time of the request */
    int n;
    int gives; /* whether drives or friction change the energy */
    /* phi, then phi', 2 n values. If the energy changes, work and heat so far follow, J; they do
     * not affect the steps. Then scratch memory of three times this size. */
    double *y;
    void *work;
};

/* Switches off GSL's default error handler, which is global and aborts the process, even if only
 * memory is short. This runs once, before main, while there is no other thread. A handler that a
 * host sets later is kept. */
__attribute__((constructor)) static void gsl_stepper_quieten(void) { gsl_set_error_handler_off(); }

/* the right-hand side; if it overflows, GSL_EBADFUNC ends the step */
static int gsl_stepper_derivative(double t, const double y[], double f[], void *context) {
    struct gsl_stepper *g = context;
    int n = g->n, bad = 0;
    memcpy(f, y + n, (size_t)n * sizeof(double));
    struct bodies_state state = {.phi = y, .rate = y + n, .time = g->start + t};
    if (g->gives)
        pend_bodies_power_at(g->tree, &g->loads, &state, g->work, f + n, f + 2 * n, f + 2 * n + 1);
    else
        pend_dynamics_at(g->tree, &g->loads, state.time, y, y + n, g->work, f + n, NULL);
    g->counts.evaluations++;
    for (int k = 0; k < n; k++) bad |= !(fabs(f[n + k]) <= DBL_MAX);
    return bad ? GSL_EBADFUNC : GSL_SUCCESS;
}

/* root mean square of v relative to the tolerance at y */
static double gsl_stepper_norm(const struct gsl_stepper *g, const struct pend_problem *problem,
                               const double v[]) {
    double sum = 0;
    for (int i = 0; i < 2 * g->n; i++) {
        double part = v[i] / (problem->atol + problem->rtol * fabs(g->y[i]));
        sum += part * part;
    }
    return sqrt(sum / (2 * g->n));
}

/* The first step: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.4, for
 * a method of the given order; `scratch` has three times as many values as y. */
static double gsl_stepper_first_size(struct gsl_stepper *g, const struct pend_problem *problem,
                                     int order, double scratch[]) {
    int m = (int)g->system.dimension;
    double *slope = scratch, *y = scratch + m, *slope_after = scratch + 2 * m;
    gsl_stepper_derivative(0, g->y, slope, g);
    double d0 = gsl_stepper_norm(g, problem, g->y), d1 = gsl_stepper_norm(g, problem, slope);
    double guess = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    for (int i = 0; i < m; i++) y[i] = g->y[i] + guess * slope[i];
    gsl_stepper_derivative(guess, y, slope_after, g);
    for (int i = 0; i < m; i++) slope_after[i] -= slope[i];
    double d2 = gsl_stepper_norm(g, problem, slope_after) / guess, largest = fmax(d1, d2);
    double size =
        largest <= 1e-15 ? fmax(1e-6, guess * 1e-3) : pow(0.01 / largest, 1.0 / (order + 1));
    size = fmin(100 * guess, size);
    return isfinite(size) && size > 0 ? size : 1e-6;
}

/* The step control of gsl_odeiv2_control_y_new, bit for bit, in existing memory, because GSL's
 * function does not check its allocation. The factor 0 keeps values that are not finite. */
static double gsl_control_level(const struct gsl_stepper *g, double y, double slope, double size) {
    return g->rtol * (fabs(y) + 0.0 * fabs(size * slope)) + g->atol;
}

static int gsl_control_adjust(void *state, size_t count, unsigned order, const double y[],
                              const double error[], const double slope[], double *size) {
    double worst = DBL_MIN, before = *size;
    if (((const struct gsl_stepper *)state)->gives) count -= 2;
    for (size_t i = 0; i < count; i++) {
        double part = fabs(error[i]) / fabs(gsl_control_level(state, y[i], slope[i], before));
        if (part > worst) worst = part;
    }
    if (worst > 1.1) {
        *size = fmax(0.9 / pow(worst, 1.0 / order), 0.2) * before;
        return GSL_ODEIV_HADJ_DEC;
    }
    if (worst >= 0.5) return GSL_ODEIV_HADJ_NIL;
    *size = fmax(fmin(0.9 / pow(worst, 1.0 / (order + 1.0)), 5), 1) * before;
    return GSL_ODEIV_HADJ_INC;
}

static int gsl_control_errlevel(void *state, const double y, const double slope, const double size,
                                const size_t index, double *level) {
    const struct gsl_stepper *g = state;
    *level = gsl_control_level(state, y, slope, size);
    if (index >= 2 * (size_t)g->n) *level = DBL_MAX; // work and heat do not limit steps
    return *level <= 0 ? GSL_ESANITY : GSL_SUCCESS;
}

static int gsl_control_set_driver(void *state, const gsl_odeiv2_driver *driver) {
    (void)state, (void)driver;
    return GSL_SUCCESS;
}

static const gsl_odeiv2_control_type gsl_control = {"tolerances", .hadjust = gsl_control_adjust,
                                                    .errlevel = gsl_control_errlevel,
                                                    .set_driver = gsl_control_set_driver};

/* fills in the driver as gsl_odeiv2_driver_alloc_y_new does, but checks every allocation; returns 0
 * if memory runs out */
static int gsl_stepper_drive(struct gsl_stepper *g, const gsl_odeiv2_step_type *type) {
    gsl_odeiv2_driver *d = &g->driver;
    *d = (gsl_odeiv2_driver){.sys = &g->system, .h = g->size, .hmax = DBL_MAX};
    d->s = gsl_odeiv2_step_alloc(type, g->system.dimension);
    d->c = &g->control;
    d->e = gsl_odeiv2_evolve_alloc(g->system.dimension);
    return d->s && d->e && gsl_odeiv2_step_set_driver(d->s, d) == GSL_SUCCESS &&
           gsl_odeiv2_evolve_set_driver(d->e, d) == GSL_SUCCESS;
}

static void gsl_stepper_free(struct gsl_stepper *g) {
    if (g->driver.e) gsl_odeiv2_evolve_free(g->driver.e);
    if (g->driver.s) gsl_odeiv2_step_free(g->driver.s);
    free(g);
}

/* The fraction of both tolerances that is requested of each step, calibrated by make
 * bench-precision: It is `loose` for rtol >= 1e-6, `tight` for rtol <= 1e-9, and a power of rtol
 * between. The errors of Prince and Dormand's steps decrease faster than the tolerance. */
struct gsl_share {
    double loose, tight;
};

/* Sets the tolerances requested of GSL, which bounds the error of one step. With these fractions,
 * the total error of a run stays within 30 times the tolerances unless the motion amplifies it
 * (figures: core/theory.md). */
static struct pend_problem gsl_stepper_tighten(const struct pend_problem *problem,
                                               struct gsl_share shares) {
    struct pend_problem tight = *problem;
    const double from = 1e-6, to = 1e-9;
    double part = log(fmin(fmax(problem->rtol, to), from) / from) / log(to / from);
    double share = shares.loose * pow(shares.tight / shares.loose, part);
    tight.atol = share * fmax(problem->atol, PEND_METHOD_ATOL_LEAST * problem->rtol);
    tight.rtol = fmax(share * problem->rtol, GSL_RTOL_LEAST);
    return tight;
}

static enum pend_status gsl_stepper_open(void **stepper, const struct pend_problem *wanted,
                                         struct pend_error *error, const gsl_odeiv2_step_type *type,
                                         int order, struct gsl_share share) {
    const struct pend_problem tight = gsl_stepper_tighten(wanted, share), *problem = &tight;
    const struct pend_loads *loads = &problem->loads;
    int n = problem->tree->n,
        gives = loads->terms && !pend_terms_conserve(loads->terms, loads->value);
    size_t count = 2 * (size_t)n + (gives ? 2 : 0),
           head = (sizeof(struct gsl_stepper) + 63) / 64 * 64,
           state = (count * 4 * sizeof(double) + 63) / 64 * 64;
    char *block = aligned_alloc(
        64, head + state + (pend_dynamics_at_bytes(problem->tree, &problem->loads) + 63) / 64 * 64);
    *stepper = NULL;
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the steps of %d arms", n);
    struct gsl_stepper *g = (struct gsl_stepper *)block;
    *g = (struct gsl_stepper){
        .tree = problem->tree,
        .loads = problem->loads,
        .control = {.type = &gsl_control, .state = g},
        .atol = problem->atol,
        .rtol = problem->rtol,
        .system = {.function = gsl_stepper_derivative, .dimension = count, .params = g},
        .n = n,
        .gives = gives,
        .start = pend_times_at(&problem->times, 0),
        .y = (double *)(block + head),
        .work = block + head + state};
    memset(g->y, 0, count * sizeof(double));
    memcpy(g->y, problem->phi, (size_t)n * sizeof(double));
    memcpy(g->y + n, problem->rate, (size_t)n * sizeof(double));
    const struct pend_times *times = &problem->times;
    double span = pend_times_at(times, times->count - 1) - pend_times_at(times, 0);
    g->size = copysign(gsl_stepper_first_size(g, problem, order, g->y + count), span);
    if (!gsl_stepper_drive(g, type)) {
        gsl_stepper_free(g);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the steps of %d arms", n);
    }
    *stepper = g;
    return PEND_OK;
}

static void gsl_stepper_close(void **stepper) {
    if (*stepper) gsl_stepper_free(*stepper);
    *stepper = NULL;
}

/* One accepted step of GSL. A step that would end within a hundredth of its length before the limit
 * is stretched to the limit; otherwise GSL may miss the limit by a rounding error and take another
 * step of that size. A cut or stretched step does not change the step size. */
static int gsl_stepper_evolve(struct gsl_stepper *g, double limit) {
    gsl_odeiv2_driver *d = &g->driver;
    double left = limit - g->t, size = g->size;
    if (fabs(left) < 1.01 * fabs(size)) size = 2 * left;
    double tried = size;
    int status = gsl_odeiv2_evolve_apply(d->e, d->c, d->s, &g->system, &g->t, limit, &size, g->y);
    if (size != tried || status != GSL_SUCCESS) g->size = size;
    return status;
}

/* As gsl_stepper_evolve. If a value is not finite, tries once more without history, because GSL's
 * multistep method divides by the difference of two states, which may vanish. */
static int gsl_stepper_evolve_anew(struct gsl_stepper *g, double limit) {
    double t = g->t, size = g->size, *kept = g->y + g->system.dimension;
    size_t bytes = g->system.dimension * sizeof(double);
    memcpy(kept, g->y, bytes);
    int status = gsl_stepper_evolve(g, limit);
    if (status != GSL_EBADFUNC) return status;
    g->t = t, g->size = size;
    memcpy(g->y, kept, bytes);
    g->rejected += (long)g->driver.e->failed_steps + 1;
    gsl_odeiv2_driver_reset(&g->driver);
    return gsl_stepper_evolve(g, limit);
}

static enum pend_status gsl_stepper_step(void *stepper, double limit, double *reached,
                                         struct pend_error *error) {
    struct gsl_stepper *g = stepper;
    int status = gsl_stepper_evolve_anew(g, limit);
    g->counts.rejected = g->rejected + (long)g->driver.e->failed_steps;
    if (status == GSL_SUCCESS) {
        g->counts.steps++;
        *reached = g->t;
        return PEND_OK;
    }
    if (status == GSL_EBADFUNC)
        return pend_fail(error, PEND_NOT_FINITE, -1, g->t, "the accelerations ceased to be finite");
    return pend_fail(error, PEND_STEP_TOO_SMALL, -1, g->t,
                     "the tolerances cannot be met with a step above %.3g s", fabs(g->size));
}

static void gsl_stepper_at(void *stepper, const double t[], int count,
                           const struct pend_points *points) {
    struct gsl_stepper *g = stepper;
    size_t row = (size_t)g->n * sizeof(double);
    (void)t; /* t is always the end of the last step */
    for (int i = 0; i < count; i++) {
        memcpy(points->phi + i * g->n, g->y, row);
        memcpy(points->rate + i * g->n, g->y + g->n, row);
    }
}

static void gsl_stepper_exchange(const void *stepper, const double t[], int count, double work[],
                                 double heat[]) {
    const struct gsl_stepper *g = stepper;
    (void)t; /* t is always the end of the last step */
    for (int i = 0; i < count; i++) {
        work[i] = g->gives ? g->y[2 * g->n] : 0;
        heat[i] = g->gives ? g->y[2 * g->n + 1] : 0;
    }
}

/* saves the state of the driver: the last derivative, and whether it exists; one-step methods keep
 * nothing else */
static void gsl_stepper_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct gsl_stepper *g = stepper;
    gsl_odeiv2_evolve *e = g->driver.e;
    size_t m = g->system.dimension;
    long applied[] = {(long)e->count, (long)e->failed_steps};
    pend_stepper_counts_carry(&g->counts, checkpoint);
    pend_checkpoint_counts(checkpoint, &g->rejected, 1);
    pend_checkpoint_row(checkpoint, &g->t, 1);
    pend_checkpoint_row(checkpoint, &g->size, 1);
    pend_checkpoint_row(checkpoint, g->y, m);
    pend_checkpoint_counts(checkpoint, applied, 2);
    e->count = (unsigned long)applied[0];
    e->failed_steps = (unsigned long)applied[1];
    pend_checkpoint_row(checkpoint, &e->last_step, 1);
    pend_checkpoint_row(checkpoint, e->dydt_out, m);
}

static struct pend_stepper_counts gsl_stepper_counts(const void *stepper) {
    return ((const struct gsl_stepper *)stepper)->counts;
}

static enum pend_status gsl_stepper_open_rkf45(void **stepper, const struct pend_problem *problem,
                                               struct pend_error *error) {
    return gsl_stepper_open(stepper, problem, error, gsl_odeiv2_step_rkf45, 5,
                            (struct gsl_share){0.03, 0.03});
}

static enum pend_status gsl_stepper_open_rk8pd(void **stepper, const struct pend_problem *problem,
                                               struct pend_error *error) {
    return gsl_stepper_open(stepper, problem, error, gsl_odeiv2_step_rk8pd, 8,
                            (struct gsl_share){0.2, 0.7});
}

/* the order varies and starts at 1 */
static enum pend_status gsl_stepper_open_msadams(void **stepper, const struct pend_problem *problem,
                                                 struct pend_error *error) {
    return gsl_stepper_open(stepper, problem, error, gsl_odeiv2_step_msadams, 1,
                            (struct gsl_share){0.005, 0.005});
}

#define GSL_STEPPER(name_, carry_, summary_)                                                       \
    const struct pend_method pend_method_##name_ = {                                               \
        .name = #name_,                                                                            \
        .summary = summary_,                                                                       \
        .flags = PEND_METHOD_LANDS | PEND_METHOD_TOLERANCES | PEND_METHOD_TERMS,                   \
        .rtol_default = 1e-9,                                                                      \
        .rtol_min = 1e-14,                                                                         \
        .rtol_max = 0.1,                                                                           \
        .atol_divisor = 1000,                                                                      \
        .atol_min = 0,                                                                             \
        .atol_max = 0.1,                                                                           \
        .open = gsl_stepper_open_##name_,                                                          \
        .step = gsl_stepper_step,                                                                  \
        .at = gsl_stepper_at,                                                                      \
        .carry = (carry_),                                                                         \
        .counts = gsl_stepper_counts,                                                              \
        .exchange = gsl_stepper_exchange,                                                          \
        .close = gsl_stepper_close,                                                                \
    }

GSL_STEPPER(rkf45, gsl_stepper_carry,
            "Runge-Kutta-Fehlberg 4(5) of the GNU Scientific Library; a step ends at every "
            "requested instant.");
GSL_STEPPER(rk8pd, gsl_stepper_carry,
            "Runge-Kutta-Prince-Dormand 8(9) of the GNU Scientific Library; a step ends at every "
            "requested instant.");
/* GSL does not expose the history of the multistep method, so such a run cannot be saved or cut */
GSL_STEPPER(msadams, NULL,
            "Adams multistep of variable order 1 to 12 of the GNU Scientific Library; a step ends "
            "at every requested instant.");
