#include "core/fit/fit_alone.h"

#include <assert.h>
#include <stdlib.h>

/* one block: the structure, unknowns, columns, then rows of t, data and sigmas */
static size_t alone_bytes(const struct pend_fit_problem *p) {
    size_t rows = (size_t)p->rows, columns = (size_t)p->columns, q = (size_t)p->unknowns;
    return sizeof(struct fit_alone) + q * (sizeof *p->unknown + sizeof(double)) +
           columns * sizeof *p->column + rows * (1 + 2 * columns) * sizeof(double);
}

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
    struct fit_alone *made = malloc(alone_bytes(p));
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
