#include "core/modes/modes_vectors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/modes.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

#define GRAVITY 9.81

/* the accuracy of all modes of a tree */
struct quality {
    double orthogonality; /* largest |V^T Re(0) V - I| */
    double residual;      /* largest |M^-1/2 (L - omega^2 M) x| over the norm of M^-1/2 L M^-1/2 */
    double terms;         /* the larger of both, relative to the size of their terms */
    double trace, diagonal;
};

/* tip displacements of a vector of angles, and of its absolute values */
static void tips_of(const struct pend_tree *tree, const double theta[], double x[], double size[]) {
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k];
        x[k] = (p < 0 ? 0 : x[p]) + tree->len[k] * theta[k];
        size[k] = (p < 0 ? 0 : size[p]) + tree->len[k] * fabs(theta[k]);
    }
}

/* residual of one mode; norm: of the matrix */
static void measure_residual(struct quality *q, const struct pend_tree *tree, double omega,
                             const double theta[], const double x[], const double size[],
                             double norm, double force[], double terms[]) {
    double squares = 0, worst = 0, scale = 0;
    for (int k = 0; k < tree->n; k++) {
        force[k] = -omega * omega * tree->mass[k] * x[k];
        terms[k] = omega * omega * tree->mass[k] * size[k];
    }
    for (int k = 0; k < tree->n; k++) {
        double pull = GRAVITY * tree->subtree_mass[k] * theta[k];
        force[k] += pull;
        terms[k] += fabs(pull);
        if (tree->parent[k] < 0) continue;
        force[tree->parent[k]] -= pull;
        terms[tree->parent[k]] += fabs(pull);
    }
    for (int k = 0; k < tree->n; k++) {
        squares += force[k] * force[k] / tree->mass[k];
        worst = fmax(worst, fabs(force[k]));
        scale = fmax(scale, terms[k]);
    }
    q->residual = fmax(q->residual, sqrt(squares) / norm);
    q->terms = fmax(q->terms, worst / scale);
}

static struct quality measure(const struct pend_modes *modes, const struct pend_tree *tree) {
    int n = tree->n;
    size_t square = (size_t)n * (size_t)n;
    double *x = malloc((2 * square + 3 * (size_t)n) * sizeof *x), *size = x + square,
           *force = size + square;
    double *terms = force + n, *diagonal = terms + n, norm = 0, trace = 0;
    struct quality q = {0, 0, 0, 0, 0};
    memset(diagonal, 0, (size_t)n * sizeof *diagonal);
    /* the largest eigenvalue is the norm */
    norm = modes->omega[n - 1] * modes->omega[n - 1];
    for (int i = 0; i < n; i++) {
        const double *theta = modes->vector + (size_t)i * n;
        double *xi = x + (size_t)i * n, *si = size + (size_t)i * n,
               square_i = modes->omega[i] * modes->omega[i];
        tips_of(tree, theta, xi, si);
        measure_residual(&q, tree, modes->omega[i], theta, xi, si, norm, force, terms);
        trace += GRAVITY / square_i;
        for (int k = 0; k < n; k++)
            diagonal[k] += theta[k] / square_i * (theta[k] / square_i) * GRAVITY * tree->len[k] *
                           tree->subtree_mass[k];
        for (int k = 0; k < n; k++)
            force[k] = tree->mass[k] * xi[k], terms[k] = tree->mass[k] * si[k];
        for (int j = 0; j <= i; j++) {
            double dot[4] = {0}, sum = 0, total;
            const double *xj = x + (size_t)j * n, *sj = size + (size_t)j * n;
            int k = 0;
            for (; k + 4 <= n; k += 4)
                for (int lane = 0; lane < 4; lane++) dot[lane] += force[k + lane] * xj[k + lane];
            for (; k < n; k++) dot[0] += force[k] * xj[k];
            total = fabs((dot[0] + dot[1]) + (dot[2] + dot[3]) - (i == j));
            q.orthogonality = fmax(q.orthogonality, total);
            if (total < 1e-12) continue;
            for (k = 0; k < n; k++) sum += terms[k] * sj[k];
            q.terms = fmax(q.terms, total / sum);
        }
    }
    q.trace = fabs(trace / tree->length_total - 1);
    for (int k = 0; k < n; k++)
        q.diagonal = fmax(q.diagonal, fabs(diagonal[k] * GRAVITY / tree->len[k] - 1));
    free(x);
    return q;
}

static void worse(struct quality *worst, struct quality q) {
    worst->orthogonality = fmax(worst->orthogonality, q.orthogonality);
    worst->residual = fmax(worst->residual, q.residual);
    worst->terms = fmax(worst->terms, q.terms);
    worst->trace = fmax(worst->trace, q.trace);
    worst->diagonal = fmax(worst->diagonal, q.diagonal);
}

/* all modes of a tree of a kind; alike: unit arms, whose masses differ by at most `off`, and if it
 * is 2 their lengths too */
static struct quality quality_of(enum test_tree_kind kind, int n, double spread, int alike,
                                 double off) {
    unsigned long long seed = 5;
    OWN(test_tree, clear) t;
    OWN(pend_modes, free) *modes = NULL;
    struct quality q = {NAN, NAN, NAN, NAN, NAN};
    test_tree_random(&t, kind, n, spread, &seed);
    for (int i = 0; alike && i < n; i++) {
        t.mass[i] = 1 + off * (2 * test_random(&seed) - 1);
        t.length[i] = alike == 2 ? 1 + off * (2 * test_random(&seed) - 1) : 1;
    }
    if (alike) test_tree_rebuild(&t);
    struct pend_error error = {.text = ""};
    int found =
        CHECK_SAYING(pend_modes_new(&modes, t.tree, TEST_LOADS(GRAVITY), 1, &error) == PEND_OK,
                     "%s", error.text);
    if (found) q = measure(modes, t.tree);
    return q;
}

static void check_quality(struct quality q, double orthogonality, double residual,
                          const char *what) {
    char text[100];
    snprintf(text, sizeof text, "%s: V^T Re(0) V = I", what);
    CHECK_RESIDUAL(q.orthogonality, orthogonality, text);
    snprintf(text, sizeof text, "%s: residual over norm", what);
    CHECK_RESIDUAL(q.residual, residual, text);
    snprintf(text, sizeof text, "%s: trace identity", what);
    CHECK_SAYING(q.trace <= 1e-13, "%s %.2e", text, q.trace);
    snprintf(text, sizeof text, "%s: diagonal identity", what);
    CHECK_SAYING(q.diagonal <= 1e-10, "%s %.2e", text, q.diagonal);
}

TEST(modes_vectors_of_seven_kinds_of_600_arms) {
    struct quality worst = {0, 0, 0, 0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        worse(&worst, quality_of((enum test_tree_kind)kind, 600, 0.3, 0, 0));
    check_quality(worst, 1e-12, 1e-13, "random lengths and masses");
}

TEST(modes_vectors_of_equal_arms) {
    struct quality worst = {0, 0, 0, 0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        worse(&worst, quality_of((enum test_tree_kind)kind, 600, 0.3, 1, 0));
    check_quality(worst, 1e-12, 1e-13, "equal arms");
}

TEST(modes_vectors_of_nearly_equal_arms) {
    for (double off = 1e-14; off < 1e-3; off *= 1e4) {
        char text[60];
        snprintf(text, sizeof text, "binary tree, masses off by %.0e", off);
        check_quality(quality_of(TEST_TREE_BINARY, 511, 0.3, 1, off), 1e-12, 1e-13, text);
    }
    check_quality(quality_of(TEST_TREE_BINARY, 511, 0.3, 1, 1e-6), 1e-12, 1e-13,
                  "binary tree, masses off by 1e-6");
    check_quality(quality_of(TEST_TREE_STAR, 200, 0.3, 1, 1e-12), 1e-12, 1e-13,
                  "star, masses off by 1e-12");
    check_quality(quality_of(TEST_TREE_BROOM, 300, 0.3, 1, 1e-9), 1e-12, 1e-13,
                  "broom, masses off by 1e-9");
}

TEST(modes_vectors_of_crowds) {
    /* many eigenvalues that differ by less and less: finer arithmetic separates them, until they
     * are equal */
    struct quality worst = {0, 0, 0, 0, 0};
    for (double off = 1e-2; off > 1e-15; off *= 1e-2) {
        worse(&worst, quality_of(TEST_TREE_STAR, 150, 0.3, 2, off));
        worse(&worst, quality_of(TEST_TREE_BINARY, 127, 0.3, 2, off));
        worse(&worst, quality_of(TEST_TREE_BROOM, 150, 0.3, 2, off));
    }
    check_quality(worst, 1e-12, 1e-13, "lengths and masses off by 1e-2 to 1e-14");
}

TEST(modes_vectors_of_unequal_masses) {
    struct quality worst = {0, 0, 0, 0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        worse(&worst, quality_of((enum test_tree_kind)kind, 300, 1.5, 0, 0));
    check_quality(worst, 1e-12, 1e-13, "masses 10^±1.5");
}

TEST(modes_vectors_of_wild_masses) {
    /* angles cannot determine more: displacements of heavy bobs are small differences of large
     * angles */
    double worst = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        worst = fmax(worst, quality_of((enum test_tree_kind)kind, 300, 6, 0, 0).terms);
    CHECK_RESIDUAL(worst, 1e-13, "masses 10^±6: orthogonality and residual over their terms");
}

/* orthogonality of some modes, and the largest residual relative to the norm; columns are too long
 * for a matrix of all pairs */
static struct quality quality_of_part(const struct pend_tree *tree, const struct pend_modes *part,
                                      double norm) {
    size_t n = (size_t)tree->n;
    struct quality q = {0, 0, 0, 0, 0};
    double *x = malloc(((size_t)part->count + 3) * n * sizeof *x),
           *size = x + (size_t)part->count * n;
    double *force = size + n, *terms = force + n;
    for (int i = 0; i < part->count; i++) {
        double *xi = x + (size_t)i * n;
        const double *theta = part->vector + (size_t)i * n;
        tips_of(tree, theta, xi, size);
        measure_residual(&q, tree, part->omega[i], theta, xi, size, norm, force, terms);
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (size_t k = 0; k < n; k++) sum += tree->mass[k] * xi[k] * x[(size_t)j * n + k];
            q.orthogonality = fmax(q.orthogonality, fabs(sum - (i == j)));
        }
    }
    free(x);
    return q;
}

TEST(modes_vectors_of_a_part_of_a_hundred_thousand_arms) {
    unsigned long long seed = 11;
    struct quality worst = {0, 0, 0, 0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        if (kind == TEST_TREE_STAR) continue; /* modes_of_a_star_of_two_thousand */
        OWN(test_tree, clear) t;
        OWN(pend_modes, free) *part = NULL, *fastest = NULL;
        test_tree_random(&t, (enum test_tree_kind)kind, 100000, 0.3, &seed);
        struct pend_modes_request request = {
            .loads.gravity = GRAVITY, .vectors = 1, .select = PEND_SELECT_SLOWEST, .count = 12};
        REQUIRE(pend_modes_select(&part, t.tree, &request, NULL) == PEND_OK);
        request = (struct pend_modes_request){
            .loads.gravity = GRAVITY, .select = PEND_SELECT_FASTEST, .count = 1};
        REQUIRE(pend_modes_select(&fastest, t.tree, &request, NULL) == PEND_OK);
        worse(&worst, quality_of_part(t.tree, part, fastest->omega[0] * fastest->omega[0]));
    }
    CHECK_RESIDUAL(worst.orthogonality, 1e-12, "12 slowest of 100 000 arms: V^T Re(0) V = I");
    CHECK_SAYING(worst.residual <= 1e-13, "12 slowest of 100 000 arms: residual %.2e",
                 worst.residual);
}

TEST(modes_vectors_hold_at_every_instruction_set) {
    enum { N = 61 };
    unsigned long long seed = 6;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_LIMBS, N, 0.3, &seed);
    OWN(pend_modes, free) *modes = NULL;
    REQUIRE(pend_modes_new(&modes, t.tree, TEST_LOADS(GRAVITY), 1, NULL) == PEND_OK);
    OWN(pend_laplacian, free) *l = NULL;
    REQUIRE(pend_laplacian_alloc(&l, N) == PEND_OK);
    for (int k = 0; k < N; k++) {
        l->spring[k] = pend_laplacian_spring(t.tree, TEST_LOADS(GRAVITY), NULL, k);
        l->mass[k] = t.tree->mass[k];
        l->len[k] = t.tree->len[k];
        l->parent[k] = t.tree->parent[k];
        l->end[k] = t.tree->end[k];
    }
    pend_laplacian_close(l);
    double worst = 0;
    for (int kind = 0; kind < 2 * ((int)pend_isa_best() + 1); kind++) {
        const struct pend_modes_kernel *kernel =
            PEND_ISA_PICK(pend_modes_kernel, (enum pend_isa)(kind / 2));
        int fine = kind % 2;
        double *work = aligned_alloc(64, (size_t)(6 * kernel->lanes * N * 8 + 63) / 64 * 64),
               value[8];
        double theta[8][N], tip[8][N], *theta_row[8], *tip_row[8];
        for (int first = 0; first + kernel->lanes <= N; first += kernel->lanes) {
            for (int i = 0; i < kernel->lanes; i++) {
                value[i] = modes->omega[first + i] * modes->omega[first + i];
                theta_row[i] = theta[i];
                tip_row[i] = tip[i];
            }
            if (fine)
                kernel->fine(l, value, t.tree->place[0], work, theta_row, tip_row);
            else
                kernel->vectors(l, value, t.tree->place[0], work, theta_row, tip_row);
            for (int i = 0; i < kernel->lanes; i++) {
                worst = fmax(worst, test_gap(N, theta[i], modes->vector + (size_t)(first + i) * N));
                for (int k = 0; k < N; k++) {
                    double from = t.tree->parent[k] < 0 ? 0 : tip[i][t.tree->parent[k]];
                    CHECK(fabs(tip[i][k] - from - t.tree->len[k] * theta[i][k]) < 1e-13);
                }
            }
        }
        free(work);
    }
    CHECK_RESIDUAL(worst, 1e-12, "vectors of all instruction sets");
}
