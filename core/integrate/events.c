#include "core/integrate/events.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/event_series.h"
#include "core/integrate/run_check.h"
#include "core/taylor/jets.h"
#include "core/tree/turns.h"

/* the most hits of a condition and its two bounds in a step, and the orders by which series of
 * places exceed those of the angles, which places are functions of */
enum { HITS_A_STEP = 2 * (PEND_ROOTS_DEGREE + 1), BEYOND = 6 };

/* rounding errors of a quantity at the start, relative to it */
static const double start_slack = 1e-14;

/* what is known of a condition between steps */
struct events_watch {
    int above[2]; /* the quantity is at its level or above; of the upper and the lower bound */
    long told;
};

struct pend_events {
    struct pend_events_problem problem;
    int n;
    void *stepper;
    double reached;   /* s, the end of the last step */
    double stopped;   /* s; NaN = not yet */
    int begun, ended; /* a step was taken; nothing more is to be told */
    int queued, next; /* the hits of the step, and the next of them to be told */
    double *room;     /* memory for the energies' series, or NULL */
    double kinetic[EVENT_TERMS], potential[EVENT_TERMS]; /* of the step, if there is room */
    struct events_watch *watch;
    struct pend_hit *queue; /* count HITS_A_STEP */
};

PEND_VALIDATOR events_valid(const struct pend_events *e) {
    return e && e->stepper && e->next >= 0 && e->next <= e->queued &&
           e->queued <= e->problem.count * HITS_A_STEP;
}

/* ---- a step */

/* the quantity of a condition over the step */
static void events_series(const struct pend_events *e, const struct event_step *step,
                          const struct pend_event *event, double out[EVENT_TERMS]) {
    double other[EVENT_TERMS];
    switch (event->quantity) {
    case PEND_QUANTITY_THETA:
    case PEND_QUANTITY_PHI:
        pend_event_series_phi(step, event->arm, out);
        return;
    case PEND_QUANTITY_RATE:
        pend_event_series_rate(step, event->arm, out);
        return;
    case PEND_QUANTITY_FORCE:
        pend_event_series_force(step, event->arm, out);
        return;
    case PEND_QUANTITY_X:
        pend_event_series_tip(step, event->arm, out, other);
        return;
    case PEND_QUANTITY_Y:
        pend_event_series_tip(step, event->arm, other, out);
        return;
    case PEND_QUANTITY_DISTANCE:
        pend_event_series_square(step, event->arm, event->other, out);
        return;
    default:
        for (int j = 0; j < EVENT_TERMS; j++)
            out[j] = (event->quantity == PEND_QUANTITY_POTENTIAL ? 0 : e->kinetic[j]) +
                     (event->quantity == PEND_QUANTITY_KINETIC ? 0 : e->potential[j]);
    }
}

/* true if the quantity is at the level or above it from the start on */
static int events_above(const struct roots_path *path, double size) {
    double slack = start_slack * size;
    if (fabs(path->base + path->low) > slack) return path->base + path->low > 0;
    for (int j = 1; j <= path->degree; j++)
        if (fabs(path->a[j]) > slack) return path->a[j] > 0;
    return 1;
}

static void events_note(struct pend_events *e, double time, int event, int up, int lower) {
    const struct pend_event *asked = &e->problem.event[event];
    // at the lower bound of a size, growing is inwards
    enum pend_way way = up != lower ? PEND_WAY_UP : PEND_WAY_DOWN;
    if (!(asked->ways & way)) return;
    assert(e->queued < e->problem.count * HITS_A_STEP);
    int i = e->queued++;
    for (; i > 0 && fabs(e->queue[i - 1].time) > fabs(time); i--) e->queue[i] = e->queue[i - 1];
    e->queue[i] = (struct pend_hit){time, event, way};
}

/* the crossings of a level, whose path is given less the level, over the step */
static void events_cross(struct pend_events *e, int event, int lower, struct roots_path *path,
                         double from, double length) {
    int *above = &e->watch[event].above[lower];
    double a = 0;
    pend_roots_divide(path);
    for (int i = 0; i < path->pieces; i++) {
        double b = path->end[i];
        int beyond = pend_roots_value(path, b) >= 0, way = 0;
        if (beyond != *above) {
            double s =
                pend_roots_next(path, a, beyond ? -INFINITY : 0, beyond ? 0 : INFINITY, &way);
            // by rounding it may be where the piece begins
            if (!(s >= a && s <= b)) s = a;
            events_note(e, from + s * length, event, beyond, lower);
            *above = beyond;
        }
        a = b;
    }
}

/* looks for a condition in the step */
static void events_look(struct pend_events *e, const struct event_step *step, int event,
                        double from) {
    const struct pend_event *asked = &e->problem.event[event];
    double series[EVENT_TERMS], level = asked->level, low = 0;
    if (e->watch[event].told >= asked->most) return;
    events_series(e, step, asked, series);
    if (asked->quantity == PEND_QUANTITY_PHI) low = step->series.begin->phi_low[asked->arm];
    if (asked->quantity == PEND_QUANTITY_THETA)
        series[0] = pend_turns_theta(series[0], step->series.begin->phi_low[asked->arm]);
    if (asked->quantity == PEND_QUANTITY_DISTANCE) level *= level;
    for (int lower = 0; lower <= (asked->bound != 0); lower++) {
        struct roots_path path = {.degree = EVENT_TERMS - 1};
        double side = lower ? -level : level;
        memcpy(path.a, series, sizeof path.a);
        path.base = series[0] - side;
        path.low = low;
        while (path.degree > 1 && path.a[path.degree] == 0) path.degree--;
        if (!e->begun)
            e->watch[event].above[lower] = events_above(&path, fabs(series[0]) + fabs(side));
        events_cross(e, event, lower, &path, from, step->length);
    }
}

static enum pend_status events_step(struct pend_events *e, struct pend_error *error) {
    const struct pend_events_problem *problem = &e->problem;
    double from = e->reached, end = problem->duration;
    struct event_step step = {.tree = problem->tree, .loads = &problem->loads, .room = e->room};
    enum pend_status status = pend_method_taylor.step(e->stepper, end, &e->reached, error);
    if (status != PEND_OK) {
        double time = problem->start + (error ? error->time : from);
        return pend_fail(error, status, -1, time, "at t = %.6g s: %s", time,
                         pend_status_text(status));
    }
    pend_method_taylor.series(e->stepper, &step.series);
    pend_jets_forces(step.series.jets, step.series.order);
    step.time = problem->start + from;
    step.length = (end > 0 ? fmin(e->reached, end) : fmax(e->reached, end)) - from;
    step.degree = (int)fmin(step.series.order + BEYOND, EVENT_TERMS - 1);
    e->next = e->queued = 0;
    if (e->room) pend_event_series_energy(&step, e->kinetic, e->potential);
    for (int i = 0; i < problem->count; i++) events_look(e, &step, i, from);
    e->begun = 1;
    return PEND_OK;
}

/* ---- the search */

/* true if no condition has anything more to tell */
static int events_told(const struct pend_events *e) {
    for (int i = 0; i < e->problem.count; i++)
        if (e->watch[i].told < e->problem.event[i].most) return 0;
    return 1;
}

/* the next hit of the step that is to be told; 0 if there is none */
static int events_give(struct pend_events *e, struct pend_hit *hit, double phi[], double rate[]) {
    while (e->next < e->queued && !e->ended) {
        *hit = e->queue[e->next++];
        struct events_watch *watch = &e->watch[hit->event];
        const struct pend_event *asked = &e->problem.event[hit->event];
        if (watch->told >= asked->most) continue;
        const struct pend_points points = {.phi = phi, .rate = rate};
        pend_method_taylor.at(e->stepper, &hit->time, 1, &points);
        if (++watch->told == asked->stop) {
            e->stopped = hit->time;
            e->ended = 1;
        }
        return 1;
    }
    return 0;
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
        if (e->ended || (end > 0 ? e->reached >= end : e->reached <= end) || events_told(e)) {
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

long pend_events_steps(const struct pend_events *e) {
    return pend_method_taylor.counts(e->stepper).steps;
}

double pend_events_progress(const struct pend_events *e) {
    return e->ended ? 1 : fmin(1, e->reached / e->problem.duration);
}

/* ---- making and freeing */

static enum pend_status events_check(const struct pend_events_problem *problem,
                                     struct pend_error *error) {
    if (!(problem->duration != 0 && isfinite(problem->duration) && isfinite(problem->start)))
        return pend_fail(error, PEND_INVALID, -1, 0, "the duration must not be 0, got %g",
                         problem->duration);
    for (int i = 0; i < problem->count; i++) {
        const struct pend_event *event = &problem->event[i];
        int n = problem->tree->n, energy = event->quantity >= PEND_QUANTITY_KINETIC;
        int arms = event->arm >= 0 && event->arm < n && event->other >= 0 && event->other < n;
        if (!arms || !isfinite(event->level) || event->most < 1 || event->stop < 0)
            return pend_fail(error, PEND_INVALID, -1, 0, "condition %d is none", i + 1);
        if (energy && pend_terms_cart(problem->loads.terms))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "the energy of a pendulum on a cart is no condition");
    }
    return PEND_OK;
}

/* the search in one block, but for its stepper */
static struct pend_events *events_allocate(const struct pend_events_problem *problem) {
    size_t n = (size_t)problem->tree->n, count = (size_t)problem->count, room = 0;
    for (size_t i = 0; i < count; i++)
        if (problem->event[i].quantity >= PEND_QUANTITY_KINETIC)
            room = pend_event_series_room((int)n);
    struct pend_events *made =
        calloc(1, sizeof *made + room * sizeof(double) +
                      count * (sizeof *made->watch + HITS_A_STEP * sizeof *made->queue));
    if (!made) return NULL;
    made->problem = *problem;
    made->n = problem->tree->n;
    made->stopped = NAN;
    double *after = (double *)(made + 1);
    if (room) made->room = after;
    made->queue = (struct pend_hit *)(void *)(after + room);
    made->watch = (struct events_watch *)(made->queue + count * HITS_A_STEP);
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
    const struct pend_problem motion = {
        .tree = problem->tree,
        .loads = problem->loads,
        .phi = problem->phi,
        .phi_low = problem->phi_low,
        .rate = problem->rate,
        .rate_low = problem->rate_low,
        .times = {.count = 2, .start = problem->start, .span = problem->duration, .divisor = 1},
        .rtol = problem->rtol > 0 ? problem->rtol : pend_method_taylor.rtol_default,
        .atol = problem->atol};
    enum pend_status status = pend_method_taylor.open(&made->stepper, &motion, error);
    made->problem.phi = made->problem.rate = NULL;
    made->problem.phi_low = made->problem.rate_low = NULL;
    if (status != PEND_OK) {
        free(made);
        return status;
    }
    *events = made;
    assert(events_valid(made));
    return PEND_OK;
}

void pend_events_free(struct pend_events **events) {
    if (!*events) return;
    pend_method_taylor.close(&(*events)->stepper);
    free(*events);
    *events = NULL;
}
