#include "core/fit/fit_verdict.h"

#include <assert.h>
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"

static int verdict_moves(const struct pend_fit *fit) {
    const struct pend_fit_problem *p = &fit->problem;
    int moves = 0;
    for (int c = 0; c < p->columns; c++) moves |= p->column[c].kind != PEND_FIT_MODE;
    return moves;
}

/* ---- outliers */

static int verdict_order(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* the median of the absolute residuals of a column, scaled to a standard deviation, at least the
 * given sigma */
static double verdict_column(const struct pend_fit *fit, int c, double room[]) {
    const struct pend_fit_column *column = &fit->problem.column[c];
    double size = 0;
    size_t count = 0;
    for (long i = 0; i < fit->problem.rows; i++) {
        if (isnan(column->data[i])) continue;
        size = fmax(size, fabs(column->data[i]));
        room[count++] = fabs(fit->residual[i * fit->problem.columns + c]);
    }
    if (!count) return INFINITY;
    qsort(room, count, sizeof *room, verdict_order);
    return fmax(1.4826 * room[count / 2], pend_fit_known(column) ? 1 : fit_known_best * size);
}

static enum pend_status verdict_spread(struct pend_fit *fit) {
    const struct pend_fit_problem *p = &fit->problem;
    double *room = malloc((size_t)p->rows * sizeof *room);
    long count, off = 0;
    if (!room) return PEND_NO_MEMORY;
    (void)pend_fit_state_squares(fit, p->rows, &count);
    for (int c = 0; c < p->columns; c++) fit->spread[c] = verdict_column(fit, c, room);
    free(room);
    // with normal noise, one data set in a hundred of this size has a larger residual
    fit->result.beyond = gsl_cdf_ugaussian_Qinv(0.005 / (double)count);
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++)
            off += fabs(fit->residual[i * p->columns + c]) > fit->result.beyond * fit->spread[c];
    if (off * FIT_OUTLIERS > count) fit->result.beyond = INFINITY, off = 0;
    fit->result.outliers = off;
    return PEND_OK;
}

/* ---- autocorrelation of the residuals */

/* lists the rows of a run in which a column was measured; returns their number */
static long verdict_rows(struct pend_fit *fit, int run, int c) {
    const struct pend_fit_problem *p = &fit->problem;
    long count = 0;
    for (long i = 0; i < p->rows; i++)
        if (pend_fit_run(p, i) == run && !isnan(p->column[c].data[i]))
            fit->model.first[count++] = i;
    return count;
}

/* the mean square of a column's residuals, 1 if all are 0 */
static double verdict_square(const struct pend_fit *fit, int c) {
    const struct pend_fit_problem *p = &fit->problem;
    double sum = 0;
    long count = 0;
    for (long i = 0; i < p->rows; i++) {
        double r = fit->residual[i * p->columns + c];
        if (!isnan(p->column[c].data[i])) sum += r * r, count++;
    }
    return sum > 0 ? sum / (double)count : 1;
}

/* computes the Durbin-Watson statistic and the autocorrelations over all series, each relative to
 * its own size */
static void verdict_run(struct pend_fit *fit) {
    const struct pend_fit_problem *p = &fit->problem;
    double lag[3] = {0, 0, 0}, steps = 0;
    long pairs = 0;
    for (int c = 0; c < p->columns; c++) {
        if (p->column[c].kind == PEND_FIT_MODE) continue;
        double square = verdict_square(fit, c);
        for (int run = 0; run < pend_fit_runs(p); run++) {
            long count = verdict_rows(fit, run, c);
            double last[2] = {0, 0};
            for (long i = 0; i < count; i++) {
                double r = fit->residual[fit->model.first[i] * p->columns + c];
                lag[0] += r * r / square;
                lag[1] += r * last[0] / square, lag[2] += r * last[1] / square;
                if (i) steps += (r - last[0]) * (r - last[0]) / square, pairs++;
                last[1] = last[0], last[0] = r;
            }
        }
    }
    fit->result.watson = pairs && lag[0] > 0 ? steps / lag[0] : NAN;
    for (int k = 0; k < 2; k++) fit->lag[k] = lag[0] > 0 ? lag[k + 1] / lag[0] : 0;
    fit->result.alike =
        pairs < FIT_PAIRS ? NAN : gsl_cdf_ugaussian_Q(fit->lag[0] * sqrt((double)pairs));
}

/* chi-squared and its degrees of freedom, without outliers if the loss is robust */
static double verdict_inliers(const struct pend_fit *fit, long *freedom) {
    const struct pend_fit_problem *p = &fit->problem;
    double sum = 0;
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++) {
            double r = fit->residual[i * p->columns + c];
            if (fabs(r) > fit->result.beyond * fit->spread[c] && p->loss)
                --*freedom;
            else
                sum += r * r;
        }
    return sum;
}

static void verdict_test(struct pend_fit *fit) {
    struct pend_fit_result *result = &fit->result;
    long freedom = result->freedom;
    double squares = verdict_inliers(fit, &freedom);
    assert(result->beyond > 0);
    verdict_run(fit);
    result->p_value = NAN;
    if (pend_fit_state_known(fit) && freedom > 0)
        result->p_value = gsl_cdf_chisq_Q(squares, (double)freedom);
}

/* ---- standard errors */

/* Adds J'VJ of a column in a run. The noise is an autoregression. Its filter is applied to the
 * slopes backwards in time; before the first row they are extrapolated until the filter's response
 * has decayed. */
static void verdict_meat(const struct pend_fit *fit, int c, long count, const double by[2],
                         double weight, double *last, double meat[]) {
    size_t q = (size_t)fit->problem.unknowns, columns = (size_t)fit->problem.columns;
    double *before = last + q, most = 0;
    memset(last, 0, 2 * q * sizeof *last);
    for (long i = count; i-- > -count;) {
        double size = 0;
        for (size_t j = 0; j < q; j++) {
            double own =
                i < 0 ? 0 : fit->slope[((size_t)fit->model.first[i] * columns + (size_t)c) * q + j];
            double next = own + by[0] * last[j] + by[1] * before[j];
            before[j] = last[j], last[j] = next;
            size = fmax(size, fabs(next * fit->size[j]));
        }
        most = fmax(most, size);
        if (i < 0 && !(size > 1e-6 * most)) return;
        for (size_t k = 0; k < q * q; k++) meat[k] += weight * last[k / q] * last[k % q];
    }
}

/* out = a b, of symmetric matrices */
static void verdict_product(size_t q, const double a[], const double b[], double out[]) {
    for (size_t k = 0; k < q * q; k++) {
        out[k] = 0;
        for (size_t i = 0; i < q; i++) out[k] += a[k / q * q + i] * b[i * q + k % q];
    }
}

/* computes the covariance for noise with the autocorrelation of the residuals; returns the fraction
 * of the measurements that remains to estimate the noise */
static double verdict_noise(struct pend_fit *fit, double *last, double meat[], double half[],
                            double covariance[]) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns;
    double a = fit->lag[0], b = fit->lag[1], taken = 0;
    double by[2] = {a * (1 - b) / (1 - a * a), (b - a * a) / (1 - a * a)}, none[2] = {0, 0};
    double step = 1 - by[0] * a - by[1] * b, squares, all = 0;
    long count;
    memset(meat, 0, q * q * sizeof *meat);
    squares = pend_fit_state_squares(fit, p->rows, &count) / (double)count;
    for (int c = 0; c < p->columns; c++) {
        double square = verdict_square(fit, c), mode = p->column[c].kind == PEND_FIT_MODE;
        for (int run = 0; run < pend_fit_runs(p); run++) {
            long rows = verdict_rows(fit, run, c);
            verdict_meat(fit, c, rows, mode ? none : by, (mode ? 1 : step) * square / squares, last,
                         meat);
        }
    }
    verdict_product(q, fit->covariance, meat, half);
    for (size_t j = 0; j < q; j++) taken += half[j * q + j];
    verdict_product(q, half, fit->covariance, covariance);
    double left = 1 - taken / (double)count;
    for (size_t k = 0; k < q * q; k++) all += covariance[k] *= squares / fmax(left, fit_freedom);
    fit->result.effective = fmin(1, (double)(count - fit->result.freedom) / taken) * (double)count;
    return isfinite(all) ? left : 0;
}

/* replaces the covariance by that for correlated residuals; no variance of an unknown decreases */
static enum pend_status verdict_alike(struct pend_fit *fit, double variance) {
    size_t q = (size_t)fit->problem.unknowns;
    assert(q >= 1 && variance >= 0);
    double *room = calloc(3 * q * q + 3 * q, sizeof *room);
    if (!room) return PEND_NO_MEMORY;
    double *noise = room + 2 * q * q, *wider = noise + q * q, *last = wider + q;
    double left = verdict_noise(fit, last, room, room + q * q, noise);
    // correct for slow components, with autocorrelations near 1, that the fit has absorbed
    for (int k = 0; k < 2 && left > fit_freedom; k++) fit->lag[k] = left * fit->lag[k] + 1 - left;
    left = verdict_noise(fit, last, room, room + q * q, noise);
    for (size_t j = 0; j < q; j++) {
        double old = variance * fit->covariance[j * q + j], fresh = noise[j * q + j];
        wider[j] = fresh > 0 && old > fresh ? sqrt(old / fresh) : 1;
        if (old > 0) fit->result.widened = fmax(fit->result.widened, wider[j] * sqrt(fresh / old));
    }
    for (size_t k = 0; k < q * q; k++)
        fit->covariance[k] = noise[k] * wider[k / q] * wider[k % q] / variance;
    if (left < fit_freedom) fit->result.widened = INFINITY;
    free(room);
    return PEND_OK;
}

static enum pend_status verdict_widen(struct pend_fit *fit, double variance) {
    struct pend_fit_result *result = &fit->result;
    size_t q = (size_t)fit->problem.unknowns;
    double spread = result->chi_squared / (double)result->freedom;
    long count;
    (void)pend_fit_state_squares(fit, fit->problem.rows, &count);
    result->widened = 1, result->effective = (double)count;
    if (result->explained > 1 - fit_exact || result->freedom < 1) return PEND_OK;
    // if the motion is wrong, the errors are meaningless
    int poor = !(result->explained > fit_explained) && !(result->p_value >= fit_level);
    if (poor && verdict_moves(fit)) result->widened = INFINITY;
    if (poor && verdict_moves(fit)) return PEND_OK;
    if (result->alike < fit_level) return verdict_alike(fit, variance);
    if (!(result->p_value < fit_level)) return PEND_OK;
    result->widened = sqrt(spread);
    for (size_t k = 0; k < q * q; k++) fit->covariance[k] *= spread;
    return PEND_OK;
}

/* ---- the whole verdict */

/* Undoes the transformation of the residuals by a loss. Returns the variance of a residual for
 * which the untransformed slopes give the covariance of an M-estimate. */
static double verdict_straight(struct pend_fit *fit) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns;
    double psi = 0, lean = 0, by;
    long count = 0;
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++) {
            double knee = p->knee ? p->knee[c] : 0, *r = &fit->residual[i * p->columns + c];
            if (isnan(p->column[c].data[i])) continue;
            double *slope = fit->slope + (size_t)(i * p->columns + c) * q;
            double bent = *r;
            struct fit_loss at = {0, 1, 1};
            if (knee > 0) {
                *r = fit_loss_straight(p->loss, knee, bent);
                (void)fit_loss_bend(p->loss, knee, *r, &by);
                at = fit_loss_at(p->loss, *r / knee * (*r / knee));
                for (size_t j = 0; j < q; j++) slope[j] /= by;
            }
            psi += *r * at.slope * *r * at.slope, lean += at.psi, count++;
        }
    lean /= (double)count;
    return psi / (double)(fit->result.freedom > 0 ? fit->result.freedom : 1) / (lean * lean);
}

static enum pend_fit_model verdict_model(const struct pend_fit *fit, int minimum) {
    const struct pend_fit_result *result = &fit->result;
    double p = result->p_value, part = result->explained;
    int poor = !(part > fit_explained);
    if (!minimum || (result->freedom < 1 && !poor)) return PEND_FIT_UNDECIDED;
    if (part > 1 - fit_exact) return PEND_FIT_ACCEPTED;
    if (p < fit_level || result->alike < fit_level) return PEND_FIT_REJECTED;
    // the data may be nothing but noise of the given size
    if (poor) return p >= fit_level ? PEND_FIT_UNDECIDED : PEND_FIT_REJECTED;
    int tested = p >= fit_level || isfinite(result->alike) ||
                 (part > fit_clear && verdict_moves(fit) && result->freedom >= FIT_FREEDOM);
    return tested ? PEND_FIT_ACCEPTED : PEND_FIT_UNDECIDED;
}

enum pend_status pend_fit_verdict(struct pend_fit *fit, double *variance, int minimum) {
    struct pend_fit_result *result = &fit->result;
    assert(fit->residual && *variance >= 0);
    if (fit->problem.loss) {
        fit->variance = *variance = verdict_straight(fit);
        PEND_TRY(pend_fit_state_free(fit));
    }
    PEND_TRY(verdict_spread(fit));
    verdict_test(fit);
    // outliers are undefined if the motion deviates from the data for several rows
    if (result->alike < fit_level) result->beyond = INFINITY, result->outliers = 0;
    result->model = verdict_model(fit, minimum);
    return verdict_widen(fit, *variance);
}
