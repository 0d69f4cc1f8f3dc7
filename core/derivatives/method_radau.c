/* radau: the implicit Runge-Kutta method Radau IIA of 7 stages and order 13, for stiff pendulums.
 * Leaves to others: the stages and their error (radau), the time loop (run).
 * Invariant: a step uses only the end, the length and, as a first guess, the polynomial of the
 * previous step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/derivatives/radau.h"
#include "core/integrate/run/run_check.h"
#include "core/taylor/taylor_order.h"

enum { LANES = DERIVATIVES_LANES, STAGES = RADAU_STAGES };

/* ---- steps */

/* the integral of a power over a fraction x of the last step, by the polynomial through the values
 * at the stages */
static double radau_energy(const struct radau *r, double x, const double power[STAGES]) {
    double weight[STAGES], sum = 0;
    for (int i = 0; i < STAGES && r->gives; i++) {
        pend_radau_weights(x * radau_node[i], 0, weight);
        for (int j = 0; j < STAGES; j++) sum += radau_through[STAGES - 1][i] * weight[j] * power[j];
    }
    return sum * x * r->kept->last;
}

static void radau_accept(struct radau *r, double h) {
    size_t rows = (size_t)(STAGES * r->n) * sizeof(double);
    int last = (STAGES - 1) * r->n;
    memcpy(r->bent, r->try_bent, rows);
    memcpy(r->gain, r->try_gain, rows);
    pend_radau_differ(r, r->bent + last, r->gain + last, &r->end);
    r->kept->last = h;
    r->kept->reached = r->kept->time + h;
    r->rough = 0;
    r->counts.steps++;
}

static enum pend_status radau_step(void *stepper, double limit, double *reached,
                                   struct pend_error *error) {
    struct radau *r = stepper;
    struct radau_scalars *kept = r->kept;
    size_t row = (size_t)r->n * sizeof(double);
    kept->given += radau_energy(r, 1, kept->power_in);
    kept->lost += radau_energy(r, 1, kept->power_out);
    memcpy(r->begin.phi, r->end.phi, row);
    memcpy(r->begin.low, r->end.low, row);
    memcpy(r->begin.rate, r->end.rate, row);
    kept->time = kept->reached;
    pend_radau_begin(r);
    if (!pend_run_finite(r->first, r->n))
        return pend_fail(error, PEND_NOT_FINITE, -1, kept->time,
                         "the accelerations ceased to be finite");
    for (int tried = 0;; tried++) {
        double left = limit - kept->time, h = copysign(fmin(kept->size, fabs(left)), left), longer;
        h = (kept->time + h) - kept->time; // rounds the length: both ends of the step are doubles
        if (!(fabs(h) > 0))
            return pend_fail(error, PEND_STEP_TOO_SMALL, -1, kept->time,
                             "the tolerances cannot be met with a step above %.3g s", kept->size);
        double ratio = pend_radau_try(r, h, &longer);
        kept->size = fabs(h) * (tried && ratio < 1 ? fmin(longer, 1) : longer);
        if (ratio < 1) {
            radau_accept(r, h);
            *reached = kept->reached;
            return PEND_OK;
        }
        r->counts.rejected++;
        r->rough = 1;
    }
}

static void radau_at(void *stepper, const double t[], int count, const struct pend_points *points) {
    struct radau *r = stepper;
    double weight[STAGES], low;
    for (int i = 0; i < count; i++) {
        double *phi = points->phi + i * r->n, *rate = points->rate + i * r->n;
        pend_radau_weights((t[i] - r->kept->time) / r->kept->last, 1, weight);
        for (int k = 0; k < r->n; k++) {
            double bent = pend_radau_sum(r, weight, r->bent, k),
                   gain = pend_radau_sum(r, weight, r->gain, k);
            radau_add(r->begin.phi[k], r->begin.low[k], bent, &phi[k], &low);
            rate[k] = r->begin.rate[k] + gain;
            if (t[i] == r->kept->reached) phi[k] = r->end.phi[k], rate[k] = r->end.rate[k];
        }
    }
}

static void radau_spread(void *stepper, double phi[], double rate[]) {
    pend_radau_spread(stepper, phi, rate);
}

static void radau_exchange(const void *stepper, const double t[], int count, double work[],
                           double heat[]) {
    const struct radau *r = stepper;
    const struct radau_scalars *kept = r->kept;
    for (int i = 0; i < count; i++) {
        double x = (t[i] - kept->time) / kept->last;
        work[i] = kept->given + radau_energy(r, x, kept->power_in);
        heat[i] = kept->lost + radau_energy(r, x, kept->power_out);
    }
}

static struct pend_stepper_counts radau_counts(const void *stepper) {
    return ((const struct radau *)stepper)->counts;
}

/* values that every step computes anew are not saved */
static void radau_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct radau *r = stepper;
    size_t n = (size_t)r->n;
    double *row[] = {r->begin.phi, r->begin.low, r->begin.rate,
                     r->end.phi,   r->end.low,   r->end.rate};
    pend_stepper_counts_carry(&r->counts, checkpoint);
    pend_checkpoint_int(checkpoint, &r->rough, 1);
    pend_checkpoint_row(checkpoint, &r->kept->time, sizeof *r->kept / sizeof(double));
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        pend_checkpoint_row(checkpoint, row[i], n);
    pend_checkpoint_row(checkpoint, r->bent, STAGES * n);
    pend_checkpoint_row(checkpoint, r->gain, STAGES * n);
}

/* ---- creation and release */

static void *radau_take(char *base, size_t *used, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (bytes + 63) / 64 * 64;
    return part;
}

/* lays out the arrays in a zeroed block; if base is NULL, only counts its bytes */
static size_t radau_place(struct radau *r, char *base) {
    size_t used = 0, n = (size_t)r->n;
    const struct pend_terms *terms = r->loads.terms;
    // sizes in doubles, and the arrays of each size
    const struct {
        size_t count;
        double **at[20];
    } group[] = {
        {n,
         {&r->begin.phi, &r->begin.low, &r->begin.rate, &r->end.phi, &r->end.low, &r->end.rate,
          &r->stage.phi, &r->stage.low, &r->stage.rate, &r->near.phi, &r->near.low, &r->near.rate,
          &r->first, &r->sum[0], &r->sum[1], &r->level_phi, &r->level_rate, &r->off_phi,
          &r->off_rate}},
        {STAGES * n, {&r->bent, &r->gain, &r->try_bent, &r->try_gain, &r->pull, &r->change}},
        {n * n, {&r->by_phi, &r->by_rate}},
        {RADAU_POLES * n * n, {&r->matrix[0], &r->matrix[1]}},
        {n * LANES, {&r->view_phi, &r->view_rate, &r->view_acc, &r->pass.len, &r->pass.mass}},
        {LANES, {&r->pass.gravity}},
        {(size_t)(terms->count + 1) * LANES, {&r->pass.value}},
        {r->kernel->count(terms, r->n, 1) * LANES, {&r->pass.place}}};
    radau_take(base, &used, sizeof *r);
    for (size_t i = 0; i < sizeof group / sizeof *group; i++)
        for (double **const *at = group[i].at; *at; at++)
            **at = radau_take(base, &used, group[i].count * sizeof(double));
    r->kept = radau_take(base, &used, sizeof *r->kept);
    r->swap = radau_take(base, &used, RADAU_POLES * n * sizeof(int));
    r->none.hung = radau_take(base, &used, n);
    r->work = radau_take(base, &used, pend_bodies_bytes(r->tree, terms));
    return used;
}

static void radau_start(struct radau *r, const struct pend_problem *problem) {
    static const double small = 0.01; // initial step as a fraction of the time scale of the motion
    const struct pend_tree *tree = r->tree;
    size_t row = (size_t)r->n * sizeof(double);
    r->pass.tree = tree, r->pass.terms = r->loads.terms, r->pass.order = 1;
    for (int k = 0; k < r->n; k++) {
        r->pass.len[k * LANES] = tree->len[k];
        r->pass.mass[k * LANES] = tree->mass[k];
    }
    r->pass.gravity[0] = r->loads.gravity;
    for (int j = 0; j < r->loads.terms->count; j++) r->pass.value[j * LANES] = r->loads.value[j];
    memcpy(r->end.phi, problem->phi, row);
    memcpy(r->end.rate, problem->rate, row);
    if (problem->phi_low) memcpy(r->end.low, problem->phi_low, row);
    double unit = pend_taylor_first_unit(r->n, &problem->loads, tree->len, problem->rate);
    r->kept->size = small / (1 / unit + pend_loads_rate(&problem->loads, tree));
}

static enum pend_status radau_open(void **stepper, const struct pend_problem *problem,
                                   struct pend_error *error) {
    const struct pend_terms *terms = problem->loads.terms;
    struct radau sketch = {.kernel = pend_kernel_derivatives(),
                           .tree = problem->tree,
                           .loads = problem->loads,
                           .none = {.n = problem->tree->n},
                           .n = problem->tree->n,
                           .gives = terms && !pend_terms_conserve(terms, problem->loads.value),
                           .rough = 1,
                           .start = pend_times_at(&problem->times, 0),
                           .rtol = problem->rtol,
                           .atol = fmax(problem->atol, PEND_METHOD_ATOL_LEAST * problem->rtol)};
    for (int i = 0; i < PEND_TERM_ROWS; i++) sketch.none.row[i] = -1;
    for (int i = 0; i < PEND_TERM_ONES; i++) sketch.none.one[i] = -1;
    if (!terms) sketch.loads.terms = &sketch.none;
    size_t bytes = radau_place(&sketch, NULL);
    struct radau *r = aligned_alloc(64, bytes);
    *stepper = r;
    if (!r)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the stages of %d arms: %zu bytes", sketch.n, bytes);
    memset(r, 0, bytes);
    *r = sketch;
    if (!terms) r->loads.terms = &r->none;
    radau_place(r, (char *)r);
    radau_start(r, problem);
    return PEND_OK;
}

static void radau_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

const struct pend_method pend_method_radau = {
    .name = "radau",
    .summary = "Radau IIA of order 13, implicit, for stiff pendulums: steps as long as the motion "
               "allows, however strong friction and springs are.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_TERMS | PEND_METHOD_FORWARD,
    .rtol_default = 1e-9,
    .rtol_min = 1e-14,
    .rtol_max = 0.1,
    .atol_divisor = 1e6,
    .atol_min = 0,
    .atol_max = 0.1,
    .open = radau_open,
    .step = radau_step,
    .at = radau_at,
    .counts = radau_counts,
    .exchange = radau_exchange,
    .spread = radau_spread,
    .carry = radau_carry,
    .close = radau_close,
};
