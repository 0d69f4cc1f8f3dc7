/* The Taylor method in numbers of about 32 digits: one trajectory, with states rounded to doubles
 * at the interface.
 * Leaves to others: the series, their steps and sums (extended), the time loop (run).
 * Invariant: instants and steps are exact doubles; a step allocates no memory. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/extended/extended.h"
#include "core/integrate/methods/exchange.h"
#include "core/integrate/methods/method.h"
#include "core/tree/turns.h"

struct extended_stepper {
    struct pend_extended *extended;
    const double *value; /* the numbers of the terms, which change from piece to piece */
    int n;
    long steps;
    int gives;     /* whether to integrate the work of drives and the heat of friction */
    double before; /* s, the start of the last step */
    struct pend_exchange exchange;
    double end[]; /* 4 n: the state at the end of the last step */
};

static void extended_stepper_close(void **stepper) {
    struct extended_stepper *x = *stepper;
    if (x) pend_extended_free(&x->extended);
    free(x);
    *stepper = NULL;
}

static enum pend_status extended_stepper_open(void **stepper, const struct pend_problem *problem,
                                              struct pend_error *error) {
    size_t rows = 4 * (size_t)problem->tree->n * sizeof(double);
    struct extended_stepper *x = calloc(1, sizeof *x + rows);
    *stepper = NULL;
    if (!x) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a run");
    enum pend_status status =
        pend_extended_new(&x->extended, problem->tree, problem->loads.terms, problem->rtol,
                          problem->atol, pend_isa_best(), error);
    if (status != PEND_OK) {
        free(x);
        return status;
    }
    // the kernel only reads the initial state
    struct pend_extended_state start = {.phi = (double *)problem->phi,
                                        .phi_low = (double *)problem->phi_low,
                                        .rate = (double *)problem->rate,
                                        .rate_low = (double *)problem->rate_low};
    const struct pend_times *times = &problem->times;
    double span = pend_times_at(times, times->count - 1) - pend_times_at(times, 0);
    pend_extended_start(x->extended, &problem->loads, &start, pend_times_at(times, 0), span);
    x->n = problem->tree->n;
    x->value = problem->loads.value;
    x->gives =
        problem->loads.terms && !pend_terms_conserve(problem->loads.terms, problem->loads.value);
    x->exchange.order = pend_extended_order(x->extended);
    assert(x->exchange.order <= PEND_EXCHANGE_ORDERS);
    *stepper = x;
    return PEND_OK;
}

static void extended_stepper_power(struct extended_stepper *x) {
    struct pend_exchange *exchange = &x->exchange;
    exchange->unit = pend_extended_power(x->extended, exchange->work.series, exchange->heat.series);
    pend_exchange_take(exchange, (pend_extended_time(x->extended) - x->before) / exchange->unit);
}

static enum pend_status extended_stepper_step(void *stepper, double limit, double *reached,
                                              struct pend_error *error) {
    struct extended_stepper *x = stepper;
    double before = pend_extended_time(x->extended);
    if (x->gives && x->steps) pend_exchange_add(&x->exchange);
    x->before = before;
    pend_extended_stop(x->extended, limit);
    pend_extended_value(x->extended, x->value);
    enum pend_extended_stage stage = pend_extended_step(x->extended);
    x->steps++;
    if (x->gives) extended_stepper_power(x);
    *reached = pend_extended_time(x->extended);
    if (stage != PEND_EXTENDED_FAILED) return PEND_OK;
    if (*reached == before)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, before,
                         "the step is too small to advance the time");
    *reached = before;
    return pend_fail(error, PEND_NOT_FINITE, -1, before, "the motion ceased to be finite");
}

static void extended_stepper_at(void *stepper, const double t[], int count,
                                const struct pend_points *points) {
    struct extended_stepper *x = stepper;
    // the array of theta also holds the values from which theta is computed
    struct pend_extended_state to = {
        .phi = points->phi, .phi_low = points->theta, .rate = points->rate};
    pend_extended_at(x->extended, count, t, &to, points->acc, points->force);
    size_t numbers = points->theta ? (size_t)count * (size_t)x->n : 0;
    for (size_t i = 0; i < numbers; i++)
        points->theta[i] = pend_turns_theta(points->phi[i], points->theta[i]);
}

static void extended_stepper_exchange(const void *stepper, const double t[], int count,
                                      double work[], double heat[]) {
    const struct extended_stepper *x = stepper;
    for (int i = 0; i < count; i++) {
        work[i] = heat[i] = 0;
        if (!x->gives) continue;
        double part = (t[i] - x->before) / x->exchange.unit;
        work[i] = pend_given_at(&x->exchange, &x->exchange.work, part);
        heat[i] = pend_given_at(&x->exchange, &x->exchange.heat, part);
    }
}

static struct pend_stepper_counts extended_stepper_counts(const void *stepper) {
    const struct extended_stepper *x = stepper;
    return (struct pend_stepper_counts){.steps = x->steps,
                                        .evaluations = x->steps * pend_extended_order(x->extended)};
}

static struct pend_start extended_stepper_end(const void *stepper) {
    const struct extended_stepper *x = stepper;
    double *at = (double *)x->end;
    size_t n = (size_t)x->n;
    struct pend_extended_state end = {at, at + n, at + 2 * n, at + 3 * n};
    pend_extended_end(x->extended, &end);
    return (struct pend_start){pend_extended_time(x->extended), end.phi, end.phi_low, end.rate,
                               end.rate_low};
}

static void extended_stepper_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct extended_stepper *x = stepper;
    pend_checkpoint_counts(checkpoint, &x->steps, 1);
    pend_extended_value(x->extended, x->value);
    pend_extended_carry(x->extended, checkpoint);
    if (!x->gives) return;
    pend_checkpoint_row(checkpoint, &x->before, 1);
    pend_exchange_carry(&x->exchange, checkpoint);
    // the series of the last step is recomputed from its start
    if (pend_checkpoint_puts(checkpoint) && x->steps) extended_stepper_power(x);
}

const struct pend_method pend_method_taylor_extended = {
    .name = "taylor",
    .summary = "Power series of the motion with about 32 digits: the reference for other answers.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES | PEND_METHOD_THETA | PEND_METHOD_TERMS |
             PEND_METHOD_EXTENDED,
    .rtol_default = 1e-28,
    .rtol_min = PEND_EXTENDED_RTOL_MIN,
    .rtol_max = 1e-1,
    .atol_divisor = 0,
    .atol_min = 0,
    .atol_max = 1,
    .open = extended_stepper_open,
    .step = extended_stepper_step,
    .at = extended_stepper_at,
    .counts = extended_stepper_counts,
    .exchange = extended_stepper_exchange,
    .carry = extended_stepper_carry,
    .end = extended_stepper_end,
    .close = extended_stepper_close,
};
