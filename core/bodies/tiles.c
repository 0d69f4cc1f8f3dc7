#include "core/bodies/tiles.h"

#include <assert.h>

/* bytes of a line of memory; arms of the largest tree that was measured */
enum { TILES_LINE = 64, TILES_MOST = 256 };

static void *tiles_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + TILES_LINE - 1) / TILES_LINE * TILES_LINE;
    return part;
}

/* an arm that hangs on no arm of its own tile */
static int tiles_is_root(const struct pend_tree *tree, int k) {
    return tree->parent[k] < k / TILE_ARMS * TILE_ARMS;
}

/* the roots and kids of a tile */
static struct tile tiles_measure(const struct pend_tree *tree, int index) {
    struct tile tile = {.first = index * TILE_ARMS};
    int left = tree->n - tile.first;
    assert(index >= 0 && left > 0);
    tile.arms = left < TILE_ARMS ? left : TILE_ARMS;
    for (int k = tile.first; k < tile.first + tile.arms; k++) {
        tile.roots += tiles_is_root(tree, k);
        for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) tile.kids += tiles_is_root(tree, c);
    }
    return tile;
}

/* where the numbers of a tile are, from `at` on; returns how many there are */
static size_t tiles_place(struct tile *tile, size_t at) {
    size_t kids = (size_t)tile->kids, start = at, rows = (size_t)TILE_INPUTS * TILE_ARMS;
    size_t gain = kids * TILE_OUT * TILE_OUT * (1 + kids);
    tile->columns = at, at += rows * (TILE_ANSWERS + TILE_ARMS);
    tile->sway = at, at += TILE_ARMS * TILE_ANSWERS;
    tile->gain = at, at += (gain + TILE_ARMS - 1) / TILE_ARMS * TILE_ARMS;
    tile->state = at, at += rows + TILE_ANSWERS + TILE_ARMS;
    return at - start;
}

static size_t tiles_lay(struct tiles *tiles, const struct pend_tree *tree, char *base) {
    size_t used = 0, n = (size_t)tree->n, numbers = 0;
    tiles->count = (tree->n + TILE_ARMS - 1) / TILE_ARMS;
    for (int i = 0; i < tiles->count; i++) {
        struct tile tile = tiles_measure(tree, i);
        numbers += tiles_place(&tile, 0);
    }
    tiles->numbers = tiles_take(base, &used, numbers, sizeof(double));
    tiles->tile = tiles_take(base, &used, (size_t)tiles->count, sizeof *tiles->tile);
    tiles->root = tiles_take(base, &used, n, sizeof(int));
    tiles->kid = tiles_take(base, &used, n, sizeof(int));
    tiles->kid_root = tiles_take(base, &used, n, sizeof(int));
    return used;
}

int pend_tiles_suit(const struct pend_tree *tree) {
    for (int first = 0; first < tree->n; first += TILE_ARMS) {
        struct tile tile = tiles_measure(tree, first / TILE_ARMS);
        if (TILE_OUT * (tile.roots + tile.kids) > TILE_ARMS) return 0;
    }
    return tree->n > TILE_ARMS && tree->n <= TILES_MOST;
}

size_t pend_tiles_bytes(const struct pend_tree *tree) {
    struct tiles sketch;
    return tiles_lay(&sketch, tree, NULL);
}

/* the root of its tile that arm k hangs on */
static int tiles_root_of(const struct pend_tree *tree, int k) {
    while (!tiles_is_root(tree, k)) k = tree->parent[k];
    return k;
}

void pend_tiles_init(struct tiles *tiles, const struct pend_tree *tree, void *memory) {
    assert(pend_tiles_suit(tree) && (size_t)memory % TILES_LINE == 0);
    tiles_lay(tiles, tree, memory);
    int roots = 0, kids = 0;
    size_t at = 0;
    for (int i = 0; i < tiles->count; i++) {
        struct tile tile = tiles_measure(tree, i);
        at += tiles_place(&tile, at);
        tile.root = roots, tile.kid = kids;
        for (int k = tile.first; k < tile.first + tile.arms; k++) {
            if (tiles_is_root(tree, k)) tiles->root[roots++] = k;
            for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) {
                if (!tiles_is_root(tree, c)) continue;
                tiles->kid_root[kids] = tiles_root_of(tree, k);
                tiles->kid[kids++] = c;
            }
        }
        tiles->tile[i] = tile;
    }
    assert(kids == roots - 1); // only the first arm hangs on the pivot
}
