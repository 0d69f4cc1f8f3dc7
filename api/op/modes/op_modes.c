/* POST /v1/modes: frequencies and shapes of small oscillations about an equilibrium, and the
 * decomposition of an initial state into them.
 * Leaves to others: reading the request (modes_json), the modes (core/modes/modes), the matrices
 * (core/modes/matrix).
 * Invariant: all arrays with one entry per mode have the same order: growing modes first, the
 * fastest of them first, then oscillating ones, the slowest first. */
#include "api/op/op.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/stats_text.h"
#include "api/json/json_out.h"
#include "api/op/modes/damped_json.h"
#include "api/op/modes/modes_json.h"
#include "core/modes/matrix.h"
#include "core/modes/modes.h"

enum scalar { MODE, OMEGA, FREQUENCY, PERIOD, GROWTH, AMPLITUDE, PHASE, RISING, FALLING, SCALARS };

static const char *const scalar_names[] = {"mode",      "omega", "frequency", "period", "growth",
                                           "amplitude", "phase", "rising",    "falling"};

/* maximum number of modes that are decomposed, or numbers that are written, before the clock is
 * read */
enum { PIECE_MODES = 32, PIECE_NUMBERS = 8192 };

/* relative difference of frequencies that count as equal, far above round-off */
static const double alike = 1e-9;

struct modes {
    struct api_modes asked;
    const struct api_format *format;
    struct api_table table; /* the answer in every representation except JSON */
    struct pend_modes_search *search;
    struct api_damped damped; /* for a real pendulum; used instead of everything below */
    double *near;             /* n angles: start of the search for the equilibrium; NULL for an
                               * ideal pendulum */

    /* set while it runs */
    struct pend_modes *found;
    int split;               /* number of modes into which the start has been decomposed so far */
    int sloped;              /* number of frequencies that have been differentiated so far */
    double *slope;           /* their derivatives, a row per mode, and memory for a computation */
    double *scratch;         /* one block, which contains the following arrays */
    double *scalar[SCALARS]; /* one number per mode */
    double *line;            /* n numbers, or several rows of the table */
    long lines;              /* capacity of `line` in rows of the table */
    struct api_writer *writer;
    double identity[3]; /* both sides of the identity, and their relative difference */
    struct api_stats stats;
    char last;            /* last byte of the JSON so far, which the next turn writes; 0 = none */
    int filled;           /* whether the arrays with one number per mode are computed */
    int begun, part, row; /* next to write: a row of the vectors (part 0) or of matrix part - 1 */
};

static void modes_clear(void *state) {
    struct modes *modes = state;
    api_writer_free(&modes->writer);
    api_damped_clear(&modes->damped);
    free(modes->near);
    free(modes->scratch);
    pend_modes_free(&modes->found);
    pend_modes_search_free(&modes->search);
    api_modes_clear(&modes->asked);
}

/* ---- reading */

static void modes_columns(struct modes *modes) {
    static const enum scalar always[] = {MODE, OMEGA, FREQUENCY};
    struct api_table *table = &modes->table;
    for (int i = 0; i < 3; i++) api_table_add(table, scalar_names[always[i]], NULL, 0);
    api_table_add(table, scalar_names[modes->asked.up ? GROWTH : PERIOD], NULL, 0);
    if (modes->asked.start) api_table_add(table, scalar_names[AMPLITUDE], NULL, 0);
    if (modes->asked.start) api_table_add(table, scalar_names[PHASE], NULL, 0);
    if (modes->asked.start && modes->asked.up) api_table_add(table, scalar_names[RISING], NULL, 0);
    if (modes->asked.start && modes->asked.up) api_table_add(table, scalar_names[FALLING], NULL, 0);
    if (modes->asked.vectors) api_table_add(table, "vectors", NULL, modes->asked.tree.n);
    if (modes->asked.derived.count)
        api_table_add_inner(table, "derivatives", "omega", 0, modes->asked.derived.count);
}

static void modes_check_size(const struct modes *modes, const struct api_reading *reading) {
    static const char fewer[] =
        "fewer modes by \"select\", or only the frequencies by \"vectors\": false";
    const struct api_table *table = &modes->table;
    double n = modes->asked.tree.n, numbers = table->rows * api_table_numbers(table, 0),
           most = reading->limits->answer_bytes;
    if (modes->asked.request.vectors && 8 * n * table->rows > most)
        api_value_fault(reading->root, reading->problem,
                        API_CODE_LIMIT
                        "asks for the vectors of %ld modes, which take %.0f bytes during the "
                        "computation, more than the limit max-answer-bytes of %.0f: ask for %s",
                        table->rows, 8 * n * table->rows, most,
                        modes->asked.start ? "fewer modes by \"select\"" : fewer);
    if (reading->format != &api_format_json) {
        api_reading_check_size(reading, table, reading->root, "modes", fewer);
        return;
    }
    for (int i = 0; i < PEND_MATRIX_COUNT; i++) numbers += modes->asked.include[i] ? n * n : 0;
    double bytes = numbers * api_out_number_bytes(table->digits) + 4 * n + 1000;
    char flowing[API_FORMATS_TEXT];
    api_format_list(flowing, 1, 1);
    if (bytes > most)
        api_value_fault(reading->root, reading->problem,
                        API_CODE_LIMIT
                        "asks for %.0f numbers, up to %.0f bytes, more than the limit "
                        "max-answer-bytes of %.0f. Ask for %s, include fewer matrices, round the "
                        "numbers by \"digits\", or choose a format without this limit: %s",
                        numbers, bytes, most, fewer, flowing);
}

static enum pend_status modes_begin_search(struct modes *modes, const struct api_reading *reading) {
    struct pend_error error = {.text = ""};
    modes->asked.request.loads = modes->asked.tree.loads;
    modes->asked.request.vectors =
        modes->asked.vectors || modes->asked.start || modes->asked.derived.count;
    modes->asked.request.up = modes->asked.up;
    enum pend_status status = pend_modes_search_new(&modes->search, modes->asked.tree.tree,
                                                    &modes->asked.request, &error);
    if (status == PEND_INVALID)
        api_value_fault(reading->root, reading->problem, API_CODE_UNSUPPORTED "%s", error.text);
    if (status) return status;
    modes->table.rows = pend_modes_search_count(modes->search);
    modes_columns(modes);
    api_tree_modes_allowed(&modes->asked.tree, API_MEMBER(reading->root, "pendulum"),
                           (int)modes->table.rows, "finding the modes", reading->limits,
                           reading->problem);
    modes_check_size(modes, reading);
    return PEND_OK;
}

/* prepares the modes of a real pendulum: the equilibrium is sought from all arms hanging, or from a
 * start */
static enum pend_status modes_begin_real(struct modes *modes, const struct api_reading *reading) {
    size_t n = (size_t)api_tree_stored(&modes->asked.tree);
    modes->near = malloc(n * sizeof *modes->near);
    if (!modes->near) return PEND_NO_MEMORY;
    for (size_t k = 0; k < n; k++)
        modes->near[k] = modes->asked.up && modes->asked.up[k] ? M_PI / 2 : -M_PI / 2;
    if (modes->asked.tree.cart) modes->near[0] = 0;
    modes->damped = (struct api_damped){.table = &modes->table, .stats = &modes->stats};
    api_damped_init(&modes->damped, &modes->asked.tree, modes->near, reading->format,
                    modes->asked.digits, modes->asked.vectors, modes->asked.include);
    api_reading_check_size(reading, &modes->table, reading->root, "modes",
                           "no shapes, by \"vectors\": false");
    return PEND_OK;
}

static enum pend_status modes_read(void *state, const struct api_reading *reading) {
    struct modes *modes = state;
    modes->format = reading->format;
    PEND_TRY(api_modes_read(&modes->asked, reading));
    modes->table.digits = modes->asked.digits;
    if (!reading->problem->status)
        PEND_TRY(modes->asked.tree.loads.terms ? modes_begin_real(modes, reading)
                                               : modes_begin_search(modes, reading));
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

/* ---- running */

/* allocates one block: some rows, and the arrays with one number per mode */
static enum pend_status modes_allocate(struct modes *modes, struct pend_error *error) {
    size_t n = (size_t)modes->asked.tree.n, count = (size_t)modes->found->count;
    long lines = PIECE_NUMBERS / (long)n;
    modes->lines = lines < 1 ? 1 : lines;
    size_t slopes = count * (size_t)modes->asked.derived.count + 2 * n + 1;
    modes->scratch =
        malloc(((size_t)modes->lines * n + SCALARS * count + slopes) * sizeof *modes->scratch);
    if (!modes->scratch)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %zu arms", n);
    modes->line = modes->scratch;
    for (int i = 0; i < SCALARS; i++)
        modes->scalar[i] = modes->scratch + (size_t)modes->lines * n + (size_t)i * count;
    modes->slope = modes->scalar[0] + SCALARS * count;
    return PEND_OK;
}

/* converts the start to a deviation from the equilibrium */
static enum pend_status modes_settle_start(struct modes *modes, struct pend_error *error) {
    PEND_TRY(api_states_settle(modes->asked.start, &modes->asked.tree, error));
    for (int k = 0; k < modes->asked.tree.n; k++)
        modes->asked.start->phi[k] =
            modes->asked.up && modes->asked.up[k]
                ? pend_modes_theta(modes->asked.start->phi[k] - M_PI, 0)
                : pend_modes_theta(modes->asked.start->phi[k], modes->asked.start->phi_low[k]);
    return PEND_OK;
}

static void modes_fill(const struct modes *modes) {
    for (int k = 0; k < modes->found->count; k++) {
        double omega = modes->found->omega[k], swings = omega > 0 ? omega : 0;
        modes->scalar[MODE][k] = modes->found->first + k + 1;
        modes->scalar[OMEGA][k] = swings;
        modes->scalar[FREQUENCY][k] = swings / (2 * M_PI);
        modes->scalar[PERIOD][k] = swings > 0 ? 2 * M_PI / swings : 0;
        modes->scalar[GROWTH][k] = omega < 0 ? -omega : 0;
        if (!modes->asked.start) continue;
        /* modes_split has written both kinds of numbers to amplitude and phase */
        modes->scalar[RISING][k] = omega < 0 ? modes->scalar[AMPLITUDE][k] : 0;
        modes->scalar[FALLING][k] = omega < 0 ? modes->scalar[PHASE][k] : 0;
        if (omega < 0) modes->scalar[AMPLITUDE][k] = modes->scalar[PHASE][k] = 0;
    }
}

static enum pend_status modes_split(struct modes *modes, struct pend_error *error) {
    struct pend_modes few = *modes->found;
    int done = modes->split,
        count = few.count - done < PIECE_MODES ? few.count - done : PIECE_MODES;
    if (!done) PEND_TRY(modes_settle_start(modes, error));
    few.count = count;
    few.omega += done;
    few.norm += done;
    few.vector += (size_t)done * (size_t)few.n;
    modes->split += count;
    return pend_modes_decompose(&few, modes->asked.tree.tree, modes->asked.up,
                                modes->asked.start->phi, modes->asked.start->rate,
                                modes->scalar[AMPLITUDE] + done, modes->scalar[PHASE] + done);
}

static enum pend_status modes_differentiate(struct modes *modes, struct pend_error *error) {
    const struct pend_modes *found = modes->found;
    int n = found->n, by = modes->asked.derived.count;
    double *row = modes->slope + (size_t)modes->sloped * (size_t)by, *omega = found->omega;
    double *all = modes->slope + (size_t)found->count * (size_t)by;
    for (int i = 0; i < PIECE_MODES && modes->sloped < found->count; i++, row += by) {
        int k = modes->sloped++;
        if (k && omega[k] - omega[k - 1] <= alike * omega[k])
            return pend_fail(error, PEND_NOT_FINITE, -1, 0,
                             "modes %d and %d have the same frequency, which has no derivatives: "
                             "change a length or a mass a little",
                             k, k + 1);
        pend_modes_slope(found, modes->asked.tree.tree, &modes->asked.tree.loads, k, all);
        for (int j = 0; j < by; j++) {
            struct pend_parameter p = modes->asked.derived.parameter[j];
            row[j] = all[(int)(p.kind - PEND_PARAMETER_LENGTH) * n + p.at];
        }
    }
    return PEND_OK;
}

static void modes_vector(const struct modes *modes, int mode, double line[]) {
    assert(mode >= 0 && mode < modes->found->count);
    const struct pend_tree *tree = modes->asked.tree.tree;
    const double *vector = modes->found->vector + (size_t)mode * (size_t)tree->n;
    for (int k = 0; k < tree->n; k++) line[tree->order[k]] = vector[k];
}

static const char *const identity_names[] = {"sum_inverse_omega_squared", "length_total_over_g",
                                             "relative_difference"};

static enum pend_status write_identity(const struct modes *modes, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "identity", '{'));
    for (int i = 0; i < 3; i++)
        PEND_TRY(api_out_number(out, identity_names[i], modes->identity[i], modes->table.digits));
    return api_buffer_text(out, "}");
}

/* the index of a name among the scalars; SCALARS if there is none */
static int scalar_of(const char *name) {
    int i = 0;
    while (i < SCALARS && strcmp(scalar_names[i], name)) i++;
    return i;
}

static enum pend_status write_lists(const struct modes *modes, struct api_buffer *out) {
    const struct api_table *table = &modes->table;
    int identity = modes->asked.request.select == PEND_SELECT_ALL;
    PEND_TRY(api_buffer_text(out, "{"));
    for (int c = 0; c < table->count; c++) {
        int which = scalar_of(table->column[c].name), exact = which == MODE;
        if (which == SCALARS) continue;
        PEND_TRY(api_out_numbers(out, scalar_names[which], (int)table->rows, modes->scalar[which],
                                 exact ? 0 : table->digits));
        if (identity && (which == PERIOD || which == GROWTH)) PEND_TRY(write_identity(modes, out));
    }
    return PEND_OK;
}

static int part_wanted(const struct modes *modes, int part) {
    if (part > PEND_MATRIX_COUNT) return modes->asked.derived.count;
    return part ? modes->asked.include[part - 1] : modes->asked.vectors;
}

/* for JSON: writes the next row of the vectors, a matrix or the derivatives, or the end */
static enum pend_status write_row(struct modes *modes, struct api_buffer *out, int *done) {
    int n = modes->asked.tree.n, part = modes->part, slope = part > PEND_MATRIX_COUNT;
    int rows = part && !slope ? n : modes->found->count, by = modes->asked.derived.count;
    if (part > PEND_MATRIX_COUNT + 1) {
        *done = 1;
        PEND_TRY(api_stats_json(&modes->stats, out));
        return api_buffer_text(out, "}");
    }
    if (part_wanted(modes, part) && !modes->row) {
        if (slope) PEND_TRY(api_out_open(out, "derivatives", '{'));
        const char *name = part ? pend_matrix_names[part - 1] : "vectors";
        PEND_TRY(api_out_open(out, slope ? "omega" : name, '['));
    }
    if (!part_wanted(modes, part) || modes->row == rows) {
        if (part_wanted(modes, part)) PEND_TRY(api_buffer_text(out, slope ? "]}" : "]"));
        modes->part++;
        modes->row = 0;
        return PEND_OK;
    }
    if (slope)
        return api_out_numbers(out, NULL, by, modes->slope + (long)modes->row++ * by,
                               modes->table.digits);
    if (part)
        pend_matrix_row(modes->asked.tree.tree, &modes->asked.tree.loads, modes->asked.up,
                        (enum pend_matrix)(part - 1), modes->row, modes->line);
    else
        modes_vector(modes, modes->row, modes->line);
    modes->row++;
    return api_out_numbers(out, NULL, n, modes->line, modes->table.digits);
}

/* for other representations: writes the next rows of the table, or the next piece after them */
static enum pend_status write_rows(struct modes *modes, struct api_buffer *out, int *done,
                                   struct pend_error *error) {
    const struct api_table *table = &modes->table;
    const double *data[API_COLUMNS];
    if (!modes->writer) PEND_TRY(api_writer_new(&modes->writer, modes->format, table, out));
    long rows = table->rows - modes->row < modes->lines ? table->rows - modes->row : modes->lines;
    if (!rows) return api_writer_finish(modes->writer, &modes->stats, out, done);
    for (int c = 0; c < table->count; c++) {
        int which = scalar_of(table->column[c].name);
        data[c] = which == SCALARS ? modes->line : modes->scalar[which] + modes->row;
        if (table->column[c].part)
            data[c] = modes->slope + (long)modes->row * modes->asked.derived.count;
    }
    for (long i = 0; modes->asked.vectors && i < rows; i++)
        modes_vector(modes, modes->row + (int)i, modes->line + i * modes->asked.tree.n);
    modes->row += (int)rows;
    return api_writer_block(modes->writer, rows, data, out, error);
}

/* the statistics. The identity is sum 1/omega^2 = l_tot/g, where growing modes and upright arms
 * count negatively: both, and their relative difference. */
static void modes_tell(struct modes *modes, const struct api_turn *turn) {
    const struct pend_tree *tree = modes->asked.tree.tree;
    const unsigned char *up = modes->asked.up;
    double gravity = modes->asked.tree.loads.gravity, *both = modes->identity;
    double all = tree->length_total / gravity, lengths = up ? 0 : all, sum = 0;
    int stable = 1;
    for (int k = 0; up && k < tree->n; k++) {
        stable &= !up[k];
        lengths += (up[k] ? -tree->len[k] : tree->len[k]) / gravity;
    }
    for (int k = modes->found->count - 1; k >= 0; k--)
        sum += 1 / (modes->found->omega[k] * fabs(modes->found->omega[k]));
    both[0] = sum, both[1] = lengths, both[2] = fabs(sum - lengths) / all;
    api_stats_whole(&modes->stats, "stable", stable);
    api_turn_tell(turn, 0, &modes->stats);
    for (int i = 0; i < 3 && modes->asked.request.select == PEND_SELECT_ALL; i++)
        api_stats_number(&modes->stats, identity_names[i], both[i]);
}

static enum pend_status modes_piece(struct modes *modes, const struct api_turn *turn, int *done,
                                    struct pend_error *error) {
    struct api_buffer *out = turn->out;
    int found = 0;
    if (modes->search) {
        PEND_TRY(pend_modes_search_step(modes->search, &found, error));
        if (!found) return PEND_OK;
        modes->found = pend_modes_search_take(modes->search);
        pend_modes_search_free(&modes->search);
        modes_tell(modes, turn);
        return modes_allocate(modes, error);
    }
    if (modes->asked.start && modes->split < modes->found->count) return modes_split(modes, error);
    if (modes->asked.derived.count && modes->sloped < modes->found->count)
        return modes_differentiate(modes, error);
    if (!modes->filled) modes_fill(modes);
    modes->filled = 1;
    if (modes->format != &api_format_json) {
        modes->begun = 1;
        return write_rows(modes, out, done, error);
    }
    if (modes->begun) return write_row(modes, out, done);
    modes->begun = 1;
    return write_lists(modes, out);
}

static enum pend_status modes_run_real(struct modes *modes, const struct api_turn *turn, int *done,
                                       struct pend_error *error) {
    if (modes->asked.start && !modes->split) {
        PEND_TRY(api_states_settle(modes->asked.start, &modes->asked.tree, error));
        for (int k = 0; k < modes->asked.start->n; k++) modes->near[k] = modes->asked.start->phi[k];
        modes->split = 1;
    }
    do PEND_TRY(api_damped_run(&modes->damped, turn, done, error));
    while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

/* JSON's commas depend on the last byte of the buffer, but the caller may remove a turn's bytes
 * after it. Therefore the last byte of a turn is written by the next turn. */
static enum pend_status modes_run(void *state, const struct api_turn *turn, int *done,
                                  struct pend_error *error) {
    struct modes *modes = state;
    struct api_buffer *out = turn->out;
    if (modes->near) return modes_run_real(modes, turn, done, error);
    if (modes->last) PEND_TRY(api_buffer_add(out, &modes->last, 1));
    do {
        enum pend_status status = modes_piece(modes, turn, done, error);
        if (status == PEND_NOT_FINITE && !error->text[0])
            return pend_fail(error, status, -1, 0,
                             "lengths, masses and gravity differ too much: a number of the modes "
                             "exceeds the range of a double");
        PEND_TRY(status);
    } while (!*done && !api_turn_over(turn));
    modes->last = 0;
    if (*done || !modes->begun || modes->format != &api_format_json) return PEND_OK;
    modes->last = out->data[--out->bytes];
    return PEND_OK;
}

static void modes_json(void *state) {
    struct modes *modes = state;
    api_writer_free(&modes->writer);
    api_writer_free(&modes->damped.writer);
    modes->format = modes->damped.format = &api_format_json;
    modes->begun = modes->row = 0;
}

static double modes_cost(const void *state) {
    const struct modes *modes = state;
    if (modes->near) return api_damped_cost(&modes->damped);
    return pend_modes_cost(modes->asked.tree.n, (int)modes->table.rows,
                           modes->asked.request.vectors);
}

/* the search takes a few hundred bytes per arm and frequency; vectors are stored once, and a second
 * time while equal branches are combined */
static double modes_bytes(const void *state) {
    const struct modes *modes = state;
    if (modes->near)
        return api_damped_bytes(&modes->damped) + api_tree_bytes(&modes->asked.tree) +
               api_states_bytes(modes->asked.start);
    double n = modes->asked.tree.n, count = (double)modes->table.rows;
    double vectors = modes->asked.request.vectors ? 2.2 * sizeof(double) * n * (count + 16) : 0;
    vectors += sizeof(double) * (count * modes->asked.derived.count + 2 * n);
    return 2048 * (n + 16) + 256 * count + vectors + sizeof(double) * (2.0 * PIECE_NUMBERS + n) +
           api_tree_bytes(&modes->asked.tree) + api_states_bytes(modes->asked.start) +
           (modes->format == &api_format_json ? 0 : api_writer_bytes(modes->format, &modes->table));
}

const struct api_op api_op_modes = {.name = "modes",
                                    .size = sizeof(struct modes),
                                    .body = 1,
                                    .terms = 1,
                                    .cart = 1,
                                    .samples = 1,
                                    .read = modes_read,
                                    .run = modes_run,
                                    .table = offsetof(struct modes, table),
                                    .cost = modes_cost,
                                    .bytes = modes_bytes,
                                    .stats = offsetof(struct modes, stats),
                                    .json = modes_json,
                                    .clear = modes_clear};
