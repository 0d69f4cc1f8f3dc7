#include "core/modes/modes.h"

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_sort_vector.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

#define GRAVITY 9.81

static struct pend_tree *tree_of(int n, const double length[], const double mass[],
                                 const int parent[]) {
    struct pend_tree *tree = NULL;
    CHECK_INT(pend_tree_new(&tree, n, length, mass, parent, NULL), PEND_OK);
    return tree;
}

static struct pend_modes *modes_of(const struct pend_tree *tree, double gravity) {
    struct pend_modes *modes = NULL;
    CHECK_INT(pend_modes_new(&modes, tree, TEST_LOADS(gravity), 1, NULL), PEND_OK);
    return modes;
}

/* entry of a mode for the caller's arm i */
static double entry(const struct pend_modes *modes, const struct pend_tree *tree, int mode, int i) {
    return modes->vector[(size_t)mode * modes->n + tree->place[i]];
}

static void normalize(struct pend_modes *modes, const struct pend_tree *tree,
                      enum pend_normalize rule) {
    for (int k = 0; k < modes->count; k++) pend_modes_scale(modes, tree, k, rule, -1);
}

/* largest relative error of omega, largest error of the entries, against lists in the caller's
 * order */
static void check_against(int n, const double mass, const int parent[], const double omega_unit[],
                          const double vector[], enum pend_normalize rule, double tolerance,
                          const char *what) {
    double length[8] = {0}, masses[8] = {0}, worst = 0;
    for (int i = 0; i < n; i++) length[i] = 0.7, masses[i] = mass;
    OWN(pend_tree, free) *tree = tree_of(n, length, masses, parent);
    OWN(pend_modes, free) *modes = modes_of(tree, GRAVITY);
    normalize(modes, tree, rule);
    for (int k = 0; k < n; k++) {
        worst = fmax(worst, fabs(modes->omega[k] / (sqrt(GRAVITY / 0.7) * omega_unit[k]) - 1));
        for (int i = 0; i < n; i++)
            worst = fmax(worst, fabs(entry(modes, tree, k, i) - vector[k * n + i]));
    }
    CHECK_RESIDUAL(worst, tolerance, what);
}

TEST(modes_of_the_papers_double_pendulum) {
    const double omega[] = {sqrt(2 - sqrt(2)), sqrt(2 + sqrt(2))}, r = sqrt(2);
    const double first[] = {1, r, 1, -r}, max[] = {1 / r, 1, -1 / r, 1};
    check_against(2, 1.3, (int[]){-1, 0}, omega, first, PEND_NORMALIZE_FIRST, 5e-15,
                  "double pendulum, first");
    check_against(2, 1.3, (int[]){-1, 0}, omega, max, PEND_NORMALIZE_MAX, 5e-15,
                  "double pendulum, max");
}

TEST(modes_of_the_papers_three_arms_at_one_joint) {
    const double omega[] = {sqrt(3 - sqrt(6)), 1, sqrt(3 + sqrt(6))}, r = sqrt(1.5);
    const double first[] = {1, r, r, 0, 1, -1, 1, -r, -r};
    check_against(3, 0.2, (int[]){-1, 0, 0}, omega, first, PEND_NORMALIZE_FIRST, 5e-15,
                  "non-standard triple, first");
    const double max[] = {1 / r, 1, 1, 0, 1, -1, -1 / r, 1, 1};
    check_against(3, 0.2, (int[]){-1, 0, 0}, omega, max, PEND_NORMALIZE_MAX, 5e-15,
                  "non-standard triple, max");
}

TEST(modes_of_one_arm) {
    double length = 2.5, mass = 3;
    OWN(pend_tree, free) *tree = tree_of(1, &length, &mass, (int[]){-1});
    OWN(pend_modes, free) *modes = modes_of(tree, GRAVITY);
    CHECK_INT(modes->count, 1);
    CHECK_RESIDUAL(fabs(modes->omega[0] / sqrt(GRAVITY / length) - 1), 5e-16,
                   "one arm's frequency");
    CHECK_RESIDUAL(fabs(modes->vector[0] * length * sqrt(mass) - 1), 5e-16, "one arm's mass norm");
}

/* A v = omega^2 v with the paper's A: the largest residual relative to the largest entry of A v,
 * both for one mode */
static double residual(const struct pend_modes *modes, const double a[]) {
    int n = modes->n;
    double worst = 0;
    for (int k = 0; k < modes->count; k++) {
        const double *v = modes->vector + (size_t)k * n;
        double error = 0, size = 0;
        for (int i = 0; i < n; i++) {
            double sum = 0, terms = 0;
            for (int j = 0; j < n; j++)
                sum += a[i * n + j] * v[j], terms += fabs(a[i * n + j] * v[j]);
            error = fmax(error, fabs(sum - modes->omega[k] * modes->omega[k] * v[i]));
            size = fmax(size, terms);
        }
        worst = fmax(worst, error / size);
    }
    return worst;
}

/* largest | V^T Re(0) V - I |, with Re(0) = g diag(l S^T m) A^{-1} */
static double orthogonality(const struct pend_modes *modes, const struct pend_tree *tree,
                            const double a_inverse[]) {
    int n = modes->n;
    double worst = 0, *product = malloc((size_t)n * sizeof *product);
    for (int k = 0; k < modes->count; k++) {
        for (int i = 0; i < n; i++) {
            product[i] = 0;
            for (int j = 0; j < n; j++)
                product[i] += a_inverse[i * n + j] * modes->vector[(size_t)k * n + j];
            product[i] *= GRAVITY * tree->len[i] * tree->subtree_mass[i];
        }
        for (int other = 0; other <= k; other++) {
            double dot = 0;
            for (int i = 0; i < n; i++) dot += modes->vector[(size_t)other * n + i] * product[i];
            worst = fmax(worst, fabs(dot - (other == k)));
        }
    }
    free(product);
    return worst;
}

/* sum 1/omega^2 = l_tot/g (the trace of A^{-1}) */
static double trace_gap(const struct pend_modes *modes, const struct pend_tree *tree) {
    double sum = 0;
    for (int k = 0; k < modes->count; k++) sum += 1 / (modes->omega[k] * modes->omega[k]);
    return fabs(sum * GRAVITY / tree->length_total - 1);
}

/* (A^{-1})_kk = sum over modes of (V_k)^2 g l_k (S^T m)_k / omega^2 ... = l_k/g, from
 * frequencies and vectors alone */
static double diagonal_gap(const struct pend_modes *modes, const struct pend_tree *tree) {
    double worst = 0;
    for (int k = 0; k < modes->n; k++) {
        double sum = 0, weight = GRAVITY * tree->len[k] * tree->subtree_mass[k];
        for (int mode = 0; mode < modes->n; mode++) {
            double v = modes->vector[(size_t)mode * modes->n + k],
                   square = modes->omega[mode] * modes->omega[mode];
            sum += v * v * weight / (square * square);
        }
        worst = fmax(worst, fabs(sum * GRAVITY / tree->len[k] - 1));
    }
    return worst;
}

TEST(modes_solve_the_papers_linearization) {
    unsigned long long seed = 4;
    double worst[4] = {0, 0, 0, 0};
    for (int kind = 0; kind < TEST_TREE_KINDS; kind++)
        for (int n = 1; n <= 60; n = 2 * n + 1) {
            OWN(test_tree, clear) t;
            test_tree_random(&t, (enum test_tree_kind)kind, n, 0.3, &seed);
            double *a = malloc(2 * (size_t)n * (size_t)n * sizeof *a),
                   *a_inverse = a + (size_t)n * n;
            test_quad_linearization(t.tree, GRAVITY, a, a_inverse);
            OWN(pend_modes, free) *modes = modes_of(t.tree, GRAVITY);
            worst[0] = fmax(worst[0], residual(modes, a));
            worst[1] = fmax(worst[1], orthogonality(modes, t.tree, a_inverse));
            worst[2] = fmax(worst[2], trace_gap(modes, t.tree));
            worst[3] = fmax(worst[3], diagonal_gap(modes, t.tree));
            for (int k = 1; k < n; k++) CHECK(modes->omega[k] >= modes->omega[k - 1]);
            free(a);
        }
    CHECK_RESIDUAL(worst[0], 5e-15, "A v = omega^2 v");
    CHECK_RESIDUAL(worst[1], 1e-12, "V^T Re(0) V = I");
    CHECK_RESIDUAL(worst[2], 1e-14, "sum 1/omega^2 = l_tot/g");
    CHECK_RESIDUAL(worst[3], 1e-12, "(A^-1)_kk = l_k/g");
}

/* largest relative difference of the frequencies, and of the vectors in the caller's order of `a`
 * through map */
static double modes_gap(const struct pend_modes *a, const struct pend_tree *a_tree,
                        const struct pend_modes *b, const struct pend_tree *b_tree, const int map[],
                        double omega_scale, double vector_scale) {
    double worst = 0;
    for (int k = 0; k < a->count; k++) {
        worst = fmax(worst, fabs(b->omega[k] / (a->omega[k] * omega_scale) - 1));
        double largest = 0, error = 0;
        for (int i = 0; i < a->n; i++) {
            double x = entry(a, a_tree, k, i);
            largest = fmax(largest, fabs(x));
            error = fmax(error, fabs(entry(b, b_tree, k, map ? map[i] : i) * vector_scale - x));
        }
        worst = fmax(worst, error / largest);
    }
    return worst;
}

TEST(modes_do_not_depend_on_the_numbers_of_the_arms) {
    enum { N = 24 };
    unsigned long long seed = 11;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 0.3, &seed);
    int map[N], parent[N];
    double length[N], mass[N];
    /* arm i becomes arm map[i], a random order */
    for (int i = 0; i < N; i++) map[i] = i;
    for (int i = N - 1; i > 0; i--) {
        int j = test_random_int(&seed, i + 1), swap = map[i];
        map[i] = map[j];
        map[j] = swap;
    }
    for (int i = 0; i < N; i++) {
        length[map[i]] = t.length[i];
        mass[map[i]] = t.mass[i];
        parent[map[i]] = t.parent[i] < 0 ? -1 : map[t.parent[i]];
    }
    OWN(pend_tree, free) *other = tree_of(N, length, mass, parent);
    OWN(pend_modes, free) *a = modes_of(t.tree, GRAVITY), *b = modes_of(other, GRAVITY);
    /* MAX does not depend on which arm comes first */
    normalize(a, t.tree, PEND_NORMALIZE_MAX);
    normalize(b, other, PEND_NORMALIZE_MAX);
    CHECK_RESIDUAL(modes_gap(a, t.tree, b, other, map, 1, 1), 1e-12, "relabelled");
}

TEST(modes_scale_with_gravity_length_and_mass) {
    enum { N = 15 };
    unsigned long long seed = 12;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_LIMBS, N, 0.3, &seed);
    double length[N], mass[N];
    for (int i = 0; i < N; i++) length[i] = 3 * t.length[i], mass[i] = 5 * t.mass[i];
    OWN(pend_tree, free) *other = tree_of(N, length, mass, t.parent);
    OWN(pend_modes, free) *a = modes_of(t.tree, GRAVITY), *b = modes_of(other, 7 * GRAVITY);
    CHECK_RESIDUAL(modes_gap(a, t.tree, b, other, NULL, sqrt(7.0 / 3), 3 * sqrt(5)), 1e-12,
                   "scaled");
}

TEST(modes_of_a_star_have_the_stated_basis) {
    enum { N = 9 }; /* eight equal arms on the tip of the first: frequency sqrt(g/l) seven times */
    double length[N], mass[N];
    int parent[N];
    for (int i = 0; i < N; i++) length[i] = 1.5, mass[i] = 2, parent[i] = i ? 0 : -1;
    OWN(pend_tree, free) *tree = tree_of(N, length, mass, parent);
    OWN(pend_modes, free) *modes = modes_of(tree, GRAVITY);
    normalize(modes, tree, PEND_NORMALIZE_FIRST);
    double worst = 0;
    for (int k = 1; k < N - 1; k++) {
        worst = fmax(worst, fabs(modes->omega[k] / sqrt(GRAVITY / 1.5) - 1));
        for (int i = 0; i < N; i++) {
            /* one arm against the mean of all later ones */
            double want = i < k ? 0 : i == k ? 1 : -1.0 / (N - 1 - k);
            worst = fmax(worst, fabs(entry(modes, tree, k, i) - want));
        }
    }
    CHECK_RESIDUAL(worst, 1e-15, "star's multiple frequency");
}

TEST(modes_normalize_keeps_the_norm_it_states) {
    unsigned long long seed = 21;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, 12, 0.3, &seed);
    OWN(pend_modes, free) *a = modes_of(t.tree, GRAVITY), *b = modes_of(t.tree, GRAVITY);
    normalize(b, t.tree, PEND_NORMALIZE_MAX);
    normalize(b, t.tree, PEND_NORMALIZE_FIRST);
    for (int k = 0; k < b->count; k++) CHECK(entry(b, t.tree, k, 0) == 1);
    normalize(b, t.tree, PEND_NORMALIZE_MASS);
    CHECK_RESIDUAL(modes_gap(a, t.tree, b, t.tree, NULL, 1, 1), 5e-15, "back to mass norm");
    for (int k = 0; k < b->count; k++) CHECK(entry(b, t.tree, k, 0) > 0 && b->norm[k] == 1);
}

TEST(modes_decompose_a_start) {
    enum { N = 17 };
    unsigned long long seed = 31;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, N, 0.3, &seed);
    OWN(pend_modes, free) *modes = modes_of(t.tree, GRAVITY);
    double theta[N], rate[N], amplitude[N], phase[N];
    for (int rule = 0; rule < 3; rule++) {
        normalize(modes, t.tree, (enum pend_normalize)rule);
        CHECK_INT(pend_modes_decompose(modes, t.tree, NULL, t.phi, t.rate, amplitude, phase),
                  PEND_OK);
        memset(theta, 0, sizeof theta);
        memset(rate, 0, sizeof rate);
        for (int k = 0; k < N; k++) {
            CHECK(amplitude[k] >= 0 && phase[k] > -M_PI && phase[k] <= M_PI);
            for (int i = 0; i < N; i++) {
                theta[i] += amplitude[k] * modes->vector[k * N + i] * cos(phase[k]);
                rate[i] -=
                    amplitude[k] * modes->omega[k] * modes->vector[k * N + i] * sin(phase[k]);
            }
        }
        CHECK_RESIDUAL(test_gap(N, theta, t.phi), 1e-13, "theta from the modes");
        CHECK_RESIDUAL(test_gap(N, rate, t.rate), 1e-13, "rate from the modes");
    }
    /* at rest in a negative mode: that mode alone, with phase pi */
    for (int i = 0; i < N; i++) theta[i] = -modes->vector[2 * N + i], rate[i] = 0;
    CHECK_INT(pend_modes_decompose(modes, t.tree, NULL, theta, rate, amplitude, phase), PEND_OK);
    CHECK(phase[2] == M_PI);
    CHECK_RESIDUAL(fabs(amplitude[2] - 1), 1e-15, "amplitude of one mode");
    /* no mode is excited */
    memset(theta, 0, sizeof theta);
    CHECK_INT(pend_modes_decompose(modes, t.tree, NULL, theta, theta, amplitude, phase), PEND_OK);
    for (int k = 0; k < N; k++) CHECK(amplitude[k] == 0 && phase[k] == 0);
}

TEST(modes_refuse_gravity_that_is_not_positive) {
    double one = 1, bad[] = {0, -1, NAN, INFINITY};
    OWN(pend_tree, free) *tree = tree_of(1, &one, &one, (int[]){-1});
    for (int i = 0; i < 4; i++) {
        struct pend_modes *modes = NULL;
        struct pend_error error;
        CHECK_INT(pend_modes_new(&modes, tree, TEST_LOADS(bad[i]), 1, &error), PEND_INVALID);
        CHECK(!modes && error.code == PEND_INVALID && strstr(error.text, "gravity"));
    }
}

TEST(modes_survive_any_allocation_that_fails) {
    unsigned long long seed = 41;
    OWN(test_tree, clear) t;
    test_tree_random(&t, TEST_TREE_ATTACHED, 10, 0.3, &seed);
    for (int for_good = 0; for_good < 2; for_good++) {
        int failures = 0;
        for (long count = 1;; count++) {
            struct pend_modes *modes = NULL;
            double amplitude[10], phase[10];
            test_alloc_fail(count, for_good);
            enum pend_status status = pend_modes_new(&modes, t.tree, TEST_LOADS(GRAVITY), 1, NULL);
            if (!status)
                status = pend_modes_decompose(modes, t.tree, NULL, t.phi, t.rate, amplitude, phase);
            test_alloc_faults_off();
            if (status) CHECK_INT(status, PEND_NO_MEMORY);
            pend_modes_free(&modes);
            if (!status) break;
            failures++;
        }
        CHECK(failures >= 2);
    }
}

TEST(modes_of_like_branches_and_crowds_survive_any_allocation_that_fails) {
    enum { N = 40 };
    unsigned long long seed = 42;
    for (int variant = 0; variant < 6; variant++) {
        OWN(test_tree, clear) t;
        unsigned char up[N] = {0};
        int failures = 0;
        test_tree_random(&t, variant % 2 ? TEST_TREE_STAR : TEST_TREE_BINARY, N, 0, &seed);
        for (int i = 0; i < N; i++) {
            t.mass[i] = 1;
            t.length[i] = 1 + (variant % 2) * 1e-6 * test_random(&seed);
            up[i] = (unsigned char)(variant > 3 && i % 3 == 0);
        }
        test_tree_rebuild(&t);
        struct pend_modes_request request = {
            .loads.gravity = GRAVITY, .vectors = 1, .up = variant > 3 ? up : NULL};
        if (variant > 1) request.select = PEND_SELECT_FASTEST, request.count = 30;
        for (long count = 1;; count++) {
            struct pend_modes *modes = NULL;
            test_alloc_fail(count, 0);
            enum pend_status status = pend_modes_select(&modes, t.tree, &request, NULL);
            test_alloc_faults_off();
            if (status) CHECK(status == PEND_NO_MEMORY && !modes);
            pend_modes_free(&modes);
            if (!status) break;
            failures++;
        }
        CHECK(failures >= 10);
    }
}

/* Largest relative difference of the frequencies from GSL's: with K = g diag(l (S^T m)) the matrix
 * K^{-1/2} Re(0) K^{-1/2} has the eigenvalues 1 / omega^2. */
static double gsl_gap(const struct pend_tree *tree) {
    OWN(pend_modes, free) *fast = modes_of(tree, GRAVITY);
    const double *len = tree->len, *carried = tree->subtree_mass;
    size_t n = (size_t)tree->n;
    gsl_matrix *matrix = gsl_matrix_calloc(n, n);
    gsl_vector *value = gsl_vector_alloc(n);
    gsl_eigen_symm_workspace *work = gsl_eigen_symm_alloc(n);
    double worst = 0;
    for (int k = 0; k < tree->n; k++)
        for (int j = k; j >= 0; j = tree->parent[j])
            gsl_matrix_set(matrix, (size_t)k, (size_t)j,
                           sqrt(len[j] * len[k]) * sqrt(carried[k] / carried[j]) / GRAVITY);
    CHECK(!gsl_eigen_symm(matrix, value, work));
    gsl_sort_vector(value);
    for (size_t k = 0; k < n; k++)
        worst = fmax(worst, fabs(fast->omega[n - 1 - k] * sqrt(gsl_vector_get(value, k)) - 1));
    gsl_eigen_symm_free(work);
    gsl_matrix_free(matrix);
    gsl_vector_free(value);
    return worst;
}

TEST(modes_agree_with_the_dense_eigensolver) {
    unsigned long long seed = 51;
    double worst = 0;
    int parent[6];
    /* every tree of up to 6 arms, with equal and different arms */
    for (int n = 1; n <= 6; n++) {
        test_parents_first(n, parent);
        do {
            OWN(test_tree, clear) t;
            test_tree_init(&t, n, parent, 0.3, &seed);
            worst = fmax(worst, gsl_gap(t.tree));
            for (int i = 0; i < n; i++) t.length[i] = t.mass[i] = 1;
            test_tree_rebuild(&t);
            worst = fmax(worst, gsl_gap(t.tree));
        } while (test_parents_next(n, parent));
    }
    CHECK_RESIDUAL(worst, 1e-12, "frequencies against GSL, all trees of up to 6 arms");
}

TEST(modes_of_like_branches_are_the_dense_ones) {
    unsigned long long seed = 52;
    double worst[3] = {0, 0, 0};
    /* few different arms, so that branches are often equal, in all ways */
    for (int round = 0; round < 60; round++) {
        int n = 2 + test_random_int(&seed, 40);
        OWN(test_tree, clear) t;
        test_tree_random(&t, round % 2 ? TEST_TREE_ATTACHED : TEST_TREE_LIMBS, n, 0, &seed);
        for (int i = 0; i < n; i++) {
            t.length[i] = round % 3 ? 1 : 1 + test_random_int(&seed, 2);
            t.mass[i] = round % 5 ? 1 : 1 + test_random_int(&seed, 2);
        }
        test_tree_rebuild(&t);
        double *a = malloc(2 * (size_t)n * (size_t)n * sizeof *a), *a_inverse = a + (size_t)n * n;
        test_quad_linearization(t.tree, GRAVITY, a, a_inverse);
        OWN(pend_modes, free) *modes = modes_of(t.tree, GRAVITY);
        worst[0] = fmax(worst[0], gsl_gap(t.tree));
        worst[1] = fmax(worst[1], residual(modes, a));
        worst[2] = fmax(worst[2], orthogonality(modes, t.tree, a_inverse));
        CHECK(trace_gap(modes, t.tree) < 1e-14 && diagonal_gap(modes, t.tree) < 1e-12);
        free(a);
    }
    CHECK_RESIDUAL(worst[0], 1e-12, "frequencies of like branches against GSL");
    CHECK_RESIDUAL(worst[1], 5e-15, "A v = omega^2 v of like branches");
    CHECK_RESIDUAL(worst[2], 1e-13, "V^T Re(0) V = I of like branches");
}

TEST(modes_of_a_star_of_two_thousand) {
    enum { N = 2000 };
    OWN_MEMORY double *one = malloc(N * sizeof *one);
    OWN_MEMORY int *parent = malloc(N * sizeof *parent);
    for (int i = 0; i < N; i++) one[i] = 1, parent[i] = i ? 0 : -1;
    OWN(pend_tree, free) *tree = tree_of(N, one, one, parent);
    OWN(pend_modes, free) *modes = modes_of(tree, GRAVITY);
    double worst = 0;
    for (int k = 1; k < N - 1; k++) worst = fmax(worst, fabs(modes->omega[k] / sqrt(GRAVITY) - 1));
    /* the other two: (1 - w)(N - w) = (N - 1) w with w = omega^2/g, so w^2 - 2 N w + N = 0 */
    double high = N + sqrt((double)N * N - N), low = N / high;
    worst = fmax(worst, fabs(modes->omega[0] / sqrt(GRAVITY * low) - 1));
    worst = fmax(worst, fabs(modes->omega[N - 1] / sqrt(GRAVITY * high) - 1));
    CHECK_RESIDUAL(worst, 1e-15, "frequencies of a star of 2000");
    CHECK_RESIDUAL(trace_gap(modes, tree), 1e-13, "trace identity of a star of 2000");
}

TEST(modes_of_two_heavy_bobs_on_a_light_hub) {
    /* the bobs swing together and against each other almost as single pendulums */
    const double length[] = {1, 1, 1}, mass[] = {1e-12, 1, 1 + 1e-6};
    OWN(pend_tree, free) *tree = tree_of(3, length, mass, (int[]){-1, 0, 0});
    OWN(pend_modes, free) *modes = modes_of(tree, GRAVITY);
    /* where M is the sum of the two masses, mu = m1 m2 / M: the hub follows at once, lambda = g/2
     * and g; then the hub's own, g M / m0 */
    CHECK_RESIDUAL(fabs(modes->omega[0] / sqrt(GRAVITY / 2) - 1), 1e-12, "bobs together");
    CHECK_RESIDUAL(fabs(modes->omega[1] / sqrt(GRAVITY) - 1), 1e-15, "bobs against each other");
    CHECK_RESIDUAL(fabs(modes->omega[2] / sqrt(2 * GRAVITY * (mass[1] + mass[2]) / mass[0]) - 1),
                   1e-11, "the hub alone");
    CHECK_RESIDUAL(trace_gap(modes, tree), 1e-15, "trace identity of two heavy bobs");
}

/* largest difference of a selection from the modes number first .. of all */
static double selection_gap(const struct pend_modes *part, const struct pend_modes *all) {
    double worst = 0;
    for (int k = 0; k < part->count; k++) {
        int of_all = part->first + k;
        worst = fmax(worst, fabs(part->omega[k] / all->omega[of_all] - 1));
        worst = fmax(worst, test_gap(all->n, part->vector + (size_t)k * all->n,
                                     all->vector + (size_t)of_all * all->n));
    }
    return worst;
}

static void check_selections(const struct pend_tree *tree, unsigned long long *seed,
                             double *worst) {
    OWN(pend_modes, free) *all = modes_of(tree, GRAVITY), *part = NULL;
    int n = tree->n, count = 1 + test_random_int(seed, n);
    struct pend_modes_request request = {.loads.gravity = GRAVITY, .vectors = 1, .count = count};
    request.select = PEND_SELECT_SLOWEST;
    CHECK_INT(pend_modes_select(&part, tree, &request, NULL), PEND_OK);
    CHECK(part->count == count && part->first == 0);
    /* if a repeated frequency is split, its vectors have another basis */
    if (count == n || all->omega[count] > all->omega[count - 1] * (1 + 1e-12))
        *worst = fmax(*worst, selection_gap(part, all));
    pend_modes_free(&part);
    request.select = PEND_SELECT_FASTEST;
    CHECK_INT(pend_modes_select(&part, tree, &request, NULL), PEND_OK);
    CHECK(part->count == count && part->first == n - count);
    for (int k = 0; k < count; k++)
        *worst = fmax(*worst, fabs(part->omega[k] / all->omega[n - count + k] - 1));
    pend_modes_free(&part);
    /* an interval that begins and ends between modes, and one that begins and ends on modes */
    int low = test_random_int(seed, n), high = low + test_random_int(seed, n - low);
    request.select = PEND_SELECT_BETWEEN;
    request.from = all->omega[low] * (1 - 1e-9);
    request.to = all->omega[high] * (1 + 1e-9);
    CHECK_INT(pend_modes_select(&part, tree, &request, NULL), PEND_OK);
    CHECK(part->first <= low && part->first + part->count > high);
    for (int k = 0; k < part->count; k++)
        CHECK(part->omega[k] >= request.from && part->omega[k] <= request.to);
    *worst = fmax(*worst, selection_gap(part, all));
    pend_modes_free(&part);
    request.from = request.to = 2 * all->omega[n - 1];
    CHECK_INT(pend_modes_select(&part, tree, &request, NULL), PEND_OK);
    CHECK(part->count == 0);
}

TEST(modes_selected_are_those_of_the_whole) {
    unsigned long long seed = 53;
    double worst = 0;
    for (int round = 0; round < 80; round++) {
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)(round % TEST_TREE_KINDS),
                         1 + test_random_int(&seed, 70), 0.3, &seed);
        for (int i = 0; round % 2 && i < t.n; i++) t.length[i] = t.mass[i] = 1;
        test_tree_rebuild(&t);
        check_selections(t.tree, &seed, &worst);
    }
    CHECK_RESIDUAL(worst, 1e-11, "selections");
}

TEST(modes_selected_about_any_equilibrium_are_those_of_the_whole) {
    enum { N = 70 };
    unsigned long long seed = 55;
    double worst = 0;
    for (int round = 0; round < 150; round++) {
        OWN(test_tree, clear) t;
        unsigned char up[N];
        int n = 1 + test_random_int(&seed, N), first = test_random_int(&seed, n);
        test_tree_random(&t, (enum test_tree_kind)(round % TEST_TREE_KINDS), n, 0.3, &seed);
        for (int i = 0; round % 3 && i < n; i++) t.length[i] = t.mass[i] = 1;
        test_tree_rebuild(&t);
        /* upright by depth, so that equal branches stay equal */
        for (int k = 0; k < n; k++) up[k] = t.tree->depth[k] % 2 == round % 2;
        struct pend_modes_request request = {.loads.gravity = GRAVITY, .vectors = 1, .up = up};
        OWN(pend_modes, free) *all = NULL, *some = NULL;
        REQUIRE(pend_modes_select(&all, t.tree, &request, NULL) == PEND_OK);
        request.select = PEND_SELECT_NUMBERS;
        request.first = first;
        request.count = 1 + test_random_int(&seed, n - first);
        REQUIRE(pend_modes_select(&some, t.tree, &request, NULL) == PEND_OK);
        CHECK(some->count == request.count && some->first == first);
        CHECK_INT(some->growing,
                  all->growing > first ? fmin(all->growing - first, request.count) : 0);
        /* if a repeated frequency that is not due to equal branches is split, its vectors have
         * another basis */
        int end = first + request.count,
            cut = first && all->omega[first] - all->omega[first - 1] < 1e-12;
        cut |= end < n && all->omega[end] - all->omega[end - 1] < 1e-12;
        if (!cut) worst = fmax(worst, selection_gap(some, all));
        for (int k = 0; k < some->count; k++)
            worst = fmax(worst, fabs(some->omega[k] / all->omega[first + k] - 1));
    }
    CHECK_RESIDUAL(worst, 1e-10, "selections about standing arms");
}

TEST(modes_refuse_selections_that_mean_nothing) {
    const double length[] = {1, 1}, mass[] = {1, 1};
    OWN(pend_tree, free) *tree = tree_of(2, length, mass, (int[]){-1, 0});
    const struct pend_modes_request bad[] = {
        {.loads.gravity = 1, .select = PEND_SELECT_SLOWEST, .count = 3},
        {.loads.gravity = 1, .select = PEND_SELECT_SLOWEST},
        {.loads.gravity = 1, .select = PEND_SELECT_FASTEST, .count = -1},
        {.loads.gravity = 1, .select = PEND_SELECT_BETWEEN, .from = 2, .to = 1},
        {.loads.gravity = 1, .select = PEND_SELECT_BETWEEN, .from = NAN}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pend_modes *modes = NULL;
        struct pend_error error;
        CHECK_INT(pend_modes_select(&modes, tree, &bad[i], &error), PEND_INVALID);
        CHECK(!modes && strlen(error.text) > 10);
    }
}

/* about an equilibrium K theta = lambda Re(0) theta with K = g diag(+-l S^T m): largest residual
 * relative to its terms */
static double upright_residual(const struct pend_modes *modes, const struct pend_tree *tree,
                               const unsigned char up[], const double a_inverse[]) {
    int n = tree->n;
    double worst = 0;
    for (int k = 0; k < n; k++) {
        const double *v = modes->vector + (size_t)k * n;
        double lambda = modes->omega[k] * fabs(modes->omega[k]), error = 0, size = 0;
        for (int i = 0; i < n; i++) {
            double sum = 0, terms = 0;
            for (int j = 0; j < n; j++) {
                /* the angle of an upright arm moves its tip in the opposite direction */
                double sign = (up[i] != 0) == (up[j] != 0) ? 1 : -1;
                sum += sign * a_inverse[i * n + j] * v[j];
                terms += fabs(a_inverse[i * n + j] * v[j]);
            }
            error = fmax(error, fabs((up[i] ? -v[i] : v[i]) - lambda * sum));
            size = fmax(size, fabs(v[i]) + fabs(lambda) * terms);
        }
        worst = fmax(worst, error / size);
    }
    return worst;
}

TEST(modes_about_any_equilibrium) {
    unsigned long long seed = 54;
    double worst = 0;
    for (int round = 0; round < 80; round++) {
        int n = 1 + test_random_int(&seed, 40), standing = 0;
        unsigned char up[40];
        OWN(test_tree, clear) t;
        test_tree_random(&t, (enum test_tree_kind)(round % TEST_TREE_KINDS), n, 0.3, &seed);
        for (int i = 0; round % 2 && i < n; i++) t.length[i] = t.mass[i] = 1;
        test_tree_rebuild(&t);
        for (int k = 0; k < n; k++) standing += up[k] = (unsigned char)(test_random(&seed) < 0.4);
        OWN_MEMORY double *a_inverse = malloc((size_t)n * (size_t)n * sizeof *a_inverse);
        test_quad_linearization(t.tree, GRAVITY, NULL, a_inverse);
        struct pend_modes_request request = {.loads.gravity = GRAVITY, .vectors = 1, .up = up};
        OWN(pend_modes, free) *modes = NULL;
        CHECK_INT(pend_modes_select(&modes, t.tree, &request, NULL), PEND_OK);
        CHECK_INT(modes->growing, standing);
        for (int k = 0; k < n; k++) CHECK((modes->omega[k] < 0) == (k < standing));
        worst = fmax(worst, upright_residual(modes, t.tree, up, a_inverse));
    }
    CHECK_RESIDUAL(worst, 1e-13, "modes about arms that stand and hang");
}

TEST(modes_of_standing_arms_grow_at_the_rates_at_which_hanging_ones_swing) {
    const double length[] = {1, 1}, mass[] = {1, 1};
    const unsigned char up[] = {1, 1};
    OWN(pend_tree, free) *tree = tree_of(2, length, mass, (int[]){-1, 0});
    struct pend_modes_request request = {.loads.gravity = GRAVITY, .vectors = 1, .up = up};
    OWN(pend_modes, free) *modes = NULL;
    CHECK_INT(pend_modes_select(&modes, tree, &request, NULL), PEND_OK);
    CHECK_RESIDUAL(fabs(modes->omega[0] / -sqrt(GRAVITY * (2 + sqrt(2))) - 1), 1e-15,
                   "fast growth");
    CHECK_RESIDUAL(fabs(modes->omega[1] / -sqrt(GRAVITY * (2 - sqrt(2))) - 1), 1e-15,
                   "slow growth");
    CHECK_INT(modes->growing, 2);
}

/* the frequency of a mode of a tree; p: number of the length or mass that is `by` times as large,
 * or gravity */
static double omega_beside(const struct test_tree *t, int p, double by, int mode) {
    double *number = p < t->n ? t->length + t->tree->order[p] : t->mass + t->tree->order[p % t->n];
    double was = *number, gravity = p < 2 * t->n ? GRAVITY : GRAVITY * by;
    if (p < 2 * t->n) *number *= by;
    struct pend_tree *tree = tree_of(t->n, t->length, t->mass, t->parent);
    struct pend_modes *modes = modes_of(tree, gravity);
    double omega = modes->omega[mode];
    *number = was;
    pend_modes_free(&modes);
    pend_tree_free(&tree);
    return omega;
}

TEST(frequencies_change_as_their_derivatives_say) {
    unsigned long long seed = 41;
    double slope[25], worst = 0, h = 1e-4;
    for (int n = 1; n <= 12; n++) {
        struct test_tree t;
        test_tree_random(&t, TEST_TREE_LIMBS, n, 0.3, &seed);
        struct pend_modes *modes = modes_of(t.tree, GRAVITY);
        for (int k = 0; k < n; k++) {
            pend_modes_slope(modes, t.tree, TEST_LOADS(GRAVITY), k, slope);
            for (int p = 0; p <= 2 * n; p++) {
                double number = p == 2 * n ? GRAVITY : p < n ? t.tree->len[p] : t.tree->mass[p - n];
                double change = omega_beside(&t, p, 1 + h, k) - omega_beside(&t, p, 1 - h, k);
                double error = change / (2 * h) - slope[p] * number;
                worst = fmax(worst, fabs(error) / modes->omega[k]);
            }
        }
        pend_modes_free(&modes);
        test_tree_clear(&t);
    }
    CHECK_RESIDUAL(worst, 1e-6, "derivatives of frequencies");
}
