#include "core/integrate/run/run.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics_at.h"
#include "core/integrate/pieces/control.h"
#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/run_check.h"
#include "core/integrate/run/run_samples.h"
#include "core/tree/turns.h"

/* samples are computed in groups of at most this many instants, and numbers per array */
enum { RUN_GROUP = 64, RUN_GROUP_NUMBERS = 8192 };
/* energies at the ends of several steps are computed together: at most this many, and about this
 * many numbers per array */
enum { RUN_ENDS = 16, RUN_ENDS_NUMBERS = 64 };
/* after this many evaluations times arms, the rows of a block are checked although it is not full,
 * because values that overflow can make steps so short that it never fills */
static const double RUN_LOOK = 1e6;

PEND_VALIDATOR run_valid(const struct pend_run *run) {
    const struct pend_times *times = &run->problem.times;
    return run->next >= 0 && run->next <= times->count && run->group >= 1 && run->listed >= 0 &&
           run->listed <= run->group && run->ends.count >= 0 && run->ends.count < run->ends.cap;
}

/* ---- creation and release */

/* reserves `bytes` in a block, aligned to 64; if base is NULL, only counts them */
static void *run_take(char *base, size_t *used, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (bytes + 63) / 64 * 64;
    return part;
}

static size_t run_place(struct pend_run *run, char *base, int group, double *start[4]) {
    const struct pend_problem *problem = &run->problem;
    int n = problem->tree->n;
    size_t used = 0, row = (size_t)n * sizeof(double), rows = row * (size_t)group;
    run_take(base, &used, sizeof *run);
    for (int i = 0; i < 4; i++) start[i] = run_take(base, &used, row);
    run->t = run_take(base, &used, (size_t)group * sizeof(double));
    run->relative = run_take(base, &used, (size_t)group * sizeof(double));
    run->points.phi = run_take(base, &used, rows);
    run->points.rate = run_take(base, &used, rows);
    run->points.acc = run_take(base, &used, rows);
    run->points.force = run_take(base, &used, rows);
    run->points.theta = run_take(base, &used, rows);
    run->spare = run->unlike ? run_take(base, &used, rows) : NULL;
    run->ends.phi = run_take(base, &used, row * (size_t)run->ends.cap);
    run->ends.rate = run_take(base, &used, row * (size_t)run->ends.cap);
    run->re = run_take(base, &used, row);
    run->im = run_take(base, &used, row);
    run->scratch = run_take(base, &used, 3 * row);
    run->turns = run_take(base, &used, row);
    run->turns_low = run_take(base, &used, row);
    run->ends.time = run_take(base, &used, (size_t)run->ends.cap * sizeof(double));
    run->ends.room = run_take(base, &used, 2 * row * (size_t)(run->ends.cap + 1));
    run->ends.work = run_take(base, &used, (size_t)run->ends.cap * sizeof(double));
    run->ends.heat = run_take(base, &used, (size_t)run->ends.cap * sizeof(double));
    run->room = run_take(base, &used, 4 * row);
    run->work =
        run_take(base, &used,
                 problem->loads.terms ? pend_dynamics_at_bytes(problem->tree, &problem->loads)
                                      : pend_dynamics_many_bytes(n));
    return used;
}

static int run_ends(int n) {
    int ends = RUN_ENDS_NUMBERS / n;
    return ends < 1 ? 1 : ends > RUN_ENDS ? RUN_ENDS : ends;
}

/* if an angle is huge, subtracts whole turns from the copied start; returns whether it did */
static int run_turn(const struct pend_run *run, double *start[4]) {
    const struct pend_problem *problem = &run->problem;
    int n = problem->tree->n, turned = 0;
    if (!pend_terms_whole_turns(problem->loads.terms)) return 0;
    for (int k = 0; k < n; k++) turned |= fabs(problem->phi[k]) > PEND_TURNS_FROM;
    for (int k = 0; k < n && turned; k++) {
        struct pend_sum turns;
        struct pend_sum rest =
            pend_turns_rest(problem->phi[k], problem->phi_low ? problem->phi_low[k] : 0, &turns);
        start[0][k] = rest.high, start[2][k] = rest.low;
        run->turns[k] = turns.high, run->turns_low[k] = turns.low;
    }
    return turned;
}

/* creates a run in one block, with a copy of the initial state, without a stepper */
static struct pend_run *run_allocate(const struct pend_method *method,
                                     const struct pend_problem *problem) {
    int n = problem->tree->n, group = RUN_GROUP_NUMBERS / n;
    group = group < 1 ? 1 : group > RUN_GROUP ? RUN_GROUP : group;
    struct pend_run sketch = {.method = method, .problem = *problem, .group = group};
    sketch.ends.cap = run_ends(n);
    sketch.unlike = pend_pieces_smooth(problem->loads.terms) &&
                    method->flags & PEND_METHOD_SERIES && method->series &&
                    pend_dynamics_unlike(problem->tree, &problem->loads);
    double *start[4];
    const double *given[4] = {problem->phi, problem->rate, problem->phi_low, problem->rate_low};
    size_t bytes = run_place(&sketch, NULL, group, start);
    char *block = aligned_alloc(64, bytes);
    if (!block) return NULL;
#ifndef NDEBUG
    memset(block, 0xff, bytes); /* all bits set are NaNs, so that uninitialized values show */
#endif
    run_place(&sketch, block, group, start);
    for (int i = 0; i < 4; i++)
        if (given[i]) memcpy(start[i], given[i], (size_t)n * sizeof(double));
    sketch.turned = run_turn(&sketch, start);
    for (int k = 0; k < n && problem->phi_low; k++) sketch.fine |= problem->phi_low[k] != 0;
    sketch.problem.phi = start[0];
    sketch.problem.rate = start[1];
    sketch.problem.phi_low = given[2] || sketch.turned ? start[2] : NULL;
    sketch.problem.rate_low = given[3] ? start[3] : NULL;
    struct pend_run *run = (struct pend_run *)block;
    *run = sketch;
    return run;
}

static void run_start(struct pend_run *run) {
    const struct pend_problem *problem = &run->problem;
    const struct pend_tree *tree = problem->tree;
    run->start = pend_times_at(&problem->times, 0);
    run->end = pend_times_at(&problem->times, problem->times.count - 1) - run->start;
    run->ordered = 1;
    for (int k = 0; k < tree->n; k++) run->ordered &= tree->order[k] == k;
    /* a sum of n modes costs about n^2 multiply-adds, each an eighth of an arm evaluation */
    run->sample_cost =
        run->method->flags & PEND_METHOD_LINEAR ? tree->n * (1 + tree->n / 8.0) : tree->n;
    struct pend_energy energy = pend_kinematics_energy_at(tree, &problem->loads, run->start,
                                                          problem->phi, problem->rate, run->room);
    run->energy_start = energy.kinetic + energy.potential;
    run->scale = pend_kinematics_energy_scale_at(tree, &problem->loads, energy.kinetic);
    run->gives =
        problem->loads.terms && !pend_terms_conserve(problem->loads.terms, problem->loads.value);
    assert(!run->gives || run->method->exchange);
}

enum pend_status pend_run_new(struct pend_run **run, const struct pend_method *method,
                              const struct pend_problem *problem, struct pend_error *error) {
    struct pend_problem checked = *problem;
    *run = NULL;
    PEND_TRY(pend_run_check(method, &checked, error));
    method = pend_pieces_method(method, problem->loads.terms);
    struct pend_run *made = run_allocate(method, &checked);
    if (!made)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a run of %d arms",
                         problem->tree->n);
    run_start(made);
    enum pend_status status = method->open(&made->stepper, &made->problem, error);
    if (status == PEND_OK)
        made->problem.loads = pend_pieces_loads(method, made->stepper, &made->problem.loads);
    if (status == PEND_OK && problem->accuracy > 0 &&
        !pend_pieces_unestimated(problem->loads.terms) && !(method->flags & PEND_METHOD_LINEAR)) {
        status = pend_horizon_new(&made->horizon, method, &made->problem, error);
        if (status != PEND_OK) method->close(&made->stepper);
    }
    if (status != PEND_OK)
        free(made);
    else
        *run = made;
    assert(status != PEND_OK || run_valid(*run));
    return status;
}

void pend_run_free(struct pend_run **run) {
    if (!*run) return;
    pend_horizon_free(&(*run)->horizon);
    (*run)->method->close(&(*run)->stepper);
    free(*run);
    *run = NULL;
}

/* ---- failures */

/* ends a run: every later call returns the same failure */
static enum pend_status run_fail(struct pend_run *run, struct pend_error *error,
                                 enum pend_status code, int arm, double t, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

static enum pend_status run_fail(struct pend_run *run, struct pend_error *error,
                                 enum pend_status code, int arm, double t, const char *format,
                                 ...) {
    char text[sizeof run->failure.text];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pend_fail(&run->failure, code, arm, t, "at t = %.6g s: %.*s", t, (int)sizeof text - 40, text);
    if (error) *error = run->failure;
    return code;
}

/* ---- steps */

/* computes the drift of a real pendulum's energy: the energy minus the work plus the heat, relative
 * to a scale that grows with all three */
static void run_balance(struct pend_run *run, const struct pend_energy energy[]) {
    const struct run_ends *ends = &run->ends;
    for (int i = 0; i < ends->count; i++) {
        double sum = energy[i].kinetic + energy[i].potential, given = ends->work[i] - ends->heat[i];
        double most = energy[i].kinetic + fabs(ends->work[i]) + fabs(ends->heat[i]);
        run->scale = fmax(run->scale, most);
        double gap = fabs((sum - run->energy_start) - given);
        if (run->scale > 0) run->drift = fmax(run->drift, gap / run->scale);
    }
}

/* updates the energy drift with the steps whose energies are not computed yet */
static void run_weigh(struct pend_run *run) {
    const struct pend_problem *problem = &run->problem;
    struct run_ends *ends = &run->ends;
    struct pend_energy energy[RUN_ENDS];
    double most = 0;
    int count = ends->count;
    if (!count) return;
    pend_kinematics_energies_at(problem->tree, &problem->loads, count, ends->time, ends->phi,
                                ends->rate, ends->room, energy);
    if (problem->loads.terms) run_balance(run, energy);
    ends->count = 0;
    if (problem->loads.terms) return;
    for (int i = 0; i < count; i++) {
        double drift = fabs(energy[i].kinetic + energy[i].potential - run->energy_start);
        if (drift > most) most = drift;
    }
    if (run->scale > 0) run->drift = fmax(run->drift, most / run->scale);
}

/* stores the end of a step for its energy, and checks that it is finite */
static enum pend_status run_inspect(struct pend_run *run, struct pend_error *error) {
    const struct pend_tree *tree = run->problem.tree;
    struct run_ends *ends = &run->ends;
    size_t row = (size_t)ends->count * (size_t)tree->n;
    double *phi = ends->phi + row, *rate = ends->rate + row;
    run->method->at(run->stepper, &run->reached, 1,
                    &(struct pend_points){.phi = phi, .rate = rate});
    if (!pend_run_finite(phi, tree->n) || !pend_run_finite(rate, tree->n)) {
        int k = 0;
        while (isfinite(phi[k]) && isfinite(rate[k])) k++;
        return run_fail(run, error, PEND_NOT_FINITE, tree->order[k], run->start + run->reached,
                        "the motion of arm %d ceased to be finite", tree->order[k] + 1);
    }
    if (run->horizon) pend_horizon_step(run->horizon, run->stepper, run->reached, phi, rate);
    int i = ends->count;
    if (run->problem.loads.terms) {
        ends->time[i] = run->start + run->reached;
        ends->work[i] = ends->heat[i] = 0;
        if (run->gives)
            run->method->exchange(run->stepper, &run->reached, 1, &ends->work[i], &ends->heat[i]);
    }
    if (!run->problem.no_drift && ++ends->count == ends->cap) run_weigh(run);
    return PEND_OK;
}

static enum pend_status run_step(struct pend_run *run, double *spent, struct pend_error *error) {
    const struct pend_problem *problem = &run->problem;
    const struct pend_method *method = run->method;
    struct pend_stepper_counts before = method->counts(run->stepper);
    if (problem->step_cap && before.steps >= problem->step_cap)
        return run_fail(run, error, PEND_TOO_MANY_STEPS, -1, run->start + run->reached,
                        "the limit of %ld steps was reached before the last instant, %.6g s",
                        problem->step_cap, run->start + run->end);
    double limit = run->end;
    if (method->flags & PEND_METHOD_LANDS)
        limit = pend_times_at(&problem->times, run->next) - run->start;
    struct pend_error fault;
    fault.arm = -1;
    fault.text[0] = 0; // only read after a failure, and too large to be
                       // cleared in every step
    enum pend_status status = method->step(run->stepper, limit, &run->reached, &fault);
    if (status != PEND_OK)
        return run_fail(run, error, status, fault.arm, run->start + run->reached, "%s", fault.text);
    *spent +=
        (double)(method->counts(run->stepper).evaluations - before.evaluations) * problem->tree->n;
    return method->flags & PEND_METHOD_LINEAR ? PEND_OK : run_inspect(run, error);
}

/* ---- samples */

static void run_list(struct pend_run *run) {
    const struct pend_times *times = &run->problem.times;
    long left = times->count - run->next;
    run->listed = left < run->group ? (int)left : run->group;
    run->listed_from = run->next;
    pend_times_list(times, run->next, run->listed, run->t);
    for (int i = 0; i < run->listed; i++) run->relative[i] = run->t[i] - run->start;
}

/* counts the listed instants up to the end of the last step, at most `most` */
static int run_due(struct pend_run *run, long most) {
    if (run->next < run->listed_from || run->next >= run->listed_from + run->listed) run_list(run);
    int due = 0, from = (int)(run->next - run->listed_from), left = run->listed - from;
    const double *relative = run->relative + from;
    if (most < left) left = (int)most;
    for (; due < left; due++)
        if (run->end < 0 ? relative[due] < run->reached : relative[due] > run->reached) break;
    return due;
}

/* removes the rows from the first non-finite value on; such a value ends the run */
static enum pend_status run_hand_out(struct pend_run *run, struct pend_samples *samples,
                                     enum pend_status status, struct pend_error *error) {
    struct run_flaw flaw = pend_run_find_flaw(run, samples);
    if (flaw.row == samples->count) return status;
    run->next -= samples->count - flaw.row;
    samples->count = flaw.row;
    double t = samples->t[flaw.row];
    if (flaw.arm < 0)
        return run_fail(run, error, PEND_NOT_FINITE, -1, t, "the %s is too large a number",
                        flaw.what);
    return run_fail(run, error, PEND_NOT_FINITE, flaw.arm, t,
                    "the %s of arm %d is too large a number", flaw.what, flaw.arm + 1);
}

enum pend_status pend_run_next(struct pend_run *run, struct pend_samples *samples, double work,
                               int *done, struct pend_error *error) {
    assert(run_valid(run) && samples->cap >= 1 && samples->t);
    double spent = 0, look = RUN_LOOK;
    enum pend_status status = PEND_OK;
    samples->count = 0;
    *done = 0;
    if (run->failure.code != PEND_OK) {
        if (error) *error = run->failure;
        return run->failure.code;
    }
    do {
        if (run->next == run->problem.times.count || samples->count == samples->cap) break;
        int due = run_due(run, samples->cap - samples->count);
        if (due)
            pend_run_sample(run, samples, due);
        else
            status = run_step(run, &spent, error);
        spent += due * run->sample_cost;
        if (spent >= look) {
            status = run_hand_out(run, samples, status, error);
            look = spent + RUN_LOOK;
        }
    } while (status == PEND_OK && spent < work);
    run_weigh(run);
    status = run_hand_out(run, samples, status, error);
    *done = status == PEND_OK && run->next == run->problem.times.count;
    assert(run_valid(run) && run->ends.count == 0);
    assert(samples->count >= 0 && samples->count <= samples->cap);
    return status;
}

/* ---- statistics */

/* the fraction of the time up to the first instant without a sample, or up to the end of the last
 * step */
static double run_progress(const struct pend_run *run) {
    const struct pend_times *times = &run->problem.times;
    if (run->next == times->count) return 1;
    if (run->end == 0) return 0;
    double next = pend_times_at(times, run->next) - run->start;
    return fmin(next / run->end, run->reached / run->end);
}

struct pend_run_stats pend_run_stats(const struct pend_run *run) {
    struct pend_stepper_counts counts = run->method->counts(run->stepper);
    double held = run->horizon ? pend_horizon_held(run->horizon, run->reached) : NAN;
    int weighed = run->problem.no_drift || (isfinite(run->energy_start) && isfinite(run->scale));
    const double *own = pend_pieces_control(run->method, run->stepper);
    int controller = 0;
    double saturated = own ? pend_control_saturated(run->problem.loads.terms->rules,
                                                    run->problem.tree->n, own, &controller)
                           : 0;
    return (struct pend_run_stats){.method = run->method->name,
                                   .saturated = saturated,
                                   .controller = controller,
                                   .steps = counts.steps,
                                   .rejected = counts.rejected,
                                   .evaluations = counts.evaluations,
                                   .energy_drift = weighed ? run->drift : NAN,
                                   .horizon = run->horizon ? pend_horizon_until(run->horizon) : NAN,
                                   .held = run->start + held,
                                   .progress = run_progress(run)};
}

/* ---- checkpoints */

int pend_run_carries(const struct pend_method *method) { return method->carry != NULL; }

enum pend_status pend_run_carry(struct pend_run *run, struct pend_checkpoint *checkpoint) {
    assert(run_valid(run) && run->failure.code == PEND_OK && run->method->carry);
    pend_checkpoint_part(checkpoint, &run->reached, sizeof run->reached);
    pend_checkpoint_counts(checkpoint, &run->next, 1);
    pend_checkpoint_part(checkpoint, &run->drift, sizeof run->drift);
    pend_checkpoint_part(checkpoint, &run->scale, sizeof run->scale);
    run->method->carry(run->stepper, checkpoint);
    if (run->horizon) PEND_TRY(pend_horizon_carry(run->horizon, checkpoint));
    /* after a refused checkpoint, the state of the run is incomplete */
    if (!pend_checkpoint_puts(checkpoint)) return PEND_OK;
    int good = run->next <= run->problem.times.count && isfinite(run->reached) &&
               isfinite(run->drift) && isfinite(run->scale);
    return good ? PEND_OK : PEND_INVALID;
}
