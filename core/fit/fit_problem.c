#include "core/fit/fit_problem.h"

#include <assert.h>
#include <math.h>

static size_t fit_measurements(const struct pend_fit_problem *problem) {
    size_t count = 0;
    for (long i = 0; i < problem->rows; i++)
        for (int c = 0; c < problem->columns; c++) count += !isnan(problem->column[c].data[i]);
    return count;
}

/* Returns the row that an out-of-order row should follow, -1 if it is earlier than the start of its
 * run, or the row itself if the order is correct. Rows of the same instant must be adjacent. */
static long fit_disorder(const struct pend_fit_problem *problem, long row) {
    double since = pend_fit_since(problem, row);
    int run = pend_fit_run(problem, row);
    assert(run >= 0 && run < pend_fit_runs(problem));
    if (!(since >= 0)) return -1;
    if (row && pend_fit_since(problem, row - 1) > since) return row - 1;
    // compare with the previous row of the same run, if its time since the start is the same
    for (long i = row - 1; i >= 0 && pend_fit_since(problem, i) == since; i--)
        if (pend_fit_run(problem, i) == run) return problem->t[row] >= problem->t[i] ? row : i;
    return row;
}

enum pend_status pend_fit_check(const struct pend_fit_problem *problem, struct pend_error *error) {
    if (problem->unknowns < 1)
        return pend_fail(error, PEND_INVALID, -1, 0, "there are no unknowns to fit");
    if (pend_terms_cart(problem->loads.terms))
        return pend_fail(error, PEND_INVALID, -1, 0, "a pendulum on a cart cannot be fitted");
    size_t count = fit_measurements(problem);
    if (count < (size_t)problem->unknowns)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%zu measurements are too few for %d unknowns: there must be as many",
                         count, problem->unknowns);
    for (long i = 0; i < problem->rows; i++) {
        long before = fit_disorder(problem, i);
        if (before == i) continue;
        double shift = problem->camera[PEND_FIT_SHIFT];
        double behind = before < 0 ? pend_fit_start(problem, pend_fit_run(problem, i)) - shift
                                   : problem->t[before];
        return pend_fail(error, PEND_INVALID, -1, problem->t[i],
                         "row %ld, %.6g s, must come after %s, %.6g s", i + 1, problem->t[i],
                         before < 0 ? "the start" : "the row before it", behind);
    }
    for (int j = 0; j < problem->unknowns; j++) {
        const struct pend_fit_unknown *u = &problem->unknown[j];
        if (u->low <= u->start && u->start <= u->high && u->low < u->high) continue;
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "unknown %d starts at %g, which must lie between its bounds %g and %g",
                         j + 1, u->start, u->low, u->high);
    }
    return PEND_OK;
}
