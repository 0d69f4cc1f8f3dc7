#include "core/taylor/jets_loads.h"

#include <assert.h>

enum { LOADS_SMALL = 8, LOADS_SPARE = 3, LOADS_TILE = 8 };

/* counts the memory needed and, if memory is given, assigns it */
struct loads_store {
    char *base;
    size_t used;
};

static void *loads_take(struct loads_store *store, size_t count, size_t bytes) {
    void *part = store->base ? store->base + store->used : NULL;
    store->used += (count * bytes + 63) / 64 * 64;
    return part;
}

/* an array of `count` numbers with `margin` zeros before it */
static double *loads_numbers(struct loads_store *store, size_t margin, size_t count) {
    double *at = loads_take(store, margin + count, sizeof(double));
    return at ? at + margin : NULL;
}

/* numbers of one row for all orders, and of one series, for up to eight arms; `twist` has one row
 * per arm, which can be more than a short series has orders */
static size_t loads_row_numbers(int order_cap) {
    int orders = order_cap + LOADS_SPARE;
    return (size_t)(orders < LOADS_SMALL ? LOADS_SMALL : orders) * LOADS_STRIDE;
}

static size_t loads_series_numbers(int order_cap) {
    return (size_t)order_cap + LOADS_SPARE + 2 * (size_t)LOADS_MARGIN;
}

static int loads_couple(const struct pend_terms *terms) {
    return terms->row[PEND_TERM_STIFFNESS] >= 0 || terms->row[PEND_TERM_DAMPING] >= 0 ||
           terms->row[PEND_TERM_TORQUE] >= 0 || terms->row[PEND_TERM_INPUT] >= 0 ||
           terms->row[PEND_TERM_SLIDE] >= 0 ||
           (terms->harmonics && terms->harmonic[terms->harmonics - 1].drives >= 0);
}

/* arrays for torques between the arms of a large tree */
static void loads_lay_large(struct jets_loads *loads, const struct pend_tree *tree,
                            const struct loads_layout *layout, struct loads_store *store) {
    size_t count = (size_t)layout->padded, n = (size_t)tree->n;
    loads->parent = loads_take(store, count, sizeof(int));
    loads->child = loads_take(store, count, sizeof(int));
    loads->near = loads_take(store, count / LOADS_TILE, sizeof *loads->near);
    loads->kid = loads_take(store, n, sizeof *loads->kid);
#define X(name) loads->name = loads_numbers(store, LOADS_MARGIN, count + LOADS_MARGIN);
    LOADS_ARMS(X)
#undef X
#define X(name) loads->name = loads_numbers(store, LOADS_MARGIN, count * (size_t)layout->rows);
    LOADS_TILES(X)
#undef X
}

static size_t loads_lay(struct jets_loads *loads, const struct pend_tree *tree, int order_cap,
                        const struct loads_layout *layout, char *base) {
    struct loads_store store = {base, 0};
#define X(name) loads->name = loads_numbers(&store, LOADS_MARGIN, loads_series_numbers(order_cap));
    LOADS_SERIES(X)
#undef X
    if (tree->n > LOADS_SMALL) {
        if (loads->couples || loads->shaped) loads_lay_large(loads, tree, layout, &store);
        return store.used;
    }
    loads->bend = loads_numbers(&store, 0, LOADS_MARGIN);
#define X(name) loads->name = loads_numbers(&store, 0, loads_row_numbers(order_cap));
    LOADS_ROWS(X)
#undef X
    return store.used;
}

size_t pend_jets_loads_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                             int order_cap, const struct loads_layout *layout) {
    struct jets_loads sketch = {.couples = loads_couple(terms), .shaped = jets_loads_bodies(terms)};
    return loads_lay(&sketch, tree, order_cap, layout, NULL);
}

/* fills in the forces across the arms for unit torques */
static void loads_twists(struct jets_loads *loads, const struct pend_tree *tree) {
    int from = tree->n > 4 ? 8 : tree->n > 2 ? 4 : 2;
    for (int a = 0; a < tree->n; a++) {
        double *forces = loads->twist + a * LOADS_STRIDE + from;
        forces[a] = 1 / tree->len[a];
        if (tree->parent[a] >= 0) forces[tree->parent[a]] = -1 / tree->len[tree->parent[a]];
    }
}

static void loads_children(struct jets_loads *loads, const struct pend_tree *tree,
                           const struct loads_layout *layout) {
    for (int a = 0; a < loads->padded; a++) loads->child[a] = -1;
    // lay out from the last arm on, because the kernels read the last order in memory last
    for (int k = tree->n - 1; k >= 0; k--) {
        int first = tree->end[k] > k + 1 ? k + 1 : -1;
        loads->child[k] = first;
        size_t row = (size_t)(k / LOADS_TILE * layout->rows * LOADS_TILE + k % LOADS_TILE);
        for (int c = k + 1; c < tree->end[k]; c = tree->end[c])
            if (c != first)
                loads->kid[loads->kids++] = (struct loads_kid){row, 1 / tree->len[k], c};
    }
}

/* the index at which the neighbours of the tile's eight arms begin in memory if they are
 * consecutive, otherwise LOADS_APART; an arm without neighbour reads padding or a margin, which are
 * zero */
static int loads_near(const struct jets_loads *loads, const int from[], int tile) {
    int start = LOADS_APART;
    for (int i = 0; i < LOADS_TILE; i++)
        if (from[tile * LOADS_TILE + i] >= 0) start = from[tile * LOADS_TILE + i] - i;
    if (start == LOADS_APART) return -LOADS_MARGIN;
    for (int i = 0; i < LOADS_TILE; i++) {
        int own = tile * LOADS_TILE + i, at = start + i;
        int zero = at < 0 || at >= loads->padded || loads->part[at] == 0;
        if (loads->part[own] != 0 && from[own] != at && !(from[own] < 0 && zero))
            return LOADS_APART;
    }
    return start < -LOADS_MARGIN ? LOADS_APART : start;
}

/* the parents and the first children of all arms */
static void loads_neighbours(struct jets_loads *loads, const struct pend_tree *tree,
                             const struct loads_layout *layout) {
    loads_children(loads, tree, layout);
    for (int a = 0; a < loads->padded; a++) loads->parent[a] = -1;
    for (int k = 0; k < tree->n; k++) {
        loads->part[k] = 1 / tree->len[k];
        loads->parent[k] = tree->parent[k];
    }
    for (int t = 0; t < loads->padded / LOADS_TILE; t++)
        loads->near[t] = (struct loads_tile){loads_near(loads, loads->parent, t),
                                             loads_near(loads, loads->child, t)};
}

void pend_jets_loads_init(struct jets_loads *loads, const struct pend_tree *tree,
                          const struct pend_terms *terms, int order_cap,
                          const struct loads_layout *layout, void *memory) {
    assert((size_t)memory % 64 == 0);
    int arms = terms->harmonics && terms->harmonic[terms->harmonics - 1].drives >= 0,
        pivot = terms->harmonics && terms->harmonic[0].drives < 0;
    *loads = (struct jets_loads){.terms = terms,
                                 .couples = loads_couple(terms),
                                 .shaped = jets_loads_bodies(terms),
                                 .springs = terms->row[PEND_TERM_STIFFNESS] >= 0,
                                 .losses = terms->row[PEND_TERM_DAMPING] >= 0,
                                 .drives = arms,
                                 .moves = pivot || terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0};
    loads_lay(loads, tree, order_cap, layout, memory);
    if (tree->n <= LOADS_SMALL) {
        loads_twists(loads, tree);
        return;
    }
    loads->padded = layout->padded;
    if (loads->couples) loads_neighbours(loads, tree, layout);
}
