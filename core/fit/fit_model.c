#include "core/fit/fit_model.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"
#include "core/integrate/run/run.h"
#include "core/modes/damped.h"
#include "core/modes/modes.h"

enum { MODEL_BLOCK = 64 };

static double *model_take(char *base, size_t *used, size_t numbers) {
    double *part = base ? (double *)(void *)(base + *used) : NULL;
    *used += (numbers * sizeof(double) + 63) / 64 * 64;
    return part;
}

/* finds which quantities are needed: with derivatives, and as time derivatives of others */
static void model_kinds(struct fit_model *model, const struct pend_fit_problem *problem,
                        unsigned *wants, unsigned *paces) {
    int shifts = 0;
    for (int j = 0; j < problem->unknowns; j++) {
        shifts |= problem->unknown[j].camera == PEND_FIT_SHIFT;
        model->seen.lens |= problem->unknown[j].camera > PEND_FIT_SHIFT &&
                            problem->unknown[j].camera < PEND_FIT_CAMERA;
    }
    for (int i = PEND_FIT_SHIFT + 1; i < PEND_FIT_CAMERA; i++)
        model->seen.lens |= problem->camera[i] != 0;
    for (int c = 0; c < problem->columns; c++) {
        enum pend_fit_kind kind = problem->column[c].kind;
        *wants |= pend_fit_number_needs(kind), shifts |= problem->column[c].clock;
        model->modes |=
            kind == PEND_FIT_MODE || kind == PEND_FIT_AMPLITUDE || kind == PEND_FIT_PERIOD;
    }
    for (int i = 0; i < FIT_SEEN && shifts; i++)
        if ((*wants >> i & 1) && pend_fit_number_pace(i) >= 0)
            *paces |= 1u << pend_fit_number_pace(i);
}

/* the largest number of pairs in a run */
static size_t model_pairs(const struct pend_fit_problem *problem) {
    size_t each = 1;
    for (int c = 0; c < problem->columns; c++) each += problem->column[c].clock != 0;
    return each * (size_t)problem->rows;
}

size_t pend_fit_model_lay(struct fit_model *model, const struct pend_fit_problem *problem,
                          char *memory) {
    assert(problem->n >= 1 && problem->unknowns >= 1 && problem->rows >= 1 &&
           problem->columns >= 1);
    size_t used = 0, n = (size_t)problem->n, q = (size_t)problem->unknowns, block = MODEL_BLOCK;
    size_t pairs = model_pairs(problem);
    unsigned wants = 0, paces = 0;
    *model = (struct fit_model){.problem = problem, .block = MODEL_BLOCK, .seen.problem = problem};
    model_kinds(model, problem, &wants, &paces);
    model->seen.swing = pend_fit_size(problem, PEND_FIT_RATE, 1);
    model->parameter = (struct pend_parameter *)(void *)model_take(memory, &used, q);
    model->place = (int *)(void *)model_take(memory, &used, q);
    model->pair = (struct fit_model_pair *)(void *)model_take(memory, &used, 3 * pairs);
    model->first = (long *)(void *)model_take(memory, &used, pairs + 2);
    model->length = model_take(memory, &used, n);
    model->mass = model_take(memory, &used, n);
    model->phi = model_take(memory, &used, n);
    model->rate = model_take(memory, &used, n);
    model->value = model_take(memory, &used,
                              problem->loads.terms ? (size_t)problem->loads.terms->count + 1 : 1);
    model->t = model_take(memory, &used, pairs + 1);
    model->list = model_take(memory, &used, pairs + 1);
    for (int i = 0; i < FIT_SEEN; i++) {
        int derived = wants >> i & 1, seen = (wants | paces) >> i & 1;
        if (seen) model->seen.value[i] = model_take(memory, &used, block * n);
        if (derived) model->slope[i] = model_take(memory, &used, block * n * (q + 1));
    }
    model->room = model_take(memory, &used, block);
    model->zero = model_take(memory, &used, (size_t)problem->zeros);
    size_t modes = model->modes ? n : 1;
    model->omega = model_take(memory, &used, modes);
    model->near = model_take(memory, &used, modes);
    model->lean = model_take(memory, &used, modes * q);
    model->beside = model_take(memory, &used, q);
    model->seen.length = model->length;
    model->seen.zero = model->zero, model->seen.omega = model->omega;
    return used;
}

/* ---- the pendulum with values of the unknowns */

static int model_elsewhere(const struct pend_fit_unknown *u, int run) {
    return u->camera < 0 && u->by.kind <= PEND_PARAMETER_RATE && u->run != run;
}

static void model_parameters(struct fit_model *model, int run) {
    const struct pend_fit_problem *p = model->problem;
    model->parameters = 0;
    for (int j = 0; j < p->unknowns; j++) {
        model->place[j] = -1;
        if (p->unknown[j].camera >= 0 || model_elsewhere(&p->unknown[j], run)) continue;
        model->parameter[model->parameters] = p->unknown[j].by;
        model->place[j] = model->parameters++;
    }
}

static enum pend_status model_pendulum(struct fit_model *model, const double value[], int run,
                                       struct pend_tree **tree, struct pend_loads *loads) {
    const struct pend_fit_problem *p = model->problem;
    size_t row = (size_t)p->n * sizeof(double), from = (size_t)run * (size_t)p->n;
    memcpy(model->length, p->length, row), memcpy(model->mass, p->mass, row);
    memcpy(model->phi, p->phi + from, row), memcpy(model->rate, p->rate + from, row);
    memcpy(model->seen.camera, p->camera, sizeof model->seen.camera);
    if (p->zeros) memcpy(model->zero, p->zero, (size_t)p->zeros * sizeof(double));
    *loads = p->loads;
    if (loads->terms) {
        memcpy(model->value, loads->value, (size_t)loads->terms->count * sizeof(double));
        loads->value = model->value;
    }
    for (int j = 0; j < p->unknowns; j++) {
        const struct pend_fit_unknown *u = &p->unknown[j];
        double *array[] = {
            [PEND_PARAMETER_PHI] = model->phi,          [PEND_PARAMETER_RATE] = model->rate,
            [PEND_PARAMETER_LENGTH] = model->length,    [PEND_PARAMETER_MASS] = model->mass,
            [PEND_PARAMETER_GRAVITY] = &loads->gravity, [PEND_PARAMETER_TERM] = model->value};
        assert(u->camera >= 0 || (size_t)u->by.kind < sizeof array / sizeof *array);
        int size = u->by.kind == PEND_PARAMETER_LENGTH || u->by.kind == PEND_PARAMETER_MASS;
        if (model_elsewhere(u, run)) continue;
        assert(u->camera < PEND_FIT_CAMERA + p->zeros);
        if (u->camera >= PEND_FIT_CAMERA)
            model->zero[u->camera - PEND_FIT_CAMERA] = value[j];
        else if (u->camera >= 0)
            model->seen.camera[u->camera] = value[j];
        else
            array[u->by.kind][size ? p->order[u->by.at] : u->by.at] = value[j];
    }
    model->seen.gravity = loads->gravity;
    return pend_tree_new_bare(tree, p->n, model->length, model->mass, p->bare, p->parent, NULL);
}

static int pair_before(const void *left, const void *right) {
    const struct fit_model_pair *a = left, *b = right;
    return (a->t > b->t) - (a->t < b->t);
}

/* collects the measured rows of a run among the first rows; returns their number */
static long model_measured(struct fit_model *model, int run, long rows) {
    const struct pend_fit_problem *p = model->problem;
    int plain = (size_t)p->rows == model_pairs(p);
    double shift = model->seen.camera[PEND_FIT_SHIFT], start = pend_fit_start(p, run);
    long count = 0;
    for (long i = 0; i < rows; i++) {
        double t = p->t[i] + shift;
        int others = plain;
        if (pend_fit_run(p, i) != run) continue;
        for (int c = 0; c < p->columns && !plain; c++) {
            int clock = p->column[c].clock, there = !isnan(p->column[c].data[i]);
            others |= there && !clock;
            if (there && clock)
                model->pair[count++] = (struct fit_model_pair){t + model->zero[clock - 1], i, c};
        }
        // the camera's own shift keeps measurements after the start
        if (others) model->pair[count++] = (struct fit_model_pair){t < start ? start : t, i, -1};
    }
    if (!plain) qsort(model->pair, (size_t)count, sizeof *model->pair, pair_before);
    return count;
}

/* Collects the instants of a run among the first rows, in the motion's time, with that of the
 * start. Returns the number of measured rows. */
static long model_instants(struct fit_model *model, int run, long rows) {
    double start = pend_fit_start(model->problem, run);
    assert(rows >= 1 && rows <= model->problem->rows);
    long count = 0, pairs = model_measured(model, run, rows), sought = 1;
    for (long i = 0; i <= pairs; i++) {
        if (sought && (i == pairs || model->pair[i].t >= start)) {
            model->start = count, model->first[count] = i, model->t[count++] = start;
            sought = 0;
        }
        // a time that is not a number fails later
        if (i == pairs || (count && model->pair[i].t <= model->t[count - 1])) continue;
        model->first[count] = i, model->t[count++] = model->pair[i].t;
    }
    model->first[count] = pairs, model->instants = count;
    return pairs;
}

/* ---- modes */

static int modes_before(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

static enum pend_status modes_damped(const struct pend_tree *tree, const struct pend_loads *loads,
                                     double omega[]) {
    struct pend_damped *damped;
    int count = 0, n = tree->n;
    for (int k = 0; k < n; k++) omega[k] = -M_PI / 2;
    PEND_TRY(pend_damped_new(&damped, tree, loads, omega, NULL));
    memset(omega, 0, (size_t)n * sizeof *omega);
    for (int j = 0; j < damped->count && count < n; j++)
        if (damped->omega[j] > 0) omega[count++] = damped->omega[j];
    pend_damped_free(&damped);
    qsort(omega, (size_t)count, sizeof *omega, modes_before);
    return PEND_OK;
}

/* Frequencies of the modes about the equilibrium near hanging, including friction, rad/s: positive
 * ones ascending, then zeros for modes that do not swing. */
static enum pend_status modes_counted(const struct pend_tree *tree, const struct pend_loads *loads,
                                      double omega[]) {
    struct pend_modes *modes;
    if (loads->terms) return modes_damped(tree, loads, omega);
    PEND_TRY(pend_modes_new(&modes, tree, loads, 0, NULL));
    memcpy(omega, modes->omega, (size_t)tree->n * sizeof *omega);
    pend_modes_free(&modes);
    return PEND_OK;
}

/* computes the modes for the given values of the unknowns; sets all to 0 if there are none */
static enum pend_status model_omega(struct fit_model *model, const double value[], double omega[]) {
    struct pend_tree *tree = NULL;
    struct pend_loads loads;
    enum pend_status status = model_pendulum(model, value, 0, &tree, &loads);
    if (status == PEND_OK) status = modes_counted(tree, &loads, omega);
    pend_tree_free(&tree);
    if (status != PEND_OK && status != PEND_NO_MEMORY) status = PEND_INVALID;
    return status;
}

/* a value near that of an unknown, at most half way to its bound */
static double model_step(const struct pend_fit_unknown *u, double value, double step) {
    double bound = step > 0 ? u->high : u->low;
    return fabs(step) < fabs(bound - value) / 2 ? value + step : value + (bound - value) / 2;
}

/* Computes the frequencies of the modes and, by central differences, their derivatives with respect
 * to the unknowns. The rounding error of a derivative is 1e-12 of the frequency divided by the
 * step. */
static enum pend_status model_modes(struct fit_model *model, const double value[], int slopes) {
    const struct pend_fit_problem *p = model->problem;
    size_t n = (size_t)p->n, q = (size_t)p->unknowns;
    PEND_TRY(model_omega(model, value, model->omega));
    for (size_t j = 0; slopes && j < q; j++) {
        double size = fabs(value[j]) > 1e-6 ? fabs(value[j]) : 1e-3, gap = 0;
        memcpy(model->beside, value, q * sizeof *value);
        for (size_t k = 0; k < n; k++) model->lean[k * q + j] = 0;
        if (p->unknown[j].camera >= 0 || p->unknown[j].by.kind <= PEND_PARAMETER_RATE) continue;
        for (int side = 1; side >= -1; side -= 2) {
            model->beside[j] = model_step(&p->unknown[j], value[j], side * fit_curve_step * size);
            gap += side * model->beside[j];
            PEND_TRY(model_omega(model, model->beside, model->near));
            for (size_t k = 0; k < n; k++) model->lean[k * q + j] += side * model->near[k];
        }
        for (size_t k = 0; k < n && gap > 0; k++) model->lean[k * q + j] /= gap;
    }
    return PEND_OK;
}

/* ---- residuals */

static double model_slope(const struct fit_model *model, const struct pend_fit_column *column,
                          const struct fit_number *number, int j) {
    const struct pend_fit_problem *p = model->problem;
    const struct pend_fit_unknown *u = &p->unknown[j];
    size_t q = (size_t)model->parameters, place = (size_t)model->place[j];
    int which = u->camera - PEND_FIT_CAMERA + 1, instrument = which > 0;
    int shift = u->camera == PEND_FIT_SHIFT, own = model->place[j] >= 0;
    double moved = 0, rest = 0;
    shift |= instrument & (which == column->clock);
    if (instrument > shift) return which == column->zero;
    for (int k = 0; k < number->seen && (own || shift); k++) {
        int what = number->what[k];
        double by = own ? model->slope[what][number->at[k] * q + place]
                        : model->seen.value[pend_fit_number_pace(what)][number->at[k]];
        moved += number->by[k] * by;
    }
    for (int k = number->seen; k < number->terms; k++) {
        int what = number->what[k];
        // the camera's numbers do not depend on unknowns of the pendulum
        if (own && what >= FIT_CAMERA) break;
        double by = what == FIT_GRAVITY  ? u->by.kind == PEND_PARAMETER_GRAVITY
                    : what >= FIT_CAMERA ? u->camera == what - FIT_CAMERA
                    : what == FIT_LENGTH
                        ? u->by.kind == PEND_PARAMETER_LENGTH && p->order[u->by.at] == column->arm
                        : model->lean[number->at[k] * (size_t)p->unknowns + (size_t)j];
        rest += number->by[k] * (own || what >= FIT_OMEGA ? by : 0);
    }
    return number->lead * moved + rest;
}

/* a measured row whose instant has index `from` in the block */
static void model_row(const struct fit_model *model, const struct fit_model_pair *pair, long from,
                      double residual[], double slope[]) {
    const struct pend_fit_problem *p = model->problem;
    long row = pair->row;
    for (int c = 0; c < p->columns; c++) {
        const struct pend_fit_column *column = &p->column[c];
        size_t at = (size_t)row * (size_t)p->columns + (size_t)c;
        double *own = slope ? slope + at * (size_t)p->unknowns : NULL;
        double data = column->data[row], sigma = pend_fit_sigma(column, row), by = 1;
        struct fit_number number;
        if (isnan(data) || (column->clock ? c : -1) != pair->column) continue;
        pend_fit_number(&model->seen, column, data, (size_t)from, &number);
        double value = column->kind == PEND_FIT_PASSAGE ? number.value : number.value - data;
        // tracking programs do not count turns
        if (column->kind == PEND_FIT_PHI) value = remainder(value, 2 * M_PI);
        residual[at] = value / sigma;
        if (p->knee && p->knee[c] > 0)
            residual[at] = fit_loss_bend(p->loss, p->knee[c], value / sigma, &by);
        for (int j = 0; own && j < p->unknowns; j++)
            own[j] = model_slope(model, column, &number, j) / sigma * by;
    }
}

/* residuals and slopes of the rows first .. first + count - 1 of a motion, whose values are in
 * `seen` and `slope` */
static void model_rows(const struct fit_model *model, long first, long count, double residual[],
                       double slope[]) {
    for (long i = 0; i < count; i++) {
        long instant = model->start + model->way * (first + i);
        for (long k = model->first[instant]; k < model->first[instant + 1]; k++)
            model_row(model, &model->pair[k], i, residual, slope);
    }
}

/* computes the motion with its derivatives, block by block; slope: NULL if not needed */
static enum pend_status model_slopes(struct fit_model *model, const struct pend_problem *problem,
                                     double residual[], double slope[], struct pend_error *error) {
    struct pend_derivatives *d;
    struct pend_derived_rows rows = {.value = {0}};
    for (int i = 0; i < FIT_SEEN; i++) {
        int what = i < FIT_CART ? i : PEND_DERIVED_CART_PLACE + i - FIT_CART;
        rows.value[what] = model->seen.value[i];
        if (slope) rows.derivative[what] = model->slope[i];
    }
    struct pend_parameter none = {PEND_PARAMETER_GRAVITY, 0};
    int count = slope && model->parameters ? model->parameters : 1;
    PEND_TRY(pend_derivatives_new(&d, problem, count, model->parameters ? model->parameter : &none,
                                  error));
    enum pend_status status = PEND_OK;
    for (long row = 0, made; row < problem->times.count && status == PEND_OK; row += made) {
        status = pend_derivatives_next(d, &rows, model->block, INFINITY, &made, error);
        model_rows(model, row, made, residual, slope);
    }
    pend_derivatives_free(&d);
    return status;
}

static enum pend_status model_values(struct fit_model *model, const struct pend_problem *problem,
                                     double residual[], struct pend_error *error) {
    struct pend_run *run;
    double *const *value = model->seen.value;
    struct pend_samples samples = {.cap = model->block,
                                   .t = model->room,
                                   .phi = value[PEND_DERIVED_PHI],
                                   .rate = value[PEND_DERIVED_RATE],
                                   .z_re = value[PEND_DERIVED_Z_RE],
                                   .z_im = value[PEND_DERIVED_Z_IM],
                                   .cart_place = value[FIT_CART]};
    PEND_TRY(pend_run_new(&run, &pend_method_taylor, problem, error));
    enum pend_status status = PEND_OK;
    int done = 0;
    for (long row = 0; !done && status == PEND_OK; row += samples.count) {
        status = pend_run_next(run, &samples, INFINITY, &done, error);
        model_rows(model, row, samples.count, residual, NULL);
    }
    pend_run_free(&run);
    return status;
}

/* computes the motion from the start to the last instant, way 1, or back to the first one, -1 */
static enum pend_status model_motion(struct fit_model *model, struct pend_problem problem, long way,
                                     double residual[], double slope[], struct pend_error *error) {
    long last = way > 0 ? model->instants - 1 - model->start : model->start;
    for (long i = 0; i <= last; i++) model->list[i] = model->t[model->start + way * i];
    double decays = fabs(model->list[last] - model->list[0]) * model->decay;
    problem.times.count = last + 1, problem.times.list = model->list, model->way = way;
    problem.step_cap += (long)fmin(FIT_STIFF_STEPS, decays);
    // accelerations of tips come with derivatives only
    int derived = slope || model->seen.value[PEND_DERIVED_ZDD_RE];
    return derived ? model_slopes(model, &problem, residual, slope, error)
                   : model_values(model, &problem, residual, error);
}

static enum pend_status model_run(struct fit_model *model, const double value[], int run, long rows,
                                  double residual[], double slope[], struct pend_error *error) {
    const struct pend_fit_problem *p = model->problem;
    struct pend_tree *tree = NULL;
    struct pend_loads loads;
    enum pend_status status = model_pendulum(model, value, run, &tree, &loads);
    if (status != PEND_OK)
        return pend_fail(error, status, -1, 0, "these values are not possible for a pendulum");
    long pairs = model_instants(model, run, rows);
    model_parameters(model, run);
    // friction that stops an arm quickly shortens the steps
    if (model->motions == 0) model->decay = fmax(model->decay, pend_loads_decay(&loads, tree));
    struct pend_problem problem = {.tree = tree,
                                   .loads = loads,
                                   .phi = model->phi,
                                   .rate = model->rate,
                                   .rtol = p->rtol,
                                   .step_cap = p->step_cap,
                                   .no_drift = 1};
    if (model->start) status = model_motion(model, problem, -1, residual, slope, error);
    if (pairs && status == PEND_OK)
        status = model_motion(model, problem, 1, residual, slope, error);
    pend_tree_free(&tree);
    return status;
}

enum pend_status pend_fit_model_at(struct fit_model *model, const double value[], long rows,
                                   double residual[], double slope[], struct pend_error *error) {
    const struct pend_fit_problem *p = model->problem;
    assert(rows >= 1 && rows <= p->rows);
    size_t numbers = (size_t)p->rows * (size_t)p->columns;
    memset(residual, 0, numbers * sizeof(double));
    if (slope) memset(slope, 0, numbers * (size_t)p->unknowns * sizeof(double));
    enum pend_status status = model->modes ? model_modes(model, value, slope != NULL) : PEND_OK;
    if (status != PEND_OK)
        return pend_fail(error, status, -1, 0, "these values are not possible for a pendulum");
    for (int run = 0; run < pend_fit_runs(p) && status == PEND_OK; run++)
        status = model_run(model, value, run, rows, residual, slope, error);
    if (slope) model->motions += (double)rows / (double)p->rows;
    return status;
}
