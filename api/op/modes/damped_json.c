#include "api/op/modes/damped_json.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "api/encode/stats_text.h"
#include "api/json/json_out.h"
#include "core/modes/rest.h"
#include "core/tree/turns.h"

/* columns of a cart exist only for a pendulum on a cart */
enum column {
    MODE,
    OMEGA,
    FREQUENCY,
    DECAY,
    RATIO,
    GROWTH,
    CART_REST,
    CART_RE,
    CART_IM,
    EQUILIBRIUM,
    RE,
    IM,
    COLUMNS
};

static const struct {
    const char *name, *part;
} columns[COLUMNS] = {
    [MODE] = {"mode", NULL},
    [OMEGA] = {"omega", NULL},
    [FREQUENCY] = {"frequency", NULL},
    [DECAY] = {"decay", NULL},
    [RATIO] = {"damping_ratio", NULL},
    [GROWTH] = {"growth", NULL},
    [CART_REST] = {"cart", "equilibrium"},
    [CART_RE] = {"cart", "re"},
    [CART_IM] = {"cart", "im"},
    [EQUILIBRIUM] = {"equilibrium", NULL},
    [RE] = {"vectors", "re"},
    [IM] = {"vectors", "im"},
};

/* growth rate, relative to the fastest mode, that may be due to rounding */
static const double damped_still = 1e-9;

/* s per square of the number of arms without a matrix, undamped and damped; s per cube, with
 * matrices of 2 n rows */
static const double still_seconds = 1e-6, lossy_seconds = 1e-5, damped_seconds = 2.5e-7;

static int damped_loses(const struct api_damped *damped) {
    return pend_loads_lose(&damped->tree->loads);
}

static int damped_tells(const struct api_damped *damped, int column) {
    assert(column >= 0 && column < COLUMNS);
    int cart = column >= CART_REST && column <= CART_IM;
    int shape = column >= RE || column == CART_RE || column == CART_IM;
    return (!cart || damped->tree->cart) && (!shape || damped->vectors);
}

void api_damped_init(struct api_damped *damped, const struct api_tree *tree, const double phi[],
                     const struct api_format *format, int digits, int vectors,
                     const char include[PEND_MATRIX_COUNT]) {
    assert(tree->loads.terms);
    *damped = (struct api_damped){.tree = tree,
                                  .phi = phi,
                                  .format = format,
                                  .table = damped->table,
                                  .stats = damped->stats,
                                  .vectors = vectors,
                                  .include = include};
    damped->table->digits = digits;
    damped->table->rows = 2 * (long)api_tree_stored(tree);
    damped->table->rows_later = 1;
    for (int c = 0; c < COLUMNS; c++)
        if (damped_tells(damped, c))
            api_table_add(damped->table, columns[c].name, columns[c].part,
                          c >= EQUILIBRIUM ? tree->n : 0);
}

void api_damped_clear(struct api_damped *damped) {
    api_writer_free(&damped->writer);
    free(damped->column[0]);
    pend_damped_free(&damped->found);
}

/* ---- running */

static void damped_fill(const struct api_damped *damped, int j) {
    const struct pend_damped *found = damped->found;
    size_t row = (size_t)j * (size_t)damped->tree->n, from = (size_t)j * (size_t)found->n;
    double size = hypot(found->omega[j], found->decay[j]);
    damped->column[MODE][j] = j + 1;
    damped->column[OMEGA][j] = found->omega[j];
    damped->column[FREQUENCY][j] = found->omega[j] / (2 * M_PI);
    damped->column[DECAY][j] = 0 - found->decay[j];
    damped->column[GROWTH][j] = found->decay[j];
    damped->column[RATIO][j] = size > 0 ? 0 - found->decay[j] / size : 0;
    damped->column[CART_REST][j] = found->phi[0];
    damped->column[CART_RE][j] = found->re[from];
    damped->column[CART_IM][j] = found->im[from];
    api_tree_put(damped->tree, found->phi, damped->column[EQUILIBRIUM] + row);
    api_tree_put(damped->tree, found->re + from, damped->column[RE] + row);
    api_tree_put(damped->tree, found->im + from, damped->column[IM] + row);
}

/* the rate of a joint in a swing of the mode, of 0.1 rad at the arm with the largest amplitude,
 * relative to the speed up to which dry friction is linear */
static double damped_rub(const struct api_damped *damped, int j, int k) {
    static const double swing = 0.1;
    const struct pend_damped *found = damped->found;
    const struct pend_loads *loads = &damped->tree->loads;
    const double *re = found->re + j * found->n, *im = found->im + j * found->n;
    int holder = pend_terms_holder(loads->terms, damped->tree->tree->parent, k);
    double x = re[k] - (holder < 0 ? 0 : re[holder]), y = im[k] - (holder < 0 ? 0 : im[holder]);
    return pend_rest_beyond(loads, k, swing * hypot(found->omega[j], found->decay[j]) * hypot(x, y),
                            0);
}

/* adds whether the equilibrium is stable, and warnings for neglected or linearized terms */
static void damped_tell(struct api_damped *damped) {
    static const double rub_most = 0.3;
    const struct pend_damped *found = damped->found;
    const struct pend_terms *terms = damped->tree->loads.terms;
    double most = 0, shaken = 0, fastest = 0;
    int mode = 0, stable = 1;
    for (int j = 0; j < found->count; j++)
        fastest = fmax(fastest, hypot(found->omega[j], found->decay[j]));
    for (int j = 0; j < found->count; j++) {
        stable &= found->decay[j] <= damped_still * fastest;
        for (int k = 0; k < found->n; k++) {
            double rub = damped_rub(damped, j, k);
            if (rub > most) most = rub, mode = j + 1;
        }
    }
    for (int i = 0; i < terms->harmonics; i++) {
        const double *h = damped->tree->value + terms->harmonic[i].at;
        if (terms->harmonic[i].drives < 0) shaken += fabs(h[0] * h[1]);
    }
    api_stats_whole(damped->stats, "stable", stable);
    if (most > rub_most) {
        snprintf(
            damped->warning[0], API_WARNING_TEXT,
            "a swing of 0.1 rad in mode %d moves a joint at %.3g times the speed below which its "
            "dry friction is linear: the linear mode is not valid there. Integrate the motion.",
            mode, most);
        api_stats_warning(damped->stats, "warning_friction", damped->warning[0]);
    }
    if (!(shaken > 0)) return;
    snprintf(damped->warning[1], API_WARNING_TEXT,
             "the pivot is shaken at up to %.3g m/s, which the modes ignore: shaking changes "
             "frequencies and can stabilize other equilibria (Kapitza). Integrate the motion.",
             shaken);
    api_stats_warning(damped->stats, "warning_pivot", damped->warning[1]);
}

/* continues the search; sets *found once there are rows to write */
static enum pend_status damped_find(struct api_damped *damped, int *found,
                                    struct pend_error *error) {
    const struct api_tree *tree = damped->tree;
    *found = 0;
    if (!damped->found)
        return pend_damped_begin(&damped->found, tree->tree, &tree->loads, damped->phi, error);
    PEND_TRY(pend_damped_step(&damped->found, found, error));
    if (!*found) return PEND_OK;
    size_t n = (size_t)tree->n, rows = (size_t)damped->found->count;
    double *at = malloc((EQUILIBRIUM + 3 * n) * rows * sizeof *at);
    if (!at) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes");
    for (int c = 0; c < COLUMNS; c++) {
        damped->column[c] = at;
        at += rows * (c >= EQUILIBRIUM ? n : 1);
    }
    damped->table->rows = (long)rows;
    for (int j = 0; j < damped->found->count; j++) damped_fill(damped, j);
    for (int c = 0, told = 0; c < COLUMNS; c++)
        if (damped_tells(damped, c)) damped->told[told++] = damped->column[c];
    damped_tell(damped);
    return PEND_OK;
}

static enum pend_status damped_rows(const struct api_damped *damped, const char *name,
                                    const double row[], struct api_buffer *out) {
    int n = damped->tree->n;
    PEND_TRY(api_out_open(out, name, '['));
    for (long j = 0; j < damped->table->rows; j++)
        PEND_TRY(api_out_numbers(out, NULL, n, row + j * n, damped->table->digits));
    return api_buffer_text(out, "]");
}

/* writes the cart's entries of the equilibrium and of the shapes */
static enum pend_status damped_cart(const struct api_damped *damped, struct api_buffer *out) {
    int rows = (int)damped->table->rows, digits = damped->table->digits;
    if (!damped->tree->cart) return PEND_OK;
    PEND_TRY(api_out_open(out, "cart", '{'));
    PEND_TRY(api_out_number(out, "equilibrium", damped->column[CART_REST][0], digits));
    for (int c = CART_RE; c <= CART_IM && damped->vectors; c++)
        PEND_TRY(api_out_numbers(out, columns[c].part, rows, damped->column[c], digits));
    return api_buffer_text(out, "}");
}

/* writes the requested matrices; a cart has the last row and column */
static enum pend_status damped_matrices(const struct api_damped *damped, struct api_buffer *out,
                                        struct pend_error *error) {
    const struct api_tree *tree = damped->tree;
    size_t n = (size_t)api_tree_stored(tree);
    for (int i = 0; i < PEND_MATRIX_COUNT; i++) {
        if (!damped->include[i]) continue;
        double *matrix = malloc(n * n * sizeof *matrix);
        if (!matrix) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a matrix");
        enum pend_status status = pend_damped_matrix(tree->tree, &tree->loads, damped->found->phi,
                                                     (enum pend_matrix)i, matrix);
        if (status == PEND_OK)
            status =
                api_out_matrix(out, pend_matrix_names[i], (int)n, matrix, damped->table->digits);
        free(matrix);
        PEND_TRY(status);
    }
    return PEND_OK;
}

/* writes the equilibrium, then lists with one entry per mode, then the shapes */
static enum pend_status damped_json(const struct api_damped *damped, struct api_buffer *out,
                                    struct pend_error *error) {
    int digits = damped->table->digits;
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(
        api_out_numbers(out, "equilibrium", damped->tree->n, damped->column[EQUILIBRIUM], digits));
    for (int c = 0; c < CART_REST; c++)
        PEND_TRY(api_out_numbers(out, columns[c].name, (int)damped->table->rows, damped->column[c],
                                 c == MODE ? 0 : digits));
    PEND_TRY(damped_cart(damped, out));
    if (damped->vectors) {
        PEND_TRY(api_out_open(out, "vectors", '{'));
        PEND_TRY(damped_rows(damped, "re", damped->column[RE], out));
        PEND_TRY(damped_rows(damped, "im", damped->column[IM], out));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    PEND_TRY(damped_matrices(damped, out, error));
    PEND_TRY(api_stats_json(damped->stats, out));
    return api_buffer_text(out, "}");
}

enum pend_status api_damped_run(struct api_damped *damped, const struct api_turn *turn, int *done,
                                struct pend_error *error) {
    struct api_buffer *out = turn->out;
    int found = damped->told[0] != NULL;
    if (!found) {
        PEND_TRY(damped_find(damped, &found, error));
        if (!found) return PEND_OK;
        api_turn_tell(turn, 0, damped->stats);
    }
    if (damped->format == &api_format_json) {
        *done = 1;
        return damped_json(damped, out, error);
    }
    if (damped->writer) return api_writer_finish(damped->writer, damped->stats, out, done);
    PEND_TRY(api_writer_new(&damped->writer, damped->format, damped->table, out));
    return api_writer_block(damped->writer, damped->table->rows, damped->told, out, error);
}

double api_damped_cost(const struct api_damped *damped) {
    double n = api_tree_stored(damped->tree);
    if (!damped_loses(damped)) return n * n * still_seconds;
    return n * n * (n > PEND_DAMPED_DENSE ? lossy_seconds : n * damped_seconds);
}

double api_damped_bytes(const struct api_damped *damped) {
    double n = api_tree_stored(damped->tree), text = 0;
    for (int i = 0; i < PEND_MATRIX_COUNT; i++)
        text += damped->include[i] ? n * n * API_OUT_NUMBER_BYTES : 0;
    return sizeof(double) * n * ((damped_loses(damped) ? 32 : 12) * n + 64) + text +
           (damped->format == &api_format_json ? 0
                                               : api_writer_bytes(damped->format, damped->table));
}
