#include "core/ensemble/ensemble_watch.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/integrate/pieces/control.h"
#include "core/tree/rules.h"
#include "core/tree/turns.h"

double pend_ensemble_watch_time(const struct pend_ensemble *e, int i, double part) {
    double from = e->lanes.from.time[i], to = e->lanes.to.time[i];
    return part == 1 ? to : from + (to - from) * part;
}

/* the tree and loads of the member in lane i, with the values that positions and energies need */
static struct pend_tree watch_member(const struct pend_ensemble *e, int i,
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

struct event_step pend_ensemble_watch_step(const struct pend_ensemble *e, int i,
                                           struct pend_tree *tree, struct pend_loads *loads) {
    const struct ensemble_lanes *lanes = &e->lanes;
    double from = lanes->from.time[i];
    *tree = watch_member(e, i, loads);
    return (struct event_step){.tree = tree,
                               .loads = loads,
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
}

void pend_ensemble_watch_start(struct pend_ensemble *e, int i) {
    assert(i >= 0 && i < e->lanes.width);
    struct ensemble_lanes *lanes = &e->lanes;
    struct pend_tree tree = *e->problem.tree;
    tree.mass = e->member.mass;
    // series of forces lose digits then
    e->seat[i].unlike = lanes->forces && pend_dynamics_unlike(&tree, &e->member.loads);
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i, own = i * lanes->n + k;
        if (lanes->bound > 0) {
            lanes->cell[at] =
                floor((lanes->from.phi[at] + M_PI_2 + lanes->bound) / (2 * lanes->bound));
            e->first_crossing[own] = NAN;
            e->crossings[own] = 0;
        }
        lanes->force_max[at] = -INFINITY;
        lanes->force_min[at] = INFINITY;
        e->sign_change[own] = NAN;
        e->sense[own] = 0;
    }
}

/* the path of phi of arm k in lane i, in powers of the fraction of the step */
static struct roots_path watch_phi(const struct pend_ensemble *e, int i, int k) {
    const struct ensemble_lanes *lanes = &e->lanes;
    size_t at = (size_t)(k * lanes->width + i), stride = (size_t)lanes->n * (size_t)lanes->width;
    struct roots_path path = {
        .degree = lanes->order + 1, .base = lanes->from.phi[at], .low = lanes->from.phi_low[at]};
    double x = lanes->step[i], power = x;
    for (int j = 0; j <= lanes->order; j++, power *= x)
        path.a[j + 1] = lanes->series[at + (size_t)j * stride] * lanes->share[j] * power;
    return path;
}

static struct roots_path watch_force(const struct pend_ensemble *e, int i, int k, double part) {
    const struct ensemble_lanes *lanes = &e->lanes;
    size_t stride = (size_t)lanes->n * (size_t)lanes->width;
    const double *force = e->kernel->force(lanes) + k * lanes->width + i;
    double x = lanes->step[i] * part, power = 1 / (e->unit[i] * e->unit[i]);
    struct roots_path path = {.degree = lanes->order - 1, .base = force[0] * power};
    for (int j = 1; j < lanes->order; j++) path.a[j] = force[(size_t)j * stride] * (power *= x);
    return path;
}

/* Follows arm k of lane i through the step from cell to cell, up to the fraction `most`. Returns
 * the fraction at which it first leaves a cell; infinity if it leaves none. */
static double watch_cross(struct pend_ensemble *e, int i, int k, double most) {
    const struct ensemble_lanes *lanes = &e->lanes;
    struct roots_path path = watch_phi(e, i, k);
    double first = INFINITY, s = 0, bound = lanes->bound,
           *cell = &lanes->cell[k * lanes->width + i];
    double *note = &e->first_crossing[i * lanes->n + k];
    int way = 0;
    pend_roots_divide(&path);
    while (s < 1) {
        double middle = *cell * 2 * bound - M_PI_2;
        s = pend_roots_next(&path, s, middle - bound, middle + bound, &way);
        if (!(s <= most)) break;
        *cell += way;
        // a member that starts on its bound does not cross it when it moves into the next cell
        double level = middle + way * bound, gap = fabs(path.base - level);
        if (e->lanes.from.time[i] == 0 && gap <= 1e-14 * (1 + fabs(level)) && !(first < INFINITY))
            continue;
        if (!(first < INFINITY)) first = s;
        if (isnan(*note)) {
            *note = pend_ensemble_watch_time(e, i, s);
            e->seat[i].open--;
        }
        e->crossings[i * lanes->n + k]++;
        if (e->problem.until == PEND_UNTIL_FIRST) break;
    }
    return first;
}

double pend_ensemble_watch_bound(struct pend_ensemble *e, int i, double most) {
    assert(e->lanes.bound > 0);
    struct ensemble_seat *seat = &e->seat[i];
    double first = INFINITY;
    int arm = -1;
    // the position of a cart is not an angle
    for (int k = pend_terms_cart(e->lanes.terms); k < e->lanes.n; k++) {
        if (!(e->lanes.near[k] >> i & 1)) continue;
        double s = watch_cross(e, i, k, most);
        if (s < first) {
            first = s;
            arm = k;
        }
    }
    if (arm >= 0 && seat->arm < 0) {
        seat->arm = arm;
        seat->first = pend_ensemble_watch_time(e, i, first);
    }
    if (e->problem.until == PEND_UNTIL_ALL && seat->open <= 0) return 1;
    if (e->problem.until != PEND_UNTIL_FIRST || arm < 0) return INFINITY;
    // no crossing comes after the one that ends the member
    for (int k = 0; k < e->lanes.n; k++) {
        if (k == seat->arm) continue;
        e->first_crossing[i * e->lanes.n + k] = NAN;
        e->crossings[i * e->lanes.n + k] = 0;
    }
    return first;
}

/* the path of a force, through forces of states if the step has them */
static struct roots_path watch_true_force(const struct event_step *step, int k, double part) {
    struct roots_path path = {.degree = EVENT_TERMS - 1};
    double power = 1;
    pend_event_series_force(step, k, path.a);
    path.base = path.a[0];
    for (int j = 1; j <= path.degree; j++) path.a[j] *= power *= part;
    while (path.degree > 1 && path.a[path.degree] == 0) path.degree--;
    return path;
}

static void watch_extremes(struct pend_ensemble *e, int i, int k, double part,
                           const struct roots_path *path) {
    struct ensemble_lanes *lanes = &e->lanes;
    struct roots_extremes found = pend_roots_extremes(path);
    int at = k * lanes->width + i, own = i * lanes->n + k;
    if (found.most > lanes->force_max[at]) {
        lanes->force_max[at] = found.most;
        e->most_time[own] = pend_ensemble_watch_time(e, i, found.most_at * part);
    }
    if (found.least < lanes->force_min[at]) {
        lanes->force_min[at] = found.least;
        e->least_time[own] = pend_ensemble_watch_time(e, i, found.least_at * part);
    }
}

/* the sign of a force from the first term of its series that is larger than rounding */
static double watch_sense(const struct roots_path *path, double slack) {
    if (fabs(path->base) > slack) return copysign(1, path->base);
    for (int j = 1; j <= path->degree; j++) {
        if (fabs(path->a[j]) > slack) return copysign(1, path->a[j]);
    }
    return 0;
}

/* Records a change of sign. A force that reaches zero within rounding and returns to its side has
 * not changed sign. */
static void watch_sign(struct pend_ensemble *e, int i, int k, double part,
                       const struct roots_path *path) {
    int own = i * e->lanes.n + k, way = 0;
    double *sense = &e->sense[own], slack = 0;
    for (int j = 1; j <= path->degree; j++) slack += 1e-12 * fabs(path->a[j]);
    slack += 1e-12 * fabs(path->base);
    double start = *sense;
    if (start == 0) *sense = watch_sense(path, slack);
    if (*sense == 0) return;
    double beyond = pend_roots_next(path, 0, *sense > 0 ? -slack : -INFINITY,
                                    *sense > 0 ? INFINITY : slack, &way);
    if (!(beyond < INFINITY)) return;
    // a force that is zero at the start changes its sign at a later zero
    double zero =
        pend_roots_next(path, 0, *sense > 0 ? 0 : -INFINITY, *sense > 0 ? INFINITY : 0, &way);
    e->sign_change[own] =
        pend_ensemble_watch_time(e, i, part * (start == 0 ? beyond : fmin(zero, beyond)));
}

void pend_ensemble_watch_force(struct pend_ensemble *e, int i, double part) {
    struct pend_loads loads;
    struct pend_tree tree;
    struct event_step step;
    assert(part > 0 && part <= 1);
    if (e->seat[i].unlike) {
        step = pend_ensemble_watch_step(e, i, &tree, &loads);
        pend_event_series_truth(&step, &e->truth);
        step.truth = &e->truth;
    }
    for (int k = 0; k < e->lanes.n; k++) {
        int own = i * e->lanes.n + k, peak = e->lanes.peak[k] >> i & 1;
        // while the first sign is unknown, every step is searched
        int turn = e->lanes.signs && isnan(e->sign_change[own]) &&
                   ((e->lanes.turn[k] >> i & 1) || e->sense[own] == 0);
        if (!peak && !turn) continue;
        struct roots_path path =
            e->seat[i].unlike ? watch_true_force(&step, k, part) : watch_force(e, i, k, part);
        pend_roots_divide(&path);
        if (peak) watch_extremes(e, i, k, part, &path);
        if (turn) watch_sign(e, i, k, part, &path);
    }
}

/* passes the values at some instants to the receiver, row by row */
static void watch_give(struct pend_ensemble *e, int i, int count) {
    int n = e->lanes.n;
    for (int a = 0; a < 4; a++)
        for (int row = 0; row < count; row++)
            for (int k = 0; k < n; k++)
                e->rows[a][row * n + k] = e->instants[a][k * ENSEMBLE_INSTANTS + row];
    for (int k = 0; k < n; k++) {
        int at = k * e->lanes.width + i;
        for (int row = 0; row < count; row++)
            for (int a = 0; a < 4; a += 3)
                e->rows[a][row * n + k] =
                    pend_turns_add(e->rows[a][row * n + k], e->turns[at], e->turns_low[at]);
    }
    e->problem.rows(e->problem.context, e->seat[i].member, e->seat[i].row, count, e->rows[0],
                    e->rows[1], e->rows[2], e->rows[3]);
    e->seat[i].row += count;
}

/* Computes angles from the vertical at the instants x, for which phi is known. For a small swing
 * they are computed from a series that starts with these angles, which keeps all their digits.
 * During the call, the arrays of the outcome hold that start. */
static void watch_theta(struct pend_ensemble *e, int i, const double x[]) {
    struct ensemble_lanes *lanes = &e->lanes;
    const struct ensemble_values values = {e->instants[3], e->instants[1], NULL};
    double largest = 0;
    int cart = pend_terms_cart(lanes->terms);
    for (int at = cart * ENSEMBLE_INSTANTS; at < lanes->n * ENSEMBLE_INSTANTS; at++) {
        e->instants[3][at] = e->instants[0][at] + M_PI_2;
        largest = fmax(largest, fabs(e->instants[3][at]));
    }
    for (int k = cart; k < lanes->n && largest <= PEND_TURNS_SMALL; k++)
        largest = fmax(largest, fabs(lanes->from.phi[k * lanes->width + i] + M_PI_2));
    if (largest > PEND_TURNS_SMALL) return;
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i;
        e->phi[k] = lanes->from.phi[at], e->phi_low[k] = lanes->from.phi_low[at];
        lanes->from.phi[at] = pend_turns_theta(e->phi[k], e->phi_low[k]);
        lanes->from.phi_low[at] = 0;
    }
    e->kernel->values(lanes, i, e->unit[i], x, &values);
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i;
        lanes->from.phi[at] = e->phi[k], lanes->from.phi_low[at] = e->phi_low[k];
    }
}

/* replaces the series' forces at the instants x by those of the states */
static void watch_true_rows(struct pend_ensemble *e, int i, const double x[], int count) {
    int n = e->lanes.n;
    struct pend_loads loads;
    const struct event_truth *to = &e->truth;
    struct pend_tree tree = watch_member(e, i, &loads);
    double start = e->lanes.start[i] + e->lanes.from.time[i];
    for (int j = 0; j < count; j++) {
        for (int k = 0; k < n; k++) {
            to->phi[k] = e->instants[0][k * ENSEMBLE_INSTANTS + j];
            to->rate[k] = e->instants[1][k * ENSEMBLE_INSTANTS + j];
        }
        pend_dynamics_at(&tree, &loads, start + x[j] * e->unit[i], to->phi, to->rate, to->work,
                         to->acc, to->force);
        for (int k = 0; k < n; k++) e->instants[2][k * ENSEMBLE_INSTANTS + j] = to->force[k];
    }
}

void pend_ensemble_watch_rows(struct pend_ensemble *e, int i, double until) {
    assert(e->problem.rows && e->problem.times);
    const struct ensemble_lanes *lanes = &e->lanes;
    const struct ensemble_values values = {e->instants[0], e->instants[1], e->instants[2]};
    double way = copysign(1, lanes->unit[i]), x[ENSEMBLE_INSTANTS] __attribute__((aligned(64)));
    for (;;) {
        const double *times = e->problem.times + e->seat[i].row;
        long left = e->problem.times_count - e->seat[i].row;
        int count = 0;
        for (; count < left && count < ENSEMBLE_INSTANTS && times[count] * way <= until * way;
             count++)
            x[count] = (times[count] - lanes->from.time[i]) / e->unit[i];
        if (!count) return;
        for (int j = count; j < ENSEMBLE_INSTANTS; j++) x[j] = 0;
        e->kernel->values(lanes, i, e->unit[i], x, &values);
        if (e->seat[i].unlike) watch_true_rows(e, i, x, count);
        watch_theta(e, i, x);
        watch_give(e, i, count);
    }
}

void pend_ensemble_watch_state(struct pend_ensemble *e, int i, double part) {
    assert(part >= 0 && part <= 1);
    const struct ensemble_lanes *lanes = &e->lanes;
    const struct ensemble_values values = {e->instants[0], e->instants[1], e->instants[2]};
    double x[ENSEMBLE_INSTANTS] __attribute__((aligned(64))) = {lanes->step[i] * part};
    for (int k = 0; k < lanes->n && part == 1; k++) {
        e->phi[k] = lanes->to.phi[k * lanes->width + i];
        e->phi_low[k] = lanes->to.phi_low[k * lanes->width + i];
        e->rate[k] = lanes->to.rate[k * lanes->width + i];
    }
    if (part == 1) return;
    e->kernel->values(lanes, i, e->unit[i], x, &values);
    for (int k = 0; k < lanes->n; k++) {
        e->phi[k] = e->instants[0][k * ENSEMBLE_INSTANTS];
        e->phi_low[k] = 0;
        e->rate[k] = e->instants[1][k * ENSEMBLE_INSTANTS];
    }
}

/* lets the controllers of lane i sample its state at the start of a piece and hold their outputs */
static void watch_control(struct pend_ensemble *e, int i, double now,
                          const struct ensemble_state *state) {
    const struct ensemble_lanes *lanes = &e->lanes;
    const struct pend_rules *rules = lanes->terms->rules;
    double *own = e->control + (size_t)i * e->controls, *phi = e->room, *rate = phi + lanes->n,
           *input = lanes->value + lanes->terms->row[PEND_TERM_INPUT] * lanes->width + i;
    struct pend_loads loads;
    struct pend_tree tree = watch_member(e, i, &loads);
    for (int k = 0; k < lanes->n; k++) {
        phi[k] = state->phi[k * lanes->width + i];
        rate[k] = state->rate[k * lanes->width + i];
    }
    e->seat[i].sampled = e->seat[i].steps;
    if (now == lanes->start[i]) memset(own, 0, e->controls * sizeof *own);
    pend_control_sample(&tree, &loads, lanes->start[i], now, phi, rate, own);
    for (int c = 0; c < rules->controllers; c++)
        input[rules->controller[c].drives * lanes->width] +=
            pend_control_output(rules, lanes->n, c, own);
    e->seat[i].knot =
        fmin(e->seat[i].knot, pend_control_next(rules, lanes->n, lanes->start[i], own));
    pend_ensemble_watch_settled(e, i, phi, &loads, now);
}

void pend_ensemble_watch_settled(struct pend_ensemble *e, int i, const double phi[],
                                 const struct pend_loads *loads, double now) {
    double *since = &e->seat[i].settled;
    if (!(e->problem.settle > 0) ||
        !pend_control_near(e->problem.tree, loads, now, phi, e->problem.settle))
        *since = NAN;
    else if (isnan(*since))
        *since = now - e->lanes.start[i];
}

void pend_ensemble_watch_begin(struct pend_ensemble *e, int i, double now,
                               const struct ensemble_state *state) {
    struct ensemble_lanes *lanes = &e->lanes;
    double duration = e->problem.duration;
    int way = duration < 0 ? -1 : 1;
    for (int lane = i; lane <= i + lanes->paired; lane++) {
        double *value = lanes->value ? lanes->value + lane : NULL;
        e->seat[i].knot = pend_rules_piece(lanes->terms, now, way, value, (size_t)lanes->width);
        if (e->control) watch_control(e, i, now, state);
        double end = e->seat[i].knot - lanes->start[i];
        lanes->stop[lane] = way > 0 ? fmin(duration, end) : fmax(duration, end);
    }
}

int pend_ensemble_watch_piece(struct pend_ensemble *e, int i) {
    struct ensemble_lanes *lanes = &e->lanes;
    if (lanes->stop[i] == e->problem.duration) return 0;
    pend_ensemble_watch_begin(e, i, e->seat[i].knot, &lanes->to);
    // a short step to the end of a piece says nothing about the length of later steps
    for (int lane = i; lane <= i + lanes->paired; lane++) lanes->unit[lane] = e->unit[lane];
    return 1;
}
