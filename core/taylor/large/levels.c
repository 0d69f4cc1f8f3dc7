#include "core/taylor/large/levels.h"

#include <assert.h>
#include <string.h>

/* the heights of arms from the children visited so far, one per waiting joint */
struct levels_climb {
    int joint[LEVELS_MAX], height[LEVELS_MAX], waiting;
};

/* the height of arm k; arms are visited from the last to the first; sizes of sub-trees halve, which
 * bounds the waiting joints */
static int levels_height(struct levels_climb *climb, const struct pend_tree *tree, int k) {
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

static int levels_degree(const struct pend_tree *tree, int k) {
    int degree = 0;
    for (int c = k + 1; c < tree->end[k] && degree <= LEVELS_CHILDREN; c = tree->end[c]) degree++;
    return degree;
}

/* number of arms of each level; returns the number of levels, 0 for a tree unsuitable for levels */
static int levels_measure(const struct pend_tree *tree, int arms[LEVELS_MAX]) {
    struct levels_climb climb = {.waiting = 0};
    int levels = 0;
    memset(arms, 0, LEVELS_MAX * sizeof *arms);
    for (int k = tree->n - 1; k >= 0; k--) {
        int height = levels_height(&climb, tree, k);
        if (height >= LEVELS_MAX || levels_degree(tree, k) > LEVELS_CHILDREN) return 0;
        arms[height]++;
        if (height >= levels) levels = height + 1;
    }
    return levels;
}

static int levels_blocks(int arms) { return (arms + LEVEL_ARMS - 1) / LEVEL_ARMS; }

/* the lowest of the levels in the cap, which has as many arms as one block has lanes */
static int levels_cap(const int arms[], int levels) {
    int room = LEVEL_ARMS;
    while (levels > 0 && arms[levels - 1] <= room) room -= arms[--levels];
    return levels;
}

int pend_levels_count(const struct pend_tree *tree) {
    int arms[LEVELS_MAX], levels = levels_measure(tree, arms), cap = levels_cap(arms, levels),
                          count = 1;
    for (int i = 0; i < cap; i++) count += levels_blocks(arms[i]);
    return cap > 0 && count <= 3 * levels_blocks(tree->n) / 2 ? count : 0;
}

/* number of arms that are not their parent's first child: the number of leaves minus one */
static int levels_light(const struct pend_tree *tree) {
    int light = -1;
    for (int k = 0; k < tree->n; k++) light += tree->end[k] == k + 1;
    return light;
}

static void *levels_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + 63) / 64 * 64;
    return part;
}

/* data of the decomposition; level i has arms[i] arms, and blocks from start[i] on */
struct levels_plan {
    int *height, *next; /* of an arm; the next one of the same height, -1 after the last */
    int cap, arms[LEVELS_MAX], head[LEVELS_MAX],
        start[LEVELS_MAX + 1]; /* the cap's lowest level; lists of the arms */
};

static size_t levels_lay(struct levels *l, struct levels_plan *plan, const struct pend_tree *tree,
                         char *base) {
    size_t used = 0, ranks = (size_t)(levels_light(tree) + LEVELS_CHILDREN), n = (size_t)tree->n;
    l->count = pend_levels_count(tree);
    l->ranks = 0;
    l->numbers = levels_take(
        base, &used, ((size_t)l->count + 1) * LEVEL_NUMBERS + ranks * LEVEL_TABLE, sizeof(double));
    l->up = levels_take(base, &used, LEVEL_ARMS * LEVEL_ARMS, sizeof(double));
    l->down = levels_take(base, &used, LEVEL_ARMS * LEVEL_ARMS, sizeof(double));
    l->block = levels_take(base, &used, (size_t)l->count, sizeof *l->block);
    l->rank = levels_take(base, &used, ranks, sizeof *l->rank);
    l->seat = levels_take(base, &used, (n + LEVEL_ARMS - 1) / LEVEL_ARMS * LEVEL_ARMS, sizeof(int));
    l->arm = levels_take(base, &used, (size_t)l->count * LEVEL_ARMS, sizeof(int));
    for (int i = 0; i < LEVELS_CHANGES; i++) {
        l->change[i] =
            levels_take(base, &used, ((size_t)l->count + 1) * LEVEL_ARMS, sizeof(double));
    }
    plan->height = levels_take(base, &used, n, sizeof(int));
    plan->next = levels_take(base, &used, n, sizeof(int));
    return used;
}

size_t pend_levels_bytes(const struct pend_tree *tree) {
    assert(pend_levels_count(tree) > 0);
    struct levels sketch;
    struct levels_plan plan;
    return levels_lay(&sketch, &plan, tree, NULL);
}

/* the first of an arm's highest children */
static int levels_first(const struct pend_tree *tree, const int height[], int k) {
    int c = k + 1;
    while (height[c] != height[k] - 1) c = tree->end[c];
    return c;
}

static void levels_sit(struct levels *l, int k, int seat) {
    l->seat[k] = seat;
    l->arm[seat] = k;
}

/* heights of all arms, and lists of the arms of a height */
static void levels_survey(struct levels_plan *plan, const struct pend_tree *tree) {
    struct levels_climb climb = {.waiting = 0};
    int levels = levels_measure(tree, plan->arms);
    plan->cap = levels_cap(plan->arms, levels);
    plan->start[0] = 0;
    for (int i = 0; i < levels; i++) {
        plan->head[i] = -1;
        plan->start[i + 1] = plan->start[i] + (i < plan->cap ? levels_blocks(plan->arms[i]) : 0);
    }
    for (int k = tree->n - 1; k >= 0; k--) {
        int height = plan->height[k] = levels_height(&climb, tree, k);
        plan->next[k] = plan->head[height];
        plan->head[height] = k;
    }
}

/* seats of a level: first children in their parents' lanes, then the others, those with many
 * children first, so that blocks have few ranks */
static void levels_seat(struct levels *l, const struct pend_tree *tree,
                        const struct levels_plan *plan, int level) {
    int seat = plan->start[level] * LEVEL_ARMS, above = plan->start[level + 1] * LEVEL_ARMS;
    for (int i = 0; level + 1 < plan->cap && i < plan->arms[level + 1]; i++) {
        levels_sit(l, levels_first(tree, plan->height, l->arm[above + i]), seat++);
    }
    for (int degree = LEVELS_CHILDREN; degree >= 0; degree--) {
        for (int k = plan->head[level]; k >= 0; k = plan->next[k]) {
            if (l->seat[k] < 0 && levels_degree(tree, k) == degree) levels_sit(l, k, seat++);
        }
    }
}

/* starts a rank without children */
static void levels_open(struct levels *l, int rank) {
    for (int i = 0; i < LEVEL_ARMS; i++)
        l->rank[rank].children[i] = pend_levels_place(l->count * LEVEL_ARMS);
}

/* the children of a joint: the first has the joint's lane, if there is one; the places of the
 * others are found by rank */
static void levels_joint(struct levels *l, const struct pend_tree *tree, int k, int first,
                         struct level_block *block) {
    int rank = block->first, lane = l->seat[k] % LEVEL_ARMS;
    int table = pend_levels_table(l->count) - LEVEL_FIRST * LEVEL_ARMS;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
        struct level_block *own = &l->block[l->seat[c] / LEVEL_ARMS];
        int at = l->seat[c] % LEVEL_ARMS;
        own->parents[at] = own->shares[at] = pend_levels_place(l->seat[k]);
        if (c == first) continue;
        own->shares[at] = table + rank * LEVEL_TABLE + lane;
        if (rank == block->end) levels_open(l, block->end++);
        l->rank[rank++].children[lane] = pend_levels_place(l->seat[c]);
    }
}

/* the joints of a block; in the cap no first child has its parent's lane */
static void levels_joints(struct levels *l, const struct pend_tree *tree,
                          const struct levels_plan *plan, int i) {
    struct level_block *block = &l->block[i];
    block->first = block->end = l->ranks;
    for (int lane = 0; lane < LEVEL_ARMS; lane++) {
        int k = l->arm[i * LEVEL_ARMS + lane];
        if (k < 0) continue;
        levels_joint(l, tree, k, i < l->count - 1 ? levels_first(tree, plan->height, k) : -1,
                     block);
    }
    l->ranks = block->end;
}

/* links the blocks of a level to those of the neighbouring levels */
static void levels_link(struct levels *l, const struct pend_tree *tree,
                        const struct levels_plan *plan, int level) {
    int firsts = level + 1 < plan->cap ? plan->arms[level + 1] : 0;
    for (int i = plan->start[level]; i < plan->start[level + 1]; i++) {
        struct level_block *block = &l->block[i];
        int order = i - plan->start[level];
        block->leaves = !level;
        block->aligned = (order + 1) * LEVEL_ARMS <= firsts;
        block->above = plan->start[level + 1] + order;
        block->below = level ? plan->start[level - 1] + order : 0;
        if (level) levels_joints(l, tree, plan, i);
    }
}

/* Sets the values that no step changes; for leaves all except the share in their parents. An empty
 * lane has a mass, because it is a divisor, but no length. */
static void levels_furnish(struct levels *l, const struct pend_tree *tree) {
    for (int i = 0; i < l->count * LEVEL_ARMS; i++) {
        double *at = l->numbers + pend_levels_place(i);
        int k = l->arm[i];
        at[LEVEL_MASS * LEVEL_ARMS] = k < 0 ? 1 : tree->mass[k];
        at[LEVEL_LENGTH * LEVEL_ARMS] = k < 0 ? 0 : tree->len[k];
        at[LEVEL_PART * LEVEL_ARMS] = k < 0 ? 0 : 1 / tree->len[k];
        if (k < 0 || tree->end[k] > k + 1) continue;
        at[LEVEL_EFF * LEVEL_ARMS] = tree->mass[k];
        at[LEVEL_WEIGHT * LEVEL_ARMS] = tree->mass[k] * tree->len[k];
        at[LEVEL_INV * LEVEL_ARMS] = at[LEVEL_INV_EFF * LEVEL_ARMS] = 1 / tree->mass[k];
    }
}

/* assigns seats: the cap's arms in stored order, then level after level from the top */
static void levels_seats(struct levels *l, const struct pend_tree *tree,
                         const struct levels_plan *plan) {
    int padded = (tree->n + LEVEL_ARMS - 1) / LEVEL_ARMS * LEVEL_ARMS,
        seat = (l->count - 1) * LEVEL_ARMS;
    for (int k = 0; k < padded; k++) l->seat[k] = k < tree->n ? -1 : l->count * LEVEL_ARMS;
    for (int i = 0; i < l->count * LEVEL_ARMS; i++) l->arm[i] = -1;
    for (int k = 0; k < tree->n; k++) {
        if (plan->height[k] >= plan->cap) levels_sit(l, k, seat++);
    }
    for (int i = plan->cap - 1; i >= 0; i--) levels_seat(l, tree, plan, i);
}

void pend_levels_init(struct levels *l, const struct pend_tree *tree, void *memory) {
    assert(pend_levels_count(tree) > 0 && (size_t)memory % 64 == 0);
    struct levels_plan plan;
    levels_lay(l, &plan, tree, memory);
    levels_survey(&plan, tree);
    levels_seats(l, tree, &plan);
    int pivot = pend_levels_place(l->count * LEVEL_ARMS);
    for (int i = 0; i < l->count; i++) {
        for (int lane = 0; lane < LEVEL_ARMS; lane++)
            l->block[i].parents[lane] = l->block[i].shares[lane] = pivot;
    }
    for (int i = 0; i < plan.cap; i++) levels_link(l, tree, &plan, i);
    levels_joints(l, tree, &plan, l->count - 1);
    levels_furnish(l, tree);
}
