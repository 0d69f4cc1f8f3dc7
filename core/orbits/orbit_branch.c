#include "core/orbits/orbit_branch.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LOCATE_MOST = 40, EASY = 3, HARD = 5 };

/* the shortest step, in parts of the longest */
static const double orbits_shortest = 1e-5;

/* cosine of the largest angle between the directions of a step's ends */
static const double orbits_bend = 0.9;

/* an orbit that misses its start by more, times the growth of its disturbances, is none; and one
 * that misses it by more whatever the growth is not known to be one */
static const double orbits_closed = 1e-9, orbits_wild = 1e-3;

/* a bifurcation is known to this part of a step, or where the test for it is so small */
static const double orbits_exact = 1e-7, orbits_zero = 1e-11;

/* how far beside a part of a step at which no orbit was found one is looked for, five times as far
 * each time; what that adds to the tries, so that the next orbit found is the last, and how often
 */
static const double orbits_beside = 2e-6;
enum { LOCATE_LOST = 1000, LOCATE_BESIDE = 5 };

/* parts of the unit of unknowns: how far from a bifurcation the first orbit of the branch that
 * begins there is looked for, one after the other; and how much farther it may be */
static const double orbits_aside[] = {5e-3, 2e-3, 1e-3, 1e-2, 3e-2};
static const double orbits_near = 8;
enum { ASIDE = sizeof orbits_aside / sizeof *orbits_aside };

int pend_orbits_valid(const struct pend_orbits *orbits) {
    return orbits->newton.unknowns == orbits->newton.form.equations + 1 && orbits->step > 0 &&
           orbits->points >= 0 && orbits->problem.points >= 1 &&
           orbits->left <= orbits->problem.switches;
}

void pend_orbit_branch_plane(struct pend_orbits *o, const double normal[]) {
    struct orbit_newton *newton = &o->newton;
    newton->value = 0;
    for (int j = 0; j < newton->unknowns; j++) {
        newton->normal[j] = normal[j];
        newton->value += normal[j] * newton->u[j];
    }
}

void pend_orbit_branch_search(struct pend_orbits *o, enum orbits_aim aim) {
    o->aim = aim, o->stage = SEARCH;
    o->newton.look = aim == LOOK;
    o->newton.whole = (o->problem.branch || o->problem.driven || aim == LAST) && aim != LOOK;
    o->newton.careful = o->problem.driven && aim == FIRST && !o->left;
    o->newton.energy = aim == LAST && !o->problem.driven && o->problem.target == PEND_ORBIT_ENERGY;
    pend_orbit_newton_begin(&o->newton);
}

/* ---- along the branch */

static double orbits_dot(const double a[], const double b[], int count) {
    assert(a && b && count >= 0);
    double sum = 0;
    for (int j = 0; j < count; j++) sum += a[j] * b[j];
    return sum;
}

static void orbits_over(struct pend_orbits *o, enum pend_orbits_end end) {
    int ended = end == PEND_ORBITS_REACHED || end == PEND_ORBITS_POINTS ||
                end == PEND_ORBITS_BACK || end == PEND_ORBITS_CLOSED;
    o->end = ended && o->left < o->problem.switches ? PEND_ORBITS_MISSING : end;
    o->stage = OVER;
}

/* looks for the orbit at the end of the next step */
static void orbits_predict(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    double bend = o->before > 0 ? o->step * o->step / (2 * o->before) : 0;
    for (int j = 0; j < newton->unknowns; j++)
        newton->u[j] =
            o->last.u[j] + o->step * o->last.along[j] + bend * (o->last.along[j] - o->turned[j]);
    pend_orbit_branch_plane(o, o->last.along);
    pend_orbit_branch_search(o, STEP);
}

/* looks for an orbit of the branch that begins at a bifurcation, at the next distance from it */
static void orbits_aside_try(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    if (o->attempts == ASIDE) {
        orbits_over(o, PEND_ORBITS_APART);
        return;
    }
    double far = orbits_aside[o->attempts++];
    for (int j = 0; j < newton->unknowns; j++) newton->u[j] = o->last.u[j] + far * o->last.along[j];
    pend_orbit_branch_plane(o, o->last.along);
    pend_orbit_branch_search(o, FIRST);
}

/* a step that failed is tried once more, shorter */
static void orbits_failed(struct pend_orbits *o, enum pend_orbits_end why) {
    o->why = why;
    if (o->aim != FIRST) o->step /= 3;
    if (o->aim == FIRST && o->left)
        orbits_aside_try(o);
    else if (o->aim == FIRST)
        orbits_over(o, why == PEND_ORBITS_LOST ? PEND_ORBITS_NONE : why);
    else if (o->step < orbits_shortest * o->problem.step)
        orbits_over(o, why);
    else
        orbits_predict(o);
}

/* which part of the way to the end of the branch a list of unknowns has gone; which arm swings
 * farthest */
static double orbits_way(const struct pend_orbits *o, const double u[], int *arm) {
    int n = o->newton.form.n;
    *arm = 0;
    const double *swing = o->newton.form.kind == ORBIT_FREE ? o->check.amplitude : u;
    if (o->problem.driven) return u[2 * n];
    for (int k = 1; k < n; k++)
        if (fabs(swing[k]) > fabs(swing[*arm])) *arm = k;
    return o->problem.target == PEND_ORBIT_ENERGY
               ? pend_orbit_newton_energy(&o->newton) / o->problem.until
               : fabs(swing[*arm]) / o->problem.until;
}

/* looks for the orbit at the very end, which the last step has passed */
static void orbits_land(struct pend_orbits *o, double way, int arm) {
    struct orbit_newton *newton = &o->newton;
    int q = newton->unknowns;
    double part = way > o->way ? (1 - o->way) / (way - o->way) : 1;
    for (int j = 0; j < q; j++) newton->u[j] = o->last.u[j] + part * (newton->u[j] - o->last.u[j]);
    memset(newton->normal, 0, (size_t)q * sizeof(double));
    newton->normal[o->problem.driven ? q - 1 : arm] =
        !o->problem.driven && o->next.u[arm] < 0 ? -1 : 1;
    pend_orbit_branch_search(o, LAST);
    newton->value = o->problem.driven ? 1 : o->problem.until;
}

/* tells of the orbit that the equations are set to */
static enum pend_status orbits_tell(struct pend_orbits *o, const double u[],
                                    struct pend_error *error) {
    struct orbit_form *form = &o->newton.form;
    struct pend_problem motion;
    PEND_TRY(pend_orbit_form_set(form, u, 1, &motion, error));
    for (int k = 0; k < form->n && !o->problem.driven; k++) o->amplitude[k] = fabs(u[k]);
    o->now.phi = form->phi, o->now.phi_low = form->phi_low, o->now.rate = form->rate;
    o->now.re = o->floquet.re, o->now.im = o->floquet.im;
    o->now.amplitude = form->kind >= ORBIT_FREE ? o->check.amplitude : o->amplitude;
    o->now.period = pend_orbit_form_period(form);
    o->now.energy = o->problem.driven ? 0 : pend_orbit_newton_energy(&o->newton);
    o->now.value = o->problem.driven && o->problem.vary ? pend_orbit_form_value(form, u) : 0;
    o->now.closure = o->check.closure;
    o->now.stable = o->floquet.stable;
    return PEND_OK;
}

/* takes the orbit that was found for the next one, with its direction; false if there is none, or
 * if the branch turns too much on the way there */
static int orbits_take(struct pend_orbits *o) {
    int q = o->newton.unknowns, alone = o->problem.driven && !o->problem.vary;
    double *along = o->next.along;
    const double *before = o->last.along;
    memcpy(o->next.u, o->newton.u, (size_t)q * sizeof(double));
    memcpy(along, before, (size_t)q * sizeof(double));
    if (!alone && !pend_orbit_newton_tangent(&o->newton, along)) return 0;
    double turn = orbits_dot(along, before, q) /
                  sqrt(orbits_dot(along, along, q) * orbits_dot(before, before, q));
    return o->aim == FIRST || turn >= orbits_bend;
}

/* true if the orbit that was taken is beyond an end of the branch, which ends or lands there */
static int orbits_beyond(struct pend_orbits *o) {
    int arm;
    double way = orbits_way(o, o->next.u, &arm);
    // the amplitude of an orbit that does not rest is no unknown
    int seen = o->newton.form.kind == ORBIT_FREE && o->problem.target == PEND_ORBIT_AMPLITUDE;
    if (o->aim == STEP && way >= 1 && seen) o->aim = LAST;
    if (o->aim == STEP && way >= 1) {
        orbits_land(o, way, arm);
        return 1;
    }
    if (!o->problem.driven || way >= 0) return 0;
    orbits_over(o, PEND_ORBITS_BACK);
    return 1;
}

/* the orbit that was found is on the branch */
static enum pend_status orbits_accept(struct pend_orbits *o, enum pend_orbits_found *found,
                                      struct pend_error *error) {
    struct orbit_newton *newton = &o->newton;
    struct orbits_point *next = &o->next;
    if (!orbits_take(o)) {
        orbits_failed(o, PEND_ORBITS_LOST);
        return PEND_OK;
    }
    if (orbits_beyond(o)) return PEND_OK;
    next->slope = o->problem.driven ? next->along[newton->unknowns - 1]
                                    : pend_orbit_newton_slope(newton, next->along);
    memcpy(next->count, o->floquet.count, sizeof next->count);
    memcpy(next->test, o->floquet.test, sizeof next->test);
    PEND_TRY(orbits_tell(o, next->u, error));
    if (newton->whole) *found = PEND_ORBITS_ORBIT;
    o->border = -1, o->came = o->aim;
    o->stage = o->aim != FIRST && o->problem.branch ? CHANGES : FORWARD;
    return PEND_OK;
}

/* true if the last step has passed the first orbit of a branch that begins at a bifurcation, in the
 * direction in which it left it; keeps the first orbit */
static int orbits_closes(struct pend_orbits *o) {
    static const double part_missed = 0.1; // of a step: a straight line is no closer
    size_t q = (size_t)o->newton.unknowns;
    const double *a = o->last.u, *b = o->next.u, *home = o->home, *along = o->home + q;
    double before = 0, after = 0, chord = 0, missed = 0;
    if (!o->left) return 0;
    if (o->aim == FIRST) {
        memcpy(o->home, o->next.u, q * sizeof(double));
        memcpy(o->home + q, o->next.along, q * sizeof(double));
        return 0;
    }
    for (size_t j = 0; j < q; j++) {
        before += along[j] * (a[j] - home[j]), after += along[j] * (b[j] - home[j]);
        chord = fmax(chord, fabs(b[j] - a[j]));
    }
    if (!(before < 0 && after >= 0)) return 0;
    double part = before / (before - after);
    for (size_t j = 0; j < q; j++)
        missed = fmax(missed, fabs(a[j] + part * (b[j] - a[j]) - home[j]));
    return missed <= part_missed * chord;
}

/* goes on from the orbit that was found, or ends */
static void orbits_forward(struct pend_orbits *o) {
    int q = o->newton.unknowns, first = o->aim == FIRST, last = o->aim == LAST, arm;
    struct orbits_point keep = o->last;
    double way = 0;
    if (orbits_closes(o)) {
        orbits_over(o, PEND_ORBITS_CLOSED);
        return;
    }
    for (int j = 0; j < q && !first; j++) way = fmax(way, fabs(o->next.u[j] - o->last.u[j]));
    memcpy(o->turned, o->last.along, (size_t)q * sizeof(double));
    o->last = o->next, o->next = keep;
    o->before = first ? 0 : way;
    o->way = orbits_way(o, o->last.u, &arm);
    if (last || (o->problem.driven && !o->problem.vary)) {
        orbits_over(o, PEND_ORBITS_REACHED);
        return;
    }
    if (++o->points >= o->problem.points) {
        orbits_over(o, PEND_ORBITS_POINTS);
        return;
    }
    int corrections = o->newton.iteration;
    if (!first && corrections <= EASY) o->step = fmin(1.6 * o->step, o->problem.step);
    if (corrections >= HARD) o->step *= 0.7;
    orbits_predict(o);
}

/* ---- bifurcations between the last orbit and the next */

/* The unknowns at a part of the way between the two orbits, on a cubic curve: where another branch
 * crosses, corrections along it hardly change the equations, and a line's guess is not enough. */
static void orbits_between_two(const struct pend_orbits *o, double part, double u[]) {
    int q = o->newton.unknowns;
    const double *a = o->last.u, *b = o->next.u, *from = o->last.along, *to = o->next.along;
    double chord = 0, rest = 1 - part;
    for (int j = 0; j < q; j++) chord += (b[j] - a[j]) * (b[j] - a[j]);
    double here = sqrt(chord / orbits_dot(from, from, q)),
           there = sqrt(chord / orbits_dot(to, to, q));
    for (int j = 0; j < q; j++)
        u[j] = rest * rest * ((1 + 2 * part) * a[j] + part * here * from[j]) +
               part * part * ((1 + 2 * rest) * b[j] - rest * there * to[j]);
}

/* looks for the orbit at the part of the way at which the search is */
static void orbits_locate_at(struct pend_orbits *o) {
    orbits_between_two(o, o->at, o->newton.u);
    pend_orbit_branch_plane(o, o->last.along);
    pend_orbit_branch_search(o, LOCATE);
}

/* looks for the orbit at the next part of the way */
static void orbits_locate(struct pend_orbits *o) {
    o->at = (o->low + o->high) / 2;
    if (o->border != ORBIT_AROUND && o->low_test * o->high_test < 0) {
        double part = o->low_test / (o->low_test - o->high_test);
        o->at = o->low + fmin(0.98, fmax(0.02, part)) * (o->high - o->low);
    }
    orbits_locate_at(o);
    o->tries++;
}

/* At a crossing of branches the equations are singular, and rounding errors decide whether an orbit
 * is found: the bifurcation is that beside it, as near as one is. Returns 0 where none is. */
static int orbits_locate_beside(struct pend_orbits *o) {
    int lost = o->tries / LOCATE_LOST;
    double away = orbits_beside * pow(5, lost) * (lost % 2 ? -1 : 1);
    if (lost == LOCATE_BESIDE) return 0;
    o->tries = LOCATE_LOST * (lost + 1);
    o->at += o->at + away > o->low && o->at + away < o->high ? away : -away;
    orbits_locate_at(o);
    return 1;
}

/* begins with the next border that lies between the two orbits; without one the branch goes on */
static void orbits_change(struct pend_orbits *o) {
    const struct orbits_point *last = &o->last, *next = &o->next;
    do o->border++;
    while (o->border < ORBIT_COUNTS && last->count[o->border] == next->count[o->border]);
    o->tries = o->side = 0, o->low = 0, o->high = 1;
    if (o->border == ORBIT_COUNTS) {
        // looking for bifurcations had an aim of its own
        o->aim = o->came, o->stage = FORWARD;
        return;
    }
    o->low_test = last->test[o->border], o->high_test = next->test[o->border];
    orbits_locate(o);
}

/* the branch is left at the bifurcation to which the equations are set: a look at it by the
 * equations of the other one */
static void orbits_leave(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    size_t q = (size_t)newton->unknowns;
    for (size_t j = 0; j < q; j++) o->turned[j] = o->next.u[j] - o->last.u[j];
    memcpy(o->last.u, newton->u, q * sizeof(double));
    if (pend_orbit_switch_form(&newton->form, o->now.kind))
        pend_orbit_branch_search(o, LOOK);
    else
        orbits_over(o, PEND_ORBITS_APART);
}

/* the look has seen in which direction the other branch leaves */
static enum pend_status orbits_looked(struct pend_orbits *o) {
    size_t q = (size_t)o->newton.unknowns;
    int found;
    PEND_TRY(pend_orbit_switch_direction(&o->newton, o->turned, o->problem.leave[o->left],
                                         o->leaving, &found));
    if (!found && o->newton.form.equations == o->newton.form.n) {
        // orbits that do not rest may begin there
        pend_orbit_newton_free(&o->newton, pend_orbit_switch_turning(&o->newton), o->turned);
        memcpy(o->last.u, o->newton.u, (size_t)o->newton.unknowns * sizeof(double));
        pend_orbit_branch_search(o, LOOK);
        return PEND_OK;
    }
    if (!found) orbits_over(o, PEND_ORBITS_APART);
    if (!found) return PEND_OK;
    memcpy(o->last.along, o->leaving, q * sizeof(double));
    o->left++;
    o->points = o->met = o->attempts = 0;
    o->step = o->begin;
    orbits_aside_try(o);
    return PEND_OK;
}

/* what follows on a bifurcation that was told: the branch is left there, or goes on */
static void orbits_met(struct pend_orbits *o) {
    int pending = o->left < o->problem.switches;
    o->met++;
    o->stage = pending && abs(o->problem.leave[o->left]) == o->met ? LEAVE : CHANGES;
}

static enum pend_orbits_kind orbits_kind(const struct pend_orbits *o) {
    if (o->border == ORBIT_AROUND) return PEND_ORBITS_TORUS;
    if (o->border == ORBIT_PLUS)
        return o->last.slope * o->next.slope < 0 ? PEND_ORBITS_FOLD : PEND_ORBITS_BRANCH;
    return o->newton.form.mirrored ? PEND_ORBITS_SYMMETRY : PEND_ORBITS_DOUBLING;
}

/* an orbit between the two was found: it is on one side of the border, or nearly at it */
static enum pend_status orbits_between(struct pend_orbits *o, enum pend_orbits_found *found,
                                       struct pend_error *error) {
    int border = o->border, below = o->floquet.count[border] == o->last.count[border];
    double test = o->floquet.test[border];
    assert(border >= 0 && border < ORBIT_COUNTS);
    // the end that stays twice is given less weight (the Illinois method)
    if (below) {
        o->low = o->at, o->low_test = test;
        if (o->side < 0) o->high_test /= 2;
    } else {
        o->high = o->at, o->high_test = test;
        if (o->side > 0) o->low_test /= 2;
    }
    o->side = below ? -1 : 1;
    int exact = o->high - o->low <= orbits_exact || o->tries >= LOCATE_MOST ||
                (border != ORBIT_AROUND && fabs(test) <= orbits_zero);
    if (!exact) {
        orbits_locate(o);
        return PEND_OK;
    }
    PEND_TRY(orbits_tell(o, o->newton.u, error));
    o->now.kind = orbits_kind(o);
    *found = PEND_ORBITS_BIFURCATION;
    orbits_met(o);
    return PEND_OK;
}

/* no orbit was found at a part of the way: the bifurcation is told where the next orbit is */
static enum pend_status orbits_unplaced(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    struct pend_problem motion;
    PEND_TRY(pend_orbit_form_set(&o->newton.form, o->next.u, 1, &motion, error));
    o->now.period = pend_orbit_form_period(&o->newton.form);
    o->now.kind = orbits_kind(o);
    *found = PEND_ORBITS_BIFURCATION;
    orbits_met(o);
    if (o->stage == LEAVE) orbits_over(o, PEND_ORBITS_APART);
    return PEND_OK;
}

/* ---- pieces */

/* Newton's method has found a solution: is it an orbit? */
static enum pend_status orbits_solution(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    struct orbit_newton *newton = &o->newton;
    struct pend_problem motion;
    if (newton->whole) PEND_TRY(pend_orbit_floquet_at(&o->floquet, newton));
    if (o->aim == LOCATE) return orbits_between(o, found, error);
    if (o->aim == LOOK) return orbits_looked(o);
    if (!newton->whole) return orbits_accept(o, found, error);
    o->stage = CHECK;
    PEND_TRY(pend_orbit_form_set(&newton->form, newton->u, 1, &motion, error));
    return pend_orbit_check_begin(&o->check, &newton->form, &motion, error);
}

/* true if an orbit is so far from the bifurcation that it was looked for at that it need not belong
 * to the branch that begins there */
static int orbits_far(const struct pend_orbits *o) {
    double far = orbits_near * orbits_aside[o->attempts - 1], most = 0;
    for (int j = 0; j < o->newton.unknowns; j++)
        most = fmax(most, fabs(o->newton.u[j] - o->last.u[j]));
    return most > far;
}

static enum pend_status orbits_checked(struct pend_orbits *o, enum pend_orbits_found *found,
                                       struct pend_error *error) {
    double closure = o->check.closure;
    o->part = o->check.divisor;
    if (o->aim == FIRST && o->left && orbits_far(o)) {
        orbits_failed(o, PEND_ORBITS_LOST);
        return PEND_OK;
    }
    if (closure <= orbits_closed * o->floquet.growth && closure <= orbits_wild && o->part == 1)
        return orbits_accept(o, found, error);
    orbits_failed(o, closure > orbits_closed * o->floquet.growth ? PEND_ORBITS_LOST
                     : closure > orbits_wild                     ? PEND_ORBITS_WILD
                                                                 : PEND_ORBITS_MEETS);
    return PEND_OK;
}

/* Newton's method has found none */
static enum pend_status orbits_lost(struct pend_orbits *o, enum pend_orbits_found *found,
                                    struct pend_error *error) {
    assert(o->stage == SEARCH);
    if (o->aim == LOCATE)
        return orbits_locate_beside(o) ? PEND_OK : orbits_unplaced(o, found, error);
    if (o->aim == LOOK)
        orbits_over(o, PEND_ORBITS_APART);
    else
        orbits_failed(o, PEND_ORBITS_LOST);
    return PEND_OK;
}

enum pend_status pend_orbit_branch_next(struct pend_orbits *o, double work,
                                        enum pend_orbits_found *found, struct pend_error *error) {
    enum orbit_newton_end end = ORBIT_GOING;
    enum pend_status status = PEND_OK;
    int done = 0;
    assert(pend_orbits_valid(o) && o->stage != SETTLE);
    *found = PEND_ORBITS_NOTHING;
    switch (o->stage) {
    case SEARCH:
        PEND_TRY(pend_orbit_newton_next(&o->newton, work, &end, error));
        if (end == ORBIT_FOUND) return orbits_solution(o, found, error);
        return end == ORBIT_LOST ? orbits_lost(o, found, error) : PEND_OK;
    case CHECK:
        status = pend_orbit_check_next(&o->check, &o->newton.form, work, &done, error);
        if (status == PEND_NO_MEMORY) return status;
        if (status != PEND_OK) orbits_failed(o, PEND_ORBITS_WILD);
        return done ? orbits_checked(o, found, error) : PEND_OK;
    case CHANGES:
        orbits_change(o);
        return PEND_OK;
    case LEAVE:
        orbits_leave(o);
        return PEND_OK;
    case FORWARD:
        orbits_forward(o);
        return PEND_OK;
    case SETTLE:
    case OVER:
        break;
    }
    *found = PEND_ORBITS_END;
    return PEND_OK;
}
