#include "core/orbits/orbit_change.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LOCATE_MOST = 40 };

/* a bifurcation is known to this part of a step, or where the test for it is so small */
static const double change_exact = 1e-7, change_zero = 1e-11;

/* how far beside a part of a step at which no orbit was found one is looked for, five times as far
 * each time; what that adds to the tries, so that the next orbit found is the last, and how often
 */
static const double change_beside = 2e-6;
enum { LOCATE_LOST = 1000, LOCATE_BESIDE = 5 };

/* parts of the unit of unknowns: how far from a bifurcation the first orbit of the branch that
 * begins there is looked for, one after the other; and how much farther it may be */
static const double change_aside[] = {5e-3, 2e-3, 1e-3, 1e-2, 3e-2};
static const double change_near = 8;
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

/* The unknowns at a part of the way between the two orbits, on a cubic curve: where another branch
 * crosses, corrections along it hardly change the equations, and a line's guess is not enough. */
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

/* looks for the orbit at the part of the way at which the search is */
static void change_locate_at(struct pend_orbits *o) {
    change_between_two(o, o->at, o->newton.u);
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, LOCATE);
}

/* looks for the orbit at the next part of the way */
static void change_locate(struct pend_orbits *o) {
    o->at = (o->low + o->high) / 2;
    if (o->border != ORBIT_AROUND && o->low_test * o->high_test < 0) {
        double part = o->low_test / (o->low_test - o->high_test);
        o->at = o->low + fmin(0.98, fmax(0.02, part)) * (o->high - o->low);
    }
    change_locate_at(o);
    o->tries++;
}

/* At a crossing of branches the equations are singular, and rounding errors decide whether an orbit
 * is found: the bifurcation is that beside it, as near as one is. Returns 0 where none is. */
static int change_locate_beside(struct pend_orbits *o) {
    int lost = o->tries / LOCATE_LOST;
    double away = change_beside * pow(5, lost) * (lost % 2 ? -1 : 1);
    if (lost == LOCATE_BESIDE) return 0;
    o->tries = LOCATE_LOST * (lost + 1);
    o->at += o->at + away > o->low && o->at + away < o->high ? away : -away;
    change_locate_at(o);
    return 1;
}

void pend_orbit_change_next(struct pend_orbits *o) {
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
    change_locate(o);
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
        // orbits that do not rest may begin there
        pend_orbit_newton_free(&o->newton, pend_orbit_switch_turning(&o->newton), o->turned);
        memcpy(o->last.u, o->newton.u, (size_t)o->newton.unknowns * sizeof(double));
        pend_orbit_search_begin(o, LOOK);
        return PEND_OK;
    }
    if (!found) pend_orbit_search_over(o, PEND_ORBITS_APART);
    if (!found) return PEND_OK;
    memcpy(o->last.along, o->leaving, q * sizeof(double));
    o->left++;
    o->points = o->met = o->attempts = 0;
    o->step = o->begin;
    pend_orbit_change_aside(o);
    return PEND_OK;
}

/* what follows on a bifurcation that was told: the branch is left there, or goes on */
static void change_met(struct pend_orbits *o) {
    int pending = o->left < o->problem.switches;
    o->met++;
    o->stage = pending && abs(o->problem.leave[o->left]) == o->met ? LEAVE : CHANGES;
}

static enum pend_orbits_kind change_kind(const struct pend_orbits *o) {
    if (o->border == ORBIT_AROUND) return PEND_ORBITS_TORUS;
    if (o->border == ORBIT_PLUS)
        return o->last.slope * o->next.slope < 0 ? PEND_ORBITS_FOLD : PEND_ORBITS_BRANCH;
    return o->newton.form.mirrored ? PEND_ORBITS_SYMMETRY : PEND_ORBITS_DOUBLING;
}

enum pend_status pend_orbit_change_between(struct pend_orbits *o, enum pend_orbits_found *found,
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
    int exact = o->high - o->low <= change_exact || o->tries >= LOCATE_MOST ||
                (border != ORBIT_AROUND && fabs(test) <= change_zero);
    if (!exact) {
        change_locate(o);
        return PEND_OK;
    }
    PEND_TRY(pend_orbit_search_tell(o, o->newton.u, error));
    o->now.kind = change_kind(o);
    *found = PEND_ORBITS_BIFURCATION;
    change_met(o);
    return PEND_OK;
}

/* no orbit was found at a part of the way: the bifurcation is told where the next orbit is */
static enum pend_status change_unplaced(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    struct pend_problem motion;
    PEND_TRY(pend_orbit_form_set(&o->newton.form, o->next.u, 1, &motion, error));
    o->now.period = pend_orbit_form_period(&o->newton.form);
    o->now.kind = change_kind(o);
    *found = PEND_ORBITS_BIFURCATION;
    change_met(o);
    if (o->stage == LEAVE) pend_orbit_search_over(o, PEND_ORBITS_APART);
    return PEND_OK;
}

enum pend_status pend_orbit_change_lost(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    return change_locate_beside(o) ? PEND_OK : change_unplaced(o, found, error);
}
