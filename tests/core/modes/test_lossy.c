/* Tests of core/modes/lossy: damped modes without a matrix, against dense ones, and their residuals
 * for many arms.
 * Leaves to others: few arms (test_damped), the equilibrium (test_rest).
 * Invariant: all pendulums are random, from seeds. */
#include "core/modes/lossy.h"

#include <math.h>
#include <stdlib.h>

#include "core/modes/damped.h"
#include "core/modes/rest.h"
#include "tests/harness/bodies.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum {
    LOSES = TEST_TERMS_RODS | TEST_TERMS_SPRINGS | TEST_TERMS_DAMPING | TEST_TERMS_FRICTION |
            TEST_TERMS_DRAG | TEST_TERMS_DRAG_PER_MASS,
    MOST = 320
};

/* all roots with nonnegative imaginary part, and their shapes */
struct found {
    int count;
    double phi[MOST];
    double complex root[2 * MOST], *shape;
};

static void found_of(struct found *f, const struct test_tree *t, const struct pend_loads *loads) {
    size_t n = (size_t)t->n;
    OWN(pend_lossy, free) *lossy = NULL;
    struct pend_error error = {0};
    enum pend_lossy_stage stage = PEND_LOSSY_UNDER_WAY;
    f->count = 0;
    f->shape = malloc(2 * n * n * sizeof *f->shape);
    if (!f->shape) abort();
    for (int k = 0; k < t->n; k++) f->phi[k] = k || !pend_terms_cart(loads->terms) ? -M_PI_2 : 0;
    if (!CHECK(pend_rest_find(t->tree, loads, f->phi, NULL, &error) == PEND_OK)) return;
    if (!CHECK(pend_lossy_new(&lossy, t->tree, loads, f->phi) == PEND_OK)) return;
    while (stage != PEND_LOSSY_DONE) {
        double complex *shape = f->shape + (size_t)f->count * n;
        enum pend_status status = pend_lossy_step(lossy, &stage, &f->root[f->count], shape);
        if (!CHECK_SAYING(status == PEND_OK, "root %d of %d arms", f->count, t->n)) break;
        f->count += stage == PEND_LOSSY_MODE;
    }
}

/* the largest residual of (p^2 M + p C + K) x = 0 over all shapes, relative to the largest term of
 * a row */
static double residual(const struct test_tree *t, const struct pend_loads *loads,
                       const struct found *f) {
    size_t n = (size_t)t->n;
    double *m = malloc(3 * n * n * sizeof *m), *c = m + n * n, *k = c + n * n, worst = 0;
    if (!m) abort();
    if (!(pend_damped_matrices(t->tree, loads, f->phi, m, c, k) == PEND_OK)) abort();
    int stride = n < 50 ? 1 : 23;
    for (int j = 0; j < f->count; j += stride) {
        const double complex *x = f->shape + (size_t)j * n;
        double complex p = f->root[j];
        double missed = 0, size = 0;
        for (size_t a = 0; a < n; a++) {
            double complex row = 0;
            double parts = 0;
            for (size_t b = 0; b < n; b++) {
                double complex at[3] = {p * p * m[a * n + b] * x[b], p * c[a * n + b] * x[b],
                                        k[a * n + b] * x[b]};
                row += at[0] + at[1] + at[2];
                parts += cabs(at[0]) + cabs(at[1]) + cabs(at[2]);
            }
            missed = fmax(missed, cabs(row));
            size = fmax(size, parts);
        }
        worst = fmax(worst, missed / size);
    }
    free(m);
    return worst;
}

/* the largest distance of a dense mode's root from the nearest found root, each used once, relative
 * to the largest root */
static double distance(const struct pend_damped *d, struct found *f) {
    double worst = 0, most = 0;
    for (int j = 0; j < d->count; j++) {
        double complex p = d->decay[j] + I * d->omega[j];
        int best = 0;
        for (int i = 0; i < f->count; i++)
            if (cabs(f->root[i] - p) < cabs(f->root[best] - p)) best = i;
        worst = fmax(worst, cabs(f->root[best] - p));
        most = fmax(most, cabs(p));
        f->root[best] = INFINITY;
    }
    return worst / most;
}

TEST(lossy_finds_the_modes_that_dense_matrices_have) {
    unsigned long long seed = 1;
    double worst = 0, missed = 0;
    for (int i = 0; i < 60; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct found f;
        struct pend_damped *d;
        struct pend_error error = {0};
        test_tree_random(&t, i % TEST_TREE_KINDS, 1 + i % 12, 0.4, &seed);
        test_bodies_random(&b, t.tree, LOSES | (i % 3 || t.n < 2 ? 0 : TEST_TERMS_CART), &seed);
        // strong friction, with which little oscillates
        for (int k = 0; k < t.n && i % 5 == 4; k++)
            b.value[b.terms->row[PEND_TERM_DAMPING] + k] *= 300;
        found_of(&f, &t, &b.loads);
        missed = fmax(missed, residual(&t, &b.loads, &f));
        if (CHECK(pend_damped_new(&d, t.tree, &b.loads, f.phi, &error) == PEND_OK)) {
            CHECK_INT(f.count, d->count);
            worst = fmax(worst, distance(d, &f));
            pend_damped_free(&d);
        }
        free(f.shape);
    }
    CHECK_RESIDUAL(worst, 1e-13, "roots, in parts of the largest");
    CHECK_RESIDUAL(missed, 1e-13, "(p^2 M + p C + K) x = 0");
}

TEST(lossy_finds_all_modes_of_some_hundred_arms) {
    unsigned long long seed = 4;
    for (int i = 0; i < 2; i++) {
        OWN(test_tree, clear) t;
        OWN(test_bodies, clear) b;
        struct found f;
        test_tree_random(&t, i ? TEST_TREE_LIMBS : TEST_TREE_ATTACHED, MOST, 0.3, &seed);
        test_bodies_random(&b, t.tree, LOSES | TEST_TERMS_CART, &seed);
        found_of(&f, &t, &b.loads);
        int all = 0;
        for (int j = 0; j < f.count; j++) all += cimag(f.root[j]) > 0 ? 2 : 1;
        CHECK_INT(all, 2 * t.n);
        CHECK_RESIDUAL(residual(&t, &b.loads, &f), 1e-13, "(p^2 M + p C + K) x = 0");
        free(f.shape);
    }
}

/* equal arms side by side have equal roots: the right number of them, and shapes that are not all
 * the same */
TEST(lossy_finds_as_many_roots_of_like_branches_as_there_are) {
    enum { N = 24 };
    unsigned long long seed = 6;
    OWN(test_tree, clear) t;
    OWN(test_bodies, clear) b;
    struct found f;
    test_tree_random(&t, TEST_TREE_STAR, N, 0, &seed);
    for (int k = 0; k < N; k++) CHECK(t.tree->len[k] > 0);
    test_bodies_random(&b, t.tree, TEST_TERMS_DRAG_PER_MASS, &seed);
    found_of(&f, &t, &b.loads);
    CHECK_INT(f.count, N);
    CHECK_SAYING(residual(&t, &b.loads, &f) < 1e-12, "%g", residual(&t, &b.loads, &f));
    free(f.shape);
}
