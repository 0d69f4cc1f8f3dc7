#include "core/integrate/run/horizon.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/neighbour.h"
#include "core/taylor/jets/jets.h"
#include "core/taylor/taylor_order.h"

/* The source of the errors of single steps: the power series of the step; a second solution of the
 * step by a power series; the truncation of numbers of 32 digits; or the method itself. */
enum horizon_way { HORIZON_SERIES, HORIZON_ANEW, HORIZON_EXTENDED, HORIZON_METHOD };

enum {
    HORIZON_ANEW_ORDER = 30, /* order of the second solution of a step */
    HORIZON_STATES = 8,
    HORIZON_ROWS = 2 + HORIZON_STATES
};

static const double HORIZON_SPREAD = 0.1, HORIZON_REGULAR = 150, HORIZON_LONG = 0.1;
static const double HORIZON_ROUNDING = 2 * 0x1p-53; /* rounding error of a step, relative to its
                                                     * increments */
static const double HORIZON_ANEW_TARGET = 1e-17;    /* truncation error of the second solution */
static const double HORIZON_LEFT = 2;               /* factor by which truncation may exceed the
                                                     * predicted one */

struct pend_horizon {
    struct pend_problem problem; /* the members phi .. rate_low are not valid after creation */
    const struct pend_method *method;
    enum horizon_way way;
    double grade;  /* factor from an error to its ratio to the allowed error */
    double target; /* limit of the first neglected term, relative to the step's motion */
    double cart;   /* m, divisor that makes a cart's position comparable with angles: length of the
                    * shortest arm; 0 without a cart */
    int lost;
    double end_time;    /* s, relative, time of the last instant */
    double held;        /* s, relative: once the accuracy is lost, the time up to which it held */
    double time, ratio; /* s, relative: start of the step; error there over the allowed error */
    double end_ratio;   /* this ratio at the end of the previous step; negative if unknown */
    double fastest, strongest; /* rad/s and N, the largest rate and force so far */
    double settled;     /* s, relative: the time up to which steps were solved a second time */
    double reach, unit; /* s, > 0, for the last series of a second solution: the time over which it
                         * is accurate; its unit */
    double *phi, *rate; /* the estimated errors, rad and rad/s */
    double *left_rate, *left_phi; /* truncation error of a step */
    struct jets_state begin, end; /* second solution: start and end of a step */
    struct pend_jets anew;
    struct pend_neighbour near;
};

PEND_VALIDATOR horizon_valid(const struct pend_horizon *horizon) {
    return (horizon->lost == 0 || horizon->lost == 1) && horizon->grade > 0;
}

/* ---- creation and release */

static enum horizon_way horizon_way(const struct pend_method *method) {
    if (method->series) return HORIZON_SERIES;
    if (method->spread) return HORIZON_METHOD;
    return method->flags & PEND_METHOD_EXTENDED ? HORIZON_EXTENDED : HORIZON_ANEW;
}

static void horizon_view(struct pend_horizon *horizon, double *at, size_t stride) {
    struct jets_state *begin = &horizon->begin, *end = &horizon->end;
    double **row[HORIZON_ROWS] = {&horizon->phi, &horizon->rate,   &begin->phi, &begin->phi_low,
                                  &begin->rate,  &begin->rate_low, &end->phi,   &end->phi_low,
                                  &end->rate,    &end->rate_low};
    for (size_t i = 0; i < HORIZON_ROWS; i++) *row[i] = at + i * stride;
}

/* sets the rounding errors of the initial state, for methods that use only doubles */
static void horizon_start(struct pend_horizon *horizon, const struct pend_problem *problem) {
    size_t n = (size_t)problem->tree->n;
    memcpy(horizon->begin.phi, problem->phi, n * sizeof(double));
    memcpy(horizon->begin.rate, problem->rate, n * sizeof(double));
    if (horizon->way != HORIZON_ANEW && horizon->way != HORIZON_METHOD) return;
    for (size_t k = 0; k < n; k++) {
        if (problem->phi_low) horizon->phi[k] = -problem->phi_low[k];
        if (problem->rate_low) horizon->rate[k] = -problem->rate_low[k];
    }
}

enum pend_status pend_horizon_new(struct pend_horizon **horizon, const struct pend_method *method,
                                  const struct pend_problem *problem, struct pend_error *error) {
    const struct pend_tree *tree = problem->tree;
    const struct pend_terms *terms = problem->loads.terms;
    enum horizon_way way = horizon_way(method);
    size_t stride = pend_jets_stride(tree->n), head = (sizeof **horizon + 63) / 64 * 64;
    size_t rows = (HORIZON_ROWS + 2) * stride * sizeof(double);
    int own = way == HORIZON_ANEW || way == HORIZON_EXTENDED;
    size_t answers = pend_jets_answers_bytes(tree, terms),
           anew = own ? pend_jets_bytes(tree, terms, HORIZON_ANEW_ORDER) : 0;
    int order = own ? HORIZON_ANEW_ORDER : pend_taylor_order(problem->rtol, 1);
    size_t series = answers || way == HORIZON_METHOD ? 0 : pend_neighbour_bytes(problem, order);
    char *block = aligned_alloc(64, head + rows + series + anew + answers);
    *horizon = (struct pend_horizon *)block;
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a neighbour of %d arms",
                         tree->n);
    char *behind = block + head + rows;
    memset(block, 0, head + rows);
    struct pend_horizon *made = *horizon;
    made->problem = *problem;
    made->method = method;
    made->way = way;
    made->grade = PEND_HORIZON_MARGIN / problem->accuracy;
    made->unit = 0x1p-5;
    made->cart = pend_terms_cart(problem->loads.terms) ? INFINITY : 0;
    for (int k = 1; k < problem->tree->n; k++) made->cart = fmin(made->cart, problem->tree->len[k]);
    made->end_ratio = -1;
    made->end_time = pend_times_at(&problem->times, problem->times.count - 1) -
                     pend_times_at(&problem->times, 0);
    made->target = fmax(method->flags & PEND_METHOD_TOLERANCES ? problem->rtol / 100 : 0, 0x1p-106);
    horizon_view(made, (double *)(block + head), stride);
    made->left_rate = (double *)behind - 2 * stride;
    made->left_phi = made->left_rate + stride;
    horizon_start(made, problem);
    if (series) pend_neighbour_init(&made->near, &made->problem, order, made->cart, behind);
    if (own)
        pend_jets_init(&made->anew, tree, &problem->loads, HORIZON_ANEW_ORDER, behind + series);
    if (own && answers) pend_jets_answers(&made->anew, behind + series + anew);
    return PEND_OK;
}

void pend_horizon_free(struct pend_horizon **horizon) {
    free(*horizon);
    *horizon = NULL;
}

/* ---- propagation of errors */

/* the largest error of angles and rates, relative to the allowed error */
static double horizon_ratio(struct pend_horizon *horizon, const double rate[]) {
    double angle = 0, speed = 0, sum = 0, fastest = horizon->fastest;
    for (int k = 0; k < horizon->problem.tree->n; k++) {
        double share = pend_neighbour_share(horizon->cart, k);
        double turned = fabs(horizon->phi[k]) * share, faster = fabs(horizon->rate[k]) * share;
        sum += turned + faster;
        fastest = pend_larger(fabs(rate[k]) * share, fastest);
        angle = pend_larger(turned, angle);
        speed = pend_larger(faster, speed);
    }
    horizon->fastest = fastest;
    if (!isfinite(sum)) return INFINITY;
    return horizon->grade * pend_larger(angle, fastest > 0 ? speed / fastest : 0);
}

/* Records the error at an instant. If it is too large, the accuracy was lost after the previous
 * instant; the time between is interpolated by a power law. */
static void horizon_note(struct pend_horizon *horizon, double time, double ratio) {
    if (ratio <= 1) return;
    double part = horizon->ratio > 0 && isfinite(ratio)
                      ? log(horizon->ratio) / (log(horizon->ratio) - log(ratio))
                      : 0;
    horizon->held = horizon->time + (part > 0 && part < 1 ? part : 0) * (time - horizon->time);
    horizon->lost = 1;
}

/* The largest allowed size of the last terms in the series of an error, relative to the error.
 * Truncation causes a spurious growth in each of the N steps of a run. In a regular motion, where
 * errors grow like t, the total must be small compared with 1, so a fraction of 1 / N is enough. A
 * short run needs less accuracy. */
static double horizon_least(const struct pend_horizon *horizon, double length) {
    double step = fabs(length / horizon->end_time), part = HORIZON_REGULAR * step;
    // a method without a series has larger errors from the start, and costs more anyway
    double least = horizon->way == HORIZON_SERIES ? 1 : 0.01;
    return least * fmax(fmin(HORIZON_SPREAD, part * part * part), HORIZON_LONG * step);
}

/* Computes the error at the end of a step from that at its start, with the motion's own series if
 * it supports this, otherwise with a neighbour. Returns the error of the forces at the start, N. */
static double horizon_carry(struct pend_horizon *horizon, const struct pend_series *step,
                            double x) {
    const struct pend_loads *loads = &horizon->problem.loads;
    double least = horizon_least(horizon, x * step->unit);
    double inverse = 1 / step->unit;
    for (int k = 0; k < horizon->problem.tree->n; k++) {
        double force = fabs(step->jets->force[pend_jets_place(step->jets, k, 0)]);
        horizon->strongest = pend_larger(force * (inverse * inverse), horizon->strongest);
    }
    if (!pend_jets_spreads(step->jets))
        return pend_neighbour_spread(&horizon->near, step, x, least, horizon->phi, horizon->rate);
    // errors of an ideal tree do not decay, so in a short run the lowest order is enough
    struct jets_spread how = {.order = least < HORIZON_SPREAD ? step->order : JETS_SPREAD,
                              .x = x,
                              .unit = step->unit,
                              .least = least};
    return pend_jets_spread(step->jets, loads, &how, horizon->phi, horizon->rate);
}

/* Propagates the error from the start of a step to its end. Checks the error at the start as soon
 * as the forces there are known. Returns the contribution of the forces to the error ratio. */
static double horizon_pass(struct pend_horizon *horizon, const struct pend_series *step, double x,
                           double time) {
    double ratio = horizon->end_ratio, part = 0;
    if (ratio < 0) ratio = horizon_ratio(horizon, step->begin->rate);
    horizon->end_ratio = -1;
    double force = horizon_carry(horizon, step, x);
    if (horizon->strongest > 0) part = force * horizon->grade / horizon->strongest;
    horizon_note(horizon, time, pend_larger(part, ratio));
    if (horizon->lost) return 0;
    horizon->time = time;
    horizon->ratio = pend_larger(part, ratio);
    return ratio > 0 ? part / ratio : 0;
}

/* ---- errors of single steps */

/* increases the magnitude of an error by |a| */
static void horizon_more(double *error, double a) { *error += copysign(a, *error); }

/* adds truncation and rounding of a power-series step, and of the steps that it represents */
static void horizon_series_error(struct pend_horizon *horizon, const struct pend_series *step,
                                 double x) {
    const struct pend_tree *tree = horizon->problem.tree;
    const struct pend_jets *jets = step->jets;
    double length = fabs(x * step->unit), inverse = 1 / step->unit, most = 0,
           turn = step->stands * fabs(x) * HORIZON_ROUNDING, left = step->stands * HORIZON_LEFT;
    pend_jets_left(jets, step->order, step->beyond, x, horizon->left_rate, horizon->left_phi);
    for (int k = 0; k < tree->n; k++)
        most = pend_larger(most, tree->len[k] * fabs(jets->rate[pend_jets_place(jets, k, 1)]));
    most *= turn * fabs(inverse);
    for (int k = 0; k < tree->n; k++) {
        double faster = left * horizon->left_rate[k] * inverse,
               turned = left * horizon->left_phi[k] * x, push = most * jets->system.inv_len[k],
               shift = push / 2 * length + fabs(jets->rate[pend_jets_place(jets, k, 0)]) * turn;
        // a rounding error has no known sign; here a smaller contribution with a sign could cancel
        // it, so its magnitude is added
        if (push < fabs(faster)) {
            horizon->rate[k] -= faster;
            horizon->phi[k] -= turned;
        } else {
            push += fabs(faster);
            shift += fabs(turned);
        }
        horizon_more(&horizon->rate[k], push);
        horizon_more(&horizon->phi[k], shift);
    }
}

static void horizon_series_step(struct pend_horizon *horizon, const struct pend_series *step,
                                const double rate[]) {
    double x = (step->reached - step->time) / step->unit;
    double part = horizon_pass(horizon, step, x, step->time);
    if (horizon->lost) return;
    if (step->stands) horizon_series_error(horizon, step, x);
    horizon->end_ratio = horizon_ratio(horizon, rate);
    horizon_note(horizon, step->reached, horizon->end_ratio * pend_larger(1, part));
}

/* Expands about the start of a step for the second solution. Returns how far the series is
 * accurate, in units. */
static double horizon_expand(struct pend_horizon *horizon, double *unit, double left) {
    enum { RANGE = 16, TRIES = 64 };
    double x = NAN;
    for (int i = 0; i < TRIES; i++) {
        pend_jets_expand(&horizon->anew, &horizon->problem.loads, *unit, &horizon->begin,
                         HORIZON_ANEW_ORDER);
        x = pend_jets_reach(&horizon->anew, HORIZON_ANEW_ORDER, log2(HORIZON_ANEW_TARGET),
                            -INFINITY);
        horizon->reach = x * fabs(*unit);
        if (x > fabs(left / *unit)) x = fabs(left / *unit);
        if (!(x < exp2(-RANGE) || x > exp2(RANGE))) break;
        *unit *= exp2(x > 1 ? RANGE : -RANGE);
    }
    return x;
}

/* adds the truncation error of numbers of 32 digits in a step, relative to the step's increments */
static void horizon_extended_error(struct pend_horizon *horizon, double length) {
    const struct pend_tree *tree = horizon->problem.tree;
    const struct jets_state *begin = &horizon->begin, *end = &horizon->end;
    double most = 0;
    for (int k = 0; k < tree->n; k++)
        most = fmax(most, tree->len[k] * fabs(end->rate[k] - begin->rate[k]));
    for (int k = 0; k < tree->n; k++) {
        double push = most / tree->len[k];
        horizon_more(&horizon->rate[k], push * horizon->target);
        horizon_more(&horizon->phi[k],
                     (push * length + fabs(end->phi[k] - begin->phi[k])) * horizon->target);
    }
}

/* Solves from the last checked instant to this one a second time, by power series. The difference
 * of the two states is the error of the method. */
static void horizon_anew(struct pend_horizon *horizon, double reached, const double phi[],
                         const double rate[]) {
    struct jets_state *begin = &horizon->begin, *end = &horizon->end;
    size_t bytes = (size_t)horizon->problem.tree->n * sizeof(double);
    double now = horizon->settled, part = 0;
    while (now != reached && !horizon->lost) {
        jets_state_time(begin, pend_times_at(&horizon->problem.times, 0), now);
        double unit = copysign(horizon->unit, reached - now),
               x = horizon_expand(horizon, &unit, reached - now);
        double next = now + x * unit;
        if (isnan(x) || next == now || fabs(reached - next) < 1e-9 * fabs(reached - now))
            next = reached;
        x = (next - now) / unit;
        struct pend_series step = {
            .jets = &horizon->anew, .begin = begin, .order = HORIZON_ANEW_ORDER, .unit = unit};
        part = horizon_pass(horizon, &step, x, now);
        if (horizon->lost) return;
        pend_jets_advance(&horizon->anew, HORIZON_ANEW_ORDER, x, unit, begin, end);
        if (horizon->way == HORIZON_EXTENDED) horizon_extended_error(horizon, fabs(x * unit));
        struct jets_state swap = *begin;
        *begin = *end;
        *end = swap;
        horizon->unit = exp2(floor(log2(fabs(x * unit))));
        now = next;
    }
    for (int k = 0; k < horizon->problem.tree->n && horizon->way == HORIZON_ANEW; k++) {
        horizon->phi[k] += (phi[k] - begin->phi[k]) - begin->phi_low[k];
        horizon->rate[k] += (rate[k] - begin->rate[k]) - begin->rate_low[k];
    }
    memcpy(begin->phi, phi, bytes);
    memcpy(begin->rate, rate, bytes);
    memset(begin->phi_low, 0, bytes);
    memset(begin->rate_low, 0, bytes);
    horizon->settled = reached;
    horizon_note(horizon, reached, horizon_ratio(horizon, rate) * pend_larger(1, part));
}

void pend_horizon_step(struct pend_horizon *horizon, void *stepper, double reached,
                       const double phi[], const double rate[]) {
    static const double often = 0.7; // a series that was used for longer than this
                                     // fraction of its range is replaced by a new one
    struct pend_series step;
    assert(horizon_valid(horizon));
    if (horizon->lost) return;
    if (horizon->way == HORIZON_SERIES) {
        horizon->method->series(stepper, &step);
        horizon_series_step(horizon, &step, rate);
    } else if (horizon->way == HORIZON_METHOD) {
        horizon->method->spread(stepper, horizon->phi, horizon->rate);
        double ratio = horizon_ratio(horizon, rate);
        horizon_note(horizon, reached, ratio);
        horizon->time = reached, horizon->ratio = ratio;
    } else if (fabs(reached - horizon->settled) >= often * horizon->reach ||
               fabs(reached) >= fabs(horizon->end_time) ||
               pend_pieces_ends(horizon->method, stepper)) {
        horizon_anew(horizon, reached, phi, rate);
    }
    assert(horizon_valid(horizon));
}

/* ---- the horizon */

double pend_horizon_held(const struct pend_horizon *horizon, double reached) {
    assert(horizon_valid(horizon));
    return horizon->lost ? horizon->held : reached;
}

double pend_horizon_until(const struct pend_horizon *horizon) {
    assert(horizon_valid(horizon));
    const struct pend_times *times = &horizon->problem.times;
    double start = pend_times_at(times, 0);
    long first = 0, last = times->count - 1;
    if (!horizon->lost) return pend_times_at(times, last);
    // invariant: at instant `first` the accuracy holds; at instant `last` it may not
    while (first < last) {
        long middle = first + (last - first + 1) / 2;
        if (fabs(pend_times_at(times, middle) - start) <= fabs(horizon->held))
            first = middle;
        else
            last = middle - 1;
    }
    return pend_times_at(times, first);
}

enum pend_status pend_horizon_carry(struct pend_horizon *horizon,
                                    struct pend_checkpoint *checkpoint) {
    size_t stride = pend_jets_stride(horizon->problem.tree->n);
    struct pend_neighbour *near = &horizon->near;
    double *number[] = {&horizon->held,      &horizon->time,    &horizon->ratio, &horizon->fastest,
                        &horizon->strongest, &horizon->settled, &horizon->reach, &horizon->unit};
    double *row[] = {horizon->phi, horizon->rate, horizon->begin.phi, horizon->begin.rate};
    pend_checkpoint_int(checkpoint, &horizon->lost, 1);
    pend_checkpoint_int(checkpoint, &near->order, near->jets.order_cap);
    for (size_t i = 0; i < sizeof number / sizeof *number; i++)
        pend_checkpoint_row(checkpoint, number[i], 1);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        pend_checkpoint_row(checkpoint, row[i], stride);
    // checks that the second solution stays near the steps' range, and costs no more than the run
    // itself
    int good = fabs(horizon->settled) <= 4 * fabs(horizon->end_time) && horizon->unit > 0 &&
               isfinite(horizon->unit) && (near->order >= JETS_SPREAD || !near->jets.order_cap);
    return good && !isnan(horizon->held) && !isnan(horizon->ratio) ? PEND_OK : PEND_INVALID;
}
