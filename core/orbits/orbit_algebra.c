#include "core/orbits/orbit_algebra.h"

#include <assert.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct orbit_algebra {
    int rows;
    double *factor;      /* rows x rows numbers */
    double *tau, *right; /* rows numbers each */
    double *value;       /* 2 rows numbers */
    double block[];
};

double pend_orbit_algebra_bytes(int rows) {
    assert(rows >= 1);
    double squared = (double)rows * rows;
    return 16 * squared + 1024 + 32.0 * rows + 200.0 * rows; // plus memory of GSL
}

enum pend_status pend_orbit_algebra_new(struct orbit_algebra **algebra, int rows) {
    assert(rows >= 1);
    size_t n = (size_t)rows;
    struct orbit_algebra *made = *algebra = malloc(sizeof *made + (n * n + 4 * n) * sizeof(double));
    if (!made) return PEND_NO_MEMORY;
    made->rows = rows;
    made->factor = made->block;
    made->tau = made->factor + n * n;
    made->right = made->tau + n;
    made->value = made->right + n;
    return PEND_OK;
}

void pend_orbit_algebra_free(struct orbit_algebra **algebra) {
    free(*algebra);
    *algebra = NULL;
}

static int algebra_finite(const double x[], size_t count) {
    int good = 1;
    for (size_t i = 0; i < count; i++) good &= isfinite(x[i]) != 0;
    return good;
}

int pend_orbit_solve(struct orbit_algebra *algebra, int n, const double A[], int count,
                     double B[]) {
    assert(n >= 1 && n <= algebra->rows && count >= 1);
    size_t rows = (size_t)n, columns = (size_t)count;
    if (!algebra_finite(A, rows * rows)) return 0;
    memcpy(algebra->factor, A, rows * rows * sizeof(double));
    gsl_matrix_view factor = gsl_matrix_view_array(algebra->factor, rows, rows);
    gsl_vector_view tau = gsl_vector_view_array(algebra->tau, rows);
    gsl_vector_view right = gsl_vector_view_array(algebra->right, rows);
    gsl_linalg_QR_decomp(&factor.matrix, &tau.vector);
    for (size_t i = 0; i < rows; i++)
        if (gsl_matrix_get(&factor.matrix, i, i) == 0) return 0;
    for (size_t j = 0; j < columns; j++) {
        for (size_t i = 0; i < rows; i++) algebra->right[i] = B[i * columns + j];
        gsl_linalg_QR_svx(&factor.matrix, &tau.vector, &right.vector);
        for (size_t i = 0; i < rows; i++) B[i * columns + j] = algebra->right[i];
    }
    return algebra_finite(B, rows * columns);
}

enum pend_status pend_orbit_least(struct orbit_algebra *algebra, int n, const double A[],
                                  double size[3], double least[]) {
    assert(n >= 2 && n <= algebra->rows);
    size_t rows = (size_t)n;
    if (!algebra_finite(A, rows * rows)) return PEND_NO_CONVERGENCE;
    double *across = malloc(rows * rows * sizeof *across);
    if (!across) return PEND_NO_MEMORY;
    memcpy(algebra->factor, A, rows * rows * sizeof(double));
    gsl_matrix_view matrix = gsl_matrix_view_array(algebra->factor, rows, rows);
    gsl_matrix_view right = gsl_matrix_view_array(across, rows, rows);
    gsl_vector_view value = gsl_vector_view_array(algebra->value, rows);
    int failed = gsl_linalg_SV_decomp_jacobi(&matrix.matrix, &right.matrix, &value.vector);
    for (size_t i = 0; i < 3 && !failed; i++)
        size[i] = i < rows ? algebra->value[rows - 1 - i] : INFINITY;
    for (size_t i = 0; i < 2 && !failed; i++)
        for (size_t j = 0; j < rows; j++) least[i * rows + j] = across[j * rows + rows - 1 - i];
    free(across);
    return !failed && algebra_finite(least, 2 * rows) ? PEND_OK : PEND_NO_CONVERGENCE;
}

enum pend_status pend_orbit_eigenvalues(struct orbit_algebra *algebra, int n, const double A[],
                                        double re[], double im[]) {
    assert(n >= 0 && n <= algebra->rows);
    size_t rows = (size_t)n;
    if (!n) return PEND_OK;
    if (!algebra_finite(A, rows * rows)) return PEND_NO_CONVERGENCE;
    gsl_eigen_nonsymm_workspace *work = gsl_eigen_nonsymm_alloc(rows);
    if (!work) return PEND_NO_MEMORY;
    memcpy(algebra->factor, A, rows * rows * sizeof(double));
    gsl_matrix_view matrix = gsl_matrix_view_array(algebra->factor, rows, rows);
    gsl_vector_complex_view value = gsl_vector_complex_view_array(algebra->value, rows);
    gsl_eigen_nonsymm_params(0, 1, work);
    int failed = gsl_eigen_nonsymm(&matrix.matrix, &value.vector, work);
    gsl_eigen_nonsymm_free(work);
    for (size_t i = 0; i < rows && !failed; i++)
        re[i] = algebra->value[2 * i], im[i] = algebra->value[2 * i + 1];
    int good = !failed && algebra_finite(re, rows) && algebra_finite(im, rows);
    return good ? PEND_OK : PEND_NO_CONVERGENCE;
}

/* replaces K by H K H with H = 1 - 2 v v^T, v of unit length */
static void algebra_reflect(size_t n, const double v[], double K[]) {
    for (size_t i = 0; i < n; i++) {
        double sum = 0;
        for (size_t j = 0; j < n; j++) sum += K[i * n + j] * v[j];
        for (size_t j = 0; j < n; j++) K[i * n + j] -= 2 * sum * v[j];
    }
    for (size_t j = 0; j < n; j++) {
        double sum = 0;
        for (size_t i = 0; i < n; i++) sum += v[i] * K[i * n + j];
        for (size_t i = 0; i < n; i++) K[i * n + j] -= 2 * v[i] * sum;
    }
}

/* removes the left or right eigenvector g from the n x n matrix K: the remaining (n - 1) x (n - 1)
 * matrix is stored at its start; v has space for n numbers */
static int algebra_deflate(size_t n, const double g[], double K[], double v[]) {
    double size = 0, norm = 0;
    for (size_t i = 0; i < n; i++) size = hypot(size, g[i]);
    if (!(size > 0) || !isfinite(size)) return 0;
    for (size_t i = 0; i < n; i++) v[i] = g[i] / size;
    v[0] += v[0] < 0 ? -1 : 1;
    for (size_t i = 0; i < n; i++) norm = hypot(norm, v[i]);
    for (size_t i = 0; i < n; i++) v[i] /= norm;
    algebra_reflect(n, v, K);
    for (size_t i = 1; i < n; i++)
        memmove(K + (i - 1) * (n - 1), K + i * n + 1, (n - 1) * sizeof *K);
    return 1;
}

enum pend_status pend_orbit_mirrored(struct orbit_algebra *algebra, int n, const double phi_by[],
                                     const double rate_by[], const double gradient[], double omega,
                                     double work[], double re[], double im[]) {
    assert(n >= 1 && omega > 0);
    size_t rows = (size_t)n, all = 2 * rows;
    double *Q = work, *right = Q + all * all, *K = right + all * rows, *v = K + rows * rows;
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < all; j++) {
            double unit = j < rows ? 1 : omega;
            Q[i * all + j] = phi_by[i * all + j] * unit;
            Q[(rows + i) * all + j] = rate_by[i * all + j] * unit / omega;
        }
    // R Q for the angles at the start
    for (size_t i = 0; i < all; i++)
        for (size_t j = 0; j < rows; j++)
            right[i * rows + j] = i < rows ? Q[i * all + j] : -Q[i * all + j];
    if (!pend_orbit_solve(algebra, 2 * n, Q, n, right)) return PEND_NO_CONVERGENCE;
    memcpy(K, right, rows * rows * sizeof *K);
    if (!algebra_deflate(rows, gradient, K, v)) return PEND_NO_CONVERGENCE;
    return pend_orbit_eigenvalues(algebra, n - 1, K, re, im);
}

enum pend_status pend_orbit_kept(struct orbit_algebra *algebra, int n, double A[],
                                 const double left[], double right[], double v[], double re[],
                                 double im[]) {
    assert(n >= 2 && n <= algebra->rows);
    size_t rows = (size_t)n;
    double sum = 0;
    if (!algebra_deflate(rows, left, A, v)) return PEND_NO_CONVERGENCE;
    for (size_t i = 0; i < rows; i++) sum += v[i] * right[i];
    for (size_t i = 0; i < rows; i++) right[i] -= 2 * sum * v[i];
    if (!algebra_deflate(rows - 1, right + 1, A, v)) return PEND_NO_CONVERGENCE;
    return pend_orbit_eigenvalues(algebra, n - 2, A, re, im);
}
