#include "core/fit/fit_curve.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps of the differences, relative: their error is a hundred-millionth, and that of the slopes,
 * of a motion to 1e-10, a millionth. */
static const double curve_step = 1e-4;

/* what both have of memory: q values, two gradients, q flags */
struct curve {
    double *value, *gradient[2];
    unsigned char *held;
};

static enum pend_status curve_init(struct curve *curve, const struct pend_fit *fit) {
    size_t q = (size_t)fit->problem.unknowns;
    *curve = (struct curve){.value = malloc(3 * q * sizeof(double)), .held = malloc(q)};
    if (!curve->value || !curve->held) return PEND_NO_MEMORY;
    curve->gradient[0] = curve->value + q, curve->gradient[1] = curve->value + 2 * q;
    memcpy(curve->held, fit->held, q);
    return PEND_OK;
}

/* puts the fit back */
static enum pend_status curve_clear(struct curve *curve, struct pend_fit *fit,
                                    enum pend_status status) {
    if (status == PEND_OK) {
        status = pend_fit_state_look(fit, fit->problem.rows, NULL);
        memcpy(fit->held, curve->held, (size_t)fit->problem.unknowns);
    }
    free(curve->value);
    free(curve->held);
    return status;
}

/* half of the derivatives of the sum of squares by relative changes; those of held unknowns are 0
 */
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

/* how the slopes change along a direction, into the first gradient; `there` = 0 where there is no
 * motion */
static enum pend_status curve_change(struct curve *curve, struct pend_fit *fit,
                                     const double direction[], int *there) {
    int q = fit->problem.unknowns;
    assert(q >= 1);
    for (int side = 0; side < 2; side++) {
        double step = side ? -curve_step : curve_step;
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
        curve->gradient[0][j] = (curve->gradient[0][j] - curve->gradient[1][j]) / (2 * curve_step);
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

enum pend_status pend_fit_curve_gain(struct pend_fit *fit, double *gain, double covariance[]) {
    struct curve curve;
    size_t q = (size_t)fit->problem.unknowns;
    int there = 1;
    *gain = INFINITY;
    double *bend = calloc(q * q + 2 * q, sizeof *bend);
    enum pend_status status = curve_init(&curve, fit);
    if (!bend) status = PEND_NO_MEMORY;
    if (status == PEND_OK) curve_slopes(fit, bend + q * q);
    for (size_t j = 0; j < q && there && status == PEND_OK; j++) {
        double *direction = bend + q * q + q;
        if (fit->held[j]) continue;
        direction[j] = 1;
        status = curve_change(&curve, fit, direction, &there);
        direction[j] = 0;
        for (size_t i = 0; i < q && there && status == PEND_OK; i++) {
            bend[i * q + j] += 0.5 * curve.gradient[0][i];
            bend[j * q + i] += 0.5 * curve.gradient[0][i];
        }
    }
    if (there && status == PEND_OK)
        status = pend_fit_told_newton((int)q, bend, bend + q * q, fit->size, gain, covariance);
    free(bend);
    return curve_clear(&curve, fit, status);
}
