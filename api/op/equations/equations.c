#include "api/op/equations/equations.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

/* the parents lead every arm to the pivot in n steps at most */
PEND_VALIDATOR equations_valid(const struct api_equations *equations) {
    for (int i = 0; i < equations->n; i++) {
        int steps = 0;
        for (int k = i; k >= 0 && steps <= equations->n; k = equations->parent[k]) steps++;
        if (steps > equations->n) return 0;
    }
    return equations->n >= 1;
}

enum pend_status api_equations_new(struct api_equations **equations, const struct api_tree *tree,
                                   const struct api_states *start, int is_explicit) {
    assert(pend_tree_valid(tree->tree) && api_states_valid(start));
    size_t n = (size_t)tree->n;
    struct api_equations *made = *equations =
        malloc(sizeof *made + n * (4 * sizeof(double) + 2 * sizeof(int)));
    if (!made) return PEND_NO_MEMORY;
    double *at = (double *)(made + 1);
    *made = (struct api_equations){.n = tree->n,
                                   .is_explicit = is_explicit,
                                   .loads = tree->loads,
                                   .tree = tree->tree,
                                   .length = at,
                                   .mass = at + n,
                                   .phi = at + 2 * n,
                                   .rate = at + 3 * n,
                                   .parent = (int *)(at + 4 * n),
                                   .place = (int *)(at + 4 * n) + n};
    for (int i = 0; i < tree->n; i++) {
        int k = tree->tree->place[i];
        made->place[i] = k;
        made->parent[i] = api_tree_parent(tree, i);
        made->length[i] = tree->tree->len[k];
        made->mass[i] = tree->tree->mass[k];
        made->phi[i] = start->phi[k];
        made->rate[i] = start->rate[k];
    }
    if (tree->cart) made->cart[0] = start->phi[0], made->cart[1] = start->rate[0];
    for (size_t i = 0; i < n; i++)
        if (!isfinite(made->phi[i]) || !isfinite(made->rate[i])) {
            api_equations_free(equations);
            return PEND_NOT_FINITE;
        }
    return PEND_OK;
}

void api_equations_free(struct api_equations **equations) {
    assert(!*equations || equations_valid(*equations));
    free(*equations);
    *equations = NULL;
}

int api_equations_carries(const struct api_equations *equations, int above, int arm) {
    assert(above >= 0 && above < equations->n && arm < equations->n);
    while (arm >= 0 && arm != above) arm = equations->parent[arm];
    return arm == above;
}
