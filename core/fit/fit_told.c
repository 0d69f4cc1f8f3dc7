#include "core/fit/fit_told.h"

#include <assert.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>

/* A direction whose effect on the data is less than this part of the largest is not told by them.
 */
static const double told_least = 1e-9;

/* The same where the direction's standard error is known, of so many sizes of the unknowns at most:
 * what no motion depends on has effects up to 1e-15 of the largest, by rounding. */
static const double told_rounding = 1e-13, told_unsure = 1e3;

/* slopes whose squares, many of them, are still numbers */
static const double told_most = 1e140;

/* An unknown with more than this part of it in directions that are not told stands alone there;
 * less than that length of a direction is what others have told. */
static const double told_alone = 1 - 1e-6, told_left = 0.1;

/* A part of the largest second derivative that is error of differences. */
static const double told_flat = 1e-7;

enum pend_status pend_fit_told_init(struct fit_told *told, size_t m, int q, const double slope[],
                                    const double residual[], const unsigned char fixed[],
                                    const double size[]) {
    assert(q >= 1 && m >= (size_t)q);
    size_t p = (size_t)q;
    *told = (struct fit_told){.q = q, .size = size};
    double *block = malloc((p * p + 2 * p + m * p) * sizeof *block);
    if (!block) return PEND_NO_MEMORY;
    told->direction = block, told->value = block + p * p, told->gain = told->value + p;
    double *left = told->gain + p, whole = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < p; j++) {
            left[i * p + j] = fixed[j] ? 0 : slope[i * p + j] * size[j];
            whole = fmax(whole, isnan(left[i * p + j]) ? INFINITY : fabs(left[i * p + j]));
        }
    if (!(whole < told_most)) return PEND_NOT_FINITE;
    gsl_matrix_view U = gsl_matrix_view_array(left, m, p);
    gsl_matrix_view V = gsl_matrix_view_array(told->direction, p, p);
    gsl_vector_view s = gsl_vector_view_array(told->value, p);
    int failed = gsl_linalg_SV_decomp_jacobi(&U.matrix, &V.matrix, &s.vector);
    if (failed) return failed == GSL_ENOMEM ? PEND_NO_MEMORY : PEND_NOT_FINITE;
    for (size_t d = 0; d < p; d++) {
        told->gain[d] = 0;
        for (size_t i = 0; i < m; i++) told->gain[d] += left[i * p + d] * residual[i];
    }
    told->least = told_least * told->value[0];
    return PEND_OK;
}

void pend_fit_told_clear(struct fit_told *told) {
    free(told->direction);
    told->direction = NULL;
}

int pend_fit_told_is(const struct fit_told *told, int d) {
    assert(d >= 0 && d < told->q);
    return told->value[d] > told->least;
}

void pend_fit_told_sure(struct fit_told *told, double variance) {
    assert(variance >= 0);
    double sure = fmax(told_rounding * told->value[0], sqrt(variance) / told_unsure);
    told->least = fmin(told->least, sure);
}

void pend_fit_told_covariance(const struct fit_told *told, double covariance[]) {
    int q = told->q;
    for (int i = 0; i < q; i++)
        for (int j = 0; j < q; j++) {
            double sum = 0;
            for (int d = 0; d < q; d++) {
                double s = told->value[d];
                if (pend_fit_told_is(told, d))
                    sum += told->direction[i * q + d] * told->direction[j * q + d] / (s * s);
            }
            covariance[i * q + j] = sum * told->size[i] * told->size[j];
        }
}

double pend_fit_told_gain(const struct fit_told *told) {
    double gain = 0;
    for (int d = 0; d < told->q; d++)
        if (pend_fit_told_is(told, d)) gain += told->gain[d] * told->gain[d];
    return gain;
}

enum pend_status pend_fit_told_newton(int q, double bend[], const double slope[],
                                      const double size[], double *gain, double covariance[]) {
    size_t p = (size_t)q;
    double most = 0, sum = 0;
    double *block = malloc((p * p + p) * sizeof *block);
    gsl_eigen_symmv_workspace *work = block ? gsl_eigen_symmv_alloc(p) : NULL;
    assert(q >= 1);
    if (!work) {
        free(block);
        return PEND_NO_MEMORY;
    }
    double *direction = block, *value = block + p * p;
    gsl_matrix_view H = gsl_matrix_view_array(bend, p, p);
    gsl_matrix_view V = gsl_matrix_view_array(direction, p, p);
    gsl_vector_view l = gsl_vector_view_array(value, p);
    int failed = gsl_eigen_symmv(&H.matrix, &l.vector, &V.matrix, work);
    gsl_eigen_symmv_free(work);
    for (size_t d = 0; d < p; d++) most = fmax(most, fabs(value[d]));
    for (size_t d = 0; d < p; d++) {
        double along = 0;
        for (size_t j = 0; j < p; j++) along += direction[j * p + d] * slope[j];
        if (!(value[d] > -told_flat * most)) failed = 1;
        if (along != 0) sum += along * along / fmax(value[d], told_flat * most);
    }
    *gain = failed ? INFINITY : sum;
    for (size_t i = 0; i < p * p && !failed; i++) {
        covariance[i] = 0;
        for (size_t d = 0; d < p; d++)
            if (value[d] > told_flat * most)
                covariance[i] += direction[i / p * p + d] * direction[i % p * p + d] / value[d] *
                                 size[i / p] * size[i % p];
    }
    free(block);
    return PEND_OK;
}

/* The part of unknown j in the directions that are not told: 1 where the data do not depend on it
 * at all. */
static double told_unseen(const struct fit_told *told, int j) {
    double sum = 0;
    for (int d = 0; d < told->q; d++) {
        double part = told->direction[j * told->q + d];
        if (!pend_fit_told_is(told, d)) sum += part * part;
    }
    return sum;
}

/* takes from a row what it has of the rows before it; returns what is left, of its length */
static double told_part(int q, const double to[], int count, double row[]) {
    double square = 0;
    for (int i = 0; i < count; i++) {
        double along = 0, own = 0;
        for (int j = 0; j < q; j++)
            along += to[i * q + j] * row[j], own += to[i * q + j] * to[i * q + j];
        for (int j = 0; j < q; j++) row[j] -= to[i * q + j] * along / own;
    }
    for (int j = 0; j < q; j++) square += row[j] * row[j];
    return sqrt(square);
}

/* unknowns that the data do not depend on stand alone: any mixture of them is a direction; says how
 * many there are, of `most` */
static int told_singles(const struct fit_told *told, const unsigned char fixed[], int most,
                        double to[]) {
    int q = told->q, count = 0;
    for (int j = 0; j < q && count < most; j++) {
        if (fixed[j] || !(told_unseen(told, j) > told_alone)) continue;
        for (int i = 0; i < q; i++) to[count * q + i] = i == j;
        count++;
    }
    return count;
}

int pend_fit_told_blind(const struct fit_told *told, const unsigned char fixed[], int most,
                        double to[]) {
    int q = told->q, count = told_singles(told, fixed, most, to);
    for (int d = 0; d < q && count < most; d++) {
        double largest = 0, *row = to + (size_t)count * (size_t)q;
        if (pend_fit_told_is(told, d)) continue;
        for (int j = 0; j < q; j++) row[j] = fixed[j] ? 0 : told->direction[j * q + d];
        // of mixtures what stands alone is left out, and what was told before
        if (told_part(q, to, count, row) < told_left) continue;
        for (int j = 0; j < q; j++)
            if (fabs(row[j]) > fabs(largest)) largest = row[j];
        if (fabs(largest) < 0.1) continue; // the direction of an unknown at its bound
        for (int j = 0; j < q; j++) row[j] /= largest;
        count++;
    }
    return count;
}
