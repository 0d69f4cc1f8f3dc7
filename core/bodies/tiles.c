#include "core/bodies/tiles.h"

#include <assert.h>

/* bytes of a line of memory; arms of the largest tree: tables of more are read from far memory */
enum { TILES_LINE = 64, TILES_MOST = 40 };

static void *tiles_take(char *base, size_t *used, size_t count, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (count * bytes + TILES_LINE - 1) / TILES_LINE * TILES_LINE;
    return part;
}

/* an arm that hangs on no arm of its own tile */
static int tiles_is_root(const struct pend_tree *tree, int k) {
    return tree->parent[k] < k / TILE_ARMS * TILE_ARMS;
}

/* children of arm k in other tiles */
static int tiles_kids(const struct pend_tree *tree, int k) {
    int kids = 0;
    for (int c = k + 1; c < tree->end[k]; c = tree->end[c]) kids += tiles_is_root(tree, c);
    return kids;
}

/* the roots and ports of a tile */
static struct tile tiles_measure(const struct pend_tree *tree, int index) {
    struct tile tile = {.first = index * TILE_ARMS};
    int left = tree->n - tile.first;
    assert(index >= 0 && left > 0);
    tile.arms = left < TILE_ARMS ? left : TILE_ARMS;
    for (int k = tile.first; k < tile.first + tile.arms; k++) {
        tile.roots += tiles_is_root(tree, k);
        tile.ports += tiles_kids(tree, k) > 0;
    }
    int outs = TILE_ROOT * tile.roots + TILE_PORT * tile.ports;
    tile.outs = (outs + TILE_ARMS - 1) / TILE_ARMS * TILE_ARMS;
    return tile;
}

/* where the numbers of a tile are, from `at` on; returns how many there are */
static size_t tiles_place(struct tile *tile, size_t at) {
    size_t outs = (size_t)tile->outs, ports = (size_t)tile->ports, start = at;
    size_t gain = ports * (TILE_ROOT * TILE_ROOT + TILE_LEAN + TILE_PORT * TILE_PORT * ports);
    size_t rows = (size_t)TILE_INPUTS * TILE_ARMS;
    tile->columns = at, at += rows * (TILE_ANSWERS + outs);
    tile->sway = at, at += outs * TILE_ANSWERS;
    tile->gain = at, at += (gain + TILE_ARMS - 1) / TILE_ARMS * TILE_ARMS;
    tile->state = at, at += rows + TILE_ANSWERS + outs;
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
    tiles->port = tiles_take(base, &used, n, sizeof(int));
    tiles->port_root = tiles_take(base, &used, n, sizeof(int));
    tiles->kid_first = tiles_take(base, &used, n + 1, sizeof(int));
    tiles->kid = tiles_take(base, &used, n, sizeof(int));
    return used;
}

int pend_tiles_suit(const struct pend_tree *tree) {
    for (int first = 0; first < tree->n; first += TILE_ARMS)
        if (tiles_measure(tree, first / TILE_ARMS).outs > TILE_ARMS) return 0;
    return tree->n > TILE_ARMS && tree->n <= TILES_MOST;
}

size_t pend_tiles_bytes(const struct pend_tree *tree) {
    struct tiles sketch;
    return tiles_lay(&sketch, tree, NULL);
}

/* which of the tile's roots arm k hangs on */
static int tiles_root_of(const struct tiles *tiles, const struct tile *tile,
                         const struct pend_tree *tree, int k) {
    int i = 0;
    while (tree->parent[k] >= tile->first) k = tree->parent[k];
    while (i < tile->roots && tiles->root[tile->root + i] != k) i++;
    assert(i < tile->roots);
    return i;
}

void pend_tiles_init(struct tiles *tiles, const struct pend_tree *tree, void *memory) {
    assert(pend_tiles_suit(tree) && (size_t)memory % TILES_LINE == 0);
    tiles_lay(tiles, tree, memory);
    int roots = 0, ports = 0, kids = 0;
    size_t at = 0;
    for (int i = 0; i < tiles->count; i++) {
        struct tile tile = tiles_measure(tree, i);
        at += tiles_place(&tile, at);
        tile.root = roots, tile.port = ports;
        for (int k = tile.first; k < tile.first + tile.arms; k++) {
            if (tiles_is_root(tree, k)) tiles->root[roots++] = k;
            if (!tiles_kids(tree, k)) continue;
            tiles->port[ports] = k;
            tiles->port_root[ports] = tiles_root_of(tiles, &tile, tree, k);
            tiles->kid_first[ports++] = kids;
            for (int c = k + 1; c < tree->end[k]; c = tree->end[c])
                if (tiles_is_root(tree, c)) tiles->kid[kids++] = c;
        }
        tiles->tile[i] = tile;
    }
    tiles->kid_first[ports] = kids;
    assert(ports <= tree->n && kids == roots - 1); // only the first arm hangs on the pivot
}
