#include "core/fit/fit.h"

#include <assert.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_clock.h"
#include "core/fit/fit_constants.h"
#include "core/fit/fit_end.h"
#include "core/fit/fit_release.h"
#include "core/fit/fit_start.h"
#include "core/tree/rules.h"

struct fit_search {
    gsl_multifit_nlinear_workspace *work;
    gsl_multifit_nlinear_fdf fdf;
};

PEND_VALIDATOR fit_valid(const struct pend_fit *fit) {
    return fit->problem.unknowns >= 1 && fit->window >= 1 && fit->window <= fit->problem.rows;
}

/* ---- the functions that GSL calls */

static void fit_values(struct pend_fit *fit, const gsl_vector *x) {
    for (int j = 0; j < fit->problem.unknowns; j++)
        fit->value[j] = pend_fit_state_outer(fit, j, gsl_vector_get(x, (size_t)j));
}

static int fit_residuals(const gsl_vector *x, void *context, gsl_vector *f) {
    struct pend_fit *fit = context;
    fit_values(fit, x);
    fit->result.evaluations++;
    fit->status =
        pend_fit_model_at(&fit->model, fit->value, fit->window, f->data, NULL, &fit->failure);
    fit->starved |= fit->status == PEND_NO_MEMORY;
    if (fit->status != PEND_OK) gsl_vector_set_all(f, fit_nowhere);
    return fit->status == PEND_NO_MEMORY ? GSL_ENOMEM : GSL_SUCCESS;
}

static int fit_slopes(const gsl_vector *x, void *context, gsl_matrix *J) {
    struct pend_fit *fit = context;
    int q = fit->problem.unknowns;
    fit_values(fit, x);
    fit->result.evaluations++;
    fit->status = pend_fit_model_at(&fit->model, fit->value, fit->window, fit->residual, fit->slope,
                                    &fit->failure);
    fit->starved |= fit->status == PEND_NO_MEMORY;
    if (fit->status != PEND_OK) return GSL_EFAILED;
    for (size_t i = 0; i < J->size1; i++)
        for (int j = 0; j < q; j++) {
            double stretch = fit->edge[j] ? 0
                                          : fit_bounds_stretch(&fit->problem.unknown[j],
                                                               gsl_vector_get(x, (size_t)j));
            gsl_matrix_set(J, i, (size_t)j, stretch * fit->slope[i * (size_t)q + (size_t)j]);
        }
    return GSL_SUCCESS;
}

/* ---- making and freeing */

static size_t fit_lay(struct pend_fit *fit, char *block) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns, m = (size_t)p->rows * (size_t)p->columns;
    size_t runs = (size_t)pend_fit_runs(p);
    size_t counts[] = {
        q, q, q, q, q * q, m, m * q, PEND_FIT_BLIND * q, q * q, q, q, q, runs, (size_t)p->columns};
    double **array[] = {&fit->origin,      &fit->inner,    &fit->value, &fit->error,
                        &fit->correlation, &fit->residual, &fit->slope, &fit->direction,
                        &fit->covariance,  &fit->size,     &fit->best,  &fit->found,
                        &fit->follows,     &fit->spread};
    unsigned char **flags[] = {&fit->bounded, &fit->held};
    signed char **edges[] = {&fit->edge, &fit->edged};
    size_t used = (sizeof *fit + 63) / 64 * 64;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        *array[i] = block ? (double *)(void *)(block + used) : NULL;
        used += (counts[i] * sizeof(double) + 63) / 64 * 64;
    }
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        *flags[i] = block ? (unsigned char *)block + used : NULL;
        used += (q + 63) / 64 * 64;
    }
    for (size_t i = 0; i < sizeof edges / sizeof *edges; i++) {
        *edges[i] = block ? (signed char *)block + used : NULL;
        used += (q + 63) / 64 * 64;
    }
    fit->search = block ? (struct fit_search *)(void *)(block + used) : NULL;
    used += (sizeof *fit->search + 63) / 64 * 64;
    return used + pend_fit_model_lay(&fit->model, p, block ? block + used : NULL);
}

/* approximate duration, s, of a swing, or of a turn if an arm rotates faster: the length of the
 * first window */
static double fit_swing(const struct pend_fit_problem *problem) {
    double length = 0;
    double span = pend_fit_since(problem, problem->rows - 1) - pend_fit_since(problem, 0);
    int arms = pend_fit_arms(problem);
    for (int k = 0; k < arms; k++) length += problem->length[k] / arms;
    double gravity = fabs(problem->loads.gravity);
    double swing = gravity > 0 ? 2 * M_PI * sqrt(length / gravity) : span / 8;
    double turned = pend_fit_start_turned(problem, swing / 4);
    return turned > M_PI ? swing * M_PI / turned : swing;
}

double pend_fit_bytes(const struct pend_fit_problem *problem) {
    struct pend_fit sketch = {.problem = *problem};
    double q = problem->unknowns, m = (double)problem->rows * problem->columns;
    // GSL stores the slopes, their factorization and a copy
    double own = (double)fit_lay(&sketch, NULL) + 8 * (4 * m * q + 9 * m + 10 * q * q);
    // a single run needs at most as much as the whole problem, and may be divided into pieces too
    if (pend_fit_runs(problem) > 1) return 4 * own;
    return own + pend_fit_pieces_bytes(problem, fit_swing(problem));
}

/* rows in the first window: one swing, and at least twice as many measurements as unknowns */
static long fit_first(const struct pend_fit_problem *problem) {
    double until = pend_fit_since(problem, 0) + fit_swing(problem);
    long rows = 0, count = 0;
    while (rows < problem->rows &&
           (pend_fit_since(problem, rows) <= until || count < 2 * problem->unknowns)) {
        for (int c = 0; c < problem->columns; c++) count += !isnan(problem->column[c].data[rows]);
        rows++;
    }
    return rows;
}

/* limits the steps of a motion: only extreme values of the unknowns, far from a minimum, need
 * more */
static void fit_cap(struct pend_fit_problem *problem) {
    double swings = pend_fit_since(problem, problem->rows - 1) / fit_swing(problem);
    double most = FIT_STEPS + FIT_STEPS * problem->n * swings;
    const struct pend_rules *rules = problem->loads.terms ? problem->loads.terms->rules : NULL;
    // a step ends at every instant of a table
    for (int i = 0; rules && i < rules->tables; i++) most += 4.0 * rules->table[i].count;
    if (!problem->step_cap || problem->step_cap > most) problem->step_cap = (long)most;
}

enum pend_status pend_fit_new(struct pend_fit **fit, const struct pend_fit_problem *problem,
                              struct pend_error *error) {
    *fit = NULL;
    PEND_TRY(pend_fit_check(problem, error));
    struct pend_fit sketch = {.problem = *problem};
    size_t bytes = fit_lay(&sketch, NULL), m = (size_t)problem->rows * (size_t)problem->columns;
    char *block = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!block) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    memset(block, 0, bytes);
    struct pend_fit *made = (struct pend_fit *)(void *)block;
    *made = sketch;
    fit_lay(made, block);
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    how.trs = gsl_multifit_nlinear_trs_lmaccel;
    made->search->work =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &how, m, (size_t)problem->unknowns);
    if (!made->search->work) {
        free(block);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    }
    made->search->fdf = (gsl_multifit_nlinear_fdf){.f = fit_residuals,
                                                   .df = fit_slopes,
                                                   .n = m,
                                                   .p = (size_t)problem->unknowns,
                                                   .params = made};
    made->window = fit_first(problem);
    made->least = INFINITY;
    made->swing = fit_swing(problem);
    made->apt = pend_fit_runs(problem) > 1 || pend_fit_pieces_apt(problem, made->swing);
    fit_cap(&made->problem);
    assert(fit_valid(made));
    *fit = made;
    return PEND_OK;
}

void pend_fit_free(struct pend_fit **fit) {
    if (!*fit) return;
    assert(fit_valid(*fit));
    gsl_multifit_nlinear_free((*fit)->search->work);
    pend_fit_pieces_free(&(*fit)->pieces);
    pend_fit_free(&(*fit)->single);
    free((*fit)->alone);
    free(*fit);
    *fit = NULL;
}

/* ---- windows */

/* the largest standard deviation of a predicted measurement, relative to the allowed one */
static double fit_doubt(const struct pend_fit *fit, long row, int c, double variance) {
    const struct pend_fit_problem *p = &fit->problem;
    size_t q = (size_t)p->unknowns;
    const double *slope = fit->slope + ((size_t)row * (size_t)p->columns + (size_t)c) * q;
    double sum = 0, most = fit_foretold, sigma = pend_fit_sigma(&p->column[c], row);
    for (size_t i = 0; i < q; i++)
        for (size_t j = 0; j < q; j++) sum += slope[i] * fit->covariance[i * q + j] * slope[j];
    most *= pend_fit_size(p, p->column[c].kind, fit->model.seen.camera[PEND_FIT_SCALE]);
    return sqrt(sum * variance) * sigma / most;
}

/* adds the rows that are predicted well enough, but at least a few */
static enum pend_status fit_grow(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    long rows = fit->window, ahead = 4 * rows + 8, least = rows + 1 + rows / 20, count;
    struct fit_told told;
    PEND_TRY(pend_fit_state_look(fit, rows, error));
    double squares = pend_fit_state_squares(fit, rows, &count);
    double variance = pend_fit_state_variance(fit, squares, count - p->unknowns);
    enum pend_status status = pend_fit_state_tell(fit, &told);
    if (status == PEND_OK) pend_fit_told_covariance(&told, fit->covariance);
    pend_fit_told_clear(&told);
    if (status != PEND_OK) return pend_fit_state_lost(status, error);
    if (ahead > p->rows) ahead = p->rows; // predict no further than the last row
    status = pend_fit_state_look(fit, ahead, error);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        for (int good = 1; rows < ahead && good; rows += good)
            for (int c = 0; c < p->columns && good; c++)
                good = !(fit_doubt(fit, rows, c, variance) > 1);
    if (rows < least) rows = least;
    fit->window = rows < p->rows ? rows : p->rows;
    fit->begun = 0;
    return PEND_OK;
}

/* ---- iterations */

static enum pend_status fit_begin(struct pend_fit *fit, struct pend_error *error) {
    size_t bytes = (size_t)fit->problem.unknowns * sizeof(double);
    if (!fit->result.iterations && pend_fit_release_begin(fit, fit->window) != PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    int some = 0;
    if (!fit->result.iterations) PEND_TRY(pend_fit_clock_find(fit, 0, &some, error));
    if (!fit->result.iterations) memcpy(fit->origin, fit->inner, bytes);
    gsl_vector_view x = gsl_vector_view_array(fit->inner, (size_t)fit->problem.unknowns);
    fit->begun = 1, fit->here = 0;
    fit->status = PEND_OK;
    int failed = gsl_multifit_nlinear_init(&x.vector, &fit->search->fdf, fit->search->work);
    if (!failed && !fit->starved && fit->status == PEND_OK) return PEND_OK;
    if (fit->starved || fit->status == PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    if (error) *error = fit->failure;
    return pend_fit_state_wild(fit, fit->status, error);
}

/* Copies the current iterate of the solver. Returns 0 and copies nothing if it is not finite: GSL
 * takes such a step if the slopes vanish or overflow. */
static int fit_keep(struct pend_fit *fit) {
    const gsl_vector *x = gsl_multifit_nlinear_position(fit->search->work);
    int q = fit->problem.unknowns, whole = 1;
    for (int j = 0; j < q; j++) whole &= isfinite(gsl_vector_get(x, (size_t)j)) != 0;
    for (int j = 0; j < q && whole; j++) fit->inner[j] = gsl_vector_get(x, (size_t)j);
    return whole;
}

/* Stores the lowest minimum so far and restores it. Returns whether it is the current one. */
static int fit_lowest(struct pend_fit *fit, double squares) {
    size_t q = (size_t)fit->problem.unknowns, bytes = q * sizeof(double);
    int lower = squares < fit->least * (1 - 1e-6);
    assert(squares >= 0);
    if (squares < fit->least) {
        memcpy(fit->best, fit->inner, bytes), fit->least = squares;
        memcpy(fit->edged, fit->edge, q);
    } else {
        memcpy(fit->inner, fit->best, bytes);
        memcpy(fit->edge, fit->edged, q);
    }
    return lower;
}

/* Evaluates all rows and fixes unknowns that reach a bound. The sum of squares is infinite if the
 * motion cannot be computed. */
static enum pend_status fit_put(struct pend_fit *fit, double *squares, double *variance, int *put,
                                struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->problem;
    long count;
    *squares = INFINITY, *variance = 1, *put = 0;
    PEND_TRY(pend_fit_state_look(fit, p->rows, error));
    *squares = pend_fit_state_squares(fit, p->rows, &count);
    *variance = pend_fit_state_variance(fit, *squares, count - p->unknowns);
    fit->variance = *variance;
    enum pend_status status = pend_fit_state_free(fit);
    if (status == PEND_OK) status = pend_fit_release_put(fit, squares, *variance, put);
    return status == PEND_OK ? PEND_OK : pend_fit_state_lost(status, error);
}

/* Decides whether the search continues after it has converged on all rows: inside a bound that need
 * not be active, or once with all bounded unknowns moved inside, to find another minimum. */
static enum pend_status fit_again(struct pend_fit *fit, int used, int *again,
                                  struct pend_error *error) {
    double gain = 0, squares, variance;
    int put;
    enum pend_status status = fit_put(fit, &squares, &variance, &put, error);
    // if the motion cannot be computed, the previous minimum is the answer
    if (status == PEND_NO_MEMORY || (status != PEND_OK && isinf(fit->least))) return status;
    *again = put && !used;
    if (*again) fit->begun = 0;
    if (*again || !fit_lowest(fit, squares) || used) return PEND_OK;
    status = pend_fit_release_let(fit, &gain);
    if (status != PEND_OK) return pend_fit_state_lost(status, error);
    int free = pend_fit_state_flat(fit, gain, squares);
    if (free && fit->inside) return PEND_OK;
    *again = pend_fit_release_move(fit, free, variance) > 0;
    if (free) fit->inside = 1;
    // in the curved valley of a chaotic motion, steps become short long before the minimum
    if (!free && !*again) *again = fit->anew = 1;
    fit->begun = !*again;
    return PEND_OK;
}

/* one iteration in the window; sets *over if no further iteration follows */
static enum pend_status fit_iterate(struct pend_fit *fit, int *over, struct pend_error *error) {
    double squares, variance;
    int put = 0, whole = fit->window == fit->problem.rows, why = 0;
    // GSL compares the square of the slope with this tolerance, because residuals may be exactly 0
    double tolerance = !whole ? fit_rough : fit->anew ? fit_exact : fit_fine;
    int stuck = gsl_multifit_nlinear_iterate(fit->search->work);
    fit->here++;
    if (fit->starved) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    if (!fit_keep(fit)) stuck = 1;
    *over = stuck || (!whole && fit->here >= FIT_WINDOW_ITERATIONS) ||
            gsl_multifit_nlinear_test(tolerance, tolerance * tolerance, 0, &why,
                                      fit->search->work) == GSL_SUCCESS;
    if (*over || !whole || fit->here % FIT_BOUND_ITERATIONS) return PEND_OK;
    // if the minimum lies beyond a bound, iterations approach the bound only very slowly
    if (fit_put(fit, &squares, &variance, &put, error) == PEND_NO_MEMORY) return PEND_NO_MEMORY;
    if (put) fit->begun = 0;
    return PEND_OK;
}

/* Returns whether the iterations are used up. A first search that multiple shooting may follow gets
 * half of them, or seven eighths with several runs. */
static int fit_used(const struct pend_fit *fit) {
    int most = fit->problem.iterations,
        other = pend_fit_runs(&fit->problem) > 1 ? most / 8 : most / 2;
    return fit->result.iterations >= (fit->apt && !fit->cut ? most - other : most);
}

/* starts the search of a single run; if a run has too few data, the separate searches end */
static enum pend_status fit_single(struct pend_fit *fit, int run, struct pend_error *error) {
    free(fit->alone);
    enum pend_status status = PEND_NO_MEMORY;
    fit->alone = pend_fit_alone(&fit->problem, run);
    if (fit->alone) status = pend_fit_new(&fit->single, &fit->alone->problem, NULL);
    if (status != PEND_OK) free(fit->alone), fit->alone = NULL;
    if (status != PEND_NO_MEMORY) return PEND_OK;
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
}

/* divides the motion into pieces if the first search has not converged, has found a wrong minimum,
 * or has reached values for which the motion cannot be computed */
static enum pend_status fit_cut(struct pend_fit *fit, enum pend_status ended,
                                struct pend_error *error) {
    int left = fit->result.iterations < fit->problem.iterations;
    if (ended == PEND_NO_MEMORY || fit->cut || !fit->apt || !left) return ended;
    int clear = ended == PEND_OK && fit->result.end == PEND_FIT_CONVERGED;
    if (clear && fit->result.explained > fit_clear) return PEND_OK;
    if (clear && !pend_fit_start_noisy(&fit->problem, fit->residual)) return PEND_OK;
    fit->cut = 1, fit->ready = 0;
    if (ended == PEND_OK) (void)fit_lowest(fit, fit->result.chi_squared);
    if (pend_fit_runs(&fit->problem) > 1) {
        fit->told = -INFINITY, fit->begun = 0;
        memcpy(fit->found, fit->origin, (size_t)fit->problem.unknowns * sizeof(double));
        return fit_single(fit, 0, error);
    }
    if (pend_fit_pieces_new(&fit->pieces, &fit->problem, fit->swing, fit->origin) == PEND_OK)
        return PEND_OK;
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
}

/* after the last iteration in a window: takes the next window or another round, or ends the fit */
static enum pend_status fit_next(struct pend_fit *fit, struct pend_error *error) {
    int used = fit_used(fit), again = 0;
    if (fit->window < fit->problem.rows && !used) return fit_grow(fit, error);
    // a second search may end before it uses all rows, and at a higher minimum than the first
    if (fit->window == fit->problem.rows || fit->cut) PEND_TRY(fit_again(fit, used, &again, error));
    int clocks = !again && !used && fit->window == fit->problem.rows && !fit->clocked++;
    if (clocks) PEND_TRY(pend_fit_clock_find(fit, 1, &again, error));
    fit->begun &= !(clocks && again);
    return again ? PEND_OK : pend_fit_end(fit, error);
}

/* one iteration of multiple shooting; after the last one, the search uses all rows */
static enum pend_status fit_pieces(struct pend_fit *fit, struct pend_error *error) {
    int over = 0;
    long before = fit->result.evaluations;
    if (pend_fit_pieces_step(fit->pieces, &over, &fit->result.evaluations) != PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a fit");
    fit->model.motions += (double)(fit->result.evaluations - before);
    fit->result.iterations++;
    if (!over && fit->result.iterations < fit->problem.iterations) return PEND_OK;
    for (int j = 0; j < fit->problem.unknowns; j++) {
        const struct pend_fit_unknown *u = &fit->problem.unknown[j];
        double x = pend_fit_pieces_inner(fit->pieces)[j];
        // an unknown that ran into its bound restarts from its start value
        int lost = fit_bounds_at(u, fit_bounds_outer(u, x));
        fit->inner[j] = lost ? fit->origin[j] : x;
        fit->edge[j] = 0;
    }
    pend_fit_pieces_free(&fit->pieces);
    fit->window = fit_first(&fit->problem), fit->begun = 0;
    return PEND_OK;
}

/* One iteration on a single run. Once the search of every run follows its data, the whole problem
 * starts from the states of these searches, with the other unknowns of the run that is explained
 * best. Otherwise the search of the whole problem continues. */
static enum pend_status fit_runs_alone(struct pend_fit *fit, struct pend_error *error) {
    const struct pend_fit_problem *p = &fit->alone->problem;
    int over = 0, next = fit->alone->run + 1, q = fit->problem.unknowns;
    enum pend_status status = pend_fit_step(fit->single, &over, error);
    if (status == PEND_NO_MEMORY || (status == PEND_OK && !over)) return status;
    double explained = over ? fit->single->result.explained : 0;
    for (int j = 0; j < p->unknowns && explained > fit_explained; j++) {
        double x = fit->single->value[j];
        int start = p->unknown[j].camera < 0 && p->unknown[j].by.kind <= PEND_PARAMETER_RATE;
        if (!fit_bounds_at(&p->unknown[j], x) && (start || explained > fit->told))
            fit->found[fit->alone->from[j]] = fit_bounds_inner(&p->unknown[j], x);
    }
    fit->told = fmax(fit->told, explained);
    fit->result.evaluations += over ? fit->single->result.evaluations : 0;
    fit->model.motions += fit->single->model.motions / pend_fit_runs(&fit->problem);
    pend_fit_free(&fit->single);
    if (explained > fit_explained && next < pend_fit_runs(&fit->problem))
        return fit_single(fit, next, error);
    free(fit->alone), fit->alone = NULL;
    if (!(explained > fit_explained)) return PEND_OK;
    memcpy(fit->inner, fit->found, (size_t)q * sizeof(double));
    memset(fit->edge, 0, (size_t)q);
    fit->window = fit_first(&fit->problem);
    return PEND_OK;
}

enum pend_status pend_fit_step(struct pend_fit *fit, int *done, struct pend_error *error) {
    assert(fit_valid(fit));
    int over = 1;
    *done = fit->ready;
    if (fit->ready) return PEND_OK;
    if (fit->pieces) return fit_pieces(fit, error);
    if (fit->alone) return fit_runs_alone(fit, error);
    enum pend_status status = fit->begun ? PEND_OK : fit_begin(fit, error);
    fit->result.iterations += fit->result.iterations < fit->problem.iterations;
    if (status == PEND_OK)
        PEND_TRY(fit_iterate(fit, &over, error));
    else if (status == PEND_NO_MEMORY || isinf(fit->least))
        return fit->result.iterations > 1 ? fit_cut(fit, status, error) : status;
    else // if the motion cannot be computed there, the previous minimum is the answer
        (void)fit_lowest(fit, INFINITY);
    status = over || fit_used(fit) ? fit_next(fit, error) : PEND_OK;
    if (status != PEND_OK || fit->ready) status = fit_cut(fit, status, error);
    *done = fit->ready;
    return status;
}

struct pend_fit_result pend_fit_result(const struct pend_fit *fit) {
    assert(fit_valid(fit) && fit->ready);
    struct pend_fit_result result = fit->result;
    result.value = fit->value, result.error = fit->error, result.correlation = fit->correlation;
    result.residual = fit->residual, result.bounded = fit->bounded;
    result.direction = fit->direction, result.follows = fit->follows;
    result.spread = fit->spread;
    return result;
}

double pend_fit_progress(const struct pend_fit *fit) {
    double motions = fit->model.motions;
    double most = FIT_MOTIONS * (6 + fit->problem.unknowns);
    return fit->ready ? 1 : motions < 1 ? 0 : motions / fmax(most, motions + 1);
}
