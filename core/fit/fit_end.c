#include "core/fit/fit_end.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_constants.h"
#include "core/fit/fit_release.h"
#include "core/fit/fit_verdict.h"

/* ---- Second derivatives of the sum of squares, if its slopes do not decide whether that is a
 * minimum. Example: the closest match to frequencies that no pendulum has is a pendulum with two
 * equal values. There the frequencies depend on neither value to first order, and a step of any
 * size seems to gain. Value, residual, slope and held of the fit are restored. */

/* memory of both functions: q values, two gradients, a direction, q flags */
struct curve {
    double *value, *gradient[2], *along;
    unsigned char *held;
};

static enum pend_status curve_init(struct curve *curve, const struct pend_fit *fit) {
    size_t q = (size_t)fit->problem.unknowns;
    *curve = (struct curve){.value = malloc(4 * q * sizeof(double)), .held = malloc(q)};
    if (!curve->value || !curve->held) return PEND_NO_MEMORY;
    curve->gradient[0] = curve->value + q, curve->gradient[1] = curve->value + 2 * q;
    curve->along = curve->value + 3 * q;
    memcpy(curve->held, fit->held, q);
    return PEND_OK;
}

static enum pend_status curve_clear(struct curve *curve, struct pend_fit *fit,
                                    enum pend_status status) {
    double variance = fit->variance;
    if (status == PEND_OK) {
        status = pend_fit_state_look(fit, fit->problem.rows, NULL);
        fit->variance = variance;
        memcpy(fit->held, curve->held, (size_t)fit->problem.unknowns);
    }
    free(curve->value);
    free(curve->held);
    return status;
}

/* half of the derivatives of the sum of squares with respect to relative changes; 0 for fixed
 * unknowns */
static void curve_slopes(const struct pend_fit *fit, double gradient[]) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    size_t q = (size_t)fit->problem.unknowns;
    for (size_t j = 0; j < q; j++) {
        double sum = 0;
        for (size_t i = 0; i < m && !fit->held[j]; i++)
            sum += fit->slope[i * q + j] * fit->residual[i];
        gradient[j] = sum * fit->size[j];
    }
}

/* the derivative of the slopes along a direction, into the first gradient; `there` = 0 if the
 * motion cannot be computed */
static enum pend_status curve_change(struct curve *curve, struct pend_fit *fit,
                                     const double direction[], int *there) {
    int q = fit->problem.unknowns;
    assert(q >= 1);
    for (int side = 0; side < 2; side++) {
        double step = side ? -fit_curve_step : fit_curve_step;
        for (int j = 0; j < q; j++)
            curve->value[j] = fit->value[j] + step * fit->size[j] * direction[j];
        fit->result.evaluations++;
        enum pend_status status = pend_fit_model_at(&fit->model, curve->value, fit->problem.rows,
                                                    fit->residual, fit->slope, NULL);
        if (status == PEND_NO_MEMORY) return status;
        *there = status == PEND_OK;
        if (!*there) return PEND_OK;
        curve_slopes(fit, curve->gradient[side]);
    }
    for (int j = 0; j < q; j++)
        curve->gradient[0][j] =
            (curve->gradient[0][j] - curve->gradient[1][j]) / (2 * fit_curve_step);
    return PEND_OK;
}

/* Half of the second derivative of the sum of squares along a direction of relative changes;
 * divided by the variance of a residual it is 1 / (standard error)^2. 0 if the motion cannot be
 * computed. */
static enum pend_status curve_along(struct pend_fit *fit, const double direction[], double *bend) {
    struct curve curve;
    int there = 0;
    assert(fit->problem.unknowns >= 1 && direction);
    *bend = 0;
    enum pend_status status = curve_init(&curve, fit);
    if (status == PEND_OK) status = curve_change(&curve, fit, direction, &there);
    for (int j = 0; j < fit->problem.unknowns && there; j++)
        *bend += direction[j] * curve.gradient[0][j];
    return curve_clear(&curve, fit, status);
}

/* the derivative of the slopes along every identifiable direction; `there` = 0 if the motion cannot
 * be computed */
static enum pend_status curve_bend(struct curve *curve, struct pend_fit *fit,
                                   const struct fit_told *told, double bend[], int *there) {
    int q = told->q;
    for (int d = 0; d < q && *there; d++) {
        if (!pend_fit_told_is(told, d)) continue;
        for (int j = 0; j < q; j++) curve->along[j] = told->direction[j * q + d];
        PEND_TRY(curve_change(curve, fit, curve->along, there));
        for (int j = 0; j < q && *there; j++) bend[j * q + d] = curve->gradient[0][j];
    }
    return PEND_OK;
}

/* The decrease of the sum of squares by a Newton step; infinite if this is not a minimum of the
 * unknowns that are not fixed. covariance: out if the step is finite, for residuals of variance 1;
 * NULL if not needed. */
static enum pend_status curve_gain(struct pend_fit *fit, double *gain, double covariance[]) {
    struct curve curve;
    struct fit_told told;
    size_t q = (size_t)fit->problem.unknowns;
    long count;
    int there = 1;
    double *bend = calloc(q * q, sizeof *bend);
    double error = fit_loose * fit->problem.rtol / fit_curve_step;
    double rest = sqrt(pend_fit_state_squares(fit, fit->problem.rows, &count));
    *gain = INFINITY;
    enum pend_status status = pend_fit_state_tell(fit, &told);
    enum pend_status made = curve_init(&curve, fit);
    if (!bend || made != PEND_OK) status = PEND_NO_MEMORY;
    if (status == PEND_OK) status = curve_bend(&curve, fit, &told, bend, &there);
    if (there && status == PEND_OK)
        status = pend_fit_told_newton(&told, bend, error * told.value[0] * rest,
                                      error * sqrt(pend_fit_state_size(fit)), gain, covariance);
    free(bend);
    pend_fit_told_clear(&told);
    return curve_clear(&curve, fit, status);
}

/* ---- the result */

/* whether an unknown has a component in a direction that is not identifiable */
static int end_blind(const struct pend_fit *fit, size_t j) {
    int blind = 0;
    for (int d = 0; d < fit->result.blind; d++)
        blind |= fabs(fit->direction[(size_t)(d * fit->problem.unknowns) + j]) > 1e-3;
    return blind;
}

static void end_errors(struct pend_fit *fit, double variance) {
    size_t q = (size_t)fit->problem.unknowns;
    int sized =
        (pend_fit_state_known(fit) || fit->result.freedom > 0) && isfinite(fit->result.widened);
    for (size_t j = 0; j < q; j++) {
        fit->error[j] = sized ? sqrt(variance * fit->covariance[j * q + j]) : NAN;
        if (end_blind(fit, j)) fit->error[j] = INFINITY;
        if (fit->bounded[j] && !(fit->error[j] > 0)) fit->error[j] = NAN;
    }
    for (size_t i = 0; i < q; i++)
        for (size_t j = 0; j < q; j++) {
            double size = sqrt(fit->covariance[i * q + i]) * sqrt(fit->covariance[j * q + j]);
            int known = isfinite(fit->error[i]) && isfinite(fit->error[j]) && size > 0;
            fit->correlation[i * q + j] = i == j ? 1 : 0;
            if (known && i != j) fit->correlation[i * q + j] = fit->covariance[i * q + j] / size;
        }
}

/* last row of a run up to which the mean square of adjacent residuals is at most six variances */
static double end_follows(const struct pend_fit *fit, int run, double variance) {
    enum { TOGETHER = 8 };
    const struct pend_fit_problem *p = &fit->problem;
    double last = NAN, until = NAN, sum = 0;
    long count = 0, together = 0;
    for (long i = 0; i < p->rows; i++) {
        if (pend_fit_run(p, i) != run) continue;
        for (int c = 0; c < p->columns; c++) {
            double r = fit->residual[i * p->columns + c];
            if (isnan(p->column[c].data[i])) continue;
            sum += r * r, count++;
        }
        until = p->t[i];
        if (++together < TOGETHER) continue;
        if (sum > 6 * variance * (double)count) return last;
        last = until, sum = 0, count = together = 0;
    }
    return sum > 6 * variance * (double)count ? last : until;
}

/* Determines the time up to which each run fits the data: the run's end if the model is accepted.
 * Without a sigma, residuals are limited by `most`: a tenth of the data's own size, if the motion
 * explains that much. */
static void end_follow(struct pend_fit *fit, double variance, double most) {
    int known = pend_fit_state_known(fit);
    double far = known ? 1 : fmax(variance, most / 600);
    if (fit->result.model == PEND_FIT_ACCEPTED) far = INFINITY;
    for (int run = 0; run < pend_fit_runs(&fit->problem); run++)
        fit->follows[run] =
            known || fit->result.explained > fit_clear ? end_follows(fit, run, far) : NAN;
}

/* returns whether residuals of adjacent rows are correlated, so that they are not noise */
static int end_drifts(const struct pend_fit *fit) {
    const struct pend_fit_problem *p = &fit->problem;
    double common = 0, all = 0;
    long pairs = 0;
    for (long i = 1; i < p->rows; i++) {
        if (pend_fit_run(p, i) != pend_fit_run(p, i - 1)) continue;
        for (int c = 0; c < p->columns; c++) {
            const double *data = p->column[c].data + i, *r = fit->residual + i * p->columns + c;
            if (isnan(data[0]) || isnan(data[-1])) continue;
            double before = r[-p->columns];
            common += r[0] * before, all += (r[0] * r[0] + before * before) / 2, pairs++;
        }
    }
    return pairs >= FIT_PAIRS && common > fit_common * all;
}

/* how the fit ended; all other members of the result are set */
static enum pend_fit_end end_kind(const struct pend_fit *fit, int minimum) {
    const struct pend_fit_result *result = &fit->result;
    double spread = result->chi_squared / (double)(result->freedom > 0 ? result->freedom : 1);
    int known = pend_fit_state_known(fit);
    int strange = result->explained < fit_explained ||
                  (known && spread > fit_strange * fit_strange) ||
                  (!known && result->explained < fit_clear && end_drifts(fit));
    if (result->away >= 0) return PEND_FIT_AWAY;
    if (!minimum || fit->window < fit->problem.rows) return PEND_FIT_STOPPED;
    return strange ? PEND_FIT_STRANGE : PEND_FIT_CONVERGED;
}

/* the index of an unknown that diverged; -1 = none */
static int end_away(const struct pend_fit *fit) {
    size_t q = (size_t)fit->problem.unknowns;
    for (size_t j = 0; j < q; j++) {
        const struct pend_fit_unknown *u = &fit->problem.unknown[j];
        double bound = fit->value[j] > 0 ? u->high : u->low;
        if (end_blind(fit, j) && isinf(bound) &&
            fabs(fit->value[j]) > fit_away * fmax(fabs(u->start), 1e-3))
            return (int)j;
    }
    return -1;
}

/* A direction with zero slope still counts as identifiable if its second derivative is large
 * enough: a relative step of 1 must change the sum of squares by more than the variance. Adds the
 * number of such directions to *found. */
static enum pend_status end_bends(struct pend_fit *fit, double variance,
                                  const struct fit_told *told, long *found) {
    struct pend_fit_result *result = &fit->result;
    size_t q = (size_t)fit->problem.unknowns;
    double total = pend_fit_state_total(fit), noise = 1e-5 * told->value[0];
    if (!(result->chi_squared > fit_exact * total)) return PEND_OK;
    for (int d = 0; d < result->blind;) {
        double bend, square = 0, *direction = fit->direction + (size_t)d * q;
        PEND_TRY(curve_along(fit, direction, &bend));
        for (size_t j = 0; j < q; j++) square += direction[j] * direction[j];
        if (!(bend > fmax(variance, noise * sqrt(result->chi_squared) * square))) {
            d++;
            continue;
        }
        for (size_t i = 0; i < q * q; i++)
            fit->covariance[i] +=
                direction[i / q] * fit->size[i / q] * direction[i % q] * fit->size[i % q] / bend;
        result->blind--, ++*found;
        memmove(direction, direction + q, (size_t)(result->blind - d) * q * sizeof *direction);
    }
    return PEND_OK;
}

/* determines which unknowns are identifiable, and whether the end of the search is a minimum */
static enum pend_status end_told(struct pend_fit *fit, double variance, long *found, int *minimum) {
    struct fit_told told;
    double gain = 0;
    *found = 0, *minimum = 0;
    PEND_TRY(pend_fit_state_free(fit));
    enum pend_status status = pend_fit_state_tell(fit, &told);
    for (int d = 0; d < told.q && status == PEND_OK; d++) *found += pend_fit_told_is(&told, d);
    if (status == PEND_OK)
        fit->result.blind =
            pend_fit_told_blind(&told, fit->bounded, PEND_FIT_BLIND, fit->direction);
    if (status == PEND_OK) status = pend_fit_release_let(fit, &gain);
    // a restarted search has not found the decrease that was predicted, so a decrease below a
    // fraction of the variance counts as none
    double fall = fit->anew ? fit_fall * variance : 0;
    if (status == PEND_OK)
        *minimum = pend_fit_state_flat(fit, fmax(gain - fall, 0), fit->result.chi_squared);
    // along a direction of nearly zero slope, the slopes may predict a decrease that does not exist
    if (status == PEND_OK && !*minimum && fit->problem.unknowns <= FIT_BENDS) {
        int free = !memchr(fit->bounded, 1, (size_t)fit->problem.unknowns);
        status = curve_gain(fit, &gain, free ? fit->covariance : NULL);
        *minimum = pend_fit_state_flat(fit, gain, fit->result.chi_squared);
    }
    if (status == PEND_OK) status = end_bends(fit, variance, &told, found);
    pend_fit_told_clear(&told);
    return status;
}

enum pend_status pend_fit_end(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    struct pend_fit_result *result = &fit->result;
    long count, found;
    int minimum;
    PEND_TRY(pend_fit_state_look(fit, p->rows, error));
    result->chi_squared = pend_fit_state_squares(fit, p->rows, &count);
    double before = pend_fit_state_variance(fit, result->chi_squared, count - p->unknowns);
    fit->variance = before;
    enum pend_status status = end_told(fit, before, &found, &minimum);
    if (status != PEND_OK) return pend_fit_state_lost(status, error);
    result->away = end_away(fit);
    result->freedom = count - found;
    double variance = pend_fit_state_variance(fit, result->chi_squared, result->freedom);
    double total = pend_fit_state_total(fit);
    result->explained = total > 0 ? 1 - result->chi_squared / total : 0;
    result->end = end_kind(fit, minimum);
    status = pend_fit_verdict(fit, &variance,
                              result->end == PEND_FIT_CONVERGED || result->end == PEND_FIT_STRANGE);
    if (status != PEND_OK) return pend_fit_state_lost(status, error);
    end_errors(fit, variance);
    end_follow(fit, variance, total / (double)count);
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++)
            if (isnan(p->column[c].data[i])) fit->residual[i * p->columns + c] = NAN;
    fit->ready = 1;
    return PEND_OK;
}
