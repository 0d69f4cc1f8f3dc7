/* Memory and angles for the power series of one tree.
 * Leaves to others: the series themselves (kernel_jets).
 * Invariant: u = e^{i phi} is computed anew from the summed angles at every expansion. */
#include "core/taylor/jets/jets.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
#define X(name) JETS_##name,
    JETS_FACTOR_ARRAYS(X)
#undef X
        JETS_COUNT,
    JETS_SHARES = 48,
    JETS_BEYOND = 3 /* rows of a tile beyond the order: two more for u, one for the known part of an
                     * order */
};

size_t pend_jets_stride(int n) {
    assert(n >= 1);
    return ((size_t)n + PEND_JETS_PAD - 1) / PEND_JETS_PAD * PEND_JETS_PAD;
}

static size_t jets_series(int order_cap, const struct pend_tree *tree) {
    return (size_t)(order_cap + JETS_BEYOND) * pend_jets_stride(tree->n);
}

/* count of doubles of the series and of the factorization */
static size_t jets_numbers(int order_cap, const struct pend_tree *tree) {
    return 4 * jets_series(order_cap, tree) + JETS_COUNT * pend_jets_stride(tree->n) + JETS_SHARES;
}

/* the system's arrays are in this memory, and at most one of blocks and chain is set */
PEND_VALIDATOR jets_valid(const struct pend_jets *jets) {
    const struct jets_system *s = &jets->system;
    int cuts = (s->chain != NULL) + (s->blocks != NULL) + jets->general;
    return jets->tree && s->n == jets->tree->n && s->rate == jets->rate &&
           s->force == jets->force && cuts == (s->n > PEND_JETS_PAD || jets->general) &&
           jets->real == (jets->general || s->loads != NULL);
}

/* true if the terms require the general kernel, for any values */
static int jets_general(const struct pend_tree *tree, const struct pend_terms *terms) {
    return terms && !jets_loads_suit(tree, terms);
}

/* the layout of the series of a pendulum for the fast kernels */
static struct loads_layout jets_layout(const struct pend_tree *tree, int order_cap) {
    return (struct loads_layout){(int)pend_jets_stride(tree->n), order_cap + JETS_BEYOND};
}

/* bytes of the decomposition of a tree for the fast kernels */
static size_t jets_cut_bytes(const struct pend_tree *tree) {
    if (pend_chain_suits(tree)) return pend_chain_bytes(tree);
    return tree->n > PEND_JETS_PAD ? pend_blocks_bytes(tree) : 0;
}

size_t pend_jets_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                       int order_cap) {
    assert(order_cap >= PEND_JETS_ORDER_MIN && order_cap <= PEND_JETS_ORDER_MAX);
    int general = jets_general(tree, terms);
    struct loads_layout layout = jets_layout(tree, order_cap);
    size_t cut = general ? pend_bodies_system_bytes(tree, terms, order_cap) : jets_cut_bytes(tree);
    size_t quick = 0;
    // memory for both kernels: only the values decide later which of them is used
    if (general && pend_rods_known(tree, terms))
        quick = pend_rods_bytes(tree) + pend_jets_loads_bytes(tree, terms, order_cap, &layout);
    if (cut < quick) cut = quick;
    if (terms && !general)
        cut += pend_jets_loads_bytes(tree, terms, order_cap, &layout) +
               (jets_loads_bodies(terms) ? pend_bodies_system_bytes(tree, terms, 1) : 0);
    return jets_numbers(order_cap, tree) * sizeof(double) + cut;
}

static struct jets_system jets_view(const struct pend_tree *tree, int general, int order_cap,
                                    double *memory) {
    size_t series = jets_series(order_cap, tree), stride = pend_jets_stride(tree->n);
    double *share = memory + 4 * series, *at = share + JETS_SHARES;
    struct jets_system s = {.n = tree->n,
                            .tiles = (int)(stride / PEND_JETS_PAD),
                            .stride = PEND_JETS_PAD,
                            .tile = PEND_JETS_PAD * (size_t)(order_cap + JETS_BEYOND),
                            .share = share,
                            .parent = tree->parent,
                            .end = tree->end,
                            .rate = memory,
                            .force = memory + series,
                            .turn_re = memory + 2 * series,
                            .turn_im = memory + 3 * series,
#define X(name) .name = at + (size_t)JETS_##name * stride,
                            JETS_FACTOR_ARRAYS(X)
#undef X
    };
    // for up to four arms an order stores rates and forces side by side
    if (s.n <= 4 && !general) s.force = s.rate + s.stride + (s.n <= 2 ? 2 : 4);
    return s;
}

/* lays out the arrays that the general kernel needs besides the series, which all kernels share */
static void jets_bodies_of(struct pend_jets *jets, const struct pend_loads *loads, void *memory) {
    pend_bodies_system(&jets->bodies, jets->tree, loads, jets->order_cap, memory);
    assert(jets->bodies.tile == jets->system.tile);
    jets->bodies.rate = jets->system.rate;
    jets->bodies.force = jets->system.force;
    jets->bodies.turn_re = jets->system.turn_re;
    jets->bodies.turn_im = jets->system.turn_im;
    jets->general = 1;
}

static void jets_cut(struct pend_jets *jets, void *memory) {
    const struct pend_tree *tree = jets->tree;
    if (pend_chain_suits(tree)) {
        pend_chain_init(&jets->chain, tree, memory);
        jets->system.chain = &jets->chain;
    } else if (tree->n > PEND_JETS_PAD) {
        pend_blocks_init(&jets->blocks, tree, memory);
        jets->system.blocks = &jets->blocks;
    }
}

static void jets_rods(struct pend_jets *jets, const struct pend_loads *loads, void *memory) {
    const struct pend_tree *tree = jets->tree;
    struct loads_layout layout = jets_layout(tree, jets->order_cap);
    pend_rods_init(&jets->rods, &jets->chain, tree, loads, memory);
    pend_jets_loads_init(&jets->loads, tree, loads->terms, jets->order_cap, &layout,
                         (char *)memory + pend_rods_bytes(tree));
    jets->system.chain = &jets->chain;
    jets->system.rods = &jets->rods;
    jets->system.loads = &jets->loads;
}

void pend_jets_init(struct pend_jets *jets, const struct pend_tree *tree,
                    const struct pend_loads *loads, int order_cap, void *memory) {
    int rods = loads->terms && pend_rods_suit(tree, loads);
    int general = !rods && jets_general(tree, loads->terms);
    assert((size_t)memory % 64 == 0);
    memset(memory, 0, pend_jets_bytes(tree, loads->terms, order_cap));
    struct jets_system s = jets_view(tree, general, order_cap, memory);
    *jets = (struct pend_jets){.tree = tree,
                               .order_cap = order_cap,
                               .isa = pend_isa_best(),
                               .system = s,
                               .real = loads->terms != NULL};
    jets->rate = s.rate;
    jets->force = s.force;
    jets->share = (double *)memory + 4 * jets_series(order_cap, tree);
    for (int j = 0; j < JETS_SHARES; j++) jets->share[j] = 1.0 / (j + 1);
    for (int k = 0; k < s.n; k++) {
        s.len[k] = tree->len[k];
        s.inv_len[k] = 1 / tree->len[k];
        s.mass[k] = tree->mass[k];
    }
    void *cut = (double *)memory + jets_numbers(order_cap, tree);
    if (general) {
        jets_bodies_of(jets, loads, cut);
        return;
    }
    if (rods) {
        jets_rods(jets, loads, cut);
        return;
    }
    jets_cut(jets, cut);
    if (!loads->terms) return;
    struct loads_layout layout = jets_layout(tree, order_cap);
    char *at = (char *)cut + jets_cut_bytes(tree);
    pend_jets_loads_init(&jets->loads, tree, loads->terms, order_cap, &layout, at);
    jets->system.loads = &jets->loads;
    if (!jets_loads_bodies(loads->terms)) return;
    // the arrays in which the fast kernels factorize bodies
    at += pend_jets_loads_bytes(tree, loads->terms, order_cap, &layout);
    pend_bodies_system(&jets->bodies, tree, loads, 1, at);
    jets->bodies.cosine = jets->system.cosine;
    jets->bodies.sine = jets->system.sine;
    jets->loads.bodies = &jets->bodies;
}

static const struct jets_kernel *jets_kernel(enum pend_isa isa) {
    return PEND_ISA_PICK(pend_kernel_jets, isa);
}

void pend_jets_expand(struct pend_jets *jets, const struct pend_loads *loads, double unit,
                      const struct jets_state *state, int order) {
    assert(jets_valid(jets) && isfinite(loads->gravity));
    assert(order >= PEND_JETS_ORDER_MIN && order <= jets->order_cap);
    assert(jets->real == (loads->terms != NULL));
    if (jets->general) {
        struct bodies_state at = {state->phi, state->phi_low, state->rate, state->time,
                                  state->late};
        jets->bodies.value = loads->value;
        pend_kernel_bodies()->orders(&jets->bodies, &at, loads->gravity, unit, order);
        return;
    }
    jets_kernel(jets->isa)->orders(&jets->system, state, loads, unit, order);
}

void pend_jets_forces(const struct pend_jets *jets, int order) {
    struct jets_loads *loads = jets->system.loads;
    assert(jets_valid(jets) && order <= jets->order_cap);
    if (jets->general) pend_kernel_bodies()->forces(&jets->bodies, order);
    if (!loads || !loads->orders) return;
    jets_kernel(jets->isa)->along(&jets->system, order < loads->orders ? order : loads->orders);
    loads->orders = 0;
}

void pend_jets_power(const struct pend_jets *jets, double unit, int order, int count, double work[],
                     double heat[]) {
    assert(jets_valid(jets) && jets->real && order <= jets->order_cap);
    assert(count == order || (jets->general && count > order && count < 2 * order));
    if (jets->general)
        pend_kernel_bodies()->power(&jets->bodies, unit, order, count, work, heat);
    else
        jets_kernel(jets->isa)->power(&jets->system, order, work, heat);
}

void pend_jets_advance(const struct pend_jets *jets, int order, double x, double unit,
                       const struct jets_state *from, const struct jets_state *to) {
    assert(jets_valid(jets) && order >= 1 && order <= jets->order_cap);
    jets_kernel(jets->isa)->advance(&jets->system, order, x, unit, from, to);
}

void pend_jets_values(const struct pend_jets *jets, int order, const double x[], int count,
                      double unit, const struct jets_state *from,
                      const struct jets_values *values) {
    assert(jets_valid(jets) && count >= 0 && values->phi && values->rate);
    if (values->force) pend_jets_forces(jets, order);
    jets_kernel(jets->isa)->values(&jets->system, order, x, count, unit, from, values);
}

double pend_jets_reach(const struct pend_jets *jets, int order, double log_rtol, double log_atol) {
    assert(jets_valid(jets) && order >= PEND_JETS_ORDER_MIN && order <= jets->order_cap);
    double reach = jets_kernel(jets->isa)->reach(&jets->system, order, log_rtol, log_atol);
    return jets->general ? pend_kernel_bodies()->reach(&jets->bodies, reach) : reach;
}

/* two tables of responses, each with one (rate, force) pair per arm and lane */
size_t pend_jets_answers_bytes(const struct pend_tree *tree, const struct pend_terms *terms) {
    size_t lanes = tree->n <= 2 ? 2 : tree->n <= 4 ? 4 : 8;
    return tree->n > PEND_JETS_PAD || terms ? 0 : 4 * lanes * lanes * sizeof(double);
}

void pend_jets_answers(struct pend_jets *jets, void *memory) {
    assert(jets_valid(jets) && (size_t)memory % 64 == 0);
    assert(jets->system.n <= PEND_JETS_PAD);
    jets->system.answers = memory;
}

int pend_jets_spreads(const struct pend_jets *jets) { return jets->system.answers != NULL; }

double pend_jets_spread(const struct pend_jets *jets, const struct pend_loads *loads,
                        const struct jets_spread *how, double phi[], double rate[]) {
    assert(jets_valid(jets) && pend_jets_spreads(jets));
    assert(how->order >= JETS_SPREAD && how->order <= JETS_SPREAD_MAX);
    return jets_kernel(jets->isa)->spread(&jets->system, loads, how, phi, rate);
}

/* x^order, order >= 0 */
static double jets_power(double x, int order) {
    double power = 1;
    for (; order; order /= 2, x *= x)
        if (order % 2) power *= x;
    return power;
}

void pend_jets_left(const struct pend_jets *jets, int order, int beyond, double x, double rate[],
                    double phi[]) {
    assert(jets_valid(jets) && beyond >= 0 && beyond <= JETS_FITTED - 2);
    assert(order + beyond <= jets->order_cap && order + beyond + 1 >= JETS_FITTED);
    struct jets_left left = {.from = order + beyond + 1 - JETS_FITTED, .beyond = beyond, .x = x};
    left.power = jets_power(x, left.from);
    jets_kernel(jets->isa)->left(&jets->system, &left, rate, phi);
}
