/* POST /v1/fits: parameters of a pendulum from measurements of its motion.
 * Leaves to others: reading (fits_json), the fit (core/fit), arms as JSON (tree_write).
 * Invariant: the answer says how the fit ended; an unknown error is null. The answer is JSON only,
 * so a job stores only JSON and no rows. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/engine.h"
#include "api/encode/encode_raw.h"
#include "api/json/json_out.h"
#include "api/op/fit/fits_hints.h"
#include "api/op/fit/fits_json.h"
#include "api/op/fit/fits_start.h"
#include "api/op/fit/fits_words.h"
#include "api/op/tree_write.h"
#include "core/fit/fit.h"

/* maximum number of further fits; each sets the knees of the loss from the residuals of the
 * previous fit */
enum { FITS_SETTLED = 8 };

/* maximum number of motions, and estimated s, that hints may cost beyond the motions of the fit
 * itself */
enum { HINT_MOTIONS = 1800, HINT_SECONDS = 5 };

enum { FITS_OUTLIERS = 50 };

struct fits {
    struct api_fit asked;
    const struct api_format *format;
    struct api_table table; /* an empty table, because the answer is JSON only */
    struct pend_fit *fit;
    int begun;                     /* whether the first step is done */
    struct pend_fit_result result; /* the fit's result, copied once the hints exist */
    struct api_hints *hints;
    int settled; /* number of earlier fits, each with other knees of the loss */
};

static void fits_clear(void *state) {
    struct fits *fits = state;
    api_hints_free(&fits->hints);
    pend_fit_free(&fits->fit);
    api_fit_clear(&fits->asked);
}

static enum pend_status fits_read(void *state, const struct api_reading *reading) {
    struct fits *fits = state;
    fits->format = reading->format;
    api_table_add(&fits->table, "residuals", NULL, 0);
    return api_fit_read(&fits->asked, reading);
}

/* ---- writing */

static enum pend_status write_unknowns(const struct fits *fits, const struct pend_fit_result *r,
                                       struct api_buffer *out) {
    assert(r->value && r->error && r->bounded);
    PEND_TRY(api_out_open(out, "unknowns", '['));
    for (int j = 0; j < fits->asked.unknowns; j++) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_text(out, "name", fits->asked.label[j]));
        PEND_TRY(api_out_number(out, "value", r->value[j] + fits->asked.shift[j], 0));
        PEND_TRY(api_out_maybe(out, "error", r->error[j]));
        PEND_TRY(api_out_key(out, "at_bound"));
        PEND_TRY(api_buffer_text(out, r->bounded[j] ? "true}" : "false}"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status write_row(const struct api_fit *asked, int run, const double row[],
                                  struct api_buffer *out) {
    const struct api_fit_run *own = &asked->run[run];
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "["));
    for (int s = 0; s < own->series; s++) PEND_TRY(api_out_maybe(out, NULL, row[own->column[s]]));
    for (int c = asked->columns - asked->modes; c < asked->columns && asked->runs == 1; c++)
        PEND_TRY(api_out_maybe(out, NULL, row[c]));
    return api_buffer_text(out, "]");
}

/* writes the residuals of a run, row by row; with a single run those of modes follow */
static enum pend_status write_residuals(const struct fits *fits, const struct pend_fit_result *r,
                                        int run, struct api_buffer *out) {
    const struct api_fit *asked = &fits->asked;
    const struct api_fit_run *own = &asked->run[run];
    assert(r->residual && asked->columns >= 1);
    long *at = malloc((size_t)asked->rows * sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    for (long i = 0; i < asked->rows; i++)
        if (asked->of[i] == run) at[asked->row[i]] = i;
    enum pend_status status = api_out_open(out, "residuals", '[');
    for (long i = 0; i < own->rows && status == PEND_OK; i++)
        status = write_row(asked, run, r->residual + at[i] * asked->columns, out);
    free(at);
    return status == PEND_OK ? api_buffer_text(out, "]") : status;
}

static enum pend_status write_modes(const struct fits *fits, const struct pend_fit_result *r,
                                    struct api_buffer *out) {
    const struct api_fit *asked = &fits->asked;
    if (!asked->modes) return PEND_OK;
    PEND_TRY(api_out_open(out, "mode_residuals", '['));
    for (int c = asked->columns - asked->modes; c < asked->columns; c++)
        PEND_TRY(api_out_maybe(out, NULL, r->residual[c]));
    return api_buffer_text(out, "]");
}

static enum pend_status write_start(const struct fits *fits, int run, double row[],
                                    struct api_buffer *out) {
    const struct api_fit *asked = &fits->asked;
    const struct api_tree *tree = &asked->tree;
    long base = (long)run * asked->start->n;
    double stop = asked->begin[run];
    PEND_TRY(api_out_open(out, "initial", '{'));
    api_tree_put(tree, asked->start->phi + base, row);
    PEND_TRY(api_out_numbers(out, "phi", tree->n, row, 0));
    api_tree_put(tree, asked->start->rate + base, row);
    PEND_TRY(api_out_numbers(out, "phid", tree->n, row, 0));
    if (tree->cart) {
        PEND_TRY(api_out_open(out, "cart", '{'));
        PEND_TRY(api_out_number(out, "x", asked->start->phi[base], 0));
        PEND_TRY(api_out_number(out, "v", asked->start->rate[base], 0));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(api_out_open(out, "times", '{'));
    PEND_TRY(api_out_number(out, "start", asked->begin[run], 0));
    for (long i = 0; i < asked->rows; i++)
        if (asked->of[i] == run) stop = asked->t[i] + asked->camera[PEND_FIT_SHIFT];
    // a fit of modes alone has a single instant
    if (!(stop > asked->begin[run])) stop = asked->begin[run] + 1;
    PEND_TRY(api_out_number(out, "stop", stop, 0));
    PEND_TRY(api_out_whole(out, "count", 201));
    return api_buffer_text(out, "}");
}

/* writes a trajectory request: the fitted pendulum, a start, and the times of the data */
static enum pend_status write_request(const struct fits *fits, int run, struct api_buffer *out) {
    const struct api_tree *tree = &fits->asked.tree;
    assert(fits->asked.start && tree->tree->n == api_tree_stored(tree));
    double *row = malloc((size_t)tree->n * sizeof *row);
    if (!row) return PEND_NO_MEMORY;
    enum pend_status status = api_out_open(out, "request", '{');
    if (status == PEND_OK) status = api_out_open(out, "pendulum", '{');
    if (status == PEND_OK) status = api_out_number(out, "gravity", tree->loads.gravity, 0);
    if (status == PEND_OK) status = api_terms_write_whole(tree->tree, &tree->loads, out);
    if (status == PEND_OK) status = api_tree_write_arms(tree, out);
    if (status == PEND_OK) status = api_buffer_text(out, "}");
    if (status == PEND_OK) status = write_start(fits, run, row, out);
    free(row);
    return status == PEND_OK ? api_buffer_text(out, "}") : status;
}

static enum pend_status write_run(const struct fits *fits, const struct pend_fit_result *r, int run,
                                  struct api_buffer *out) {
    PEND_TRY(api_out_maybe(out, "follows_until", r->follows[run]));
    PEND_TRY(write_residuals(fits, r, run, out));
    return write_request(fits, run, out);
}

/* writes a single run into the answer itself, several runs as a list */
static enum pend_status write_runs(const struct fits *fits, const struct pend_fit_result *r,
                                   struct api_buffer *out) {
    if (fits->asked.runs == 1) return write_run(fits, r, 0, out);
    PEND_TRY(write_modes(fits, r, out));
    PEND_TRY(api_out_open(out, "runs", '['));
    for (int run = 0; run < fits->asked.runs; run++) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(write_run(fits, r, run, out));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status write_outliers(const struct api_fit *asked, const struct pend_fit_result *r,
                                       struct api_buffer *out) {
    int count = 0;
    PEND_TRY(api_out_open(out, "outliers", '['));
    for (long i = 0; i < asked->rows; i++)
        for (int s = 0; s < asked->run[asked->of[i]].series; s++) {
            int c = asked->run[asked->of[i]].column[s];
            double off = fabs(r->residual[i * asked->columns + c]) / r->spread[c];
            if (!(off > r->beyond) || count++ >= FITS_OUTLIERS) continue;
            PEND_TRY(api_out_comma(out));
            PEND_TRY(api_buffer_text(out, "{"));
            if (asked->runs > 1) PEND_TRY(api_out_whole(out, "run", asked->of[i] + 1));
            PEND_TRY(api_out_whole(out, "row", asked->row[i] + 1));
            PEND_TRY(api_out_number(out, "t", asked->t[i], 0));
            PEND_TRY(api_out_whole(out, "series", s + 1));
            PEND_TRY(api_out_number(out, "deviations", off, 0));
            PEND_TRY(api_buffer_text(out, "}"));
        }
    return api_buffer_text(out, "]");
}

/* the lens, if it has an effect */
static enum pend_status write_lens(const struct api_fit *asked, struct api_buffer *out) {
    const double *camera = asked->camera, *tilt = camera + PEND_FIT_TILT_X;
    double stretch = camera[PEND_FIT_STRETCH], bent = camera[PEND_FIT_DISTORTION];
    if (tilt[0] == 0 && tilt[1] == 0 && stretch == 0 && bent == 0) return PEND_OK;
    PEND_TRY(api_out_numbers(out, "tilt", 2, tilt, 0));
    PEND_TRY(api_out_number(out, "stretch", stretch, 0));
    PEND_TRY(api_out_number(out, "distortion", bent, 0));
    PEND_TRY(api_out_numbers(out, "center", 2, asked->center, 0));
    return api_out_number(out, "reach", asked->reach, 0);
}

static enum pend_status write_figures(const struct fits *fits, const struct pend_fit_result *r,
                                      struct api_buffer *out) {
    assert(r->blind >= 0 && r->blind <= PEND_FIT_BLIND);
    double freedom = r->freedom > 0 ? (double)r->freedom : NAN;
    PEND_TRY(api_out_number(out, "chi_squared", r->chi_squared, 0));
    PEND_TRY(api_out_whole(out, "degrees_of_freedom", r->freedom));
    PEND_TRY(api_out_maybe(out, "chi_squared_per_degree", r->chi_squared / freedom));
    PEND_TRY(api_out_maybe(out, "p_value", r->p_value));
    PEND_TRY(api_out_maybe(out, "durbin_watson", r->watson));
    PEND_TRY(api_out_maybe(out, "errors_widened", r->widened));
    PEND_TRY(api_out_maybe(out, "effective_measurements", r->effective));
    PEND_TRY(api_out_number(out, "explained", r->explained, 0));
    PEND_TRY(api_hints_write(fits->hints, out));
    if (fits->asked.tables.bytes) {
        PEND_TRY(api_out_open(out, "tables", '['));
        PEND_TRY(api_buffer_add(out, fits->asked.tables.data, fits->asked.tables.bytes));
        PEND_TRY(api_buffer_text(out, "]"));
    }
    PEND_TRY(write_outliers(&fits->asked, r, out));
    for (int old = 0; old < 2; old++) { // also under the deprecated name
        PEND_TRY(api_out_open(out, old ? "not_told" : "unidentifiable", '['));
        for (int d = 0; d < r->blind; d++)
            PEND_TRY(api_fit_write_direction(&fits->asked, r->direction + d * fits->asked.unknowns,
                                             out));
        PEND_TRY(api_buffer_text(out, "]"));
    }
    PEND_TRY(api_out_open(out, "camera", '{'));
    PEND_TRY(api_out_number(out, "scale", fits->asked.camera[PEND_FIT_SCALE], 0));
    PEND_TRY(api_out_number(out, "rotation", fits->asked.camera[PEND_FIT_ROTATION], 0));
    PEND_TRY(api_out_numbers(out, "origin", 2, fits->asked.camera + PEND_FIT_ORIGIN_X, 0));
    PEND_TRY(api_out_number(out, "shift", fits->asked.camera[PEND_FIT_SHIFT], 0));
    PEND_TRY(write_lens(&fits->asked, out));
    return api_buffer_text(out, "}");
}

static enum pend_status fits_write(struct fits *fits, const struct api_turn *turn) {
    struct api_buffer *out = turn->out;
    struct pend_fit_result r = pend_fit_result(fits->fit);
    double seconds = api_turn_seconds(turn);
    PEND_TRY(api_fit_put(&fits->asked, r.value));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_fit_write_end(&fits->asked, &r, out));
    PEND_TRY(write_unknowns(fits, &r, out));
    PEND_TRY(api_out_matrix(out, "correlation", fits->asked.unknowns, r.correlation, 0));
    PEND_TRY(api_fit_write_fixed(&fits->asked, out));
    PEND_TRY(write_figures(fits, &r, out));
    PEND_TRY(write_runs(fits, &r, out));
    PEND_TRY(api_out_open(out, "stats", '{'));
    PEND_TRY(api_out_whole(out, "iterations", r.iterations));
    PEND_TRY(api_out_whole(out, "evaluations", r.evaluations));
    PEND_TRY(api_out_text(out, "version", PEND_VERSION));
    PEND_TRY(api_out_text(out, "engine", api_engine_name));
    if (seconds >= 0)
        PEND_TRY(api_out_number(out, "compute_seconds", rint(seconds * 1e6) / 1e6, 0));
    return api_buffer_text(out, "}}");
}

/* ---- running */

/* Estimated cost: about fifty motions with derivatives, 20 steps per arm and swing and 0.05 per
 * decay by 1/e due to friction. A step takes 10 us per arm and eight unknowns, or 2 us for an ideal
 * pendulum. If modes are measured, all modes are computed twice per unknown, at 80 ns per cube of
 * the number of arms, or 2 ns for an ideal pendulum. */
static double fits_cost(const void *state) {
    const struct api_fit *asked = &((const struct fits *)state)->asked;
    assert(asked->rows >= 1 && asked->tree.n >= 1);
    double n = asked->tree.n, length = 0, own = 0;
    // the last row is the latest of all runs
    double span = asked->t[asked->rows - 1] + asked->camera[PEND_FIT_SHIFT] -
                  asked->begin[asked->of[asked->rows - 1]];
    span *= asked->runs;
    for (int j = 0; j < asked->unknowns; j++)
        own += asked->unknown[j].camera < 0 && asked->unknown[j].by.kind <= PEND_PARAMETER_RATE;
    for (int k = 0; k < asked->tree.n; k++) length += asked->length[k] / n;
    double swings = span * sqrt(fabs(asked->tree.loads.gravity) / length) / 6;
    double steps = 20 * n * swings +
                   fmin(2e5, 0.05 * span * pend_loads_decay(&asked->tree.loads, asked->tree.tree));
    int ideal = !asked->tree.loads.terms;
    double q = asked->unknowns, each = q - own + own / asked->runs, passes = ceil(each / 8),
           arm = ideal ? 2e-6 : 1e-5;
    double numbers = (double)asked->rows * asked->columns;
    double modes = asked->modes ? (2 * q + 1) * n * n * n * (ideal ? 2e-9 : 8e-8) : 0;
    return 50 * (steps * n * passes * arm + numbers * (1e-6 * passes + 2e-8 * q * q) + modes);
}

static enum pend_status fits_hint(struct fits *fits, const struct pend_fit_result *result,
                                  const struct api_turn *turn, int *over) {
    double motions = fmin(HINT_MOTIONS, 50 * HINT_SECONDS / fits_cost(fits));
    fits->result = *result;
    if (!fits->hints)
        PEND_TRY(api_hints_new(&fits->hints, &fits->asked, &fits->result, (long)motions));
    do PEND_TRY(api_hints_step(fits->hints, over));
    while (!*over && !api_turn_over(turn));
    return PEND_OK;
}

/* does the iterations of one turn; a failure of the first motion is an error in the start values */
static enum pend_status fits_step(struct fits *fits, const struct api_turn *turn, int *over,
                                  struct pend_error *error) {
    do {
        enum pend_status status = pend_fit_step(fits->fit, over, error);
        // a likely mistake in the table explains more than the end of the search
        if (status != PEND_OK && status != PEND_NO_MEMORY && error && *fits->asked.advice)
            snprintf(error->text, sizeof error->text, "the fit failed: %s", fits->asked.advice);
        if (status != PEND_OK && status != PEND_NO_MEMORY && !fits->begun && turn->problem && error)
            api_problem_fault(turn->problem, fits->asked.runs > 1 ? "/data/runs" : "/initial",
                              API_CODE_OUT_OF_RANGE "%s", error->text);
        if (status != PEND_OK) return status;
        fits->begun = 1;
    } while (!*over && !api_turn_over(turn));
    return PEND_OK;
}

static enum pend_status fits_run(void *state, const struct api_turn *turn, int *done,
                                 struct pend_error *error) {
    struct fits *fits = state;
    int over = 0;
    assert(fits->asked.unknowns >= 1 && !*done);
    if (!fits->fit) {
        if (!fits->settled) (void)api_fit_bend(&fits->asked, NULL);
        struct pend_fit_problem problem = api_fit_problem(&fits->asked);
        PEND_TRY(pend_fit_new(&fits->fit, &problem, error));
    }
    PEND_TRY(fits_step(fits, turn, &over, error));
    if (!over) return PEND_OK;
    struct pend_fit_result r = pend_fit_result(fits->fit);
    if (!fits->hints && fits->settled++ < FITS_SETTLED && api_fit_bend(&fits->asked, &r)) {
        pend_fit_free(&fits->fit);
        return PEND_OK;
    }
    PEND_TRY(fits_hint(fits, &r, turn, &over));
    if (!over) return PEND_OK;
    *done = 1;
    return fits->format == &api_format_raw ? PEND_OK : fits_write(fits, turn);
}

static void fits_json(void *state) { ((struct fits *)state)->format = &api_format_json; }

static const char *fits_way_out(const void *state) {
    (void)state;
    return "ask for fewer rows, or give dry friction a larger \"speed\"";
}

static void fits_progress(const void *state, double *steps, double *work) {
    const struct fits *fits = state;
    *steps = -1;
    *work = fits->fit ? pend_fit_progress(fits->fit) : 0;
}

static double fits_bytes(const void *state) {
    const struct api_fit *asked = &((const struct fits *)state)->asked;
    struct pend_fit_problem problem = api_fit_problem(asked);
    double numbers = (double)asked->rows * (asked->columns + 1);
    double again = numbers <= API_HINT_NUMBERS ? pend_fit_bytes(&problem) + numbers * 8 : 0;
    return API_OP_SMALL_BYTES + pend_fit_bytes(&problem) + again +
           numbers * (3 * 8 + 2 * API_OUT_NUMBER_BYTES) + 1024.0 * asked->tree.n +
           (double)sizeof(struct api_fit) + api_terms_write_bytes(&asked->tree.loads) +
           api_tree_bytes(&asked->tree) + api_states_bytes(asked->start);
}

const struct api_op api_op_fits = {.name = "fits",
                                   .size = sizeof(struct fits),
                                   .body = 1,
                                   .form = 1,
                                   .terms = 1,
                                   .pieces = 1,
                                   .cart = 1,
                                   .read = fits_read,
                                   .run = fits_run,
                                   .progress = fits_progress,
                                   .table = offsetof(struct fits, table),
                                   .cost = fits_cost,
                                   .doubt = 3,
                                   .way_out = fits_way_out,
                                   .bytes = fits_bytes,
                                   .json = fits_json,
                                   .clear = fits_clear};
