#include "core/fit/fit_model.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/integrate/run.h"

enum { MODEL_BLOCK = 64, MODEL_ANGLE = 0, MODEL_X = 1, MODEL_Y = 2 };

static double *model_take(char *base, size_t *used, size_t numbers) {
    double *part = base ? (double *)(void *)(base + *used) : NULL;
    *used += (numbers * sizeof(double) + 63) / 64 * 64;
    return part;
}

size_t pend_fit_model_lay(struct fit_model *model, const struct pend_fit_problem *problem,
                          char *memory) {
    assert(problem->n >= 1 && problem->unknowns >= 1 && problem->rows >= 1 &&
           problem->columns >= 1);
    size_t used = 0, n = (size_t)problem->n, q = (size_t)problem->unknowns, block = MODEL_BLOCK;
    *model = (struct fit_model){.problem = problem, .block = MODEL_BLOCK};
    for (int j = 0; j < problem->unknowns; j++) model->parameters += problem->unknown[j].camera < 0;
    for (int c = 0; c < problem->columns; c++) {
        int angle = problem->column[c].kind == PEND_FIT_PHI;
        if (angle)
            model->wants[MODEL_ANGLE] = 1;
        else
            model->wants[MODEL_X] = model->wants[MODEL_Y] = 1;
    }
    model->before = problem->rows && problem->start < problem->t[0];
    model->parameter = (struct pend_parameter *)(void *)model_take(memory, &used, q);
    model->length = model_take(memory, &used, n);
    model->mass = model_take(memory, &used, n);
    model->phi = model_take(memory, &used, n);
    model->rate = model_take(memory, &used, n);
    model->value = model_take(memory, &used,
                              problem->loads.terms ? (size_t)problem->loads.terms->count + 1 : 1);
    model->t = model_take(memory, &used, (size_t)problem->rows + 1);
    for (int i = 0; i < 3; i++) {
        model->seen[i] = model_take(memory, &used, block * n);
        model->slope[i] = model_take(memory, &used, block * n * (q + 1));
    }
    model->room = model_take(memory, &used, block);
    if (!memory) return used;
    model->t[0] = problem->start;
    memcpy(model->t + model->before, problem->t, (size_t)problem->rows * sizeof(double));
    for (int j = 0, at = 0; j < problem->unknowns; j++)
        if (problem->unknown[j].camera < 0) model->parameter[at++] = problem->unknown[j].by;
    return used;
}

/* ---- the pendulum with values of the unknowns */

static enum pend_status model_pendulum(struct fit_model *model, const double value[],
                                       struct pend_tree **tree, struct pend_loads *loads) {
    const struct pend_fit_problem *p = model->problem;
    size_t row = (size_t)p->n * sizeof(double);
    memcpy(model->length, p->length, row), memcpy(model->mass, p->mass, row);
    memcpy(model->phi, p->phi, row), memcpy(model->rate, p->rate, row);
    memcpy(model->camera, p->camera, sizeof model->camera);
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
        if (u->camera >= 0)
            model->camera[u->camera] = value[j];
        else
            array[u->by.kind][size ? p->order[u->by.at] : u->by.at] = value[j];
    }
    return pend_tree_new_bare(tree, p->n, model->length, model->mass, p->bare, p->parent, NULL);
}

/* ---- residuals */

/* one measurement: its model, and the slopes of it by the pendulum's parameters and the camera */
static void model_number(const struct fit_model *model, const struct pend_fit_column *column,
                         long row, int slopes, double *model_value, double slope[]) {
    const struct pend_fit_problem *p = model->problem;
    size_t at = (size_t)row * (size_t)p->n + (size_t)column->arm;
    size_t of = at * (size_t)model->parameters;
    if (column->kind == PEND_FIT_PHI) {
        *model_value = model->seen[MODEL_ANGLE][at];
        for (int j = 0, i = 0; slopes && j < p->unknowns; j++)
            slope[j] = p->unknown[j].camera < 0 ? model->slope[MODEL_ANGLE][of + (size_t)i++] : 0;
        return;
    }
    double scale = model->camera[PEND_FIT_SCALE], c = cos(model->camera[PEND_FIT_ROTATION]);
    double s = sin(model->camera[PEND_FIT_ROTATION]);
    double x = model->seen[MODEL_X][at], y = model->seen[MODEL_Y][at];
    // the camera's coordinate is origin + scale (a x + b y)
    int first = column->kind == PEND_FIT_X;
    double a = first ? c : s, b = first ? -s : c, turn = first ? -s * x - c * y : c * x - s * y;
    *model_value =
        model->camera[first ? PEND_FIT_ORIGIN_X : PEND_FIT_ORIGIN_Y] + scale * (a * x + b * y);
    double by[PEND_FIT_CAMERA] = {a * x + b * y, scale * turn, first, !first};
    for (int j = 0, i = 0; slopes && j < p->unknowns; j++) {
        if (p->unknown[j].camera >= 0) {
            slope[j] = by[p->unknown[j].camera];
            continue;
        }
        size_t place = of + (size_t)i++;
        slope[j] = scale * (a * model->slope[MODEL_X][place] + b * model->slope[MODEL_Y][place]);
    }
}

/* rows first .. first + count - 1, which are in `seen` and `slope` from place `from` on */
static void model_rows(const struct fit_model *model, long first, long from, long count,
                       double residual[], double slope[]) {
    const struct pend_fit_problem *p = model->problem;
    for (long i = 0; i < count; i++)
        for (int c = 0; c < p->columns; c++) {
            const struct pend_fit_column *column = &p->column[c];
            size_t at = (size_t)(first + i) * (size_t)p->columns + (size_t)c;
            double *own = slope ? slope + at * (size_t)p->unknowns : NULL;
            double data = column->data[first + i], value;
            double sigma = pend_fit_sigma(column, first + i);
            if (isnan(data)) continue;
            model_number(model, column, from + i, slope != NULL, &value, own);
            value -= data;
            // a tracker does not count turns
            if (column->kind == PEND_FIT_PHI) value = remainder(value, 2 * M_PI);
            residual[at] = value / sigma;
            for (int j = 0; own && j < p->unknowns; j++) own[j] /= sigma;
        }
}

/* the motion with derivatives, block by block */
static enum pend_status model_slopes(struct fit_model *model, const struct pend_problem *problem,
                                     double residual[], double slope[], struct pend_error *error) {
    struct pend_derivatives *d;
    struct pend_derived_rows rows = {.value = {0}};
    static const int what[3] = {PEND_DERIVED_PHI, PEND_DERIVED_Z_RE, PEND_DERIVED_Z_IM};
    for (int i = 0; i < 3; i++)
        if (model->wants[i])
            rows.value[what[i]] = model->seen[i], rows.derivative[what[i]] = model->slope[i];
    struct pend_parameter none = {PEND_PARAMETER_GRAVITY, 0};
    int count = model->parameters ? model->parameters : 1;
    PEND_TRY(pend_derivatives_new(&d, problem, count, model->parameters ? model->parameter : &none,
                                  error));
    enum pend_status status = PEND_OK;
    for (long row = 0, made; row < problem->times.count && status == PEND_OK; row += made) {
        status = pend_derivatives_next(d, &rows, model->block, INFINITY, &made, error);
        long skip = !row && model->before;
        model_rows(model, row + skip - model->before, skip, made - skip, residual, slope);
    }
    pend_derivatives_free(&d);
    return status;
}

/* the motion alone */
static enum pend_status model_values(struct fit_model *model, const struct pend_problem *problem,
                                     double residual[], struct pend_error *error) {
    struct pend_run *run;
    struct pend_samples samples = {.cap = model->block, .t = model->room};
    if (model->wants[MODEL_ANGLE]) samples.phi = model->seen[MODEL_ANGLE];
    if (model->wants[MODEL_X])
        samples.z_re = model->seen[MODEL_X], samples.z_im = model->seen[MODEL_Y];
    PEND_TRY(pend_run_new(&run, &pend_method_taylor, problem, error));
    enum pend_status status = PEND_OK;
    int done = 0;
    for (long row = 0; !done && status == PEND_OK; row += samples.count) {
        status = pend_run_next(run, &samples, INFINITY, &done, error);
        long skip = !row && model->before && samples.count;
        model_rows(model, row + skip - model->before, skip, samples.count - skip, residual, NULL);
    }
    pend_run_free(&run);
    return status;
}

enum pend_status pend_fit_model_at(struct fit_model *model, const double value[], long rows,
                                   double residual[], double slope[], struct pend_error *error) {
    const struct pend_fit_problem *p = model->problem;
    assert(rows >= 1 && rows <= p->rows);
    size_t numbers = (size_t)p->rows * (size_t)p->columns;
    struct pend_tree *tree = NULL;
    struct pend_loads loads;
    memset(residual, 0, numbers * sizeof(double));
    if (slope) memset(slope, 0, numbers * (size_t)p->unknowns * sizeof(double));
    enum pend_status status = model_pendulum(model, value, &tree, &loads);
    if (status != PEND_OK) return pend_fail(error, status, -1, 0, "there is no such pendulum");
    struct pend_problem problem = {.tree = tree,
                                   .loads = loads,
                                   .phi = model->phi,
                                   .rate = model->rate,
                                   .times = {.count = rows + model->before, .list = model->t},
                                   .rtol = p->rtol,
                                   .step_cap = p->step_cap,
                                   .no_drift = 1};
    status = slope ? model_slopes(model, &problem, residual, slope, error)
                   : model_values(model, &problem, residual, error);
    pend_tree_free(&tree);
    return status;
}
