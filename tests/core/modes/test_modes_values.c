#include "core/modes/modes_values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

#define GRAVITY 9.81

static struct pend_laplacian *laplacian_of(const struct pend_tree *tree) {
    struct pend_laplacian *l = NULL;
    CHECK_INT(pend_laplacian_alloc(&l, tree->n), PEND_OK);
    for (int k = 0; k < tree->n; k++) {
        l->spring[k] = pend_laplacian_spring(tree, TEST_LOADS(GRAVITY), NULL, k);
        l->mass[k] = tree->mass[k];
        l->len[k] = tree->len[k];
        l->parent[k] = tree->parent[k];
        l->end[k] = tree->end[k];
    }
    pend_laplacian_close(l);
    return l;
}

/* the values number first .. first + count - 1 */
static void find_values(const struct pend_laplacian *l, int first, int count, double value[]) {
    OWN(pend_values, free) *values;
    REQUIRE(pend_values_new(&values, l, first, count, value) == PEND_OK);
    while (!pend_values_step(values)) continue;
}

/* the number of eigenvalues below a shift, in quadruple precision */
static int quad_below(const struct pend_laplacian *l, test_quad shift, test_quad pivot[]) {
    int below = 0;
    for (int k = 0; k < l->n; k++) pivot[k] = -shift * l->mass[k];
    for (int k = l->n - 1; k >= 0; k--) {
        test_quad d = pivot[k] + l->spring[k];
        if (d == 0) d = 1e-40 * (test_quad)l->spring[k];
        below += d < 0;
        if (k) pivot[l->parent[k]] += l->spring[k] * (pivot[k] / d);
    }
    return below;
}

/* relative error of eigenvalue i: the interval is doubled until quadruple-precision counts bracket
 * it */
static double value_error(const struct pend_laplacian *l, double value, int i, test_quad pivot[]) {
    double error = 1e-16;
    while (error < 1 && !(quad_below(l, value * (1 - (test_quad)error), pivot) <= i &&
                          quad_below(l, value * (1 + (test_quad)error), pivot) > i))
        error *= 2;
    return error;
}

/* largest relative error of all eigenvalues of a random tree */
static double worst_error(enum test_tree_kind kind, int n, double spread,
                          unsigned long long *seed) {
    OWN(test_tree, clear) t;
    test_tree_random(&t, kind, n, spread, seed);
    OWN(pend_laplacian, free) *l = laplacian_of(t.tree);
    double worst = 0, sum = 0, *value = malloc((size_t)n * sizeof *value);
    OWN_MEMORY test_quad *pivot = malloc((size_t)n * sizeof *pivot);
    find_values(l, 0, n, value);
    for (int i = 0; i < n; i++) {
        CHECK(value[i] > 0 && (!i || value[i] >= value[i - 1]));
        worst = fmax(worst, value_error(l, value[i], i, pivot));
        sum += GRAVITY / value[i];
    }
    CHECK(fabs(sum / t.tree->length_total - 1) < 1e-13);
    free(value);
    return worst;
}

TEST(modes_values_are_exact_whatever_the_masses) {
    unsigned long long seed = 3;
    double mild = 0, wild = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        mild = fmax(mild, worst_error((enum test_tree_kind)kind, 150, 0.3, &seed));
        wild = fmax(wild, worst_error((enum test_tree_kind)kind, 200, 10, &seed));
    }
    CHECK_RESIDUAL(mild, 2e-15, "eigenvalues against quad counts, masses 10^±0.3");
    CHECK_RESIDUAL(wild, 1e-14, "eigenvalues against quad counts, masses 10^±10");
}

/* for two arms both ends of a span know the eigenvalue exactly, and round-off makes their estimates
 * cross */
TEST(modes_values_of_double_pendulums_are_those_of_the_quadratic_equation) {
    unsigned long long seed = 12;
    const int parent[2] = {-1, 0};
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        double length[2], mass[2], value[2];
        for (int k = 0; k < 2; k++)
            length[k] = 0.2 + 4 * test_random(&seed), mass[k] = 0.2 + 4 * test_random(&seed);
        OWN(pend_tree, free) *tree;
        REQUIRE(pend_tree_new(&tree, 2, length, mass, parent, NULL) == PEND_OK);
        OWN(pend_laplacian, free) *l = laplacian_of(tree);
        find_values(l, 0, 2, value);
        double square = mass[0] / (mass[0] + mass[1]) * length[0] * length[1],
               half = (length[0] + length[1]) / 2, root = sqrt(half * half - square);
        worst = fmax(worst, fabs(value[0] * (half + root) / GRAVITY - 1));
        worst = fmax(worst, fabs(value[1] * square / (GRAVITY * (half + root)) - 1));
    }
    CHECK_RESIDUAL(worst, 1e-14, "eigenvalues of double pendulums");
}

TEST(modes_values_of_a_chain_of_a_million_unit_arms) {
    enum { N = 1000000 };
    double *one = malloc(N * sizeof *one), slowest = 0;
    OWN_MEMORY int *parent = malloc(N * sizeof *parent);
    for (int i = 0; i < N; i++) one[i] = 1, parent[i] = i - 1;
    OWN(pend_tree, free) *tree = NULL;
    REQUIRE(pend_tree_new(&tree, N, one, one, parent, NULL) == PEND_OK);
    OWN(pend_laplacian, free) *l = laplacian_of(tree);
    find_values(l, 0, 1, &slowest);
    OWN_MEMORY test_quad *pivot = malloc(N * sizeof *pivot);
    CHECK_RESIDUAL(value_error(l, slowest, 0, pivot), 1e-14, "slowest mode of a million unit arms");
    /* the hanging chain: sqrt(g/length) times half the first zero of J_0 */
    CHECK_RESIDUAL(fabs(sqrt(slowest * N / GRAVITY) / (0.5 * 2.404825557695773) - 1), 1e-5,
                   "against a hanging string");
    free(one);
}

TEST(modes_values_of_a_part_are_those_of_the_whole) {
    enum { N = 120 };
    unsigned long long seed = 8;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_LIMBS, N, 2, &seed);
    OWN(pend_laplacian, free) *l = laplacian_of(t.tree);
    double all[N], part[N], worst = 0;
    find_values(l, 0, N, all);
    for (int round = 0; round < 200; round++) {
        int first = test_random_int(&seed, N), count = 1 + test_random_int(&seed, N - first);
        find_values(l, first, count, part);
        for (int i = 0; i < count; i++) worst = fmax(worst, fabs(part[i] / all[first + i] - 1));
        /* halfway between two eigenvalues the count is known */
        if (first) CHECK_INT(pend_values_below(l, sqrt(all[first - 1] * all[first])), first);
    }
    CHECK_RESIDUAL(worst, 3e-15, "eigenvalues of parts");
}

TEST(modes_values_hold_at_every_instruction_set) {
    enum { N = 90, SHIFTS = 70 };
    unsigned long long seed = 9;
    double worst = 0;
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)kind, N, 0.3, &seed);
        OWN(pend_laplacian, free) *l = laplacian_of(t.tree);
        for (int isa = 0; isa <= (int)pend_isa_best(); isa++) {
            const struct pend_modes_kernel *kernel =
                PEND_ISA_PICK(pend_modes_kernel, (enum pend_isa)isa);
            struct pend_modes_probe probe[SHIFTS], alone;
            test_quad pivot[N];
            for (int i = 0; i < SHIFTS; i++)
                probe[i].shift = l->least * pow(l->most / l->least, (i + 0.5) / SHIFTS);
            kernel->probe(l, SHIFTS, probe);
            for (int i = 0; i < SHIFTS; i++) {
                CHECK_INT(probe[i].below, quad_below(l, probe[i].shift, pivot));
                /* p'/p by a difference of the counts' own pivots is too coarse: compare with the
                 * base kernel instead */
                alone.shift = probe[i].shift;
                PEND_ISA_PICK(pend_modes_kernel, PEND_ISA_BASE)->probe(l, 1, &alone);
                worst = fmax(worst, fabs(probe[i].log_rate / alone.log_rate - 1));
                /* a lane does not depend on its neighbours */
                alone.shift = probe[i].shift;
                kernel->probe(l, 1, &alone);
                CHECK(alone.log_rate == probe[i].log_rate && alone.log_bend == probe[i].log_bend);
            }
        }
    }
    CHECK_RESIDUAL(worst, 1e-9, "log derivatives of all instruction sets");
}

TEST(modes_values_log_derivatives_are_sums_over_the_eigenvalues) {
    enum { N = 40 };
    unsigned long long seed = 10;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 0.3, &seed);
    OWN(pend_laplacian, free) *l = laplacian_of(t.tree);
    double value[N], worst = 0;
    find_values(l, 0, N, value);
    for (int i = 1; i < N; i++) {
        struct pend_modes_probe probe = {.shift = 0.3 * value[i - 1] + 0.7 * value[i]};
        double rate = 0, size = 0, bend = 0;
        PEND_ISA_PICK(pend_modes_kernel, pend_isa_best())->probe(l, 1, &probe);
        for (int j = 0; j < N; j++) {
            double inverse = 1 / (probe.shift - value[j]);
            rate += inverse;
            size += fabs(inverse);
            bend += inverse * inverse;
        }
        worst =
            fmax(worst, fmax(fabs(probe.log_rate - rate) / size, fabs(probe.log_bend / bend - 1)));
    }
    CHECK_RESIDUAL(worst, 1e-10, "sums 1/(s - lambda) and 1/(s - lambda)^2");
}
