#include "core/orbits/orbit_change.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_constants.h"

enum { LOCATE_LOST = 1000 };

/* distances from a bifurcation, in the unit of the unknowns, at which the first orbit of the new
 * branch is searched for, in this order */
static const double change_aside[] = {5e-3, 2e-3, 1e-3, 1e-2, 3e-2};
enum { ASIDE = sizeof change_aside / sizeof *change_aside };

void pend_orbit_change_aside(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    if (o->attempts == ASIDE) {
        pend_orbit_search_over(o, PEND_ORBITS_APART);
        return;
    }
    double far = change_aside[o->attempts++];
    for (int j = 0; j < newton->unknowns; j++) newton->u[j] = o->last.u[j] + far * o->last.along[j];
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, FIRST);
}

int pend_orbit_change_far(const struct pend_orbits *o) {
    double far = change_near * change_aside[o->attempts - 1], most = 0;
    for (int j = 0; j < o->newton.unknowns; j++)
        most = fmax(most, fabs(o->newton.u[j] - o->last.u[j]));
    return most > far;
}

/* Interpolates the unknowns at a fraction of the path between the two orbits by a cubic. Linear
 * interpolation is not accurate enough if another branch crosses, because the equations hardly
 * change along that branch. */
static void change_between_two(const struct pend_orbits *o, double part, double u[]) {
    int q = o->newton.unknowns;
    const double *a = o->last.u, *b = o->next.u, *from = o->last.along, *to = o->next.along;
    double chord = 0, rest = 1 - part;
    for (int j = 0; j < q; j++) chord += (b[j] - a[j]) * (b[j] - a[j]);
    double here = sqrt(chord / pend_orbit_search_dot(from, from, q)),
           there = sqrt(chord / pend_orbit_search_dot(to, to, q));
    for (int j = 0; j < q; j++)
        u[j] = rest * rest * ((1 + 2 * part) * a[j] + part * here * from[j]) +
               part * part * ((1 + 2 * rest) * b[j] - rest * there * to[j]);
}

static void change_locate_at(struct pend_orbits *o) {
    change_between_two(o, o->at, o->newton.u);
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, LOCATE);
}

/* True if a boundary lies between two orbits. The unit circle counts if more multipliers cross it
 * than at +1 and -1. */
static int change_passes(const struct orbits_mark *a, const struct orbits_mark *b, int border) {
    int passed = abs(a->side[border] - b->side[border]);
    if (border != ORBIT_AROUND) return passed > 0;
    return passed > change_passes(a, b, ORBIT_PLUS) + change_passes(a, b, ORBIT_MINUS);
}

/* the first boundary between two orbits that is to be located; ORBIT_BORDERS if there is none */
static int change_border(const struct orbits_mark *a, const struct orbits_mark *b) {
    static const int order[] = {ORBIT_TURN, ORBIT_PLUS, ORBIT_MINUS, ORBIT_AROUND};
    for (int i = 0; i < ORBIT_BORDERS; i++)
        if (change_passes(a, b, order[i])) return order[i];
    return ORBIT_BORDERS;
}

static struct orbits_mark *change_top(struct pend_orbits *o) {
    assert(o->waiting > 0 && o->waiting <= ORBITS_AHEAD);
    return &o->ahead[o->waiting - 1];
}

static void change_locate(struct pend_orbits *o) {
    const struct orbits_mark *low = &o->low, *top = change_top(o);
    int border = change_border(low, top);
    if (border != o->border) o->side = 0, o->weight[0] = o->weight[1] = 1;
    o->border = border;
    int tests = border != ORBIT_AROUND;
    double from = tests ? o->weight[0] * low->test[border] : 0;
    double to = tests ? o->weight[1] * top->test[border] : 0;
    o->at = (low->at + top->at) / 2;
    if (from * to < 0)
        o->at = low->at + fmin(0.98, fmax(0.02, from / (from - to))) * (top->at - low->at);
    change_locate_at(o);
    o->tries++;
}

/* At a crossing of branches the equations are singular, and rounding errors decide whether an orbit
 * is found. This searches for the closest orbit nearby instead. Returns 0 if every attempt was
 * used. */
static int change_locate_beside(struct pend_orbits *o) {
    int lost = o->tries / LOCATE_LOST;
    double away = change_beside * pow(5, lost) * (lost % 2 ? -1 : 1);
    if (lost == CHANGE_BESIDE) return 0;
    o->tries = LOCATE_LOST * (lost + 1);
    o->at += o->at + away > o->low.at && o->at + away < change_top(o)->at ? away : -away;
    change_locate_at(o);
    return 1;
}

/* true if no real multiplier is within rounding errors of a boundary */
static int change_surely(const struct orbits_mark *mark, int border) {
    return mark->beyond[border] == mark->surely[border];
}

/* determines the side of each boundary on which an orbit lies */
static void change_sides(const struct pend_orbits *o, struct orbits_mark *mark) {
    mark->side[ORBIT_AROUND] = mark->outside;
    mark->side[ORBIT_TURN] = mark->test[ORBIT_TURN] > 0;
    for (int i = 0; i < ORBIT_REAL; i++) {
        int real = o->known[i] ? mark->beyond[i] : mark->surely[i];
        mark->side[i] = real % 2;
        mark->side[ORBIT_AROUND] += real;
    }
}

void pend_orbit_change_next(struct pend_orbits *o) {
    if (o->waiting < 0) {
        o->low = o->last.mark, o->low.at = 0;
        o->ahead[0] = o->next.mark, o->ahead[0].at = 1;
        o->waiting = 1;
        for (int i = 0; i < ORBIT_REAL; i++)
            o->known[i] = change_surely(&o->low, i) || change_surely(&o->ahead[0], i);
        change_sides(o, &o->low);
        change_sides(o, &o->ahead[0]);
    }
    while (o->waiting && change_border(&o->low, change_top(o)) == ORBIT_BORDERS)
        o->low = *change_top(o), o->waiting--;
    o->tries = o->beside = 0, o->border = ORBIT_BORDERS;
    if (o->waiting) {
        change_locate(o);
        return;
    }
    // restores the aim of the step, which the search for bifurcations replaced
    o->aim = o->came, o->stage = FORWARD;
}

void pend_orbit_change_leave(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    size_t q = (size_t)newton->unknowns;
    for (size_t j = 0; j < q; j++) o->turned[j] = o->next.u[j] - o->last.u[j];
    memcpy(o->last.u, newton->u, q * sizeof(double));
    if (pend_orbit_switch_form(&newton->form, o->now.kind))
        pend_orbit_search_begin(o, LOOK);
    else
        pend_orbit_search_over(o, PEND_ORBITS_APART);
}

enum pend_status pend_orbit_change_looked(struct pend_orbits *o) {
    size_t q = (size_t)o->newton.unknowns;
    int found;
    PEND_TRY(pend_orbit_switch_direction(&o->newton, o->turned, o->problem.leave[o->left],
                                         o->leaving, &found));
    if (!found && o->newton.form.equations == o->newton.form.n) {
        // free orbits may start at this bifurcation
        const double *acc = o->newton.map.energy_by; // at the start between two states of rest
        int turning = 0;
        for (int k = 1; k < o->newton.form.n; k++)
            if (fabs(acc[k]) > fabs(acc[turning])) turning = k;
        pend_orbit_newton_free(&o->newton, turning, o->turned);
        memcpy(o->last.u, o->newton.u, (size_t)o->newton.unknowns * sizeof(double));
        pend_orbit_search_begin(o, LOOK);
        return PEND_OK;
    }
    if (!found) pend_orbit_search_over(o, PEND_ORBITS_APART);
    if (!found) return PEND_OK;
    memcpy(o->last.along, o->leaving, q * sizeof(double));
    o->left++;
    o->points = o->met = o->attempts = 0;
    o->turned_at = PEND_ORBITS_KINDS;
    o->step = o->begin;
    pend_orbit_change_aside(o);
    return PEND_OK;
}

/* continues after a bifurcation was reported: leaves the branch there, or follows it */
static void change_met(struct pend_orbits *o, enum pend_orbits_found *found) {
    int pending = o->left < o->problem.switches;
    o->met++;
    o->stage = pending && abs(o->problem.leave[o->left]) == o->met ? LEAVE : CHANGES;
    if (o->now.turns && o->now.kind != PEND_ORBITS_FOLD) o->turned_at = o->now.kind;
    *found = PEND_ORBITS_BIFURCATION;
}

static int change_turns(const struct pend_orbits *o) {
    return (o->last.mark.test[ORBIT_TURN] > 0) != (o->next.mark.test[ORBIT_TURN] > 0);
}

/* the slope at an orbit, relative to the slopes at the last orbit and the next */
static double change_slope(const struct pend_orbits *o, const struct orbits_mark *mark) {
    return fabs(mark->test[ORBIT_TURN]) /
           fmax(fabs(o->last.mark.test[ORBIT_TURN]), fabs(o->next.mark.test[ORBIT_TURN]));
}

/* At a fold a multiplier crosses +1 or touches it. Near a fold, the slope is the more reliable test
 * for the side of +1. */
static void change_tie(struct pend_orbits *o, struct orbits_mark *mark) {
    const struct orbits_mark *low = &o->low, *top = change_top(o);
    const struct orbits_mark *same = change_passes(low, mark, ORBIT_TURN) ? top : low;
    double test = fabs(mark->test[ORBIT_PLUS]);
    double most = fmax(fabs(o->last.mark.test[ORBIT_PLUS]), fabs(o->next.mark.test[ORBIT_PLUS]));
    if (!change_passes(low, top, ORBIT_TURN) || !change_passes(same, mark, ORBIT_PLUS)) return;
    if (test > change_turn * most) return;
    mark->side[ORBIT_PLUS] = same->side[ORBIT_PLUS];
    mark->side[ORBIT_AROUND] += same->side[ORBIT_AROUND] < mark->side[ORBIT_AROUND] ? -1 : 1;
}

/* true if the branch turns back between `low` and the nearest orbit ahead although no multiplier
 * crosses +1 */
static int change_touches(struct pend_orbits *o) {
    const struct orbits_mark *low = &o->low, *top = change_top(o);
    return change_passes(low, top, ORBIT_TURN) && !change_passes(low, top, ORBIT_PLUS);
}

/* determines the sides of the orbit found between the two; false if it is on another branch */
static int change_mark(struct pend_orbits *o, struct orbits_mark *mark) {
    int q = o->newton.unknowns;
    double *along = o->leaving;
    const double *last = o->last.along;
    *mark = (struct orbits_mark){.at = o->at};
    memcpy(along, last, (size_t)q * sizeof *along);
    if (change_turns(o) && !pend_orbit_newton_tangent(&o->newton, along)) return 0;
    pend_orbit_search_mark(o, along, mark);
    change_sides(o, mark);
    if (!change_turns(o)) mark->side[ORBIT_TURN] = o->low.side[ORBIT_TURN];
    change_tie(o, mark);
    // near a crossing, Newton's method may converge to the other branch, whose slope differs
    double slope = fmax(fabs(o->low.test[ORBIT_TURN]), fabs(change_top(o)->test[ORBIT_TURN]));
    if (change_touches(o) && !o->beside && fabs(mark->test[ORBIT_TURN]) > change_other * slope)
        return 0;
    double sizes = pend_orbit_search_dot(along, along, q) * pend_orbit_search_dot(last, last, q);
    return pend_orbit_search_dot(along, last, q) >= change_bend * sqrt(sizes);
}

/* Inserts an orbit between `low` and the nearest orbit ahead. An end that stays the same twice in a
 * row gets less weight (Illinois method). */
static void change_put(struct pend_orbits *o, const struct orbits_mark *mark) {
    int below = change_border(&o->low, mark) == ORBIT_BORDERS;
    if (below) {
        o->low = *mark, o->weight[0] = 1;
        if (o->side < 0) o->weight[1] /= 2;
    } else {
        if (change_border(mark, change_top(o)) < ORBIT_BORDERS && o->waiting < ORBITS_AHEAD)
            o->waiting++;
        *change_top(o) = *mark, o->weight[1] = 1;
        if (o->side > 0) o->weight[0] /= 2;
    }
    o->side = below ? -1 : 1;
}

static int change_single(struct pend_orbits *o) {
    const struct orbits_mark *low = &o->low, *top = change_top(o);
    int passes[ORBIT_BORDERS], count = 0;
    for (int i = 0; i < ORBIT_BORDERS; i++) count += passes[i] = change_passes(low, top, i);
    return count == 1 || (count == 2 && passes[ORBIT_PLUS] && passes[ORBIT_TURN]);
}

/* the kind of the bifurcation at the orbit found, as far as multipliers determine it */
static enum pend_orbits_kind change_kind(struct pend_orbits *o) {
    const struct orbits_mark *low = &o->low, *top = change_top(o);
    int plus = o->border == ORBIT_PLUS, around = o->border == ORBIT_AROUND;
    if (o->border == ORBIT_TURN) return change_touches(o) ? PEND_ORBITS_BRANCH : PEND_ORBITS_FOLD;
    // several real multipliers may cross together, for example with equal branches
    if (plus || (around && low->beyond[ORBIT_PLUS] != top->beyond[ORBIT_PLUS]))
        return PEND_ORBITS_BRANCH;
    if (around && low->beyond[ORBIT_MINUS] == top->beyond[ORBIT_MINUS]) return PEND_ORBITS_TORUS;
    return o->newton.form.mirrored ? PEND_ORBITS_SYMMETRY : PEND_ORBITS_DOUBLING;
}

static void change_beyond(struct pend_orbits *o) {
    struct orbits_mark *low = &o->low;
    const struct orbits_mark *top = change_top(o);
    int way = top->side[ORBIT_AROUND] < low->side[ORBIT_AROUND] ? -1 : 1;
    if (o->border == ORBIT_AROUND) {
        low->side[ORBIT_AROUND] += 2 * way;
        return;
    }
    if (!change_touches(o)) low->side[ORBIT_AROUND] += way;
    if (o->border == ORBIT_TURN) low->side[ORBIT_PLUS] = top->side[ORBIT_PLUS];
    low->side[o->border] = top->side[o->border];
}

/* True if the motion over half of the period is needed to classify a crossing branch: its orbits
 * may be mirror images of themselves, or have half of the period. */
static int change_halves(const struct pend_orbits *o) {
    const struct orbit_form *form = &o->newton.form;
    return o->now.kind == PEND_ORBITS_BRANCH && !form->mirrored;
}

enum pend_status pend_orbit_change_halved(struct pend_orbits *o, enum pend_orbits_found *found) {
    const struct orbit_newton *newton = &o->newton;
    const struct orbit_form *form = &newton->form;
    const struct orbit_map *map = &newton->map;
    int breaks = 1, turns = o->now.turns;
    double chord = 0;
    for (int j = 0; j < form->equations; j++)
        chord = fmax(chord, fabs(o->next.u[j] - o->last.u[j]));
    // orbits at a bifurcation are less exact
    double alike = turns ? branch_near * chord : 10 * orbits_alike;
    if (turns && form->times % 2 == 0 && pend_orbit_form_apart(form, map, 1) < alike)
        o->now.kind = PEND_ORBITS_DOUBLING;
    if (o->now.kind == PEND_ORBITS_BRANCH && pend_orbit_form_apart(form, map, -1) < alike) {
        // an equilibrium is its own mirror image at every instant
        int moves = pend_orbit_form_apart(form, NULL, -1) > alike;
        if (form->kind == ORBIT_DRIVEN && moves)
            PEND_TRY(pend_orbit_floquet_half(&o->floquet, newton, &breaks));
        if (breaks) o->now.kind = PEND_ORBITS_SYMMETRY;
    }
    change_met(o, found);
    return PEND_OK;
}

static enum pend_status change_tell(struct pend_orbits *o, enum pend_orbits_found *found,
                                    struct pend_error *error) {
    PEND_TRY(pend_orbit_search_tell(o, o->newton.u, error));
    o->now.kind = change_kind(o), o->now.turns = o->border == ORBIT_TURN;
    change_beyond(o);
    if (!change_halves(o))
        change_met(o, found);
    else if (o->newton.form.kind == ORBIT_HALF)
        return pend_orbit_change_halved(o, found);
    else
        pend_orbit_search_begin(o, HALF);
    return PEND_OK;
}

/* which orbit near a fold is searched next */
enum { BEYOND = 1, BEFORE, AT };

/* The branch turns back at the orbit found, although no multiplier seems to cross +1 there. If
 * another branch meets this one, a multiplier only touches +1. Orbits on both sides decide which is
 * the case. */
static void change_touch(struct pend_orbits *o) {
    if (!o->beside++) o->touch = o->at;
    if (o->beside == BEFORE && o->touch - o->low.at <= change_turn) o->beside = AT;
    o->at = o->touch;
    if (o->beside == BEYOND) o->at = fmin(o->touch + change_turn, (o->touch + 1) / 2);
    if (o->beside == BEFORE) o->at = o->touch - change_turn;
    while (o->beside == BEYOND && o->waiting > 1 && change_top(o)->at <= o->at) o->waiting--;
    change_locate_at(o);
}

/* reports the bifurcation at the next orbit, because none was found between the two */
static enum pend_status change_unplaced(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    struct pend_problem motion;
    PEND_TRY(pend_orbit_form_set(&o->newton.form, o->next.u, 1, &motion, error));
    o->now.period = pend_orbit_form_period(&o->newton.form);
    o->border = change_border(&o->low, change_top(o));
    o->now.kind = change_kind(o), o->now.turns = o->border == ORBIT_TURN;
    change_beyond(o);
    change_met(o, found);
    if (o->stage == LEAVE) pend_orbit_search_over(o, PEND_ORBITS_APART);
    return PEND_OK;
}

enum pend_status pend_orbit_change_lost(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    if (o->aim == HALF)
        change_met(o, found);
    else if (!change_locate_beside(o))
        return change_unplaced(o, found, error);
    return PEND_OK;
}

/* true if the bifurcation between `low` and the nearest orbit ahead is at the orbit found */
static int change_exact(struct pend_orbits *o, const struct orbits_mark *mark, int border) {
    int single = change_single(o), folds = change_passes(&o->low, change_top(o), ORBIT_PLUS);
    if (change_top(o)->at - o->low.at <= change_short || o->tries >= CHANGE_MOST) return 1;
    if (!single || (border != o->border && !o->beside) || border == ORBIT_AROUND) return 0;
    if (border == ORBIT_TURN)
        return o->beside || change_slope(o, mark) <= (folds ? change_zero : change_turn);
    return fabs(mark->test[border]) <= change_zero;
}

enum pend_status pend_orbit_change_between(struct pend_orbits *o, enum pend_orbits_found *found,
                                           struct pend_error *error) {
    struct orbits_mark mark;
    if (!change_mark(o, &mark)) return pend_orbit_change_lost(o, found, error);
    if (o->beside == AT) return change_tell(o, found, error);
    change_put(o, &mark);
    int border = change_border(&o->low, change_top(o)), exact = change_exact(o, &mark, border);
    int touches = change_touches(o);
    if (!touches && o->beside == BEFORE) o->beside = exact = 0;
    assert(border < ORBIT_BORDERS);
    if (exact) o->border = border;
    if (o->beside || (exact && touches))
        change_touch(o);
    else if (exact)
        return change_tell(o, found, error);
    else
        change_locate(o);
    return PEND_OK;
}
