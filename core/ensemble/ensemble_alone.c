#include "core/ensemble/ensemble_alone.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/ensemble/ensemble_watch.h"
#include "core/integrate/events/events.h"
#include "core/integrate/pieces/pieces.h"

enum pend_status pend_ensemble_alone_check(const struct pend_ensemble_problem *problem,
                                           struct pend_error *error) {
    const struct pend_terms *terms = problem->loads.terms;
    unsigned observe = problem->observe;
    if (pend_pieces_unestimated(terms) &&
        (observe & PEND_OBSERVE_LYAPUNOV || problem->accuracy > 0))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "exponents and horizons are not computed with controllers, stops or "
                         "friction that holds");
    if (pend_pieces_smooth(terms) || (problem->duration >= 0 && problem->bound == 0 &&
                                      !(observe & ~(unsigned)PEND_OBSERVE_ENERGY)))
        return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "joints that stick or hit are followed forward in time only, without flips, "
                     "extremes and signs of forces: use conditions on angles, or trajectories");
}

void pend_ensemble_alone_close(struct pend_ensemble *e) {
    pend_events_free(&e->alone.search);
    if (e->alone.stepper) e->alone.method->close(&e->alone.stepper);
}

void pend_ensemble_fetch(struct pend_ensemble *e, long i, struct ensemble_queue *queue) {
    const struct pend_tree *tree = e->problem.tree;
    size_t bytes = (size_t)tree->n * sizeof(double);
    memset(e->member.phi, 0, bytes);
    memset(e->member.phi_low, 0, bytes);
    memset(e->member.rate, 0, bytes);
    memcpy(e->member.length, tree->len, bytes);
    memcpy(e->member.mass, tree->mass, bytes);
    e->member.loads = e->problem.loads;
    e->member.start = 0;
    if (e->lanes.terms) {
        memcpy(e->member.value, e->problem.loads.value,
               (size_t)e->lanes.terms->count * sizeof(double));
        e->member.loads.value = e->member.value;
    }
    if (e->problem.fetch(e->problem.context, i, &e->member)) queue->cancelled = 1;
}

static enum pend_status alone_search(struct pend_ensemble *e, struct pend_error *error) {
    const struct pend_ensemble_problem *of = &e->problem;
    const struct pend_events_problem problem = {.tree = &e->alone.tree,
                                                .loads = e->member.loads,
                                                .phi = e->member.phi,
                                                .rate = e->member.rate,
                                                .phi_low = e->member.phi_low,
                                                .start = e->member.start,
                                                .duration = of->duration,
                                                .rtol = of->rtol,
                                                .atol = of->atol,
                                                .count = of->events,
                                                .event = of->event};
    return pend_events_new(&e->alone.search, &problem, error);
}

static enum pend_status alone_open(struct pend_ensemble *e, struct pend_error *error) {
    struct ensemble_alone *alone = &e->alone;
    const struct pend_member *member = &e->member;
    const struct pend_problem problem = {
        .tree = &alone->tree,
        .loads = member->loads,
        .phi = member->phi,
        .rate = member->rate,
        .phi_low = member->phi_low,
        .times = {.count = 2, .start = member->start, .span = e->problem.duration, .divisor = 1},
        .rtol = e->problem.rtol,
        .atol = e->problem.atol};
    PEND_TRY(alone->method->open(&alone->stepper, &problem, error));
    struct pend_energy energy = pend_kinematics_energy_at(
        &alone->tree, &member->loads, member->start, member->phi, member->rate, e->room);
    e->seat[0].energy = energy.kinetic + energy.potential;
    e->seat[0].scale =
        pend_kinematics_energy_scale_at(&alone->tree, &member->loads, energy.kinetic);
    return PEND_OK;
}

/* reports the next passage; the search ends after the last passage */
static enum pend_status alone_look(struct pend_ensemble *e, struct pend_error *error) {
    enum { STEPS = 20 };
    struct ensemble_alone *alone = &e->alone;
    enum pend_found found;
    struct pend_hit hit;
    PEND_TRY(pend_events_next(alone->search, STEPS, &found, &hit, e->phi, e->rate, error));
    if (found == PEND_FOUND_PASSAGE)
        e->problem.hit(e->problem.context, e->seat[0].member, &hit, e->phi, e->rate);
    if (found != PEND_FOUND_END) return PEND_OK;
    double stopped = pend_events_stopped(alone->search);
    if (!isnan(stopped)) alone->end = stopped;
    alone->searched = 1;
    return PEND_OK;
}

/* reports the rows whose instants lie in the last step */
static void alone_rows(struct pend_ensemble *e, double until) {
    struct ensemble_seat *seat = &e->seat[0];
    const struct pend_points points = {.phi = e->rows[0],
                                       .rate = e->rows[1],
                                       .acc = e->instants[0],
                                       .force = e->rows[2],
                                       .theta = e->rows[3]};
    for (; seat->row < e->problem.times_count && e->problem.times[seat->row] <= until;
         seat->row++) {
        e->alone.method->at(e->alone.stepper, e->problem.times + seat->row, 1, &points);
        e->problem.rows(e->problem.context, seat->member, seat->row, 1, e->rows[0], e->rows[1],
                        e->rows[2], e->rows[3]);
    }
}

/* the energy change that drives, friction and impacts do not explain, relative to the scale */
static double alone_drift(struct pend_ensemble *e) {
    const struct ensemble_alone *alone = &e->alone;
    double work, heat, time = e->member.start + alone->end;
    alone->method->exchange(alone->stepper, &alone->end, 1, &work, &heat);
    struct pend_energy energy =
        pend_kinematics_energy_at(&alone->tree, &e->member.loads, time, e->phi, e->rate, e->room);
    double gap = energy.kinetic + energy.potential - e->seat[0].energy - (work - heat);
    double scale = fmax(e->seat[0].scale, energy.kinetic + fabs(work) + fabs(heat));
    return scale > 0 ? fabs(gap) / scale : 0;
}

/* takes a step of the motion; sets *last if it was the last one */
static enum pend_status alone_move(struct pend_ensemble *e, int *last, struct pend_error *error) {
    struct ensemble_alone *alone = &e->alone;
    const struct pend_points points = {.phi = e->phi, .rate = e->rate};
    PEND_TRY(alone->method->step(alone->stepper, alone->end, &alone->reached, error));
    *last = alone->reached >= alone->end;
    double now = fmin(alone->reached, alone->end);
    if (e->problem.times_count) alone_rows(e, now);
    if (!(e->problem.settle > 0) && !*last) return PEND_OK;
    alone->method->at(alone->stepper, &now, 1, &points);
    pend_ensemble_watch_settled(e, 0, e->phi, &e->member.loads, e->member.start + now);
    return PEND_OK;
}

/* fills in the results of a member at its end */
static void alone_tell(struct pend_ensemble *e, enum pend_status status,
                       struct pend_outcome *outcome) {
    struct ensemble_alone *alone = &e->alone;
    int moved = status == PEND_OK && alone->stepper;
    *outcome = (struct pend_outcome){
        .stop = status != PEND_OK                   ? PEND_STOP_FAILED
                : alone->end != e->problem.duration ? PEND_STOP_EVENT
                                                    : PEND_STOP_TIME,
        .status = status,
        .time = status == PEND_OK ? alone->end : alone->reached,
        .arm = -1,
        .first = NAN,
        .phi = e->phi,
        .rate = e->rate,
        .energy_drift = NAN,
        .horizon = NAN,
        .settled = e->seat[0].settled <= 0.9 * alone->end ? e->seat[0].settled : NAN,
        .lyapunov = NAN,
        .steps = alone->search ? pend_events_steps(alone->search) : 0};
    if (alone->stepper) outcome->steps += alone->method->counts(alone->stepper).steps;
    if (moved && e->problem.observe & PEND_OBSERVE_ENERGY) outcome->energy_drift = alone_drift(e);
}

/* takes the next step of the search, then of the motion; sets *ended if nothing is left to do */
static enum pend_status alone_go(struct pend_ensemble *e, int *ended, struct pend_error *error) {
    struct ensemble_alone *alone = &e->alone;
    if (e->problem.events && !alone->search) PEND_TRY(alone_search(e, error));
    if (alone->search && !alone->searched) return alone_look(e, error);
    if ((*ended = e->problem.until == PEND_UNTIL_TOLD)) return PEND_OK;
    if (!alone->stepper) PEND_TRY(alone_open(e, error));
    return alone_move(e, ended, error);
}

enum pend_status pend_ensemble_alone_step(struct pend_ensemble *e, struct ensemble_queue *queue) {
    struct ensemble_seat *seat = &e->seat[0];
    struct ensemble_alone *alone = &e->alone;
    struct pend_outcome outcome;
    struct pend_error error;
    int ended = 0;
    if (seat->member < 0) {
        pend_ensemble_fetch(e, queue->next, queue);
        *seat = (struct ensemble_seat){.member = queue->next++, .settled = NAN};
        *alone = (struct ensemble_alone){
            .tree = pend_member_tree(e->problem.tree, &e->member, e->subtree),
            .method = alone->method,
            .end = e->problem.duration};
        e->lanes.start[0] = e->member.start;
    }
    if (queue->cancelled) return PEND_OK;
    enum pend_status status = alone_go(e, &ended, &error);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK && !ended && e->problem.step_cap > 0 &&
        ++seat->steps >= e->problem.step_cap)
        status = PEND_TOO_MANY_STEPS;
    if (status == PEND_OK && !ended) return PEND_OK;
    alone_tell(e, status, &outcome);
    pend_ensemble_alone_close(e);
    queue->cancelled |= e->problem.deliver(e->problem.context, seat->member, &outcome) != 0;
    seat->member = -1;
    queue->left--;
    return PEND_OK;
}
