#include "core/bodies/bodies.h"

#include <assert.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/bodies/tiles.h"

enum {
    BODIES_TILE = 8,
    BODIES_AHEAD = 3 /* rows of a series beyond its order: turns are two ahead */
};

const struct bodies_kernel *pend_kernel_bodies(void) {
#ifdef __x86_64__
    enum pend_isa isa = pend_isa_best();
    if (isa == PEND_ISA_AVX512) return &pend_kernel_bodies_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_bodies_avx2;
#endif
    return &pend_kernel_bodies_base;
}

/* arms, padded to whole tiles */
static size_t bodies_arms(int n) {
    return ((size_t)n + BODIES_TILE - 1) / BODIES_TILE * BODIES_TILE;
}

static size_t bodies_series(int n, int order) {
    return bodies_arms(n) * (size_t)(order + BODIES_AHEAD);
}

/* the numbers of a system without the four series that jets has */
static size_t bodies_own(const struct pend_tree *tree, const struct pend_terms *terms, int order) {
    return bodies_numbers(terms, bodies_arms(tree->n), bodies_series(tree->n, order), order) +
           2 * bodies_arms(tree->n);
}

/* tiles cost a step their tables, which one order does not pay for; a cart has none, and where the
 * air acts on tips they gain nothing */
static int bodies_tiled(const struct pend_tree *tree, const struct pend_terms *terms, int order) {
    return order > 1 && !pend_terms_cart(terms) && !(bodies_needs(terms) & BODIES_AIR) &&
           pend_tiles_suit(tree);
}

static size_t bodies_numbers_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                                   int order) {
    return (bodies_own(tree, terms, order) + 7) / 8 * 8 * sizeof(double);
}

enum { BODIES_TILES = (sizeof(struct tiles) + 63) / 64 * 64 };

size_t pend_bodies_system_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                                int order) {
    size_t bytes = bodies_numbers_bytes(tree, terms, order);
    if (!bodies_tiled(tree, terms, order)) return bytes;
    return bytes + BODIES_TILES + pend_tiles_bytes(tree);
}

void pend_bodies_system(struct bodies_system *system, const struct pend_tree *tree,
                        const struct pend_loads *loads, int order, void *memory) {
    assert(tree->n >= 1 && loads->terms && order >= 1);
    size_t arms = bodies_arms(tree->n);
    memset(memory, 0, pend_bodies_system_bytes(tree, loads->terms, order));
    double *len = memory, *mass = len + arms;
    for (int k = 0; k < tree->n; k++) len[k] = tree->len[k], mass[k] = tree->mass[k];
    *system = (struct bodies_system){.n = tree->n,
                                     .stride = BODIES_TILE,
                                     .tile = (size_t)BODIES_TILE * (size_t)(order + BODIES_AHEAD),
                                     .parent = tree->parent,
                                     .terms = loads->terms,
                                     .len = len,
                                     .mass = mass,
                                     .value = loads->value};
    bodies_lay(system, arms, bodies_series(tree->n, order), order, mass + arms);
    if (!bodies_tiled(tree, loads->terms, order)) return;
    // behind the numbers
    char *at = (char *)memory + bodies_numbers_bytes(tree, loads->terms, order);
    struct tiles *tiles = (struct tiles *)(void *)at;
    pend_tiles_init(tiles, tree, at + BODIES_TILES);
    system->tiles = tiles;
}

size_t pend_bodies_bytes(const struct pend_tree *tree, const struct pend_terms *terms) {
    return pend_bodies_system_bytes(tree, terms, 1) +
           4 * bodies_series(tree->n, 1) * sizeof(double);
}

/* the force of the rail on a cart, along and across it */
static void bodies_rail(const struct bodies_system *s, const struct bodies_forces *forces) {
    double c = -s->point_y[0], z = s->point_x[0], x = s->haul_x[0], y = s->haul_y[0];
    assert(s->terms->one[PEND_TERM_RAIL] >= 0);
    double along = c * x + z * y, across = c * y - z * x;
    if (forces->joint_along) forces->joint_along[0] = along;
    if (forces->joint_across) forces->joint_across[0] = across;
    if (forces->tip_along) forces->tip_along[0] = along;
    if (forces->tip_across) forces->tip_across[0] = across;
}

/* the system at a state, to order 1 in seconds */
static struct bodies_system bodies_expand(const struct pend_tree *tree,
                                          const struct pend_loads *loads,
                                          const struct bodies_state *state, void *work) {
    struct bodies_system s;
    size_t series = bodies_series(tree->n, 1),
           own = pend_bodies_system_bytes(tree, loads->terms, 1);
    pend_bodies_system(&s, tree, loads, 1, work);
    s.rate = (double *)(void *)((char *)work + own);
    s.force = s.rate + series, s.turn_re = s.rate + 2 * series, s.turn_im = s.rate + 3 * series;
    memset(s.rate, 0, 4 * series * sizeof(double));
    pend_kernel_bodies()->orders(&s, state, loads->gravity, 1, 1);
    return s;
}

void pend_bodies_power_at(const struct pend_tree *tree, const struct pend_loads *loads,
                          const struct bodies_state *state, void *work, double acc[], double *given,
                          double *lost) {
    struct bodies_system s = bodies_expand(tree, loads, state, work);
    pend_kernel_bodies()->power(&s, 1, 1, given, lost);
    for (int k = 0; k < tree->n; k++) acc[k] = s.rate[bodies_row(&s, k) + s.stride];
}

void pend_bodies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                    const struct bodies_state *state, void *work, double acc[],
                    const struct bodies_forces *forces) {
    struct bodies_system s = bodies_expand(tree, loads, state, work);
    for (int k = 0; k < tree->n; k++) {
        size_t row = bodies_row(&s, k);
        acc[k] = s.rate[row + s.stride];
        if (!forces) continue;
        double x = s.base_x[k], y = s.base_y[k];
        if (forces->joint_along)
            forces->joint_along[k] = s.form_xx[k] * x + s.form_xy[k] * y + s.asked_x[k];
        if (forces->joint_across)
            forces->joint_across[k] = s.form_xy[k] * x + s.form_yy[k] * y + s.asked_y[k];
        if (forces->tip_along) forces->tip_along[k] = s.tip_x[row];
        if (forces->tip_across) forces->tip_across[k] = s.tip_y[row];
    }
    if (forces && pend_terms_cart(loads->terms)) bodies_rail(&s, forces);
}
