#include "core/ensemble/ensemble.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/ensemble/ensemble_alone.h"
#include "core/ensemble/ensemble_events.h"
#include "core/ensemble/ensemble_shadow.h"
#include "core/ensemble/ensemble_watch.h"
#include "core/integrate/pieces/control.h"
#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/horizon.h"
#include "core/taylor/taylor_order.h"
#include "core/tree/turns.h"

/* numbers of arrays: of n values per lane for the kernel; of one value per lane; of n values per
 * lane for the outcomes; of n values */
enum {
    ENSEMBLE_LANED = 18,
    ENSEMBLE_SINGLE = 14,
    ENSEMBLE_NOTED = 8,
    ENSEMBLE_FLAT = 13,
    ENSEMBLE_SHARES = 48
};

static enum pend_status ensemble_check(const struct pend_ensemble_problem *problem,
                                       struct pend_error *error) {
    if (!(problem->rtol >= 1e-16 && problem->rtol <= 0.1)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "rtol must be from 1e-16 to 0.1, got %g",
                         problem->rtol);
    }
    if (!(problem->atol >= 0 && problem->atol <= 1)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "atol must be from 0 to 1, got %g",
                         problem->atol);
    }
    if (!(problem->bound >= 0 && problem->bound <= 1e6)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "the bound must be from 0 to 1e6 rad, got %g",
                         problem->bound);
    }
    if (!isfinite(problem->duration)) {
        return pend_fail(error, PEND_INVALID, -1, 0, "the duration must be a finite number");
    }
    int told = problem->until == PEND_UNTIL_TOLD;
    if (problem->events ? problem->until != PEND_UNTIL_TIME && !told : told)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "conditions and an end at a bound exclude each other");
    PEND_TRY(pend_event_search_check(problem->events, problem->event, problem->tree->n, error));
    PEND_TRY(pend_ensemble_alone_check(problem, error));
    return pend_loads_check_series(&problem->loads, error);
}

/* allocates `count` doubles of a block, rounded up to 64 bytes */
static double *ensemble_take(char **at, size_t count) {
    double *piece = (double *)(void *)*at;
    *at += (count + 7) / 8 * 8 * sizeof(double);
    return piece;
}

static size_t ensemble_padded(size_t count) { return (count + 7) / 8 * 8; }

/* returns the number of values in an ensemble's list of terms */
static size_t ensemble_terms(const struct pend_terms *terms) {
    return terms ? (size_t)terms->count : 0;
}

static size_t ensemble_doubles(const struct pend_terms *terms, int n_, int width_, size_t series) {
    size_t n = (size_t)n_, width = (size_t)width_, count = ensemble_terms(terms);
    size_t real = terms ? ensemble_padded(count * width) + ensemble_padded(count) +
                              ENSEMBLE_ORDER_MAX * width +
                              ensemble_padded(pend_control_numbers(terms->rules, n_) * width)
                        : 0;
    return real + (ENSEMBLE_LANED + ENSEMBLE_NOTED) * ensemble_padded(n * width) +
           ENSEMBLE_SINGLE * ensemble_padded(width) + ENSEMBLE_FLAT * ensemble_padded(n) +
           8 * ensemble_padded(n * ENSEMBLE_INSTANTS) + ENSEMBLE_SHARES + 3 * ensemble_padded(n) +
           ensemble_padded(series);
}

static void ensemble_place(struct pend_ensemble *e, char *at, size_t doubts) {
    struct ensemble_lanes *lanes = &e->lanes;
    struct ensemble_doubt *doubt = &lanes->doubt;
    size_t n = (size_t)lanes->n, width = (size_t)lanes->width;
    double **laned[ENSEMBLE_LANED] = {
        &lanes->from.phi,  &lanes->from.phi_low, &lanes->from.rate, &lanes->from.rate_low,
        &lanes->to.phi,    &lanes->to.phi_low,   &lanes->to.rate,   &lanes->to.rate_low,
        &lanes->len,       &lanes->inv_len,      &lanes->mass,      &lanes->cell,
        &lanes->force_max, &lanes->force_min,    &e->turns,         &e->turns_low,
        &doubt->phi,       &doubt->rate};
    double **single[ENSEMBLE_SINGLE] = {
        &lanes->from.time, &lanes->to.time, &lanes->from.gain, &lanes->to.gain, &lanes->start,
        &lanes->gravity,   &lanes->unit,    &lanes->stop,      &lanes->step,    &doubt->fastest,
        &doubt->strongest, &doubt->time,    &doubt->ratio,     &doubt->held};
    double **noted[ENSEMBLE_NOTED - 1] = {&e->first_crossing, &e->most,       &e->most_time,
                                          &e->least,          &e->least_time, &e->sign_change,
                                          &e->sense};
    double **flat[ENSEMBLE_FLAT - 4] = {
        &e->member.phi, &e->member.rate, &e->member.length,  &e->member.mass, &e->phi,
        &e->rate,       &e->subtree,     &e->member.phi_low, &e->phi_low};
    ensemble_set **set[3] = {&lanes->near, &lanes->peak, &lanes->turn};
    for (int i = 0; i < ENSEMBLE_LANED; i++) *laned[i] = ensemble_take(&at, n * width);
    for (int i = 0; i < ENSEMBLE_SINGLE; i++) *single[i] = ensemble_take(&at, width);
    for (int i = 0; i < ENSEMBLE_NOTED - 1; i++) *noted[i] = ensemble_take(&at, n * width);
    for (int i = 0; i < ENSEMBLE_FLAT - 4; i++) *flat[i] = ensemble_take(&at, n);
    e->room = ensemble_take(&at, 4 * n);
    for (int i = 0; i < 4; i++) e->rows[i] = ensemble_take(&at, n * ENSEMBLE_INSTANTS);
    for (int i = 0; i < 4; i++) e->instants[i] = ensemble_take(&at, n * ENSEMBLE_INSTANTS);
    for (int i = 0; i < 3; i++) *set[i] = (ensemble_set *)ensemble_take(&at, n);
    lanes->share = ensemble_take(&at, ENSEMBLE_SHARES);
    for (int j = 0; j < ENSEMBLE_SHARES; j++) lanes->share[j] = 1.0 / (j + 1);
    e->crossings = (long *)(void *)ensemble_take(&at, n * width);
    if (lanes->terms) {
        size_t count = ensemble_terms(lanes->terms);
        lanes->value = ensemble_take(&at, count * width);
        e->member.value = ensemble_take(&at, count);
        double *power = ensemble_take(&at, ENSEMBLE_ORDER_MAX * width);
        if (e->problem.observe & PEND_OBSERVE_ENERGY) lanes->power = power;
        e->controls = pend_control_numbers(lanes->terms->rules, lanes->n);
        if (e->controls) e->control = ensemble_take(&at, e->controls * width);
    }
    lanes->doubt.series = ensemble_take(&at, doubts);
    size_t limits = ensemble_padded(ensemble_limits(lanes->n, doubt->order) * width);
    if (doubts) doubt->limit = doubt->series + doubts - limits;
    lanes->series = (double *)(void *)at;
}

/* members are counted once; a seat holds a member of the queue or is idle */
PEND_VALIDATOR ensemble_valid(const struct pend_ensemble *e) {
    const struct ensemble_queue *queue = &e->queue;
    if (!e->kernel || e->lanes.width != e->kernel->width) return 0;
    if (e->lanes.n != e->problem.tree->n || queue->left < queue->end - queue->next) return 0;
    for (int i = 0; i < e->lanes.width; i += 1 + e->lanes.paired)
        if (e->seat[i].member >= queue->end && queue->end > 0) return 0;
    return 1;
}

/* true if forces are needed at other instants than the start of a step */
static int ensemble_forces(const struct pend_ensemble_problem *problem) {
    int wanted = (problem->observe & (PEND_OBSERVE_EXTREMES | PEND_OBSERVE_SIGNS)) != 0 ||
                 problem->times_count > 0;
    for (int i = 0; i < problem->events; i++)
        wanted |= problem->event[i].quantity == PEND_QUANTITY_FORCE;
    return wanted;
}

enum pend_status pend_ensemble_new(struct pend_ensemble **ensemble,
                                   const struct pend_ensemble_problem *problem, enum pend_isa isa,
                                   struct pend_error *error) {
    *ensemble = NULL;
    PEND_TRY(ensemble_check(problem, error));
    const struct ensemble_kernel *kernel = PEND_ISA_PICK(pend_kernel_ensemble, isa);
    const struct pend_terms *terms = problem->loads.terms;
    int n = problem->tree->n, order = pend_taylor_order(problem->rtol, 0);
    int known = order + (problem->accuracy > 0 ? ENSEMBLE_DOUBT_BEYOND : 0);
    int spread = ensemble_spread(problem->tree, problem->loads.gravity, problem->duration, known);
    size_t limits = ensemble_padded(ensemble_limits(n, spread) * (size_t)kernel->width);
    size_t doubts = ensemble_padded(kernel->series_count(terms, n, spread)) + limits;
    if (!(problem->accuracy > 0)) doubts = 0;
    size_t head = (sizeof **ensemble + 63) / 64 * 64,
           series = kernel->series_count(terms, n, known);
    size_t bytes =
        head + (doubts + ensemble_doubles(terms, n, kernel->width, series)) * sizeof(double);
    size_t events = pend_ensemble_events_bytes(problem, kernel->width);
    int forces = ensemble_forces(problem);
    // forces are computed from states
    size_t truth = forces ? pend_event_truth_bytes(problem->tree, &problem->loads) : 0;
    size_t all = bytes + events + truth;
    struct pend_ensemble *e = aligned_alloc(64, all);
    if (!e)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for an ensemble of trees of %d arms", n);
    memset(e, 0, all);
    e->problem = *problem;
    e->kernel = kernel;
    e->lanes =
        (struct ensemble_lanes){.n = n, .order = order, .known = known, .width = kernel->width};
    e->lanes.doubt.grade = problem->accuracy > 0 ? PEND_HORIZON_MARGIN / problem->accuracy : 0;
    e->lanes.doubt.order = spread;
    e->lanes.terms = terms;
    e->lanes.parent = problem->tree->parent;
    e->lanes.end = problem->tree->end;
    e->lanes.log_rtol = log2(pend_taylor_target(problem->rtol));
    e->lanes.log_atol = problem->atol > 0 ? log2(pend_taylor_atol(problem->atol)) : -1e5;
    e->lanes.bound = problem->bound;
    e->lanes.paired = (problem->observe & PEND_OBSERVE_LYAPUNOV) != 0;
    e->lanes.extremes = (problem->observe & PEND_OBSERVE_EXTREMES) != 0;
    e->lanes.signs = (problem->observe & PEND_OBSERVE_SIGNS) != 0;
    e->lanes.forces = forces;
    ensemble_place(e, (char *)e + head, doubts);
    pend_ensemble_events_place(e, (char *)e + bytes);
    if (forces) pend_event_truth_place(&e->truth, problem->tree, (char *)e + bytes + events);
    if (!pend_pieces_smooth(terms))
        e->alone.method = pend_pieces_method(&pend_method_taylor, terms);
    kernel->prepare(&e->lanes);
    assert(ensemble_valid(e));
    *ensemble = e;
    return PEND_OK;
}

void pend_ensemble_free(struct pend_ensemble **ensemble) {
    assert(!*ensemble || ensemble_valid(*ensemble));
    if (*ensemble) pend_ensemble_alone_close(*ensemble);
    free(*ensemble);
    *ensemble = NULL;
}

/* the number of arms with enough energy to reach their bound: at least the potential energy of an
 * arm at its bound while all other arms hang at rest */
static int ensemble_able(const struct pend_ensemble *e, const struct pend_tree *tree,
                         double energy) {
    double gravity = e->member.loads.gravity,
           least = -pend_kinematics_energy_scale(tree, &e->member.loads, 0);
    int able = 0;
    for (int k = 0; k < tree->n; k++) {
        double rise = gravity * tree->len[k] * tree->subtree_mass[k] *
                      (1 - cos(fmin(e->problem.bound, M_PI)));
        able += !(gravity > 0) || !(energy < least + rise - 1e-9 * fabs(least));
    }
    return able;
}

/* the instant up to which a member that ended at `time` has the requested accuracy */
static double ensemble_horizon(const struct ensemble_lanes *lanes, int i, double time) {
    double held = lanes->doubt.held[i];
    if (!(lanes->doubt.grade > 0)) return NAN;
    return fabs(held) < fabs(time) ? held : time;
}

/* loads a member's start into lane i; returns the number of arms that may reach their bound */
static int ensemble_seat_start(struct pend_ensemble *e, int i) {
    struct ensemble_lanes *lanes = &e->lanes;
    const struct pend_member *member = &e->member;
    const struct pend_terms *terms = lanes->terms;
    // cells of width 2 pi have whole turns as boundaries only; springs distinguish whole turns
    int whole =
        (e->problem.bound == 0 || e->problem.bound == M_PI) && pend_terms_whole_turns(terms);
    for (int k = 0; k < lanes->n; k++) {
        size_t at = (size_t)(k * lanes->width + i);
        struct pend_sum turns = {0, 0}, phi = {member->phi[k], member->phi_low[k]};
        if (whole) phi = pend_turns_rest(phi.high, phi.low, &turns);
        member->phi[k] = lanes->from.phi[at] = phi.high;
        e->turns[at] = turns.high, e->turns_low[at] = turns.low;
        lanes->from.rate[at] = member->rate[k];
        lanes->from.phi_low[at] = phi.low;
        lanes->from.rate_low[at] = 0;
        lanes->len[at] = member->length[k];
        lanes->inv_len[at] = 1 / member->length[k];
        lanes->mass[at] = member->mass[k];
    }
    for (int j = 0; terms && j < terms->count; j++)
        lanes->value[j * lanes->width + i] = member->value[j];
    const struct ensemble_doubt *doubt = &lanes->doubt;
    for (int k = 0; k < lanes->n; k++)
        doubt->phi[k * lanes->width + i] = doubt->rate[k * lanes->width + i] = 0;
    doubt->fastest[i] = doubt->strongest[i] = doubt->time[i] = doubt->ratio[i] = 0;
    doubt->held[i] = ENSEMBLE_HELD;
    lanes->from.time[i] = lanes->from.gain[i] = 0;
    lanes->start[i] = member->start;
    lanes->gravity[i] = member->loads.gravity;
    pend_ensemble_watch_begin(e, i, member->start, &lanes->from);
    lanes->unit[i] =
        copysign(pend_taylor_first_unit(lanes->n, &member->loads, member->length, member->rate),
                 e->problem.duration);
    pend_ensemble_watch_start(e, i);
    size_t watched = (size_t)e->problem.events;
    if (watched) memset(e->watch + (size_t)i * watched, 0, watched * sizeof *e->watch);
    if (lanes->paired) pend_ensemble_shadow_start(e, i);
    int arms = lanes->n - pend_terms_cart(terms);
    if (!(e->problem.observe & PEND_OBSERVE_ENERGY) && !e->problem.spare) return arms;
    struct pend_tree tree = pend_member_tree(e->problem.tree, &e->member, e->subtree);
    struct pend_energy energy = pend_kinematics_energy_at(&tree, &member->loads, member->start,
                                                          member->phi, member->rate, e->room);
    e->seat[i].energy = energy.kinetic + energy.potential;
    e->seat[i].scale = pend_kinematics_energy_scale_at(&tree, &member->loads, energy.kinetic);
    return e->problem.spare && !terms ? ensemble_able(e, &tree, e->seat[i].energy) : arms;
}

/* copies the results of the member in lane i, except its end, into its outcome */
static void ensemble_seat_notes(const struct pend_ensemble *e, int i,
                                struct pend_outcome *outcome) {
    size_t own = (size_t)i * (size_t)e->lanes.n;
    outcome->arm = e->seat[i].arm;
    outcome->first = e->seat[i].first;
    outcome->steps = e->seat[i].steps;
    outcome->phi = e->phi;
    outcome->rate = e->rate;
    outcome->phi_low = e->phi_low;
    outcome->energy_drift = outcome->lyapunov = NAN;
    outcome->horizon = ensemble_horizon(&e->lanes, i, outcome->time);
    outcome->settled = e->seat[i].settled <= 0.9 * outcome->time ? e->seat[i].settled : NAN;
    if (e->lanes.bound > 0) {
        outcome->first_crossing = e->first_crossing + own;
        outcome->crossings = e->crossings + own;
    }
    for (int k = 0; k < e->lanes.n && e->lanes.extremes; k++) {
        e->most[own + (size_t)k] = e->lanes.force_max[k * e->lanes.width + i];
        e->least[own + (size_t)k] = e->lanes.force_min[k * e->lanes.width + i];
    }
    if (e->lanes.extremes) {
        outcome->force = (struct pend_force_range){e->most + own, e->most_time + own,
                                                   e->least + own, e->least_time + own};
    }
    if (e->lanes.signs) outcome->sign_change = e->sign_change + own;
}

/* work of drives minus heat of friction, J, up to a fraction of the step of lane i */
static double ensemble_gain(const struct ensemble_lanes *lanes, int i, double part) {
    double sum = 0, x = lanes->step[i] * part;
    if (!lanes->power) return 0;
    for (int j = lanes->order - 1; j >= 0; j--) sum = sum * x + lanes->power[j * lanes->width + i];
    return part == 1 ? lanes->to.gain[i] : lanes->from.gain[i] + sum * x;
}

/* the energy at a fraction of the step, minus the initial and the exchanged, over the scale */
static double ensemble_seat_drift(struct pend_ensemble *e, int i, double part) {
    const struct ensemble_lanes *lanes = &e->lanes;
    int width = lanes->width, terms = (int)ensemble_terms(lanes->terms);
    for (int k = 0; k < lanes->n; k++) {
        e->member.length[k] = lanes->len[k * width + i];
        e->member.mass[k] = lanes->mass[k * width + i];
    }
    for (int j = 0; j < terms; j++) e->member.value[j] = lanes->value[j * width + i];
    struct pend_tree tree = pend_member_tree(e->problem.tree, &e->member, e->subtree);
    struct pend_loads loads = {lanes->gravity[i], lanes->terms, e->member.value};
    double time = lanes->start[i] + pend_ensemble_watch_time(e, i, part);
    struct pend_energy energy =
        pend_kinematics_energy_at(&tree, &loads, time, e->phi, e->rate, e->room);
    double gain = ensemble_gain(lanes, i, part), scale = e->seat[i].scale;
    if (terms) scale = fmax(scale, energy.kinetic + fabs(gain));
    double gap = energy.kinetic + energy.potential - e->seat[i].energy - gain;
    return scale == 0 ? 0 : fabs(gap) / scale;
}

/* delivers the member in lane i, which ended at the fraction `part` of the step */
static void ensemble_seat_deliver(struct pend_ensemble *e, int i, double part,
                                  struct pend_outcome *outcome, int *cancelled) {
    ensemble_seat_notes(e, i, outcome);
    if (outcome->steps && e->problem.observe & PEND_OBSERVE_ENERGY)
        outcome->energy_drift = ensemble_seat_drift(e, i, part);
    if (outcome->steps && e->lanes.paired) outcome->lyapunov = pend_ensemble_shadow_exponent(e, i);
    for (int k = 0; k < e->lanes.n; k++) {
        int at = k * e->lanes.width + i;
        e->phi[k] = pend_turns_add(e->phi[k], e->turns[at], e->turns_low[at]);
    }
    if (e->problem.deliver(e->problem.context, e->seat[i].member, outcome)) *cancelled = 1;
}

/* Delivers a member without taking a step if none of its arms can reach its bound, because then no
 * crossing can happen. */
static void ensemble_seat_spare(struct pend_ensemble *e, int i, int *cancelled) {
    struct pend_outcome outcome = {.stop = PEND_STOP_TIME, .time = e->problem.duration};
    memcpy(e->phi, e->member.phi, (size_t)e->lanes.n * sizeof(double));
    memcpy(e->phi_low, e->member.phi_low, (size_t)e->lanes.n * sizeof(double));
    memcpy(e->rate, e->member.rate, (size_t)e->lanes.n * sizeof(double));
    ensemble_seat_deliver(e, i, 1, &outcome, cancelled);
}

/* loads the next member into lane i; if no member is left, the lane stays idle in its last state */
static void ensemble_seat_next(struct pend_ensemble *e, int i, struct ensemble_queue *queue) {
    while (queue->next < queue->end && !queue->cancelled) {
        pend_ensemble_fetch(e, queue->next, queue);
        e->seat[i] = (struct ensemble_seat){
            .member = queue->next++, .arm = -1, .first = NAN, .settled = NAN};
        e->seat[i].open = ensemble_seat_start(e, i);
        if (!e->problem.spare || e->seat[i].open) return;
        ensemble_seat_spare(e, i, &queue->cancelled);
        queue->left--;
    }
    e->seat[i].member = -1;
    for (int lane = i; lane <= i + e->lanes.paired; lane++)
        e->lanes.stop[lane] = copysign(1e300, e->lanes.unit[lane]);
}

static int ensemble_seat_capped(const struct pend_ensemble *e, int i) {
    long cap = e->problem.step_cap, steps = e->seat[i].steps;
    return (cap > 0 && steps >= cap) ||
           (e->control && steps - e->seat[i].sampled >= ENSEMBLE_SAMPLE_STEPS);
}

/* the fraction of the step at which the member in lane i ends; 0 if the member continues */
static double ensemble_seat_end(struct pend_ensemble *e, int i,
                                const struct ensemble_attention *attention,
                                struct pend_outcome *outcome) {
    const struct ensemble_lanes *lanes = &e->lanes;
    unsigned own = 1u << i | (unsigned)lanes->paired << (i + 1);
    if (attention->bad & own) {
        outcome->stop = PEND_STOP_FAILED;
        outcome->time = lanes->from.time[i];
        outcome->status = isfinite(lanes->step[i]) &&
                                  fabs(lanes->step[i] * e->unit[i]) < fabs(lanes->stop[i]) * 0x1p-52
                              ? PEND_STEP_TOO_SMALL
                              : PEND_NOT_FINITE;
        return 1;
    }
    double event = e->problem.events ? pend_ensemble_events_step(e, i) : INFINITY;
    double stop = INFINITY, part = fmin(event, 1);
    if (attention->near & own) stop = pend_ensemble_watch_bound(e, i, part);
    part = fmin(stop, part);
    if (attention->force & own || lanes->signs) pend_ensemble_watch_force(e, i, part);
    if (e->problem.times_count)
        pend_ensemble_watch_rows(e, i, pend_ensemble_watch_time(e, i, part));
    if (fmin(stop, event) < INFINITY) {
        outcome->stop = event < INFINITY ? PEND_STOP_EVENT : PEND_STOP_BOUND;
        outcome->time = pend_ensemble_watch_time(e, i, part);
        return part;
    }
    if (attention->done & own && !pend_ensemble_watch_piece(e, i)) return 1;
    if (!ensemble_seat_capped(e, i)) return 0;
    outcome->stop = PEND_STOP_FAILED;
    outcome->status = PEND_TOO_MANY_STEPS;
    return 1;
}

/* completes a step of lane i; returns non-zero if its member ended and was delivered */
static int ensemble_seat_serve(struct pend_ensemble *e, int i,
                               const struct ensemble_attention *attention, int *cancelled) {
    struct pend_outcome outcome = {.stop = PEND_STOP_TIME, .time = e->lanes.to.time[i]};
    if (e->lanes.paired && !(attention->bad >> i & 3)) pend_ensemble_shadow_step(e, i);
    double part = ensemble_seat_end(e, i, attention, &outcome);
    if (part == 0) return 0;
    pend_ensemble_watch_state(e, i, part);
    if (e->problem.settle > 0)
        pend_ensemble_watch_settled(e, i, e->phi, &e->problem.loads,
                                    e->lanes.start[i] + outcome.time);
    ensemble_seat_deliver(e, i, part, &outcome, cancelled);
    return 1;
}

static void ensemble_step(struct pend_ensemble *e, struct ensemble_queue *queue) {
    struct ensemble_lanes *lanes = &e->lanes;
    struct ensemble_attention attention;
    int width = lanes->width, apart = 1 + lanes->paired;
    int always = lanes->paired || lanes->signs || e->problem.times_count || e->problem.events;
    unsigned capped = 0;
    memcpy(e->unit, lanes->unit, (size_t)width * sizeof(double));
    e->kernel->step(lanes, &attention);
    for (int i = 0; i < width; i += apart) {
        e->seat[i].steps++;
        capped |= (unsigned)ensemble_seat_capped(e, i) << i;
    }
    unsigned call = always ? ~0u
                           : (unsigned)(attention.done | attention.bad | attention.near |
                                        attention.force),
             served = 0;
    call |= capped;
    for (int i = 0; i < width; i += apart) {
        if (!(call >> i & 1) || e->seat[i].member < 0) continue;
        if (ensemble_seat_serve(e, i, &attention, &queue->cancelled)) served |= 1u << i;
    }
    struct ensemble_state swap = lanes->from;
    lanes->from = lanes->to;
    lanes->to = swap;
    for (int i = 0; served && i < width; i += apart) {
        if (!(served >> i & 1)) continue;
        queue->left--;
        ensemble_seat_next(e, i, queue);
    }
}

void pend_ensemble_begin(struct pend_ensemble *e, long first, long count) {
    assert(ensemble_valid(e) && count >= 0);
    e->queue = (struct ensemble_queue){.next = first, .end = first + count, .left = count};
    e->seat[0].member = -1;
    pend_ensemble_alone_close(e);
    for (int i = 0; i < e->lanes.width && !e->alone.method; i += 1 + e->lanes.paired)
        ensemble_seat_next(e, i, &e->queue);
}

enum pend_status pend_ensemble_go(struct pend_ensemble *e, long steps, int *done) {
    assert(ensemble_valid(e));
    struct ensemble_queue *queue = &e->queue;
    for (; steps > 0 && queue->left > 0 && !queue->cancelled; steps--) {
        if (e->alone.method)
            PEND_TRY(pend_ensemble_alone_step(e, queue));
        else
            ensemble_step(e, queue);
    }
    *done = queue->left <= 0;
    assert(ensemble_valid(e) && queue->left >= 0);
    return queue->cancelled ? PEND_CANCELLED : PEND_OK;
}
