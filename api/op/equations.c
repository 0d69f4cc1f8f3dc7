#include "api/op/equations.h"

#include <math.h>
#include <stdlib.h>

enum pend_status api_equations_new(struct api_equations **equations, const struct api_tree *tree,
                                   const struct api_states *start, int is_explicit) {
    size_t n = (size_t)tree->n;
    struct api_equations *made = *equations =
        malloc(sizeof *made + n * (4 * sizeof(double) + sizeof(int)));
    if (!made) return PEND_NO_MEMORY;
    double *at = (double *)(made + 1);
    *made = (struct api_equations){.n = tree->n,
                                   .is_explicit = is_explicit,
                                   .loads = tree->loads,
                                   .length = at,
                                   .mass = at + n,
                                   .phi = at + 2 * n,
                                   .rate = at + 3 * n,
                                   .parent = (int *)(at + 4 * n)};
    for (int i = 0; i < tree->n; i++) {
        int k = tree->tree->place[i];
        made->parent[i] = api_tree_parent(tree, i);
        made->length[i] = tree->tree->len[k];
        made->mass[i] = tree->tree->mass[k];
        made->phi[i] = start->phi[k];
        made->rate[i] = start->rate[k];
    }
    for (size_t i = 0; i < n; i++)
        if (!isfinite(made->phi[i]) || !isfinite(made->rate[i])) {
            api_equations_free(equations);
            return PEND_NOT_FINITE;
        }
    return PEND_OK;
}

void api_equations_free(struct api_equations **equations) {
    free(*equations);
    *equations = NULL;
}

int api_equations_carries(const struct api_equations *equations, int above, int arm) {
    while (arm >= 0 && arm != above) arm = equations->parent[arm];
    return arm == above;
}
