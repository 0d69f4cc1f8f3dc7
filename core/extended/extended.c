#include "core/extended/extended.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/extended/kernel_extended.h"
#include "core/taylor/taylor_order.h"

/* one trajectory in its lane */
struct extended_seat {
    enum pend_extended_lane state;
    int empty; /* never started */
    int taken; /* by a member of a run */
    long member, steps;
    double unit; /* s, of the last step */
};

struct pend_extended {
    const struct pend_tree *tree;
    const struct extended_kernel *kernel;
    struct extended_lanes lanes;
    struct extended_seat seat[EXTENDED_WIDTH_MAX];
    struct pend_member member;
    struct pend_extended_state end; /* of a member */
};

/* arrays with values for every lane, with one value a lane, and with one for all lanes */
enum { EXTENDED_LANED = 10, EXTENDED_SINGLE = 6, EXTENDED_FLAT = 8, EXTENDED_BYTES_CAP = 1 << 30 };

/* ---- orders */

/* the first term of a step that is left out, relative to the motion of the step: a hundredth of
 * rtol, but not below the last digit of the numbers */
static double extended_target(double rtol) { return fmax(0.01 * rtol, 0x1p-106); }

static int extended_order(double target) { return (int)ceil(6 - 0.45 * log(target)); }

/*
 * The order above which coefficients need but one double: the order at which the terms of a step
 * have fallen by the ratio of a double's precision to the target. The slowest to fall are those of
 * an exponential, x^j / j!, with x such that the first term left out is the target.
 */
static int extended_precise(double target, int order) {
    double bits = -log2(target), log_x = (lgamma(order + 2) / M_LN2 - bits) / (order + 1);
    int j = 1;
    while (j < order && lgamma(j + 1) / M_LN2 - j * log_x < bits - 53 + 4) j++;
    return j < order ? j : order;
}

/* ---- memory */

/* allocates `count` doubles of a block, a multiple of 64 bytes; with base NULL it only counts
 * them */
static double *extended_take(char *base, size_t *used, size_t count) {
    double *piece = base ? (double *)(void *)(base + *used) : NULL;
    *used += (count + 7) / 8 * 8 * sizeof(double);
    return piece;
}

static size_t extended_place(struct pend_extended *e, char *base) {
    struct extended_lanes *l = &e->lanes;
    size_t n = (size_t)l->n, width = (size_t)e->kernel->width, used = 0;
    double **laned[EXTENDED_LANED] = {
        &l->from.phi,   &l->from.phi_low, &l->from.rate,   &l->from.rate_low, &l->to.phi,
        &l->to.phi_low, &l->to.rate,      &l->to.rate_low, &l->len,           &l->mass};
    double **single[EXTENDED_SINGLE] = {&l->from.time, &l->to.time, &l->gravity,
                                        &l->unit,      &l->stop,    &l->start};
    double **flat[EXTENDED_FLAT] = {&e->member.phi,  &e->member.rate, &e->member.length,
                                    &e->member.mass, &e->end.phi,     &e->end.rate,
                                    &e->end.phi_low, &e->end.rate_low};
    extended_take(base, &used, sizeof *e / sizeof(double) + 1);
    for (int i = 0; i < EXTENDED_LANED; i++) *laned[i] = extended_take(base, &used, n * width);
    for (int i = 0; i < EXTENDED_SINGLE; i++) *single[i] = extended_take(base, &used, width);
    for (int i = 0; i < EXTENDED_FLAT; i++) *flat[i] = extended_take(base, &used, n);
    l->attention = (unsigned char *)extended_take(base, &used, 1);
    l->share = extended_take(base, &used, (size_t)l->order + 2);
    l->series = extended_take(base, &used, e->kernel->series_count(l->terms, l->n, l->order));
    if (!l->terms) return used;
    l->value = extended_take(base, &used, (size_t)l->terms->count * width);
    e->member.value = extended_take(base, &used, (size_t)l->terms->count);
    return used;
}

enum pend_status pend_extended_new(struct pend_extended **extended, const struct pend_tree *tree,
                                   const struct pend_terms *terms, double rtol, double atol,
                                   int single, enum pend_isa isa, struct pend_error *error) {
    *extended = NULL;
    if (!(rtol >= PEND_EXTENDED_RTOL_MIN && rtol <= 0.1))
        return pend_fail(error, PEND_INVALID, -1, 0, "rtol must be from %g to 0.1, got %g",
                         PEND_EXTENDED_RTOL_MIN, rtol);
    if (!(atol >= 0 && atol <= 1))
        return pend_fail(error, PEND_INVALID, -1, 0, "atol must be from 0 to 1, got %g", atol);
    double target = extended_target(rtol);
    int order = extended_order(target);
    // four lanes hold the four sums of an arm
    if (single && isa > PEND_ISA_AVX2) isa = PEND_ISA_AVX2;
    struct pend_extended sketch = {.tree = tree,
                                   .kernel = PEND_ISA_PICK(pend_kernel_extended, isa)};
    sketch.lanes =
        (struct extended_lanes){.n = tree->n,
                                .single = single,
                                .terms = terms,
                                .order = order,
                                .precise = extended_precise(target, order),
                                .parent = tree->parent,
                                .end = tree->end,
                                .log_rtol = log2(target),
                                .log_atol = atol > 0 ? log2(pend_taylor_atol(atol)) : -1e5};
    size_t bytes = extended_place(&sketch, NULL);
    // the limit is that of the widest lanes, so that every processor refuses the same trees
    size_t widest = single ? 4 : EXTENDED_WIDTH_MAX,
           counted = bytes / (size_t)sketch.kernel->width * widest;
    if (counted > (size_t)EXTENDED_BYTES_CAP)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "32 digits are for smaller trees: the series of %d arms would take %zu "
                         "bytes, more than %d",
                         tree->n, counted, EXTENDED_BYTES_CAP);
    char *block = aligned_alloc(64, bytes);
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the series of %d arms: %zu bytes", tree->n, bytes);
    memset(block, 0, bytes);
    extended_place(&sketch, block);
    for (int j = 0; j < order + 2; j++) sketch.lanes.share[j] = 1.0 / (j + 1);
    *extended = (struct pend_extended *)(void *)block;
    **extended = sketch;
    for (int i = 0; i < EXTENDED_WIDTH_MAX; i++)
        (*extended)->seat[i] = (struct extended_seat){.state = PEND_EXTENDED_STOPPED, .empty = 1};
    return PEND_OK;
}

/* the sizes agree with the tree's and the kernel's, and every lane is in one of its states */
PEND_VALIDATOR extended_valid(const struct pend_extended *e) {
    if (!e->kernel || e->kernel->width < 1 || e->kernel->width > EXTENDED_WIDTH_MAX) return 0;
    if (e->lanes.n != e->tree->n || e->lanes.precise > e->lanes.order + 1) return 0;
    for (int i = 0; i < e->kernel->width; i++)
        if (e->seat[i].steps < 0 || e->seat[i].state > PEND_EXTENDED_FAILED) return 0;
    return 1;
}

void pend_extended_free(struct pend_extended **extended) {
    assert(!*extended || extended_valid(*extended));
    free(*extended);
    *extended = NULL;
}

/* ---- lanes */

int pend_extended_width(const struct pend_extended *e) { return e->kernel->width; }

int pend_extended_order(const struct pend_extended *e) { return e->lanes.order; }

/* copies a start into a lane: the end of the last step is the start of the next */
static void extended_fill(struct pend_extended *e, int lane, const struct pend_loads *loads,
                          const struct pend_extended_state *state, const double len[],
                          const double mass[], double start, double stop) {
    struct extended_lanes *l = &e->lanes;
    double unit = pend_taylor_first_unit(l->n, loads, len, state->rate);
    for (int k = 0; k < l->n; k++) {
        size_t at = (size_t)(k * e->kernel->width + lane);
        l->to.phi[at] = state->phi[k];
        l->to.phi_low[at] = state->phi_low ? state->phi_low[k] : 0;
        l->to.rate[at] = state->rate[k];
        l->to.rate_low[at] = state->rate_low ? state->rate_low[k] : 0;
        l->len[at] = len[k];
        l->mass[at] = mass[k];
    }
    for (int j = 0; l->terms && j < l->terms->count; j++)
        l->value[j * e->kernel->width + lane] = loads->value[j];
    l->start[lane] = start;
    l->to.time[lane] = 0;
    l->stop[lane] = stop;
    l->gravity[lane] = loads->gravity;
    l->unit[lane] = copysign(unit, stop);
}

static void extended_begin(struct pend_extended *e, int lane, const struct pend_loads *loads,
                           const struct pend_extended_state *state, const double len[],
                           const double mass[], double start, double stop) {
    extended_fill(e, lane, loads, state, len, mass, start, stop);
    e->seat[lane] =
        (struct extended_seat){.state = stop == 0 ? PEND_EXTENDED_STOPPED : PEND_EXTENDED_UNDER_WAY,
                               .unit = e->lanes.unit[lane]};
    // lanes without a trajectory compute this one as well: its numbers are finite
    for (int i = 0; i < e->kernel->width; i++)
        if (e->seat[i].empty) extended_fill(e, i, loads, state, len, mass, start, stop);
}

void pend_extended_start(struct pend_extended *e, int lane, const struct pend_loads *loads,
                         const struct pend_extended_state *state, double start, double stop) {
    assert(extended_valid(e) && lane >= 0 && lane < e->kernel->width);
    assert(loads->terms == e->lanes.terms);
    assert(!e->lanes.single || lane == 0);
    extended_begin(e, lane, loads, state, e->tree->len, e->tree->mass, start, stop);
}

void pend_extended_stop(struct pend_extended *e, int lane, double stop) {
    assert(extended_valid(e) && lane >= 0 && lane < e->kernel->width);
    double left = stop - e->lanes.to.time[lane];
    e->lanes.stop[lane] = stop;
    e->lanes.unit[lane] = copysign(e->lanes.unit[lane], left);
    if (left != 0 && e->seat[lane].state == PEND_EXTENDED_STOPPED)
        e->seat[lane].state = PEND_EXTENDED_UNDER_WAY;
}

/* before a step: its start is the end of the last; idle lanes repeat their step */
static void extended_turn(struct pend_extended *e) {
    struct extended_lanes *l = &e->lanes;
    struct extended_state swap = l->from;
    l->from = l->to;
    l->to = swap;
    for (int i = 0; i < e->kernel->width; i++) {
        if (e->seat[i].state != PEND_EXTENDED_UNDER_WAY) l->stop[i] = copysign(1e300, l->unit[i]);
        e->seat[i].unit = l->unit[i];
    }
}

int pend_extended_step(struct pend_extended *e) {
    assert(extended_valid(e));
    int ended = 0;
    extended_turn(e);
    int any = e->kernel->step(&e->lanes);
    for (int i = 0; i < e->kernel->width; i++) {
        struct extended_seat *seat = &e->seat[i];
        if (seat->state != PEND_EXTENDED_UNDER_WAY) continue;
        seat->steps++;
        if (!any || !e->lanes.attention[i]) continue;
        seat->state =
            e->lanes.attention[i] & EXTENDED_BAD ? PEND_EXTENDED_FAILED : PEND_EXTENDED_STOPPED;
        ended++;
    }
    assert(extended_valid(e) && ended <= e->kernel->width);
    return ended;
}

enum pend_extended_lane pend_extended_lane(const struct pend_extended *e, int lane) {
    assert(lane >= 0 && lane < e->kernel->width);
    return e->seat[lane].state;
}

double pend_extended_time(const struct pend_extended *e, int lane) {
    assert(lane >= 0 && lane < e->kernel->width);
    return e->lanes.to.time[lane];
}

long pend_extended_steps(const struct pend_extended *e, int lane) {
    assert(lane >= 0 && lane < e->kernel->width);
    return e->seat[lane].steps;
}

void pend_extended_end(const struct pend_extended *e, int lane,
                       const struct pend_extended_state *state) {
    assert(extended_valid(e) && state->phi != state->rate);
    const struct extended_state *to = &e->lanes.to;
    for (int k = 0; k < e->lanes.n; k++) {
        size_t at = (size_t)(k * e->kernel->width + lane);
        state->phi[k] = to->phi[at];
        state->rate[k] = to->rate[at];
        if (state->phi_low) state->phi_low[k] = to->phi_low[at];
        if (state->rate_low) state->rate_low[k] = to->rate_low[at];
    }
}

void pend_extended_carry(struct pend_extended *e, struct pend_checkpoint *checkpoint) {
    assert(extended_valid(e));
    struct extended_lanes *l = &e->lanes;
    struct extended_seat *seat = &e->seat[0];
    const size_t width = (size_t)e->kernel->width;
    /* the start of the last step; before the first step, the start of that */
    struct extended_state *start = seat->steps ? &l->from : &l->to;
    long steps = seat->steps;
    double unit = seat->steps ? seat->unit : l->unit[0], stop = l->stop[0], time = start->time[0];
    pend_checkpoint_counts(checkpoint, &steps, 1);
    pend_checkpoint_row(checkpoint, &unit, 1);
    pend_checkpoint_row(checkpoint, &stop, 1);
    pend_checkpoint_row(checkpoint, &time, 1);
    double *rows[] = {start->phi, start->phi_low, start->rate, start->rate_low};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        for (size_t k = 0; k < (size_t)l->n; k++)
            pend_checkpoint_row(checkpoint, rows[i] + k * width, 1);
    if (!pend_checkpoint_puts(checkpoint)) return;
    for (size_t i = 0; i < width; i++) {
        for (size_t j = 0; j < sizeof rows / sizeof *rows; j++)
            for (size_t k = 0; k < (size_t)l->n; k++) rows[j][k * width + i] = rows[j][k * width];
        l->unit[i] = unit;
        l->stop[i] = stop;
        start->time[i] = time;
    }
    if (!steps) return;
    seat->state = PEND_EXTENDED_UNDER_WAY;
    pend_extended_step(e);
    seat->steps = steps;
}

static double *extended_row(double *array, size_t base) { return array ? array + base : NULL; }

void pend_extended_at(const struct pend_extended *e, int lane, int count, const double t[],
                      const struct pend_extended_state *to, double acc[], double force[]) {
    assert(extended_valid(e) && count >= 0 && to->phi && to->rate);
    int width = e->kernel->width;
    for (int i = 0; i < count; i += width) {
        size_t base = (size_t)i * (size_t)e->lanes.n;
        struct extended_values values = {.phi = to->phi + base,
                                         .phi_low = extended_row(to->phi_low, base),
                                         .rate = to->rate + base,
                                         .rate_low = extended_row(to->rate_low, base),
                                         .acc = extended_row(acc, base),
                                         .force = extended_row(force, base)};
        int some = count - i < width ? count - i : width;
        e->kernel->values(&e->lanes, lane, e->seat[lane].unit, some, t + i, &values);
    }
}

double pend_extended_power(const struct pend_extended *e, int lane, double work[], double heat[]) {
    assert(extended_valid(e) && e->lanes.terms && e->seat[lane].steps > 0);
    e->kernel->power(&e->lanes, lane, e->seat[lane].unit, work, heat);
    return e->seat[lane].unit;
}

/* ---- many members */

/* puts the next member into a lane, unless no member is left */
static void extended_seat_next(struct pend_extended *e, const struct pend_ensemble_problem *problem,
                               int lane, long *next, long end, int *cancelled) {
    size_t bytes = (size_t)e->lanes.n * sizeof(double);
    if (*next >= end || *cancelled) return;
    memset(e->member.phi, 0, bytes);
    memset(e->member.rate, 0, bytes);
    memcpy(e->member.length, e->tree->len, bytes);
    memcpy(e->member.mass, e->tree->mass, bytes);
    e->member.loads = problem->loads;
    e->member.start = 0;
    if (e->lanes.terms) {
        memcpy(e->member.value, problem->loads.value,
               (size_t)e->lanes.terms->count * sizeof(double));
        e->member.loads.value = e->member.value;
    }
    if (problem->fetch(problem->context, *next, &e->member)) *cancelled = 1;
    struct pend_extended_state start = {.phi = e->member.phi, .rate = e->member.rate};
    extended_begin(e, lane, &e->member.loads, &start, e->member.length, e->member.mass,
                   e->member.start, problem->duration);
    e->seat[lane].member = (*next)++;
    e->seat[lane].taken = 1;
}

/* delivers a member that has ended, or has taken too many steps; returns non-zero when it did */
static int extended_seat_serve(struct pend_extended *e, const struct pend_ensemble_problem *problem,
                               int lane, int *cancelled) {
    struct extended_seat *seat = &e->seat[lane];
    struct pend_outcome outcome = {.time = e->lanes.to.time[lane], .arm = -1, .steps = seat->steps};
    outcome.first = outcome.lyapunov = outcome.energy_drift = NAN;
    if (!seat->taken) return 0;
    if (seat->state == PEND_EXTENDED_FAILED) {
        outcome.stop = PEND_STOP_FAILED;
        outcome.time = e->lanes.from.time[lane];
        outcome.status =
            e->lanes.to.time[lane] == outcome.time ? PEND_STEP_TOO_SMALL : PEND_NOT_FINITE;
    } else if (seat->state == PEND_EXTENDED_UNDER_WAY) {
        if (!problem->step_cap || seat->steps < problem->step_cap) return 0;
        outcome.stop = PEND_STOP_FAILED;
        outcome.status = PEND_TOO_MANY_STEPS;
        seat->state = PEND_EXTENDED_STOPPED;
    }
    pend_extended_end(e, lane, &e->end);
    outcome.phi = e->end.phi;
    outcome.rate = e->end.rate;
    seat->taken = 0;
    if (problem->deliver(problem->context, seat->member, &outcome)) *cancelled = 1;
    return 1;
}

enum pend_status pend_extended_run(struct pend_extended *e,
                                   const struct pend_ensemble_problem *problem, long first,
                                   long count) {
    assert(extended_valid(e) && problem->tree == e->tree && count >= 0);
    long next = first, end = first + count, left = count;
    int cancelled = 0, width = e->kernel->width;
    for (int i = 0; i < width; i++) extended_seat_next(e, problem, i, &next, end, &cancelled);
    while (left > 0 && !cancelled) {
        for (int i = 0; i < width; i++) {
            if (!extended_seat_serve(e, problem, i, &cancelled)) continue;
            left--;
            extended_seat_next(e, problem, i, &next, end, &cancelled);
        }
        if (left > 0 && !cancelled) pend_extended_step(e);
    }
    for (int i = 0; i < width; i++) e->seat[i].taken = 0;
    return cancelled ? PEND_CANCELLED : PEND_OK;
}
