/* ode23: the pair of Bogacki and Shampine, 3(2), with the step control, the defaults and the
 * interpolant of MATLAB's function of that name.
 * Leaves to others: the time loop (run).
 * Invariant: y and f[0] belong to the start of the last step, y_end and f[3] to its end. For rtol
 * >= 1e-3, MATLAB's default, every operation is the same as in MATLAB. For smaller values the
 * tolerances are calibrated and the state is a compensated sum. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics.h"
#include "core/integrate/methods/method.h"

struct ode23 {
    const struct pend_tree *tree;
    struct pend_loads loads;
    double asked, rtol, threshold; /* the caller's rtol; the tolerances of one step */
    double begin, end,
        length; /* s: start and end of the last step, and its length; all 0 before the first step */
    double first, last;    /* s: the first instant in the time of the request; the last instant,
                            * relative */
    double size, size_max; /* s, >= 0: length of the next step, and of the longest */
    struct pend_stepper_counts counts;
    int n;
    int gives;  /* whether drives or friction change the energy */
    int count;  /* number of components: 2 n, plus 2 if the energy changes */
    int matlab; /* whether every operation is the same as in MATLAB */
    /* phi, then phi', 2 n values, then work and heat so far, J, which do not affect the steps; f:
     * their derivatives */
    double *y, *y_end, *f[4];
    double *low, *low_end; /* rounding errors of y and y_end; 0 if every operation is the same as in
                            * MATLAB */
    void *work;
};

/* MATLAB's default; for this rtol and larger, results equal MATLAB's */
static const double ODE23_MATLAB_RTOL = 1e-3;

/* fraction of both tolerances that is requested of a step for a smaller rtol: calibrated by make
 * bench-precision, so that the error of a run stays within 30 times its tolerance */
static const double ODE23_SHARE = 0.1;

enum { ODE23_ROWS = 8 };

/* weights of the derivatives at the stages: for the second and third stage, for the result, and for
 * the error estimate */
static const double ode23_stage2 = 1.0 / 2, ode23_stage3 = 3.0 / 4;
static const double ode23_result[3] = {2.0 / 9, 1.0 / 3, 4.0 / 9};
static const double ode23_error[4] = {-5.0 / 72, 1.0 / 12, 1.0 / 9, -1.0 / 8};
/* weight of derivative j in the interpolant: a polynomial in s = (t - begin)/length without
 * constant term */
static const double ode23_interpolant[4][3] = {
    {1, -4.0 / 3, 5.0 / 9}, {0, 1, -2.0 / 3}, {0, 4.0 / 3, -8.0 / 9}, {0, -1, 1}};

/* `time` is relative to the first instant */
static void ode23_derivative(struct ode23 *o, double time, const double y[], double f[]) {
    int n = o->n;
    struct bodies_state state = {.phi = y, .rate = y + n, .time = o->first + time};
    memcpy(f, y + n, sizeof(double) * (size_t)n);
    if (o->gives)
        pend_bodies_power_at(o->tree, &o->loads, &state, o->work, f + n, f + 2 * n, f + 2 * n + 1);
    else
        pend_dynamics_at(o->tree, &o->loads, state.time, y, y + n, o->work, f + n, NULL);
    o->counts.evaluations++;
}

/* MATLAB's initial step, from |y'| alone. MATLAB also bounds it by the first requested interval,
 * but then the motion would depend on the requested instants. */
static double ode23_first_size(const struct ode23 *o) {
    double rate = 0;
    for (int i = 0; i < 2 * o->n; i++)
        rate = fmax(rate, fabs(o->f[3][i]) / fmax(fabs(o->y_end[i]), o->threshold));
    rate /= 0.8 * cbrt(o->rtol);
    return o->size_max * rate > 1 ? 1 / rate : o->size_max;
}

static void ode23_start(struct ode23 *o, const struct pend_problem *problem) {
    const struct pend_times *times = &problem->times;
    o->first = pend_times_at(times, 0);
    o->last = pend_times_at(times, times->count - 1) - o->first;
    o->size_max = 0.1 * fabs(o->last);
    memcpy(o->y_end, problem->phi, sizeof(double) * (size_t)o->n);
    memcpy(o->y_end + o->n, problem->rate, sizeof(double) * (size_t)o->n);
    ode23_derivative(o, 0, o->y_end, o->f[3]);
    o->size = ode23_first_size(o);
}

static enum pend_status ode23_open(void **stepper, const struct pend_problem *problem,
                                   struct pend_error *error) {
    const struct pend_loads *loads = &problem->loads;
    int n = problem->tree->n,
        gives = loads->terms && !pend_terms_conserve(loads->terms, loads->value);
    int count = 2 * n + (gives ? 2 : 0);
    size_t vector = ((size_t)count * sizeof(double) + 63) / 64 * 64,
           head = (sizeof(struct ode23) + 63) / 64 * 64;
    size_t work = (pend_dynamics_at_bytes(problem->tree, &problem->loads) + 63) / 64 * 64;
    char *block = aligned_alloc(64, head + ODE23_ROWS * vector + work);
    *stepper = block;
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the steps of %d arms", n);
    struct ode23 *o = *stepper;
    *o = (struct ode23){.tree = problem->tree,
                        .loads = problem->loads,
                        .asked = problem->rtol,
                        .rtol = problem->rtol,
                        .threshold = fmax(problem->atol / problem->rtol, PEND_METHOD_ATOL_LEAST),
                        .matlab = problem->rtol >= ODE23_MATLAB_RTOL,
                        .n = n,
                        .gives = gives,
                        .count = count};
    if (!o->matlab) o->rtol *= ODE23_SHARE;
    double **row[ODE23_ROWS] = {&o->y,    &o->y_end, &o->f[0], &o->f[1],
                                &o->f[2], &o->f[3],  &o->low,  &o->low_end};
    for (size_t j = 0; j < ODE23_ROWS; j++) *row[j] = (double *)(block + head + j * vector);
    o->work = block + head + ODE23_ROWS * vector;
    memset(o->y_end, 0, vector);
    memset(o->low, 0, vector);
    memset(o->low_end, 0, vector);
    ode23_start(o, problem);
    return PEND_OK;
}

static void ode23_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

/* makes the end of the last step the start of the next, and its last derivative the first */
static void ode23_advance(struct ode23 *o) {
    double *y = o->y, *f = o->f[0], *low = o->low;
    o->y = o->y_end;
    o->y_end = y;
    o->low = o->low_end;
    o->low_end = low;
    o->f[0] = o->f[3];
    o->f[3] = f;
    o->begin = o->end;
}

/* y_end = y + change as a sum of two doubles, which matters in runs of a million steps */
static void ode23_sum(struct ode23 *o, int i, double change) {
    double y = o->y[i], part = change + o->low[i], end = y + part, moved = end - y;
    o->y_end[i] = end;
    o->low_end[i] = (y - (end - moved)) + (part - moved);
}

/* Tries a step from begin to end. As in MATLAB, the stages use the length `h` and the result uses
 * end - begin, which differs from `h` by a rounding error of the time. If the tolerance is tighter
 * than MATLAB's default, the stages use end - begin too. */
static void ode23_try(struct ode23 *o, double h) {
    int m = o->count;
    double *y = o->y, *y_end = o->y_end, *f0 = o->f[0], *f1 = o->f[1], *f2 = o->f[2];
    if (!o->matlab) h = o->end - o->begin;
    for (int i = 0; i < m; i++) y_end[i] = y[i] + h * ode23_stage2 * f0[i];
    ode23_derivative(o, o->begin + h * ode23_stage2, y_end, f1);
    for (int i = 0; i < m; i++) y_end[i] = y[i] + h * ode23_stage3 * f1[i];
    ode23_derivative(o, o->begin + h * ode23_stage3, y_end, f2);
    double b0 = h * ode23_result[0], b1 = h * ode23_result[1], b2 = h * ode23_result[2];
    for (int i = 0; i < m; i++) {
        double change = b0 * f0[i] + b1 * f1[i] + b2 * f2[i];
        if (o->matlab)
            y_end[i] = y[i] + change;
        else
            ode23_sum(o, i, change);
    }
    ode23_derivative(o, o->end, y_end, o->f[3]);
    o->length = o->end - o->begin;
}

/* largest component of the error estimate, relative to max(|y|, |y_end|, threshold) */
static double ode23_estimate(const struct ode23 *o) {
    const double *e = ode23_error;
    double worst = 0;
    for (int i = 0; i < 2 * o->n; i++) {
        double error =
            o->f[0][i] * e[0] + o->f[1][i] * e[1] + o->f[2][i] * e[2] + o->f[3][i] * e[3];
        worst =
            fmax(worst, fabs(error) / fmax(fmax(fabs(o->y[i]), fabs(o->y_end[i])), o->threshold));
    }
    return o->size * worst;
}

static enum pend_status ode23_step(void *stepper, double limit, double *reached,
                                   struct pend_error *error) {
    struct ode23 *o = stepper;
    (void)limit; /* `limit` is always the last instant, o->last */
    ode23_advance(o);
    double size_min = 16 * (nextafter(fabs(o->begin), INFINITY) - fabs(o->begin));
    o->size = fmin(o->size_max, fmax(size_min, o->size));
    double h = copysign(o->size, o->last), estimate;

    /* end the step at the last instant if a step 10 % longer would reach it */
    int last = 1.1 * o->size >= fabs(o->last - o->begin);
    if (last) h = o->last - o->begin;
    o->size = fabs(h);
    for (int failures = 0;; failures++) {
        o->end = last ? o->last : o->begin + h;
        ode23_try(o, h);
        estimate = ode23_estimate(o);
        if (!(estimate > o->rtol)) {
            /* without failures the next step may grow, or shrink a little */
            double shrink = failures ? 1 : 1.25 * cbrt(estimate / o->rtol);
            o->size = shrink > 0.2 ? o->size / shrink : 5 * o->size;
            break;
        }
        if (o->size <= size_min) {
            o->end = o->begin;
            return pend_fail(error, PEND_STEP_TOO_SMALL, -1, o->begin,
                             "ode23 cannot meet rtol = %g with a step above %.3g s", o->asked,
                             size_min);
        }
        double factor = failures ? 0.5 : fmax(0.5, 0.8 * cbrt(o->rtol / estimate));
        o->size = fmax(size_min, o->size * factor);
        h = copysign(o->size, o->last);
        last = 0;
        o->counts.rejected++;
    }
    o->counts.steps++;
    *reached = o->end;
    return PEND_OK;
}

/* the weights of the derivatives in the cubic through both ends with their slopes, as in MATLAB's
 * ntrp23 */
static void ode23_weigh(const struct ode23 *o, double t, double weight[4]) {
    double s = (t - o->begin) / o->length;
    for (int j = 0; j < 4; j++) {
        const double *b = ode23_interpolant[j];
        weight[j] = o->length * (s * (b[0] + s * (b[1] + s * b[2])));
    }
}

static double ode23_inside(const struct ode23 *o, const double weight[4], int i) {
    return o->y[i] + (weight[0] * o->f[0][i] + weight[1] * o->f[1][i] + weight[2] * o->f[2][i] +
                      weight[3] * o->f[3][i]);
}

static void ode23_exchange(const void *stepper, const double t[], int count, double work[],
                           double heat[]) {
    const struct ode23 *o = stepper;
    double weight[4];
    for (int i = 0; i < count; i++) {
        int at = 2 * o->n, end = t[i] == o->end;
        work[i] = heat[i] = 0;
        if (!o->gives) continue;
        ode23_weigh(o, t[i], weight);
        work[i] = end ? o->y_end[at] : ode23_inside(o, weight, at);
        heat[i] = end ? o->y_end[at + 1] : ode23_inside(o, weight, at + 1);
    }
}

static void ode23_at(void *stepper, const double t[], int count, const struct pend_points *points) {
    struct ode23 *o = stepper;
    size_t n = (size_t)o->n;
    for (int i = 0; i < count; i++) {
        double *phi = points->phi + (size_t)i * n, *rate = points->rate + (size_t)i * n;
        if (t[i] != o->end) {
            double weight[4];
            ode23_weigh(o, t[i], weight);
            for (int k = 0; k < o->n; k++) phi[k] = ode23_inside(o, weight, k);
            for (int k = 0; k < o->n; k++) rate[k] = ode23_inside(o, weight, o->n + k);
            continue;
        }
        memcpy(phi, o->y_end, n * sizeof(double));
        memcpy(rate, o->y_end + n, n * sizeof(double));
    }
}

static struct pend_stepper_counts ode23_counts(const void *stepper) {
    return ((const struct ode23 *)stepper)->counts;
}

static void ode23_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct ode23 *o = stepper;
    double *numbers[] = {&o->begin, &o->end, &o->length, &o->size};
    double *rows[ODE23_ROWS] = {o->y,    o->y_end, o->f[0], o->f[1],
                                o->f[2], o->f[3],  o->low,  o->low_end};
    pend_stepper_counts_carry(&o->counts, checkpoint);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        pend_checkpoint_row(checkpoint, numbers[i], 1);
    for (size_t i = 0; i < ODE23_ROWS; i++)
        pend_checkpoint_row(checkpoint, rows[i], (size_t)o->count);
}

const struct pend_method pend_method_ode23 = {
    .name = "ode23",
    .summary = "Bogacki-Shampine 3(2) with MATLAB's step control and default tolerances, as used "
               "in the paper; quick and coarse.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_TERMS,
    .rtol_default = 1e-3,
    .rtol_min = 1e-13,
    .rtol_max = 0.1,
    .atol_divisor = 1000,
    .atol_min = 0,
    .atol_max = 0.1,
    .open = ode23_open,
    .step = ode23_step,
    .at = ode23_at,
    .exchange = ode23_exchange,
    .counts = ode23_counts,
    .carry = ode23_carry,
    .close = ode23_close,
};
