#include "core/ensemble/ensemble_events.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/ensemble/ensemble_watch.h"
#include "core/tree/turns.h"

static size_t events_watches(const struct pend_ensemble_problem *problem, int width) {
    size_t bytes = (size_t)width * (size_t)problem->events * sizeof(struct event_watch);
    return (bytes + 63) / 64 * 64;
}

size_t pend_ensemble_events_bytes(const struct pend_ensemble_problem *problem, int width) {
    if (!problem->events) return 0;
    size_t search =
        pend_event_search_bytes(problem->events, problem->event, problem->tree, &problem->loads);
    return events_watches(problem, width) + (search + 63) / 64 * 64;
}

void pend_ensemble_events_place(struct pend_ensemble *e, void *memory) {
    const struct pend_ensemble_problem *problem = &e->problem;
    if (!problem->events) return;
    e->watch = memory;
    pend_event_search_init(&e->search, problem->events, problem->event, problem->tree,
                           (char *)memory + events_watches(problem, e->lanes.width));
}

/* reports a passage with its state; returns the fraction of the step at which it lies */
static double events_give(struct pend_ensemble *e, int i, const struct pend_hit *hit) {
    const struct ensemble_lanes *lanes = &e->lanes;
    double from = lanes->from.time[i], length = lanes->to.time[i] - from;
    assert(length != 0);
    double part = fmin(fmax((hit->time - from) / length, 0), 1);
    pend_ensemble_watch_state(e, i, part);
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i;
        e->phi[k] = pend_turns_add(e->phi[k], e->turns[at], e->turns_low[at]);
    }
    e->problem.hit(e->problem.context, e->seat[i].member, hit, e->phi, e->rate);
    return part;
}

double pend_ensemble_events_step(struct pend_ensemble *e, int i) {
    const struct ensemble_lanes *lanes = &e->lanes;
    struct event_watch *watch = e->watch + (size_t)i * (size_t)e->problem.events;
    struct pend_loads loads;
    struct pend_tree tree;
    double from = lanes->from.time[i];
    struct event_step step = pend_ensemble_watch_step(e, i, &tree, &loads);
    int stops = 0;
    assert(e->problem.events > 0 && e->problem.hit);
    pend_event_search_step(&e->search, &step, watch, from, e->seat[i].steps == 1);
    const struct pend_hit *hit;
    while ((hit = pend_event_search_take(&e->search, watch, &stops))) {
        double part = events_give(e, i, hit);
        if (stops) return part;
    }
    int told = e->problem.until == PEND_UNTIL_TOLD && pend_event_search_told(&e->search, watch);
    return told ? 1 : INFINITY;
}
