#include "core/fit/fit_told.h"

#include <assert.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>

#include "core/fit/fit_constants.h"

enum pend_status pend_fit_told_init(struct fit_told *told, size_t m, int q, const double slope[],
                                    const double residual[], const unsigned char fixed[],
                                    const double size[]) {
    assert(q >= 1 && m >= (size_t)q);
    size_t p = (size_t)q;
    *told = (struct fit_told){.q = q, .size = size};
    double *block = malloc((p * p + 2 * p + m * p) * sizeof *block);
    if (!block) return PEND_NO_MEMORY;
    told->direction = block, told->value = block + p * p, told->gain = told->value + p;
    double *left = told->change = told->gain + p, whole = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < p; j++) {
            left[i * p + j] = fixed[j] ? 0 : slope[i * p + j] * size[j];
            whole = fmax(whole, isnan(left[i * p + j]) ? INFINITY : fabs(left[i * p + j]));
        }
    if (!(whole < fit_largest)) return PEND_NOT_FINITE;
    gsl_matrix_view U = gsl_matrix_view_array(left, m, p);
    gsl_matrix_view V = gsl_matrix_view_array(told->direction, p, p);
    gsl_vector_view s = gsl_vector_view_array(told->value, p);
    int failed = gsl_linalg_SV_decomp_jacobi(&U.matrix, &V.matrix, &s.vector);
    if (failed) return failed == GSL_ENOMEM ? PEND_NO_MEMORY : PEND_NOT_FINITE;
    for (size_t d = 0; d < p; d++) {
        told->gain[d] = 0;
        for (size_t i = 0; i < m; i++) told->gain[d] += left[i * p + d] * residual[i];
    }
    told->least = fit_least * told->value[0];
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
    double sure = fmax(fit_rounding * told->value[0], sqrt(variance) / fit_unsure);
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

void pend_fit_told_rest(const struct fit_told *told, size_t m, const double residual[],
                        double rest[]) {
    size_t q = (size_t)told->q;
    assert(m >= q);
    for (size_t i = 0; i < m; i++) {
        rest[i] = residual[i];
        for (size_t d = 0; d < q; d++)
            if (pend_fit_told_is(told, (int)d)) rest[i] -= told->change[i * q + d] * told->gain[d];
    }
}

double pend_fit_told_gain(const struct fit_told *told) {
    double gain = 0;
    for (int d = 0; d < told->q; d++)
        if (pend_fit_told_is(told, d)) gain += told->gain[d] * told->gain[d];
    return gain;
}

/* Computes the identity plus the contribution of second derivatives, k x k, in coordinates in which
 * each direction changes the residuals by 1; `white` converts such coordinates to changes of the
 * unknowns. */
static void told_bent(const struct fit_told *told, const double bend[], double noise, double loose,
                      double white[], double k[]) {
    int q = told->q;
    for (int d = 0; d < q; d++)
        for (int a = 0; a < q; a++) {
            double s = told->value[d], sum = 0;
            int seen = pend_fit_told_is(told, d) && pend_fit_told_is(told, a);
            white[a * q + d] =
                pend_fit_told_is(told, d) ? told->size[a] * told->direction[a * q + d] / s : 0;
            for (int i = 0; i < q && seen; i++)
                sum += (told->direction[i * q + a] * bend[i * q + d] +
                        told->direction[i * q + d] * bend[i * q + a]) /
                       2;
            double more = seen ? sum / told->value[a] / s - (a == d) : 0;
            double doubt =
                seen ? (noise / fmin(told->value[a], s) + loose) / fmax(told->value[a], s) : 0;
            k[a * q + d] = (a == d) + (fabs(more) > doubt ? more : 0);
        }
}

enum pend_status pend_fit_told_newton(const struct fit_told *told, const double bend[],
                                      double noise, double loose, double *gain,
                                      double covariance[]) {
    size_t q = (size_t)told->q;
    double sum = 0;
    double *block = malloc((4 * q * q + q) * sizeof *block);
    gsl_eigen_symmv_workspace *work = block ? gsl_eigen_symmv_alloc(q) : NULL;
    assert(q >= 1 && noise >= 0 && loose >= 0);
    if (!work) {
        free(block);
        return PEND_NO_MEMORY;
    }
    double *white = block, *k = white + q * q, *direction = k + q * q, *turned = direction + q * q;
    double *value = turned + q * q;
    told_bent(told, bend, noise, loose, white, k);
    gsl_matrix_view H = gsl_matrix_view_array(k, q, q);
    gsl_matrix_view V = gsl_matrix_view_array(direction, q, q);
    gsl_vector_view l = gsl_vector_view_array(value, q);
    int failed = gsl_eigen_symmv(&H.matrix, &l.vector, &V.matrix, work);
    gsl_eigen_symmv_free(work);
    for (size_t d = 0; d < q; d++) {
        double along = 0;
        for (size_t a = 0; a < q; a++)
            if (pend_fit_told_is(told, (int)a)) along += direction[a * q + d] * told->gain[a];
        failed |= !(value[d] > fit_minimum);
        sum += along * along / fmax(value[d], fit_minimum);
        for (size_t j = 0; j < q; j++) {
            turned[j * q + d] = 0;
            for (size_t a = 0; a < q; a++)
                turned[j * q + d] += white[j * q + a] * direction[a * q + d];
        }
    }
    *gain = failed ? INFINITY : sum;
    for (size_t i = 0; i < q * q && !failed && covariance; i++) {
        covariance[i] = 0;
        for (size_t d = 0; d < q; d++)
            covariance[i] += turned[i / q * q + d] * turned[i % q * q + d] / value[d];
    }
    free(block);
    return PEND_OK;
}

/* subtracts from a row its projection on earlier rows; returns the fraction of its length that
 * remains */
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

/* Lists unknowns on which the data do not depend as separate directions, because any mixture of
 * them would be a null direction too. Returns their number, up to `most`. */
static int told_singles(const struct fit_told *told, const unsigned char fixed[], int most,
                        double to[]) {
    int q = told->q, count = 0;
    for (int j = 0; j < q && count < most; j++) {
        // the component in the null directions: 1 if the data do not depend on the unknown
        double unseen = 0;
        for (int d = 0; d < q; d++) {
            double part = told->direction[j * q + d];
            if (!pend_fit_told_is(told, d)) unseen += part * part;
        }
        if (fixed[j] || !(unseen > fit_alone)) continue;
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
        // skip mixtures of single unknowns and directions already listed
        if (told_part(q, to, count, row) < fit_left) continue;
        for (int j = 0; j < q; j++)
            if (fabs(row[j]) > fabs(largest)) largest = row[j];
        if (fabs(largest) < 0.1) continue; // skip the direction of an unknown at its bound
        for (int j = 0; j < q; j++) row[j] /= largest;
        count++;
    }
    return count;
}
