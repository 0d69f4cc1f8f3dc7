#include "core/fit/fit_release.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"

/* half of the derivative of the sum of squares of the given residuals with respect to an unknown */
static double release_slope(const struct pend_fit *fit, const double residual[], int j) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    size_t q = (size_t)fit->problem.unknowns;
    double sum = 0;
    for (size_t i = 0; i < m; i++) sum += fit->slope[i * q + (size_t)j] * residual[i];
    return sum;
}

/* A step of all unknowns within their bounds; one block of memory. q unknowns. */
struct release {
    double *left;     /* q x q: covariance of the unknowns that have not reached a bound */
    double *step;     /* q: the step */
    double *slope;    /* q: half of the derivatives of the sum of squares */
    double *residual; /* one number per measurement */
    signed char *at;  /* q flags: -1 at the low bound, 1 at the high bound, 0 at neither */
};

static enum pend_status release_new(struct release *r, const struct pend_fit *fit) {
    size_t q = (size_t)fit->problem.unknowns;
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    r->left = malloc((q * q + 2 * q + m) * sizeof *r->left + q);
    if (!r->left) return PEND_NO_MEMORY;
    r->step = r->left + q * q, r->slope = r->step + q, r->residual = r->slope + q;
    r->at = (signed char *)(void *)(r->residual + m);
    memcpy(r->left, fit->covariance, q * q * sizeof *r->left);
    for (size_t j = 0; j < q; j++) r->slope[j] = release_slope(fit, fit->residual, (int)j);
    for (size_t j = 0; j < q; j++) {
        r->step[j] = 0, r->at[j] = 0;
        for (size_t i = 0; i < q; i++) r->step[j] -= r->left[j * q + i] * r->slope[i];
    }
    return PEND_OK;
}

/* Returns the step of an unknown to its bound if its own step reaches the bound or comes within a
 * thousandth of the standard error; NaN if no bound is reached. */
static double release_reached(const struct pend_fit *fit, const struct release *r, size_t j,
                              double variance) {
    const struct pend_fit_unknown *u = &fit->problem.unknown[j];
    double square = r->left[j * (size_t)fit->problem.unknowns + j];
    double low = u->low - fit->value[j], high = u->high - fit->value[j];
    double near = 1e-3 * sqrt(variance * fmax(square, 0));
    if (r->at[j] || !(square > 0)) return NAN;
    if (fit->edge[j]) return 0;
    if (r->step[j] - near <= low) return low;
    return r->step[j] + near >= high ? high : NAN;
}

/* Limits the step to the bounds: an unknown that reaches one is fixed there, the nearest first, and
 * the others take the optimal step under that constraint. Returns how many unknowns newly reached a
 * bound. */
static int release_hold(const struct pend_fit *fit, struct release *r, double variance) {
    size_t q = (size_t)fit->problem.unknowns, which;
    int put = 0;
    do {
        double nearest = INFINITY, to = 0;
        which = q;
        for (size_t j = 0; j < q; j++) {
            double bound = release_reached(fit, r, j, variance);
            double part = bound == 0 ? 0 : fabs(bound) / (fabs(bound) + fabs(r->step[j]));
            if (part < nearest) nearest = part, which = j, to = bound;
        }
        if (which == q) break;
        double own = r->left[which * q + which], more = to - r->step[which];
        int low = fit->edge[which] ? fit->edge[which] < 0
                                   : to == fit->problem.unknown[which].low - fit->value[which];
        r->at[which] = low ? -1 : 1, put += !fit->edge[which];
        for (size_t i = 0; i < q; i++) r->step[i] += r->left[i * q + which] / own * more;
        for (size_t i = 0; i < q;
             i++) // the row and the column of the fixed unknown are not changed
            for (size_t j = 0; j < q && i != which; j++)
                if (j != which)
                    r->left[i * q + j] -= r->left[i * q + which] * r->left[which * q + j] / own;
        for (size_t i = 0; i < q; i++) r->left[i * q + which] = r->left[which * q + i] = 0;
    } while (which < q);
    return put;
}

/* the decrease of the sum of squares that the slopes predict for the step */
static double release_foretold(const struct pend_fit *fit, const struct release *r) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    size_t q = (size_t)fit->problem.unknowns;
    double gain = 0;
    for (size_t i = 0; i < m; i++) {
        double change = 0;
        for (size_t j = 0; j < q; j++) change += fit->slope[i * q + j] * r->step[j];
        gain -= change * (2 * fit->residual[i] + change);
    }
    return gain;
}

/* accepts the current values; unknowns whose full step reaches a bound are fixed there */
static void release_take(struct pend_fit *fit, const struct release *r, int whole) {
    assert(whole == 0 || whole == 1);
    for (int j = 0; j < fit->problem.unknowns; j++) {
        if (whole && r->at[j]) fit->edge[j] = r->at[j];
        if (!fit->edge[j])
            fit->inner[j] = fit_bounds_inner(&fit->problem.unknown[j], fit->value[j]);
    }
}

/* Takes the fraction `part` of the step, unless the sum of squares is higher there. */
static enum pend_status release_try(struct pend_fit *fit, const struct release *r, double part,
                                    double *squares, int *good) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t m = (size_t)p->rows * (size_t)p->columns;
    int whole = part == 1;
    double sum = 0;
    assert(part > 0 && part <= 1);
    for (int j = 0; j < p->unknowns; j++) {
        fit->value[j] += part * r->step[j];
        if (whole && r->at[j])
            fit->value[j] = r->at[j] < 0 ? p->unknown[j].low : p->unknown[j].high;
    }
    fit->result.evaluations++;
    enum pend_status status =
        pend_fit_model_at(&fit->model, fit->value, p->rows, r->residual, NULL, NULL);
    for (size_t i = 0; i < m && status == PEND_OK; i++) sum += r->residual[i] * r->residual[i];
    *good = status == PEND_OK && pend_fit_state_flat(fit, fmax(sum - *squares, 0), *squares);
    if (*good) release_take(fit, r, whole), *squares = fmin(sum, *squares);
    for (int j = 0; j < p->unknowns && !*good; j++)
        fit->value[j] = pend_fit_state_outer(fit, j, fit->inner[j]);
    return status == PEND_NO_MEMORY ? status : PEND_OK;
}

enum pend_status pend_fit_release_put(struct pend_fit *fit, double *squares, double variance,
                                      int *put) {
    struct release r;
    double before = *squares;
    int good = 0;
    assert(variance >= 0 && *squares >= 0);
    *put = 0;
    PEND_TRY(release_new(&r, fit));
    int bounds = release_hold(fit, &r, variance);
    int flat = pend_fit_state_flat(fit, fmax(release_foretold(fit, &r), 0), *squares);
    enum pend_status status = PEND_OK;
    for (double part = 1; part > 0.01 && !good && (bounds || !flat); part /= 4) {
        if (part < 1 && flat) break;
        status = release_try(fit, &r, part, squares, &good);
        if (status != PEND_OK) break;
        if (good)
            *put = (bounds && part == 1) || !pend_fit_state_flat(fit, before - *squares, *squares);
    }
    free(r.left);
    return status;
}

static int release_low(const struct pend_fit_unknown *u, double value) {
    return !isfinite(u->high) || value - u->low < u->high - value;
}

enum pend_status pend_fit_release_let(struct pend_fit *fit, double *gain) {
    struct fit_told told;
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    int count = 0;
    assert(fit->problem.unknowns >= 1);
    double *rest = malloc(m * sizeof *rest);
    if (!rest) return PEND_NO_MEMORY;
    enum pend_status status = pend_fit_state_tell(fit, &told);
    if (status == PEND_OK) pend_fit_told_rest(&told, m, fit->residual, rest);
    // a fixed unknown is judged by its own slope, because the others do not move
    for (int j = 0; j < fit->problem.unknowns && status == PEND_OK; j++) {
        double slope = fit->held[j] ? release_slope(fit, rest, j) : 0;
        int in = release_low(&fit->problem.unknown[j], fit->value[j]) ? slope < 0 : slope > 0;
        if (in) fit->held[j] = 0, count++;
    }
    free(rest);
    if (count) {
        pend_fit_told_clear(&told);
        status = pend_fit_state_tell(fit, &told);
    }
    if (status == PEND_OK) *gain = pend_fit_told_gain(&told);
    pend_fit_told_clear(&told);
    return status;
}

/* the inner number of a point `step` inside the bound, at most of the middle between the bounds */
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
        // for one unknown alone, the step is slope over curvature
        double step = square > 0 ? fabs(release_slope(fit, fit->residual, (int)j)) * square : 0;
        double first = fabs(u->start - (low ? u->low : u->high));
        if (all) step = fmax(error, first);
        fit->edge[j] = 0;
        fit->inner[j] = release_inside(u, low, fmax(step, 0.1 * error));
        moved++;
    }
    return moved;
}

/* Frequencies depend equally on two lengths, or masses, with equal initial values, so no step would
 * separate them. Returns an initial value that differs by a hundredth for each preceding equal
 * unknown. */
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

/* Initial distance of an unknown from its bound: its uncertainty according to the first rows. Data
 * that do not depend on the unknown, for example on friction at rest, give no distance. */
static double release_unknown(const struct pend_fit *fit, size_t j, size_t m, double squares,
                              long count) {
    size_t q = (size_t)fit->problem.unknowns;
    double told = 0, least = fit_rounding * fit_rounding * pend_fit_state_size(fit);
    for (size_t i = 0; i < m; i++) told += fit->slope[i * q + j] * fit->slope[i * q + j];
    double step = count && told > least ? sqrt(squares / ((double)count * told)) : 0;
    return step > 0 ? step : fit_rough;
}

enum pend_status pend_fit_release_begin(struct pend_fit *fit, long rows) {
    size_t q = (size_t)fit->problem.unknowns, m = (size_t)rows * (size_t)fit->problem.columns;
    int bounds = 0;
    long count = 0;
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
        if (u->start == u->low || u->start == u->high)
            fit->inner[j] =
                release_inside(u, u->start == u->low, release_unknown(fit, j, m, squares, count));
    }
    return PEND_OK;
}
