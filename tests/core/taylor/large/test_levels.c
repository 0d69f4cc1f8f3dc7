/* Tests of core/taylor/large/levels: every arm has a seat, every joint finds its children, and
 * trees for blocks are left to them. Leaves to others: what is computed in levels (test_jets).
 * Invariant: all is checked against the tree's own parents. */
#include "core/taylor/large/levels.h"

#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS_MAX = 4096 };

/* a tree by its parents, and its levels; memory is NULL where it is not for levels */
struct cut {
    struct pend_tree *tree;
    struct levels levels;
    void *memory;
};

static int cut_open(struct cut *cut, int n, const int parent[]) {
    static double ones[ARMS_MAX];
    for (int k = 0; k < n; k++) ones[k] = 1;
    cut->memory = NULL;
    if (pend_tree_new(&cut->tree, n, ones, ones, parent, NULL) != PEND_OK) return 0;
    if (!pend_levels_count(cut->tree)) return 1;
    size_t bytes = pend_levels_bytes(cut->tree);
    cut->memory = aligned_alloc(64, bytes);
    if (!cut->memory) return 0;
    memset(cut->memory, 0, bytes);
    pend_levels_init(&cut->levels, cut->tree, cut->memory);
    return 1;
}

static void cut_close(struct cut *cut) {
    free(cut->memory);
    pend_tree_free(&cut->tree);
}

/* arms that are not where their seat says, or whose parent's place is wrong */
static int wrong_seats(const struct cut *cut) {
    const struct levels *l = &cut->levels;
    int wrong = 0, seated = 0;
    for (int seat = 0; seat < l->count * LEVEL_ARMS; seat++) seated += l->arm[seat] >= 0;
    for (int k = 0; k < cut->tree->n; k++) {
        int seat = l->seat[k], p = cut->tree->parent[k];
        int parent = pend_levels_place(p < 0 ? l->count * LEVEL_ARMS : l->seat[p]);
        wrong +=
            l->arm[seat] != k || l->block[seat / LEVEL_ARMS].parents[seat % LEVEL_ARMS] != parent;
    }
    return wrong + abs(seated - cut->tree->n);
}

/* how often child c of arm k is found from k's block; what c feels across must be kept where it
 * is found */
static int found(const struct cut *cut, int k, int c) {
    const struct levels *l = &cut->levels;
    const struct level_block *block = &l->block[l->seat[k] / LEVEL_ARMS];
    const struct level_block *own = &l->block[l->seat[c] / LEVEL_ARMS];
    int lane = l->seat[k] % LEVEL_ARMS, share = own->shares[l->seat[c] % LEVEL_ARMS], count = 0;
    if (l->seat[k] / LEVEL_ARMS < l->count - 1 && l->seat[c] == block->below * LEVEL_ARMS + lane) {
        count += share == pend_levels_place(l->seat[k]);
    }
    for (int i = block->first; i < block->end; i++) {
        int row = pend_levels_table(l->count) + i * LEVEL_TABLE + lane - LEVEL_FIRST * LEVEL_ARMS;
        count += l->rank[i].children[lane] == pend_levels_place(l->seat[c]) && share == row;
    }
    return count;
}

static int wrong_children(const struct cut *cut) {
    int wrong = 0;
    for (int c = 1; c < cut->tree->n; c++) wrong += found(cut, cut->tree->parent[c], c) != 1;
    return wrong;
}

/* blocks whose arms have all their parents in the lanes above, or that touch one another, and do
 * not say so */
static int wrong_blocks(const struct cut *cut) {
    const struct levels *l = &cut->levels;
    int wrong = 0;
    for (int i = 0; i < l->count - 1; i++) {
        const struct level_block *block = &l->block[i];
        for (int lane = 0; lane < LEVEL_ARMS; lane++) {
            int k = l->arm[i * LEVEL_ARMS + lane];
            wrong += block->aligned &&
                     block->parents[lane] != pend_levels_place(block->above * LEVEL_ARMS + lane);
            if (k < 0) continue;
            wrong += block->leaves != (cut->tree->end[k] == k + 1);
            wrong += l->seat[cut->tree->parent[k]] / LEVEL_ARMS <= i;
        }
    }
    return wrong;
}

TEST(levels_seat_every_arm_and_find_every_child) {
    unsigned long long seed = 1;
    int layered = 0, aligned = 0;
    for (int i = 0; i < 400; i++) {
        static int parent[ARMS_MAX];
        int n = i < 300 ? 1 + i : 300 + test_random_int(&seed, ARMS_MAX - 300);
        struct cut cut;
        test_parents((enum test_tree_kind)(i % 3 ? TEST_TREE_ATTACHED : i % TEST_TREE_KINDS), n,
                     parent, &seed);
        REQUIRE(cut_open(&cut, n, parent));
        if (cut.memory) {
            layered++;
            for (int j = 0; j < cut.levels.count; j++) aligned += cut.levels.block[j].aligned;
            CHECK_INT(wrong_seats(&cut), 0);
            CHECK_INT(wrong_children(&cut), 0);
            CHECK_INT(wrong_blocks(&cut), 0);
        }
        cut_close(&cut);
    }
    CHECK_SAYING(layered > 200 && aligned > 1000,
                 "%d trees in layers, %d blocks below their parents", layered, aligned);
}

static int blocks_of(int n, const int parent[]) {
    struct cut cut;
    if (!cut_open(&cut, n, parent)) return -1;
    int count = pend_levels_count(cut.tree);
    cut_close(&cut);
    return count;
}

TEST(levels_leave_deep_crowded_and_narrow_trees_to_blocks) {
    static const enum test_tree_kind others[] = {TEST_TREE_CHAIN, TEST_TREE_STAR,
                                                 TEST_TREE_CATERPILLAR, TEST_TREE_BROOM};
    unsigned long long seed = 2;
    int parent[ARMS_MAX];
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        test_parents(others[i], 200, parent, &seed);
        CHECK_INT(blocks_of(200, parent), 0);
    }
    // the complete tree of 255: 128 + 64 + 32 + 16 + 8 arms in levels, 7 in the cap
    test_parents(TEST_TREE_BINARY, 255, parent, &seed);
    CHECK_INT(blocks_of(255, parent), 16 + 8 + 4 + 2 + 1 + 1);
    // one more child than an arm may have
    for (int degree = LEVELS_CHILDREN; degree <= LEVELS_CHILDREN + 1; degree++) {
        test_parents(TEST_TREE_BINARY, 255, parent, &seed);
        for (int k = 255; k < 255 + degree; k++) parent[k] = 254;
        CHECK_INT(blocks_of(255 + degree, parent) > 0, degree == LEVELS_CHILDREN);
    }
    // one more level than there may be, of a tree so large that narrow ones do not count
    for (int levels = LEVELS_MAX; levels <= LEVELS_MAX + 1; levels++) {
        test_parents(TEST_TREE_BINARY, 2047, parent, &seed);
        for (int i = 0; i < levels - 11; i++) parent[2047 + i] = 2046 + i;
        CHECK_INT(blocks_of(2047 + levels - 11, parent) > 0, levels == LEVELS_MAX);
    }
}
