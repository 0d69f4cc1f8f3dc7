#include "core/blocks.h"

/* an arm that neither hangs on its own block nor, as its first, on the last arm of the block before */
static int blocks_crosses(const struct pend_tree *tree, int k) {
    int start = k / BLOCK_ARMS * BLOCK_ARMS, p = tree->parent[k];
    return p < start && !(k == start && p == k - 1);
}

static int blocks_has_siblings(const struct pend_tree *tree, int k) {
    int p = tree->parent[k];
    return p >= 0 && !(k == p + 1 && tree->end[k] == tree->end[p]);
}

/* counts edges, joints with several children, and these children */
static void blocks_measure(const struct pend_tree *tree, int *edges, int *joints, int *kids) {
    *edges = *joints = *kids = 0;
    for (int k = 0; k < tree->n; k++) {
        *edges += blocks_crosses(tree, k);
        *kids += blocks_has_siblings(tree, k);
        *joints += k + 1 < tree->end[k] && tree->end[k + 1] != tree->end[k];
    }
}

static void *blocks_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + 63) / 64 * 64;
    return part;
}

static size_t blocks_lay(struct blocks *b, const struct pend_tree *tree, char *base) {
    size_t used = 0, row = BLOCK_ARMS * sizeof(double);
    int kids;
    blocks_measure(tree, &b->edges, &b->joints, &kids);
    b->count = (tree->n + BLOCK_ARMS - 1) / BLOCK_ARMS;
    size_t count = (size_t)b->count, edges = (size_t)b->edges, joints = (size_t)b->joints;
    b->numbers = blocks_take(base, &used, count + 1, BLOCK_NUMBERS * sizeof(double));
    if (base) b->numbers += BLOCK_NUMBERS; // the pivot's comes first
    b->edge_up = blocks_take(base, &used, edges, row);
    b->edge_down = blocks_take(base, &used, edges, row);
    b->shape = blocks_take(base, &used, count, sizeof *b->shape);
    b->up_place = blocks_take(base, &used, edges, sizeof(int));
    b->down_place = blocks_take(base, &used, edges, sizeof(int));
    b->up_arm = blocks_take(base, &used, edges, sizeof(int));
    b->down_arm = blocks_take(base, &used, edges, sizeof(int));
    b->joint = blocks_take(base, &used, joints, sizeof(int));
    b->first = blocks_take(base, &used, joints + 1, sizeof(int));
    b->kid = blocks_take(base, &used, (size_t)kids, sizeof(int));
    b->kid_arm = blocks_take(base, &used, (size_t)kids, sizeof(int));
    return used;
}

size_t pend_blocks_bytes(const struct pend_tree *tree) {
    struct blocks sketch;
    return blocks_lay(&sketch, tree, NULL);
}

static void blocks_shape(struct block_shape *shape, const struct pend_tree *tree, int start) {
    shape->lead = tree->parent[start] == start - 1;
    shape->straight = 1;
    for (int i = 0; i < BLOCK_ARMS; i++) {
        int k = start + i, p = k < tree->n ? tree->parent[k] : k - 1;
        shape->straight &= p == k - 1;
        shape->inside[i] = (signed char)(p < start ? -1 : p - start);
        shape->parent[i] = pend_blocks_place(p);
    }
}

/* edges in the order of their children's blocks, and in the order of their parents' */
static void blocks_edges(struct blocks *b, const struct pend_tree *tree) {
    int edges = 0;
    for (int k = 0; k < tree->n; k++) {
        struct block_shape *shape = &b->shape[k / BLOCK_ARMS];
        if (k % BLOCK_ARMS == 0) shape->down_first = edges;
        if (blocks_crosses(tree, k)) {
            b->down_place[edges] = pend_blocks_place(tree->parent[k]);
            b->down_arm[edges++] = k;
            b->shape[tree->parent[k] / BLOCK_ARMS].up_end++;
        }
        shape->down_end = edges;
    }
    edges = 0;
    for (int i = 0; i < b->count; i++) {
        struct block_shape *shape = &b->shape[i];
        shape->up_first = edges;
        edges += shape->up_end;
        shape->up_end = shape->up_first;
    }
    // the sweep that needs them comes from the last block: what is known last is added last
    for (int k = tree->n - 1; k >= 0; k--) {
        if (!blocks_crosses(tree, k)) continue;
        struct block_shape *shape = &b->shape[tree->parent[k] / BLOCK_ARMS];
        b->up_place[shape->up_end] = pend_blocks_place(k);
        b->up_arm[shape->up_end++] = k;
    }
}

/* children of arm k */
static int blocks_degree(const struct pend_tree *tree, int k) {
    int degree = 0;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) degree++;
    return degree;
}

static void blocks_kids(struct blocks *b, const struct pend_tree *tree, int k, int *joints, int *kids) {
    b->joint[*joints] = pend_blocks_place(k);
    b->first[(*joints)++] = *kids;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
        b->kid[*kids] = pend_blocks_place(c);
        b->kid_arm[(*kids)++] = c;
    }
}

/* joints with few children come sorted by their number, so that loops over the children foresee their ends */
static void blocks_joints(struct blocks *b, const struct pend_tree *tree) {
    enum { SORTED = 8 };
    int joints = 0, kids = 0;
    for (int degree = 2; degree <= SORTED; degree++) {
        for (int k = 0; k < tree->n; k++) {
            int here = blocks_degree(tree, k);
            if (here == degree || (degree == SORTED && here > degree)) blocks_kids(b, tree, k, &joints, &kids);
        }
    }
    b->first[joints] = kids;
}

void pend_blocks_init(struct blocks *blocks, const struct pend_tree *tree, void *memory) {
    blocks_lay(blocks, tree, memory);
    for (int i = 0; i < blocks->count; i++) blocks_shape(&blocks->shape[i], tree, i * BLOCK_ARMS);
    blocks_edges(blocks, tree);
    blocks_joints(blocks, tree);
}
