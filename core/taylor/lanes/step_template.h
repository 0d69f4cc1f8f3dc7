/* The step lengths of several series at once, one per lane, by the rule of the taylor method. The
 * including file defines STEP_SIZE(s, place): the magnitude, as a `wide`, of the coefficient of a
 * rate at index `place`.
 * Leaves to others: one series alone, whose arms are in lanes (kernel_jets).
 * Invariant: no lane's step depends on another lane. */
#pragma once

#include "core/taylor/jets_system.h"
#include "core/taylor/taylor_order.h"

enum { STEP_TRAILING = 4, STEP_LEADING = 4 };

/* log2 of the largest coefficient of order j; a very negative number if all are zero */
VEC_INLINE wide step_norm(const struct jets_system *s, int j) {
    wide norm = wide_of(0);
    for (int k = 0; k < s->n; k++)
        norm = WIDE_(max)(norm, STEP_SIZE(s, (size_t)j * s->stride + (size_t)k));
    return WIDE_(log2)(norm) - (wide)((wide_mask)(norm == 0) & (wide_mask)wide_of(1e4));
}

/* the step in units for which the first neglected term is below rtol times the motion, or below
 * atol; tolerances are given as log2 */
static wide step_reach(const struct jets_system *s, int order, double log_rtol, double log_atol) {
    static const double log2_of[STEP_LEADING] = {0, 1, 1.5849625007211562, 2};
    wide leading[STEP_LEADING], reach = wide_of(10);
    const double *last = s->share + order;
    double spread = (PEND_TAYLOR_LOG_CAP - log_rtol) * last[0];
    for (int i = 0; i < STEP_LEADING; i++) leading[i] = step_norm(s, i) - log2_of[i];
    for (int j = order - STEP_TRAILING + 1; j <= order; j++) {
        wide trailing = step_norm(s, j);
        // an arm that stays at rest does not limit the step, although its leading terms are 0
        trailing -= (wide)((wide_mask)(trailing < -5e3) & (wide_mask)wide_of(1e6));
        wide far = log_atol * last[1] - trailing * s->share[j];
        wide here = log_rtol * last[0] + (leading[0] - trailing) * s->share[j - 1];
        for (int i = 1; i < STEP_LEADING; i++)
            here = WIDE_(max)(here,
                              log_rtol * last[-i] + (leading[i] - trailing) * s->share[j - i - 1]);
        // the tolerance atol may lengthen the step, at most to that of the largest rtol
        here = WIDE_(max)(here, WIDE_(min)(far, here + spread));
        reach = WIDE_(min)(reach, here);
    }
    return WIDE_(exp2)(WIDE_(max)(reach, wide_of(-60)));
}
