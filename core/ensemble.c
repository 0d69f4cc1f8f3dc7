#include "core/ensemble.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/crossing.h"
#include "core/kernel_ensemble.h"
#include "core/taylor_order.h"

/* one member in its lane */
struct ensemble_seat {
    long member; /* -1 = the lane is idle */
    long steps;
    int arm;
    double first; /* s, of the first crossing of any arm */
};

struct pend_ensemble {
    struct pend_ensemble_problem problem;
    const struct ensemble_kernel *kernel;
    struct ensemble_lanes lanes;
    struct ensemble_seat seat[ENSEMBLE_WIDTH_MAX];
    double *first_crossing; /* [lane * n + arm] */
    long *crossings;        /* [lane * n + arm] */
    struct pend_member member;
    double *phi, *rate; /* of an outcome */
};

/* doubles an arm for a member's start and an outcome, which share no lanes */
enum { ENSEMBLE_FLAT = 6, ENSEMBLE_LANED = 13, ENSEMBLE_SINGLE = 6, ENSEMBLE_SHARES = 48 };

static const struct ensemble_kernel *ensemble_kernel(enum pend_isa isa) {
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_kernel_ensemble_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_ensemble_avx2;
#endif
    (void)isa;
    return &pend_kernel_ensemble_base;
}

static enum pend_status ensemble_check(const struct pend_ensemble_problem *problem, struct pend_error *error) {
    if (!(problem->rtol >= 1e-16 && problem->rtol <= 0.1)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "rtol must be from 1e-16 to 0.1, got %g", problem->rtol);
    }
    if (!(problem->atol >= 0 && problem->atol <= 1)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "atol must be from 0 to 1, got %g", problem->atol);
    }
    if (!(problem->bound >= 0 && problem->bound <= 1e6)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "the bound must be from 0 to 1e6 rad, got %g", problem->bound);
    }
    if (!isfinite(problem->duration) || !isfinite(problem->gravity)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "duration and gravity must be finite numbers");
    }
    return PEND_OK;
}

/* hands out `count` doubles of a block, a multiple of 64 bytes */
static double *ensemble_take(char **at, size_t count) {
    double *piece = (double *)(void *)*at;
    *at += (count + 7) / 8 * 8 * sizeof(double);
    return piece;
}

static void ensemble_place(struct pend_ensemble *e, char *at) {
    struct ensemble_lanes *lanes = &e->lanes;
    size_t n = (size_t)lanes->n, width = (size_t)lanes->width;
    double **laned[ENSEMBLE_LANED] = {&lanes->from.phi, &lanes->from.phi_low, &lanes->from.rate, &lanes->from.rate_low,
                                      &lanes->to.phi,   &lanes->to.phi_low,   &lanes->to.rate,   &lanes->to.rate_low,
                                      &lanes->len,      &lanes->inv_len,      &lanes->mass,      &lanes->cell,
                                      &lanes->near};
    double **single[ENSEMBLE_SINGLE] = {&lanes->from.time, &lanes->to.time, &lanes->gravity,
                                        &lanes->unit,      &lanes->stop,    &lanes->step};
    double **flat[ENSEMBLE_FLAT] = {&e->member.phi,  &e->member.rate, &e->member.length,
                                    &e->member.mass, &e->phi,         &e->rate};
    for (int i = 0; i < ENSEMBLE_LANED; i++) *laned[i] = ensemble_take(&at, n * width);
    for (int i = 0; i < ENSEMBLE_SINGLE; i++) *single[i] = ensemble_take(&at, width);
    for (int i = 0; i < ENSEMBLE_FLAT; i++) *flat[i] = ensemble_take(&at, n);
    lanes->share = ensemble_take(&at, ENSEMBLE_SHARES);
    for (int j = 0; j < ENSEMBLE_SHARES; j++) lanes->share[j] = 1.0 / (j + 1);
    e->first_crossing = ensemble_take(&at, n * width);
    e->crossings = (long *)(void *)ensemble_take(&at, n * width);
    lanes->series = (double *)(void *)at;
}

static size_t ensemble_padded(size_t count) { return (count + 7) / 8 * 8; }

enum pend_status pend_ensemble_new(struct pend_ensemble **ensemble, const struct pend_ensemble_problem *problem,
                                   enum pend_isa isa, struct pend_error *error) {
    *ensemble = NULL;
    PEND_TRY(ensemble_check(problem, error));
    const struct ensemble_kernel *kernel = ensemble_kernel(isa);
    int n = problem->tree->n, order = pend_taylor_order(problem->rtol);
    size_t width = (size_t)kernel->width, head = (sizeof **ensemble + 63) / 64 * 64;
    size_t doubles = (ENSEMBLE_LANED + 2) * ensemble_padded((size_t)n * width) + ENSEMBLE_SINGLE * ensemble_padded(width) +
                     ENSEMBLE_FLAT * ensemble_padded((size_t)n) + ENSEMBLE_SHARES +
                     ensemble_padded(kernel->series_count(n, order));
    struct pend_ensemble *e = aligned_alloc(64, head + doubles * sizeof(double));
    if (!e) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for an ensemble of trees of %d arms", n);
    memset(e, 0, head + doubles * sizeof(double));
    e->problem = *problem;
    e->kernel = kernel;
    e->lanes = (struct ensemble_lanes){.n = n, .order = order, .width = kernel->width};
    e->lanes.parent = problem->tree->parent;
    e->lanes.end = problem->tree->end;
    e->lanes.log_rtol = log2(pend_taylor_target(problem->rtol));
    e->lanes.log_atol = problem->atol > 0 ? log2(problem->atol) : -1e5;
    e->lanes.bound = problem->bound;
    ensemble_place(e, (char *)e + head);
    *ensemble = e;
    return PEND_OK;
}

void pend_ensemble_free(struct pend_ensemble **ensemble) {
    free(*ensemble);
    *ensemble = NULL;
}

/* the start of a member into lane i */
static void ensemble_seat_start(struct pend_ensemble *e, int i) {
    struct ensemble_lanes *lanes = &e->lanes;
    const struct pend_member *member = &e->member;
    double fastest = 0;
    for (int k = 0; k < lanes->n; k++) {
        size_t at = (size_t)(k * lanes->width + i);
        lanes->from.phi[at] = member->phi[k];
        lanes->from.rate[at] = member->rate[k];
        lanes->from.phi_low[at] = lanes->from.rate_low[at] = 0;
        lanes->len[at] = member->length[k];
        lanes->inv_len[at] = 1 / member->length[k];
        lanes->mass[at] = member->mass[k];
        if (lanes->bound > 0) {
            lanes->cell[at] = floor((member->phi[k] + M_PI_2 + lanes->bound) / (2 * lanes->bound));
            e->first_crossing[i * lanes->n + k] = NAN;
            e->crossings[i * lanes->n + k] = 0;
        }
        fastest = fmax(fastest, fmax(fabs(member->rate[k]), sqrt(fabs(member->gravity) / member->length[k])));
    }
    lanes->from.time[i] = 0;
    lanes->stop[i] = e->problem.duration;
    lanes->gravity[i] = member->gravity;
    lanes->unit[i] = copysign(fastest > 0 ? exp2(-floor(log2(fastest))) : 1, e->problem.duration);
}

/* the next member into lane i; when none is left, the lane goes idle on its last state, which does no harm */
static void ensemble_seat_next(struct pend_ensemble *e, int i, long *next, long end, int *cancelled) {
    const struct pend_tree *tree = e->problem.tree;
    size_t bytes = (size_t)tree->n * sizeof(double);
    e->seat[i] = (struct ensemble_seat){.member = -1, .arm = -1, .first = NAN};
    if (*next >= end || *cancelled) {
        e->lanes.stop[i] = copysign(1e300, e->lanes.unit[i]);
        return;
    }
    memset(e->member.phi, 0, bytes);
    memset(e->member.rate, 0, bytes);
    memcpy(e->member.length, tree->len, bytes);
    memcpy(e->member.mass, tree->mass, bytes);
    e->member.gravity = e->problem.gravity;
    if (e->problem.fetch(e->problem.context, *next, &e->member)) *cancelled = 1;
    e->seat[i].member = (*next)++;
    ensemble_seat_start(e, i);
}

static void ensemble_seat_deliver(struct pend_ensemble *e, int i, struct pend_outcome *outcome, int *cancelled) {
    const struct ensemble_lanes *lanes = &e->lanes;
    const struct ensemble_seat *seat = &e->seat[i];
    outcome->arm = seat->arm;
    outcome->steps = seat->steps;
    outcome->phi = e->phi;
    outcome->rate = e->rate;
    if (lanes->bound > 0) {
        outcome->first_crossing = e->first_crossing + i * lanes->n;
        outcome->crossings = e->crossings + i * lanes->n;
    }
    if (e->problem.deliver(e->problem.context, seat->member, outcome)) *cancelled = 1;
}

/* the state at the end of the step of lane i into the outcome's arrays */
static void ensemble_seat_end(struct pend_ensemble *e, int i) {
    for (int k = 0; k < e->lanes.n; k++) {
        e->phi[k] = e->lanes.to.phi[k * e->lanes.width + i];
        e->rate[k] = e->lanes.to.rate[k * e->lanes.width + i];
    }
}

static struct crossing_path ensemble_path(const struct pend_ensemble *e, int i, int k) {
    const struct ensemble_lanes *lanes = &e->lanes;
    size_t at = (size_t)(k * lanes->width + i);
    return (struct crossing_path){.order = lanes->order,
                                  .stride = (size_t)lanes->n * (size_t)lanes->width,
                                  .rate = lanes->series + at,
                                  .share = lanes->share,
                                  .phi = lanes->from.phi[at],
                                  .phi_low = lanes->from.phi_low[at]};
}

/* time of a point of the step of lane i, x units after its start */
static double ensemble_seat_time(const struct pend_ensemble *e, int i, double x) {
    const struct ensemble_lanes *lanes = &e->lanes;
    double from = lanes->from.time[i], to = lanes->to.time[i];
    return x == lanes->step[i] ? to : from + (to - from) * (x / lanes->step[i]);
}

/* follows arm k of lane i through the step from cell to cell; returns where it first leaves one, infinity if never */
static double ensemble_seat_cross(struct pend_ensemble *e, int i, int k) {
    struct ensemble_lanes *lanes = &e->lanes;
    struct crossing_path path = ensemble_path(e, i, k);
    double first = INFINITY, x = 0, *cell = &lanes->cell[k * lanes->width + i];
    int way = 0;
    for (;;) {
        double middle = *cell * 2 * lanes->bound - M_PI_2;
        x = pend_crossing_next(&path, x, lanes->step[i], middle - lanes->bound, middle + lanes->bound, &way);
        if (!(x < INFINITY)) return first;
        if (!(first < INFINITY)) {
            first = x;
            double *note = &e->first_crossing[i * lanes->n + k];
            if (isnan(*note)) *note = ensemble_seat_time(e, i, x);
        }
        e->crossings[i * lanes->n + k]++;
        *cell += way;
        if (e->problem.stop_at_bound) return first;
    }
}

/* looks at the arms that may have left their cells; returns where the member is to stop, infinity if it is not */
static double ensemble_seat_watch(struct pend_ensemble *e, int i) {
    struct ensemble_seat *seat = &e->seat[i];
    double stop = INFINITY;
    int arm = -1;
    for (int k = 0; k < e->lanes.n; k++) {
        if (e->lanes.near[k * e->lanes.width + i] == 0) continue;
        double x = ensemble_seat_cross(e, i, k);
        if (x < stop) {
            stop = x;
            arm = k;
        }
    }
    if (arm >= 0 && seat->arm < 0) {
        seat->arm = arm;
        seat->first = ensemble_seat_time(e, i, stop);
    }
    return e->problem.stop_at_bound ? stop : INFINITY;
}

/* an outcome that ends inside the step: crossings that come after the first did not happen */
static void ensemble_seat_cut(struct pend_ensemble *e, int i, double x, struct pend_outcome *outcome) {
    const struct ensemble_lanes *lanes = &e->lanes;
    outcome->stop = PEND_STOP_BOUND;
    outcome->time = e->seat[i].first;
    for (int k = 0; k < lanes->n; k++) {
        struct crossing_path path = ensemble_path(e, i, k);
        e->phi[k] = pend_crossing_phi(&path, x);
        e->rate[k] = pend_crossing_rate(&path, x) / lanes->unit[i];
        if (k == e->seat[i].arm) continue;
        e->first_crossing[i * lanes->n + k] = NAN;
        e->crossings[i * lanes->n + k] = 0;
    }
}

/* looks after lane i at the end of a step; non-zero when its member has ended and was delivered */
static int ensemble_seat_serve(struct pend_ensemble *e, int i, int attention, double unit, int *cancelled) {
    struct ensemble_lanes *lanes = &e->lanes;
    struct pend_outcome outcome = {.stop = PEND_STOP_TIME, .time = lanes->to.time[i]};
    double next_unit = lanes->unit[i], stop = INFINITY;
    if (attention & ENSEMBLE_BAD) {
        outcome.stop = PEND_STOP_FAILED;
        outcome.time = lanes->from.time[i];
        outcome.status = lanes->to.time[i] == outcome.time ? PEND_STEP_TOO_SMALL : PEND_NOT_FINITE;
    } else if (attention & ENSEMBLE_NEAR) {
        stop = ensemble_seat_watch(e, i);
    }
    if (stop < INFINITY) {
        lanes->unit[i] = unit;
        ensemble_seat_cut(e, i, stop, &outcome);
        lanes->unit[i] = next_unit;
    } else if (attention & (ENSEMBLE_DONE | ENSEMBLE_BAD)) {
        ensemble_seat_end(e, i);
    } else if (e->problem.step_cap > 0 && e->seat[i].steps >= e->problem.step_cap) {
        outcome.stop = PEND_STOP_FAILED;
        outcome.status = PEND_TOO_MANY_STEPS;
        ensemble_seat_end(e, i);
    } else {
        return 0;
    }
    ensemble_seat_deliver(e, i, &outcome, cancelled);
    return 1;
}

/* one step of all lanes; returns how many members ended */
static int ensemble_step(struct pend_ensemble *e, long *next, long end, int *cancelled) {
    struct ensemble_lanes *lanes = &e->lanes;
    unsigned char attention[ENSEMBLE_WIDTH_MAX];
    double unit[ENSEMBLE_WIDTH_MAX];
    int ended = 0, width = lanes->width;
    memcpy(unit, lanes->unit, (size_t)width * sizeof(double));
    int any = e->kernel->step(lanes, attention) || e->problem.step_cap > 0;
    for (int i = 0; i < width; i++) e->seat[i].steps++;
    unsigned served = 0;
    for (int i = 0; any && i < width; i++) {
        if (e->seat[i].member >= 0 && ensemble_seat_serve(e, i, attention[i], unit[i], cancelled)) served |= 1u << i;
    }
    struct ensemble_state swap = lanes->from;
    lanes->from = lanes->to;
    lanes->to = swap;
    for (int i = 0; served && i < width; i++) {
        if (!(served >> i & 1)) continue;
        ended++;
        ensemble_seat_next(e, i, next, end, cancelled);
    }
    return ended;
}

enum pend_status pend_ensemble_run(struct pend_ensemble *e, long first, long count) {
    long next = first, end = first + count;
    int cancelled = 0;
    for (int i = 0; i < e->lanes.width; i++) ensemble_seat_next(e, i, &next, end, &cancelled);
    for (long left = count; left > 0 && !cancelled;) left -= ensemble_step(e, &next, end, &cancelled);
    return cancelled ? PEND_CANCELLED : PEND_OK;
}
