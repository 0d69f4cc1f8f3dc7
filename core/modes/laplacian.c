#include "core/modes/laplacian.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

struct laplacian_block {
    struct pend_laplacian laplacian; /* the first member, so that its address is the block's */
    double data[];                   /* three arrays of n doubles, two of n ints, one of n bytes */
};

enum pend_status pend_laplacian_alloc(struct pend_laplacian **laplacian, int n) {
    assert(n >= 1);
    *laplacian = NULL;
    size_t count = (size_t)n;
    struct laplacian_block *block = malloc(
        sizeof *block + count * (3 * sizeof(double) + 2 * sizeof(int) + sizeof(unsigned char)));
    if (!block) return PEND_NO_MEMORY;
    int *numbers = (int *)(block->data + 3 * count);
    block->laplacian = (struct pend_laplacian){.n = n,
                                               .spring = block->data,
                                               .mass = block->data + count,
                                               .len = block->data + 2 * count,
                                               .parent = numbers,
                                               .end = numbers + count,
                                               .turn = (unsigned char *)(numbers + 2 * count)};
    *laplacian = &block->laplacian;
    return PEND_OK;
}

int pend_laplacian_valid(const struct pend_laplacian *laplacian) {
    const struct pend_laplacian *l = laplacian;
    if (l->n < 1 || l->parent[0] != -1 || l->end[0] != l->n || l->depth > l->n) return 0;
    for (int k = 0; k < l->n; k++) {
        int p = l->parent[k];
        if (p >= k || (k && (p < 0 || l->end[k] > l->end[p])) || l->end[k] <= k) return 0;
        if (!(l->turn[k] & PEND_TURN_LEAF) != (l->end[k] > k + 1)) return 0;
        if (!(l->turn[k] & PEND_TURN_NEXT) != (!k || l->end[k] == l->end[p])) return 0;
    }
    return 1;
}

void pend_laplacian_free(struct pend_laplacian **laplacian) {
    free(*laplacian);
    *laplacian = NULL;
}

void pend_laplacian_close(struct pend_laplacian *laplacian) {
    int n = laplacian->n;
    const int *parent = laplacian->parent, *end = laplacian->end;
    /* The least eigenvalue is at least 1 / trace(L^-1 M). This trace is the sum over all nodes of
     * the mass of the sub-tree divided by the spring of the node. */
    double trace = 0, most = 0, carried[PEND_LAPLACIAN_STACK + 1],
           springs[PEND_LAPLACIAN_STACK + 1];
    int top = 0, height[PEND_LAPLACIAN_STACK + 1], tall = 0;
    for (int k = n - 1; k >= 0; k--) {
        int leaf = end[k] == k + 1, next = k && end[k] != end[parent[k]];
        laplacian->turn[k] =
            (unsigned char)((leaf ? PEND_TURN_LEAF : 0) | (next ? PEND_TURN_NEXT : 0));
        double mass = leaf ? 0 : carried[top], around = leaf ? 0 : springs[top],
               spring = fabs(laplacian->spring[k]);
        tall = leaf ? 1 : height[top] + 1;
        top -= !leaf;
        assert(top >= 0 && top < PEND_LAPLACIAN_STACK);
        mass += laplacian->mass[k];
        trace += mass / spring;
        /* a bound by Gershgorin's discs of M^-1 L */
        most = fmax(most, 2 * (spring + around) / laplacian->mass[k]);
        top += !next;
        carried[top] = next ? carried[top] + mass : mass;
        height[top] = next && height[top] > tall ? height[top] : tall;
        springs[top] = next ? springs[top] + spring : spring;
    }
    laplacian->depth = tall;
    laplacian->least = (1 - 1e-9) / trace;
    laplacian->most = (1 + 1e-9) * most;
    assert(pend_laplacian_valid(laplacian));
}

double pend_laplacian_spring(const struct pend_tree *tree, const struct pend_loads *loads,
                             const unsigned char up[], int k) {
    double spring = loads->gravity * tree->subtree_mass[k] / tree->len[k];
    return up && up[k] ? -spring : spring;
}
