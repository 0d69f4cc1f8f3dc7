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
    size_t search = pend_event_search_bytes(problem->events, problem->event, problem->tree->n);
    return events_watches(problem, width) + (search + 63) / 64 * 64;
}

void pend_ensemble_events_place(struct pend_ensemble *e, void *memory) {
    const struct pend_ensemble_problem *problem = &e->problem;
    if (!problem->events) return;
    e->watch = memory;
    pend_event_search_init(&e->search, problem->events, problem->event, problem->tree->n,
                           (char *)memory + events_watches(problem, e->lanes.width));
}

void pend_ensemble_events_start(struct pend_ensemble *e, int i) {
    size_t count = (size_t)e->problem.events;
    assert(i >= 0 && i < e->lanes.width);
    if (count) memset(e->watch + (size_t)i * count, 0, count * sizeof *e->watch);
}

/* the tree of the member in lane i, as far as places and energies need it, and what acts on it */
static struct pend_tree events_member(const struct pend_ensemble *e, int i,
                                      struct pend_loads *loads) {
    const struct ensemble_lanes *lanes = &e->lanes;
    assert(i >= 0 && i < e->lanes.width && e->seat[i].member >= 0);
    struct pend_tree tree = *e->problem.tree;
    int width = lanes->width, terms = lanes->terms ? lanes->terms->count : 0;
    for (int k = 0; k < lanes->n; k++) {
        e->member.length[k] = lanes->len[k * width + i];
        e->member.mass[k] = lanes->mass[k * width + i];
    }
    for (int j = 0; j < terms; j++) e->member.value[j] = lanes->value[j * width + i];
    tree.len = e->member.length;
    tree.mass = e->member.mass;
    *loads = (struct pend_loads){lanes->gravity[i], lanes->terms, e->member.value};
    return tree;
}

/* hands a passage out, with the state then; returns its place in the step */
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
    struct pend_tree tree = events_member(e, i, &loads);
    double from = lanes->from.time[i];
    struct event_step step = {.tree = &tree,
                              .loads = &loads,
                              .lanes = lanes->width,
                              .rate = lanes->series + i,
                              .force = e->kernel->force(lanes) + i,
                              .share = lanes->share,
                              .phi = lanes->from.phi + i,
                              .phi_low = lanes->from.phi_low + i,
                              .turns = e->turns + i,
                              .turns_low = e->turns_low + i,
                              .order = lanes->order,
                              .unit = e->unit[i],
                              .time = lanes->start[i] + from,
                              .length = lanes->to.time[i] - from,
                              .degree = pend_event_series_degree(lanes->order)};
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
