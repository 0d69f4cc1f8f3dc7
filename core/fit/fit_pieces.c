#include "core/fit/fit_pieces.h"

#include <assert.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/fit/fit_bounds.h"
#include "core/fit/fit_constants.h"
#include "core/fit/fit_model.h"
#include "core/fit/fit_start.h"

struct piece {
    struct pend_fit_problem problem; /* rows of the piece; a last row has its continuity
                                      * conditions */
    double start;                    /* s, the instant at which the piece starts */
    struct fit_model model;
    char *memory;
    int joint;        /* whether the piece ends with continuity conditions */
    int *from;        /* for each unknown of the piece, its index in the extended list */
    double *value;    /* values of the piece's unknowns */
    double *data;     /* columns x rows */
    double *residual; /* rows x columns */
    double *slope;    /* rows x columns x unknowns */
    struct pend_fit_column *column;
    struct pend_fit_unknown *unknown;
};

struct fit_pieces {
    struct pend_fit_problem own; /* the rows that are divided into pieces */
    const struct pend_fit_problem *problem;
    int count, unknowns, round, here;
    struct piece piece[FIT_PIECES];
    double *x; /* unknowns in unbounded form, then phi and rate at every join, stored order */
    double omega, sigma; /* rad/s, frequency of a swing; rad, standard deviation of the data */
    gsl_multifit_nlinear_workspace *work;
    gsl_multifit_nlinear_fdf fdf;
    long evaluations;
    enum pend_status status;
};

/* ---- how the motion is divided */

/* the number of rows, counted from the first, to divide into pieces; limited by the number of
 * pieces and by memory */
static long pieces_rows(const struct pend_fit_problem *p, double swing) {
    long rows = 1;
    while (rows < p->rows && rows * p->columns < FIT_PIECE_NUMBERS &&
           p->t[rows] - p->t[0] < fit_piece * swing * FIT_PIECES)
        rows++;
    return rows;
}

static int pieces_count(const struct pend_fit_problem *p, double swing) {
    long rows = pieces_rows(p, swing);
    double span = p->t[rows - 1] - p->t[0];
    double most = fmin(span / (fit_piece * swing), (double)FIT_PIECES);
    return (int)fmin(most, (double)rows / (2 * FIT_BESIDE));
}

static long pieces_row(const struct pend_fit_problem *p, int count, int s) {
    return p->rows * s / count;
}

static size_t pieces_numbers(const struct pend_fit_problem *p, int count) {
    size_t numbers = (size_t)(count - 1) * 2 * (size_t)p->n;
    for (int c = 0; c < p->columns; c++)
        for (long i = 0; i < p->rows; i++) numbers += !isnan(p->column[c].data[i]);
    return numbers;
}

int pend_fit_pieces_apt(const struct pend_fit_problem *p, double swing) {
    if (p->rows < 2 || p->n > 8 || p->run || pieces_count(p, swing) < 2) return 0;
    for (int j = 0; j < p->unknowns; j++)
        if (p->unknown[j].camera == PEND_FIT_SHIFT) return 0;
    for (int c = 0; c < p->columns; c++)
        if (p->column[c].kind >= PEND_FIT_MODE || p->column[c].clock) return 0;
    for (int arm = 0; arm < p->n; arm++) {
        long seen = 0;
        for (long i = 0; i < p->rows; i++) seen += !isnan(pend_fit_start_angle(p, arm, i));
        if (2 * seen < p->rows) return 0;
    }
    struct pend_fit_problem own = *p;
    own.rows = pieces_rows(p, swing);
    return pieces_numbers(&own, 1) >= (size_t)p->unknowns;
}

/* ---- making and freeing */

/* a typical standard deviation of an angle, from the data */
static double pieces_sigma(const struct pend_fit_problem *p) {
    double sum = 0;
    for (int c = 0; c < p->columns; c++)
        sum += pend_fit_sigma(&p->column[c], 0) /
               pend_fit_size(p, p->column[c].kind, p->camera[PEND_FIT_SCALE]);
    return sum / p->columns;
}

/* lists the unknowns of a piece: all those of the pendulum, and the state at the piece's start */
static void piece_unknowns(const struct fit_pieces *all, struct piece *piece, int s) {
    const struct pend_fit_problem *p = all->problem;
    int count = 0, state = p->unknowns + (s - 1) * 2 * p->n;
    for (int j = 0; j < p->unknowns; j++) {
        enum pend_parameter_kind kind = p->unknown[j].by.kind;
        int start =
            p->unknown[j].camera < 0 && (kind == PEND_PARAMETER_PHI || kind == PEND_PARAMETER_RATE);
        if (s && start) continue;
        piece->from[count] = j, piece->unknown[count++] = p->unknown[j];
    }
    for (int i = 0; s && i < 2 * p->n; i++) {
        struct pend_parameter by = {i < p->n ? PEND_PARAMETER_PHI : PEND_PARAMETER_RATE, i % p->n};
        piece->from[count] = state + i;
        piece->unknown[count++] = (struct pend_fit_unknown){-1, by, 0, -INFINITY, INFINITY, 0};
    }
    piece->problem.unknowns = count, piece->problem.unknown = piece->unknown;
}

/* lists the measurements of a piece, and the continuity conditions in the row after them */
static void piece_columns(const struct fit_pieces *all, struct piece *piece, long first) {
    const struct pend_fit_problem *p = all->problem;
    long rows = piece->problem.rows, own = rows - piece->joint;
    int columns = p->columns + (piece->joint ? 2 * p->n : 0);
    for (int c = 0; c < columns; c++) {
        double *data = piece->data + (size_t)c * (size_t)rows;
        struct pend_fit_column *column = &piece->column[c];
        int joint = c - p->columns;
        for (long i = 0; i < rows; i++)
            data[i] = joint < 0 && i < own ? p->column[c].data[first + i] : NAN;
        if (joint < 0) {
            *column = p->column[c];
            if (column->each) column->each += first;
        } else // arms of columns are in the caller's order
            *column = (struct pend_fit_column){.kind = joint < p->n ? PEND_FIT_PHI : PEND_FIT_RATE,
                                               .arm = p->order[joint % p->n]};
        column->data = data;
    }
    piece->problem.columns = columns, piece->problem.column = piece->column;
}

static enum pend_status piece_make(const struct fit_pieces *all, struct piece *piece, int s) {
    const struct pend_fit_problem *p = all->problem;
    long first = pieces_row(p, all->count, s), last = pieces_row(p, all->count, s + 1);
    size_t q = (size_t)p->unknowns + 2 * (size_t)p->n;
    size_t columns = (size_t)p->columns + 2 * (size_t)p->n;
    piece->joint = s + 1 < all->count;
    piece->problem = *p;
    piece->problem.rows = last - first + piece->joint, piece->problem.t = p->t + first;
    piece->start = s ? p->t[first] + p->camera[PEND_FIT_SHIFT] : pend_fit_start(p, 0);
    piece->problem.start = &piece->start;
    size_t m = (size_t)piece->problem.rows * columns;
    piece->from = malloc(q * sizeof *piece->from);
    piece->value = malloc((q + m * (q + 2)) * sizeof(double));
    piece->column = malloc(columns * sizeof *piece->column);
    piece->unknown = malloc(q * sizeof *piece->unknown);
    if (!piece->from || !piece->value || !piece->column || !piece->unknown) return PEND_NO_MEMORY;
    piece->data = piece->value + q, piece->residual = piece->data + m;
    piece->slope = piece->residual + m;
    piece_unknowns(all, piece, s);
    piece_columns(all, piece, first);
    size_t bytes = pend_fit_model_lay(&piece->model, &piece->problem, NULL);
    piece->memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!piece->memory) return PEND_NO_MEMORY;
    pend_fit_model_lay(&piece->model, &piece->problem, piece->memory);
    return PEND_OK;
}

void pend_fit_pieces_free(struct fit_pieces **pieces) {
    struct fit_pieces *all = *pieces;
    if (!all) return;
    for (int s = 0; s < all->count; s++) {
        free(all->piece[s].from);
        free(all->piece[s].value);
        free(all->piece[s].column);
        free(all->piece[s].unknown);
        free(all->piece[s].memory);
    }
    gsl_multifit_nlinear_free(all->work);
    free(all->x);
    free(all);
    *pieces = NULL;
}

/* ---- the functions that GSL calls */

/* copies the unknowns, the states at the joins and the weight of gaps into the pieces */
static void pieces_set(struct fit_pieces *all, const gsl_vector *x) {
    const struct pend_fit_problem *p = all->problem;
    double gape = fit_noisy * pow(0.1, all->round) * all->sigma;
    for (int s = 0; s < all->count; s++) {
        struct piece *piece = &all->piece[s];
        long rows = piece->problem.rows;
        for (int j = 0; j < piece->problem.unknowns; j++)
            piece->value[j] =
                fit_bounds_outer(&piece->unknown[j], gsl_vector_get(x, (size_t)piece->from[j]));
        for (int i = 0; piece->joint && i < 2 * p->n; i++) {
            size_t at = (size_t)(p->unknowns + s * 2 * p->n + i);
            piece->data[(size_t)(p->columns + i + 1) * (size_t)rows - 1] = gsl_vector_get(x, at);
            piece->column[p->columns + i].sigma = i < p->n ? gape : gape * all->omega;
        }
    }
}

/* writes one row of slopes, of measurement or continuity condition c of a piece */
static void pieces_row_of(const struct fit_pieces *all, int s, size_t c, const double slope[],
                          const gsl_vector *x, size_t at, gsl_matrix *J) {
    const struct piece *piece = &all->piece[s];
    size_t columns = (size_t)all->problem->columns;
    for (int j = 0; j < piece->problem.unknowns; j++) {
        size_t own = (size_t)piece->from[j];
        double stretch = fit_bounds_stretch(&piece->unknown[j], gsl_vector_get(x, own));
        gsl_matrix_set(J, at, own, stretch * slope[j]);
    }
    if (c < columns) return;
    size_t joint = (size_t)all->problem->unknowns + (size_t)s * 2 * (size_t)all->problem->n;
    gsl_matrix_set(J, at, joint + c - columns, -1 / piece->column[c].sigma);
}

/* computes the residuals, and their slopes if J is not NULL */
static int pieces_look(struct fit_pieces *all, const gsl_vector *x, gsl_vector *f, gsl_matrix *J) {
    size_t at = 0;
    pieces_set(all, x);
    if (J) gsl_matrix_set_zero(J);
    all->evaluations++;
    for (int s = 0; s < all->count; s++) {
        struct piece *piece = &all->piece[s];
        size_t q = (size_t)piece->problem.unknowns, columns = (size_t)piece->problem.columns;
        size_t rows = (size_t)piece->problem.rows;
        enum pend_status status =
            pend_fit_model_at(&piece->model, piece->value, piece->problem.rows, piece->residual,
                              J ? piece->slope : NULL, NULL);
        if (status != PEND_OK) all->status = status;
        if (status == PEND_NO_MEMORY || (J && status != PEND_OK)) return GSL_EFAILED;
        for (size_t i = 0; i < rows * columns; i++) {
            size_t c = i % columns;
            if (isnan(piece->column[c].data[i / columns])) continue;
            if (f) gsl_vector_set(f, at, status == PEND_OK ? piece->residual[i] : fit_nowhere);
            if (J) pieces_row_of(all, s, c, piece->slope + i * q, x, at, J);
            at++;
        }
    }
    return GSL_SUCCESS;
}

static int pieces_residuals(const gsl_vector *x, void *context, gsl_vector *f) {
    return pieces_look(context, x, f, NULL);
}

static int pieces_slopes(const gsl_vector *x, void *context, gsl_matrix *J) {
    return pieces_look(context, x, NULL, J);
}

/* ---- the search */

static void pieces_begin(struct fit_pieces *all, const double inner[]) {
    const struct pend_fit_problem *p = all->problem;
    memcpy(all->x, inner, (size_t)p->unknowns * sizeof *all->x);
    // if the start is at the first row, it is a join too
    for (int j = 0; j < p->unknowns && pend_fit_since(p, 0) == 0; j++) {
        const struct pend_fit_unknown *u = &p->unknown[j];
        double state[2];
        if (u->camera >= 0 || u->by.kind > PEND_PARAMETER_RATE) continue;
        pend_fit_start_parabola(p, p->order[u->by.at], 0, &state[0], &state[1]);
        double value = state[u->by.kind == PEND_PARAMETER_RATE];
        if (u->low < value && value < u->high) all->x[j] = fit_bounds_inner(u, value);
    }
    for (int s = 1; s < all->count; s++)
        for (int k = 0; k < p->n; k++) {
            double *to = all->x + p->unknowns + (s - 1) * 2 * p->n + k;
            pend_fit_start_parabola(p, p->order[k], pieces_row(p, all->count, s), to, to + p->n);
        }
}

enum pend_status pend_fit_pieces_new(struct fit_pieces **pieces,
                                     const struct pend_fit_problem *problem, double swing,
                                     const double inner[]) {
    assert(pend_fit_pieces_apt(problem, swing));
    enum pend_status status = PEND_OK;
    *pieces = NULL;
    struct fit_pieces *all = calloc(1, sizeof *all);
    if (!all) return PEND_NO_MEMORY;
    all->own = *problem, all->problem = &all->own, all->count = pieces_count(problem, swing);
    all->own.rows = pieces_rows(problem, swing);
    all->omega = 2 * M_PI / swing, all->sigma = pieces_sigma(problem);
    all->unknowns = problem->unknowns + (all->count - 1) * 2 * problem->n;
    all->x = malloc((size_t)all->unknowns * sizeof *all->x);
    for (int s = 0; s < all->count && status == PEND_OK; s++)
        status = piece_make(all, &all->piece[s], s);
    size_t numbers = pieces_numbers(all->problem, all->count);
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    if (numbers >= (size_t)all->unknowns && all->x)
        all->work = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &how, numbers,
                                               (size_t)all->unknowns);
    all->fdf = (gsl_multifit_nlinear_fdf){.f = pieces_residuals,
                                          .df = pieces_slopes,
                                          .n = numbers,
                                          .p = (size_t)all->unknowns,
                                          .params = all};
    if (status != PEND_OK || !all->x || !all->work) {
        pend_fit_pieces_free(&all);
        return PEND_NO_MEMORY;
    }
    pieces_begin(all, inner);
    *pieces = all;
    return PEND_OK;
}

enum pend_status pend_fit_pieces_step(struct fit_pieces *pieces, int *done, long *evaluations) {
    struct fit_pieces *all = pieces;
    gsl_vector_view x = gsl_vector_view_array(all->x, (size_t)all->unknowns);
    long before = all->evaluations;
    int why = 0, failed = 0;
    all->status = PEND_OK;
    if (!all->here) failed = gsl_multifit_nlinear_init(&x.vector, &all->fdf, all->work);
    int lost = failed;
    if (!failed) failed = gsl_multifit_nlinear_iterate(all->work);
    *evaluations += all->evaluations - before;
    if (all->status == PEND_NO_MEMORY) return PEND_NO_MEMORY;
    const gsl_vector *now = gsl_multifit_nlinear_position(all->work);
    for (int j = 0; j < all->unknowns && !lost; j++) all->x[j] = gsl_vector_get(now, (size_t)j);
    int over = failed || ++all->here >= FIT_ROUND_ITERATIONS ||
               gsl_multifit_nlinear_test(1e-3, 1e-6, 0, &why, all->work) == GSL_SUCCESS;
    if (over) all->here = 0, all->round++;
    *done = all->round >= FIT_ROUNDS;
    return PEND_OK;
}

const double *pend_fit_pieces_inner(const struct fit_pieces *pieces) {
    assert(pieces->x);
    return pieces->x;
}

double pend_fit_pieces_bytes(const struct pend_fit_problem *problem, double swing) {
    if (!pend_fit_pieces_apt(problem, swing)) return 0;
    struct pend_fit_problem cut = *problem;
    double count = pieces_count(problem, swing), n = problem->n;
    cut.rows = pieces_rows(problem, swing);
    double q = problem->unknowns + 2 * n, columns = problem->columns + 2 * n;
    double own = ((double)cut.rows + count) * columns * (q + 2) * 8;
    double wide = problem->unknowns + (count - 1) * 2 * n;
    double numbers = (double)cut.rows * problem->columns + count * 2 * n;
    struct fit_model sketch;
    double model = (double)pend_fit_model_lay(&sketch, &cut, NULL) * (1 + 2 * n / q);
    return own + count * model + 8 * (4 * numbers * wide + 8 * numbers + 8 * wide * wide);
}
