/* POST /v1/modes: frequencies and shapes of small oscillations about hanging, and a start's part in each of them.
 * Leaves to others: reading (tree_json, state_json), the modes (core/modes), the matrices (core/reference, tree).
 * Invariant: all arrays with one entry a mode are in the same order, slowest first. */
#include "api/op.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "api/json_out.h"
#include "api/state_json.h"
#include "core/modes.h"
#include "core/reference.h"

static const double pi = 3.14159265358979323846;
static const char *const fields[] = {"pendulum", "select",  "vectors", "normalize",
                                     "include",  "initial", "digits",  NULL};

/* the matrices that can be included, in the order in which they are answered */
enum matrix { MATRIX_A, MATRIX_M, MATRIX_S, MATRIX_B, MATRICES };

static const char *const matrix_names[] = {"A", "M", "S", "B", NULL};

static const char *const normalize_names[] = {
    [PEND_NORMALIZE_FIRST] = "first", [PEND_NORMALIZE_MASS] = "mass", [PEND_NORMALIZE_MAX] = "max", NULL};

struct modes {
    struct api_tree tree;
    struct api_states *start;          /* NULL = no start was given */
    struct pend_modes_request request; /* its gravity and vectors follow from the rest */
    int vectors;                       /* are answered */
    int normalize;                     /* enum pend_normalize */
    char include[MATRICES];
    int digits;

    /* once it runs */
    struct pend_modes *found;
    double *scratch; /* n numbers each: a row, amplitudes, phases; then n x n where one is included */
    int part, row;   /* what is written next: a row of the vectors (part 0) or of matrix part - 1 */
};

static void modes_free(void **state) {
    struct modes *modes = *state;
    if (!modes) return;
    free(modes->scratch);
    pend_modes_free(&modes->found);
    api_states_free(&modes->start);
    api_tree_clear(&modes->tree);
    free(modes);
    *state = NULL;
}

/* reading */

/* {"slowest": k} or {"fastest": k}; true when the object is of that kind */
static int read_extreme(struct modes *modes, const struct api_value *object, const char *name, enum pend_select select,
                        struct api_problem *problem) {
    struct api_value field = api_value_member(object, name);
    long count = 0;
    if (api_value_kind(&field) == API_MISSING) return 0;
    (void)api_field_whole(&field, 1, modes->tree.n ? modes->tree.n : 1000000000, &count, problem);
    modes->request.select = select;
    modes->request.count = (int)count;
    return 1;
}

/* {"from": w1, "to": w2} */
static void read_range(struct modes *modes, const struct api_value *object, struct api_problem *problem) {
    struct api_value from = api_value_member(object, "from"), to = api_value_member(object, "to");
    modes->request.select = PEND_SELECT_BETWEEN;
    int good = api_field_needed(&from, problem) && api_field_needed(&to, problem);
    good &= api_value_read_number(&from, 0, INFINITY, "rad/s", &modes->request.from, problem) > 0;
    good &= api_value_read_number(&to, 0, INFINITY, "rad/s", &modes->request.to, problem) > 0;
    double low = modes->request.from, high = modes->request.to;
    if (good && low > high) api_value_fault(&to, problem, "must not be below from (%.15g rad/s), got %.15g", low, high);
}

static void read_select(struct modes *modes, const struct api_value *value, struct api_problem *problem) {
    static const char *const words[] = {"all", NULL};
    static const char *const allowed[] = {"slowest", "fastest", "from", "to", NULL};
    int chosen;
    if (api_value_kind(value) != API_OBJECT) {
        (void)api_field_word(value, words, &chosen, problem);
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
        api_value_fault(value, problem,
                        "must be \"all\", or have one of \"slowest\", \"fastest\", and \"from\" with \"to\"");
}

static void read_include(struct modes *modes, const struct api_value *value, const struct api_limits *limits,
                         struct api_problem *problem) {
    struct api_value item = api_value_item(value, 0);
    if (api_value_kind(value) == API_MISSING) return;
    if (api_value_kind(value) != API_ARRAY) api_value_fault(value, problem, "must be an array of names of matrices");
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int matrix = 0;
        if (api_field_word(&item, matrix_names, &matrix, problem) <= 0) continue;
        if (modes->include[matrix])
            api_value_fault(&item, problem, "\"%s\" is in the list already", matrix_names[matrix]);
        modes->include[matrix] = 1;
    }
    if (api_value_count(value) && modes->tree.n > limits->matrix_arms)
        api_value_fault(value, problem,
                        "matrices are answered for at most %.0f arms (the limit max-matrix-arms), and "
                        "here are %d: leave it out",
                        limits->matrix_arms, modes->tree.n);
}

/* faults an answer that would be too large */
static void modes_check_size(const struct modes *modes, const struct api_reading *reading) {
    double n = modes->tree.n, numbers = n * (modes->start ? 6 : 4), count = n;
    if (modes->request.count) count = modes->request.count;
    if (modes->vectors) numbers += count * n;
    for (int i = 0; i < MATRICES; i++) numbers += modes->include[i] ? n * n : 0;
    double bytes = numbers * api_out_number_bytes(modes->digits) + 10 * n + 2000;
    if (bytes > reading->limits->answer_bytes)
        api_value_fault(reading->root, reading->problem,
                        "asks for %.0f numbers, up to %.0f bytes, more than the limit max-answer-bytes of %.0f: select "
                        "fewer modes, include fewer matrices, or leave out the vectors",
                        numbers, bytes, reading->limits->answer_bytes);
}

static enum pend_status modes_read_parts(struct modes *modes, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value pendulum = api_value_member(root, "pendulum"), select = api_value_member(root, "select");
    struct api_value vectors = api_value_member(root, "vectors"), normalize = api_value_member(root, "normalize");
    struct api_value include = api_value_member(root, "include"), initial = api_value_member(root, "initial");
    struct api_value digits = api_value_member(root, "digits");
    long rounded = 0;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_tree_read(&modes->tree, &pendulum, reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    if (modes->tree.n) api_tree_modes_allowed(&modes->tree, &pendulum, "finding the modes", reading->limits, problem);
    if (api_value_kind(&initial) != API_MISSING && status == PEND_OK)
        PEND_TRY(api_states_new(&modes->start, 1, modes->tree.n));
    api_states_read(modes->start, 0, &initial, &modes->tree, reading->limits, problem);
    read_select(modes, &select, problem);
    (void)api_field_truth(&vectors, &modes->vectors, problem);
    (void)api_field_word(&normalize, normalize_names, &modes->normalize, problem);
    read_include(modes, &include, reading->limits, problem);
    (void)api_field_whole(&digits, 1, 17, &rounded, problem);
    modes->digits = (int)rounded;
    if (!problem->status) modes_check_size(modes, reading);
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status modes_read(void **state, const struct api_reading *reading) {
    struct modes *modes = calloc(1, sizeof *modes);
    *state = modes;
    if (!modes) return PEND_NO_MEMORY;
    modes->vectors = 1;
    modes->normalize = PEND_NORMALIZE_FIRST;
    enum pend_status status = modes_read_parts(modes, reading);
    if (status != PEND_OK) modes_free(state);
    return status;
}

/* running */

static enum pend_status modes_compute(struct modes *modes, struct pend_error *error) {
    const struct api_tree *tree = &modes->tree;
    size_t n = (size_t)tree->n;
    int matrices = 0;
    for (int i = 0; i < MATRICES; i++) matrices |= modes->include[i];
    modes->scratch = calloc(n, (matrices ? n + 3 : 3) * sizeof *modes->scratch);
    if (!modes->scratch) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %zu arms", n);
    modes->request.gravity = tree->gravity;
    modes->request.vectors = modes->vectors || modes->start;
    modes->request.normalize = (enum pend_normalize)modes->normalize;
    PEND_TRY(pend_modes_select(&modes->found, tree->tree, &modes->request, error));
    if (!modes->start) return PEND_OK;
    PEND_TRY(api_states_settle(modes->start, tree, error));
    for (size_t k = 0; k < n; k++) modes->start->phi[k] = pend_modes_theta(modes->start->phi[k]);
    return pend_modes_decompose(modes->found, tree->tree, modes->start->phi, modes->start->rate, modes->scratch + n,
                                modes->scratch + 2 * n);
}

/* sum 1/omega^2 = l_tot/g */
static enum pend_status write_identity(const struct modes *modes, struct api_buffer *out) {
    double sum = 0, lengths = modes->tree.tree->length_total / modes->tree.gravity;
    for (int k = modes->found->count - 1; k >= 0; k--) sum += 1 / (modes->found->omega[k] * modes->found->omega[k]);
    PEND_TRY(api_out_open(out, "identity", '{'));
    PEND_TRY(api_out_number(out, "sum_inverse_omega_squared", sum, modes->digits));
    PEND_TRY(api_out_number(out, "length_total_over_g", lengths, modes->digits));
    PEND_TRY(api_out_number(out, "relative_difference", fabs(sum - lengths) / lengths, modes->digits));
    return api_buffer_text(out, "}");
}

/* everything with one entry a mode */
static enum pend_status write_lists(const struct modes *modes, struct api_buffer *out) {
    const double *omega = modes->found->omega;
    double *row = modes->scratch;
    size_t n = (size_t)modes->tree.n;
    int count = modes->found->count, digits = modes->digits;
    for (int k = 0; k < count; k++) row[k] = modes->found->first + k + 1;
    PEND_TRY(api_out_numbers(out, "mode", count, row, 0));
    PEND_TRY(api_out_numbers(out, "omega", count, omega, digits));
    for (int k = 0; k < count; k++) row[k] = omega[k] / (2 * pi);
    PEND_TRY(api_out_numbers(out, "frequency", count, row, digits));
    for (int k = 0; k < count; k++) row[k] = 2 * pi / omega[k];
    PEND_TRY(api_out_numbers(out, "period", count, row, digits));
    if (modes->request.select == PEND_SELECT_ALL) PEND_TRY(write_identity(modes, out));
    if (!modes->start) return PEND_OK;
    PEND_TRY(api_out_numbers(out, "amplitude", count, modes->scratch + n, digits));
    return api_out_numbers(out, "phase", count, modes->scratch + 2 * n, digits);
}

static double *modes_matrix(const struct modes *modes) { return modes->scratch + 3 * (size_t)modes->tree.n; }

/* the columns of a matrix from the stored order to the caller's, in place, by way of a row */
static void matrix_order_columns(const struct pend_tree *tree, double matrix[], double row[]) {
    size_t n = (size_t)tree->n;
    for (size_t k = 0; k < n; k++) {
        double *at = matrix + k * n;
        for (size_t j = 0; j < n; j++) row[tree->order[j]] = at[j];
        memcpy(at, row, n * sizeof *row);
    }
}

/* computes a matrix; A and M have columns in the caller's order and rows still in the stored one */
static enum pend_status matrix_compute(const struct modes *modes, enum matrix which, double matrix[],
                                       struct pend_error *error) {
    const struct pend_tree *tree = modes->tree.tree;
    size_t n = (size_t)tree->n;
    enum pend_status status = PEND_OK;
    if (which == MATRIX_S) pend_tree_path(tree, matrix);
    if (which == MATRIX_B) pend_tree_force_map(tree, matrix);
    if (which == MATRIX_A) status = pend_reference_linearization(tree, modes->tree.gravity, matrix, NULL);
    if (which == MATRIX_M) {
        double *im = malloc(n * n * sizeof *im);
        memset(modes->scratch, 0, n * sizeof *im); /* all angles equal: M is real then */
        status = im ? pend_reference_mass_matrix(tree, modes->scratch, matrix, im) : PEND_NO_MEMORY;
        free(im);
    }
    if (status != PEND_OK)
        return pend_fail(error, status, -1, 0, "the matrix %s: %s", matrix_names[which], pend_status_text(status));
    if (which == MATRIX_A || which == MATRIX_M) matrix_order_columns(tree, matrix, modes->scratch);
    return PEND_OK;
}

static int part_wanted(const struct modes *modes, int part) { return part ? modes->include[part - 1] : modes->vectors; }

/* opens the array of rows, and computes them where they are a matrix */
static enum pend_status part_open(struct modes *modes, struct api_buffer *out, struct pend_error *error) {
    int part = modes->part;
    if (part) PEND_TRY(matrix_compute(modes, (enum matrix)(part - 1), modes_matrix(modes), error));
    return api_out_open(out, part ? matrix_names[part - 1] : "vectors", '[');
}

static enum pend_status part_write_row(const struct modes *modes, struct api_buffer *out) {
    const struct pend_tree *tree = modes->tree.tree;
    int n = modes->tree.n, which = modes->part - 1, row = modes->row;
    const double *matrix = modes_matrix(modes);
    if (which == MATRIX_A || which == MATRIX_M) row = tree->place[row];
    if (which >= 0) return api_out_numbers(out, NULL, n, matrix + (size_t)row * (size_t)n, modes->digits);
    const double *vector = modes->found->vector + (size_t)row * (size_t)n;
    for (int k = 0; k < n; k++) modes->scratch[tree->order[k]] = vector[k];
    return api_out_numbers(out, NULL, n, modes->scratch, modes->digits);
}

static enum pend_status modes_begin(struct modes *modes, struct api_buffer *out, struct pend_error *error) {
    PEND_TRY(modes_compute(modes, error));
    PEND_TRY(api_buffer_text(out, "{"));
    return write_lists(modes, out);
}

/* computes all at once; the rows of large arrays are written a turn at a time */
static enum pend_status modes_run(void *state, const struct api_turn *turn, int *done, struct pend_error *error) {
    struct modes *modes = state;
    if (!modes->found) PEND_TRY(modes_begin(modes, turn->out, error));
    for (; modes->part <= MATRICES; modes->part++, modes->row = 0) {
        int rows = modes->part ? modes->tree.n : modes->found->count;
        if (!part_wanted(modes, modes->part)) continue;
        if (!modes->row) PEND_TRY(part_open(modes, turn->out, error));
        while (modes->row < rows) {
            PEND_TRY(part_write_row(modes, turn->out));
            if (++modes->row < rows && api_turn_over(turn)) return PEND_OK;
        }
        PEND_TRY(api_buffer_text(turn->out, "]"));
    }
    *done = 1;
    return api_buffer_text(turn->out, "}");
}

const struct api_op api_op_modes = {
    .name = "modes", .body = 1, .read = modes_read, .run = modes_run, .free = modes_free};
