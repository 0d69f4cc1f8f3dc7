/* Memory and angles for the power series of one tree.
 * Leaves to others: the series themselves (kernel_jets).
 * Invariant: u = e^{i phi} is formed anew from the summed angles at every expansion. */
#include "core/jets.h"

#include <string.h>

enum {
#define X(name) JETS_##name,
    JETS_FACTOR_ARRAYS(X)
#undef X
        JETS_COUNT,
    JETS_SHARES = 48,
    /* Rows from one series of a small tree to the next, at least PEND_JETS_ORDER_MAX + 2. A load waits for an earlier
     * store whose address differs by a multiple of 64 rows; these are 16 rows from that. */
    JETS_APART = 48
};

size_t pend_jets_stride(int n) { return ((size_t)n + PEND_JETS_PAD - 1) / PEND_JETS_PAD * PEND_JETS_PAD; }

static size_t jets_series(int order_cap, int n) {
    return n > PEND_JETS_PAD ? (size_t)(order_cap + 2) * pend_jets_stride(n) : JETS_APART * PEND_JETS_PAD;
}

/* numbers of the series and of the factorization */
static size_t jets_numbers(int order_cap, int n) {
    return 4 * jets_series(order_cap, n) + JETS_COUNT * pend_jets_stride(n) + JETS_SHARES;
}

size_t pend_jets_bytes(const struct pend_tree *tree, int order_cap) {
    size_t large = 0;
    if (pend_strand_suits(tree))
        large = pend_strand_bytes(tree);
    else if (tree->n > PEND_JETS_PAD)
        large = pend_blocks_bytes(tree);
    return jets_numbers(order_cap, tree->n) * sizeof(double) + large;
}

static struct jets_system jets_view(const struct pend_tree *tree, int order_cap, double *memory) {
    size_t series = jets_series(order_cap, tree->n), stride = pend_jets_stride(tree->n);
    double *share = memory + 4 * series, *at = share + JETS_SHARES;
    struct jets_system s = {.n = tree->n,
                            .stride = PEND_JETS_PAD,
                            .tile = PEND_JETS_PAD * (size_t)(order_cap + 2),
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
    // the orders of up to four arms have rates and forces side by side
    if (s.n <= 4) s.force = s.rate + s.stride + (s.n <= 2 ? 2 : 4);
    return s;
}

void pend_jets_init(struct pend_jets *jets, const struct pend_tree *tree, int order_cap, void *memory) {
    memset(memory, 0, pend_jets_bytes(tree, order_cap));
    struct jets_system s = jets_view(tree, order_cap, memory);
    *jets = (struct pend_jets){.tree = tree, .order_cap = order_cap, .isa = pend_isa_best(), .system = s};
    jets->rate = s.rate;
    jets->force = s.force;
    jets->share = (double *)memory + 4 * jets_series(order_cap, tree->n);
    for (int j = 0; j < JETS_SHARES; j++) jets->share[j] = 1.0 / (j + 1);
    for (int k = 0; k < s.n; k++) {
        s.len[k] = tree->len[k];
        s.inv_len[k] = 1 / tree->len[k];
        s.mass[k] = tree->mass[k];
    }
    void *large = (double *)memory + jets_numbers(order_cap, s.n);
    if (pend_strand_suits(tree)) {
        pend_strand_init(&jets->strand, tree, large);
        jets->system.strand = &jets->strand;
    } else if (tree->n > PEND_JETS_PAD) {
        pend_blocks_init(&jets->blocks, tree, large);
        jets->system.blocks = &jets->blocks;
    }
}

static const struct jets_kernel *jets_kernel(enum pend_isa isa) {
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_kernel_jets_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_kernel_jets_avx2;
#endif
    (void)isa;
    return &pend_kernel_jets_base;
}

void pend_jets_expand(struct pend_jets *jets, double gravity, double unit, const struct jets_state *state, int order) {
    jets_kernel(jets->isa)->orders(&jets->system, state, gravity, unit, order);
}

void pend_jets_advance(const struct pend_jets *jets, int order, double x, double unit, const struct jets_state *from,
                       const struct jets_state *to) {
    jets_kernel(jets->isa)->advance(&jets->system, order, x, unit, from, to);
}

void pend_jets_values(const struct pend_jets *jets, int order, const double x[], int count, double unit,
                      const struct jets_state *from, const struct jets_values *values) {
    jets_kernel(jets->isa)->values(&jets->system, order, x, count, unit, from, values);
}

double pend_jets_reach(const struct pend_jets *jets, int order, double log_rtol, double log_atol) {
    return jets_kernel(jets->isa)->reach(&jets->system, order, log_rtol, log_atol);
}
