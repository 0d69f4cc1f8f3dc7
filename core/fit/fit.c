#include "core/fit/fit.h"

#include <assert.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_model.h"
#include "core/fit/fit_told.h"

/* Tolerances of an iteration: of a window that will grow, and of all rows. */
static const double fit_rough = 1e-3, fit_fine = 1e-6;

/* most iterations in a window that will grow */
enum { FIT_ROUGH = 12 };

/* Rows are taken in as long as the fit so far foretells an angle to this, rad, and a tip to this
 * part of the lengths together. */
static const double fit_foretold = 0.4;

/* Parts of the sum of squares: what one more step may still gain at a minimum; what a motion that
 * follows explains; residuals of so many sigma are not noise */
static const double fit_minimum = 1e-6, fit_explained = 0.9, fit_strange = 3;

/* part of the data's squares that is rounding: data may be met exactly */
static const double fit_exact = 1e-12;

/* residual where there is no motion: a step there is never taken */
static const double fit_nowhere = 1e6;

struct pend_fit {
    struct pend_fit_problem problem;
    struct fit_model model;
    gsl_multifit_nlinear_workspace *work;
    gsl_multifit_nlinear_fdf fdf;
    long window;             /* rows taken in */
    int here;                /* iterations in this window */
    int begun, ready;        /* the workspace is at the window; the result is there */
    double largest;          /* s, of the first window */
    enum pend_status status; /* of the last evaluation at an iterate */
    int starved;             /* memory was refused: no result is what it would have been */
    struct pend_error failure;
    double *inner, *value, *error, *correlation, *residual, *slope, *direction, *covariance, *size;
    unsigned char *bounded;
    struct pend_fit_result result;
};

int pend_fit_valid(const struct pend_fit *fit) {
    return fit->problem.unknowns >= 1 && fit->window >= 1 && fit->window <= fit->problem.rows;
}

/* ---- what GSL asks for */

static void fit_values(struct pend_fit *fit, const gsl_vector *x) {
    for (int j = 0; j < fit->problem.unknowns; j++)
        fit->value[j] = fit_bounds_outer(&fit->problem.unknown[j], gsl_vector_get(x, (size_t)j));
}

static int fit_residuals(const gsl_vector *x, void *context, gsl_vector *f) {
    struct pend_fit *fit = context;
    fit_values(fit, x);
    fit->result.evaluations++;
    fit->status =
        pend_fit_model_at(&fit->model, fit->value, fit->window, f->data, NULL, &fit->failure);
    fit->starved |= fit->status == PEND_NO_MEMORY;
    if (fit->status != PEND_OK) gsl_vector_set_all(f, fit_nowhere);
    return fit->status == PEND_NO_MEMORY ? GSL_ENOMEM : GSL_SUCCESS;
}

static int fit_slopes(const gsl_vector *x, void *context, gsl_matrix *J) {
    struct pend_fit *fit = context;
    int q = fit->problem.unknowns;
    fit_values(fit, x);
    fit->result.evaluations++;
    fit->status = pend_fit_model_at(&fit->model, fit->value, fit->window, fit->residual, fit->slope,
                                    &fit->failure);
    fit->starved |= fit->status == PEND_NO_MEMORY;
    if (fit->status != PEND_OK) return GSL_EFAILED;
    for (size_t i = 0; i < J->size1; i++)
        for (int j = 0; j < q; j++) {
            double stretch =
                fit_bounds_stretch(&fit->problem.unknown[j], gsl_vector_get(x, (size_t)j));
            gsl_matrix_set(J, i, (size_t)j, stretch * fit->slope[i * (size_t)q + (size_t)j]);
        }
    return GSL_SUCCESS;
}

/* ---- making and freeing */

static size_t fit_measurements(const struct pend_fit_problem *problem) {
    size_t count = 0;
    for (long i = 0; i < problem->rows; i++)
        for (int c = 0; c < problem->columns; c++) count += !isnan(problem->column[c].data[i]);
    return count;
}

static enum pend_status fit_check(const struct pend_fit_problem *problem,
                                  struct pend_error *error) {
    if (problem->unknowns < 1)
        return pend_fail(error, PEND_INVALID, -1, 0, "there is nothing to be found: no unknowns");
    size_t count = fit_measurements(problem);
    if (count < (size_t)problem->unknowns)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%zu measurements are too few for %d unknowns: there must be as many",
                         count, problem->unknowns);
    for (long i = 0; i < problem->rows; i++) {
        double before = i ? problem->t[i - 1] : problem->start;
        if (i ? problem->t[i] > before : problem->t[i] >= before) continue;
        return pend_fail(error, PEND_INVALID, -1, problem->t[i],
                         "row %ld, %.6g s, must come after %s, %.6g s", i + 1, problem->t[i],
                         i ? "the row before it" : "the start", before);
    }
    for (int j = 0; j < problem->unknowns; j++) {
        const struct pend_fit_unknown *u = &problem->unknown[j];
        if (u->low < u->start && u->start < u->high) continue;
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "unknown %d starts at %g, which must lie between its bounds %g and %g",
                         j + 1, u->start, u->low, u->high);
    }
    return PEND_OK;
}

static size_t fit_lay(struct pend_fit *fit, char *block) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns, m = (size_t)p->rows * (size_t)p->columns;
    size_t counts[] = {q, q, q, q * q, m, m * q, PEND_FIT_BLIND * q, q * q, q, (q + 7) / 8};
    double **array[] = {&fit->inner,       &fit->value,      &fit->error,
                        &fit->correlation, &fit->residual,   &fit->slope,
                        &fit->direction,   &fit->covariance, &fit->size};
    size_t used = (sizeof *fit + 63) / 64 * 64;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        double *at = block ? (double *)(void *)(block + used) : NULL;
        if (i < sizeof array / sizeof *array)
            *array[i] = at;
        else
            fit->bounded = (unsigned char *)at;
        used += (counts[i] * sizeof(double) + 63) / 64 * 64;
    }
    return used + pend_fit_model_lay(&fit->model, p, block ? block + used : NULL);
}

double pend_fit_bytes(const struct pend_fit_problem *problem) {
    struct pend_fit sketch = {.problem = *problem};
    double q = problem->unknowns, m = (double)problem->rows * problem->columns;
    // GSL keeps the slopes, their factorization and a copy
    return (double)fit_lay(&sketch, NULL) + 8 * (4 * m * q + 8 * m + 8 * q * q);
}

/* s, about the time of a swing: what is fitted first */
static double fit_swing(const struct pend_fit_problem *problem) {
    double length = 0, span = problem->t[problem->rows - 1] - problem->t[0];
    for (int k = 0; k < problem->n; k++) length += problem->length[k] / problem->n;
    double gravity = fabs(problem->loads.gravity);
    return gravity > 0 ? 2 * M_PI * sqrt(length / gravity) : span / 8;
}

/* the first rows: a swing, and twice as many measurements as unknowns */
static long fit_first(const struct pend_fit_problem *problem) {
    double until = problem->t[0] + fit_swing(problem);
    long rows = 0, count = 0;
    while (rows < problem->rows && (problem->t[rows] <= until || count < 2 * problem->unknowns)) {
        for (int c = 0; c < problem->columns; c++) count += !isnan(problem->column[c].data[rows]);
        rows++;
    }
    return rows;
}

/* a motion of so many steps is one of wild values, where the search has nothing to find */
static void fit_cap(struct pend_fit_problem *problem) {
    enum { LEAST = 200, A_SWING = 200 };
    double swings = (problem->t[problem->rows - 1] - problem->start) / fit_swing(problem);
    double most = LEAST + A_SWING * problem->n * swings;
    if (!problem->step_cap || problem->step_cap > most) problem->step_cap = (long)most;
}

enum pend_status pend_fit_new(struct pend_fit **fit, const struct pend_fit_problem *problem,
                              struct pend_error *error) {
    *fit = NULL;
    PEND_TRY(fit_check(problem, error));
    struct pend_fit sketch = {.problem = *problem};
    size_t bytes = fit_lay(&sketch, NULL), m = (size_t)problem->rows * (size_t)problem->columns;
    char *block = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!block) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    memset(block, 0, bytes);
    struct pend_fit *made = (struct pend_fit *)(void *)block;
    *made = sketch;
    fit_lay(made, block);
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    how.trs = gsl_multifit_nlinear_trs_lmaccel;
    made->work =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &how, m, (size_t)problem->unknowns);
    if (!made->work) {
        free(block);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    }
    made->fdf = (gsl_multifit_nlinear_fdf){.f = fit_residuals,
                                           .df = fit_slopes,
                                           .n = m,
                                           .p = (size_t)problem->unknowns,
                                           .params = made};
    for (int j = 0; j < problem->unknowns; j++)
        made->inner[j] = fit_bounds_inner(&problem->unknown[j], problem->unknown[j].start);
    made->window = fit_first(problem);
    fit_cap(&made->problem);
    assert(pend_fit_valid(made));
    *fit = made;
    return PEND_OK;
}

void pend_fit_free(struct pend_fit **fit) {
    if (!*fit) return;
    assert(pend_fit_valid(*fit));
    gsl_multifit_nlinear_free((*fit)->work);
    free(*fit);
    *fit = NULL;
}

/* ---- what the data tell */

/* what an unknown is measured in: its value, or 1 where that is next to nothing */
static double fit_measure(const struct pend_fit *fit, int j) {
    double value = fabs(fit->value[j]), start = fabs(fit->problem.unknown[j].start);
    return value > 1e-6 ? value : start > 1e-6 ? start : 1;
}

/* what the slopes and residuals of the last look tell */
static enum pend_status fit_tell(const struct pend_fit *fit, struct fit_told *told) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    return pend_fit_told_init(told, m, fit->problem.unknowns, fit->slope, fit->residual,
                              fit->bounded, fit->size);
}

/* the covariance as it is where no unknown were held by a bound: the one that is there is as
 * uncertain as the data leave it, and the others with it; then which are there */
static enum pend_status fit_free(struct pend_fit *fit, double variance) {
    struct fit_told told;
    size_t q = (size_t)fit->problem.unknowns;
    memset(fit->bounded, 0, q);
    enum pend_status status = fit_tell(fit, &told);
    if (status == PEND_OK) pend_fit_told_covariance(&told, fit->covariance);
    pend_fit_told_clear(&told);
    for (size_t j = 0; j < q && status == PEND_OK; j++) {
        double error = sqrt(variance * fit->covariance[j * q + j]);
        int at = fit_bounds_at(&fit->problem.unknown[j], fit->value[j], error);
        fit->bounded[j] = (unsigned char)at;
    }
    return status;
}

/* slopes and residuals of the first rows at the fit's values; unknowns that are next to bounds */
static enum pend_status fit_look(struct pend_fit *fit, long rows, struct pend_error *error) {
    fit->result.evaluations++;
    for (int j = 0; j < fit->problem.unknowns; j++) {
        fit->value[j] = fit_bounds_outer(&fit->problem.unknown[j], fit->inner[j]);
        fit->bounded[j] = (unsigned char)fit_bounds_at(&fit->problem.unknown[j], fit->value[j], 0);
        fit->size[j] = fit_measure(fit, j);
    }
    return pend_fit_model_at(&fit->model, fit->value, rows, fit->residual, fit->slope, error);
}

/* the sum of squares of the first rows, and how many measurements are in them */
static double fit_squares(const struct pend_fit *fit, long rows, long *count) {
    double sum = 0;
    *count = 0;
    for (long i = 0; i < rows; i++)
        for (int c = 0; c < fit->problem.columns; c++) {
            double r = fit->residual[i * fit->problem.columns + c];
            if (isnan(fit->problem.column[c].data[i])) continue;
            sum += r * r, ++*count;
        }
    return sum;
}

/* whether all standard deviations are known */
static int fit_known(const struct pend_fit *fit) {
    int known = 1;
    for (int c = 0; c < fit->problem.columns; c++) known &= pend_fit_known(&fit->problem.column[c]);
    return known;
}

/* variance of a residual: 1 where sigma is known, else as large as it is */
static double fit_variance(const struct pend_fit *fit, double squares, long freedom) {
    return fit_known(fit) || freedom < 1 ? 1 : squares / (double)freedom;
}

/* ---- windows */

/* the standard deviation with which a measurement is foretold, over what it may be */
static double fit_doubt(const struct pend_fit *fit, long row, int c, double variance) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns;
    const double *slope = fit->slope + ((size_t)row * (size_t)p->columns + (size_t)c) * q;
    double sum = 0, most = fit_foretold, sigma = pend_fit_sigma(&p->column[c], row);
    for (size_t i = 0; i < q; i++)
        for (size_t j = 0; j < q; j++) sum += slope[i] * fit->covariance[i * q + j] * slope[j];
    if (p->column[c].kind != PEND_FIT_PHI) {
        double reach = 0;
        for (int k = 0; k < p->n; k++) reach += p->length[k];
        most *= reach * fabs(fit->model.camera[PEND_FIT_SCALE]);
    }
    return sqrt(sum * variance) * sigma / most;
}

/* takes in rows that are foretold, at least a few */
static enum pend_status fit_grow(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    long rows = fit->window, ahead = 4 * rows + 8, least = rows + 1 + rows / 20, count;
    struct fit_told told;
    PEND_TRY(fit_look(fit, rows, error));
    double squares = fit_squares(fit, rows, &count);
    double variance = fit_variance(fit, squares, count - p->unknowns);
    enum pend_status status = fit_tell(fit, &told);
    if (status == PEND_OK) pend_fit_told_covariance(&told, fit->covariance);
    pend_fit_told_clear(&told);
    PEND_TRY(status);
    if (ahead > p->rows) ahead = p->rows;
    // a motion that has no later rows is told only as far as it goes
    status = fit_look(fit, ahead, error);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        for (int good = 1; rows < ahead && good; rows += good)
            for (int c = 0; c < p->columns && good; c++)
                good = !(fit_doubt(fit, rows, c, variance) > 1);
    if (rows < least) rows = least;
    fit->window = rows < p->rows ? rows : p->rows;
    fit->begun = 0;
    return PEND_OK;
}

/* ---- the result */

static void fit_errors(struct pend_fit *fit, double variance) {
    size_t q = (size_t)fit->problem.unknowns;
    for (size_t j = 0; j < q; j++) {
        fit->error[j] = sqrt(variance * fit->covariance[j * q + j]);
        for (int d = 0; d < fit->result.blind; d++)
            if (fabs(fit->direction[(size_t)d * q + j]) > 1e-3) fit->error[j] = INFINITY;
        if (fit->bounded[j]) fit->error[j] = NAN;
    }
    for (size_t i = 0; i < q; i++)
        for (size_t j = 0; j < q; j++) {
            double size = sqrt(fit->covariance[i * q + i]) * sqrt(fit->covariance[j * q + j]);
            int known = isfinite(fit->error[i]) && isfinite(fit->error[j]) && size > 0;
            fit->correlation[i * q + j] = i == j ? 1 : 0;
            if (known && i != j) fit->correlation[i * q + j] = fit->covariance[i * q + j] / size;
        }
}

/* the sum of squares of the data about their mean, or what is left of it by rounding */
static double fit_total(const struct pend_fit *fit) {
    double sum = 0;
    for (int c = 0; c < fit->problem.columns; c++) {
        const struct pend_fit_column *column = &fit->problem.column[c];
        double mean = 0, weight = 0;
        for (long i = 0; i < fit->problem.rows; i++) {
            if (isnan(column->data[i])) continue;
            double own = pow(pend_fit_sigma(column, i), -2);
            mean += own * column->data[i], weight += own;
        }
        mean /= weight > 0 ? weight : 1;
        for (long i = 0; i < fit->problem.rows; i++) {
            double x = column->data[i], size = pow(pend_fit_sigma(column, i), -2);
            if (!isnan(x)) sum += size * ((x - mean) * (x - mean) + fit_exact * x * x);
        }
    }
    return sum;
}

/* the last row up to which the residuals of any few rows together are not above two sigma */
static double fit_follows(const struct pend_fit *fit, double variance) {
    enum { TOGETHER = 8 };
    const struct pend_fit_problem *p = &fit->problem;
    double last = NAN;
    for (long from = 0; from < p->rows; from += TOGETHER) {
        double sum = 0;
        long count = 0, end = from + TOGETHER < p->rows ? from + TOGETHER : p->rows;
        for (long i = from; i < end; i++)
            for (int c = 0; c < p->columns; c++) {
                double r = fit->residual[i * p->columns + c];
                if (isnan(p->column[c].data[i])) continue;
                sum += r * r, count++;
            }
        if (sum > 6 * variance * (double)count) return last;
        last = p->t[end - 1];
    }
    return last;
}

static enum pend_status fit_finish(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    struct pend_fit_result *result = &fit->result;
    struct fit_told told;
    long count, found = 0;
    PEND_TRY(fit_look(fit, p->rows, error));
    result->chi_squared = fit_squares(fit, p->rows, &count);
    PEND_TRY(fit_free(fit, fit_variance(fit, result->chi_squared, count - p->unknowns)));
    enum pend_status status = fit_tell(fit, &told);
    if (status != PEND_OK) {
        pend_fit_told_clear(&told);
        return status;
    }
    for (int d = 0; d < p->unknowns; d++) found += pend_fit_told_is(&told, d);
    result->freedom = count - found;
    double variance = fit_variance(fit, result->chi_squared, result->freedom);
    result->blind = pend_fit_told_blind(&told, fit->bounded, PEND_FIT_BLIND, fit->direction);
    // no step gains more than a millionth of what is left, or of one measurement's own
    double total = fit_total(fit), floor = fit_known(fit) ? 1 : fit_exact * total;
    int minimum = fit->window == p->rows &&
                  pend_fit_told_gain(&told) <= fit_minimum * (result->chi_squared + floor);
    pend_fit_told_clear(&told);
    fit_errors(fit, variance);
    result->explained = total > 0 ? 1 - result->chi_squared / total : 0;
    result->follows = fit_follows(fit, variance);
    double spread = result->chi_squared / (double)(result->freedom > 0 ? result->freedom : 1);
    int strange =
        result->explained < fit_explained || (variance == 1 && spread > fit_strange * fit_strange);
    result->end = !minimum ? PEND_FIT_STOPPED : strange ? PEND_FIT_STRANGE : PEND_FIT_CONVERGED;
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++)
            if (isnan(p->column[c].data[i])) fit->residual[i * p->columns + c] = NAN;
    fit->ready = 1;
    return PEND_OK;
}

/* ---- iterations */

/* puts the workspace to the window */
static enum pend_status fit_begin(struct pend_fit *fit, struct pend_error *error) {
    gsl_vector_view x = gsl_vector_view_array(fit->inner, (size_t)fit->problem.unknowns);
    fit->begun = 1, fit->here = 0;
    fit->status = PEND_OK;
    int failed = gsl_multifit_nlinear_init(&x.vector, &fit->fdf, fit->work);
    if (!failed && !fit->starved && fit->status == PEND_OK) return PEND_OK;
    if (fit->starved || fit->status == PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    if (error) *error = fit->failure;
    return fit->status;
}

static void fit_keep(struct pend_fit *fit) {
    const gsl_vector *x = gsl_multifit_nlinear_position(fit->work);
    for (int j = 0; j < fit->problem.unknowns; j++) fit->inner[j] = gsl_vector_get(x, (size_t)j);
}

enum pend_status pend_fit_step(struct pend_fit *fit, int *done, struct pend_error *error) {
    assert(pend_fit_valid(fit));
    const struct pend_fit_problem *p = &fit->problem;
    *done = fit->ready;
    if (fit->ready) return PEND_OK;
    if (!fit->begun) PEND_TRY(fit_begin(fit, error));
    int whole = fit->window == p->rows, why = 0;
    // the slope's is squared: it is of residuals that may be met exactly
    double tolerance = whole ? fit_fine : fit_rough;
    fit->result.iterations++, fit->here++;
    int status = gsl_multifit_nlinear_iterate(fit->work);
    if (fit->starved) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    fit_keep(fit);
    int used = fit->result.iterations >= p->iterations;
    int over = status || used || (!whole && fit->here >= FIT_ROUGH) ||
               gsl_multifit_nlinear_test(tolerance, tolerance * tolerance, 0, &why, fit->work) ==
                   GSL_SUCCESS;
    if (over && !whole && !used) PEND_TRY(fit_grow(fit, error));
    if (over && (whole || used)) PEND_TRY(fit_finish(fit, error));
    *done = fit->ready;
    return PEND_OK;
}

struct pend_fit_result pend_fit_result(const struct pend_fit *fit) {
    assert(pend_fit_valid(fit) && fit->ready);
    struct pend_fit_result result = fit->result;
    result.value = fit->value, result.error = fit->error, result.correlation = fit->correlation;
    result.residual = fit->residual, result.bounded = fit->bounded;
    result.direction = fit->direction;
    return result;
}

double pend_fit_progress(const struct pend_fit *fit) {
    double part = (double)fit->window / (double)fit->problem.rows;
    return fit->ready ? 1 : 0.9 * part;
}
