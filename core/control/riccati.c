#include "core/control/riccati.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_algebra.h"

enum { DOUBLINGS_MOST = 60 };

void pend_product(int n, int k, int m, const double a[], int ta, const double b[], int tb,
                  double keep, double out[]) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++) {
            double sum = keep == 0 ? 0 : keep * out[i * m + j];
            for (int l = 0; l < k; l++)
                sum += a[ta ? l * n + i : i * k + l] * b[tb ? j * k + l : l * m + j];
            out[i * m + j] = sum;
        }
}

/* replaces a matrix by its symmetric part; returns the largest entry */
static double riccati_even(int n, double x[]) {
    double most = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            x[i * n + j] = x[j * n + i] = (x[i * n + j] + x[j * n + i]) / 2;
            most = fmax(most, fabs(x[i * n + j]));
        }
    return most;
}

/* one doubling step of a, g and h, with scratch `work` of 4 n^2; returns the relative change of h,
 * or NAN if W is singular */
static double riccati_double(struct orbit_algebra *algebra, int n, double a[], double g[],
                             double h[], double work[]) {
    size_t square = (size_t)n * (size_t)n;
    double *w = work, *x = w + square, *y = x + square, *t = y + square;
    memset(w, 0, square * sizeof *w);
    for (int i = 0; i < n; i++) w[i * n + i] = 1;
    pend_product(n, n, n, g, 0, h, 0, 1, w);
    memcpy(x, a, square * sizeof *x);
    memcpy(y, g, square * sizeof *y);
    if (!pend_orbit_solve(algebra, n, w, n, x) || !pend_orbit_solve(algebra, n, w, n, y))
        return NAN;
    pend_product(n, n, n, a, 0, y, 0, 0, t);
    pend_product(n, n, n, t, 0, a, 1, 1, g);
    pend_product(n, n, n, h, 0, x, 0, 0, t);
    pend_product(n, n, n, a, 1, t, 0, 0, y);
    pend_product(n, n, n, a, 0, x, 0, 0, t);
    memcpy(a, t, square * sizeof *a);
    for (size_t i = 0; i < square; i++) h[i] += y[i];
    (void)riccati_even(n, g);
    return riccati_even(n, y) / riccati_even(n, h);
}

/* h <- the cost of the current gains, sum (A_c^T)^k (Q + K^T R K) A_c^k, A_c = A - B K, with
 * scratch `work` of 4 n^2; returns the relative change in the last doubling */
static double riccati_cost(int n, int m, const double a[], const double b[], const double q[],
                           const double r[], const double gains[], double h[], double work[]) {
    size_t square = (size_t)n * (size_t)n;
    double *c = work, *t = c + square, *y = t + square, change = INFINITY;
    pend_product(n, m, n, b, 0, gains, 0, 0, c);
    for (size_t i = 0; i < square; i++) c[i] = a[i] - c[i];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            h[i * n + j] = i == j ? q[i] : 0;
            for (int k = 0; k < m; k++) h[i * n + j] += gains[k * n + i] * r[k] * gains[k * n + j];
        }
    for (int i = 0; i < DOUBLINGS_MOST && change > 0x1p-52; i++) {
        pend_product(n, n, n, h, 0, c, 0, 0, t);
        pend_product(n, n, n, c, 1, t, 0, 0, y);
        for (size_t j = 0; j < square; j++) h[j] += y[j];
        change = riccati_even(n, y) / riccati_even(n, h);
        pend_product(n, n, n, c, 0, c, 0, 0, t);
        memcpy(c, t, square * sizeof *c);
    }
    return change;
}

/* gains for a cost matrix h, with scratch `work` of m (n + m); returns 0 if they are not finite */
static int riccati_gains(struct orbit_algebra *algebra, int n, int m, const double a[],
                         const double b[], const double r[], const double h[], double work[],
                         double gains[]) {
    double *mn = work, *mm = mn + n * m;
    pend_product(m, n, n, b, 1, h, 0, 0, mn);
    pend_product(m, n, n, mn, 0, a, 0, 0, gains);
    pend_product(m, n, m, mn, 0, b, 0, 0, mm);
    for (int i = 0; i < m; i++) mm[i * m + i] += r[i];
    return pend_orbit_solve(algebra, m, mm, n, gains);
}

enum pend_status pend_riccati(int n, int m, const double a[], const double b[], const double q[],
                              const double r[], double gains[]) {
    assert(n >= 1 && m >= 1);
    size_t square = (size_t)n * (size_t)n, few = (size_t)m * (size_t)(n + m);
    struct orbit_algebra *algebra = NULL;
    double *block = calloc(7 * square + few, sizeof *block), change = INFINITY;
    enum pend_status status =
        block ? pend_orbit_algebra_new(&algebra, n > m ? n : m) : PEND_NO_MEMORY;
    if (status != PEND_OK) {
        free(block);
        return status;
    }
    double *now = block, *g = now + square, *h = g + square, *work = h + square;
    double *room = work + 4 * square;
    memcpy(now, a, square * sizeof *a);
    for (int i = 0; i < n; i++) h[i * n + i] = q[i];
    for (int i = 0; i < n * m; i++) room[i] = b[i] / r[i % m];
    pend_product(n, m, n, room, 0, b, 1, 0, g);
    for (int i = 0; i < DOUBLINGS_MOST && change > 0x1p-52; i++)
        change = riccati_double(algebra, n, now, g, h, work);
    int good = change <= 0x1p-52 && riccati_gains(algebra, n, m, a, b, r, h, room, gains) &&
               riccati_cost(n, m, a, b, q, r, gains, h, work) <= 0x1p-52 &&
               riccati_gains(algebra, n, m, a, b, r, h, room, gains);
    pend_orbit_algebra_free(&algebra);
    free(block);
    return good ? PEND_OK : PEND_NO_CONVERGENCE;
}
