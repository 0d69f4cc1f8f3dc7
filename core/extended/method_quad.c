/* The Taylor method in numbers of 62 digits, for motions that need more than 32 digits and as the
 * reference for those with 32.
 * Leaves to others: the series (kernel_quad), the time loop (run).
 * Invariant: a step allocates nothing; the same bits in every instruction set. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/extended/kernel_quad.h"
#include "core/integrate/methods/exchange.h"
#include "core/integrate/methods/method.h"
#include "core/taylor/taylor_order.h"

enum { PARTS = 4, QUAD_ARMS_MOST = 256 };

struct quad_stepper {
    struct quad_series series;
    const struct quad_kernel *kernel;
    double log_rtol, log_atol;       /* binary logarithms */
    double next_unit, time, reached; /* s: of the next step, > 0; the last step's ends */
    struct pend_stepper_counts counts;
    int gives; /* the work of drives and the heat of friction are added up */
    struct pend_exchange exchange;
};

static const struct quad_kernel *quad_kernel(enum pend_isa isa) {
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_kernel_quad_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_quad_avx2;
#endif
    (void)isa;
    return &pend_kernel_quad_base;
}

/* The order from which coefficients need but 32 digits: the order at which the terms of a step
 * have fallen by the ratio of that precision to the target. The slowest to fall are those of an
 * exponential, x^j / j!, as in `extended`. */
static int quad_precise(double target, int order) {
    double bits = -log2(target), log_x = (lgamma(order + 2) / M_LN2 - bits) / (order + 1);
    int j = 1;
    while (j < order && lgamma(j + 1) / M_LN2 - j * log_x < bits - 104 + 6) j++;
    return j;
}

static void quad_stepper_fill(double to[], const double high[], const double low[], int n) {
    for (int k = 0; k < n; k++) {
        double *part = to + PARTS * (size_t)k;
        part[0] = high[k];
        part[1] = low ? low[k] : 0;
        part[2] = part[3] = 0;
    }
}

static enum pend_status quad_stepper_open(void **stepper, const struct pend_problem *problem,
                                          struct pend_error *error) {
    const struct quad_kernel *kernel = quad_kernel(pend_isa_best());
    double target = 0.01 * problem->rtol;
    int n = problem->tree->n, order = (int)ceil(6 - 0.45 * log(target));
    size_t head = (sizeof(struct quad_stepper) + 63) / 64 * 64, row = PARTS * (size_t)n;
    size_t numbers = (kernel->count(problem->loads.terms, n, order) + 7) / 8 * 8,
           bytes = head + (numbers + 4 * row + 7) / 8 * 64;
    *stepper = NULL;
    if (n > QUAD_ARMS_MOST)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "62 digits are for trees of at most %d arms, got %d: a step of more would take seconds",
            QUAD_ARMS_MOST, n);
    char *block = aligned_alloc(64, bytes);
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the series of %d arms: %zu bytes", n, bytes);
    memset(block, 0, bytes);
    struct quad_stepper *q = (struct quad_stepper *)(void *)block;
    double *at = (double *)(void *)(block + head);
    *q = (struct quad_stepper){
        .kernel = kernel,
        .log_rtol = log2(target),
        .next_unit = pend_taylor_first_unit(n, &problem->loads, problem->tree->len, problem->rate)};
    q->log_atol = problem->atol > 0 ? log2(pend_taylor_atol(problem->atol)) : -1e5;
    q->series = (struct quad_series){.tree = problem->tree,
                                     .order = order,
                                     .loads = problem->loads,
                                     .start = pend_times_at(&problem->times, 0),
                                     .numbers = at,
                                     .unit = q->next_unit,
                                     .precise = quad_precise(target, order)};
    q->series.phi = at + numbers;
    q->series.rate = q->series.phi + row;
    q->series.phi_end = q->series.rate + row;
    q->series.rate_end = q->series.phi_end + row;
    q->gives =
        problem->loads.terms && !pend_terms_conserve(problem->loads.terms, problem->loads.value);
    assert(order <= PEND_EXCHANGE_ORDERS);
    quad_stepper_fill(q->series.phi_end, problem->phi, problem->phi_low, n);
    quad_stepper_fill(q->series.rate_end, problem->rate, problem->rate_low, n);
    *stepper = q;
    return PEND_OK;
}

static void quad_stepper_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

/* the power of the last step, as series */
static void quad_stepper_power(struct quad_stepper *q) {
    q->exchange.order = q->series.order, q->exchange.unit = q->series.unit;
    q->kernel->power(&q->series, q->exchange.work.series, q->exchange.heat.series);
    pend_exchange_take(&q->exchange, (q->reached - q->time) / q->exchange.unit);
}

static enum pend_status quad_stepper_step(void *stepper, double limit, double *reached,
                                          struct pend_error *error) {
    struct quad_stepper *q = stepper;
    struct quad_series *s = &q->series;
    double *phi = s->phi, *rate = s->rate;
    s->phi = s->phi_end, s->rate = s->rate_end;
    s->phi_end = phi, s->rate_end = rate;
    if (q->gives && q->counts.steps) pend_exchange_add(&q->exchange);
    q->time = q->reached;
    s->time = q->time;
    s->unit = copysign(q->next_unit, limit - q->time);
    double x = q->kernel->expand(s, q->log_rtol, q->log_atol);
    q->counts.evaluations += s->order;
    if (isnan(x))
        return pend_fail(error, PEND_NOT_FINITE, -1, q->time, "the motion ceased to be finite");
    // a step may pass the last instant, by no more than its own length
    x = fmin(x, 2 * fabs(limit - q->time) / fabs(s->unit));
    q->reached = q->time + x * s->unit;
    if (q->reached == q->time)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, q->time, "the step fell to %g s",
                         x * s->unit);
    q->kernel->advance(s, q->time, q->reached);
    q->next_unit = exp2(floor(log2(fabs(x * s->unit))));
    if (q->gives) quad_stepper_power(q);
    q->counts.steps++;
    *reached = q->reached;
    return PEND_OK;
}

static double *quad_offset(double *array, size_t base) { return array ? array + base : NULL; }

static void quad_stepper_at(void *stepper, const double t[], int count,
                            const struct pend_points *points) {
    const struct quad_stepper *q = stepper;
    for (int i = 0; i < count; i++) {
        size_t base = (size_t)i * (size_t)q->series.tree->n;
        const struct quad_values values = {
            points->phi + base, points->rate + base, quad_offset(points->acc, base),
            quad_offset(points->force, base), quad_offset(points->theta, base)};
        q->kernel->values(&q->series, q->time, t[i], &values);
    }
}

static void quad_stepper_exchange(const void *stepper, const double t[], int count, double work[],
                                  double heat[]) {
    const struct quad_stepper *q = stepper;
    for (int i = 0; i < count; i++) {
        work[i] = heat[i] = 0;
        if (!q->gives) continue;
        double x = (t[i] - q->time) / q->exchange.unit;
        work[i] = pend_given_at(&q->exchange, &q->exchange.work, x);
        heat[i] = pend_given_at(&q->exchange, &q->exchange.heat, x);
    }
}

static struct pend_stepper_counts quad_stepper_counts(const void *stepper) {
    return ((const struct quad_stepper *)stepper)->counts;
}

static void quad_stepper_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct quad_stepper *q = stepper;
    struct quad_series *s = &q->series;
    double *numbers[] = {&s->unit, &q->next_unit, &q->time, &q->reached};
    double *rows[] = {s->phi, s->rate, s->phi_end, s->rate_end};
    pend_stepper_counts_carry(&q->counts, checkpoint);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        pend_checkpoint_row(checkpoint, numbers[i], 1);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        pend_checkpoint_row(checkpoint, rows[i], PARTS * (size_t)s->tree->n);
    if (q->gives) pend_exchange_carry(&q->exchange, checkpoint);
    // the series of the last step follows from its start
    s->time = q->time;
    if (!pend_checkpoint_puts(checkpoint) || !q->counts.steps) return;
    q->kernel->expand(s, q->log_rtol, q->log_atol);
    if (q->gives) quad_stepper_power(q);
}

const struct pend_method pend_method_taylor_quad = {
    .name = "taylor",
    .summary = "Power series of the motion in numbers of about 62 digits: for horizons beyond "
               "those of 32.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES | PEND_METHOD_THETA | PEND_METHOD_TERMS,
    .rtol_default = 1e-56,
    .rtol_min = 1e-58,
    .rtol_max = 1e-16,
    .atol_divisor = 0,
    .atol_min = 0,
    .atol_max = 1e-16,
    .open = quad_stepper_open,
    .step = quad_stepper_step,
    .at = quad_stepper_at,
    .counts = quad_stepper_counts,
    .exchange = quad_stepper_exchange,
    .carry = quad_stepper_carry,
    .close = quad_stepper_close,
};
