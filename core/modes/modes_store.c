#include "core/modes/modes_store.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "core/modes/hugepage.h"
#include "core/tree/turns.h"

struct store_block {
    struct pend_modes modes; /* the first member, so that its address is the block's */
    double data[];
};

enum pend_status pend_modes_alloc(struct pend_modes **modes, int count, int n, int vectors) {
    assert(count >= 0 && n >= 1);
    *modes = NULL;
    size_t doubles = (size_t)count;
    if (vectors) {
        if ((size_t)n > (SIZE_MAX / sizeof(double) - 16) / ((size_t)count + 1))
            return PEND_NO_MEMORY;
        doubles = (size_t)count * ((size_t)n + 2);
    }
    struct store_block *block = pend_hugepage(sizeof *block + doubles * sizeof(double));
    if (!block) return PEND_NO_MEMORY;
    block->modes = (struct pend_modes){.count = count, .n = n, .omega = block->data};
    if (vectors) {
        block->modes.norm = block->data + count;
        block->modes.vector = block->modes.norm + count;
    }
    *modes = &block->modes;
    return PEND_OK;
}

PEND_VALIDATOR modes_valid(const struct pend_modes *modes) {
    int growing = 0;
    if (modes->count < 0 || modes->n < 1 || modes->first < 0 || !modes->vector != !modes->norm)
        return 0;
    for (int k = 0; k < modes->count; k++) {
        if (k && modes->omega[k] < modes->omega[k - 1]) return 0;
        growing += modes->omega[k] < 0;
    }
    return growing == modes->growing;
}

void pend_modes_trim(struct pend_modes *modes, int from, int end) {
    assert(0 <= from && from <= end && end <= modes->count);
    modes->count = end - from;
    modes->omega += from;
    if (modes->vector) {
        modes->vector += (size_t)from * (size_t)modes->n;
        modes->norm += from;
    }
    for (int k = 0; k < modes->count; k++) modes->growing += modes->omega[k] < 0;
    assert(modes_valid(modes));
}

void pend_modes_free(struct pend_modes **modes) {
    free(*modes);
    *modes = NULL;
}

static double store_length(const struct pend_tree *tree, const unsigned char up[], int k) {
    return up && up[k] ? -tree->len[k] : tree->len[k];
}

/* Computes Re x without a matrix: masses times tip displacements, added up over the sub-trees.
 * `product` and `x` must be different arrays. */
static void modes_mass_apply(const struct pend_tree *tree, const unsigned char up[],
                             const double x[], double product[]) {
    /* tip displacements, from the pivot outwards */
    for (int k = 0; k < tree->n; k++)
        product[k] = (k ? product[tree->parent[k]] : 0) + store_length(tree, up, k) * x[k];
    for (int k = 0; k < tree->n; k++) product[k] *= tree->mass[k];
    /* sums over the sub-trees, from the leaves inwards */
    for (int k = tree->n - 1; k > 0; k--) product[tree->parent[k]] += product[k];
    for (int k = 0; k < tree->n; k++) product[k] *= store_length(tree, up, k);
}

static double store_largest(int n, const double x[]) {
    double largest[8] = {0};
    int k = 0;
    for (; k + 8 <= n; k += 8)
        for (int i = 0; i < 8; i++)
            largest[i] = fabs(x[k + i]) > largest[i] ? fabs(x[k + i]) : largest[i];
    for (; k < n; k++) largest[0] = fmax(largest[0], fabs(x[k]));
    for (int i = 1; i < 8; i++) largest[0] = fmax(largest[0], largest[i]);
    return largest[0];
}

/* the first arm with a non-zero entry, by the caller's numbers from `from` on; n: none */
static int store_first(const struct pend_tree *tree, const double x[], double zero, int from) {
    while (from < tree->n && fabs(x[tree->place[from]]) <= zero) from++;
    return from;
}

/* rotates the vectors x and y in their plane so that y becomes 0 at one entry */
static void store_rotate(int n, double x[], double y[], int entry) {
    assert(y[entry] != 0);
    double h = hypot(x[entry], y[entry]), c = x[entry] / h, s = y[entry] / h;
    for (int k = 0; k < n; k++) {
        double a = x[k], b = y[k];
        x[k] = c * a + s * b;
        y[k] = c * b - s * a;
    }
    y[entry] = 0;
}

/* brings `group` orthogonal vectors into echelon form in the caller's order; they stay
 * orthogonal */
static void store_echelon(const struct pend_tree *tree, int group, double vector[]) {
    int n = tree->n, lead = 0;
    for (int done = 0; done < group - 1; done++, lead++) {
        /* the first arm that moves in any remaining vector; the vector that moves it most */
        int first = n, best = done;
        for (int j = done; j < group; j++) {
            double *x = vector + (size_t)j * n;
            int f = store_first(tree, x, PEND_MODES_ZERO * store_largest(n, x), lead);
            if (f > first || f == n) continue;
            int entry = tree->place[f];
            if (f < first || fabs(x[entry]) > fabs(vector[(size_t)best * n + entry])) best = j;
            first = f;
        }
        if (first == n) return;
        lead = first;
        int entry = tree->place[lead];
        double *head = vector + (size_t)done * n, *most = vector + (size_t)best * n;
        for (int k = 0; best != done && k < n; k++) {
            double swap = head[k];
            head[k] = most[k];
            most[k] = swap;
        }
        for (int j = done + 1; j < group; j++)
            if (vector[(size_t)j * n + entry] != 0)
                store_rotate(n, head, vector + (size_t)j * n, entry);
    }
}

/* the divisor that normalizes a vector; NaN if all its entries are zero or infinite */
static double store_divisor(const struct pend_tree *tree, const double x[], double norm,
                            enum pend_normalize rule, int lead) {
    double largest = lead < 0 || rule == PEND_NORMALIZE_MAX ? store_largest(tree->n, x) : 0;
    if (rule == PEND_NORMALIZE_MAX) {
        lead = store_first(tree, x, (1 - PEND_MODES_ZERO) * largest, 0);
        return lead < tree->n ? x[tree->place[lead]] : NAN;
    }
    if (lead < 0) lead = store_first(tree, x, PEND_MODES_ZERO * largest, 0);
    if (lead == tree->n) return NAN;
    return rule == PEND_NORMALIZE_FIRST ? x[tree->place[lead]]
                                        : copysign(norm, x[tree->place[lead]]);
}

int pend_modes_basis(struct pend_modes *modes, const struct pend_tree *tree, double multiple,
                     int mode, int lead[]) {
    assert(mode >= 0 && mode < modes->count && modes->vector && tree->n == modes->n);
    double limit = modes->omega[mode] + multiple * fabs(modes->omega[mode]);
    int end = mode + 1, ordered = 1;
    while (end < modes->count && modes->omega[end] <= limit) end++;
    if (end == mode + 1) return end;
    for (int j = mode; j < end; j++) {
        const double *x = modes->vector + (size_t)j * modes->n;
        if (lead[j] < 0)
            lead[j] = store_first(tree, x, PEND_MODES_ZERO * store_largest(tree->n, x), 0);
        if (lead[j] == tree->n) lead[j] = -1;
        ordered &= j == mode || lead[j] > lead[j - 1];
    }
    if (ordered) return end;
    for (int j = mode; j < end; j++) lead[j] = -1;
    store_echelon(tree, end - mode, modes->vector + (size_t)mode * modes->n);
    return end;
}

void pend_modes_scale(struct pend_modes *modes, const struct pend_tree *tree, int mode,
                      enum pend_normalize rule, int lead) {
    assert(mode >= 0 && mode < modes->count && modes->vector);
    assert(lead >= -1 && lead < tree->n && tree->n == modes->n);
    double *x = modes->vector + (size_t)mode * modes->n;
    double divisor = store_divisor(tree, x, modes->norm[mode], rule, lead);
    for (int arm = 0; divisor != 1 && arm < modes->n; arm++) x[arm] /= divisor;
    modes->norm[mode] = rule == PEND_NORMALIZE_MASS ? 1 : modes->norm[mode] / fabs(divisor);
}

double pend_modes_theta(double phi, double low) {
    struct pend_sum rest = pend_turns_rest(phi, low, NULL);
    if (low != 0 && fabs(rest.high) <= 2) return pend_turns_theta(rest.high, rest.low);
    return remainder(rest.high + M_PI_2, 4 * M_PI_2);
}

enum pend_status pend_modes_decompose(const struct pend_modes *modes, const struct pend_tree *tree,
                                      const unsigned char up[], const double theta[],
                                      const double rate[], double first[], double second[]) {
    assert(modes_valid(modes) && modes->vector && tree->n == modes->n);
    int n = modes->n;
    double *product = malloc(2 * (size_t)n * sizeof *product);
    if (!product) return PEND_NO_MEMORY;
    modes_mass_apply(tree, up, theta, product);
    modes_mass_apply(tree, up, rate, product + n);
    for (int k = 0; k < modes->count; k++) {
        const double *x = modes->vector + (size_t)k * n;
        double along_theta = 0, along_rate = 0, square = modes->norm[k] * modes->norm[k];
        for (int arm = 0; arm < n; arm++) {
            along_theta += x[arm] * product[arm];
            along_rate += x[arm] * product[n + arm];
        }
        /* sets amplitude cos(phase) and amplitude sin(phase); + 0.0 turns -0 into 0 */
        double c = along_theta / square + 0.0, s = -along_rate / (square * modes->omega[k]) + 0.0;
        if (modes->omega[k] < 0) {
            first[k] = 0.5 * (c + s);
            second[k] = 0.5 * (c - s);
            continue;
        }
        first[k] = hypot(c, s);
        second[k] = atan2(s, c);
        if (second[k] <= -M_PI) second[k] = M_PI;
        assert(!(first[k] < 0) && !(fabs(second[k]) > M_PI));
    }
    free(product);
    return PEND_OK;
}

void pend_modes_slope(const struct pend_modes *modes, const struct pend_tree *tree,
                      const struct pend_loads *loads, int mode, double slope[]) {
    size_t n = (size_t)tree->n;
    const double *v = modes->vector + (size_t)mode * n;
    double omega = modes->omega[mode], size = 0;
    double *x = slope, *work = slope + n; // displacement of each tip; sum g l v^2 of its path
    assert(modes->n == tree->n && mode < modes->count && omega > 0);
    for (size_t k = 0; k < n; k++) {
        int p = tree->parent[k];
        x[k] = (p < 0 ? 0 : x[p]) + tree->len[k] * v[k];
        work[k] = (p < 0 ? 0 : work[p]) + loads->gravity * tree->len[k] * v[k] * v[k];
        size += 2 * omega * tree->mass[k] * x[k] * x[k];
    }
    for (size_t k = 0; k < n; k++) {
        work[k] = (work[k] - omega * omega * x[k] * x[k]) / size;
        x[k] = -loads->gravity * tree->subtree_mass[k] * v[k] * v[k] / size;
    }
    slope[2 * n] = omega / (2 * loads->gravity);
}
