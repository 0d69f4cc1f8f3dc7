#include "core/integrate/run.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/integrate/horizon.h"
#include "core/dynamics/kinematics.h"
#include "core/integrate/run_check.h"
#include "core/tree/turns.h"

/* samples are made in groups: at most this many instants, and about this many numbers an array */
enum { RUN_GROUP = 64, RUN_GROUP_NUMBERS = 8192 };
/* ends of steps whose energies are found together: at most this many, and about this many
 * numbers an array */
enum { RUN_ENDS = 16, RUN_ENDS_NUMBERS = 64 };
/* evaluations times arms after which the block's rows are looked at before it is full: numbers
 * that overflow can make steps so short that it never would be */
static const double RUN_LOOK = 1e6;

/* States at the ends of the last steps, whose energies nobody has looked at. None is left when
 * pend_run_next returns.
 */
struct run_ends {
    int count, cap;
    double *phi, *rate; /* stored order */
};

struct pend_run {
    const struct pend_method *method;
    struct pend_problem problem; /* phi and rate point into this block */
    void *stepper;
    struct pend_horizon *horizon; /* NULL: nobody asks */
    double start, end;            /* s: the first instant, and the last one relative to it */
    double reached;               /* s, relative: what the steps have reached */
    long next;                    /* number of the first instant that was not handed out */
    int group;                    /* most instants in one group */
    long listed_from;             /* number of the first instant in t */
    int listed;                   /* instants in t */
    int ordered;                  /* stored order is the caller's order */
    double sample_cost;           /* arm-evaluations that a sample stands for */
    double scale, energy_start, drift;
    struct pend_error failure; /* code PEND_OK: none */
    double *t, *relative;      /* the next instants, and the same relative to the first */
    struct pend_points points; /* a group's states, stored order */
    struct run_ends ends;
    double *re, *im, *scratch; /* one row each, and three */
    double *turns,
        *turns_low; /* rad, what the start's angles are larger by than the run's, stored order */
    int turned;     /* there is such a thing */
    int fine;       /* the start has digits that doubles do not hold */
    void *work;     /* of pend_dynamics_many */
};

/* ---- making and freeing */

/* takes `bytes` from a block, aligned to 64; with base NULL only counts them */
static void *run_take(char *base, size_t *used, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (bytes + 63) / 64 * 64;
    return part;
}

/* places a run's parts in its block; says how many bytes they need */
static size_t run_place(struct pend_run *run, char *base, int n, int group, double *start[4]) {
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
    run->ends.phi = run_take(base, &used, row * (size_t)run->ends.cap);
    run->ends.rate = run_take(base, &used, row * (size_t)run->ends.cap);
    run->re = run_take(base, &used, row);
    run->im = run_take(base, &used, row);
    run->scratch = run_take(base, &used, 3 * row);
    run->turns = run_take(base, &used, row);
    run->turns_low = run_take(base, &used, row);
    run->work = run_take(base, &used, pend_dynamics_many_bytes(n));
    return used;
}

static int run_group(int n) {
    int group = RUN_GROUP_NUMBERS / n;
    return group < 1 ? 1 : group > RUN_GROUP ? RUN_GROUP : group;
}

static int run_ends(int n) {
    int ends = RUN_ENDS_NUMBERS / n;
    return ends < 1 ? 1 : ends > RUN_ENDS ? RUN_ENDS : ends;
}

/* takes whole turns from the angles of a start that was copied, where one is huge; returns
 * whether it is so */
static int run_turn(const struct pend_run *run, double *start[4]) {
    const struct pend_problem *problem = &run->problem;
    int n = problem->tree->n, turned = 0;
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

/* a run in one block, its problem's state copied, no stepper yet */
static struct pend_run *run_allocate(const struct pend_method *method,
                                     const struct pend_problem *problem) {
    int n = problem->tree->n, group = run_group(n);
    struct pend_run sketch = {.method = method, .problem = *problem, .group = group};
    sketch.ends.cap = run_ends(n);
    double *start[4];
    const double *given[4] = {problem->phi, problem->rate, problem->phi_low, problem->rate_low};
    size_t bytes = run_place(&sketch, NULL, n, group, start);
    char *block = aligned_alloc(64, bytes);
    if (!block) return NULL;
#ifndef NDEBUG
    memset(block, 0xff, bytes); /* not-a-numbers, so that reading before writing shows */
#endif
    run_place(&sketch, block, n, group, start);
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
    /* a sum of n modes: a multiply and add takes about an eighth of an arm-evaluation */
    run->sample_cost =
        run->method->flags & PEND_METHOD_LINEAR ? tree->n * (1 + tree->n / 8.0) : tree->n;
    struct pend_energy energy =
        pend_kinematics_energy(tree, &problem->loads, problem->phi, problem->rate);
    run->energy_start = energy.kinetic + energy.potential;
    run->scale = pend_kinematics_energy_scale(tree, &problem->loads, energy.kinetic);
}

enum pend_status pend_run_new(struct pend_run **run, const struct pend_method *method,
                              const struct pend_problem *problem, struct pend_error *error) {
    struct pend_problem checked = *problem;
    *run = NULL;
    PEND_TRY(pend_run_check(method, &checked, error));
    struct pend_run *made = run_allocate(method, &checked);
    if (!made)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a run of %d arms",
                         problem->tree->n);
    run_start(made);
    enum pend_status status = method->open(&made->stepper, &made->problem, error);
    if (status == PEND_OK && problem->accuracy > 0) {
        status = pend_horizon_new(&made->horizon, method, &made->problem, error);
        if (status != PEND_OK) method->close(&made->stepper);
    }
    if (status != PEND_OK)
        free(made);
    else
        *run = made;
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

/* ends a run for good: the failure is kept and told again to whoever asks for more */
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

/* energy drift of the steps since it was last looked at */
static void run_weigh(struct pend_run *run) {
    const struct pend_problem *problem = &run->problem;
    struct run_ends *ends = &run->ends;
    struct pend_energy energy[RUN_ENDS];
    double most = 0;
    if (!ends->count) return;
    pend_kinematics_energies(problem->tree, &problem->loads, ends->count, ends->phi, ends->rate,
                             energy);
    for (int i = 0; i < ends->count; i++) {
        double drift = fabs(energy[i].kinetic + energy[i].potential - run->energy_start);
        if (drift > most) most = drift;
    }
    if (run->scale > 0) run->drift = fmax(run->drift, most / run->scale);
    ends->count = 0;
}

/* keeps the end of a step for its energy, and sees whether it is still made of numbers */
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
    fault.text[0] = 0; // the rest of it is only read after a failure, and is large for a step
    enum pend_status status = method->step(run->stepper, limit, &run->reached, &fault);
    if (status != PEND_OK)
        return run_fail(run, error, status, fault.arm, run->start + run->reached, "%s", fault.text);
    *spent +=
        (double)(method->counts(run->stepper).evaluations - before.evaluations) * problem->tree->n;
    return method->flags & PEND_METHOD_LINEAR ? PEND_OK : run_inspect(run, error);
}

/* ---- samples */

/* lists the instants from the next one on */
static void run_list(struct pend_run *run) {
    const struct pend_times *times = &run->problem.times;
    long left = times->count - run->next;
    run->listed = left < run->group ? (int)left : run->group;
    run->listed_from = run->next;
    pend_times_list(times, run->next, run->listed, run->t);
    for (int i = 0; i < run->listed; i++) run->relative[i] = run->t[i] - run->start;
}

/* counts the wanted instants within reach, at most `most` and as far as they are listed */
static int run_due(struct pend_run *run, long most) {
    if (run->next < run->listed_from || run->next >= run->listed_from + run->listed) run_list(run);
    int due = 0, from = (int)(run->next - run->listed_from), left = run->listed - from;
    const double *relative = run->relative + from;
    if (most < left) left = (int)most;
    for (; due < left; due++)
        if (run->end < 0 ? relative[due] < run->reached : relative[due] > run->reached) break;
    return due;
}

/* where a group's states go: to the caller's arrays, where these have the stored order, else
 * into the run's own */
static struct pend_points run_room(const struct pend_run *run, const struct pend_samples *samples) {
    struct pend_points room = run->points;
    size_t at = (size_t)samples->count * (size_t)run->problem.tree->n;
    if (!run->ordered) return room;
    if (samples->phi) room.phi = samples->phi + at;
    if (samples->rate) room.rate = samples->rate + at;
    if (samples->acc) room.acc = samples->acc + at;
    if (samples->force) room.force = samples->force + at;
    if (samples->theta) room.theta = samples->theta + at;
    return room;
}

/* the start is a small swing about hanging */
static int run_swings(const struct pend_run *run) {
    const struct pend_problem *problem = &run->problem;
    double largest = 0;
    for (int k = 0; k < problem->tree->n; k++)
        largest = fmax(largest, fabs(pend_turns_theta(problem->phi[k], problem->phi_low[k])));
    return largest <= PEND_TURNS_SMALL;
}

/* the states of the instants due, and their accelerations and forces where they are wanted */
static void run_states(struct pend_run *run, const struct pend_samples *samples, int due,
                       const struct pend_points *room) {
    const struct pend_problem *problem = &run->problem;
    unsigned flags = run->method->flags;
    size_t n = (size_t)problem->tree->n;
    int first = run->next == 0 && !(flags & PEND_METHOD_LINEAR),
        fine = run->fine && flags & PEND_METHOD_THETA;
    struct pend_points points = *room;
    if (!samples->theta || !fine) points.theta = NULL;
    if (!samples->force) points.force = NULL;
    if (!samples->acc && !(points.force && flags & PEND_METHOD_LINEAR)) points.acc = NULL;
    if (first) {
        memcpy(points.phi, problem->phi, n * sizeof(double));
        memcpy(points.rate, problem->rate, n * sizeof(double));
        for (size_t k = 0; k < n && points.theta; k++)
            points.theta[k] = pend_turns_theta(problem->phi[k], problem->phi_low[k]);
    } else {
        run->method->at(run->stepper, run->relative + (run->next - run->listed_from), due, &points);
    }
    for (size_t i = 0; i < (size_t)due * n && samples->theta && !points.theta; i++)
        room->theta[i] = points.phi[i] + M_PI_2;
    if ((!points.acc && !points.force) || (flags & PEND_METHOD_SERIES && !first)) return;
    if (first && fine && run_swings(run))
        pend_dynamics_fine(problem->tree, &problem->loads, problem->phi, problem->phi_low,
                           problem->rate, run->work, run->scratch, room->acc, room->force);
    else if (!(flags & PEND_METHOD_LINEAR))
        pend_dynamics_many(problem->tree, &problem->loads, due, points.phi, points.rate, run->work,
                           room->acc, room->force);
    else if (points.force)
        for (size_t row = 0; row < (size_t)due * n; row += n)
            pend_kinematics_force(problem->tree, &problem->loads, points.phi + row,
                                  points.rate + row, points.acc + row, points.force + row);
}

/* copies rows in stored order to the caller's, from row `at` of `out` on, unless they are there
 * already */
static void run_put(const struct pend_run *run, const double rows[], int count, double out[],
                    long at) {
    if (!out) return;
    size_t n = (size_t)run->problem.tree->n;
    const int *order = run->problem.tree->order;
    out += (size_t)at * n;
    if (out == rows) return;
    if (run->ordered) {
        memcpy(out, rows, (size_t)count * n * sizeof(double));
        return;
    }
    for (int i = 0; i < count; i++, out += n, rows += n)
        for (size_t k = 0; k < n; k++) out[order[k]] = rows[k];
}

/* positions, velocities and energies of one row, as far as they are wanted */
static void run_derive(struct pend_run *run, const double phi[], const double rate[],
                       struct pend_samples *samples, long at) {
    const struct pend_problem *problem = &run->problem;
    if (samples->z_re || samples->z_im) {
        pend_kinematics_position(problem->tree, phi, run->re, run->im);
        run_put(run, run->re, 1, samples->z_re, at);
        run_put(run, run->im, 1, samples->z_im, at);
    }
    if (samples->zd_re || samples->zd_im) {
        pend_kinematics_velocity(problem->tree, phi, rate, run->re, run->im);
        run_put(run, run->re, 1, samples->zd_re, at);
        run_put(run, run->im, 1, samples->zd_im, at);
    }
    if (samples->kinetic || samples->potential) {
        struct pend_energy energy =
            pend_kinematics_energy(problem->tree, &problem->loads, phi, rate);
        if (samples->kinetic) samples->kinetic[at] = energy.kinetic;
        if (samples->potential) samples->potential[at] = energy.potential;
    }
}

/* the first wanted number that is not finite: row is the number of rows where all are */
struct run_flaw {
    long row;
    int arm;
    const char *what;
};

static struct run_flaw run_find_flaw(const struct pend_run *run,
                                     const struct pend_samples *samples) {
    int n = run->problem.tree->n;
    const struct {
        const double *from;
        int width;
        const char *what;
    } wanted[] = {{samples->phi, n, "angle"},        {samples->rate, n, "angular velocity"},
                  {samples->acc, n, "acceleration"}, {samples->force, n, "force"},
                  {samples->z_re, n, "position"},    {samples->z_im, n, "position"},
                  {samples->zd_re, n, "velocity"},   {samples->zd_im, n, "velocity"},
                  {samples->kinetic, 0, "energy"},   {samples->potential, 0, "energy"}};
    struct run_flaw flaw = {.row = samples->count, .arm = -1};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        const double *from = wanted[i].from;
        int width = wanted[i].width ? wanted[i].width : 1;
        if (!from || pend_run_finite(from, flaw.row * width)) continue;
        long bad = 0;
        while (isfinite(from[bad])) bad++;
        flaw = (struct run_flaw){bad / width, wanted[i].width ? (int)(bad % width) : -1,
                                 wanted[i].what};
    }
    return flaw;
}

/* takes rows back from the first on that is not finite, which ends the run: what came behind it
 * never happened */
static enum pend_status run_hand_out(struct pend_run *run, struct pend_samples *samples,
                                     enum pend_status status, struct pend_error *error) {
    struct run_flaw flaw = run_find_flaw(run, samples);
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

/* gives rows of angles in the caller's order their whole turns back */
static void run_return(const struct pend_run *run, double phi[], int count) {
    const struct pend_tree *tree = run->problem.tree;
    if (!run->turned || run->problem.no_turns || !phi) return;
    for (int i = 0; i < count; i++, phi += tree->n)
        for (int k = 0; k < tree->n; k++)
            phi[tree->order[k]] =
                pend_turns_add(phi[tree->order[k]], run->turns[k], run->turns_low[k]);
}

static void run_sample(struct pend_run *run, struct pend_samples *samples, int due) {
    size_t n = (size_t)run->problem.tree->n;
    const struct pend_points points = run_room(run, samples);
    long at = samples->count;
    run_states(run, samples, due, &points);
    memcpy(samples->t + at, run->t + (run->next - run->listed_from), (size_t)due * sizeof(double));
    run_put(run, points.phi, due, samples->phi, at);
    run_put(run, points.rate, due, samples->rate, at);
    run_put(run, points.acc, due, samples->acc, at);
    run_put(run, points.force, due, samples->force, at);
    run_put(run, points.theta, due, samples->theta, at);
    int derived = samples->z_re || samples->z_im || samples->zd_re || samples->zd_im ||
                  samples->kinetic || samples->potential;
    for (int i = 0; i < due && derived; i++)
        run_derive(run, points.phi + (size_t)i * n, points.rate + (size_t)i * n, samples, at + i);
    if (samples->phi) run_return(run, samples->phi + (size_t)at * n, due);
    if (samples->theta) run_return(run, samples->theta + (size_t)at * n, due);
    samples->count += due;
    run->next += due;
}

enum pend_status pend_run_next(struct pend_run *run, struct pend_samples *samples, double work,
                               int *done, struct pend_error *error) {
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
            run_sample(run, samples, due);
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
    return status;
}

/* ---- statistics */

/* the part of the time up to the first instant that was not handed out, as far as it is reached */
static double run_progress(const struct pend_run *run) {
    const struct pend_times *times = &run->problem.times;
    if (run->next == times->count) return 1;
    if (run->end == 0) return 0;
    double next = pend_times_at(times, run->next) - run->start;
    return fmin(next / run->end, run->reached / run->end);
}

struct pend_run_stats pend_run_stats(const struct pend_run *run) {
    struct pend_stepper_counts counts = run->method->counts(run->stepper);
    return (struct pend_run_stats){.method = run->method->name,
                                   .steps = counts.steps,
                                   .rejected = counts.rejected,
                                   .evaluations = counts.evaluations,
                                   .energy_drift = run->drift,
                                   .horizon = run->horizon ? pend_horizon_until(run->horizon) : NAN,
                                   .progress = run_progress(run)};
}

/* ---- from one process to another */

int pend_run_carries(const struct pend_method *method) { return method->carry != NULL; }

enum pend_status pend_run_carry(struct pend_run *run, struct pend_checkpoint *checkpoint) {
    assert(run->failure.code == PEND_OK);
    pend_checkpoint_part(checkpoint, &run->reached, sizeof run->reached);
    pend_checkpoint_counts(checkpoint, &run->next, 1);
    pend_checkpoint_part(checkpoint, &run->drift, sizeof run->drift);
    run->method->carry(run->stepper, checkpoint);
    if (run->horizon) PEND_TRY(pend_horizon_carry(run->horizon, checkpoint));
    /* a checkpoint that refused on the way was put back in part: it is not whole */
    if (!pend_checkpoint_puts(checkpoint)) return PEND_OK;
    int good =
        run->next <= run->problem.times.count && isfinite(run->reached) && isfinite(run->drift);
    return good ? PEND_OK : PEND_INVALID;
}
