#include "core/taylor/large/chain.h"

#include <assert.h>
#include <math.h>

/* largest ratio of masses in a chain; a chain of more unequal masses is solved in blocks */
static const double CHAIN_MASSES = 64;

int pend_chain_suits(const struct pend_tree *tree) {
    double least = tree->mass[0], most = least;
    if (tree->n <= CHAIN_ARMS) return 0;
    for (int k = 1; k < tree->n; k++) {
        if (tree->parent[k] != k - 1) return 0;
        least = fmin(least, tree->mass[k]);
        most = fmax(most, tree->mass[k]);
    }
    return most <= CHAIN_MASSES * least;
}

static size_t chain_count(const struct pend_tree *tree) {
    return ((size_t)tree->n + CHAIN_ARMS - 1) / CHAIN_ARMS;
}

size_t pend_chain_bytes(const struct pend_tree *tree) {
    return (chain_count(tree) + 2) * CHAIN_NUMBERS * sizeof(double);
}

void pend_chain_lay(struct chain *chain, const struct pend_tree *tree, void *memory) {
    assert((size_t)memory % 64 == 0);
    chain->count = (int)chain_count(tree);
    chain->numbers = (double *)memory + CHAIN_NUMBERS;
    for (int k = 0; k < tree->n; k++) {
        double *at = chain->numbers + (size_t)(k / CHAIN_ARMS) * CHAIN_NUMBERS + k % CHAIN_ARMS;
        at[CHAIN_PULL * CHAIN_ARMS] = -tree->len[k];
        at[CHAIN_PART * CHAIN_ARMS] = 1 / tree->len[k];
    }
}

void pend_chain_init(struct chain *chain, const struct pend_tree *tree, void *memory) {
    assert(pend_chain_suits(tree));
    pend_chain_lay(chain, tree, memory);
    for (int k = 0; k < tree->n; k++) {
        double *at = chain->numbers + (size_t)(k / CHAIN_ARMS) * CHAIN_NUMBERS + k % CHAIN_ARMS;
        double above = k ? tree->mass[k - 1] : 1;
        at[CHAIN_MASS * CHAIN_ARMS] = above;
        at[CHAIN_ABOVE * CHAIN_ARMS] = k ? 1 / above : 0;
        at[CHAIN_BELOW * CHAIN_ARMS] = 1 / tree->mass[k];
    }
    // padding lanes are divided by too, so they must not be zero
    double *last =
        chain->numbers + (size_t)(chain->count - 1) * CHAIN_NUMBERS + CHAIN_N_LAST * CHAIN_ARMS;
    for (int k = tree->n; k < chain->count * CHAIN_ARMS; k++) last[k % CHAIN_ARMS] = 1;
}
