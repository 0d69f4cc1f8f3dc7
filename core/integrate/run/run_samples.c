#include "core/integrate/run/run_samples.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/bodies/bodies.h"
#include "core/dynamics/dynamics.h"
#include "core/dynamics/kinematics_at.h"
#include "core/integrate/pieces/control.h"
#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/run_check.h"
#include "core/tree/turns.h"

/* number of columns in the caller's arrays: the arms, not a cart */
static int run_arms(const struct pend_run *run) {
    return run->problem.tree->n - (pend_terms_cart(run->problem.loads.terms) ? 1 : 0);
}

/* arrays for the states of a group: the caller's if they are in stored order, else the run's */
static struct pend_points run_room(const struct pend_run *run, const struct pend_samples *samples) {
    struct pend_points room = run->points;
    size_t at = (size_t)samples->count * (size_t)run->problem.tree->n;
    if (!run->ordered || run_arms(run) < run->problem.tree->n) return room;
    if (samples->phi) room.phi = samples->phi + at;
    if (samples->rate) room.rate = samples->rate + at;
    if (samples->acc) room.acc = samples->acc + at;
    if (samples->force) room.force = samples->force + at;
    if (samples->theta) room.theta = samples->theta + at;
    return room;
}

static int run_swings(const struct pend_run *run) {
    const struct pend_problem *problem = &run->problem;
    double largest = 0;
    for (int k = 0; k < problem->tree->n; k++)
        largest = fmax(largest, fabs(pend_turns_theta(problem->phi[k], problem->phi_low[k])));
    return largest <= PEND_TURNS_SMALL;
}

static void run_start_states(const struct pend_problem *problem, const struct pend_points *points) {
    size_t n = (size_t)problem->tree->n;
    memcpy(points->phi, problem->phi, n * sizeof(double));
    memcpy(points->rate, problem->rate, n * sizeof(double));
    for (size_t k = 0; k < n && points->theta; k++)
        points->theta[k] = pend_turns_theta(problem->phi[k], problem->phi_low[k]);
}

/* accelerations and forces of `due` states by the equations of motion, or of the linear method */
static void run_forces(struct pend_run *run, int due, int swings, const struct pend_points *points,
                       const struct pend_points *room) {
    const struct pend_problem *problem = &run->problem;
    size_t n = (size_t)problem->tree->n;
    const double *t = run->t + (run->next - run->listed_from);
    if (!pend_pieces_smooth(problem->loads.terms))
        for (size_t row = 0; row < (size_t)due * n; row += n)
            pend_pieces_forces(run->stepper, t[row / n], points->phi + row, points->rate + row,
                               room->acc + row,
                               &(struct bodies_forces){.tip_along = room->force + row});
    else if (problem->loads.terms)
        for (size_t row = 0; row < (size_t)due * n; row += n)
            pend_dynamics_at(problem->tree, &problem->loads, t[row / n], points->phi + row,
                             points->rate + row, run->work, room->acc + row, room->force + row);
    else if (swings)
        pend_dynamics_fine(problem->tree, &problem->loads, problem->phi, problem->phi_low,
                           problem->rate, run->work, run->scratch, room->acc, room->force);
    else if (!(run->method->flags & PEND_METHOD_LINEAR))
        pend_dynamics_many(problem->tree, &problem->loads, due, points->phi, points->rate,
                           run->work, room->acc, room->force);
    else if (points->force)
        for (size_t row = 0; row < (size_t)due * n; row += n)
            pend_kinematics_force(problem->tree, &problem->loads, points->phi + row,
                                  points->rate + row, points->acc + row, points->force + row);
}

/* the arrays of a group that the method is to fill in */
static struct pend_points run_wanted(const struct pend_run *run, const struct pend_samples *samples,
                                     int fine, const struct pend_points *room) {
    struct pend_points points = *room;
    int linear = run->method->flags & PEND_METHOD_LINEAR;
    if (!samples->theta || !fine) points.theta = NULL;
    int series = run->next > 0 && run->unlike;
    if (series || (!samples->force && !samples->joint_along)) points.force = NULL;
    if (!samples->acc && !(points.force && linear)) points.acc = NULL;
    return points;
}

/* computes the accelerations and forces of `due` states that the method has not filled in */
static void run_pull(struct pend_run *run, const struct pend_samples *samples, int due, int swings,
                     const struct pend_points *points, const struct pend_points *room) {
    int series = run->method->flags & PEND_METHOD_SERIES && run->next > 0;
    // if the series loses digits of the forces; its accelerations are accurate
    struct pend_points own = *room;
    own.acc = run->spare;
    if (series && run->unlike && (samples->force || samples->joint_along))
        run_forces(run, due, 0, points, &own);
    else if (!series && (points->acc || points->force))
        run_forces(run, due, swings, points, room);
}

/* computes the states at the due instants, and their accelerations and forces if requested */
static void run_states(struct pend_run *run, const struct pend_samples *samples, int due,
                       const struct pend_points *room) {
    const struct pend_problem *problem = &run->problem;
    unsigned flags = run->method->flags;
    size_t numbers = (size_t)due * (size_t)problem->tree->n;
    int first = run->next == 0 && !(flags & PEND_METHOD_LINEAR),
        fine = run->fine && flags & PEND_METHOD_THETA;
    struct pend_points points = run_wanted(run, samples, fine, room);
    if (first)
        run_start_states(problem, &points);
    else
        run->method->at(run->stepper, run->relative + (run->next - run->listed_from), due, &points);
    for (size_t i = 0; i < numbers && samples->theta && !points.theta; i++)
        room->theta[i] = points.phi[i] + M_PI_2;
    run_pull(run, samples, due, first && fine && run_swings(run), &points, room);
}

/* copies rows in stored order to the caller's array, from row `at` of `out` on, unless `rows` is
 * that array */
static void run_put(const struct pend_run *run, const double rows[], int count, double out[],
                    long at) {
    if (!out) return;
    size_t n = (size_t)run->problem.tree->n, arms = (size_t)run_arms(run);
    const int *order = run->problem.tree->order;
    out += (size_t)at * arms;
    if (out == rows) return;
    if (run->ordered && arms == n) {
        memcpy(out, rows, (size_t)count * n * sizeof(double));
        return;
    }
    // a cart, stored first, has separate columns
    int cart = arms < n ? order[0] : (int)n;
    for (int i = 0; i < count; i++, out += arms, rows += n)
        for (size_t k = n - arms; k < n; k++) out[order[k] - (order[k] > cart)] = rows[k];
}

static void run_derive(struct pend_run *run, double time, const double phi[], const double rate[],
                       struct pend_samples *samples, long at) {
    const struct pend_problem *problem = &run->problem;
    if (samples->z_re || samples->z_im) {
        pend_kinematics_position_at(problem->tree, &problem->loads, time, phi, run->re, run->im);
        run_put(run, run->re, 1, samples->z_re, at);
        run_put(run, run->im, 1, samples->z_im, at);
    }
    if (samples->zd_re || samples->zd_im) {
        pend_kinematics_velocity_at(problem->tree, &problem->loads, time, phi, rate, run->re,
                                    run->im);
        run_put(run, run->re, 1, samples->zd_re, at);
        run_put(run, run->im, 1, samples->zd_im, at);
    }
    if (samples->kinetic || samples->potential) {
        struct pend_energy energy =
            pend_kinematics_energy_at(problem->tree, &problem->loads, time, phi, rate, run->room);
        if (samples->kinetic) samples->kinetic[at] = energy.kinetic;
        if (samples->potential) samples->potential[at] = energy.potential;
    }
}

/* fills in the forces besides lambda; for ideal pendulums the force at the joint is lambda, and no
 * force acts across */
static void run_joints(struct pend_run *run, const struct pend_points *points, int due,
                       struct pend_samples *samples) {
    const struct pend_problem *problem = &run->problem;
    size_t n = (size_t)problem->tree->n;
    double *acc = run->room, *along = acc + n, *across = along + n, *tip = across + n;
    struct bodies_forces forces = {along, across, NULL, tip};
    memset(run->room, 0, 4 * n * sizeof(double));
    for (int i = 0; i < due; i++) {
        long at = samples->count + i;
        size_t row = (size_t)i * n;
        struct bodies_state state = {points->phi + row, NULL, points->rate + row, samples->t[at],
                                     0};
        if (!pend_pieces_smooth(problem->loads.terms))
            pend_pieces_forces(run->stepper, samples->t[at], state.phi, state.rate, acc, &forces);
        else if (problem->loads.terms)
            pend_bodies_at(problem->tree, &problem->loads, &state, run->work, acc, &forces);
        else if (points->force)
            memcpy(along, points->force + row, n * sizeof(double));
        run_put(run, along, 1, samples->joint_along, at);
        run_put(run, across, 1, samples->joint_across, at);
        run_put(run, tip, 1, samples->across, at);
        if (samples->cart_reaction && pend_terms_cart(problem->loads.terms))
            samples->cart_reaction[at] = across[0];
    }
}

static void run_exchange(const struct pend_run *run, int due, struct pend_samples *samples) {
    const double *t = run->relative + (run->next - run->listed_from);
    for (int i = 0; i < due; i++) {
        double work = 0, heat = 0;
        int first = run->next + i == 0;
        if (run->gives && !first) run->method->exchange(run->stepper, t + i, 1, &work, &heat);
        if (samples->work) samples->work[samples->count + i] = work;
        if (samples->heat) samples->heat[samples->count + i] = heat;
    }
}

struct run_flaw pend_run_find_flaw(const struct pend_run *run, const struct pend_samples *samples) {
    int n = run_arms(run), cart = pend_terms_cart(run->problem.loads.terms);
    const struct {
        const double *from;
        int width;
        const char *what;
    } wanted[] = {{samples->phi, n, "angle"},
                  {samples->rate, n, "angular velocity"},
                  {samples->acc, n, "acceleration"},
                  {samples->force, n, "force"},
                  {samples->across, n, "force"},
                  {samples->joint_along, n, "force"},
                  {samples->joint_across, n, "force"},
                  {samples->z_re, n, "position"},
                  {samples->z_im, n, "position"},
                  {samples->zd_re, n, "velocity"},
                  {samples->zd_im, n, "velocity"},
                  {samples->kinetic, 0, "energy"},
                  {samples->potential, 0, "energy"},
                  {cart ? samples->cart_place : NULL, 0, "position of the cart"},
                  {cart ? samples->cart_speed : NULL, 0, "velocity of the cart"},
                  {cart ? samples->cart_reaction : NULL, 0, "force"}};
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

/* adds the whole turns of the start to rows of angles in the caller's order */
static void run_return(const struct pend_run *run, double phi[], int count) {
    const struct pend_tree *tree = run->problem.tree;
    if (!run->turned || run->problem.no_turns || !phi) return;
    for (int i = 0; i < count; i++, phi += tree->n)
        for (int k = 0; k < tree->n; k++)
            phi[tree->order[k]] =
                pend_turns_add(phi[tree->order[k]], run->turns[k], run->turns_low[k]);
}

static void run_control(const struct pend_run *run, int due, struct pend_samples *samples) {
    const struct pend_problem *problem = &run->problem;
    const double *own = pend_pieces_control(run->method, run->stepper);
    int count = own ? problem->loads.terms->rules->controllers : 0;
    for (int j = 0; j < due * count; j++)
        samples->control[samples->count * count + j] =
            pend_control_output(problem->loads.terms->rules, problem->tree->n, j % count, own);
}

static void run_all_derive(struct pend_run *run, const struct pend_points *points, int due,
                           struct pend_samples *samples) {
    size_t n = (size_t)run->problem.tree->n;
    long at = samples->count;
    int derived = samples->z_re || samples->z_im || samples->zd_re || samples->zd_im ||
                  samples->kinetic || samples->potential;
    for (int i = 0; i < due && derived; i++)
        run_derive(run, samples->t[at + i], points->phi + (size_t)i * n,
                   points->rate + (size_t)i * n, samples, at + i);
    if (samples->across || samples->joint_along || samples->joint_across || samples->cart_reaction)
        run_joints(run, points, due, samples);
    if (samples->work || samples->heat) run_exchange(run, due, samples);
    if (samples->control) run_control(run, due, samples);
}

void pend_run_sample(struct pend_run *run, struct pend_samples *samples, int due) {
    assert(due >= 1 && due <= run->group && due <= samples->cap - samples->count);
    assert(run->next >= run->listed_from && run->next + due <= run->listed_from + run->listed);
    const struct pend_points points = run_room(run, samples);
    size_t n = (size_t)run->problem.tree->n;
    long at = samples->count;
    run_states(run, samples, due, &points);
    memcpy(samples->t + at, run->t + (run->next - run->listed_from), (size_t)due * sizeof(double));
    run_put(run, points.phi, due, samples->phi, at);
    run_put(run, points.rate, due, samples->rate, at);
    run_put(run, points.acc, due, samples->acc, at);
    run_put(run, points.force, due, samples->force, at);
    run_put(run, points.theta, due, samples->theta, at);
    run_all_derive(run, &points, due, samples);
    for (int i = 0; i < due && pend_terms_cart(run->problem.loads.terms); i++) {
        if (samples->cart_place) samples->cart_place[at + i] = points.phi[(size_t)i * n];
        if (samples->cart_speed) samples->cart_speed[at + i] = points.rate[(size_t)i * n];
    }
    if (samples->phi) run_return(run, samples->phi + (size_t)at * n, due);
    if (samples->theta) run_return(run, samples->theta + (size_t)at * n, due);
    samples->count += due;
    run->next += due;
}
