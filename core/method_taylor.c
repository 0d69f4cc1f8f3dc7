/* The Taylor method: one power series a step, its order by the tolerance, its step by the trailing coefficients.
 * Leaves to others: the series (jets), the time loop (run).
 * Invariant: angles and rates are sums with compensation; a step allocates nothing. */
#include "core/method.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/jets.h"

enum { TAYLOR_TRAILING = 4, TAYLOR_LEADING = 4, TAYLOR_ORDER_MIN = 8, TAYLOR_ORDER_MAX = 24, TAYLOR_TILE = 8 };

/* a state whose values are sums of two doubles each */
struct taylor_state {
    double *phi, *phi_low, *rate, *rate_low;
};

struct taylor {
    const struct pend_tree *tree;
    double gravity, rtol, atol;
    int order;
    double unit;          /* s, of the series */
    double next_unit;     /* s, > 0 */
    double time, reached; /* s: start and end of the last step, exact: the step is what lies between */
    struct taylor_state begin, end;
    struct pend_jets jets;
    struct pend_stepper_counts counts;
};

/* sum + add, exactly, as a sum of two */
static double taylor_add(double sum, double add, double *low) {
    double total = sum + add, part = total - sum;
    *low = (sum - (total - part)) + (add - part);
    return total;
}

/* the order that reaches the tolerance at the least cost; fewer where the series would fill the memory */
static int taylor_order(double rtol, int n) {
    enum { BYTES_CAP = 512 << 20 };
    int order = (int)ceil(4 - 0.5 * log(rtol));
    if (order < TAYLOR_ORDER_MIN) order = TAYLOR_ORDER_MIN;
    if (order > TAYLOR_ORDER_MAX) order = TAYLOR_ORDER_MAX;
    while (order > TAYLOR_ORDER_MIN && pend_jets_bytes(n, order) > BYTES_CAP) order--;
    return order;
}

/* a power of two near the time that the fastest arm takes for a radian, as far as the start tells */
static double taylor_first_unit(const struct pend_problem *problem) {
    double fastest = 0;
    for (int k = 0; k < problem->tree->n; k++) {
        fastest = fmax(fastest, fabs(problem->rate[k]));
        fastest = fmax(fastest, sqrt(fabs(problem->gravity) / problem->tree->len[k]));
    }
    return fastest > 0 ? exp2(-floor(log2(fastest))) : 1;
}

static void taylor_view(struct taylor *taylor, double *at) {
    size_t stride = taylor->jets.stride;
    double **array[] = {&taylor->begin.phi, &taylor->begin.phi_low, &taylor->begin.rate, &taylor->begin.rate_low,
                        &taylor->end.phi,   &taylor->end.phi_low,   &taylor->end.rate,   &taylor->end.rate_low};
    for (size_t i = 0; i < sizeof array / sizeof array[0]; i++) *array[i] = at + i * stride;
}

static enum pend_status taylor_open(void **stepper, const struct pend_problem *problem, struct pend_error *error) {
    int n = problem->tree->n, order = taylor_order(problem->rtol, n);
    size_t head = (sizeof(struct taylor) + 63) / 64 * 64, series = pend_jets_bytes(n, order);
    size_t state = pend_jets_bytes(n, 0), bytes = head + series + state;
    char *block = *stepper = aligned_alloc(64, bytes);
    if (!block) {
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the power series of %d arms: %zu bytes", n,
                         bytes);
    }
    struct taylor *taylor = (struct taylor *)block;
    *taylor = (struct taylor){.tree = problem->tree, .gravity = problem->gravity, .order = order};
    taylor->rtol = problem->rtol;
    taylor->atol = problem->atol;
    taylor->next_unit = taylor_first_unit(problem);
    pend_jets_init(&taylor->jets, problem->tree, order, block + head);
    taylor_view(taylor, (double *)(block + head + series));
    memset(block + head + series, 0, state);
    memcpy(taylor->end.phi, problem->phi, (size_t)n * sizeof(double));
    memcpy(taylor->end.rate, problem->rate, (size_t)n * sizeof(double));
    return PEND_OK;
}

static void taylor_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

/* the largest magnitude of a coefficient over the arms; a number that is not finite wins, and names its arm */
static double taylor_norm(const struct taylor *taylor, int j, int *arm) {
    const double *c = taylor->jets.rate + (size_t)j * taylor->jets.stride;
    double norm = 0;
    for (int k = 0; k < taylor->tree->n; k++) {
        if (!(fabs(c[k]) <= norm)) {
            norm = fabs(c[k]);
            *arm = k;
        }
        if (!isfinite(norm)) return INFINITY;
    }
    return norm;
}

/*
 * The longest step, in units, at which the term of order j is below rtol times the motion of the step, judged by its
 * leading terms, or below atol. Infinite where the term is zero.
 */
static double taylor_reach(const struct taylor *taylor, const double leading[], double trailing, int j) {
    if (trailing == 0) return INFINITY;
    double reach = pow(taylor->atol / trailing, 1.0 / (j + 1));
    for (int i = 0; i < TAYLOR_LEADING; i++) {
        reach = fmax(reach, pow(taylor->rtol * leading[i] / ((i + 1) * trailing), 1.0 / (j - i)));
    }
    return reach;
}

/* the step in units, from four trailing orders: a symmetric start makes three of four vanish */
static double taylor_choose(const struct taylor *taylor, int *bad_arm) {
    double leading[TAYLOR_LEADING], reach = INFINITY;
    *bad_arm = -1;
    for (int i = 0; i < TAYLOR_LEADING; i++) {
        leading[i] = taylor_norm(taylor, i, bad_arm);
        if (!isfinite(leading[i])) return NAN;
    }
    for (int j = taylor->order - TAYLOR_TRAILING + 1; j <= taylor->order; j++) {
        double trailing = taylor_norm(taylor, j, bad_arm);
        if (!isfinite(trailing)) return NAN;
        reach = fmin(reach, taylor_reach(taylor, leading, trailing, j));
    }
    return reach;
}

/* what one instant asks of the series: x = t / unit, its powers are formed by Horner */
struct taylor_values {
    double phi[TAYLOR_TILE], rate[TAYLOR_TILE], acc[TAYLOR_TILE], force[TAYLOR_TILE];
};

/* changes of phi and phi', and phi'' and lambda, of the arms a .. a + TAYLOR_TILE - 1 */
static void taylor_horner(const struct taylor *taylor, double x, size_t a, struct taylor_values *v) {
    memset(v, 0, sizeof *v);
    const struct pend_jets *jets = &taylor->jets;
    for (int j = taylor->order; j >= 1; j--) {
        const double *w = jets->rate + (size_t)j * jets->stride + a;
        const double *f = jets->force + (size_t)(j - 1) * jets->stride + a;
        double share = 1.0 / (j + 1);
        for (int i = 0; i < TAYLOR_TILE; i++) {
            v->phi[i] = v->phi[i] * x + w[i] * share;
            v->rate[i] = v->rate[i] * x + w[i];
            v->acc[i] = v->acc[i] * x + w[i] * j;
            v->force[i] = v->force[i] * x + f[i];
        }
    }
    double rate = 1 / taylor->unit, acc = rate * rate;
    for (int i = 0; i < TAYLOR_TILE; i++) {
        v->phi[i] = x * (jets->rate[a + (size_t)i] + x * v->phi[i]);
        v->rate[i] *= x * rate;
        v->acc[i] *= acc;
        v->force[i] *= acc;
    }
}

/* the state at the end of the step, x units after its start */
static void taylor_advance(struct taylor *taylor, double x) {
    const struct taylor_state *from = &taylor->begin, *to = &taylor->end;
    struct taylor_values v;
    for (size_t a = 0; a < (size_t)taylor->tree->n; a += TAYLOR_TILE) {
        taylor_horner(taylor, x, a, &v);
        for (size_t i = 0; i < TAYLOR_TILE; i++) {
            size_t k = a + i;
            to->phi[k] = taylor_add(from->phi[k], v.phi[i] + from->phi_low[k], &to->phi_low[k]);
            to->rate[k] = taylor_add(from->rate[k], v.rate[i] + from->rate_low[k], &to->rate_low[k]);
        }
    }
}

/* expands about the start of the step in a unit of time near the step, which is returned in units; NaN names an arm */
static double taylor_expand(struct taylor *taylor, double limit, int *bad_arm) {
    enum { RANGE = 16, TRIES = 64 };
    const struct taylor_state *from = &taylor->begin;
    double x = NAN, left = fabs(limit - taylor->time);
    for (int i = 0; i < TRIES; i++) {
        pend_jets_expand(&taylor->jets, taylor->gravity, taylor->unit, from->phi, from->phi_low, from->rate,
                         taylor->order);
        taylor->counts.evaluations += taylor->order;
        x = taylor_choose(taylor, bad_arm);
        // a step may pass the last instant, by no more than its own length
        if (x > 2 * left / fabs(taylor->unit)) x = 2 * left / fabs(taylor->unit);
        if (x >= exp2(-RANGE) && x <= exp2(RANGE)) break;
        taylor->unit *= exp2(x > 1 ? RANGE : -RANGE);
    }
    return x;
}

static enum pend_status taylor_step(void *stepper, double limit, double *reached, struct pend_error *error) {
    struct taylor *taylor = stepper;
    struct taylor_state swap = taylor->begin;
    taylor->begin = taylor->end;
    taylor->end = swap;
    taylor->time = taylor->reached;
    taylor->unit = copysign(taylor->next_unit, limit - taylor->time);
    int arm;
    double x = taylor_expand(taylor, limit, &arm);
    if (isnan(x)) {
        return pend_fail(error, PEND_NOT_FINITE, taylor->tree->order[arm], taylor->time,
                         "the motion of an arm ceased to be finite");
    }
    taylor->reached = taylor->time + x * taylor->unit;
    if (taylor->reached == taylor->time) {
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, taylor->time, "the step fell to %g s", x * taylor->unit);
    }
    taylor_advance(taylor, (taylor->reached - taylor->time) / taylor->unit);
    taylor->next_unit = exp2(floor(log2(x * fabs(taylor->unit))));
    taylor->counts.steps++;
    *reached = taylor->reached;
    return PEND_OK;
}

/* one instant at the end of the step: the sums themselves, so that the next step starts where this one ends */
static void taylor_at_end(const struct taylor *taylor, double phi[], double rate[]) {
    size_t bytes = (size_t)taylor->tree->n * sizeof(double);
    memcpy(phi, taylor->end.phi, bytes);
    memcpy(rate, taylor->end.rate, bytes);
}

static void taylor_copy(double to[], const double from[], size_t base, size_t a, size_t count) {
    if (to) memcpy(to + base + a, from, count * sizeof(double));
}

static void taylor_at_one(const struct taylor *taylor, double t, size_t base, const struct pend_points *points) {
    const struct taylor_state *from = &taylor->begin;
    double x = (t - taylor->time) / taylor->unit;
    size_t n = (size_t)taylor->tree->n;
    for (size_t a = 0; a < n; a += TAYLOR_TILE) {
        size_t count = n - a < TAYLOR_TILE ? n - a : TAYLOR_TILE;
        struct taylor_values v;
        taylor_horner(taylor, x, a, &v);
        for (size_t i = 0; i < TAYLOR_TILE; i++) {
            v.phi[i] = from->phi[a + i] + (v.phi[i] + from->phi_low[a + i]);
            v.rate[i] = from->rate[a + i] + (v.rate[i] + from->rate_low[a + i]);
        }
        taylor_copy(points->phi, v.phi, base, a, count);
        taylor_copy(points->rate, v.rate, base, a, count);
        taylor_copy(points->acc, v.acc, base, a, count);
        taylor_copy(points->force, v.force, base, a, count);
    }
}

static void taylor_at(void *stepper, const double t[], int count, const struct pend_points *points) {
    const struct taylor *taylor = stepper;
    for (int i = 0; i < count; i++) {
        size_t base = (size_t)i * (size_t)taylor->tree->n;
        taylor_at_one(taylor, t[i], base, points);
        if (t[i] == taylor->reached) taylor_at_end(taylor, points->phi + base, points->rate + base);
    }
}

static struct pend_stepper_counts taylor_counts(const void *stepper) {
    const struct taylor *taylor = stepper;
    return taylor->counts;
}

const struct pend_method pend_method_taylor = {
    .name = "taylor",
    .summary = "Power series of the motion, order and step by the tolerance: the most accurate and the fastest.",
    .flags = PEND_METHOD_TOLERANCES | PEND_METHOD_SERIES,
    .rtol_default = 1e-12,
    .rtol_min = 1e-16,
    .rtol_max = 1e-1,
    .atol_default = 0,
    .atol_min = 0,
    .atol_max = 1,
    .open = taylor_open,
    .step = taylor_step,
    .at = taylor_at,
    .counts = taylor_counts,
    .close = taylor_close,
};
