/* Memory and angles for the power series of one tree.
 * Leaves to others: the series themselves (kernel_jets).
 * Invariant: u = e^{i phi} is formed anew from the summed angles at every expansion. */
#include "core/jets.h"

#include <string.h>

enum {
#define X(name) JETS_##name,
    JETS_ARRAYS(X)
#undef X
        JETS_COUNT,
    JETS_SHARES = 48
};

static size_t jets_stride(int n) { return ((size_t)n + PEND_JETS_PAD - 1) / PEND_JETS_PAD * PEND_JETS_PAD; }

static size_t jets_series(int order_cap, int n) { return (size_t)(order_cap + 2) * jets_stride(n); }

size_t pend_jets_bytes(int n, int order_cap) {
    return (4 * jets_series(order_cap, n) + JETS_COUNT * jets_stride(n) + JETS_SHARES) * sizeof(double);
}

static struct jets_system jets_view(const struct pend_jets *jets) {
    double *at = jets->system;
    struct jets_system s = {.n = jets->tree->n,
                            .stride = PEND_JETS_PAD,
                            .tile = PEND_JETS_PAD * (size_t)(jets->order_cap + 2),
                            .share = jets->share,
                            .parent = jets->tree->parent,
                            .end = jets->tree->end,
                            .rate = jets->rate,
                            .force = jets->force,
                            .turn_re = jets->turn_re,
                            .turn_im = jets->turn_im,
#define X(name) .name = at + (size_t)JETS_##name * jets->stride,
                            JETS_ARRAYS(X)
#undef X
    };
    return s;
}

void pend_jets_init(struct pend_jets *jets, const struct pend_tree *tree, int order_cap, void *block) {
    size_t series = jets_series(order_cap, tree->n);
    *jets = (struct pend_jets){.tree = tree, .order_cap = order_cap, .isa = pend_isa_best()};
    jets->stride = jets_stride(tree->n);
    jets->rate = block;
    jets->force = jets->rate + series;
    jets->turn_re = jets->force + series;
    jets->turn_im = jets->turn_re + series;
    jets->share = jets->turn_im + series;
    jets->system = jets->share + JETS_SHARES;
    memset(block, 0, pend_jets_bytes(tree->n, order_cap));
    for (int j = 0; j < JETS_SHARES; j++) jets->share[j] = 1.0 / (j + 1);
    struct jets_system s = jets_view(jets);
    for (int k = 0; k < s.n; k++) {
        s.len[k] = tree->len[k];
        s.inv_len[k] = 1 / tree->len[k];
        s.mass[k] = tree->mass[k];
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
    struct jets_system s = jets_view(jets);
    jets_kernel(jets->isa)->orders(&s, state, gravity, unit, order);
}

void pend_jets_advance(const struct pend_jets *jets, int order, double x, double unit, const struct jets_state *from,
                       const struct jets_state *to) {
    struct jets_system s = jets_view(jets);
    jets_kernel(jets->isa)->advance(&s, order, x, unit, from, to);
}

void pend_jets_values(const struct pend_jets *jets, int order, double x, double unit, const struct jets_state *from,
                      const struct jets_values *values) {
    struct jets_system s = jets_view(jets);
    jets_kernel(jets->isa)->values(&s, order, x, unit, from, values);
}
