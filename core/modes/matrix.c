#include "core/modes/matrix.h"

#include <assert.h>
#include <string.h>

const char *const pend_matrix_names[PEND_MATRIX_COUNT + 1] = {
    [PEND_MATRIX_A] = "A", [PEND_MATRIX_M] = "M", [PEND_MATRIX_S] = "S",
    [PEND_MATRIX_B] = "B", [PEND_MATRIX_C] = "C", [PEND_MATRIX_K] = "K"};

static double matrix_sign(const unsigned char up[], int k) { return up && up[k] ? -1 : 1; }

/* g/l_j (B^T diag(1/m) B)_jk (S^T m)_k, which differs from zero only for the arm itself, its
 * parent, its children and its siblings */
static void matrix_row_a(const struct pend_tree *tree, const struct pend_loads *loads, double sign,
                         int j, double row[]) {
    int p = tree->parent[j];
    double scale = sign * loads->gravity / tree->len[j], own = scale / tree->mass[j],
           at_base = p < 0 ? 0 : scale / tree->mass[p];
    for (int c = j + 1; c < tree->end[j]; c = tree->end[c])
        row[tree->order[c]] = -own * tree->subtree_mass[c];
    for (int c = p + 1; p >= 0 && c < tree->end[p]; c = tree->end[c])
        row[tree->order[c]] = at_base * tree->subtree_mass[c];
    if (p >= 0) row[tree->order[p]] = -at_base * tree->subtree_mass[p];
    row[tree->order[j]] = (own + at_base) * tree->subtree_mass[j];
}

/* l_j l_k times the mass that both arms carry */
static void matrix_row_m(const struct pend_tree *tree, const unsigned char up[], int j,
                         double row[]) {
    double own = matrix_sign(up, j) * tree->len[j];
    for (int k = j; k < tree->end[j]; k++)
        row[tree->order[k]] = own * matrix_sign(up, k) * tree->len[k] * tree->subtree_mass[k];
    for (int k = tree->parent[j]; k >= 0; k = tree->parent[k])
        row[tree->order[k]] = own * matrix_sign(up, k) * tree->len[k] * tree->subtree_mass[j];
}

void pend_matrix_row(const struct pend_tree *tree, const struct pend_loads *loads,
                     const unsigned char up[], enum pend_matrix which, int arm, double row[]) {
    assert(arm >= 0 && arm < tree->n && (unsigned)which < PEND_MATRIX_COUNT);
    int j = tree->place[arm];
    memset(row, 0, (size_t)tree->n * sizeof *row);
    switch (which) {
    case PEND_MATRIX_A:
        matrix_row_a(tree, loads, matrix_sign(up, j), j, row);
        break;
    case PEND_MATRIX_M:
        matrix_row_m(tree, up, j, row);
        break;
    case PEND_MATRIX_S:
        for (int k = j; k >= 0; k = tree->parent[k]) row[tree->order[k]] = 1;
        break;
    case PEND_MATRIX_B:
        row[arm] = 1;
        for (int c = j + 1; c < tree->end[j]; c = tree->end[c]) row[tree->order[c]] = -1;
        break;
    case PEND_MATRIX_K:
        row[arm] = matrix_sign(up, j) * loads->gravity * tree->len[j] * tree->subtree_mass[j];
        break;
    default: /* C */
        break;
    }
}
