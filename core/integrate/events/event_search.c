#include "core/integrate/events/event_search.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/tree/turns.h"

/* relative rounding error of a quantity at the start; factor by which rounding can enlarge a sum of
 * a series' terms */
static const double start_slack = 1e-14, size_slack = 1 + 1e-12;

enum pend_status pend_event_search_check(int count, const struct pend_event event[], int n,
                                         struct pend_error *error) {
    for (int i = 0; i < count; i++) {
        const struct pend_event *asked = &event[i];
        int arms = asked->arm >= 0 && asked->arm < n && asked->other >= 0 && asked->other < n;
        if (!arms || !isfinite(asked->level) || asked->most < 1 || asked->stop < 0)
            return pend_fail(error, PEND_INVALID, -1, 0, "condition %d is invalid", i + 1);
    }
    return PEND_OK;
}

static size_t search_room(int count, const struct pend_event event[], int n) {
    for (int i = 0; i < count; i++)
        if (pend_quantity_energy(event[i].quantity)) return pend_event_series_room(n);
    return 0;
}

static int search_pulls(int count, const struct pend_event event[]) {
    for (int i = 0; i < count; i++)
        if (event[i].quantity == PEND_QUANTITY_FORCE) return 1;
    return 0;
}

/* bytes before the array of the states' forces, which is aligned to 64 */
static size_t search_own(int count, const struct pend_event event[], int n) {
    return search_room(count, event, n) * sizeof(double) +
           (size_t)count * EVENT_HITS * sizeof(struct pend_hit);
}

size_t pend_event_search_bytes(int count, const struct pend_event event[],
                               const struct pend_tree *tree, const struct pend_loads *loads) {
    return search_own(count, event, tree->n) +
           (search_pulls(count, event) ? 64 + pend_event_truth_bytes(tree, loads) : 0);
}

void pend_event_search_init(struct event_search *search, int count, const struct pend_event event[],
                            const struct pend_tree *tree, void *memory) {
    assert(count >= 1 && memory);
    size_t room = search_room(count, event, tree->n), own = search_own(count, event, tree->n);
    *search = (struct event_search){.count = count, .event = event};
    search->room = room ? memory : NULL;
    search->queue = (struct pend_hit *)(void *)((double *)memory + room);
    if (!search_pulls(count, event)) return;
    char *at = (char *)memory + own;
    pend_event_truth_place(&search->truth, tree, at + (64 - (size_t)at % 64) % 64);
}

static void search_series(const struct event_search *search, const struct event_step *step,
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
            out[j] = (event->quantity == PEND_QUANTITY_POTENTIAL ? 0 : search->kinetic[j]) +
                     (event->quantity == PEND_QUANTITY_KINETIC ? 0 : search->potential[j]);
    }
}

/* whether the quantity is above the level just after the start; negative if, up to rounding, it
 * stays at the level */
static int search_side(const struct roots_path *path, double size) {
    double slack = start_slack * size;
    if (fabs(path->base + path->low) > slack) return path->base + path->low > 0;
    for (int j = 1; j <= path->degree; j++)
        if (fabs(path->a[j]) > slack) return path->a[j] > 0;
    return -1;
}

/* true if the path cannot leave its known side of the level */
static int search_stays(const struct roots_path *path, int above) {
    double size = fabs(path->low), base = path->base;
    for (int j = 1; j <= path->degree; j++) size += fabs(path->a[j]);
    return size * size_slack < fabs(base) * (2 - size_slack) && (base > 0) == above;
}

void pend_event_search_note(struct event_search *search, double time, int event, int up) {
    enum pend_way way = up ? PEND_WAY_UP : PEND_WAY_DOWN;
    if (!(search->event[event].ways & way)) return;
    assert(search->queued < search->count * EVENT_HITS);
    int i = search->queued++;
    for (; i > 0 && fabs(search->queue[i - 1].time) > fabs(time); i--)
        search->queue[i] = search->queue[i - 1];
    search->queue[i] = (struct pend_hit){time, event, way};
}

/* finds the crossings of a level in a step; the path is given minus the level */
static void search_cross(struct event_search *search, int event, int lower, int *above,
                         struct roots_path *path, double from, double length) {
    double a = 0;
    if (search_stays(path, *above)) return;
    pend_roots_divide(path);
    for (int i = 0; i < path->pieces; i++) {
        double b = path->end[i];
        int beyond = pend_roots_value(path, b) >= 0, way = 0;
        if (beyond != *above) {
            double s =
                pend_roots_next(path, a, beyond ? -INFINITY : 0, beyond ? 0 : INFINITY, &way);
            // rounding may put s before the start of the piece
            if (!(s >= a && s <= b)) s = a;
            // at the lower bound of a magnitude, a growing value moves into the interval
            pend_event_search_note(search, from + s * length, event, beyond != lower);
            *above = beyond;
        }
        a = b;
    }
}

/* rad, the turns by which the angle in an arm's lane is smaller than that of the motion */
static double search_turns(const struct event_step *step, const double turns[], int k) {
    return turns ? turns[k * step->lanes] : 0;
}

/* Returns whether only rounding changes the quantity. This is so for the total energy without work
 * and heat, whose drift in a long motion would exceed any tolerance. */
static int search_keeps(const struct event_step *step, const struct pend_event *event) {
    const struct pend_loads *loads = step->loads;
    return event->quantity == PEND_QUANTITY_ENERGY &&
           (!loads->terms || pend_terms_conserve(loads->terms, loads->value));
}

static void search_look(struct event_search *search, const struct event_step *step, int event,
                        struct event_watch *watch, double from, int first) {
    const struct pend_event *asked = &search->event[event];
    double series[EVENT_TERMS], level = asked->level, low = 0, turns = 0;
    assert(watch->told >= 0 && asked->arm < step->tree->n);
    if (watch->told >= asked->most || search_keeps(step, asked)) return;
    search_series(search, step, asked, series);
    if (asked->quantity <= PEND_QUANTITY_THETA) turns = search_turns(step, step->turns, asked->arm);
    if (asked->quantity == PEND_QUANTITY_PHI)
        low = step->phi_low[asked->arm * step->lanes] +
              search_turns(step, step->turns_low, asked->arm);
    if (asked->quantity == PEND_QUANTITY_THETA) {
        series[0] = pend_turns_theta(series[0], step->phi_low[asked->arm * step->lanes]);
        low = search_turns(step, step->turns_low, asked->arm);
    }
    if (asked->quantity == PEND_QUANTITY_DISTANCE) level *= level;
    for (int lower = 0; lower <= (asked->bound != 0); lower++) {
        struct roots_path path = {.degree = EVENT_TERMS - 1};
        double side = lower ? -level : level;
        memcpy(path.a, series, sizeof path.a);
        path.base = series[0] - (side - turns);
        path.low = low;
        while (path.degree > 1 && path.a[path.degree] == 0) path.degree--;
        if (first || watch->above[lower] < 0)
            watch->above[lower] = search_side(&path, fabs(series[0]) + fabs(side));
        if (watch->above[lower] < 0) continue;
        search_cross(search, event, lower, &watch->above[lower], &path, from, step->length);
    }
}

void pend_event_search_step(struct event_search *search, struct event_step *step,
                            struct event_watch watch[], double from, int first) {
    search->next = search->queued = 0;
    step->room = search->room;
    if (search->truth.phi && pend_dynamics_unlike(step->tree, step->loads)) {
        pend_event_series_truth(step, &search->truth);
        step->truth = &search->truth;
    }
    if (search->room) pend_event_series_energy(step, search->kinetic, search->potential);
    for (int i = 0; i < search->count; i++)
        if (search->event[i].quantity != PEND_QUANTITY_IMPACT) // an impact has no level
            search_look(search, step, i, &watch[i], from, first);
    assert(search->queued <= search->count * EVENT_HITS);
}

const struct pend_hit *pend_event_search_take(struct event_search *search,
                                              struct event_watch watch[], int *stops) {
    assert(search->next >= 0 && search->next <= search->queued);
    while (search->next < search->queued) {
        const struct pend_hit *hit = &search->queue[search->next++];
        const struct pend_event *asked = &search->event[hit->event];
        if (watch[hit->event].told >= asked->most) continue;
        *stops = ++watch[hit->event].told == asked->stop;
        return hit;
    }
    return NULL;
}

int pend_event_search_told(const struct event_search *search, const struct event_watch watch[]) {
    for (int i = 0; i < search->count; i++)
        if (watch[i].told < search->event[i].most) return 0;
    return 1;
}
