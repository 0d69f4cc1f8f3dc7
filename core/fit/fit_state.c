#include "core/fit/fit_state.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"

/* The scale of an unknown: its value; if that is nearly 0, its start; if that is too, 1. A value
 * close to 0 would be too small a scale next to other unknowns that the data cannot distinguish
 * from it. */
static double fit_measure(const struct pend_fit *fit, int j) {
    double value = fabs(fit->value[j]), start = fabs(fit->problem.unknown[j].start);
    return value > fmax(1e-6, 0.03 * start) ? value : start > 1e-6 ? start : 1;
}

double pend_fit_state_outer(const struct pend_fit *fit, int j, double inner) {
    const struct pend_fit_unknown *u = &fit->problem.unknown[j];
    assert(j >= 0 && j < fit->problem.unknowns);
    if (fit->edge[j]) return fit->edge[j] < 0 ? u->low : u->high;
    return fit_bounds_outer(u, inner);
}

enum pend_status pend_fit_state_wild(const struct pend_fit *fit, enum pend_status status,
                                     struct pend_error *error) {
    const char *where = fit->result.iterations > 1 ? "the values that the search reached"
                                                   : "the given start values";
    if (status == PEND_OK || status == PEND_NO_MEMORY || !error) return status;
    if (status != PEND_TOO_MANY_STEPS) {
        struct pend_error why = *error;
        return pend_fail(error, status, why.arm, why.time,
                         "with %s no motion can be computed: %.120s. Give other start values",
                         where, why.text);
    }
    return pend_fail(
        error, status, -1, 0,
        "with %s the motion is too fast, too chaotic or too strongly damped: it needs more than "
        "%ld steps to reach the last measurement. Give other start values, such as a lower rate, "
        "larger lengths and masses or a larger \"speed\" of friction, give the unknowns a \"low\" "
        "and a \"high\", or use fewer rows",
        where, fit->problem.step_cap);
}

enum pend_status pend_fit_state_lost(enum pend_status status, struct pend_error *error) {
    assert(status != PEND_OK);
    if (status == PEND_NO_MEMORY) return pend_fail(error, status, -1, 0, "no memory for a fit");
    return pend_fail(
        error, status, -1, 0,
        "the derivatives of the motion with respect to the unknowns are too large for a double. "
        "Give other start values, give the unknowns a \"low\" and a \"high\", or use fewer rows");
}

enum pend_status pend_fit_state_look(struct pend_fit *fit, long rows, struct pend_error *error) {
    assert(rows >= 1 && rows <= fit->problem.rows);
    fit->result.evaluations++;
    fit->variance = 0;
    for (int j = 0; j < fit->problem.unknowns; j++) {
        fit->value[j] = pend_fit_state_outer(fit, j, fit->inner[j]);
        fit->held[j] = (unsigned char)fit_bounds_at(&fit->problem.unknown[j], fit->value[j]);
        fit->size[j] = fit_measure(fit, j);
    }
    enum pend_status status =
        pend_fit_model_at(&fit->model, fit->value, rows, fit->residual, fit->slope, error);
    return pend_fit_state_wild(fit, status, error);
}

double pend_fit_state_squares(const struct pend_fit *fit, long rows, long *count) {
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

int pend_fit_state_known(const struct pend_fit *fit) {
    int known = 1;
    for (int c = 0; c < fit->problem.columns; c++) known &= pend_fit_known(&fit->problem.column[c]);
    return known;
}

double pend_fit_state_variance(const struct pend_fit *fit, double squares, long freedom) {
    return pend_fit_state_known(fit) || freedom < 1 ? 1 : squares / (double)freedom;
}

/* the effect of rounding on all data, in standard deviations; smaller effects do not count */
static double state_rounding(const struct pend_fit *fit) {
    double sum = 0;
    for (int c = 0; c < fit->problem.columns; c++) {
        const struct pend_fit_column *column = &fit->problem.column[c];
        for (long i = 0; i < fit->problem.rows; i++) {
            double x = column->kind == PEND_FIT_PHI ? 1 : fabs(column->data[i]);
            if (isnan(column->data[i])) continue;
            sum += pow(x / pend_fit_sigma(column, i), 2);
        }
    }
    return fit_rounding * sqrt(sum);
}

enum pend_status pend_fit_state_tell(const struct pend_fit *fit, struct fit_told *told) {
    size_t m = (size_t)fit->problem.rows * (size_t)fit->problem.columns;
    PEND_TRY(pend_fit_told_init(told, m, fit->problem.unknowns, fit->slope, fit->residual,
                                fit->held, fit->size));
    if (fit->variance > 0) pend_fit_told_sure(told, fit->variance);
    told->least = fmax(told->least, state_rounding(fit));
    return PEND_OK;
}

/* Computes the covariance with the `held` unknowns fixed. untold: out, the number of null
 * directions among the others. */
static enum pend_status state_covariance(struct pend_fit *fit, int *untold) {
    struct fit_told told;
    enum pend_status status = pend_fit_state_tell(fit, &told);
    *untold = 0;
    for (int d = 0; d < fit->problem.unknowns && status == PEND_OK; d++)
        *untold += !pend_fit_told_is(&told, d) - (fit->held[d] != 0);
    if (status == PEND_OK) pend_fit_told_covariance(&told, fit->covariance);
    pend_fit_told_clear(&told);
    return status;
}

enum pend_status pend_fit_state_free(struct pend_fit *fit) {
    int untold, without, bounds = 0;
    size_t q = (size_t)fit->problem.unknowns;
    memset(fit->held, 0, q);
    PEND_TRY(state_covariance(fit, &untold));
    for (size_t j = 0; j < q; j++) {
        int at = fit_bounds_at(&fit->problem.unknown[j], fit->value[j]);
        fit->bounded[j] = fit->held[j] = (unsigned char)at, bounds += at;
    }
    if (!untold || !bounds) return PEND_OK;
    PEND_TRY(state_covariance(fit, &without));
    if (without < untold) return PEND_OK; // a fixed unknown is not distinguishable
    memset(fit->held, 0, q);
    PEND_TRY(state_covariance(fit, &untold));
    memcpy(fit->held, fit->bounded, q);
    return PEND_OK;
}

/* The mean of a column; for angles the direction of the mean, because whole turns do not count. A
 * frequency is a single number, whose mean is meaningless. */
static double state_mean(const struct pend_fit *fit, const struct pend_fit_column *column) {
    double sum = 0, weight = 0, re = 0, im = 0;
    for (long i = 0; i < fit->problem.rows; i++) {
        double x = column->data[i], own = pow(pend_fit_sigma(column, i), -2);
        if (isnan(x)) continue;
        sum += own * x, weight += own;
        if (column->kind == PEND_FIT_PHI) re += own * cos(x), im += own * sin(x);
    }
    if (column->kind == PEND_FIT_MODE || !(weight > 0)) return 0;
    return column->kind == PEND_FIT_PHI ? atan2(im, re) : sum / weight;
}

double pend_fit_state_total(const struct pend_fit *fit) {
    double sum = 0;
    for (int c = 0; c < fit->problem.columns; c++) {
        const struct pend_fit_column *column = &fit->problem.column[c];
        double mean = state_mean(fit, column);
        for (long i = 0; i < fit->problem.rows; i++) {
            double x = column->data[i], gap = x - mean, size = pend_fit_sigma(column, i);
            if (isnan(x)) continue;
            if (column->kind == PEND_FIT_PHI)
                x = remainder(x, 2 * M_PI), gap = remainder(gap, 2 * M_PI);
            // the instants of passages are spread over half a swing
            if (column->kind == PEND_FIT_PASSAGE)
                x = 0, gap = M_PI / sqrt(12) / fit->model.seen.swing;
            sum += pow(size, -2) * (gap * gap + fit_exact * x * x);
        }
    }
    return sum;
}

double pend_fit_state_size(const struct pend_fit *fit) {
    double sum = 0;
    for (int c = 0; c < fit->problem.columns; c++) {
        const struct pend_fit_column *column = &fit->problem.column[c];
        for (long i = 0; i < fit->problem.rows; i++) {
            double x = column->data[i];
            if (column->kind == PEND_FIT_PHI) x = remainder(x, 2 * M_PI);
            if (!isnan(x)) sum += pow(x / pend_fit_sigma(column, i), 2);
        }
    }
    return sum;
}

int pend_fit_state_flat(const struct pend_fit *fit, double gain, double squares) {
    assert(gain >= 0);
    double least = fit_minimum * squares + fit_step * fit->variance;
    if (pend_fit_state_known(fit)) return gain <= least + fit_minimum;
    double motion = fmin(pow(fit_loose * fit->problem.rtol, 2), fit_exact);
    return gain <= least + motion * pend_fit_state_size(fit);
}
