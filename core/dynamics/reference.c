#include "core/dynamics/reference.h"

#include <assert.h>
#include <gsl/gsl_blas.h>
#include <gsl/gsl_complex.h>
#include <gsl/gsl_complex_math.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The matrices of the paper, as views into one block. GSL's own allocation functions abort the
 * program if memory runs out. */
struct reference_space {
    double *block;
    gsl_matrix_complex_view tips;    /* S diag(l e^{i phi}) */
    gsl_matrix_complex_view loaded;  /* diag(m) S diag(l e^{i phi}) */
    gsl_matrix_complex_view inertia; /* M(phi) */
    gsl_matrix_view path;            /* S */
    gsl_matrix_view re, im;          /* of M; re becomes its factors */
    gsl_vector_view hung;            /* S^T m */
    gsl_vector_view square;          /* phi'^2 */
    gsl_vector_view right;           /* a right-hand side */
    gsl_permutation pivots;
};

static gsl_matrix_view reference_matrix(double **free_at, size_t n) {
    gsl_matrix_view view = gsl_matrix_view_array(*free_at, n, n);
    *free_at += n * n;
    return view;
}

static gsl_matrix_complex_view reference_complex(double **free_at, size_t n) {
    gsl_matrix_complex_view view = gsl_matrix_complex_view_array(*free_at, n, n);
    *free_at += 2 * n * n;
    return view;
}

static gsl_vector_view reference_vector(double **free_at, size_t n) {
    gsl_vector_view view = gsl_vector_view_array(*free_at, n);
    *free_at += n;
    return view;
}

static enum pend_status reference_init(struct reference_space *space,
                                       const struct pend_tree *tree) {
    size_t n = (size_t)tree->n;
    space->block = NULL;
    if (n > SIZE_MAX / sizeof(double) / 16 / n) return PEND_NO_MEMORY;
    double *at = space->block = calloc(9 * n * n + 3 * n, sizeof *at);
    size_t *pivot = malloc(n * sizeof *pivot);
    if (!at || !pivot) {
        free(at);
        free(pivot);
        space->block = NULL;
        return PEND_NO_MEMORY;
    }
    space->tips = reference_complex(&at, n);
    space->loaded = reference_complex(&at, n);
    space->inertia = reference_complex(&at, n);
    space->path = reference_matrix(&at, n);
    space->re = reference_matrix(&at, n);
    space->im = reference_matrix(&at, n);
    space->hung = reference_vector(&at, n);
    space->square = reference_vector(&at, n);
    space->right = reference_vector(&at, n);
    space->pivots = (gsl_permutation){n, pivot};
    return PEND_OK;
}

static void reference_clear(struct reference_space *space) {
    if (!space->block) return;
    free(space->pivots.data);
    free(space->block);
}

/* S, in the tree's stored order, and S^T m */
static void reference_paths(struct reference_space *space, const struct pend_tree *tree) {
    for (int k = 0; k < tree->n; k++)
        for (int j = k; j >= 0; j = tree->parent[j])
            gsl_matrix_set(&space->path.matrix, (size_t)k, (size_t)j, 1);
    gsl_vector_const_view mass = gsl_vector_const_view_array(tree->mass, (size_t)tree->n);
    gsl_blas_dgemv(CblasTrans, 1, &space->path.matrix, &mass.vector, 0, &space->hung.vector);
}

/* M(phi) = diag(e^{-i phi} l) S^T diag(m) S diag(l e^{i phi}), with its parts in re and im */
static void reference_inertia(struct reference_space *space, const struct pend_tree *tree,
                              const double phi[]) {
    size_t n = (size_t)tree->n;
    for (size_t j = 0; j < n; j++) {
        gsl_complex arm = gsl_complex_polar(tree->len[j], phi[j]);
        for (size_t k = 0; k < n; k++) {
            gsl_complex tip = gsl_complex_mul_real(arm, gsl_matrix_get(&space->path.matrix, k, j));
            gsl_matrix_complex_set(&space->tips.matrix, k, j, tip);
            gsl_matrix_complex_set(&space->loaded.matrix, k, j,
                                   gsl_complex_mul_real(tip, tree->mass[k]));
        }
    }
    gsl_blas_zgemm(CblasConjTrans, CblasNoTrans, GSL_COMPLEX_ONE, &space->tips.matrix,
                   &space->loaded.matrix, GSL_COMPLEX_ZERO, &space->inertia.matrix);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            gsl_complex entry = gsl_matrix_complex_get(&space->inertia.matrix, i, j);
            gsl_matrix_set(&space->re.matrix, i, j, GSL_REAL(entry));
            gsl_matrix_set(&space->im.matrix, i, j, GSL_IMAG(entry));
        }
}

/* factors re in place: P Re P^T = L D L^T; this Cholesky variant reports a failure in D instead of
 * calling GSL's error handler */
static enum pend_status reference_factor(struct reference_space *space) {
    gsl_linalg_pcholesky_decomp(&space->re.matrix, &space->pivots);
    for (size_t k = 0; k < space->pivots.size; k++) {
        double d = gsl_matrix_get(&space->re.matrix, k, k);
        if (!(d > 0 && isfinite(d))) return PEND_NOT_FINITE;
    }
    return PEND_OK;
}

enum pend_status pend_reference_mass_matrix(const struct pend_tree *tree, const double phi[],
                                            double re[], double im[]) {
    assert(pend_tree_valid(tree) && re != im);
    struct reference_space space;
    size_t bytes = (size_t)tree->n * (size_t)tree->n * sizeof *re;
    PEND_TRY(reference_init(&space, tree));
    reference_paths(&space, tree);
    reference_inertia(&space, tree, phi);
    memcpy(re, space.re.matrix.data, bytes);
    memcpy(im, space.im.matrix.data, bytes);
    reference_clear(&space);
    return PEND_OK;
}

/* (aaa): phi'' = Re^-1 [ Im phi'^2 - g cos(phi) l (S^T m) ], left in space->right */
static enum pend_status reference_aaa(struct reference_space *space, const struct pend_tree *tree,
                                      const struct pend_loads *loads, const double phi[]) {
    gsl_vector *right = &space->right.vector;
    for (size_t k = 0; k < right->size; k++)
        gsl_vector_set(right, k,
                       loads->gravity * cos(phi[k]) * tree->len[k] *
                           gsl_vector_get(&space->hung.vector, k));
    gsl_blas_dgemv(CblasNoTrans, 1, &space->im.matrix, &space->square.vector, -1, right);
    PEND_TRY(reference_factor(space));
    gsl_linalg_pcholesky_svx(&space->re.matrix, &space->pivots, right);
    return PEND_OK;
}

/* (bbb): lambda = g sin(phi) (S^T m) - l^-1 [ Im phi'' + Re phi'^2 ]; `re` is M's again */
static void reference_bbb(struct reference_space *space, const struct pend_tree *tree,
                          const struct pend_loads *loads, const double phi[], const double acc[],
                          double force[]) {
    gsl_vector_const_view acceleration = gsl_vector_const_view_array(acc, (size_t)tree->n);
    gsl_vector *right = &space->right.vector;
    gsl_blas_dgemv(CblasNoTrans, 1, &space->im.matrix, &acceleration.vector, 0, right);
    gsl_blas_dgemv(CblasNoTrans, 1, &space->re.matrix, &space->square.vector, 1, right);
    for (size_t k = 0; k < right->size; k++)
        force[k] = loads->gravity * sin(phi[k]) * gsl_vector_get(&space->hung.vector, k) -
                   gsl_vector_get(right, k) / tree->len[k];
}

enum pend_status pend_reference_dynamics(const struct pend_tree *tree,
                                         const struct pend_loads *loads, const double phi[],
                                         const double rate[], double acc[], double force[]) {
    assert(pend_tree_valid(tree) && acc != force && phi != acc && rate != acc);
    struct reference_space space;
    enum pend_status status = reference_init(&space, tree);
    if (status) goto out;
    reference_paths(&space, tree);
    reference_inertia(&space, tree, phi);
    for (int k = 0; k < tree->n; k++)
        gsl_vector_set(&space.square.vector, (size_t)k, rate[k] * rate[k]);
    status = reference_aaa(&space, tree, loads, phi);
    if (status) goto out;
    memcpy(acc, space.right.vector.data, (size_t)tree->n * sizeof *acc);
    if (force) {
        reference_inertia(&space, tree, phi);
        reference_bbb(&space, tree, loads, phi, acc, force);
    }
out:
    reference_clear(&space);
    return status;
}

/* A = g Re(0)^-1 diag(l (S^T m)), column by column; re contains the factors */
static void reference_lin(struct reference_space *space, const struct pend_tree *tree,
                          const struct pend_loads *loads, double a[]) {
    size_t n = (size_t)tree->n;
    gsl_vector *column = &space->right.vector;
    for (size_t j = 0; j < n; j++) {
        gsl_vector_set_zero(column);
        gsl_vector_set(column, j,
                       loads->gravity * tree->len[j] * gsl_vector_get(&space->hung.vector, j));
        gsl_linalg_pcholesky_svx(&space->re.matrix, &space->pivots, column);
        for (size_t i = 0; i < n; i++) a[i * n + j] = gsl_vector_get(column, i);
    }
}

/* A^-1 = diag(l (S^T m))^-1 Re(0) / g */
static void reference_lin_inverse(struct reference_space *space, const struct pend_tree *tree,
                                  const struct pend_loads *loads, double inverse[]) {
    size_t n = (size_t)tree->n;
    for (size_t i = 0; i < n; i++) {
        double scale = loads->gravity * tree->len[i] * gsl_vector_get(&space->hung.vector, i);
        for (size_t j = 0; j < n; j++)
            inverse[i * n + j] = gsl_matrix_get(&space->re.matrix, i, j) / scale;
    }
}

enum pend_status pend_reference_linearization(const struct pend_tree *tree,
                                              const struct pend_loads *loads, double a[],
                                              double a_inverse[]) {
    struct reference_space space;
    if (loads->gravity == 0 && a_inverse) return PEND_INVALID;
    enum pend_status status = reference_init(&space, tree);
    if (status) goto out;
    // M(0) is real; the angles are 0, because the block was just cleared
    reference_paths(&space, tree);
    reference_inertia(&space, tree, space.square.vector.data);
    if (a_inverse) reference_lin_inverse(&space, tree, loads, a_inverse);
    if (!a) goto out;
    status = reference_factor(&space);
    if (status) goto out;
    reference_lin(&space, tree, loads, a);
out:
    reference_clear(&space);
    return status;
}
