#include "core/blocks.h"

/* an arm that neither hangs on its own block nor, as its first, on the last arm of the block before */
static int blocks_crosses(const struct pend_tree *tree, int k) {
    int start = k / BLOCK_ARMS * BLOCK_ARMS, p = tree->parent[k];
    return p < start && !(k == start && p == k - 1);
}

/* children of arm k, BLOCK_SIBLINGS + 2 where there are as many or more */
static int blocks_degree(const struct pend_tree *tree, int k) {
    int degree = 0;
    for (int c = k + 1; c < tree->end[k] && degree < BLOCK_SIBLINGS + 2; c = tree->end[c]) degree++;
    return degree;
}

static int blocks_crowded(const struct pend_tree *tree, int k) { return blocks_degree(tree, k) == BLOCK_SIBLINGS + 2; }

struct blocks_counts {
    size_t edges, kids, joints, crowd;
};

static struct blocks_counts blocks_measure(const struct pend_tree *tree) {
    struct blocks_counts counts = {0, 0, 0, 0};
    for (int k = 0; k < tree->n; k++) {
        counts.edges += (size_t)blocks_crosses(tree, k);
        counts.kids += k > 0 && tree->parent[k] != k - 1;
        if (!blocks_crowded(tree, k)) continue;
        counts.joints++;
        for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) counts.crowd++;
    }
    return counts;
}

static void *blocks_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + 63) / 64 * 64;
    return part;
}

static size_t blocks_lay(struct blocks *b, const struct pend_tree *tree, char *base) {
    struct blocks_counts counts = blocks_measure(tree);
    size_t used = 0, row = BLOCK_ARMS * sizeof(double);
    b->count = (tree->n + BLOCK_ARMS - 1) / BLOCK_ARMS;
    b->numbers = blocks_take(base, &used, (size_t)b->count + 1, BLOCK_NUMBERS * sizeof(double));
    if (base) b->numbers += BLOCK_NUMBERS; // the pivot's comes first
    b->shape = blocks_take(base, &used, (size_t)b->count, sizeof *b->shape);
    b->up = blocks_take(base, &used, counts.edges, row);
    b->down = blocks_take(base, &used, counts.edges, row);
    b->kid = blocks_take(base, &used, counts.kids, 2 * row);
    b->up_place = blocks_take(base, &used, counts.edges, sizeof(int));
    b->up_arm = blocks_take(base, &used, counts.edges, sizeof(int));
    b->down_place = blocks_take(base, &used, counts.edges, sizeof(int));
    b->down_arm = blocks_take(base, &used, counts.edges, sizeof(int));
    b->kid_place = blocks_take(base, &used, counts.kids, sizeof(int));
    b->kid_arm = blocks_take(base, &used, counts.kids, sizeof(int));
    b->crowd_first = blocks_take(base, &used, counts.joints + 1, sizeof(int));
    b->crowd_place = blocks_take(base, &used, counts.crowd, sizeof(int));
    b->crowd_arm = blocks_take(base, &used, counts.crowd, sizeof(int));
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
        for (int j = 0; j < BLOCK_SIBLINGS; j++) shape->sibling[j][i] = pend_blocks_place(-1);
        if (k >= tree->n || p < 0 || blocks_crowded(tree, p)) continue;
        int rounds = 0;
        for (int c = p + 1; c < tree->end[p]; c = tree->end[c]) {
            if (c != k) shape->sibling[rounds++][i] = pend_blocks_place(c);
        }
        if (rounds > shape->rounds) shape->rounds = rounds;
    }
}

/* edges to earlier blocks in the order of their children */
static void blocks_down_edges(struct blocks *b, const struct pend_tree *tree) {
    int edges = 0;
    for (int k = 0; k < tree->n; k++) {
        struct block_run *run = &b->shape[k / BLOCK_ARMS].down;
        if (k % BLOCK_ARMS == 0) run->first = edges;
        if (blocks_crosses(tree, k)) {
            b->down_place[edges] = pend_blocks_place(tree->parent[k]);
            b->down_arm[edges++] = k;
        }
        run->end = edges;
    }
}

/* edges from later blocks in the order of their parents' blocks; the sweep that needs them comes from the last block:
 * what is known last is added last */
static void blocks_up_edges(struct blocks *b, const struct pend_tree *tree) {
    int edges = 0;
    for (int k = 0; k < tree->n; k++) {
        if (blocks_crosses(tree, k)) b->shape[tree->parent[k] / BLOCK_ARMS].up.end++;
    }
    for (int i = 0; i < b->count; i++) {
        struct block_run *run = &b->shape[i].up;
        int count = run->end;
        run->first = run->end = edges;
        edges += count;
    }
    for (int k = tree->n - 1; k >= 0; k--) {
        if (!blocks_crosses(tree, k)) continue;
        int at = b->shape[tree->parent[k] / BLOCK_ARMS].up.end++;
        b->up_place[at] = pend_blocks_place(k);
        b->up_arm[at] = k;
    }
}

/* children that are not first, and crowded joints with all their children, by the parent's block */
static void blocks_children(struct blocks *b, const struct pend_tree *tree) {
    int kids = 0, joints = 0, crowd = 0;
    for (int k = 0; k < tree->n; k++) {
        struct block_shape *shape = &b->shape[k / BLOCK_ARMS];
        if (k % BLOCK_ARMS == 0) {
            shape->kids.first = kids;
            shape->joints.first = joints;
        }
        int crowded = blocks_crowded(tree, k);
        if (crowded) b->crowd_first[joints++] = crowd;
        for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
            if (crowded) {
                b->crowd_place[crowd] = pend_blocks_place(c);
                b->crowd_arm[crowd++] = c;
            }
            if (c == k + 1) continue;
            b->kid_place[kids] = pend_blocks_place(c);
            b->kid_arm[kids++] = c;
        }
        shape->kids.end = kids;
        shape->joints.end = joints;
    }
    b->crowd_first[joints] = crowd;
}

void pend_blocks_init(struct blocks *blocks, const struct pend_tree *tree, void *memory) {
    blocks_lay(blocks, tree, memory);
    for (int i = 0; i < blocks->count; i++) blocks_shape(&blocks->shape[i], tree, i * BLOCK_ARMS);
    blocks_down_edges(blocks, tree);
    blocks_up_edges(blocks, tree);
    blocks_children(blocks, tree);
}
