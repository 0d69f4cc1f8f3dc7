/* POST /v1/response: amplitude and phase of a driven pendulum as functions of frequency, and its
 * poles.
 * Leaves to others: reading (response_json), the response (core/modes/response), the poles
 * (core/modes/damped), the bytes (encode).
 * Invariant: a frequency without a finite response has the amplitude NaN and the phase 0. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/json/json_out.h"
#include "api/op/modes/response_json.h"
#include "core/modes/damped.h"
#include "core/modes/response.h"
#include "core/modes/rest.h"

enum { OMEGA, FREQUENCY, FIRST_PART };
/* cost: s per arm and frequency; s per cube of the number of arms for all poles. Limits: rad of a
 * small swing; fraction of the linear range of dry friction or drag */
static const double sweep_seconds = 6e-7, pole_seconds = 2.5e-7, swing_most = 0.3, rub_most = 0.3;

/* the columns of each output: names of amplitude and phase, and the quantity */
static const struct {
    enum api_response_output output;
    const char *amplitude, *phase;
    enum pend_response_part part;
} columns[] = {
    {API_RESPONSE_PHI, "amplitude", "phase", PEND_RESPONSE_ANGLE},
    {API_RESPONSE_Z, "x_amplitude", "x_phase", PEND_RESPONSE_X},
    {API_RESPONSE_Z, "y_amplitude", "y_phase", PEND_RESPONSE_Y},
    {API_RESPONSE_LAMBDA, "amplitude", "phase", PEND_RESPONSE_TIP_ALONG},
    {API_RESPONSE_JOINT_FORCE, "along_amplitude", "along_phase", PEND_RESPONSE_JOINT_ALONG},
    {API_RESPONSE_JOINT_FORCE, "across_amplitude", "across_phase", PEND_RESPONSE_JOINT_ACROSS},
    {API_RESPONSE_TIP_FORCE, "along_amplitude", "along_phase", PEND_RESPONSE_TIP_ALONG},
    {API_RESPONSE_TIP_FORCE, "across_amplitude", "across_phase", PEND_RESPONSE_TIP_ACROSS},
    {API_RESPONSE_CART, "amplitude", "phase", PEND_RESPONSE_ANGLE},
};
enum { COLUMNS = sizeof columns / sizeof *columns };

struct response {
    struct api_response asked;
    const struct api_format *format;
    struct api_table table;

    /* set while it runs */
    struct pend_response *found;
    struct pend_damped *poles;
    double *block, *column[API_COLUMNS];                              /* columns of all rows, in one
                                                                       * block */
    double *part, *re[PEND_RESPONSE_PARTS], *im[PEND_RESPONSE_PARTS]; /* results for a group of
                                                                       * frequencies */
    double *couple;                                                   /* 2 n: torques of the drive,
                                                                       * re and im */
    long computed, written, unknown; /* numbers of rows: computed, written, and without a finite
                                      * response */
    double swing, swing_at;          /* the largest swing, rad, and its frequency, rad/s */
    double rub, rub_at; /* the largest ratio to the speed up to which friction is linear; its
                         * frequency, rad/s */
    struct api_writer *writer;
    struct api_stats stats;
    int rest; /* first column that repeats the equilibrium, or the number of columns */
    char warning[4][API_WARNING_TEXT];
};

static void response_clear(void *state) {
    struct response *response = state;
    api_writer_free(&response->writer);
    pend_response_free(&response->found);
    pend_damped_free(&response->poles);
    free(response->block);
    free(response->part);
    free(response->couple);
    api_response_clear(&response->asked);
}

/* ---- reading */

static void response_columns(struct response *response) {
    struct api_table *table = &response->table;
    int n = response->asked.tree.n;
    assert(!table->count && n >= 1);
    api_table_add(table, "omega", NULL, 0);
    api_table_add(table, "frequency", NULL, 0);
    for (int i = 0; i < COLUMNS; i++) {
        if (!response->asked.output[columns[i].output]) continue;
        const char *name = api_response_outputs[columns[i].output];
        int width = columns[i].output == API_RESPONSE_CART ? 0 : n;
        api_table_add(table, name, columns[i].amplitude, width);
        api_table_add(table, name, columns[i].phase, width);
        table->column[table->count - 2].sparse = 1;
    }
    if (response->asked.output[API_RESPONSE_TRANSMISSIBILITY]) {
        api_table_add(table, api_response_outputs[API_RESPONSE_TRANSMISSIBILITY], NULL, n);
        table->column[table->count - 1].sparse = 1;
    }
    response->rest = table->count;
    if (response->format == &api_format_json) return;
    // JSON has the equilibrium once; in a table each row repeats it
    api_table_add(table, "equilibrium", NULL, n);
    if (response->asked.tree.cart) api_table_add(table, "cart_equilibrium", NULL, 0);
}

static enum pend_status response_read(void *state, const struct api_reading *reading) {
    struct response *response = state;
    response->format = reading->format;
    enum pend_status status = api_response_read(&response->asked, reading);
    if (status == PEND_OK) {
        response->table.rows = response->asked.rows;
        response->table.digits = response->asked.digits;
        response_columns(response);
        api_reading_check_kept(reading, &response->table, API_MEMBER(reading->root, "omega"),
                               response->asked.tree.n, "frequencies",
                               "fewer frequencies or outputs");
        if (reading->problem->status) status = PEND_INVALID;
    }
    return status;
}

/* ---- running */

static enum pend_status response_allocate(struct response *response, struct pend_error *error) {
    size_t rows = (size_t)response->table.rows, n = (size_t)api_tree_stored(&response->asked.tree);
    size_t numbers = (size_t)api_table_numbers(&response->table, 0);
    assert(rows >= 1 && numbers >= 2 && !response->block);
    response->block = malloc(rows * numbers * sizeof(double));
    response->part = malloc(2 * PEND_RESPONSE_PARTS * PEND_RESPONSE_LANES * n * sizeof(double));
    response->couple = calloc(2 * n, sizeof(double));
    if (!response->block || !response->part || !response->couple)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the response of %zu arms", n);
    double *at = response->block, *part = response->part;
    for (int c = 0; c < response->table.count; c++) {
        response->column[c] = at;
        at += rows * (size_t)api_column_numbers(&response->table.column[c]);
    }
    for (int i = 0; i < PEND_RESPONSE_PARTS; i++) {
        response->re[i] = part, part += PEND_RESPONSE_LANES * n;
        response->im[i] = part, part += PEND_RESPONSE_LANES * n;
    }
    return PEND_OK;
}

static enum pend_status response_begin(struct response *response, struct pend_error *error) {
    const struct api_tree *tree = &response->asked.tree;
    struct api_states *start = response->asked.start;
    PEND_TRY(response_allocate(response, error));
    if (start) PEND_TRY(api_states_settle(start, tree, error));
    for (int k = 0; k < api_tree_stored(tree); k++)
        response->part[k] = start ? start->phi[k] : k < tree->cart ? 0 : -M_PI / 2;
    PEND_TRY(pend_response_new(&response->found, tree->tree, &tree->loads, response->part, error));
    if (!response->asked.poles) return PEND_OK;
    return pend_damped_new(&response->poles, tree->tree, &tree->loads,
                           pend_response_rest(response->found), error);
}

/* sets the drive to the harmonics of the pendulum: those of one frequency, or all */
static void response_own(const struct response *response, double omega,
                         struct pend_response_drive *drive) {
    const struct pend_terms *terms = response->asked.tree.loads.terms;
    size_t n = (size_t)api_tree_stored(&response->asked.tree);
    assert(terms && terms->harmonics > 0);
    memset(response->couple, 0, 2 * n * sizeof(double));
    for (int i = 0; i < terms->harmonics; i++) {
        const double *h = response->asked.tree.value + terms->harmonic[i].at;
        int drives = terms->harmonic[i].drives;
        if (response->asked.apart && fabs(h[1]) != omega) continue;
        // cos(-w t + p) is cos(w t - p)
        double phase = h[1] < 0 ? -h[2] : h[2];
        double re = h[0] * cos(phase), im = h[0] * sin(phase);
        if (drives >= 0) {
            response->couple[drives] += re;
            response->couple[n + (size_t)drives] += im;
        } else {
            drive->pivot_re[drives == PEND_DRIVE_PIVOT_Y] += re;
            drive->pivot_im[drives == PEND_DRIVE_PIVOT_Y] += im;
        }
    }
}

static struct pend_response_drive response_drive(const struct response *response, double omega) {
    const struct api_response *asked = &response->asked;
    struct pend_response_drive drive = {.couple_re = response->couple,
                                        .couple_im =
                                            response->couple + api_tree_stored(&asked->tree)};
    if (asked->own) {
        response_own(response, omega, &drive);
        return drive;
    }
    for (int i = 0; i < 2; i++) drive.pivot_re[i] = asked->pivot[i];
    if (asked->arm >= 0) response->couple[asked->arm] = asked->couple;
    return drive;
}

/* ratio of a tip's motion to that of the pivot, in the pivot's direction; NaN if the pivot does not
 * move */
static double response_passed(const struct response *response,
                              const struct pend_response_drive *drive, size_t at) {
    double size = 0, re = 0, im = 0;
    for (int i = 0; i < 2; i++) {
        double p = drive->pivot_re[i], q = drive->pivot_im[i];
        double x = response->re[PEND_RESPONSE_X + i][at], y = response->im[PEND_RESPONSE_X + i][at];
        size += p * p + q * q;
        re += p * x + q * y;
        im += p * y - q * x;
    }
    return size > 0 ? hypot(re, im) / size : NAN;
}

/* computes the amplitudes and phases of one quantity, of the arms or of the cart */
static void response_swing(const struct response *response, size_t from, int defined, int column,
                           double amplitude[], double phase[]) {
    const struct api_tree *tree = &response->asked.tree;
    const int *order = tree->tree->order;
    const double *re = response->re[columns[column].part] + from;
    const double *im = response->im[columns[column].part] + from;
    int cart = columns[column].output == API_RESPONSE_CART;
    int first = cart ? 0 : tree->cart, end = cart ? 1 : api_tree_stored(tree);
    for (int k = first; k < end; k++) {
        int at = cart ? 0 : order[k];
        amplitude[at] = defined ? hypot(re[k], im[k]) : NAN;
        phase[at] = defined ? atan2(im[k], re[k]) : 0;
    }
}

/* the ratio of a joint's rate or a tip's speed to the speed up to which friction and drag are
 * linear */
static double response_rub(const struct response *response, int k, size_t from, double omega) {
    const struct api_tree *tree = &response->asked.tree;
    const struct pend_loads *loads = &tree->loads;
    if (!loads->terms) return 0;
    int holder = pend_terms_holder(loads->terms, tree->tree->parent, k);
    size_t at = from + (size_t)k, on = from + (size_t)(holder < 0 ? 0 : holder);
    const double *re = response->re[PEND_RESPONSE_ANGLE], *im = response->im[PEND_RESPONSE_ANGLE];
    double x = re[at] - (holder < 0 ? 0 : re[on]), y = im[at] - (holder < 0 ? 0 : im[on]);
    double way =
        omega * hypot(hypot(response->re[PEND_RESPONSE_X][at], response->im[PEND_RESPONSE_X][at]),
                      hypot(response->re[PEND_RESPONSE_Y][at], response->im[PEND_RESPONSE_Y][at]));
    return pend_rest_beyond(loads, k, omega * hypot(x, y), way);
}

static void response_row(struct response *response, long row, int lane, int defined,
                         const struct pend_response_drive *drive) {
    const struct api_tree *tree = &response->asked.tree;
    size_t n = (size_t)api_tree_stored(tree), from = (size_t)lane * n, cart = (size_t)tree->cart;
    assert(row < response->table.rows && lane < PEND_RESPONSE_LANES);
    const int *order = tree->tree->order;
    int c = FIRST_PART;
    for (int i = 0; i < COLUMNS; i++) {
        if (!response->asked.output[columns[i].output]) continue;
        long at = row * api_column_numbers(&response->table.column[c]);
        response_swing(response, from, defined, i, response->column[c] + at,
                       response->column[c + 1] + at);
        c += 2;
    }
    for (size_t k = cart; k < n && defined; k++) {
        double swing = hypot(response->re[PEND_RESPONSE_ANGLE][from + k],
                             response->im[PEND_RESPONSE_ANGLE][from + k]);
        double omega = response->column[OMEGA][row],
               rub = response_rub(response, (int)k, from, omega);
        if (swing > response->swing) response->swing = swing, response->swing_at = omega;
        if (rub > response->rub) response->rub = rub, response->rub_at = omega;
    }
    if (response->rest < response->table.count) {
        const double *rest = pend_response_rest(response->found);
        api_tree_put(tree, rest, response->column[response->rest] + row * tree->n);
        if (cart) response->column[response->rest + 1][row] = rest[0];
    }
    if (!response->asked.output[API_RESPONSE_TRANSMISSIBILITY]) return;
    // there is no cart if the pivot is driven
    double *passed = response->column[c] + (size_t)row * n;
    for (size_t k = 0; k < n; k++)
        passed[order[k]] = defined ? response_passed(response, drive, from + k) : NAN;
}

/* computes the next frequencies: a group side by side, or one with drives of its own */
static double response_omega(const struct api_response *asked, long i) {
    assert(i >= 0 && i < asked->rows);
    if (asked->list) return asked->list[i];
    if (!i) return asked->from;
    if (i == asked->rows - 1) return asked->to;
    double part = (double)i / (double)(asked->rows - 1);
    return asked->logarithmic ? asked->from * pow(asked->to / asked->from, part)
                              : asked->from + (asked->to - asked->from) * part;
}

static void response_compute(struct response *response) {
    double omega[PEND_RESPONSE_LANES];
    unsigned char defined[PEND_RESPONSE_LANES];
    long left = response->table.rows - response->computed;
    int most = response->asked.apart ? 1 : PEND_RESPONSE_LANES;
    int count = left < most ? (int)left : most;
    assert(count > 0);
    for (int i = 0; i < count; i++)
        omega[i] = response_omega(&response->asked, response->computed + i);
    struct pend_response_drive drive = response_drive(response, omega[0]);
    pend_response_at(response->found, count, omega, &drive, response->re, response->im, defined);
    for (int i = 0; i < count; i++) {
        long row = response->computed + i;
        response->column[OMEGA][row] = omega[i];
        response->column[FREQUENCY][row] = omega[i] / (2 * M_PI);
        response->unknown += !defined[i];
        response_row(response, row, i, defined[i], &drive);
    }
    response->computed += count;
}

static enum pend_status response_write(struct response *response, struct api_buffer *out,
                                       struct pend_error *error) {
    const double *data[API_COLUMNS];
    long rows = response->computed - response->written;
    assert(rows >= 0 && response->computed <= response->table.rows);
    for (int c = 0; c < response->table.count; c++)
        data[c] = response->column[c] +
                  response->written * api_column_numbers(&response->table.column[c]);
    response->written = response->computed;
    return api_writer_block(response->writer, rows, data, out, error);
}

static void response_tell_rub(struct response *response) {
    if (!response->asked.given || response->rub <= rub_most) return;
    snprintf(response->warning[3], API_WARNING_TEXT,
             "at omega = %.6g rad/s a joint or a tip moves at %.3g times the speed below which its "
             "dry friction or quadratic drag is linear: the linear response is not valid there. "
             "Integrate the motion or reduce the drive.",
             response->rub_at, response->rub);
    api_stats_warning(&response->stats, "warning_friction", response->warning[3]);
}

static void response_tell(struct response *response, const struct api_turn *turn) {
    struct api_stats *stats = &response->stats;
    api_stats_whole(stats, "frequencies", response->table.rows);
    api_stats_whole(stats, "unknown", response->unknown);
    api_stats_whole(stats, "stable", pend_response_stable(response->found));
    api_turn_tell(turn, 0, stats);
    if (response->unknown) {
        snprintf(
            response->warning[0], API_WARNING_TEXT,
            "at %ld of the frequencies the amplitude is not finite: an undamped mode is in "
            "resonance, or has no restoring force. Add friction or leave these frequencies out.",
            response->unknown);
        api_stats_warning(stats, "warning_resonance", response->warning[0]);
    }
    if (!pend_response_stable(response->found)) {
        snprintf(response->warning[1], API_WARNING_TEXT,
                 "the equilibrium is unstable: a motion that begins near this response leaves it.");
        api_stats_warning(stats, "warning_stability", response->warning[1]);
    }
    response_tell_rub(response);
    if (!response->asked.given || response->swing <= swing_most) return;
    snprintf(response->warning[2], API_WARNING_TEXT,
             "an arm swings by %.3g rad at omega = %.6g rad/s: a linear response is valid for "
             "small swings only. Integrate the motion for larger ones.",
             response->swing, response->swing_at);
    api_stats_warning(stats, "warning_swing", response->warning[2]);
}

/* writes the poles, as lists with one entry each; `work` has space for one number per pole */
static enum pend_status response_poles(const struct pend_damped *poles, int digits, double work[],
                                       struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "poles", '{'));
    PEND_TRY(api_out_numbers(out, "omega", poles->count, poles->omega, digits));
    for (int j = 0; j < poles->count; j++) work[j] = 0 - poles->decay[j];
    PEND_TRY(api_out_numbers(out, "decay", poles->count, work, digits));
    PEND_TRY(api_out_numbers(out, "growth", poles->count, poles->decay, digits));
    for (int j = 0; j < poles->count; j++) {
        double size = hypot(poles->omega[j], poles->decay[j]);
        work[j] = size > 0 ? work[j] / size : 0;
    }
    PEND_TRY(api_out_numbers(out, "damping_ratio", poles->count, work, digits));
    return api_buffer_text(out, "}");
}

/* additional members of JSON, which replace its closing brace */
static enum pend_status response_more(const struct response *response, struct api_buffer *out) {
    const struct api_tree *tree = &response->asked.tree;
    const double *rest = pend_response_rest(response->found);
    double *work = response->part;
    int digits = response->table.digits;
    assert(out->bytes && out->data[out->bytes - 1] == '}');
    out->data[out->bytes - 1] = ',';
    api_tree_put(tree, rest, work);
    PEND_TRY(api_out_numbers(out, "equilibrium", tree->n, work, digits));
    if (tree->cart) PEND_TRY(api_out_number(out, "cart_equilibrium", rest[0], digits));
    if (response->poles) PEND_TRY(response_poles(response->poles, digits, work, out));
    return api_buffer_text(out, "}");
}

static enum pend_status response_piece(struct response *response, const struct api_turn *turn,
                                       int *done, struct pend_error *error) {
    if (!response->writer)
        PEND_TRY(api_writer_new(&response->writer, response->format, &response->table, turn->out));
    if (response->computed < response->table.rows) {
        response_compute(response);
        return response_write(response, turn->out, error);
    }
    if (response->written < response->computed) return response_write(response, turn->out, error);
    if (!response->stats.count) response_tell(response, turn);
    PEND_TRY(api_writer_finish(response->writer, &response->stats, turn->out, done));
    if (!*done || response->format != &api_format_json) return PEND_OK;
    return response_more(response, turn->out);
}

static enum pend_status response_run(void *state, const struct api_turn *turn, int *done,
                                     struct pend_error *error) {
    struct response *response = state;
    if (!response->found) PEND_TRY(response_begin(response, error));
    do PEND_TRY(response_piece(response, turn, done, error));
    while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

static void response_json(void *state) {
    struct response *response = state;
    api_writer_free(&response->writer);
    response->format = &api_format_json;
    response->table.count = response->rest;
    response->written = 0;
}

static void response_progress(const void *state, double *steps, double *work) {
    const struct response *response = state;
    *steps = -1;
    *work = (double)response->computed / (double)response->table.rows;
}

static double response_cost(const void *state) {
    const struct response *response = state;
    double n = api_tree_stored(&response->asked.tree);
    return n * (double)response->table.rows * sweep_seconds +
           (response->asked.poles ? n * n * n * pole_seconds : 0);
}

/* all rows, the sweeps of a group of frequencies, dense matrices for the poles; and a copy of the
 * rows for representations that do not stream */
static double response_bytes(const void *state) {
    const struct response *response = state;
    double n = api_tree_stored(&response->asked.tree), rows = (double)response->table.rows;
    double kept = api_table_numbers(&response->table, 0) * rows;
    double poles = response->asked.poles ? n * (32 * n + 64) : 0;
    double lanes = 2.0 * PEND_RESPONSE_PARTS * PEND_RESPONSE_LANES * n + 2 * n;
    return sizeof(double) * (kept + lanes + poles) + pend_response_bytes((int)n) +
           (response->asked.list ? sizeof(double) * rows : 0) +
           api_tree_bytes(&response->asked.tree) + api_states_bytes(response->asked.start) +
           api_writer_bytes(response->format, &response->table) + 2.0 * API_PIECE_BYTES;
}

const struct api_op api_op_response = {.name = "response",
                                       .size = sizeof(struct response),
                                       .body = 1,
                                       .terms = 1,
                                       .cart = 1,
                                       .samples = 1,
                                       .read = response_read,
                                       .run = response_run,
                                       .progress = response_progress,
                                       .table = offsetof(struct response, table),
                                       .cost = response_cost,
                                       .doubt = 10,
                                       .bytes = response_bytes,
                                       .stats = offsetof(struct response, stats),
                                       .json = response_json,
                                       .clear = response_clear};
