#include "tests/harness/quad.h"

#include <stdlib.h>
#include <string.h>

#include "tests/harness/own.h"

// not <math.h>: clang 14 hides its quad functions, although glibc has them
#if defined(__x86_64__) || defined(__i386__)
test_quad sinf128(test_quad x);
test_quad cosf128(test_quad x);
test_quad sqrtf128(test_quad x);
test_quad tanhf128(test_quad x);
test_quad test_quad_sin(test_quad x) { return sinf128(x); }
test_quad test_quad_cos(test_quad x) { return cosf128(x); }
test_quad test_quad_sqrt(test_quad x) { return sqrtf128(x); }
test_quad test_quad_tanh(test_quad x) { return tanhf128(x); }
#else
long double sinl(long double x);
long double cosl(long double x);
long double sqrtl(long double x);
long double tanhl(long double x);
test_quad test_quad_sin(test_quad x) { return sinl(x); }
test_quad test_quad_cos(test_quad x) { return cosl(x); }
test_quad test_quad_sqrt(test_quad x) { return sqrtl(x); }
test_quad test_quad_tanh(test_quad x) { return tanhl(x); }
#endif

test_quad test_quad_abs(test_quad x) { return x < 0 ? -x : x; }

test_quad test_quad_read(const char *text) {
    test_quad x = 0, unit = 1;
    int negative = *text == '-', point = 0;
    for (text += negative; (*text >= '0' && *text <= '9') || *text == '.'; text++) {
        if (*text == '.') {
            point = 1;
            continue;
        }
        // digits and powers of ten below 10^33 are exact
        x = 10 * x + (*text - '0');
        if (point) unit *= 10;
    }
    int exponent = *text == 'e' ? atoi(text + 1) : 0;
    for (; exponent > 0; exponent--) x *= 10;
    for (; exponent < 0; exponent++) unit *= 10;
    x /= unit;
    return negative ? -x : x;
}

/* S^T diag(m) S: every arm k adds its mass if both arms are on the path to tip k */
static void quad_gram(const struct pend_tree *tree, test_quad gram[]) {
    size_t n = (size_t)tree->n;
    memset(gram, 0, n * n * sizeof *gram);
    for (int k = 0; k < tree->n; k++)
        for (int i = k; i >= 0; i = tree->parent[i])
            for (int j = k; j >= 0; j = tree->parent[j])
                gram[(size_t)i * n + (size_t)j] += tree->mass[k];
}

/* turns S^T diag(m) S into Re M (the lower triangle with its diagonal) and Im M (below and
 * above, by sign) */
static void quad_inertia(const struct pend_tree *tree, const double phi[], const test_quad gram[],
                         test_quad re[], test_quad im[], test_quad unit[]) {
    int n = tree->n;
    test_quad *c = unit, *s = unit + n;
    for (int i = 0; i < n; i++) c[i] = test_quad_cos(phi[i]), s[i] = test_quad_sin(phi[i]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            size_t at = (size_t)i * (size_t)n + (size_t)j;
            test_quad inertia = gram[at] * tree->len[i] * tree->len[j];
            // e^{i (phi_j - phi_i)}
            re[at] = inertia * (c[i] * c[j] + s[i] * s[j]);
            im[at] = inertia * (c[i] * s[j] - s[i] * c[j]);
        }
}

static void quad_factor(size_t w, test_quad a[]) {
    for (size_t j = 0; j < w; j++) {
        for (size_t k = 0; k < j; k++) a[j * w + j] -= a[j * w + k] * a[j * w + k];
        a[j * w + j] = test_quad_sqrt(a[j * w + j]);
        for (size_t i = j + 1; i < w; i++) {
            for (size_t k = 0; k < j; k++) a[i * w + j] -= a[i * w + k] * a[j * w + k];
            a[i * w + j] /= a[j * w + j];
        }
    }
}

static void quad_substitute(size_t w, const test_quad a[], test_quad b[]) {
    for (size_t i = 0; i < w; i++) {
        for (size_t k = 0; k < i; k++) b[i] -= a[i * w + k] * b[k];
        b[i] /= a[i * w + i];
    }
    for (size_t i = w; i-- > 0;) {
        for (size_t k = i + 1; k < w; k++) b[i] -= a[k * w + i] * b[k];
        b[i] /= a[i * w + i];
    }
}

void test_quad_solve(int n, test_quad a[], test_quad b[]) {
    quad_factor((size_t)n, a);
    quad_substitute((size_t)n, a, b);
}

/* S^T diag(m) S, Re M and Im M, one after another; the caller frees them */
static test_quad *quad_matrices(const struct pend_tree *tree, const double phi[]) {
    size_t n = (size_t)tree->n;
    test_quad *gram = malloc((3 * n * n + 2 * n) * sizeof *gram);
    if (!gram) abort();
    quad_gram(tree, gram);
    quad_inertia(tree, phi, gram, gram + n * n, gram + 2 * n * n, gram + 3 * n * n);
    return gram;
}

void test_quad_inertia(const struct pend_tree *tree, const double phi[], double re[], double im[]) {
    size_t square = (size_t)tree->n * (size_t)tree->n;
    OWN_MEMORY test_quad *m = quad_matrices(tree, phi);
    for (size_t i = 0; i < square; i++) {
        re[i] = (double)m[square + i];
        im[i] = (double)m[2 * square + i];
    }
}

void test_quad_linearization(const struct pend_tree *tree, double gravity, double a[],
                             double a_inverse[]) {
    size_t n = (size_t)tree->n;
    double *hanging = calloc(n, sizeof *hanging);
    OWN_MEMORY test_quad *column = malloc(n * sizeof *column);
    if (!hanging || !column) abort();
    test_quad *gram = quad_matrices(tree, hanging), *re = gram + n * n;
    for (size_t i = 0; a_inverse && i < n * n; i++)
        a_inverse[i] = (double)(re[i] / (gravity * tree->len[i / n] * gram[i / n * (n + 1)]));
    quad_factor(n, re);
    for (size_t j = 0; a && j < n; j++) {
        for (size_t i = 0; i < n; i++) column[i] = 0;
        column[j] = gravity * tree->len[j] * gram[j * (n + 1)];
        quad_substitute(n, re, column);
        for (size_t i = 0; i < n; i++) a[i * n + j] = (double)column[i];
    }
    free(gram);
    free(hanging);
}

void test_quad_dynamics(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], const double rate[], test_quad acc[],
                        test_quad force[]) {
    size_t n = (size_t)tree->n;
    test_quad *gram = malloc((4 * n * n + 2 * n) * sizeof *gram);
    if (!gram) abort();
    test_quad *re = gram + n * n, *im = re + n * n, *factor = im + n * n, *unit = factor + n * n;
    quad_gram(tree, gram);
    quad_inertia(tree, phi, gram, re, im, unit);

    // (aaa): Re phi'' = Im phi'^2 - g cos(phi) l (S^T m); the diagonal of S^T diag(m) S is S^T m
    for (size_t i = 0; i < n; i++) {
        acc[i] = -(test_quad)loads->gravity * unit[i] * tree->len[i] * gram[i * n + i];
        for (size_t j = 0; j < n; j++) acc[i] += im[i * n + j] * rate[j] * rate[j];
    }
    memcpy(factor, re, n * n * sizeof *factor);
    test_quad_solve(tree->n, factor, acc);

    // (bbb): lambda = g sin(phi) (S^T m) - l^-1 (Im phi'' + Re phi'^2)
    for (size_t i = 0; i < n; i++) {
        test_quad sum = 0;
        for (size_t j = 0; j < n; j++)
            sum += im[i * n + j] * acc[j] + re[i * n + j] * rate[j] * rate[j];
        force[i] = (test_quad)loads->gravity * unit[n + i] * gram[i * n + i] - sum / tree->len[i];
    }
    free(gram);
}

double test_quad_gap(int n, const double x[], const test_quad exact[]) {
    test_quad most = 0, gap = 0;
    for (int i = 0; i < n; i++) {
        test_quad here = test_quad_abs(x[i] - exact[i]), size = test_quad_abs(exact[i]);
        if (here != here) return (double)here;
        if (here > gap) gap = here;
        if (size > most) most = size;
    }
    return gap > 0 ? (double)(gap / most) : 0;
}
