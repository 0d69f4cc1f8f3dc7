#include "core/fit/fit_problem.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

double pend_fit_size(const struct pend_fit_problem *problem, enum pend_fit_kind kind,
                     double scale) {
    double reach = 0, gravity = fabs(problem->loads.gravity);
    for (int k = 0; k < pend_fit_arms(problem); k++) reach += problem->length[k];
    double rate = gravity > 0 ? sqrt(gravity / reach) : reach * fabs(scale);
    double force = gravity > 0 ? gravity : reach, place = reach * fabs(scale);
    const double size[PEND_FIT_KINDS] = {
        [PEND_FIT_PHI] = 1,       [PEND_FIT_AMPLITUDE] = 1,      [PEND_FIT_RATE] = rate,
        [PEND_FIT_X] = place,     [PEND_FIT_Y] = place,          [PEND_FIT_MODE] = place,
        [PEND_FIT_CART] = reach,  [PEND_FIT_PASSAGE] = 1 / rate, [PEND_FIT_PERIOD] = 1 / rate,
        [PEND_FIT_ALONG] = force, [PEND_FIT_ACROSS] = force};
    return size[kind];
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
    size_t count = 0;
    for (long i = 0; i < problem->rows; i++)
        for (int c = 0; c < problem->columns; c++) count += !isnan(problem->column[c].data[i]);
    if (count < (size_t)problem->unknowns)
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "%zu measurements are too few for %d unknowns: there must be at least as many", count,
            problem->unknowns);
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

/* ---- one of several motions */

/* copies the values of the rows that belong to the run; returns where they begin */
static const double *alone_rows(const struct pend_fit_problem *p, int run, const double from[],
                                double **at) {
    double *to = *at;
    for (long i = 0; i < p->rows; i++)
        if (p->run[i] == run) *(*at)++ = from[i];
    return to;
}

struct fit_alone *pend_fit_alone(const struct pend_fit_problem *problem, int run) {
    const struct pend_fit_problem *p = problem;
    size_t rows = (size_t)p->rows, columns = (size_t)p->columns, q = (size_t)p->unknowns;
    // one block: the structure, unknowns, columns, then rows of t, data and sigmas
    struct fit_alone *made =
        malloc(sizeof *made + q * (sizeof *p->unknown + sizeof(double)) +
               columns * sizeof *p->column + rows * (1 + 2 * columns) * sizeof(double));
    assert(p->run && run >= 0 && run < p->runs);
    if (!made) return NULL;
    struct pend_fit_unknown *unknown = (struct pend_fit_unknown *)(void *)(made + 1);
    struct pend_fit_column *column = (struct pend_fit_column *)(void *)(unknown + p->unknowns);
    double *at = (double *)(void *)(column + p->columns), *first = at;
    *made = (struct fit_alone){.problem = *p, .run = run};
    struct pend_fit_problem *own = &made->problem;
    own->iterations = 1 + p->iterations / 2;
    own->runs = 0, own->run = NULL, own->column = column, own->unknown = unknown;
    own->phi += (long)run * p->n, own->rate += (long)run * p->n;
    own->start = p->start ? p->start + run : NULL;
    own->t = alone_rows(p, run, p->t, &at);
    own->rows = at - first;
    for (int c = 0; c < p->columns; c++) {
        column[c] = p->column[c];
        column[c].data = alone_rows(p, run, p->column[c].data, &at);
        if (p->column[c].each) column[c].each = alone_rows(p, run, p->column[c].each, &at);
    }
    made->from = (int *)(void *)at;
    own->unknowns = 0;
    for (int j = 0; j < p->unknowns; j++) {
        const struct pend_fit_unknown *u = &p->unknown[j];
        int start = u->camera < 0 && u->by.kind <= PEND_PARAMETER_RATE;
        if (start && u->run != run) continue;
        made->from[own->unknowns] = j;
        unknown[own->unknowns] = *u, unknown[own->unknowns++].run = 0;
    }
    return made;
}
