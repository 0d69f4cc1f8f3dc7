/* The Taylor method: one power series per step; the tolerance determines the order, the last
 * coefficients determine the step.
 * Leaves to others: the series (jets), the time loop (run).
 * Invariant: angles and rates are compensated sums; a step allocates no memory. */
#include "core/integrate/methods/exchange.h"
#include "core/integrate/methods/kernel_exchange.h"
#include "core/integrate/methods/method.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics.h"
#include "core/taylor/jets/jets.h"
#include "core/taylor/taylor_order.h"
#include "core/tree/turns.h"

enum { TAYLOR_STATE = 10, TAYLOR_GROUP = 64 };

/* shortest step, as a fraction of the remaining time */
static const double TAYLOR_LEAST = 1e-14;

struct taylor {
    const struct pend_tree *tree;
    struct pend_loads loads;
    double start;              /* s, the first instant in the time of the request */
    double log_rtol, log_atol; /* binary logarithms */
    double kinetic;       /* J, kinetic energy of the start if it is conserved (several arms without
                           * gravity); 0 = it may change */
    int order, beyond;    /* order of the step; number of known coefficients beyond it */
    int beyond_most;      /* > 0 if a horizon is requested */
    int stands;           /* as `stands` in pend_series */
    double unit;          /* s, unit of the series */
    double next_unit;     /* s, > 0: unit for the next step */
    double time, reached; /* s: start and end of the last step, exact; its length is their
                           * difference */
    struct jets_state begin, end;
    int gives; /* whether work of drives and heat of friction are added up */
    int nodes; /* whether work and heat are computed from the power at nodes */
    struct pend_exchange exchange;
    double *hanging; /* angles from the vertical at the start of a step, then zeros */
    struct pend_jets jets;
    struct pend_stepper_counts counts;
};

static void taylor_view(struct taylor *taylor, double *at) {
    size_t stride = pend_jets_stride(taylor->tree->n);
    double **array[] = {&taylor->begin.phi,      &taylor->begin.phi_low, &taylor->begin.rate,
                        &taylor->begin.rate_low, &taylor->end.phi,       &taylor->end.phi_low,
                        &taylor->end.rate,       &taylor->end.rate_low};
    for (size_t i = 0; i < sizeof array / sizeof array[0]; i++) *array[i] = at + i * stride;
    taylor->hanging = at + 8 * stride;
}

static enum pend_status taylor_open(void **stepper, const struct pend_problem *problem,
                                    struct pend_error *error) {
    enum { BYTES_CAP = 1 << 30 };
    int n = problem->tree->n, order = pend_taylor_order(problem->rtol, 1);
    while (order > PEND_TAYLOR_ORDER_MIN &&
           pend_jets_bytes(problem->tree, problem->loads.terms, order) > BYTES_CAP)
        order--;
    int beyond = problem->accuracy > 0 ? PEND_SERIES_BEYOND : 0;
    size_t head = (sizeof(struct taylor) + 63) / 64 * 64,
           series = pend_jets_bytes(problem->tree, problem->loads.terms, order + beyond);
    size_t answers =
        problem->accuracy > 0 ? pend_jets_answers_bytes(problem->tree, problem->loads.terms) : 0;
    size_t state = TAYLOR_STATE * pend_jets_stride(n) * sizeof(double),
           bytes = head + series + state + answers;
    char *block = *stepper = aligned_alloc(64, bytes);
    if (!block) {
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the power series of %d arms: %zu bytes", n, bytes);
    }
    struct taylor *taylor = (struct taylor *)block;
    *taylor = (struct taylor){
        .tree = problem->tree, .loads = problem->loads, .order = order, .beyond_most = beyond};
    // a stepper can be opened without instants
    taylor->start = problem->times.count ? pend_times_at(&problem->times, 0) : problem->times.start;
    taylor->gives =
        problem->loads.terms && !pend_terms_conserve(problem->loads.terms, problem->loads.value);
    taylor->log_rtol = log2(pend_taylor_target(problem->rtol));
    taylor->log_atol = log2(pend_taylor_atol(problem->atol));
    taylor->next_unit =
        pend_taylor_first_unit(n, &problem->loads, problem->tree->len, problem->rate);
    pend_jets_init(&taylor->jets, problem->tree, &problem->loads, order + beyond, block + head);
    taylor->nodes = taylor->gives && pend_exchange_at_nodes(&taylor->jets);
    if (answers) pend_jets_answers(&taylor->jets, block + head + series + state);
    taylor_view(taylor, (double *)(block + head + series));
    memset(block + head + series, 0, state);
    memcpy(taylor->end.phi, problem->phi, (size_t)n * sizeof(double));
    memcpy(taylor->end.rate, problem->rate, (size_t)n * sizeof(double));
    if (problem->phi_low) memcpy(taylor->end.phi_low, problem->phi_low, (size_t)n * sizeof(double));
    if (problem->rate_low)
        memcpy(taylor->end.rate_low, problem->rate_low, (size_t)n * sizeof(double));
    if (problem->loads.gravity == 0 && n > 1 && !problem->loads.terms)
        taylor->kinetic = pend_kinematics_energy(problem->tree, &(const struct pend_loads){0},
                                                 problem->phi, problem->rate)
                              .kinetic;
    return PEND_OK;
}

static void taylor_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

/* the arm whose coefficients are not finite, in the caller's numbering; -1 if all are finite */
static int taylor_bad_arm(const struct taylor *taylor) {
    for (int j = 0; j <= taylor->order; j++) {
        for (int k = 0; k < taylor->tree->n; k++) {
            if (!isfinite(taylor->jets.rate[pend_jets_place(&taylor->jets, k, j)]))
                return taylor->tree->order[k];
        }
    }
    return -1;
}

/* Expands about the start of step number `step`. After the first steps, only every fourth step
 * computes higher orders for the truncation error; after many steps, its error is used for all
 * four. */
static void taylor_series_of(struct taylor *taylor, long step) {
    enum { FIRST = 24, MANY = 256, EVERY = 4 };
    int looks = step < FIRST || step % EVERY == 0;
    taylor->beyond = looks ? taylor->beyond_most : 0;
    taylor->stands = step <= MANY ? 1 : looks ? EVERY : 0;
    pend_jets_expand(&taylor->jets, &taylor->loads, taylor->unit, &taylor->begin,
                     taylor->order + taylor->beyond);
}

/* Expands about the start of the step with a unit of time near the step. Returns the step in units;
 * NaN on failure. */
static double taylor_expand(struct taylor *taylor, double limit) {
    enum { RANGE = 16, TRIES = 64 };
    double x = NAN, left = fabs(limit - taylor->time);
    for (int i = 0; i < TRIES; i++) {
        taylor_series_of(taylor, taylor->counts.steps);
        taylor->counts.evaluations += taylor->order;
        x = pend_jets_reach(&taylor->jets, taylor->order, taylor->log_rtol, taylor->log_atol);
        // a step may pass the last instant, but at most by its own length
        if (x > 2 * left / fabs(taylor->unit)) x = 2 * left / fabs(taylor->unit);
        if (x >= exp2(-RANGE) && x <= exp2(RANGE)) break;
        taylor->unit *= exp2(x > 1 ? RANGE : -RANGE);
    }
    return x;
}

/* the largest power of two below a step's length; a huge one if the length is almost 0 */
static double taylor_power_of_two(double step) {
    uint64_t bits;
    memcpy(&bits, &step, sizeof bits);
    bits &= UINT64_C(0x7ff) << 52;
    memcpy(&step, &bits, sizeof step);
    return step > 0 ? step : DBL_MIN;
}

/* work and heat since the start of the step, if they are computed at nodes */
static struct exchange_given taylor_given(const struct taylor *taylor, double x) {
    const struct exchange_kernel *kernel = PEND_ISA_PICK(pend_kernel_exchange, taylor->jets.isa);
    return kernel->given(&taylor->jets, &taylor->loads, taylor->unit, taylor->order, x);
}

/* the work of the pivot, J, from orders beyond those of its power, if the power is a series */
static double taylor_beyond(const struct taylor *taylor, double x) {
    const struct bodies_system *s = &taylor->jets.bodies;
    const struct jets_loads *loads = &taylor->jets.loads;
    double square = taylor->unit * taylor->unit, turned[2][PEND_EXCHANGE_ORDERS];
    if (taylor->jets.general) {
        const double *force[2] = {s->pivot_force_x, s->pivot_force_y},
                     *speed[2] = {s->slide_x, s->slide_y};
        if (!(s->need & BODIES_PIVOT)) return 0;
        return pend_exchange_beyond(force, speed, taylor->order, taylor->exchange.order, x) /
               square;
    }
    if (!loads->moves) return 0;
    // components along and across the direction of the first arm
    double C = taylor->jets.system.cosine[0], Z = taylor->jets.system.sine[0];
    for (int j = 0; j < taylor->order; j++) {
        turned[0][j] = C * loads->pivot_force_x[j] - Z * loads->pivot_force_y[j];
        turned[1][j] = Z * loads->pivot_force_x[j] + C * loads->pivot_force_y[j];
    }
    const double *force[2] = {turned[0], turned[1]}, *speed[2] = {loads->slide_x, loads->slide_y};
    return pend_exchange_beyond(force, speed, taylor->order, taylor->exchange.order, x) / square;
}

/* computes the power of the last expansion as series, or its integral up to the end of the step */
static void taylor_power(struct taylor *taylor) {
    /* Orders of the power of a pendulum in the general kernel beyond those of its factors. Each
     * makes the neglected remainder about three times smaller, and a run with every load 3 %
     * slower. */
    enum { TAYLOR_BEYOND = 4 };
    struct pend_exchange *exchange = &taylor->exchange;
    exchange->order = taylor->order + (taylor->jets.general ? TAYLOR_BEYOND : 0);
    exchange->unit = taylor->unit;
    if (taylor->nodes) {
        double x = (taylor->reached - taylor->time) / taylor->unit;
        struct exchange_given given = taylor_given(taylor, x);
        pend_exchange_put(exchange, x, given.work, given.heat);
        return;
    }
    pend_jets_power(&taylor->jets, taylor->unit, taylor->order, exchange->order,
                    exchange->work.series, exchange->heat.series);
    pend_exchange_take(exchange, (taylor->reached - taylor->time) / taylor->unit);
    exchange->work.end += taylor_beyond(taylor, exchange->end);
}

/* Restores the energy of the start at the end of a step. Arms that rotate as one rigid body have
 * the same rounding error in every step, so that their rates would drift by a relative 1e-15 per
 * step: 2e-4 rad in 1e6 steps. Scaling all rates only changes the speed along the same path. */
static void taylor_hold(const struct taylor *taylor) {
    const double most = 1e-6; /* with a larger rtol, the errors of a step exceed rounding */
    const struct jets_state *end = &taylor->end;
    double kinetic =
        pend_kinematics_energy(taylor->tree, &(const struct pend_loads){0}, end->phi, end->rate)
            .kinetic;
    double part = (taylor->kinetic - kinetic) / (2 * kinetic);
    if (!(fabs(part) <= most)) return;
    for (int k = 0; k < taylor->tree->n; k++) {
        double x = end->rate[k], add = end->rate_low[k] + part * x, sum = x + add;
        end->rate_low[k] = add - (sum - x);
        end->rate[k] = sum;
    }
}

static void taylor_arrive(struct taylor *taylor) {
    if (taylor->gives) taylor_power(taylor);
    pend_jets_advance(&taylor->jets, taylor->order, (taylor->reached - taylor->time) / taylor->unit,
                      taylor->unit, &taylor->begin, &taylor->end);
    if (taylor->kinetic > 0) taylor_hold(taylor);
}

static void taylor_cut(void *stepper, double t) {
    struct taylor *taylor = stepper;
    taylor->reached = t;
    taylor_arrive(taylor);
}

static struct pend_start taylor_state(const void *stepper) {
    const struct taylor *taylor = stepper;
    const struct jets_state *end = &taylor->end;
    return (struct pend_start){taylor->reached, end->phi, end->phi_low, end->rate, end->rate_low};
}

static void taylor_put(void *stepper, const struct pend_start *start) {
    struct taylor *taylor = stepper;
    size_t bytes = (size_t)taylor->tree->n * sizeof(double);
    double *to[] = {taylor->end.phi, taylor->end.phi_low, taylor->end.rate, taylor->end.rate_low};
    const double *from[] = {start->phi, start->phi_low, start->rate, start->rate_low};
    taylor->reached = start->time;
    for (int i = 0; i < 4; i++)
        if (from[i])
            memcpy(to[i], from[i], bytes);
        else
            memset(to[i], 0, bytes);
}

static enum pend_status taylor_step(void *stepper, double limit, double *reached,
                                    struct pend_error *error) {
    struct taylor *taylor = stepper;
    struct jets_state swap = taylor->begin;
    taylor->begin = taylor->end;
    taylor->end = swap;
    taylor->time = taylor->reached;
    jets_state_time(&taylor->begin, taylor->start, taylor->time);
    if (taylor->gives && taylor->counts.steps) pend_exchange_add(&taylor->exchange);
    taylor->unit = copysign(taylor->next_unit, limit - taylor->time);
    double x = taylor_expand(taylor, limit);
    if (isnan(x)) {
        return pend_fail(error, PEND_NOT_FINITE, taylor_bad_arm(taylor), taylor->time,
                         "the motion of an arm ceased to be finite");
    }
    taylor->reached = taylor->time + x * taylor->unit;
    // stop here, although the clock, near zero, still advances: such a run would never end
    if (taylor->reached == taylor->time ||
        x * fabs(taylor->unit) < TAYLOR_LEAST * fabs(limit - taylor->time)) {
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, taylor->time, "the step fell to %g s",
                         x * taylor->unit);
    }
    taylor_arrive(taylor);
    taylor->next_unit = taylor_power_of_two(x * taylor->unit);
    taylor->counts.steps++;
    *reached = taylor->reached;
    return PEND_OK;
}

static double *taylor_offset(double *array, size_t base) { return array ? array + base : NULL; }

static void taylor_group(const struct taylor *taylor, const double t[], int count,
                         const struct jets_values *values) {
    double x[TAYLOR_GROUP], inverse = 1 / taylor->unit; // exact, because the unit is a power of two
    for (int i = 0; i < count; i++) x[i] = (t[i] - taylor->time) * inverse;
    pend_jets_values(&taylor->jets, taylor->order, x, count, taylor->unit, &taylor->begin, values);
}

/* The angles from the vertical. For a small swing, the sum of the series is added to the angles
 * from the vertical at the start, which are known to all digits; otherwise this gains nothing. */
static void taylor_theta(const struct taylor *taylor, const double t[], int count,
                         const struct pend_points *points) {
    size_t n = (size_t)taylor->tree->n;
    double inverse = 1 / taylor->unit;
    for (int i = 0; i < count; i++) {
        double *theta = points->theta + (size_t)i * n, *rate = points->rate + (size_t)i * n,
               largest = 0;
        int at_end = t[i] == taylor->reached;
        const struct jets_state *base = at_end ? &taylor->end : &taylor->begin;
        for (size_t k = 0; k < n; k++) {
            theta[k] = points->phi[(size_t)i * n + k] + M_PI_2;
            largest = fmax(largest, fabs(theta[k]));
        }
        if (largest > PEND_TURNS_SMALL) continue;
        double x = (t[i] - taylor->time) * inverse;
        struct jets_state hanging = *base;
        hanging.phi = taylor->hanging;
        hanging.phi_low = taylor->hanging + pend_jets_stride((int)n);
        for (size_t k = 0; k < n; k++) {
            hanging.phi[k] = pend_turns_theta(base->phi[k], base->phi_low[k]);
            hanging.phi_low[k] = 0;
        }
        struct jets_values values = {.phi = theta, .rate = rate};
        if (at_end)
            memcpy(theta, hanging.phi, n * sizeof(double));
        else
            pend_jets_values(&taylor->jets, taylor->order, &x, 1, taylor->unit, &hanging, &values);
    }
}

static void taylor_at(void *stepper, const double t[], int count,
                      const struct pend_points *points) {
    const struct taylor *taylor = stepper;
    size_t n = (size_t)taylor->tree->n;
    int end_alone = count == 1 && t[0] == taylor->reached && !points->acc && !points->force;
    for (int i = 0; i < count && !end_alone; i += TAYLOR_GROUP) {
        size_t base = (size_t)i * n;
        struct jets_values values = {points->phi + base, points->rate + base,
                                     taylor_offset(points->acc, base),
                                     taylor_offset(points->force, base)};
        taylor_group(taylor, t + i, count - i < TAYLOR_GROUP ? count - i : TAYLOR_GROUP, &values);
    }
    for (int i = 0; i < count; i++) {
        if (t[i] != taylor->reached) continue;
        // the compensated sums themselves, from which the next step starts
        memcpy(points->phi + (size_t)i * n, taylor->end.phi, n * sizeof(double));
        memcpy(points->rate + (size_t)i * n, taylor->end.rate, n * sizeof(double));
    }
    if (points->theta) taylor_theta(taylor, t, count, points);
}

static void taylor_exchange(const void *stepper, const double t[], int count, double work[],
                            double heat[]) {
    const struct taylor *taylor = stepper;
    for (int i = 0; i < count; i++) {
        double x = (t[i] - taylor->time) / taylor->unit;
        work[i] = heat[i] = 0;
        if (!taylor->gives) continue;
        if (taylor->nodes && x != taylor->exchange.end) {
            struct exchange_given given = taylor_given(taylor, x);
            work[i] = pend_given_plus(&taylor->exchange.work, given.work);
            heat[i] = pend_given_plus(&taylor->exchange.heat, given.heat);
            continue;
        }
        work[i] = pend_given_at(&taylor->exchange, &taylor->exchange.work, x);
        if (x != taylor->exchange.end) work[i] += taylor_beyond(taylor, x);
        heat[i] = pend_given_at(&taylor->exchange, &taylor->exchange.heat, x);
    }
}

static struct pend_stepper_counts taylor_counts(const void *stepper) {
    const struct taylor *taylor = stepper;
    return taylor->counts;
}

static void taylor_series(const void *stepper, struct pend_series *series) {
    const struct taylor *taylor = stepper;
    *series = (struct pend_series){.jets = &taylor->jets,
                                   .begin = &taylor->begin,
                                   .order = taylor->order,
                                   .beyond = taylor->beyond,
                                   .stands = taylor->stands,
                                   .unit = taylor->unit,
                                   .time = taylor->time,
                                   .reached = taylor->reached};
}

static void taylor_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct taylor *taylor = stepper;
    size_t stride = pend_jets_stride(taylor->tree->n);
    struct jets_state *ends[] = {&taylor->begin, &taylor->end};
    pend_stepper_counts_carry(&taylor->counts, checkpoint);
    double *numbers[] = {&taylor->unit, &taylor->next_unit, &taylor->time, &taylor->reached};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        pend_checkpoint_row(checkpoint, numbers[i], 1);
    for (int i = 0; i < 2; i++) {
        double *rows[] = {ends[i]->phi, ends[i]->phi_low, ends[i]->rate, ends[i]->rate_low};
        for (size_t j = 0; j < sizeof rows / sizeof *rows; j++)
            pend_checkpoint_row(checkpoint, rows[j], stride);
    }
    if (taylor->gives) pend_exchange_carry(&taylor->exchange, checkpoint);
    // the series of the last step is recomputed from its start
    if (!pend_checkpoint_puts(checkpoint) || !taylor->counts.steps) return;
    jets_state_time(&taylor->begin, taylor->start, taylor->time);
    taylor_series_of(taylor, taylor->counts.steps - 1);
    if (taylor->gives) taylor_power(taylor);
}

const struct pend_method pend_method_taylor = {
    .name = "taylor",
    .summary = "Power series of the motion; the tolerance sets order and step: the most accurate "
               "and the fastest.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES | PEND_METHOD_THETA | PEND_METHOD_TERMS,
    .rtol_default = 1e-12,
    .rtol_min = 1e-16,
    .rtol_max = 1e-1,
    .atol_divisor = 0,
    .atol_min = 0,
    .atol_max = 1,
    .extended = &pend_method_taylor_extended,
    .open = taylor_open,
    .step = taylor_step,
    .at = taylor_at,
    .counts = taylor_counts,
    .exchange = taylor_exchange,
    .series = taylor_series,
    .carry = taylor_carry,
    .cut = taylor_cut,
    .end = taylor_state,
    .put = taylor_put,
    .close = taylor_close,
};
