#include "core/fit/fit_clock.h"

#include <assert.h>
#include <math.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"

/* whether an unknown is the shift of a column's clock */
static int clock_is(const struct pend_fit_problem *p, int j) {
    int clock = p->unknown[j].camera - PEND_FIT_CAMERA + 1, found = 0;
    for (int c = 0; c < p->columns && clock > 0; c++) found |= p->column[c].clock == clock;
    return found;
}

/* the sum of squares for a value of the shift; infinite if the motion cannot be computed */
static double clock_squares(struct pend_fit *fit, int j, double shift, long *count) {
    const struct pend_fit_unknown *u = &fit->problem.unknown[j];
    if (fit->starved || !(u->low < shift && shift < u->high)) return INFINITY;
    fit->value[j] = shift, fit->result.evaluations++;
    enum pend_status status =
        pend_fit_model_at(&fit->model, fit->value, fit->window, fit->residual, NULL, NULL);
    fit->starved |= status == PEND_NO_MEMORY;
    return status == PEND_OK ? pend_fit_state_squares(fit, fit->window, count) : INFINITY;
}

/* the sum of squares after a step of all unknowns from there, to first order */
static double clock_left(struct pend_fit *fit, int j, double shift, long *count) {
    struct fit_told told;
    fit->inner[j] = fit_bounds_inner(&fit->problem.unknown[j], shift);
    enum pend_status status = pend_fit_state_look(fit, fit->window, NULL);
    double left = pend_fit_state_squares(fit, fit->window, count);
    if (status == PEND_OK) {
        status = pend_fit_state_tell(fit, &told);
        if (status == PEND_OK) left -= pend_fit_told_gain(&told);
        pend_fit_told_clear(&told);
    }
    fit->starved |= status == PEND_NO_MEMORY;
    return status == PEND_OK ? left : INFINITY;
}

/* Lists the minima, from the given shift outwards, by the parabola through three sums of squares;
 * returns their number. */
static int clock_minima(struct pend_fit *fit, int j, double at[], double low[], long *count) {
    double step = 2 * M_PI / fit->model.seen.swing / FIT_CLOCK_PARTS, given = fit->value[j];
    double sums[2 * FIT_CLOCK_STEPS + 1], *sum = sums + FIT_CLOCK_STEPS;
    int minima = 0;
    for (int k = -FIT_CLOCK_STEPS; k <= FIT_CLOCK_STEPS; k++)
        sum[k] = clock_squares(fit, j, given + k * step, count);
    for (int k = 1; k < 2 * FIT_CLOCK_STEPS; k++) {
        int i = k & 1 ? k / 2 : -k / 2;
        double slope = sum[i + 1] - sum[i - 1], bend = sum[i + 1] - 2 * sum[i] + sum[i - 1];
        if (!isfinite(bend) || sum[i - 1] < sum[i] || sum[i + 1] <= sum[i]) continue;
        at[minima] = given + (i - slope / (2 * bend)) * step, low[minima++] = sum[i];
    }
    fit->value[j] = given;
    return minima;
}

enum pend_status pend_fit_clock_find(struct pend_fit *fit, int whole, int *some,
                                     struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    double at[FIT_CLOCK_STEPS], low[FIT_CLOCK_STEPS];
    fit->result.twin = -1;
    for (int j = 0; j < p->unknowns; j++)
        fit->value[j] = pend_fit_state_outer(fit, j, fit->inner[j]);
    for (int j = 0; j < p->unknowns; j++) {
        double given = fit->value[j], least = INFINITY;
        int good = 0;
        long count = 1;
        if (!clock_is(p, j)) continue;
        *some = 1, fit->edge[j] = 0;
        int minima = clock_minima(fit, j, at, low, &count);
        for (int k = 0; k < minima; k++) {
            if (whole) low[k] = clock_left(fit, j, at[k], &count);
            least = fmin(least, low[k]);
        }
        fit->value[j] = given;
        for (int k = 0; k < minima; k++) {
            double more = (low[k] / least - 1) * (double)count;
            if (!good && more <= (whole ? 1 : (double)count))
                fit->value[j] = at[k], good = 1;
            else if (more < fit_clock && fit->result.twin < 0)
                fit->result.twin = j, fit->result.other = at[k];
        }
        fit->inner[j] = fit_bounds_inner(&p->unknown[j], fit->value[j]);
    }
    assert(fit->window >= 1);
    if (!fit->starved) return PEND_OK;
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
}
