#include "core/fit/fit_curve.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_constants.h"

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

/* half the derivatives of the sum of squares by relative changes of the unknowns; 0 if fixed */
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

/* the derivative of the slopes along a direction, written to the first gradient; sets `there` to 0
 * if the motion cannot be computed */
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

enum pend_status pend_fit_curve_along(struct pend_fit *fit, const double direction[],
                                      double *bend) {
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

/* the derivatives of the slopes along all identifiable directions; sets `there` to 0 if the motion
 * cannot be computed */
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

enum pend_status pend_fit_curve_gain(struct pend_fit *fit, double *gain, double covariance[]) {
    struct curve curve;
    struct fit_told told;
    size_t q = (size_t)fit->problem.unknowns;
    long count;
    int there = 1;
    double *bend = calloc(q * q, sizeof *bend);
    double error = fit_curve_margin * fit->problem.rtol / fit_curve_step;
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
