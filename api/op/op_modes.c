/* POST /v1/modes: frequencies and shapes of small oscillations about an equilibrium, and a
 * start's part in each of them. Leaves to others: reading (tree_json, state_json), the modes
 * (core/modes/modes), the matrices (core/modes/matrix).
 * Invariant: all arrays with one entry a mode are in the same order: those that grow, fastest
 * first, then those that swing, slowest first. */
#include "api/op/op.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode_raw.h"
#include "api/json/json_out.h"
#include "api/read/state_json.h"
#include "core/modes/matrix.h"
#include "core/modes/modes.h"

static const double pi = 3.14159265358979323846;
static const char *const fields[] = {"pendulum", "about",   "select", "vectors", "normalize",
                                     "include",  "initial", "digits", NULL};

static const char *const matrix_names[] = {[PEND_MATRIX_A] = "A",
                                           [PEND_MATRIX_M] = "M",
                                           [PEND_MATRIX_S] = "S",
                                           [PEND_MATRIX_B] = "B",
                                           NULL};

static const char *const normalize_names[] = {"first", "mass", "max", NULL};
static const enum pend_normalize normalize_rules[] = {PEND_NORMALIZE_FIRST, PEND_NORMALIZE_MASS,
                                                      PEND_NORMALIZE_MAX};

/* what has one number a mode */
enum scalar { MODE, OMEGA, FREQUENCY, PERIOD, GROWTH, AMPLITUDE, PHASE, RISING, FALLING, SCALARS };

static const char *const scalar_names[] = {"mode",      "omega", "frequency", "period", "growth",
                                           "amplitude", "phase", "rising",    "falling"};

/* at most so many modes are split, or rows written, before the clock is looked at */
enum { PIECE_MODES = 32, PIECE_NUMBERS = 8192 };

struct modes {
    struct api_tree tree;
    struct api_states *start;          /* NULL = no start was given */
    struct pend_modes_request request; /* its gravity and vectors follow from the rest */
    unsigned char *up; /* n flags in stored order, arms that stand; NULL when all hang */
    int vectors;       /* are answered */
    char include[PEND_MATRIX_COUNT];
    const struct api_format *format;
    struct api_table table; /* as which every representation but JSON answers */
    struct pend_modes_search *search;

    /* once it runs */
    struct pend_modes *found;
    int split;               /* so many modes know their part of the start */
    double *scratch;         /* one block: */
    double *scalar[SCALARS]; /* one number a mode; NULL where it is not answered */
    double *line;            /* n numbers, or rows of the table */
    long lines;              /* rows of the table that fit there */
    struct api_writer *writer;
    char last;  /* byte of the JSON so far, kept back; 0 = none */
    int filled; /* the numbers that every mode has are there */
    int begun, part,
        row; /* what is written next: a row of the vectors (part 0) or of matrix part - 1 */
};

static void modes_free(void **state) {
    struct modes *modes = *state;
    if (!modes) return;
    api_writer_free(&modes->writer);
    free(modes->scratch);
    pend_modes_free(&modes->found);
    pend_modes_search_free(&modes->search);
    free(modes->up);
    api_states_free(&modes->start);
    api_tree_clear(&modes->tree);
    free(modes);
    *state = NULL;
}

/* reading */

/* ["down", "up", ...], one an arm */
static enum pend_status read_about(struct modes *modes, const struct api_value *value,
                                   struct api_problem *problem) {
    static const char *const words[] = {"down", "up", NULL};
    const struct pend_tree *tree = modes->tree.tree;
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) == API_MISSING) return PEND_OK;
    if (api_value_kind(value) != API_ARRAY || (tree && api_value_count(value) != tree->n)) {
        api_value_fault(value, problem,
                        "must be an array with \"down\" or \"up\" for each of the %d arms",
                        modes->tree.n);
        return PEND_OK;
    }
    if (tree && !(modes->up = calloc((size_t)tree->n, 1))) return PEND_NO_MEMORY;
    int standing = 0;
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int word = 0;
        if (api_field_word(&item, words, &word, problem) <= 0 || !tree) continue;
        modes->up[tree->place[item.index]] = (unsigned char)word;
        standing += word;
    }
    if (standing) return PEND_OK;
    free(modes->up);
    modes->up = NULL;
    return PEND_OK;
}

/* {"slowest": k} or {"fastest": k}; true when the object is of that kind */
static int read_extreme(struct modes *modes, const struct api_value *object, const char *name,
                        enum pend_select select, struct api_problem *problem) {
    struct api_value field = api_value_member(object, name);
    long count = 0;
    if (api_value_kind(&field) == API_MISSING) return 0;
    (void)api_field_whole(&field, 1, modes->tree.n ? modes->tree.n : 1000000000, &count, problem);
    modes->request.select = select;
    modes->request.count = (int)count;
    return 1;
}

/* {"from": w1, "to": w2} */
static void read_range(struct modes *modes, const struct api_value *object,
                       struct api_problem *problem) {
    struct api_value from = api_value_member(object, "from"), to = api_value_member(object, "to");
    modes->request.select = PEND_SELECT_BETWEEN;
    int good = api_field_needed(&from, problem) && api_field_needed(&to, problem);
    good &= api_value_read_number(&from, 0, INFINITY, "rad/s", &modes->request.from, problem) > 0;
    good &= api_value_read_number(&to, 0, INFINITY, "rad/s", &modes->request.to, problem) > 0;
    double low = modes->request.from, high = modes->request.to;
    if (good && low > high)
        api_value_fault(&to, problem, "must not be below from (%.15g rad/s), got %.15g", low, high);
}

static void read_select(struct modes *modes, const struct api_value *value,
                        struct api_problem *problem) {
    static const char *const words[] = {"all", NULL};
    static const char *const allowed[] = {"slowest", "fastest", "from", "to", NULL};
    int chosen;
    if (api_value_kind(value) != API_OBJECT) {
        if (api_field_word(value, words, &chosen, problem) > 0) api_value_usual(value);
        return;
    }
    struct api_value from = api_value_member(value, "from"), to = api_value_member(value, "to");
    (void)api_value_only(value, allowed, problem);
    int ways = read_extreme(modes, value, "slowest", PEND_SELECT_SLOWEST, problem);
    ways += read_extreme(modes, value, "fastest", PEND_SELECT_FASTEST, problem);
    if (api_value_kind(&from) != API_MISSING || api_value_kind(&to) != API_MISSING) {
        read_range(modes, value, problem);
        ways++;
    }
    if (ways != 1)
        api_value_fault(
            value, problem,
            "must be \"all\", or have one of \"slowest\", \"fastest\", and \"from\" with \"to\"");
}

static void read_include(struct modes *modes, const struct api_value *value,
                         const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) == API_MISSING) return;
    if (api_value_kind(value) != API_ARRAY)
        api_value_fault(value, problem, "must be an array of names of matrices");
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int matrix = 0;
        if (api_field_word(&item, matrix_names, &matrix, problem) <= 0) continue;
        if (modes->include[matrix])
            api_value_fault(&item, problem, "\"%s\" is in the list already", matrix_names[matrix]);
        modes->include[matrix] = 1;
    }
    if (api_value_count(value) && modes->tree.n > reading->limits->matrix_arms)
        api_value_fault(
            value, problem,
            "matrices are answered for at most %.0f arms (the limit max-matrix-arms), and "
            "here are %d: leave it out",
            reading->limits->matrix_arms, modes->tree.n);
    if (api_value_count(value) && reading->format != &api_format_json &&
        reading->format != &api_format_raw)
        api_value_fault(
            value, problem,
            "matrices are answered in %s only, not in %s: leave it out, or ask for that",
            api_format_json.media_type, reading->format->media_type);
}

/* the columns of the table, one row a mode */
static void modes_columns(struct modes *modes) {
    static const enum scalar always[] = {MODE, OMEGA, FREQUENCY};
    struct api_table *table = &modes->table;
    for (int i = 0; i < 3; i++) api_table_add(table, scalar_names[always[i]], NULL, 0);
    api_table_add(table, scalar_names[modes->up ? GROWTH : PERIOD], NULL, 0);
    if (modes->start) api_table_add(table, scalar_names[AMPLITUDE], NULL, 0);
    if (modes->start) api_table_add(table, scalar_names[PHASE], NULL, 0);
    if (modes->start && modes->up) api_table_add(table, scalar_names[RISING], NULL, 0);
    if (modes->start && modes->up) api_table_add(table, scalar_names[FALLING], NULL, 0);
    if (modes->vectors) api_table_add(table, "vectors", NULL, modes->tree.n);
}

/* faults an answer that would be too large, and modes that would be */
static void modes_check_size(const struct modes *modes, const struct api_reading *reading) {
    static const char fewer[] =
        "fewer modes by \"select\", or only the frequencies by \"vectors\": false";
    const struct api_table *table = &modes->table;
    double n = modes->tree.n, numbers = table->rows * api_table_numbers(table, 0),
           most = reading->limits->answer_bytes;
    if (modes->request.vectors && 8 * n * table->rows > most)
        api_value_fault(reading->root, reading->problem,
                        "asks for the vectors of %ld modes, which take %.0f bytes while they are "
                        "found, more than the "
                        "limit max-answer-bytes of %.0f: ask for %s",
                        table->rows, 8 * n * table->rows, most,
                        modes->start ? "fewer modes by \"select\"" : fewer);
    if (reading->format != &api_format_json) {
        api_reading_check_size(reading, table, reading->root, "modes", fewer);
        return;
    }
    for (int i = 0; i < PEND_MATRIX_COUNT; i++) numbers += modes->include[i] ? n * n : 0;
    double bytes = numbers * api_out_number_bytes(table->digits) + 4 * n + 1000;
    char flowing[API_FORMATS_TEXT];
    api_format_list(flowing, 1, 1);
    if (bytes > most)
        api_value_fault(reading->root, reading->problem,
                        "asks for %.0f numbers, up to %.0f bytes, more than the limit "
                        "max-answer-bytes of %.0f: ask for "
                        "%s, include fewer matrices, round the numbers by \"digits\", or ask for a "
                        "representation "
                        "without such a limit: %s",
                        numbers, bytes, most, fewer, flowing);
}

/* begins the search, so that it is known how many modes there will be */
static enum pend_status modes_begin_search(struct modes *modes, const struct api_reading *reading) {
    struct pend_error error = {.text = ""};
    modes->request.loads = modes->tree.loads;
    modes->request.vectors = modes->vectors || modes->start;
    modes->request.up = modes->up;
    enum pend_status status =
        pend_modes_search_new(&modes->search, modes->tree.tree, &modes->request, &error);
    if (status == PEND_INVALID) api_value_fault(reading->root, reading->problem, "%s", error.text);
    if (status) return status;
    modes->table.rows = pend_modes_search_count(modes->search);
    modes_columns(modes);
    struct api_value pendulum = api_value_member(reading->root, "pendulum");
    api_tree_modes_allowed(&modes->tree, &pendulum, (int)modes->table.rows, "finding the modes",
                           reading->limits, reading->problem);
    modes_check_size(modes, reading);
    return PEND_OK;
}

static enum pend_status modes_read_parts(struct modes *modes, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value pendulum = api_value_member(root, "pendulum"),
                     select = api_value_member(root, "select");
    struct api_value vectors = api_value_member(root, "vectors"),
                     normalize = api_value_member(root, "normalize");
    struct api_value include = api_value_member(root, "include"),
                     initial = api_value_member(root, "initial");
    struct api_value digits = api_value_member(root, "digits"),
                     about = api_value_member(root, "about");
    long rounded = 0;
    int rule = 0;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_tree_read(&modes->tree, &pendulum, reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    if (modes->tree.n)
        api_tree_modes_allowed(&modes->tree, &pendulum, 0, "finding the modes", reading->limits,
                               problem);
    if (api_value_kind(&initial) != API_MISSING && status == PEND_OK)
        PEND_TRY(api_states_new(&modes->start, 1, modes->tree.n));
    api_states_read(modes->start, 0, &initial, &modes->tree, reading->limits, problem);
    PEND_TRY(read_about(modes, &about, problem));
    read_select(modes, &select, problem);
    if (api_field_truth(&vectors, &modes->vectors, problem) > 0 && modes->vectors)
        api_value_usual(&vectors);
    if (api_field_word(&normalize, normalize_names, &rule, problem) > 0 && !rule)
        api_value_usual(&normalize);
    modes->request.normalize = normalize_rules[rule];
    read_include(modes, &include, reading);
    (void)api_field_whole(&digits, 1, 17, &rounded, problem);
    modes->table.digits = (int)rounded;
    if (!problem->status) PEND_TRY(modes_begin_search(modes, reading));
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status modes_read(void **state, const struct api_reading *reading) {
    struct modes *modes = calloc(1, sizeof *modes);
    *state = modes;
    if (!modes) return PEND_NO_MEMORY;
    modes->vectors = 1;
    modes->format = reading->format;
    enum pend_status status = modes_read_parts(modes, reading);
    if (status != PEND_OK) modes_free(state);
    return status;
}

/* running */

/* one block: a row or a few, and the numbers that every mode has; where a start is split they
 * are found in place */
static enum pend_status modes_allocate(struct modes *modes, struct pend_error *error) {
    size_t n = (size_t)modes->tree.n, count = (size_t)modes->found->count;
    long lines = PIECE_NUMBERS / (long)n;
    modes->lines = lines < 1 ? 1 : lines;
    modes->scratch = malloc(((size_t)modes->lines * n + SCALARS * count) * sizeof *modes->scratch);
    if (!modes->scratch)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %zu arms", n);
    modes->line = modes->scratch;
    for (int i = 0; i < SCALARS; i++)
        modes->scalar[i] = modes->scratch + (size_t)modes->lines * n + (size_t)i * count;
    return PEND_OK;
}

/* the start becomes a deviation from the equilibrium */
static enum pend_status modes_settle_start(struct modes *modes, struct pend_error *error) {
    PEND_TRY(api_states_settle(modes->start, &modes->tree, error));
    for (int k = 0; k < modes->tree.n; k++)
        modes->start->phi[k] =
            modes->up && modes->up[k]
                ? pend_modes_theta(modes->start->phi[k] - pi, 0)
                : pend_modes_theta(modes->start->phi[k], modes->start->phi_low[k]);
    return PEND_OK;
}

/* what all numbers but the vectors follow from */
static void modes_fill(const struct modes *modes) {
    for (int k = 0; k < modes->found->count; k++) {
        double omega = modes->found->omega[k], swings = omega > 0 ? omega : 0;
        modes->scalar[MODE][k] = modes->found->first + k + 1;
        modes->scalar[OMEGA][k] = swings;
        modes->scalar[FREQUENCY][k] = swings / (2 * pi);
        modes->scalar[PERIOD][k] = swings > 0 ? 2 * pi / swings : 0;
        modes->scalar[GROWTH][k] = omega < 0 ? -omega : 0;
        if (!modes->start) continue;
        /* the split has put what it found of either kind under amplitude and phase */
        modes->scalar[RISING][k] = omega < 0 ? modes->scalar[AMPLITUDE][k] : 0;
        modes->scalar[FALLING][k] = omega < 0 ? modes->scalar[PHASE][k] : 0;
        if (omega < 0) modes->scalar[AMPLITUDE][k] = modes->scalar[PHASE][k] = 0;
    }
}

/* a few modes' part of the start */
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
    return pend_modes_decompose(&few, modes->tree.tree, modes->up, modes->start->phi,
                                modes->start->rate, modes->scalar[AMPLITUDE] + done,
                                modes->scalar[PHASE] + done);
}

/* a vector in the caller's order */
static void modes_vector(const struct modes *modes, int mode, double line[]) {
    const struct pend_tree *tree = modes->tree.tree;
    const double *vector = modes->found->vector + (size_t)mode * (size_t)tree->n;
    for (int k = 0; k < tree->n; k++) line[tree->order[k]] = vector[k];
}

/* sum 1/omega^2 = l_tot/g, where a growing mode and a standing arm count below 0 */
static enum pend_status write_identity(const struct modes *modes, struct api_buffer *out) {
    const struct pend_tree *tree = modes->tree.tree;
    double sum = 0, lengths = 0, all = tree->length_total / modes->tree.loads.gravity;
    for (int k = modes->found->count - 1; k >= 0; k--)
        sum += 1 / (modes->found->omega[k] * fabs(modes->found->omega[k]));
    for (int k = 0; modes->up && k < tree->n; k++)
        lengths += (modes->up[k] ? -tree->len[k] : tree->len[k]) / modes->tree.loads.gravity;
    if (!modes->up) lengths = all;
    PEND_TRY(api_out_open(out, "identity", '{'));
    PEND_TRY(api_out_number(out, "sum_inverse_omega_squared", sum, modes->table.digits));
    PEND_TRY(api_out_number(out, "length_total_over_g", lengths, modes->table.digits));
    PEND_TRY(
        api_out_number(out, "relative_difference", fabs(sum - lengths) / all, modes->table.digits));
    return api_buffer_text(out, "}");
}

/* the number of a name among the scalars, SCALARS for none */
static int scalar_of(const char *name) {
    int i = 0;
    while (i < SCALARS && strcmp(scalar_names[i], name)) i++;
    return i;
}

/* JSON: everything with one entry a mode */
static enum pend_status write_lists(const struct modes *modes, struct api_buffer *out) {
    const struct api_table *table = &modes->table;
    int identity = modes->request.select == PEND_SELECT_ALL;
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
    return part ? modes->include[part - 1] : modes->vectors;
}

/* JSON: the next row of the vectors or of a matrix, or the end */
static enum pend_status write_row(struct modes *modes, struct api_buffer *out, int *done) {
    int n = modes->tree.n, part = modes->part, rows = part ? n : modes->found->count;
    if (part > PEND_MATRIX_COUNT) {
        *done = 1;
        return api_buffer_text(out, "}");
    }
    if (part_wanted(modes, part) && !modes->row)
        PEND_TRY(api_out_open(out, part ? matrix_names[part - 1] : "vectors", '['));
    if (!part_wanted(modes, part) || modes->row == rows) {
        if (part_wanted(modes, part)) PEND_TRY(api_buffer_text(out, "]"));
        modes->part++;
        modes->row = 0;
        return PEND_OK;
    }
    if (part)
        pend_matrix_row(modes->tree.tree, &modes->tree.loads, modes->up,
                        (enum pend_matrix)(part - 1), modes->row, modes->line);
    else
        modes_vector(modes, modes->row, modes->line);
    modes->row++;
    return api_out_numbers(out, NULL, n, modes->line, modes->table.digits);
}

/* other representations: the next rows of the table, or a piece of what comes behind them */
static enum pend_status write_rows(struct modes *modes, struct api_buffer *out, int *done,
                                   struct pend_error *error) {
    const struct api_table *table = &modes->table;
    const double *data[API_COLUMNS];
    if (!modes->writer) PEND_TRY(api_writer_new(&modes->writer, modes->format, table, out));
    long rows = table->rows - modes->row < modes->lines ? table->rows - modes->row : modes->lines;
    if (!rows) return api_writer_finish(modes->writer, NULL, out, done);
    for (int c = 0; c < table->count; c++) {
        int which = scalar_of(table->column[c].name);
        data[c] = which == SCALARS ? modes->line : modes->scalar[which] + modes->row;
    }
    for (long i = 0; modes->vectors && i < rows; i++)
        modes_vector(modes, modes->row + (int)i, modes->line + i * modes->tree.n);
    modes->row += (int)rows;
    return api_writer_block(modes->writer, rows, data, out, error);
}

/* the search comes to its end: what follows needs memory */
static enum pend_status modes_found(struct modes *modes, struct pend_error *error) {
    modes->found = pend_modes_search_take(modes->search);
    pend_modes_search_free(&modes->search);
    return modes_allocate(modes, error);
}

/* a piece of the search, of the split, or of the answer */
static enum pend_status modes_piece(struct modes *modes, struct api_buffer *out, int *done,
                                    struct pend_error *error) {
    int found = 0;
    if (modes->search) {
        PEND_TRY(pend_modes_search_step(modes->search, &found, error));
        return found ? modes_found(modes, error) : PEND_OK;
    }
    if (modes->start && modes->split < modes->found->count) return modes_split(modes, error);
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

/* JSON's commas follow from what was written last, and what a turn wrote may be taken away after
 * it: its last byte is kept back for the next turn */
static enum pend_status modes_run(void *state, const struct api_turn *turn, int *done,
                                  struct pend_error *error) {
    struct modes *modes = state;
    struct api_buffer *out = turn->out;
    if (modes->last) PEND_TRY(api_buffer_add(out, &modes->last, 1));
    do {
        enum pend_status status = modes_piece(modes, out, done, error);
        if (status == PEND_NOT_FINITE && !error->text[0])
            return pend_fail(error, status, -1, 0,
                             "lengths, masses and gravity are too far apart: a number of the modes "
                             "is beyond those that "
                             "a double holds");
        PEND_TRY(status);
    } while (!*done && !api_turn_over(turn));
    modes->last = 0;
    if (*done || !modes->begun || modes->format != &api_format_json) return PEND_OK;
    modes->last = out->data[--out->bytes];
    return PEND_OK;
}

/* what was found is kept, and written from its first number on */
static void modes_json(void *state) {
    struct modes *modes = state;
    api_writer_free(&modes->writer);
    modes->format = &api_format_json;
    modes->begun = modes->row = 0;
}

static const struct api_table *modes_table(const void *state) {
    return &((const struct modes *)state)->table;
}

static double modes_cost(const void *state) {
    const struct modes *modes = state;
    return pend_modes_cost(modes->tree.n, (int)modes->table.rows, modes->request.vectors);
}

/* a frequency is searched for in a few hundred bytes an arm. Vectors are kept once, and a second
 * time while like branches are put together; a row of them is made orthogonal to those of its
 * crowd */
static double modes_bytes(const void *state) {
    const struct modes *modes = state;
    double n = modes->tree.n, count = (double)modes->table.rows;
    double vectors = modes->request.vectors ? 2.2 * sizeof(double) * n * (count + 16) : 0;
    return 2048 * (n + 16) + 256 * count + vectors + sizeof(double) * (2.0 * PIECE_NUMBERS + n) +
           api_tree_bytes(&modes->tree) + api_states_bytes(modes->start) +
           (modes->format == &api_format_json ? 0 : api_writer_bytes(modes->format, &modes->table));
}

const struct api_op api_op_modes = {.name = "modes",
                                    .body = 1,
                                    .samples = 1,
                                    .read = modes_read,
                                    .run = modes_run,
                                    .table = modes_table,
                                    .cost = modes_cost,
                                    .bytes = modes_bytes,
                                    .json = modes_json,
                                    .free = modes_free};
