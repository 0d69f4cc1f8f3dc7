/* Systems of complex equations: factors of a matrix, and solutions with them.
 * Leaves to others: the systems (method_radau). GSL's functions are not available in browsers.
 * Invariant: matrices are n rows of n, with separate arrays for real and imaginary parts; the
 * diagonal holds the inverses of the pivots. */
#pragma once

#include <math.h>

/** Factors a matrix in place, with pivoting; `swap` receives the row exchanges. Returns 0 if the
 * matrix is singular or not finite. O(n^3). */
static inline int complex_factor(int n, double re[], double im[], int swap[]) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (hypot(re[i * n + k], im[i * n + k]) > hypot(re[best * n + k], im[best * n + k]))
                best = i;
        swap[k] = best;
        for (int j = 0; j < n && best != k; j++) {
            double a = re[k * n + j], b = im[k * n + j];
            re[k * n + j] = re[best * n + j], im[k * n + j] = im[best * n + j];
            re[best * n + j] = a, im[best * n + j] = b;
        }
        double a = re[k * n + k], b = im[k * n + k], square = a * a + b * b;
        if (!(square > 0) || !isfinite(square)) return 0;
        // the diagonal holds the inverse of the pivot
        re[k * n + k] = a / square, im[k * n + k] = -b / square;
        const double *restrict top_re = re + k * n, *restrict top_im = im + k * n;
        for (int i = k + 1; i < n; i++) {
            double *restrict x = re + i * n, *restrict y = im + i * n, p = x[k], q = y[k];
            double u = p * top_re[k] - q * top_im[k], v = p * top_im[k] + q * top_re[k];
            x[k] = u, y[k] = v;
            for (int j = k + 1; j < n; j++) {
                x[j] -= u * top_re[j] - v * top_im[j];
                y[j] -= u * top_im[j] + v * top_re[j];
            }
        }
    }
    return 1;
}

/** Solves a system with the factors; x + i y: in the right-hand side, out the solution. O(n^2). */
static inline void complex_solve(int n, const double re[], const double im[], const int swap[],
                                 double x[], double y[]) {
    for (int k = 0; k < n; k++) {
        double a = x[swap[k]], b = y[swap[k]];
        x[swap[k]] = x[k], y[swap[k]] = y[k];
        for (int j = 0; j < k; j++) {
            a -= re[k * n + j] * x[j] - im[k * n + j] * y[j];
            b -= re[k * n + j] * y[j] + im[k * n + j] * x[j];
        }
        x[k] = a, y[k] = b;
    }
    for (int k = n - 1; k >= 0; k--) {
        double a = x[k], b = y[k];
        for (int j = k + 1; j < n; j++) {
            a -= re[k * n + j] * x[j] - im[k * n + j] * y[j];
            b -= re[k * n + j] * y[j] + im[k * n + j] * x[j];
        }
        x[k] = a * re[k * n + k] - b * im[k * n + k];
        y[k] = a * im[k * n + k] + b * re[k * n + k];
    }
}
