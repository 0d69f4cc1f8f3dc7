#include "core/orbits/orbit_newton.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_constants.h"

static size_t newton_numbers(size_t unknowns) { return unknowns * (unknowns + 6); }

double pend_orbit_newton_bytes(const struct pend_orbit_problem *problem) {
    int n = problem->tree->n, unknowns = pend_orbit_unknowns(problem);
    int harmonics = problem->loads.terms ? problem->loads.terms->harmonics : 0;
    int most = 2 * n + (harmonics ? harmonics : 1);
    return sizeof(double) * (double)newton_numbers((size_t)unknowns) +
           pend_orbit_form_bytes(problem) + pend_orbit_map_bytes(n, most) +
           pend_orbit_algebra_bytes(2 * n + 1) +
           pend_derivatives_bytes(problem->tree, problem->loads.terms, most);
}

enum pend_status pend_orbit_newton_init(struct orbit_newton *newton,
                                        const struct pend_orbit_problem *problem,
                                        struct pend_error *error) {
    *newton = (struct orbit_newton){.energy = 0};
    PEND_TRY(pend_orbit_form_init(&newton->form, problem, error));
    int n = newton->form.n;
    size_t unknowns = (size_t)pend_orbit_unknowns(problem);
    newton->unknowns = newton->form.equations + 1;
    double *at = newton->block = calloc(newton_numbers(unknowns), sizeof *at);
    if (!at || pend_orbit_map_init(&newton->map, n, pend_orbit_form_most(&newton->form)) ||
        pend_orbit_algebra_new(&newton->algebra, 2 * n + 1))
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits of %d arms", n);
    newton->J = at, at += unknowns * unknowns;
    newton->u = at, at += unknowns;
    newton->normal = at, at += unknowns;
    newton->F = at, at += unknowns;
    newton->delta = at, at += unknowns;
    newton->good = at, at += unknowns;
    newton->way = at;
    return PEND_OK;
}

void pend_orbit_newton_clear(struct orbit_newton *newton) {
    pend_orbit_form_clear(&newton->form);
    pend_orbit_map_clear(&newton->map);
    pend_orbit_algebra_free(&newton->algebra);
    free(newton->block);
    *newton = (struct orbit_newton){.energy = 0};
}

double pend_orbit_newton_energy(const struct orbit_newton *newton) {
    assert(newton->form.kind != ORBIT_DRIVEN);
    return newton->map.energy - newton->form.rest_potential;
}

double pend_orbit_newton_slope(const struct orbit_newton *newton, const double along[]) {
    assert(newton->form.kind != ORBIT_DRIVEN);
    double sum = 0;
    for (int k = 0; k < newton->form.equations; k++)
        sum += newton->map.energy_by[k] * (k < newton->form.n ? 1 : newton->form.omega) * along[k];
    return sum;
}

/* appends the period after the rates, which are set to 0 */
static void newton_widen(int n, double u[]) {
    assert(n >= 1);
    u[2 * n] = u[n];
    for (int k = 0; k < n; k++) u[n + k] = 0;
}

void pend_orbit_newton_free(struct orbit_newton *newton, int turning, double direction[]) {
    // from orbits between two states of rest; gravity and springs must accelerate the turning arm
    assert(newton->form.kind == ORBIT_QUARTER || newton->form.kind == ORBIT_HALF);
    newton->form.kind = ORBIT_FREE;
    newton->form.turning = turning;
    newton->form.equations = 2 * newton->form.n;
    newton->unknowns = newton->form.equations + 1;
    newton_widen(newton->form.n, newton->u);
    newton_widen(newton->form.n, direction);
}

static double newton_size(const double x[], int count) {
    assert(x && count >= 0);
    double most = 0;
    for (int i = 0; i < count; i++) most = fmax(most, fabs(x[i]));
    return most;
}

/* computes the last row of J and the residual of the closing equation */
static double newton_close(struct orbit_newton *newton) {
    int q = newton->unknowns;
    double *row = newton->J + (size_t)(q - 1) * (size_t)q, sum = 0;
    if (newton->energy) {
        for (int k = 0; k < q - 1; k++) {
            double unit = k < newton->form.n ? 1 : newton->form.omega;
            row[k] = newton->map.energy_by[k] * unit / newton->value;
        }
        row[q - 1] = 0;
        return pend_orbit_newton_energy(newton) / newton->value - 1;
    }
    for (int j = 0; j < q; j++) row[j] = newton->normal[j], sum += row[j] * newton->u[j];
    return sum - newton->value;
}

static void newton_try(struct orbit_newton *newton) {
    for (int j = 0; j < newton->unknowns; j++)
        newton->u[j] = newton->good[j] + newton->part * newton->way[j];
}

/* judges a correction far from the solution: accepted if the equations' error decreases */
static enum orbit_newton_end newton_far(struct orbit_newton *newton, double correction) {
    int q = newton->unknowns;
    double size = newton_size(newton->F, q);
    if (size > newton->size && newton->iteration > 1) {
        newton->part /= 2;
        newton_try(newton);
        return ORBIT_GOING;
    }
    newton->size = size;
    newton->part = fmin(1, newton_longest / correction);
    memcpy(newton->good, newton->u, (size_t)q * sizeof(double));
    memcpy(newton->way, newton->delta, (size_t)q * sizeof(double));
    newton_try(newton);
    newton->last = correction;
    return ORBIT_GOING;
}

/* judges a correction of the size of round-off: the end, unless all derivatives are needed */
static enum orbit_newton_end newton_last(struct orbit_newton *newton, double correction) {
    newton->last = correction;
    if (newton->whole && !newton->complete) return ORBIT_GOING;
    for (int j = 0; j < newton->unknowns; j++) newton->u[j] += newton->delta[j];
    return ORBIT_FOUND;
}

static enum orbit_newton_end newton_correct(struct orbit_newton *newton) {
    int q = newton->unknowns;
    newton->iteration++;
    pend_orbit_form_equations(&newton->form, &newton->map, newton->F, newton->J);
    if (newton->look) {
        memset(newton->J + (size_t)(q - 1) * (size_t)q, 0, (size_t)q * sizeof(double));
        return ORBIT_FOUND;
    }
    newton->F[q - 1] = newton_close(newton);
    for (int j = 0; j < q; j++) newton->delta[j] = -newton->F[j];
    if (!pend_orbit_solve(newton->algebra, q, newton->J, 1, newton->delta)) return ORBIT_LOST;
    pend_orbit_form_hold(&newton->form, newton->delta);
    double correction = newton_size(newton->delta, q);
    int stalled = correction <= newton_stalled && correction > newton->last / 4;
    if (correction <= newton_fine || stalled) return newton_last(newton, correction);
    if (newton->iteration >= (newton->careful ? NEWTON_FAR : NEWTON_NEAR)) return ORBIT_LOST;
    if (newton->careful) return newton_far(newton, correction);
    if (correction > newton_longest || (newton->iteration > 2 && correction > newton->last))
        return ORBIT_LOST;
    for (int j = 0; j < q; j++) newton->u[j] += newton->delta[j];
    newton->last = correction;
    return ORBIT_GOING;
}

enum pend_status pend_orbit_newton_next(struct orbit_newton *newton, double work,
                                        enum orbit_newton_end *end, struct pend_error *error) {
    int done = 0;
    enum pend_status status = PEND_OK;
    assert(newton->unknowns >= 2);
    *end = ORBIT_GOING;
    if (!newton->under_way) {
        // all derivatives, if they cost nothing more, or are likely to be needed
        enum { TOGETHER = 7 };
        int n = newton->form.n;
        newton->complete = !newton->whole || newton->form.equations == 2 * n ||
                           (2 * n + TOGETHER - 1) / TOGETHER == (n + TOGETHER - 1) / TOGETHER ||
                           newton->last * newton->last <= newton_stalled;
        status = pend_orbit_form_set(&newton->form, newton->u, newton->whole && newton->complete,
                                     &newton->motion, error);
        if (status == PEND_OK)
            status = pend_orbit_map_begin(&newton->map, &newton->motion, newton->form.span,
                                          newton->form.count, newton->form.parameter, error);
        newton->under_way = status == PEND_OK;
    } else {
        status = pend_orbit_map_next(&newton->map, work, &done, error);
        newton->under_way = status == PEND_OK && !done;
        if (!newton->under_way) newton->steps += pend_orbit_map_steps(&newton->map), newton->maps++;
    }
    if (status == PEND_NO_MEMORY) return status;
    if (status != PEND_OK) *end = ORBIT_LOST;
    if (done) *end = newton_correct(newton);
    return PEND_OK;
}

int pend_orbit_newton_tangent(struct orbit_newton *newton, double along[]) {
    int q = newton->unknowns;
    double *last = newton->J + (size_t)(q - 1) * (size_t)q;
    memcpy(last, along, (size_t)q * sizeof *last);
    for (int j = 0; j < q; j++) newton->delta[j] = j == q - 1;
    if (!pend_orbit_solve(newton->algebra, q, newton->J, 1, newton->delta)) return 0;
    pend_orbit_form_hold(&newton->form, newton->delta);
    double size = newton_size(newton->delta, q);
    if (!(size > 0)) return 0;
    for (int j = 0; j < q; j++) along[j] = newton->delta[j] / size;
    return 1;
}
