#include "core/orbits/orbits.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/integrate/run/run.h"
#include "core/orbits/orbit_branch.h"
#include "core/orbits/orbit_constants.h"

/* ---- creation and release */

static size_t orbits_numbers(size_t n, size_t unknowns) { return 9 * unknowns + 5 * n; }

double pend_orbits_bytes(const struct pend_orbit_problem *problem) {
    int n = problem->tree->n, unknowns = pend_orbit_unknowns(problem);
    return (double)sizeof(struct pend_orbits) + pend_orbit_newton_bytes(problem) +
           pend_orbit_floquet_bytes(n) +
           pend_orbit_check_bytes(n, problem->driven || problem->switches) +
           sizeof(double) * (double)orbits_numbers((size_t)n, (size_t)unknowns);
}

void pend_orbits_free(struct pend_orbits **orbits) {
    struct pend_orbits *o = *orbits;
    if (!o) return;
    pend_run_free(&o->settling);
    pend_orbit_newton_clear(&o->newton);
    pend_orbit_floquet_clear(&o->floquet);
    pend_orbit_check_clear(&o->check);
    free(o->block);
    free(o);
    *orbits = NULL;
}

static enum pend_status orbits_allocate(struct pend_orbits *o, struct pend_error *error) {
    size_t n = (size_t)o->problem.tree->n, q = (size_t)pend_orbit_unknowns(&o->problem);
    double *at = o->block = calloc(orbits_numbers(n, q), sizeof *at);
    if (!at || pend_orbit_floquet_init(&o->floquet, (int)n) ||
        pend_orbit_check_init(&o->check, (int)n, o->problem.driven || o->problem.switches))
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits of %zu arms", n);
    o->last.u = at, at += q;
    o->last.along = at, at += q;
    o->next.u = at, at += q;
    o->next.along = at, at += q;
    o->turned = at, at += q;
    o->leaving = at, at += 2 * q;
    o->home = at, at += 2 * q;
    o->amplitude = at, at += n;
    o->row = at;
    return PEND_OK;
}

/* sets *swing, rad, to a small swing in the mode, below the requested amplitude */
static enum pend_status orbits_small(struct pend_orbits *o, double *swing,
                                     struct pend_error *error) {
    enum { HALVES = 40 };
    const struct orbit_form *form = &o->newton.form;
    *swing = orbits_begin;
    if (o->problem.target == PEND_ORBIT_AMPLITUDE) {
        *swing = fmin(*swing, o->problem.until / 2);
        return PEND_OK;
    }
    double *scratch = calloc(4 * (size_t)form->n, sizeof *scratch);
    if (!scratch) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits");
    for (int i = 0; i < HALVES; i++, *swing /= 2) {
        for (int k = 0; k < form->n; k++) form->phi[k] = form->rest[k] + *swing * form->shape[k];
        struct pend_energy energy = pend_kinematics_energy_at(o->problem.tree, &o->problem.loads, 0,
                                                              form->phi, form->rate, scratch);
        if (energy.potential - form->rest_potential < o->problem.until / 4) break;
    }
    free(scratch);
    return PEND_OK;
}

static enum pend_status orbits_start(struct pend_orbits *o, const double phi[], const double rate[],
                                     struct pend_error *error) {
    struct orbit_newton *newton = &o->newton;
    int n = newton->form.n;
    if (!o->problem.driven) {
        PEND_TRY(orbits_small(o, &o->swing, error));
        pend_orbit_search_small(o);
        return PEND_OK;
    }
    for (int k = 0; k < n; k++)
        newton->u[k] = phi[k], newton->u[n + k] = rate[k] / newton->form.omega;
    newton->u[2 * n] = 0, o->last.along[2 * n] = 1;
    pend_orbit_search_plane(o, o->last.along);
    pend_orbit_search_begin(o, FIRST);
    return PEND_OK;
}

/* starts to integrate from the given start over whole periods of the drive */
static enum pend_status orbits_settle(struct pend_orbits *o, struct pend_error *error) {
    const struct pend_orbit_problem *p = &o->problem;
    double span = p->settle * 2 * M_PI / o->newton.form.omega;
    struct pend_problem motion = {.tree = p->tree,
                                  .loads = p->loads,
                                  .phi = p->phi,
                                  .rate = p->rate,
                                  .times = {.count = 2, .span = span, .divisor = 1},
                                  .no_drift = 1};
    o->stage = SETTLE;
    return pend_run_new(&o->settling, &pend_method_taylor, &motion, error);
}

enum pend_status pend_orbits_new(struct pend_orbits **orbits,
                                 const struct pend_orbit_problem *problem,
                                 struct pend_error *error) {
    assert(problem->points >= 1 && problem->step > 0);
    assert(problem->switches >= 0 && problem->switches <= PEND_ORBIT_SWITCHES);
    assert(!problem->switches || problem->branch);
    *orbits = NULL;
    if (pend_terms_cart(problem->loads.terms))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "orbits of a pendulum on a cart are not supported");
    struct pend_orbits *o = *orbits = calloc(1, sizeof *o);
    if (!o) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits");
    o->problem = *problem;
    o->end = o->why = PEND_ORBITS_NONE, o->turned_at = PEND_ORBITS_KINDS;
    o->step = o->begin = fmin(orbits_begin, problem->step);
    enum pend_status status = pend_orbit_newton_init(&o->newton, &o->problem, error);
    if (status == PEND_OK) status = orbits_allocate(o, error);
    if (status == PEND_OK)
        status = problem->driven && problem->settle > 0
                     ? orbits_settle(o, error)
                     : orbits_start(o, problem->phi, problem->rate, error);
    if (status != PEND_OK) {
        pend_orbits_free(orbits);
        return status;
    }
    assert(pend_orbits_valid(o));
    return PEND_OK;
}

/* ---- running */

static long orbits_run_steps(const struct pend_run *run) {
    return run ? pend_run_stats(run).steps : 0;
}

/* makes the state after some periods of the drive the start */
static enum pend_status orbits_settled(struct pend_orbits *o, struct pend_error *error) {
    size_t n = (size_t)o->newton.form.n;
    const int *place = o->problem.tree->place;
    double t[2], *phi = o->row, *rate = phi + n, *start = rate + n;
    struct pend_samples samples = {.cap = 1, .t = t, .phi = phi, .rate = rate};
    int done = 0;
    enum pend_status status = pend_run_next(o->settling, &samples, orbits_piece, &done, error);
    if (status == PEND_NO_MEMORY) return status;
    if (status != PEND_OK) {
        o->stage = OVER;
        return PEND_OK;
    }
    if (!done) return PEND_OK;
    o->settled = orbits_run_steps(o->settling);
    pend_run_free(&o->settling);
    for (size_t k = 0; k < n; k++) {
        start[(size_t)place[k]] = o->newton.form.turns ? remainder(phi[k], 2 * M_PI) : phi[k];
        start[n + (size_t)place[k]] = rate[k];
    }
    return orbits_start(o, start, start + n, error);
}

enum pend_status pend_orbits_next(struct pend_orbits *orbits, enum pend_orbits_found *found,
                                  struct pend_error *error) {
    assert(pend_orbits_valid(orbits));
    *found = PEND_ORBITS_NOTHING;
    if (orbits->stage == SETTLE) return orbits_settled(orbits, error);
    PEND_TRY(pend_orbit_branch_next(orbits, orbits_piece, found, error));
    // on branches that the search will leave, nothing but the end of the last branch is reported
    int before = orbits->left < orbits->problem.switches,
        last = orbits->stage == LEAVE && orbits->left == orbits->problem.switches - 1;
    if (before && !last && *found != PEND_ORBITS_END) *found = PEND_ORBITS_NOTHING;
    return PEND_OK;
}

struct pend_orbit pend_orbits_orbit(const struct pend_orbits *orbits) {
    return orbits->now;
}

enum pend_orbits_end pend_orbits_end(const struct pend_orbits *orbits) {
    assert(orbits->stage == OVER);
    return orbits->end;
}

int pend_orbits_part(const struct pend_orbits *orbits) { return orbits->part; }

enum pend_orbits_kind pend_orbits_turned(const struct pend_orbits *orbits) {
    return orbits->turned_at;
}

int pend_orbits_twins(const struct pend_orbits *orbits, int twin[2], int *against) {
    const struct orbit_form *form = &orbits->newton.form;
    for (int i = 0; i < 2 && form->twins; i++) twin[i] = form->problem->tree->order[form->twin[i]];
    *against = form->against;
    return form->twins;
}

int pend_orbits_left(const struct pend_orbits *orbits) { return orbits->left; }

long pend_orbits_steps(const struct pend_orbits *orbits, long *maps) {
    const struct orbit_newton *newton = &orbits->newton;
    long now = newton->under_way ? pend_orbit_map_steps(&newton->map) : 0;
    *maps = newton->maps;
    return newton->steps + now + orbits->check.steps + orbits_run_steps(orbits->check.run) +
           orbits->settled + orbits_run_steps(orbits->settling);
}

double pend_orbits_progress(const struct pend_orbits *orbits) {
    double points = (double)orbits->points / orbits->problem.points;
    double part = fmin(1, fmax(points, fmax(0, orbits->way)));
    if (orbits->stage == OVER) return 1;
    return (orbits->left + part) / (orbits->problem.switches + 1);
}

/* ---- checkpoints */

int pend_orbits_rests(const struct pend_orbits *orbits, long *steps) {
    *steps = (long)orbits->left * orbits->problem.points + orbits->points;
    return orbits->stage == FORWARD || orbits->stage == OVER;
}

static void orbits_carry_point(const struct pend_orbits *o, struct orbits_point *point,
                               struct pend_checkpoint *checkpoint) {
    size_t q = (size_t)pend_orbit_unknowns(&o->problem);
    pend_checkpoint_row(checkpoint, point->u, q);
    pend_checkpoint_row(checkpoint, point->along, q);
    pend_checkpoint_row(checkpoint, point->mark.test, ORBIT_TURN + 1);
    pend_checkpoint_int(checkpoint, &point->mark.outside, 2 * o->problem.tree->n);
    for (int i = 0; i < ORBIT_REAL; i++) {
        pend_checkpoint_int(checkpoint, &point->mark.beyond[i], 2 * o->problem.tree->n);
        pend_checkpoint_int(checkpoint, &point->mark.surely[i], 2 * o->problem.tree->n);
    }
}

/* Restores the equations. Those of free orbits have more unknowns than a search without branch
 * switches has space for. */
static enum pend_status orbits_carry_form(struct pend_orbits *o,
                                          struct pend_checkpoint *checkpoint) {
    struct orbit_form *form = &o->newton.form;
    int kind = (int)form->kind, driven = o->problem.driven;
    pend_checkpoint_int(checkpoint, &kind, ORBIT_DRIVEN);
    pend_checkpoint_int(checkpoint, &form->times, PEND_ORBIT_PERIODS);
    pend_checkpoint_int(checkpoint, &form->mirrored, 1);
    pend_checkpoint_int(checkpoint, &form->turning, form->n - 1);
    pend_checkpoint_int(checkpoint, &form->against, form->twins > 0);
    int known = (kind == ORBIT_DRIVEN) == driven && form->times > 0 &&
                (kind != ORBIT_FREE || o->problem.switches);
    if (!known) return PEND_INVALID;
    form->kind = (enum orbit_kind)kind;
    form->equations = kind >= (int)ORBIT_FREE ? 2 * form->n : form->n;
    o->newton.unknowns = form->equations + 1;
    return PEND_OK;
}

static void orbits_carry_place(struct pend_orbits *o, struct pend_checkpoint *checkpoint) {
    int over = o->stage == OVER, aim = (int)o->aim, end = (int)o->end, why = (int)o->why;
    int kind = (int)o->now.kind, turned = (int)o->turned_at;
    pend_checkpoint_int(checkpoint, &over, 1);
    pend_checkpoint_int(checkpoint, &aim, LOOK);
    pend_checkpoint_int(checkpoint, &end, PEND_ORBITS_ENDS - 1);
    pend_checkpoint_int(checkpoint, &why, PEND_ORBITS_ENDS - 1);
    pend_checkpoint_int(checkpoint, &kind, PEND_ORBITS_KINDS - 1);
    pend_checkpoint_int(checkpoint, &turned, PEND_ORBITS_KINDS);
    pend_checkpoint_int(checkpoint, &o->points, o->problem.points);
    pend_checkpoint_int(checkpoint, &o->part, INT_MAX);
    pend_checkpoint_int(checkpoint, &o->met, INT_MAX / 2);
    pend_checkpoint_int(checkpoint, &o->left, o->problem.switches);
    pend_checkpoint_int(checkpoint, &o->newton.iteration, INT_MAX / 2);
    o->stage = over ? OVER : FORWARD;
    o->aim = (enum orbits_aim)aim;
    o->end = (enum pend_orbits_end)end, o->why = (enum pend_orbits_end)why;
    o->now.kind = (enum pend_orbits_kind)kind, o->turned_at = (enum pend_orbits_kind)turned;
}

enum pend_status pend_orbits_carry(struct pend_orbits *orbits, struct pend_checkpoint *checkpoint) {
    struct pend_orbits *o = orbits;
    size_t n = (size_t)o->problem.tree->n, q = (size_t)pend_orbit_unknowns(&o->problem);
    long maps, steps = pend_orbits_steps(o, &maps);
    long done[] = {o->newton.steps, maps, steps - o->newton.steps};
    assert(pend_checkpoint_puts(checkpoint) || o->stage == FORWARD || o->stage == OVER);
    PEND_TRY(orbits_carry_form(o, checkpoint));
    orbits_carry_place(o, checkpoint);
    orbits_carry_point(o, &o->last, checkpoint);
    orbits_carry_point(o, &o->next, checkpoint);
    pend_checkpoint_row(checkpoint, o->turned, q);
    pend_checkpoint_row(checkpoint, o->home, 2 * q);
    pend_checkpoint_row(checkpoint, o->check.amplitude, n);
    pend_checkpoint_row(checkpoint, &o->newton.map.energy, 1);
    pend_checkpoint_row(checkpoint, &o->step, 1);
    pend_checkpoint_row(checkpoint, &o->before, 1);
    pend_checkpoint_row(checkpoint, &o->way, 1);
    pend_checkpoint_counts(checkpoint, done, 3);
    if (!pend_checkpoint_puts(checkpoint)) return PEND_OK;
    if (!(o->step > 0)) return PEND_INVALID;
    pend_run_free(&o->settling);
    o->newton.steps = done[0], o->newton.maps = done[1];
    o->check.steps = done[2], o->settled = 0;
    return PEND_OK;
}
