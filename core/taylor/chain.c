#include "core/taylor/chain.h"

#include <math.h>

/* masses further apart than this are solved in blocks */
static const double STRAND_MASSES = 64;

int pend_strand_suits(const struct pend_tree *tree) {
    double least = tree->mass[0], most = least;
    if (tree->n <= STRAND_ARMS) return 0;
    for (int k = 1; k < tree->n; k++) {
        if (tree->parent[k] != k - 1) return 0;
        least = fmin(least, tree->mass[k]);
        most = fmax(most, tree->mass[k]);
    }
    return most <= STRAND_MASSES * least;
}

static size_t strand_count(const struct pend_tree *tree) { return ((size_t)tree->n + STRAND_ARMS - 1) / STRAND_ARMS; }

size_t pend_strand_bytes(const struct pend_tree *tree) {
    return (strand_count(tree) + 2) * STRAND_NUMBERS * sizeof(double);
}

void pend_strand_init(struct strand *strand, const struct pend_tree *tree, void *memory) {
    strand->count = (int)strand_count(tree);
    strand->numbers = (double *)memory + STRAND_NUMBERS;
    for (int k = 0; k < tree->n; k++) {
        double *at = strand->numbers + (size_t)(k / STRAND_ARMS) * STRAND_NUMBERS + k % STRAND_ARMS;
        double above = k ? tree->mass[k - 1] : 1;
        at[STRAND_MASS * STRAND_ARMS] = above;
        at[STRAND_ABOVE * STRAND_ARMS] = k ? 1 / above : 0;
        at[STRAND_BELOW * STRAND_ARMS] = 1 / tree->mass[k];
        at[STRAND_PULL * STRAND_ARMS] = -tree->len[k];
        at[STRAND_PART * STRAND_ARMS] = 1 / tree->len[k];
    }
    // arms that are not there are divided by too
    double *last = strand->numbers + (size_t)(strand->count - 1) * STRAND_NUMBERS + STRAND_N_LAST * STRAND_ARMS;
    for (int k = tree->n; k < strand->count * STRAND_ARMS; k++) last[k % STRAND_ARMS] = 1;
}
