#include "core/fit/fit_release.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"

/* half of the derivative of the sum of squares by an unknown */
static double release_slope(const struct pend_fit *fit, int j) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    size_t q = (size_t)fit->problem.unknowns;
    double sum = 0;
    for (size_t i = 0; i < m; i++) sum += fit->slope[i * q + (size_t)j] * fit->residual[i];
    return sum;
}

/* whether the sum of squares is no higher with an unknown at its bound; it is, lower */
static enum pend_status release_try(struct pend_fit *fit, size_t j, double residual[],
                                    double *squares, int *good) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t m = (size_t)p->rows * (size_t)p->columns;
    double sum = 0, before = fit->value[j];
    fit->value[j] = pend_fit_state_outer(fit, (int)j, fit->inner[j]);
    fit->result.evaluations++;
    enum pend_status status =
        pend_fit_model_at(&fit->model, fit->value, p->rows, residual, NULL, NULL);
    for (size_t i = 0; i < m && status == PEND_OK; i++) sum += residual[i] * residual[i];
    *good = status == PEND_OK && pend_fit_state_flat(fit, fmax(sum - *squares, 0), *squares);
    if (*good)
        *squares = fmin(sum, *squares);
    else
        fit->value[j] = before, fit->edge[j] = 0;
    return status == PEND_NO_MEMORY ? status : PEND_OK;
}

enum pend_status pend_fit_release_put(struct pend_fit *fit, double *squares, double variance,
                                      int *put) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns;
    enum pend_status status = PEND_OK;
    double *residual = malloc((size_t)p->rows * (size_t)p->columns * sizeof *residual);
    assert(variance >= 0 && *squares >= 0);
    *put = 0;
    if (!residual) return PEND_NO_MEMORY;
    for (size_t j = 0; j < q && status == PEND_OK; j++) {
        const struct pend_fit_unknown *u = &p->unknown[j];
        double slope = release_slope(fit, (int)j), bound = slope > 0 ? u->low : u->high;
        double gap = fabs(fit->value[j] - bound), square = fit->covariance[j * q + j];
        double step = fmax(fabs(slope) * square, 1e-3 * sqrt(variance * square));
        int good = 0;
        if (fit->edge[j] || !isfinite(bound) || slope == 0) continue;
        if (!fit_bounds_at(u, fit->value[j]) && !(gap <= step)) continue;
        fit->edge[j] = slope > 0 ? -1 : 1;
        status = release_try(fit, j, residual, squares, &good);
        *put += good;
    }
    free(residual);
    return status;
}

/* whether an unknown that is at a bound is at the low one */
static int release_low(const struct pend_fit_unknown *u, double value) {
    return !isfinite(u->high) || value - u->low < u->high - value;
}

enum pend_status pend_fit_release_let(struct pend_fit *fit, double *gain) {
    struct fit_told told;
    assert(fit->problem.unknowns >= 1);
    for (int j = 0; j < fit->problem.unknowns; j++) {
        double slope = fit->held[j] ? release_slope(fit, j) : 0;
        if (release_low(&fit->problem.unknown[j], fit->value[j]) ? slope < 0 : slope > 0)
            fit->held[j] = 0;
    }
    enum pend_status status = pend_fit_state_tell(fit, &told);
    if (status == PEND_OK) *gain = pend_fit_told_gain(&told);
    pend_fit_told_clear(&told);
    return status;
}

/* the inner number of a place inside, `step` from the bound, but not beyond the middle */
static double release_inside(const struct pend_fit_unknown *u, int low, double step) {
    double bound = low ? u->low : u->high, least = 1e-6 * fmax(fabs(bound), 1e-6);
    if (!(step > least)) step = least;
    if (isfinite(u->low) && isfinite(u->high)) step = fmin(step, 0.5 * (u->high - u->low));
    return fit_bounds_inner(u, low ? bound + step : bound - step);
}

int pend_fit_release_move(struct pend_fit *fit, int all, double variance) {
    size_t q = (size_t)fit->problem.unknowns;
    int moved = 0;
    assert(variance >= 0);
    for (size_t j = 0; j < q; j++) {
        const struct pend_fit_unknown *u = &fit->problem.unknown[j];
        int low = release_low(u, fit->value[j]);
        if (!fit->bounded[j] || (!all && fit->held[j])) continue;
        double square = fit->covariance[j * q + j], error = sqrt(variance * square);
        // alone it would go as far as its slope over its curvature
        double step = square > 0 ? fabs(release_slope(fit, (int)j)) * square : 0;
        double first = fabs(u->start - (low ? u->low : u->high));
        if (all) step = fmax(error, first);
        fit->edge[j] = 0;
        fit->inner[j] = release_inside(u, low, fmax(step, 0.1 * error));
        moved++;
    }
    return moved;
}

/* Modes change alike with two lengths, or masses, that begin alike, and no step would part them: a
 * value for the unknown to begin with that is a hundredth off for each twin before it. */
static double release_apart(const struct pend_fit *fit, size_t j) {
    const struct pend_fit_unknown *u = &fit->problem.unknown[j];
    double value = u->start;
    for (size_t i = 0; i < j && fit->model.modes; i++) {
        const struct pend_fit_unknown *other = &fit->problem.unknown[i];
        int twins =
            other->camera == u->camera && other->by.kind == u->by.kind && other->start == u->start;
        if (twins) value += 0.01 * u->start;
    }
    return u->low < value && value < u->high ? value : u->start;
}

enum pend_status pend_fit_release_begin(struct pend_fit *fit, long rows) {
    size_t q = (size_t)fit->problem.unknowns, m = (size_t)rows * (size_t)fit->problem.columns;
    int bounds = 0;
    long count;
    assert(rows >= 1 && rows <= fit->problem.rows);
    for (size_t j = 0; j < q; j++) {
        const struct pend_fit_unknown *u = &fit->problem.unknown[j];
        fit->value[j] = u->start;
        fit->inner[j] = fit_bounds_inner(u, release_apart(fit, j));
        bounds += u->start == u->low || u->start == u->high;
    }
    if (!bounds) return PEND_OK;
    fit->result.evaluations++;
    enum pend_status status =
        pend_fit_model_at(&fit->model, fit->value, rows, fit->residual, fit->slope, NULL);
    if (status == PEND_NO_MEMORY) return status;
    double squares = status == PEND_OK ? pend_fit_state_squares(fit, rows, &count) : 0;
    for (size_t j = 0; j < q; j++) {
        const struct pend_fit_unknown *u = &fit->problem.unknown[j];
        double told = 0;
        if (u->start != u->low && u->start != u->high) continue;
        for (size_t i = 0; i < m && status == PEND_OK; i++)
            told += fit->slope[i * q + j] * fit->slope[i * q + j];
        double step = told > 0 ? sqrt(squares / ((double)count * told)) : 0;
        fit->inner[j] = release_inside(u, u->start == u->low, step > 0 ? step : 1e-3);
    }
    return PEND_OK;
}
