/* Memory and angles for the power series of one tree, with plain doubles as the kernel's numbers.
 * Leaves to others: the series themselves (jets_kernel).
 * Invariant: u = e^{i phi} is formed anew from the summed angles at every expansion. */
#include "core/jets.h"

#include <math.h>
#include <string.h>

#define WIDE 1
typedef double wide;
static double num_of(double x) { return x; }
static double num_neg(double x) { return -x; }
static double num_add(double x, double y) { return x + y; }
static double num_sub(double x, double y) { return x - y; }
static double num_mul(double x, double y) { return x * y; }
static double num_div(double x, double y) { return x / y; }
static double num_fma(double x, double y, double z) { return x * y + z; }
static double wide_get(const double *x) { return *x; }
static void wide_put(double *x, double y) { *x = y; }
#define wide_of num_of
#define wide_neg num_neg
#define wide_add num_add
#define wide_sub num_sub
#define wide_mul num_mul
#define wide_fma num_fma
#include "core/jets_kernel.h"

enum {
#define X(name) JETS_##name,
    JETS_ARRAYS(X)
#undef X
        JETS_COUNT
};

static size_t jets_stride(int n) { return ((size_t)n + PEND_JETS_PAD - 1) / PEND_JETS_PAD * PEND_JETS_PAD; }

static size_t jets_series(int order_cap, int n) { return (size_t)(order_cap + 2) * jets_stride(n); }

size_t pend_jets_bytes(int n, int order_cap) {
    return (4 * jets_series(order_cap, n) + JETS_COUNT * jets_stride(n)) * sizeof(double);
}

static struct jets_system jets_view(const struct pend_jets *jets) {
    double *at = jets->system;
    struct jets_system s = {.n = jets->tree->n,
                            .stride = jets->stride,
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
    *jets = (struct pend_jets){.tree = tree, .order_cap = order_cap};
    jets->stride = jets_stride(tree->n);
    jets->rate = block;
    jets->force = jets->rate + series;
    jets->turn_re = jets->force + series;
    jets->turn_im = jets->turn_re + series;
    jets->system = jets->turn_im + series;
    memset(block, 0, pend_jets_bytes(tree->n, order_cap));
    struct jets_system s = jets_view(jets);
    for (int k = 0; k < s.n; k++) {
        s.len[k] = tree->len[k];
        s.inv_len[k] = 1 / tree->len[k];
        s.mass[k] = tree->mass[k];
    }
}

/* the angle of an arm to its parent, as the difference of two sums of two */
static double jets_angle(const double phi[], const double low[], int k, int p) {
    double x = phi[k], y = p < 0 ? 0 : phi[p];
    double d = x - y, back = x - d;
    double error = (x - (d + back)) + (back - y);
    return d + (error + (low[k] - (p < 0 ? 0 : low[p])));
}

void pend_jets_expand(struct pend_jets *jets, double gravity, double unit, const double phi[], const double phi_low[],
                      const double rate[], int order) {
    struct jets_system s = jets_view(jets);
    for (int k = 0; k < s.n; k++) {
        double angle = jets_angle(phi, phi_low, k, s.parent[k]);
        s.cosine[k] = cos(angle);
        s.sine[k] = sin(angle);
        s.rate[k] = rate[k] * unit;
    }
    jets_orders(&s, gravity * unit * unit, order);
}
