#include "core/integrate/events/events.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/horizon.h"
#include "core/integrate/run/run_check.h"
#include "core/taylor/jets/jets.h"

struct pend_events {
    struct pend_events_problem problem;
    int n;
    const struct pend_method *method;
    void *stepper;
    double reached;               /* s, end of the last step */
    double stopped;               /* s, time at which a condition stopped the motion; NaN = not
                                   * yet */
    int begun, ended;             /* whether a step was taken; whether all passages are reported */
    struct pend_horizon *horizon; /* NULL if no accuracy is given */
    double *phi, *rate;           /* n values each: state at the end of a step */
    double *whole; /* NULL unless joints may hold: angles of all arms at the start of a step, their
                    * low parts, and the series of their rates */
    struct event_search search;
    struct event_watch *watch;
};

PEND_VALIDATOR events_valid(const struct pend_events *e) {
    return e && e->stepper && e->search.next >= 0 && e->search.next <= e->search.queued &&
           e->search.count == e->problem.count;
}

/* notes the impacts at the start of this step and those at its end */
static void events_impacts(struct pend_events *e, double from) {
    int within = fabs(e->reached) <= fabs(e->problem.duration);
    for (int i = 0; i < e->problem.count; i++) {
        const struct pend_event *asked = &e->problem.event[i];
        if (asked->quantity != PEND_QUANTITY_IMPACT) continue;
        int *side = e->watch[i].above, now = pend_pieces_struck(e->method, e->stepper, asked->arm);
        if (*side) pend_event_search_note(&e->search, from, i, *side > 0);
        *side = within ? now : 0;
        if (*side) pend_event_search_note(&e->search, e->reached, i, now > 0);
    }
}

static enum pend_status events_step(struct pend_events *e, struct pend_error *error) {
    const struct pend_events_problem *problem = &e->problem;
    double from = e->reached, end = problem->duration;
    struct pend_series series;
    enum pend_status status = e->method->step(e->stepper, end, &e->reached, error);
    if (status != PEND_OK) {
        double time = problem->start + (error ? error->time : from);
        return pend_fail(error, status, -1, time, "at t = %.6g s: %s", time,
                         pend_status_text(status));
    }
    if (e->horizon) {
        const struct pend_points points = {.phi = e->phi, .rate = e->rate};
        e->method->at(e->stepper, &e->reached, 1, &points);
        pend_horizon_step(e->horizon, e->stepper, e->reached, e->phi, e->rate);
    }
    e->method->series(e->stepper, &series);
    if (!e->whole) pend_jets_forces(series.jets, series.order);
    struct event_step step = pend_event_series_step(&series, problem->tree, &problem->loads);
    if (e->whole) {
        double *phi = e->whole, *low = phi + e->n, *whole = low + e->n;
        pend_pieces_series(e->stepper, &series, whole, phi, low);
        step.jets = NULL, step.force = NULL;
        step.rate = whole, step.phi = phi, step.phi_low = low;
    }
    step.time = problem->start + from;
    step.length = (end > 0 ? fmin(e->reached, end) : fmax(e->reached, end)) - from;
    pend_event_search_step(&e->search, &step, e->watch, from, !e->begun);
    if (e->whole) events_impacts(e, from);
    e->begun = 1;
    return PEND_OK;
}

/* ---- the search */

/* copies the next hit of the step that is to be reported; returns 0 if none is left */
static int events_give(struct pend_events *e, struct pend_hit *hit, double phi[], double rate[]) {
    int stops = 0;
    const struct pend_hit *next =
        e->ended ? NULL : pend_event_search_take(&e->search, e->watch, &stops);
    if (!next) return 0;
    *hit = *next;
    const struct pend_points points = {.phi = phi, .rate = rate};
    e->method->at(e->stepper, &hit->time, 1, &points);
    if (stops) {
        e->stopped = hit->time;
        e->ended = 1;
    }
    return 1;
}

enum pend_status pend_events_next(struct pend_events *e, long steps, enum pend_found *found,
                                  struct pend_hit *hit, double phi[], double rate[],
                                  struct pend_error *error) {
    assert(events_valid(e) && steps >= 1);
    *found = PEND_FOUND_NOTHING;
    for (; steps > 0; steps--) {
        if (events_give(e, hit, phi, rate)) {
            *found = PEND_FOUND_PASSAGE;
            return PEND_OK;
        }
        double end = e->problem.duration;
        if (e->ended || (end > 0 ? e->reached >= end : e->reached <= end) ||
            pend_event_search_told(&e->search, e->watch)) {
            *found = PEND_FOUND_END;
            return PEND_OK;
        }
        PEND_TRY(events_step(e, error));
    }
    return PEND_OK;
}

double pend_events_stopped(const struct pend_events *e) {
    assert(events_valid(e));
    return e->stopped;
}

double pend_events_held(const struct pend_events *e) {
    assert(events_valid(e));
    double duration = e->problem.duration, least = fmin(fabs(e->reached), fabs(duration));
    if (!e->horizon) return NAN;
    if (!isnan(e->stopped)) least = fmin(least, fabs(e->stopped));
    return copysign(fmin(fabs(pend_horizon_held(e->horizon, e->reached)), least), duration);
}

long pend_events_steps(const struct pend_events *e) { return e->method->counts(e->stepper).steps; }

double pend_events_progress(const struct pend_events *e) {
    return e->ended ? 1 : fmin(1, e->reached / e->problem.duration);
}

/* ---- creation and release */

static enum pend_status events_check(const struct pend_events_problem *problem,
                                     struct pend_error *error) {
    if (!(problem->duration != 0 && isfinite(problem->duration) && isfinite(problem->start)))
        return pend_fail(error, PEND_INVALID, -1, 0, "the duration must not be 0, got %g",
                         problem->duration);
    for (int i = 0; i < problem->count; i++)
        if (problem->event[i].quantity == PEND_QUANTITY_FORCE &&
            !pend_pieces_smooth(problem->loads.terms))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "conditions on forces are not supported where joints stick or hit a "
                             "stop: ask for the force at instants");
    return pend_event_search_check(problem->count, problem->event, problem->tree->n, error);
}

static struct pend_events *events_allocate(const struct pend_events_problem *problem) {
    size_t bytes = pend_event_search_bytes(problem->count, problem->event, problem->tree,
                                           &problem->loads),
           watches = (size_t)problem->count * sizeof(struct event_watch),
           state = 2 * (size_t)problem->tree->n * sizeof(double);
    size_t whole = pend_pieces_smooth(problem->loads.terms)
                       ? 0
                       : (EVENT_TERMS + 2) * (size_t)problem->tree->n * sizeof(double);
    struct pend_events *made = calloc(1, sizeof *made + state + watches + whole + bytes);
    if (!made) return NULL;
    made->problem = *problem;
    made->n = problem->tree->n;
    made->stopped = NAN;
    made->phi = (double *)(made + 1);
    made->rate = made->phi + made->n;
    made->watch = (struct event_watch *)(void *)(made->rate + made->n);
    char *at = (char *)(made->watch + problem->count);
    if (whole) made->whole = (double *)(void *)at;
    pend_event_search_init(&made->search, problem->count, problem->event, problem->tree,
                           at + whole);
    return made;
}

enum pend_status pend_events_new(struct pend_events **events,
                                 const struct pend_events_problem *problem,
                                 struct pend_error *error) {
    *events = NULL;
    PEND_TRY(events_check(problem, error));
    PEND_TRY(pend_loads_check_series(&problem->loads, error));
    PEND_TRY(pend_run_check_tree(problem->tree, error));
    struct pend_events *made = events_allocate(problem);
    if (!made)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for %d conditions",
                         problem->count);
    struct pend_problem motion = {
        .tree = problem->tree,
        .loads = problem->loads,
        .phi = problem->phi,
        .phi_low = problem->phi_low,
        .rate = problem->rate,
        .rate_low = problem->rate_low,
        .times = {.count = 2, .start = problem->start, .span = problem->duration, .divisor = 1},
        .rtol = problem->rtol > 0 ? problem->rtol : pend_method_taylor.rtol_default,
        .atol = problem->atol,
        .accuracy = problem->accuracy};
    made->method = pend_pieces_method(&pend_method_taylor, problem->loads.terms);
    enum pend_status status = made->method->open(&made->stepper, &motion, error);
    if (status == PEND_OK)
        motion.loads = made->problem.loads =
            pend_pieces_loads(made->method, made->stepper, &problem->loads);
    if (status == PEND_OK && motion.accuracy > 0 && !pend_pieces_unestimated(motion.loads.terms))
        status = pend_horizon_new(&made->horizon, made->method, &motion, error);
    made->problem.phi = made->problem.rate = NULL;
    made->problem.phi_low = made->problem.rate_low = NULL;
    if (status == PEND_OK)
        *events = made;
    else
        pend_events_free(&made);
    assert(status != PEND_OK || events_valid(*events));
    return status;
}

void pend_events_free(struct pend_events **events) {
    if (!*events) return;
    pend_horizon_free(&(*events)->horizon);
    if ((*events)->stepper) (*events)->method->close(&(*events)->stepper);
    free(*events);
    *events = NULL;
}
