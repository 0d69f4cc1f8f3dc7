#include "core/integrate/pieces/joints.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/integrate/pieces/balance.h"
#include "core/taylor/jets/jets.h"
#include "core/taylor/roots.h"

enum { EVENT_NODES = PEND_JOINT_NODES, EVENT_POLISH = 6 };

/* a first coefficient smaller than this fraction of the following ones counts as rounding */
static const double event_rounded = 1e-9;
static const double event_slack = 1e-13;

struct event_look {
    struct pend_joints *joints;
    const struct pend_joint_step *step;
    struct pend_series series;
    double length; /* s, from the start of the step to the end of the search */
    double first;  /* fraction of that length at which the first event found so far lies */
};

enum event_kind { EVENT_STOPPED, EVENT_UPPER, EVENT_LOWER, EVENT_FORCED };

/* ---- series */

/* adds `factor` times the rate of arm k, as coefficients in powers of the fraction of the step */
static void event_rate(const struct event_look *look, int k, double factor, double out[]) {
    const struct pend_jets *jets = look->series.jets;
    const struct pend_stuck *stuck = look->step->stuck;
    if (k < 0 || (stuck && stuck->still[k])) return;
    const double *from = jets->rate + pend_jets_place(jets, stuck ? stuck->rep[k] : k, 0);
    double x = look->length / look->series.unit, power = factor / look->series.unit;
    for (int j = 0; j <= look->series.order; j++, power *= x, from += PEND_JETS_PAD)
        out[j] += *from * power;
}

/* `way` times the rate of a joint, or its angle, in powers of the fraction of the step; `base` is
 * the value at the start */
static void event_path(const struct event_look *look, int k, int way, int angle, double base,
                       struct roots_path *path) {
    const struct pend_joints *j = look->joints;
    double a[PEND_ROOTS_DEGREE + 1] = {0};
    int order = look->series.order;
    event_rate(look, k, way, a);
    event_rate(look, pend_terms_holder(j->piece->problem->loads.terms, j->tree->parent, k), -way,
               a);
    *path = (struct roots_path){.degree = order + angle, .base = base};
    assert(path->degree <= PEND_ROOTS_DEGREE);
    for (int i = 1 - angle; i <= order; i++)
        path->a[i + angle] = angle ? a[i] * look->length / (i + 1) : a[i];
}

/* divides by the known roots at the start; by one more if the slope there is within rounding */
static void event_divide(struct roots_path *path, int roots, int forced) {
    for (; roots > 0 && path->degree > 1; roots--) {
        path->base = path->a[1];
        memmove(path->a + 1, path->a + 2, (size_t)(path->degree - 1) * sizeof *path->a);
        path->degree--;
        double rest = 0;
        for (int i = 1; i <= path->degree; i++) rest += fabs(path->a[i]);
        if (roots == 1 && forced && fabs(path->base) <= event_rounded * rest) roots++, forced = 0;
    }
}

/* the fraction of the step at which a path that starts above 0 reaches 0 */
static double event_root(struct roots_path *path) {
    double size = 0;
    int way;
    for (int i = 1; i <= path->degree; i++) size += fabs(path->a[i]);
    if (path->base > size) return INFINITY;
    pend_roots_divide(path);
    return pend_roots_next(path, 0, 0, INFINITY, &way);
}

/* records an event of joint k, unless an earlier one was found */
static void event_note(struct event_look *look, double s, enum event_kind kind, int k, int way) {
    struct pend_joints *j = look->joints;
    if (!(s <= 1) || s > look->first) return;
    if (s < look->first) {
        memset(j->forced, 0, (size_t)j->n);
        memset(j->struck, 0, (size_t)j->n);
        memset(j->stopped, 0, (size_t)j->n);
    }
    look->first = s;
    if (kind == EVENT_STOPPED) j->stopped[k] = 1;
    if (kind == EVENT_UPPER) j->struck[k] = 1;
    if (kind == EVENT_LOWER) j->struck[k] = -1;
    if (kind == EVENT_FORCED) j->forced[k] = (signed char)way;
}

struct event_marks {
    int forced, struck;
};

static void event_stops(struct event_look *look, int k, const struct event_marks *had) {
    const struct pend_joints *j = look->joints;
    struct roots_path path;
    double r = j->mode[k] * pend_joints_rate(j, look->step->room, k);
    int rests = look->step->fresh && r == 0;
    event_path(look, k, j->mode[k], 0, r, &path);
    if (rests) event_divide(&path, 1, had->forced);
    event_note(look, event_root(&path), EVENT_STOPPED, k, 0);
}

static void event_hits(struct event_look *look, int k, const struct event_marks *had) {
    const struct pend_joints *j = look->joints;
    const double *rate = look->step->room, *phi = rate + j->n;
    for (int side = -1; side <= 1; side += 2) {
        struct roots_path path;
        double stop = side > 0 ? j->piece->rules->most[k] : j->piece->rules->least[k];
        if (isinf(stop)) continue;
        int begins = look->step->fresh && had->struck == side,
            rests = pend_joints_rate(j, rate, k) == 0;
        event_path(look, k, -side, 1, side * (stop - pend_joints_angle(j, phi, k)), &path);
        if (begins && rests) path.a[1] = 0;
        if (begins) event_divide(&path, 1 + rests, had->forced);
        event_note(look, event_root(&path), side > 0 ? EVENT_UPPER : EVENT_LOWER, k, 0);
    }
}

/* ---- torques */

static const double *event_torques(const struct event_look *look, double s) {
    const struct pend_joints *j = look->joints;
    const struct pend_joint_step *step = look->step;
    size_t n = (size_t)j->n;
    double *at = step->room + 2 * n, *phi = at, *rate = at + n, *acc = at + 2 * n, *own = j->torque;
    double t = look->series.time + s * look->length;
    struct pend_points points = {.phi = phi, .rate = rate, .acc = acc};
    step->method->at(step->stepper, &t, 1, &points);
    if (step->stuck) {
        pend_stuck_turn(step->stuck, phi, NULL, own, NULL);
        memcpy(phi, own, n * sizeof(double));
        pend_stuck_spread(step->stuck, rate, own);
        memcpy(rate, own, n * sizeof(double));
        pend_stuck_spread(step->stuck, acc, own);
        memcpy(acc, own, n * sizeof(double));
    }
    const struct pend_moving moving = {step->start + t, phi, rate, acc};
    pend_balance(j->tree, &j->piece->problem->loads, &moving, j->room, own, NULL);
    return own;
}

/* refines the root of a torque, starting from the root of its polynomial */
static double event_polish(const struct event_look *look, int k, int way, double bound,
                           const struct roots_path *path, double s) {
    for (int i = 0; i < EVENT_POLISH && s > 0 && s < 1; i++) {
        double gap = bound - way * event_torques(look, s)[k], slope = 0;
        for (int m = path->degree; m >= 1; m--) slope = slope * s + m * path->a[m];
        double next = s - gap / slope;
        if (!(fabs(next - s) < 1e-3)) break;
        int done = fabs(next - s) < 1e-16;
        s = fmin(fmax(next, 0), 1);
        if (done) break;
    }
    return s;
}

/* finds where the torque in a stuck joint reaches its limit */
static void event_slips(struct event_look *look, int k) {
    const struct pend_joints *j = look->joints;
    const double *at = look->step->room + 5 * (size_t)j->n;
    double bound = j->piece->rules->holding ? j->piece->rules->holding[k] : 0;
    for (int way = -1; way <= 1; way += 2) {
        struct roots_path path;
        double gap[EVENT_NODES], more = 0, most = bound;
        if (j->touch[k] == -way) continue; // here the joint is held by its stop
        for (int i = 0; i < EVENT_NODES; i++) {
            double h = at[(size_t)i * (size_t)j->n + (size_t)k];
            gap[i] = bound - way * h;
            most = fmax(most, fabs(h));
        }
        // a torque that equals its limit when the piece begins must grow beyond rounding
        if (fabs(gap[0]) <= event_slack * most) more = 2 * event_slack * most;
        for (int i = 0; i < EVENT_NODES; i++) gap[i] += more;
        path = (struct roots_path){.degree = EVENT_NODES - 1, .base = gap[0]};
        pend_roots_through(EVENT_NODES, gap, path.a);
        double s = event_root(&path);
        if (s <= 1) s = event_polish(look, k, way, bound + more, &path, s);
        event_note(look, s, EVENT_FORCED, k, -way);
    }
}

double pend_joint_events(struct pend_joints *j, const struct pend_joint_step *step) {
    struct event_look look = {.joints = j, .step = step, .first = INFINITY};
    size_t n = (size_t)j->n;
    double *rate = step->room, *phi = rate + n, *nodes = rate + 5 * n;
    int any = 0;
    step->method->series(step->stepper, &look.series);
    look.length = step->to - look.series.time;
    const struct jets_state *begin = look.series.begin;
    if (step->stuck) {
        pend_stuck_spread(step->stuck, begin->rate, rate);
        pend_stuck_turn(step->stuck, begin->phi, begin->phi_low, phi, NULL);
    } else {
        memcpy(rate, begin->rate, n * sizeof(double));
        memcpy(phi, begin->phi, n * sizeof(double));
    }
    for (int k = 0; k < j->n; k++) any |= j->mode[k] == PEND_JOINT_HOLDS;
    for (int i = 0; any && i < EVENT_NODES; i++)
        memcpy(nodes + (size_t)i * n, event_torques(&look, pend_roots_node(i, EVENT_NODES)),
               n * sizeof(double));
    for (int k = 0; k < j->n; k++) {
        struct event_marks had = {j->was_forced[k], j->was_struck[k]};
        int mode = j->mode[k];
        if (mode == 1 || mode == -1) event_stops(&look, k, &had);
        if (mode != PEND_JOINT_HOLDS && j->piece->rules->least) event_hits(&look, k, &had);
        if (mode == PEND_JOINT_HOLDS) event_slips(&look, k);
    }
    return look.series.time + look.first * look.length;
}
