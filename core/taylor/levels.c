#include "core/taylor/levels.h"

#include <string.h>

/* the heights that arms above the one at hand have from children met so far, one a joint that waits */
struct layers_climb {
    int joint[LAYERS_MAX], height[LAYERS_MAX], waiting;
};

/* the height of arm k, met from the last arm to the first; no more joints wait than the sub-trees halve */
static int layers_height(struct layers_climb *climb, const struct pend_tree *tree, int k) {
    int top = climb->waiting - 1, height = 0, p = tree->parent[k];
    if (top >= 0 && climb->joint[top] == k) {
        height = climb->height[top--];
    }
    if (top < 0 || climb->joint[top] != p) {
        climb->joint[++top] = p;
        climb->height[top] = 0;
    }
    if (climb->height[top] < height + 1) climb->height[top] = height + 1;
    climb->waiting = top + 1;
    return height;
}

static int layers_degree(const struct pend_tree *tree, int k) {
    int degree = 0;
    for (int c = k + 1; c < tree->end[k] && degree <= LAYERS_CHILDREN; c = tree->end[c]) degree++;
    return degree;
}

/* arms of each layer, layers; 0 where a tree is not for layers */
static int layers_measure(const struct pend_tree *tree, int arms[LAYERS_MAX]) {
    struct layers_climb climb = {.waiting = 0};
    int layers = 0;
    memset(arms, 0, LAYERS_MAX * sizeof *arms);
    for (int k = tree->n - 1; k >= 0; k--) {
        int height = layers_height(&climb, tree, k);
        if (height >= LAYERS_MAX || layers_degree(tree, k) > LAYERS_CHILDREN) return 0;
        arms[height]++;
        if (height >= layers) layers = height + 1;
    }
    return layers;
}

static int layers_blocks(int arms) { return (arms + LAYER_ARMS - 1) / LAYER_ARMS; }

/* the lowest of the layers that the cap takes: as many as one block has lanes for */
static int layers_cap(const int arms[], int layers) {
    int room = LAYER_ARMS;
    while (layers > 0 && arms[layers - 1] <= room) room -= arms[--layers];
    return layers;
}

int pend_layers_count(const struct pend_tree *tree) {
    int arms[LAYERS_MAX], layers = layers_measure(tree, arms), cap = layers_cap(arms, layers), count = 1;
    for (int i = 0; i < cap; i++) count += layers_blocks(arms[i]);
    return cap > 0 && count <= 3 * layers_blocks(tree->n) / 2 ? count : 0;
}

/* arms that are not their parent's first child: as many as there are leaves, but one */
static int layers_light(const struct pend_tree *tree) {
    int light = -1;
    for (int k = 0; k < tree->n; k++) light += tree->end[k] == k + 1;
    return light;
}

static void *layers_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + 63) / 64 * 64;
    return part;
}

/* what is needed while a tree is cut; layer i has arms[i] arms, and blocks from start[i] on */
struct layers_plan {
    int *height, *next; /* of an arm; the next one of the same height, -1 after the last */
    int cap, arms[LAYERS_MAX], head[LAYERS_MAX], start[LAYERS_MAX + 1]; /* the cap's lowest layer; lists of the arms */
};

static size_t layers_lay(struct layers *l, struct layers_plan *plan, const struct pend_tree *tree, char *base) {
    size_t used = 0, ranks = (size_t)(layers_light(tree) + LAYERS_CHILDREN), n = (size_t)tree->n;
    l->count = pend_layers_count(tree);
    l->ranks = 0;
    l->numbers = layers_take(base, &used, ((size_t)l->count + 1) * LAYER_NUMBERS + ranks * LAYER_TABLE, sizeof(double));
    l->up = layers_take(base, &used, LAYER_ARMS * LAYER_ARMS, sizeof(double));
    l->down = layers_take(base, &used, LAYER_ARMS * LAYER_ARMS, sizeof(double));
    l->block = layers_take(base, &used, (size_t)l->count, sizeof *l->block);
    l->rank = layers_take(base, &used, ranks, sizeof *l->rank);
    l->seat = layers_take(base, &used, (n + LAYER_ARMS - 1) / LAYER_ARMS * LAYER_ARMS, sizeof(int));
    l->arm = layers_take(base, &used, (size_t)l->count * LAYER_ARMS, sizeof(int));
    for (int i = 0; i < LAYERS_CHANGES; i++) {
        l->change[i] = layers_take(base, &used, ((size_t)l->count + 1) * LAYER_ARMS, sizeof(double));
    }
    plan->height = layers_take(base, &used, n, sizeof(int));
    plan->next = layers_take(base, &used, n, sizeof(int));
    return used;
}

size_t pend_layers_bytes(const struct pend_tree *tree) {
    struct layers sketch;
    struct layers_plan plan;
    return layers_lay(&sketch, &plan, tree, NULL);
}

/* the first of an arm's highest children */
static int layers_first(const struct pend_tree *tree, const int height[], int k) {
    int c = k + 1;
    while (height[c] != height[k] - 1) c = tree->end[c];
    return c;
}

static void layers_sit(struct layers *l, int k, int seat) {
    l->seat[k] = seat;
    l->arm[seat] = k;
}

/* heights of all arms, and lists of the arms of a height */
static void layers_survey(struct layers_plan *plan, const struct pend_tree *tree) {
    struct layers_climb climb = {.waiting = 0};
    int layers = layers_measure(tree, plan->arms);
    plan->cap = layers_cap(plan->arms, layers);
    plan->start[0] = 0;
    for (int i = 0; i < layers; i++) {
        plan->head[i] = -1;
        plan->start[i + 1] = plan->start[i] + (i < plan->cap ? layers_blocks(plan->arms[i]) : 0);
    }
    for (int k = tree->n - 1; k >= 0; k--) {
        int height = plan->height[k] = layers_height(&climb, tree, k);
        plan->next[k] = plan->head[height];
        plan->head[height] = k;
    }
}

/* seats of a layer: first children in their parents' lanes, then the others, those with many children first, so that
 * blocks have few ranks */
static void layers_seat(struct layers *l, const struct pend_tree *tree, const struct layers_plan *plan, int layer) {
    int seat = plan->start[layer] * LAYER_ARMS, above = plan->start[layer + 1] * LAYER_ARMS;
    for (int i = 0; layer + 1 < plan->cap && i < plan->arms[layer + 1]; i++) {
        layers_sit(l, layers_first(tree, plan->height, l->arm[above + i]), seat++);
    }
    for (int degree = LAYERS_CHILDREN; degree >= 0; degree--) {
        for (int k = plan->head[layer]; k >= 0; k = plan->next[k]) {
            if (l->seat[k] < 0 && layers_degree(tree, k) == degree) layers_sit(l, k, seat++);
        }
    }
}

/* a rank without children yet */
static void layers_open(struct layers *l, int rank) {
    for (int i = 0; i < LAYER_ARMS; i++) l->rank[rank].children[i] = pend_layers_place(l->count * LAYER_ARMS);
}

/* the children of a joint: the first has its lane, where there is one, the others' places are found by rank */
static void layers_joint(struct layers *l, const struct pend_tree *tree, int k, int first, struct layer_block *block) {
    int rank = block->first, lane = l->seat[k] % LAYER_ARMS;
    int table = pend_layers_table(l->count) - LAYER_FIRST * LAYER_ARMS;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
        struct layer_block *own = &l->block[l->seat[c] / LAYER_ARMS];
        int at = l->seat[c] % LAYER_ARMS;
        own->parents[at] = own->shares[at] = pend_layers_place(l->seat[k]);
        if (c == first) continue;
        own->shares[at] = table + rank * LAYER_TABLE + lane;
        if (rank == block->end) layers_open(l, block->end++);
        l->rank[rank++].children[lane] = pend_layers_place(l->seat[c]);
    }
}

/* the joints of a block; none of the cap's has a first child in its lane */
static void layers_joints(struct layers *l, const struct pend_tree *tree, const struct layers_plan *plan, int i) {
    struct layer_block *block = &l->block[i];
    block->first = block->end = l->ranks;
    for (int lane = 0; lane < LAYER_ARMS; lane++) {
        int k = l->arm[i * LAYER_ARMS + lane];
        if (k < 0) continue;
        layers_joint(l, tree, k, i < l->count - 1 ? layers_first(tree, plan->height, k) : -1, block);
    }
    l->ranks = block->end;
}

/* the blocks of a layer, and which those of the layers next to it belong to */
static void layers_link(struct layers *l, const struct pend_tree *tree, const struct layers_plan *plan, int layer) {
    int firsts = layer + 1 < plan->cap ? plan->arms[layer + 1] : 0;
    for (int i = plan->start[layer]; i < plan->start[layer + 1]; i++) {
        struct layer_block *block = &l->block[i];
        int order = i - plan->start[layer];
        block->leaves = !layer;
        block->aligned = (order + 1) * LAYER_ARMS <= firsts;
        block->above = plan->start[layer + 1] + order;
        block->below = layer ? plan->start[layer - 1] + order : 0;
        if (layer) layers_joints(l, tree, plan, i);
    }
}

/* what no step changes, of leaves all but the share in their parents; an empty lane has a mass, to be divided by, but
 * no length */
static void layers_furnish(struct layers *l, const struct pend_tree *tree) {
    for (int i = 0; i < l->count * LAYER_ARMS; i++) {
        double *at = l->numbers + pend_layers_place(i);
        int k = l->arm[i];
        at[LAYER_MASS * LAYER_ARMS] = k < 0 ? 1 : tree->mass[k];
        at[LAYER_LENGTH * LAYER_ARMS] = k < 0 ? 0 : tree->len[k];
        at[LAYER_PART * LAYER_ARMS] = k < 0 ? 0 : 1 / tree->len[k];
        if (k < 0 || tree->end[k] > k + 1) continue;
        at[LAYER_EFF * LAYER_ARMS] = tree->mass[k];
        at[LAYER_WEIGHT * LAYER_ARMS] = tree->mass[k] * tree->len[k];
        at[LAYER_INV * LAYER_ARMS] = at[LAYER_INV_EFF * LAYER_ARMS] = 1 / tree->mass[k];
    }
}

/* who sits where: the cap's arms in stored order, then layer after layer from the top */
static void layers_seats(struct layers *l, const struct pend_tree *tree, const struct layers_plan *plan) {
    int padded = (tree->n + LAYER_ARMS - 1) / LAYER_ARMS * LAYER_ARMS, seat = (l->count - 1) * LAYER_ARMS;
    for (int k = 0; k < padded; k++) l->seat[k] = k < tree->n ? -1 : l->count * LAYER_ARMS;
    for (int i = 0; i < l->count * LAYER_ARMS; i++) l->arm[i] = -1;
    for (int k = 0; k < tree->n; k++) {
        if (plan->height[k] >= plan->cap) layers_sit(l, k, seat++);
    }
    for (int i = plan->cap - 1; i >= 0; i--) layers_seat(l, tree, plan, i);
}

void pend_layers_init(struct layers *l, const struct pend_tree *tree, void *memory) {
    struct layers_plan plan;
    layers_lay(l, &plan, tree, memory);
    layers_survey(&plan, tree);
    layers_seats(l, tree, &plan);
    int pivot = pend_layers_place(l->count * LAYER_ARMS);
    for (int i = 0; i < l->count; i++) {
        for (int lane = 0; lane < LAYER_ARMS; lane++) l->block[i].parents[lane] = l->block[i].shares[lane] = pivot;
    }
    for (int i = 0; i < plan.cap; i++) layers_link(l, tree, &plan, i);
    layers_joints(l, tree, &plan, l->count - 1);
    layers_furnish(l, tree);
}
