#include "core/orbits/orbit_search.h"

#include <assert.h>
#include <math.h>
#include <string.h>

int pend_orbits_valid(const struct pend_orbits *orbits) {
    return orbits->newton.unknowns == orbits->newton.form.equations + 1 && orbits->step > 0 &&
           orbits->points >= 0 && orbits->problem.points >= 1 &&
           orbits->left <= orbits->problem.switches;
}

void pend_orbit_search_plane(struct pend_orbits *o, const double normal[]) {
    struct orbit_newton *newton = &o->newton;
    newton->value = 0;
    for (int j = 0; j < newton->unknowns; j++) {
        newton->normal[j] = normal[j];
        newton->value += normal[j] * newton->u[j];
    }
}

void pend_orbit_search_begin(struct pend_orbits *o, enum orbits_aim aim) {
    o->aim = aim, o->stage = SEARCH;
    o->newton.look = aim == LOOK || aim == HALF;
    o->newton.form.halved = aim == HALF;
    o->newton.whole = (o->problem.branch || o->problem.driven || aim == LAST) && !o->newton.look;
    o->newton.careful = o->problem.driven && aim == FIRST && !o->left;
    o->newton.energy = aim == LAST && !o->problem.driven && o->problem.target == PEND_ORBIT_ENERGY;
    o->newton.iteration = o->newton.under_way = 0;
    o->newton.last = o->newton.size = INFINITY;
    o->newton.part = 1;
}

double pend_orbit_search_dot(const double a[], const double b[], int count) {
    assert(a && b && count >= 0);
    double sum = 0;
    for (int j = 0; j < count; j++) sum += a[j] * b[j];
    return sum;
}

void pend_orbit_search_over(struct pend_orbits *o, enum pend_orbits_end end) {
    int ended = end == PEND_ORBITS_REACHED || end == PEND_ORBITS_POINTS ||
                end == PEND_ORBITS_BACK || end == PEND_ORBITS_CLOSED;
    o->end = ended && o->left < o->problem.switches ? PEND_ORBITS_MISSING : end;
    o->stage = OVER;
}

enum pend_status pend_orbit_search_tell(struct pend_orbits *o, const double u[],
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

void pend_orbit_search_mark(const struct pend_orbits *o, const double along[],
                            struct orbits_mark *mark) {
    double slope = o->problem.driven ? along[o->newton.unknowns - 1]
                                     : pend_orbit_newton_slope(&o->newton, along);
    memcpy(mark->beyond, o->floquet.beyond, sizeof mark->beyond);
    memcpy(mark->surely, o->floquet.surely, sizeof mark->surely);
    memcpy(mark->test, o->floquet.test, sizeof o->floquet.test);
    mark->outside = o->floquet.outside, mark->test[ORBIT_TURN] = slope;
}

void pend_orbit_search_small(struct pend_orbits *o) {
    const struct orbit_form *form = &o->newton.form;
    for (int k = 0; k < form->n; k++) {
        o->newton.u[k] = o->swing * form->shape[k];
        o->last.along[k] = form->shape[k];
    }
    o->newton.u[form->n] = 1, o->last.along[form->n] = 0;
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, FIRST);
}
