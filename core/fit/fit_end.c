#include "core/fit/fit_end.h"

#include <assert.h>
#include <math.h>

#include "core/fit/fit_release.h"

/* Parts of the sum of squares: what a motion that follows explains; residuals of so many sigma are
 * not noise. */
static const double fit_explained = 0.9, fit_strange = 3;

static void end_errors(struct pend_fit *fit, double variance) {
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

/* the last row of a run up to which the residuals of any few rows together are not above two sigma
 */
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

/* how it ended, of a result that is filled in but for that */
static enum pend_fit_end end_kind(const struct pend_fit *fit, int minimum) {
    const struct pend_fit_result *result = &fit->result;
    double spread = result->chi_squared / (double)(result->freedom > 0 ? result->freedom : 1);
    int strange = result->explained < fit_explained ||
                  (pend_fit_state_known(fit) && spread > fit_strange * fit_strange);
    if (!minimum || fit->window < fit->problem.rows) return PEND_FIT_STOPPED;
    return strange ? PEND_FIT_STRANGE : PEND_FIT_CONVERGED;
}

enum pend_status pend_fit_end(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    struct pend_fit_result *result = &fit->result;
    struct fit_told told;
    long count, found = 0;
    double gain = 0;
    PEND_TRY(pend_fit_state_look(fit, p->rows, error));
    result->chi_squared = pend_fit_state_squares(fit, p->rows, &count);
    double before = pend_fit_state_variance(fit, result->chi_squared, count - p->unknowns);
    PEND_TRY(pend_fit_state_free(fit, before));
    enum pend_status status = pend_fit_state_tell(fit, &told);
    for (int d = 0; d < p->unknowns && status == PEND_OK; d++) found += pend_fit_told_is(&told, d);
    if (status == PEND_OK)
        result->blind = pend_fit_told_blind(&told, fit->bounded, PEND_FIT_BLIND, fit->direction);
    pend_fit_told_clear(&told);
    if (status == PEND_OK) status = pend_fit_release_let(fit, &gain);
    if (status != PEND_OK) return status;
    int minimum = pend_fit_state_flat(fit, gain, result->chi_squared);
    result->freedom = count - found;
    double variance = pend_fit_state_variance(fit, result->chi_squared, result->freedom);
    double total = pend_fit_state_total(fit);
    end_errors(fit, variance);
    result->explained = total > 0 ? 1 - result->chi_squared / total : 0;
    for (int run = 0; run < pend_fit_runs(p); run++)
        fit->follows[run] = end_follows(fit, run, variance);
    result->end = end_kind(fit, minimum);
    for (long i = 0; i < p->rows; i++)
        for (int c = 0; c < p->columns; c++)
            if (isnan(p->column[c].data[i])) fit->residual[i * p->columns + c] = NAN;
    fit->ready = 1;
    return PEND_OK;
}
