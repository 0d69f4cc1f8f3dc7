#include "core/orbits/orbit_branch.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/orbits/orbit_constants.h"

/* ---- along the branch */

static void orbits_predict(struct pend_orbits *o) {
    struct orbit_newton *newton = &o->newton;
    double bend = o->before > 0 ? o->step * o->step / (2 * o->before) : 0;
    for (int j = 0; j < newton->unknowns; j++)
        newton->u[j] =
            o->last.u[j] + o->step * o->last.along[j] + bend * (o->last.along[j] - o->turned[j]);
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, STEP);
}

/* repeats a failed step once with a shorter length */
static void orbits_failed(struct pend_orbits *o, enum pend_orbits_end why) {
    o->why = why;
    if (o->aim != FIRST) o->step /= 3;
    if (o->aim == FIRST && o->left)
        pend_orbit_change_aside(o);
    else if (o->aim == FIRST && pend_orbit_form_against(&o->newton.form))
        pend_orbit_search_small(o);
    else if (o->aim == FIRST)
        pend_orbit_search_over(o, why == PEND_ORBITS_LOST ? PEND_ORBITS_NONE : why);
    else if (o->step < branch_shortest * o->problem.step)
        pend_orbit_search_over(o, why);
    else
        orbits_predict(o);
}

/* the fraction of the branch covered so far, 1 at its end; *arm: the arm with the largest swing */
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

/* searches for the orbit exactly at the end of the branch, after a step beyond it */
static void orbits_land(struct pend_orbits *o, double way, int arm) {
    struct orbit_newton *newton = &o->newton;
    int q = newton->unknowns;
    double part = way > o->way ? (1 - o->way) / (way - o->way) : 1;
    for (int j = 0; j < q; j++) newton->u[j] = o->last.u[j] + part * (newton->u[j] - o->last.u[j]);
    memset(newton->normal, 0, (size_t)q * sizeof(double));
    newton->normal[o->problem.driven ? q - 1 : arm] =
        !o->problem.driven && o->next.u[arm] < 0 ? -1 : 1;
    pend_orbit_search_begin(o, LAST);
    newton->value = o->problem.driven ? 1 : o->problem.until;
}

/* Accepts the orbit found as the next one, with its direction. Returns false if the direction is
 * unknown or the branch turned too much in the step. */
static int orbits_take(struct pend_orbits *o) {
    int q = o->newton.unknowns, alone = o->problem.driven && !o->problem.vary;
    double *along = o->next.along;
    const double *before = o->last.along;
    memcpy(o->next.u, o->newton.u, (size_t)q * sizeof(double));
    memcpy(along, before, (size_t)q * sizeof(double));
    if (!alone && !pend_orbit_newton_tangent(&o->newton, along)) return 0;
    double turn =
        pend_orbit_search_dot(along, before, q) /
        sqrt(pend_orbit_search_dot(along, along, q) * pend_orbit_search_dot(before, before, q));
    return o->aim == FIRST || turn >= branch_bend;
}

/* if the accepted orbit is beyond an end of the branch, ends the branch or searches for the orbit
 * at that end, and returns true */
static int orbits_beyond(struct pend_orbits *o) {
    int arm;
    double way = orbits_way(o, o->next.u, &arm);
    // the amplitude of a free orbit is not an unknown
    int seen = o->newton.form.kind == ORBIT_FREE && o->problem.target == PEND_ORBIT_AMPLITUDE;
    if (o->aim == STEP && way >= 1 && seen) o->aim = LAST;
    if (o->aim == STEP && way >= 1) {
        orbits_land(o, way, arm);
        return 1;
    }
    if (!o->problem.driven || way >= 0) return 0;
    pend_orbit_search_over(o, PEND_ORBITS_BACK);
    return 1;
}

static enum pend_status orbits_accept(struct pend_orbits *o, enum pend_orbits_found *found,
                                      struct pend_error *error) {
    struct orbit_newton *newton = &o->newton;
    struct orbits_point *next = &o->next;
    if (!orbits_take(o)) {
        orbits_failed(o, PEND_ORBITS_LOST);
        return PEND_OK;
    }
    if (orbits_beyond(o)) return PEND_OK;
    pend_orbit_search_mark(o, next->along, &next->mark);
    PEND_TRY(pend_orbit_search_tell(o, next->u, error));
    if (newton->whole) *found = PEND_ORBITS_ORBIT;
    o->waiting = -1, o->came = o->aim;
    o->stage = o->aim != FIRST && o->problem.branch ? CHANGES : FORWARD;
    return PEND_OK;
}

/* True if the last step of a branch that started at a bifurcation has passed its first orbit again,
 * in the initial direction. Stores the first orbit. */
static int orbits_closes(struct pend_orbits *o) {
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
    return missed <= branch_near * chord;
}

/* starts the next step from the orbit found, or ends the search */
static void orbits_forward(struct pend_orbits *o) {
    int q = o->newton.unknowns, first = o->aim == FIRST, last = o->aim == LAST, arm;
    struct orbits_point keep = o->last;
    double way = 0;
    if (orbits_closes(o)) {
        pend_orbit_search_over(o, PEND_ORBITS_CLOSED);
        return;
    }
    for (int j = 0; j < q && !first; j++) way = fmax(way, fabs(o->next.u[j] - o->last.u[j]));
    memcpy(o->turned, o->last.along, (size_t)q * sizeof(double));
    o->last = o->next, o->next = keep;
    o->before = first ? 0 : way;
    o->way = orbits_way(o, o->last.u, &arm);
    if (last || (o->problem.driven && !o->problem.vary)) {
        pend_orbit_search_over(o, PEND_ORBITS_REACHED);
        return;
    }
    if (++o->points >= o->problem.points) {
        pend_orbit_search_over(o, PEND_ORBITS_POINTS);
        return;
    }
    int corrections = o->newton.iteration;
    if (!first && corrections <= BRANCH_EASY) o->step = fmin(1.6 * o->step, o->problem.step);
    if (corrections >= BRANCH_HARD) o->step *= 0.7;
    orbits_predict(o);
}

/* ---- pieces */

/* checks that the solution found by Newton's method is an orbit */
static enum pend_status orbits_solution(struct pend_orbits *o, enum pend_orbits_found *found,
                                        struct pend_error *error) {
    struct orbit_newton *newton = &o->newton;
    struct pend_problem motion;
    if (newton->whole) PEND_TRY(pend_orbit_floquet_at(&o->floquet, newton));
    if (o->aim == LOCATE) return pend_orbit_change_between(o, found, error);
    if (o->aim == LOOK) return pend_orbit_change_looked(o);
    if (o->aim == HALF) return pend_orbit_change_halved(o, found);
    if (!newton->whole) return orbits_accept(o, found, error);
    o->stage = CHECK;
    PEND_TRY(pend_orbit_form_set(&newton->form, newton->u, 1, &motion, error));
    return pend_orbit_check_begin(&o->check, &newton->form, &motion, error);
}

static enum pend_status orbits_checked(struct pend_orbits *o, enum pend_orbits_found *found,
                                       struct pend_error *error) {
    double closure = o->check.closure;
    o->part = o->check.divisor;
    if (o->aim == FIRST && o->left && pend_orbit_change_far(o)) {
        orbits_failed(o, PEND_ORBITS_LOST);
        return PEND_OK;
    }
    if (closure <= orbits_exact * o->floquet.growth && closure <= branch_wild && o->part == 1)
        return orbits_accept(o, found, error);
    orbits_failed(o, closure > orbits_exact * o->floquet.growth ? PEND_ORBITS_LOST
                     : closure > branch_wild                    ? PEND_ORBITS_WILD
                                                                : PEND_ORBITS_MEETS);
    return PEND_OK;
}

static enum pend_status orbits_lost(struct pend_orbits *o, enum pend_orbits_found *found,
                                    struct pend_error *error) {
    assert(o->stage == SEARCH);
    if (o->aim == LOCATE || o->aim == HALF) return pend_orbit_change_lost(o, found, error);
    if (o->aim == LOOK)
        pend_orbit_search_over(o, PEND_ORBITS_APART);
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
        pend_orbit_change_next(o);
        return PEND_OK;
    case LEAVE:
        pend_orbit_change_leave(o);
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
