#include "core/orbits/orbit_form.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/modes/damped.h"
#include "core/modes/modes.h"
#include "core/orbits/orbit_constants.h"
#include "core/tree/turns.h"

static const double hanging = -M_PI_2, hanging_low = -PEND_QUARTER_LOW;

/* ---- the pendulum */

int pend_orbit_drive(const struct pend_loads *loads, double *omega) {
    const struct pend_terms *terms = loads->terms;
    double least = INFINITY;
    assert(omega);
    for (int i = 0; terms && i < terms->harmonics; i++) {
        double w = fabs(loads->value[terms->harmonic[i].at + 1]);
        if (w > 0) least = fmin(least, w);
    }
    if (!isfinite(least)) return 0;
    for (int part = 1; part <= FORM_MULTIPLES; part++) {
        double base = least / part;
        int fits = 1;
        for (int i = 0; i < terms->harmonics; i++) {
            double times = fabs(loads->value[terms->harmonic[i].at + 1]) / base;
            fits &=
                fabs(times - rint(times)) <= form_alike * times && rint(times) <= FORM_MULTIPLES;
        }
        if (!fits) continue;
        *omega = base;
        return 1;
    }
    return 0;
}

/* non-zero if the mirror image of every motion about hanging is a motion too */
static int form_mirrors(const struct orbit_form *form) {
    static const enum pend_term_row odd[] = {PEND_TERM_CENTER_Y, PEND_TERM_AT_Y, PEND_TERM_REST,
                                             PEND_TERM_TORQUE};
    const struct pend_loads *loads = &form->problem->loads;
    for (int k = 0; k < form->n; k++) {
        if (fabs(form->rest[k] - hanging) > 1e-12) return 0;
        for (size_t i = 0; loads->terms && i < sizeof odd / sizeof *odd; i++)
            if (pend_terms_get(loads->terms, loads->value, odd[i], k) != 0) return 0;
    }
    return 1;
}

/* selects the requested mode of a real pendulum, among those that swing */
static enum pend_status form_damped(struct orbit_form *form, struct pend_error *error) {
    const struct pend_orbit_problem *p = form->problem;
    struct pend_damped *modes;
    int left = p->mode;
    for (int k = 0; k < form->n; k++) form->rest[k] = hanging;
    PEND_TRY(pend_damped_new(&modes, p->tree, &p->loads, form->rest, error));
    form->omega = 0;
    for (int j = 0; j < modes->count && form->omega == 0; j++) {
        if (!(modes->omega[j] > 0) || modes->decay[j] != 0 || left-- > 0) continue;
        form->omega = modes->omega[j];
        for (int k = 0; k < form->n; k++) form->shape[k] = modes->re[j * form->n + k];
    }
    for (int k = 0; k < form->n; k++) form->rest[k] = modes->phi[k];
    pend_damped_free(&modes);
    if (form->omega > 0) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "fewer than %d modes of this pendulum oscillate about its equilibrium",
                     p->mode + 1);
}

/* ---- equal branches */

/* number of arms of a branch, which are contiguous */
static int form_branch(const struct pend_tree *tree, int first) {
    int end = first + 1;
    while (end < tree->n && tree->parent[end] >= first) end++;
    return end - first;
}

static int form_equal(const struct orbit_form *form, int a, int b) {
    const struct pend_tree *tree = form->problem->tree;
    const struct pend_loads *loads = &form->problem->loads;
    int size = form_branch(tree, a), equal = size == form_branch(tree, b);
    equal &= tree->parent[a] == tree->parent[b];
    for (int i = 0; i < size && equal; i++) {
        equal &= tree->len[a + i] == tree->len[b + i] && tree->mass[a + i] == tree->mass[b + i];
        equal &= !i || tree->parent[a + i] - a == tree->parent[b + i] - b;
        for (int row = 0; loads->terms && row < PEND_TERM_ROWS; row++)
            equal &= pend_terms_get(loads->terms, loads->value, (enum pend_term_row)row, a + i) ==
                     pend_terms_get(loads->terms, loads->value, (enum pend_term_row)row, b + i);
    }
    return equal;
}

void pend_orbit_form_hold(const struct orbit_form *form, double u[]) {
    int a = form->twin[0], b = form->twin[1], size = form_branch(form->problem->tree, a);
    if (!form->against) return;
    for (int k = 0; k < form->n; k++) {
        int in = k >= a && k < a + size;
        if (in) u[k] = (u[k] - u[b + k - a]) / 2, u[b + k - a] = -u[k];
        if (!in && (k < b || k >= b + size)) u[k] = 0;
    }
}

int pend_orbit_form_against(struct orbit_form *form) {
    double most = 0;
    if (!form->twins || form->against) return 0;
    form->against = 1;
    memcpy(form->phi, form->shape, (size_t)form->n * sizeof(double));
    pend_orbit_form_hold(form, form->shape);
    for (int k = 0; k < form->n; k++) most = fmax(most, fabs(form->shape[k]));
    for (int k = 0; k < form->n; k++) form->shape[k] /= most;
    return 1;
}

/* of three or more equal branches, finds the two whose opposite motion in the mode is largest */
static void form_twins(struct orbit_form *form) {
    static const double still = 1e-9;
    double most = still, other = 0;
    for (int a = 1; a < form->n; a++) {
        int likes = 0, b = 0;
        for (int k = 1; k < form->n; k++) {
            if (!form_equal(form, a, k)) continue;
            likes++;
            if (k > a && !b) b = k;
        }
        double apart = fabs(form->shape[a] - form->shape[b]);
        if (likes < 3 || !b || apart <= most) continue;
        most = apart, form->twins = likes, form->twin[0] = a, form->twin[1] = b;
    }
    // the mode may have that shape already
    if (!pend_orbit_form_against(form)) return;
    for (int k = 0; k < form->n; k++) other = fmax(other, fabs(form->phi[k] - form->shape[k]));
    form->against = other <= still;
    if (!form->against) memcpy(form->shape, form->phi, (size_t)form->n * sizeof(double));
}

static enum pend_status form_mode(struct orbit_form *form, struct pend_error *error) {
    const struct pend_orbit_problem *p = form->problem;
    assert(p->mode >= 0 && p->mode < form->n);
    if (p->loads.terms) {
        PEND_TRY(form_damped(form, error));
    } else {
        struct pend_modes *modes;
        const struct pend_modes_request request = {.loads = p->loads,
                                                   .vectors = 1,
                                                   .normalize = PEND_NORMALIZE_MAX,
                                                   .select = PEND_SELECT_NUMBERS,
                                                   .first = p->mode,
                                                   .count = 1};
        PEND_TRY(pend_modes_select(&modes, p->tree, &request, error));
        form->omega = modes->omega[0];
        memcpy(form->shape, modes->vector, (size_t)form->n * sizeof(double));
        pend_modes_free(&modes);
        for (int k = 0; k < form->n; k++) form->rest[k] = hanging;
    }
    form->mirrored = form_mirrors(form);
    form->kind = form->mirrored ? ORBIT_QUARTER : ORBIT_HALF;
    if (form->mirrored) form_twins(form);
    for (int k = 0; form->kind == ORBIT_QUARTER && k < form->n; k++)
        form->rest[k] = hanging, form->rest_low[k] = hanging_low;
    return PEND_OK;
}

static double form_from(const struct orbit_form *form) {
    const struct pend_orbit_problem *p = form->problem;
    if (p->vary == PEND_ORBIT_OMEGA) return form->omega;
    if (p->vary != PEND_ORBIT_PARAMETER) return 0;
    switch (p->by.kind) {
    case PEND_PARAMETER_LENGTH:
        return p->tree->len[p->by.at];
    case PEND_PARAMETER_MASS:
        return p->tree->mass[p->by.at];
    case PEND_PARAMETER_GRAVITY:
        return p->loads.gravity;
    case PEND_PARAMETER_TERM:
        return p->loads.value[p->by.at];
    case PEND_PARAMETER_PHI:
    case PEND_PARAMETER_RATE:
        break;
    }
    return 0;
}

/* ---- memory */

static size_t form_numbers(size_t n, size_t terms) { return 6 * n + 2 * terms + 3; }

static size_t form_terms(const struct pend_orbit_problem *problem) {
    return problem->loads.terms ? (size_t)problem->loads.terms->count : 0;
}

/* for a real pendulum, memory to compute all modes, with dense matrices if it has few arms */
double pend_orbit_form_bytes(const struct pend_orbit_problem *problem) {
    double n = problem->tree->n, terms = (double)form_terms(problem);
    return 8 * (double)form_numbers((size_t)n, (size_t)terms) +
           (2 * n + terms + 1) * (double)sizeof(struct pend_parameter) + 4096 + 1024 * n +
           (problem->loads.terms ? 64 * n * n : 0) + 64 * n;
}

int pend_orbit_form_most(const struct orbit_form *form) {
    int harmonics = form->problem->loads.terms ? form->problem->loads.terms->harmonics : 0;
    return 2 * form->n + (harmonics ? harmonics : 1);
}

enum pend_status pend_orbit_form_init(struct orbit_form *form,
                                      const struct pend_orbit_problem *problem,
                                      struct pend_error *error) {
    size_t n = (size_t)problem->tree->n, terms = form_terms(problem);
    *form = (struct orbit_form){
        .kind = ORBIT_DRIVEN, .problem = problem, .n = problem->tree->n, .loads = problem->loads};
    form->equations = problem->driven ? 2 * form->n : form->n;
    form->times = problem->driven ? problem->periods : 1;
    form->turns = pend_terms_whole_turns(problem->loads.terms);
    double *at = form->block = calloc(form_numbers(n, terms), sizeof *at);
    form->parameter = calloc((size_t)pend_orbit_form_most(form), sizeof *form->parameter);
    if (!at || !form->parameter)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits of %zu arms", n);
    form->rest = at, at += n;
    form->rest_low = at, at += n;
    form->shape = at, at += n;
    form->phi = at, at += n;
    form->phi_low = at, at += n;
    form->rate = at, at += n;
    form->value = at, at += terms;
    form->weight = at;
    if (problem->driven) {
        if (!pend_orbit_drive(&problem->loads, &form->omega))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "the drives of this pendulum have no common period");
    } else {
        PEND_TRY(form_mode(form, error));
        double *scratch = calloc(4 * n, sizeof *scratch);
        if (!scratch) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for orbits");
        form->rest_potential = pend_kinematics_energy_at(problem->tree, &problem->loads, 0,
                                                         form->rest, form->rate, scratch)
                                   .potential;
        free(scratch);
    }
    form->from = form_from(form);
    return PEND_OK;
}

void pend_orbit_form_clear(struct orbit_form *form) {
    pend_tree_free(&form->tree);
    free(form->block);
    free(form->parameter);
    *form = (struct orbit_form){.n = 0};
}

/* ---- a list of unknowns */

double pend_orbit_form_value(const struct orbit_form *form, const double u[]) {
    assert(form->kind == ORBIT_DRIVEN);
    return form->from + u[form->equations] * (form->problem->to - form->from);
}

/* number of periods in the time span of a motion */
static double form_spans(const struct orbit_form *form) {
    static const double parts[] = {
        [ORBIT_QUARTER] = 4, [ORBIT_HALF] = 2, [ORBIT_FREE] = 1, [ORBIT_DRIVEN] = 1};
    return form->kind == ORBIT_FREE && form->mirrored ? 2 : parts[form->kind];
}

/* by how much the span, s, grows without a drive if the period grows by 1 in its unit */
static double form_later(const struct orbit_form *form) {
    assert(form->kind != ORBIT_DRIVEN);
    return 2 * M_PI / form->omega * form->times / form_spans(form);
}

double pend_orbit_form_period(const struct orbit_form *form) {
    return form_spans(form) * form->span;
}

/* creates the tree with a changed length or mass, in the same stored order */
static enum pend_status form_tree(struct orbit_form *form, double value, struct pend_error *error) {
    const struct pend_tree *tree = form->problem->tree;
    size_t n = (size_t)tree->n;
    int length = form->problem->by.kind == PEND_PARAMETER_LENGTH;
    double *row = malloc(2 * n * sizeof *row);
    int *parent = malloc(n * sizeof *parent);
    unsigned char *bare = malloc(n);
    enum pend_status status = row && parent && bare ? PEND_OK : PEND_NO_MEMORY;
    pend_tree_free(&form->tree);
    for (size_t k = 0; k < n && !status; k++) {
        int i = tree->order[k], changed = (int)k == form->problem->by.at;
        row[i] = changed && length ? value : tree->len[k];
        row[(int)n + i] = changed && !length ? value : tree->mass[k];
        parent[i] = tree->parent[k] < 0 ? -1 : tree->order[tree->parent[k]];
        bare[i] = tree->mass[k] == 0;
    }
    if (!status)
        status = pend_tree_new_bare(&form->tree, tree->n, row, row + n, bare, parent, NULL);
    free(bare);
    free(parent);
    free(row);
    if (status != PEND_OK)
        return pend_fail(error, status, -1, 0, "the pendulum cannot have this %s: %.6g",
                         length ? "length" : "mass", value);
    return PEND_OK;
}

/* sets the varied number in the pendulum, and adds its parameters to those of the map */
static enum pend_status form_vary(struct orbit_form *form, const double u[],
                                  struct pend_error *error) {
    const struct pend_orbit_problem *p = form->problem;
    const struct pend_terms *terms = p->loads.terms;
    double value = pend_orbit_form_value(form, u), span = p->to - form->from;
    form->loads = p->loads;
    form->slope = form->count;
    if (p->vary == PEND_ORBIT_ALONE) return PEND_OK;
    memcpy(form->value, p->loads.value, form_terms(p) * sizeof(double));
    form->loads.value = form->value;
    if (p->vary == PEND_ORBIT_OMEGA) {
        if (!(value > 0))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "a drive cannot have the frequency 0 rad/s");
        for (int i = 0; i < terms->harmonics; i++) {
            int at = terms->harmonic[i].at + 1;
            form->value[at] *= value / form->from;
            form->weight[form->count - form->slope] = p->loads.value[at] / form->from * span;
            form->parameter[form->count++] = (struct pend_parameter){PEND_PARAMETER_TERM, at};
        }
        return PEND_OK;
    }
    form->weight[0] = span;
    form->parameter[form->count++] = p->by;
    if (p->by.kind == PEND_PARAMETER_GRAVITY) form->loads.gravity = value;
    if (p->by.kind == PEND_PARAMETER_TERM) {
        if (!pend_terms_fits(terms, p->by.at, value))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "this number of the pendulum cannot be %.6g", value);
        form->value[p->by.at] = value;
    }
    if (p->by.kind != PEND_PARAMETER_LENGTH && p->by.kind != PEND_PARAMETER_MASS) return PEND_OK;
    return form_tree(form, value, error);
}

enum pend_status pend_orbit_form_set(struct orbit_form *form, const double u[], int whole,
                                     struct pend_problem *motion, struct pend_error *error) {
    const struct pend_orbit_problem *p = form->problem;
    int n = form->n, driven = form->kind == ORBIT_DRIVEN, rates = form->equations == 2 * n;
    form->count = 0;
    for (int k = 0; k < n; k++) {
        double rest = driven ? 0 : form->rest[k];
        form->phi[k] = rest + u[k];
        double back = form->phi[k] - rest;
        form->phi_low[k] =
            (u[k] - back) + (rest - (form->phi[k] - back)) + (driven ? 0 : form->rest_low[k]);
        form->rate[k] = rates ? u[n + k] * form->omega : 0;
        form->parameter[form->count++] = (struct pend_parameter){PEND_PARAMETER_PHI, k};
    }
    for (int k = 0; k < n && (rates || whole); k++)
        form->parameter[form->count++] = (struct pend_parameter){PEND_PARAMETER_RATE, k};
    if (driven) {
        PEND_TRY(form_vary(form, u, error));
        double omega = p->vary == PEND_ORBIT_OMEGA ? pend_orbit_form_value(form, u) : form->omega;
        form->span = form->times * 2 * M_PI / omega;
    } else {
        form->span = u[form->equations] * form_later(form);
    }
    if (form->halved) form->span /= 2;
    if (!(form->span > 0) || !isfinite(form->span))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the period of an orbit must be a positive number");
    *motion = (struct pend_problem){.tree = form->tree ? form->tree : p->tree,
                                    .loads = form->loads,
                                    .phi = form->phi,
                                    .phi_low = form->phi_low,
                                    .rate = form->rate,
                                    .rtol = 1e-16,
                                    .no_drift = 1};
    return PEND_OK;
}

double pend_orbit_form_apart(const struct orbit_form *form, const struct orbit_map *map, int side) {
    double most = 0, twice = side < 0 ? 2 * hanging : 0;
    const double *phi = map ? map->phi : form->phi, *rate = map ? map->rate : form->rate;
    assert(side == 1 || side == -1);
    for (int k = 0; k < form->n; k++) {
        double way = phi[k] - side * form->phi[k] - twice;
        double speed = rate[k] - side * form->rate[k];
        if (form->turns) way = remainder(way, 2 * M_PI);
        most = fmax(most, fmax(fabs(way), fabs(speed) / form->omega));
    }
    return most;
}

/* ---- equations */

static void form_driven(const struct orbit_form *form, const struct orbit_map *map, double F[],
                        double J[]) {
    int n = form->n, columns = 2 * n + 1, q = map->count;
    double omega = form->omega,
           later = 0; // derivative of the span with respect to the last unknown
    assert(q == form->count);
    if (form->problem->vary == PEND_ORBIT_OMEGA) {
        double now = form->times * 2 * M_PI / form->span;
        later = -form->span / now * (form->problem->to - form->from);
    }
    for (int k = 0; k < n; k++) {
        double *angle = J + (size_t)k * (size_t)columns;
        double *speed = J + (size_t)(n + k) * (size_t)columns;
        double way = map->phi[k] - form->phi[k];
        F[k] = form->turns ? remainder(way, 2 * M_PI) : way;
        F[n + k] = (map->rate[k] - form->rate[k]) / omega;
        for (int j = 0; j < 2 * n; j++) {
            double unit = j < n ? 1 : omega;
            angle[j] = map->phi_by[k * q + j] * unit - (j == k);
            speed[j] = map->rate_by[k * q + j] * unit / omega - (j == n + k);
        }
        angle[2 * n] = later * map->rate[k], speed[2 * n] = later * map->acc[k] / omega;
        for (int j = form->slope; j < q; j++) {
            angle[2 * n] += map->phi_by[k * q + j] * form->weight[j - form->slope];
            speed[2 * n] += map->rate_by[k * q + j] * form->weight[j - form->slope] / omega;
        }
    }
}

/* a row of J: the derivatives of a value at the end, in its unit, with respect to the start */
static void form_row(const struct orbit_form *form, const double by[], double unit, double row[]) {
    int n = form->n;
    for (int j = 0; j < 2 * n; j++) row[j] = by[j] * (j < n ? 1 : form->omega) / unit;
}

static void form_free(const struct orbit_form *form, const struct orbit_map *map, double F[],
                      double J[]) {
    size_t n = (size_t)form->n, columns = 2 * n + 1, turning = (size_t)form->turning;
    double side = form->mirrored ? -1 : 1, later = form_later(form), omega = form->omega;
    assert(map->count == 2 * form->n);
    for (size_t k = 0; k < n; k++) {
        double *angle = J + k * columns, *speed = J + (n + k) * columns;
        double rest = form->rest[k], rest_low = form->rest_low[k];
        F[k] = (map->phi[k] - rest - rest_low) -
               side * (form->phi[k] - rest - (rest_low - form->phi_low[k]));
        F[n + k] = (map->rate[k] - side * form->rate[k]) / omega;
        form_row(form, map->phi_by + k * 2 * n, 1, angle);
        form_row(form, map->rate_by + k * 2 * n, omega, speed);
        angle[k] -= side, speed[n + k] -= side;
        angle[2 * n] = later * map->rate[k], speed[2 * n] = later * map->acc[k] / omega;
    }
    F[turning] = form->rate[turning] / omega;
    for (size_t j = 0; j < columns; j++) J[turning * columns + j] = j == n + turning;
}

void pend_orbit_form_equations(const struct orbit_form *form, const struct orbit_map *map,
                               double F[], double J[]) {
    int n = form->n, q = map->count;
    if (form->kind == ORBIT_FREE) {
        form_free(form, map, F, J);
        return;
    }
    if (form->kind == ORBIT_DRIVEN) {
        form_driven(form, map, F, J);
        return;
    }
    int quarter = form->kind == ORBIT_QUARTER;
    double later = form_later(form);
    for (int k = 0; k < n; k++) {
        double *row = J + (size_t)k * (size_t)(n + 1);
        F[k] =
            quarter ? map->phi[k] - form->rest[k] - form->rest_low[k] : map->rate[k] / form->omega;
        for (int j = 0; j < n; j++)
            row[j] = quarter ? map->phi_by[k * q + j] : map->rate_by[k * q + j] / form->omega;
        row[n] = later * (quarter ? map->rate[k] : map->acc[k] / form->omega);
    }
}
