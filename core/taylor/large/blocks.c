#include "core/taylor/large/blocks.h"

#include <assert.h>

static int blocks_start(int k) { return k / BLOCK_ARMS * BLOCK_ARMS; }

/* true if the arm has no children in its own block */
static int blocks_leaves(const struct pend_tree *tree, int k) {
    return tree->parent[k] < blocks_start(k);
}

/* true if the arm is the first of its block and a child of the previous block's last arm */
static int blocks_leads(const struct pend_tree *tree, int k) {
    return k == blocks_start(k) && tree->parent[k] == k - 1;
}

/* true if the edge to arm k is in the list of the parent's block */
static int blocks_crosses(const struct pend_tree *tree, int k) {
    return blocks_leaves(tree, k) && !blocks_leads(tree, k);
}

/* number of children of arm k, counted up to BLOCK_SIBLINGS + 2 */
static int blocks_degree(const struct pend_tree *tree, int k) {
    int degree = 0;
    for (int c = k + 1; c < tree->end[k] && degree < BLOCK_SIBLINGS + 2; c = tree->end[c]) degree++;
    return degree;
}

static int blocks_crowded(const struct pend_tree *tree, int k) {
    return blocks_degree(tree, k) == BLOCK_SIBLINGS + 2;
}

struct blocks_counts {
    size_t up, down, kids, joints, crowd;
};

static struct blocks_counts blocks_measure(const struct pend_tree *tree) {
    struct blocks_counts counts = {0};
    for (int k = 0; k < tree->n; k++) {
        counts.up += (size_t)blocks_crosses(tree, k);
        counts.down += (size_t)blocks_leaves(tree, k);
        counts.kids += k > 0 && tree->parent[k] != k - 1;
        int crowded = blocks_crowded(tree, k);
        counts.joints += (size_t)crowded;
        for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
            counts.crowd += (size_t)crowded;
        }
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
    size_t used = 0;
    b->count = (tree->n + BLOCK_ARMS - 1) / BLOCK_ARMS;
    b->numbers = blocks_take(base, &used, (size_t)b->count + 1, BLOCK_NUMBERS * sizeof(double));
    if (base) b->numbers += BLOCK_NUMBERS; // a block with the pivot precedes block 0
    b->shape = blocks_take(base, &used, (size_t)b->count, sizeof *b->shape);
    b->up_place = blocks_take(base, &used, counts.up, sizeof(int));
    b->up_arm = blocks_take(base, &used, counts.up, sizeof(int));
    b->down_place = blocks_take(base, &used, counts.down, sizeof(int));
    b->down_arm = blocks_take(base, &used, counts.down, sizeof(int));
    b->up_lane = blocks_take(base, &used, counts.up, 1);
    b->kid_lane = blocks_take(base, &used, counts.kids, 1);
    b->kid_place = blocks_take(base, &used, counts.kids, sizeof(int));
    b->kid_arm = blocks_take(base, &used, counts.kids, sizeof(int));
    b->crowd_first = blocks_take(base, &used, counts.joints + 1, sizeof(int));
    b->crowd_place = blocks_take(base, &used, counts.crowd, sizeof(int));
    return used;
}

size_t pend_blocks_bytes(const struct pend_tree *tree) {
    assert(tree->n > BLOCK_ARMS);
    struct blocks sketch;
    return blocks_lay(&sketch, tree, NULL);
}

/* siblings of arm k, those in its own block first */
static int blocks_siblings(const struct pend_tree *tree, int k, int sibling[BLOCK_SIBLINGS]) {
    int p = tree->parent[k], count = 0;
    if (p < 0 || blocks_crowded(tree, p)) return 0;
    for (int far = 0; far < 2; far++) {
        for (int c = p + 1; c < tree->end[p]; c = tree->end[c]) {
            if (c == k || (blocks_start(c) != blocks_start(k)) != far) continue;
            sibling[count++] = c;
        }
    }
    return count;
}

static void blocks_lane(struct blocks *b, const struct pend_tree *tree, int k) {
    struct block_shape *shape = &b->shape[k / BLOCK_ARMS];
    int lane = k % BLOCK_ARMS, p = tree->parent[k], sibling[BLOCK_SIBLINGS];
    shape->straight &= p == k - 1;
    shape->parents[lane] = pend_blocks_place(p);
    int count = blocks_siblings(tree, k, sibling);
    for (int i = 0; i < count; i++) shape->siblings[i][lane] = pend_blocks_place(sibling[i]);
    if (count > shape->rounds) shape->rounds = count;
}

static void blocks_shapes(struct blocks *b, const struct pend_tree *tree) {
    for (int i = 0; i < b->count; i++) {
        struct block_shape *shape = &b->shape[i];
        int start = i * BLOCK_ARMS;
        shape->straight = 1;
        shape->lead = blocks_leads(tree, start);
        for (int lane = 0; lane < BLOCK_ARMS; lane++) {
            shape->parents[lane] = pend_blocks_place(start + lane - 1);
            for (int j = 0; j < BLOCK_SIBLINGS; j++)
                shape->siblings[j][lane] = pend_blocks_place(-1);
        }
        for (int k = start; k < start + BLOCK_ARMS && k < tree->n; k++) blocks_lane(b, tree, k);
    }
}

/* lists the edges to earlier blocks in the order of their children */
static void blocks_down_edges(struct blocks *b, const struct pend_tree *tree) {
    int edges = 0;
    for (int k = 0; k < tree->n; k++) {
        struct block_run *run = &b->shape[k / BLOCK_ARMS].down;
        if (k % BLOCK_ARMS == 0) run->first = edges;
        if (blocks_leaves(tree, k)) {
            b->down_place[edges] = pend_blocks_place(tree->parent[k]);
            b->down_arm[edges++] = k;
        }
        run->end = edges;
    }
}

/* lists the edges from later blocks in the order of their parents' blocks. Their sweep starts at
 * the last block, so that edges are added in the order in which values become known. */
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
        b->up_lane[at] = (unsigned char)(tree->parent[k] % BLOCK_ARMS);
        b->up_arm[at] = k;
    }
}

/* lists the children that are not first, and the crowded joints' children, by the parent's block */
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
                b->crowd_place[crowd++] = pend_blocks_place(c);
            }
            if (c == k + 1) continue;
            b->kid_place[kids] = pend_blocks_place(c);
            b->kid_lane[kids] = (unsigned char)(k % BLOCK_ARMS);
            b->kid_arm[kids++] = c;
        }
        shape->kids.end = kids;
        shape->joints.end = joints;
    }
    b->crowd_first[joints] = crowd;
}

void pend_blocks_init(struct blocks *blocks, const struct pend_tree *tree, void *memory) {
    assert(tree->n > BLOCK_ARMS && (size_t)memory % 64 == 0);
    blocks_lay(blocks, tree, memory);
    blocks_shapes(blocks, tree);
    blocks_down_edges(blocks, tree);
    blocks_up_edges(blocks, tree);
    blocks_children(blocks, tree);
}
