/* POST /v1/trees: checks a pendulum and returns properties of its shape: S, B, S^T m, depths.
 * Leaves to others: reading it (tree_json), the shape itself (core/tree/tree).
 * Invariant: the answer's arms, used in a request, describe the same tree. */
#include "api/op/op.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"
#include "api/op/tree_write.h"
#include "api/read/tree_json.h"

static const char *const fields[] = {"pendulum", NULL};

struct trees {
    struct api_tree tree;
    int matrices; /* whether the answer includes S and B, because the tree is within the limit for
                   * them */
};

static void trees_clear(void *state) {
    struct trees *trees = state;
    api_tree_clear(&trees->tree);
}

static enum pend_status trees_read(void *state, const struct api_reading *reading) {
    struct trees *trees = state;
    int unknown = api_value_only(reading->root, fields, reading->problem);
    enum pend_status status = api_reading_tree(reading, &trees->tree);
    if (status == PEND_OK && unknown) status = PEND_INVALID;
    trees->matrices = trees->tree.n <= reading->limits->matrix_arms;
    return status;
}

/* computes the masses of the arms' sub-trees, with those of rods and bodies, in the caller's
 * order */
static void sum_masses(const struct api_tree *tree, double row[]) {
    const struct pend_tree *stored = tree->tree;
    const struct pend_loads *loads = &tree->loads;
    for (int k = tree->cart; k < stored->n; k++)
        row[stored->order[k]] =
            loads->terms
                ? stored->mass[k] + pend_terms_get(loads->terms, loads->value, PEND_TERM_ROD, k) +
                      pend_terms_get(loads->terms, loads->value, PEND_TERM_BODY, k)
                : stored->subtree_mass[k];
    for (int k = stored->n - 1; loads->terms && k > 0; k--)
        if (stored->parent[k] >= tree->cart)
            row[stored->order[stored->parent[k]]] += row[stored->order[k]];
}

/* writes the lists with a number per arm; `row` is scratch of n numbers */
static enum pend_status write_lists(const struct api_tree *tree, double row[],
                                    struct api_buffer *out) {
    const struct pend_tree *stored = tree->tree;
    for (int i = 0; i < tree->n; i++) row[i] = api_tree_parent(tree, i) + 1;
    PEND_TRY(api_out_numbers(out, "parent", tree->n, row, 0));
    for (int i = 0; i < tree->n; i++) row[i] = stored->depth[stored->place[i]] - tree->cart;
    PEND_TRY(api_out_numbers(out, "depth", tree->n, row, 0));
    sum_masses(tree, row);
    return api_out_numbers(out, "subtree_mass", tree->n, row, 0);
}

/* removes the last row and the last column, those of a cart, from a matrix */
static void leave_cart_out(const struct api_tree *tree, double matrix[]) {
    size_t n = (size_t)tree->n, stored = n + (size_t)tree->cart;
    assert(stored == (size_t)tree->tree->n);
    for (size_t i = 1; i < n && tree->cart; i++)
        memmove(matrix + i * n, matrix + i * stored, n * sizeof *matrix);
}

static enum pend_status write_matrices(const struct api_tree *tree, double matrix[],
                                       struct api_buffer *out) {
    pend_tree_path(tree->tree, matrix);
    leave_cart_out(tree, matrix);
    PEND_TRY(api_out_matrix(out, "S", tree->n, matrix, 0));
    pend_tree_force_map(tree->tree, matrix);
    leave_cart_out(tree, matrix);
    return api_out_matrix(out, "B", tree->n, matrix, 0);
}

static enum pend_status write_tree(const struct trees *trees, double scratch[],
                                   const struct api_turn *turn) {
    const struct api_tree *tree = &trees->tree;
    struct api_buffer *out = turn->out;
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "n", tree->n));
    PEND_TRY(api_out_number(out, "gravity", tree->loads.gravity, 0));
    PEND_TRY(api_terms_write_whole(tree->tree, &tree->loads, out));
    PEND_TRY(api_out_number(out, "length_total", tree->tree->length_total - tree->cart, 0));
    PEND_TRY(api_tree_write_arms(tree, out));
    PEND_TRY(write_lists(tree, scratch, out));
    if (trees->matrices) PEND_TRY(write_matrices(tree, scratch, out));
    return api_turn_close(turn);
}

static enum pend_status trees_run(void *state, const struct api_turn *turn, int *done,
                                  struct pend_error *error) {
    const struct trees *trees = state;
    size_t n = (size_t)api_tree_stored(&trees->tree);
    double *scratch = calloc(n, (trees->matrices ? n : 1) * sizeof *scratch);
    if (!scratch)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the matrices of %d arms",
                         trees->tree.n);
    enum pend_status status = write_tree(trees, scratch, turn);
    free(scratch);
    *done = 1;
    return status;
}

/* bytes of a matrix and its text: most entries of S have one digit, those of B a few */
static double trees_bytes(const void *state) {
    const struct trees *trees = state;
    double n = api_tree_stored(&trees->tree), square = trees->matrices ? n * n : n;
    return api_tree_bytes(&trees->tree) + (sizeof(double) + 8) * square + 512 * n +
           api_terms_write_bytes(&trees->tree.loads);
}

const struct api_op api_op_trees = {.name = "trees",
                                    .size = sizeof(struct trees),
                                    .body = 1,
                                    .terms = 1,
                                    .pieces = 1,
                                    .cart = 1,
                                    .read = trees_read,
                                    .run = trees_run,
                                    .bytes = trees_bytes,
                                    .clear = trees_clear};
