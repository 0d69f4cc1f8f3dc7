#include "core/control/riccati.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_algebra.h"
#include "core/tree/turns.h"

enum { DOUBLINGS_MOST = 60, ROUNDS_MOST = 8 };

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

/* A system and its gains in 32 digits; arrays of n x n, of b n x m, of g and u m x n. */
struct exact {
    int n, m;
    const double *q, *r;
    struct pend_sum *a, *b, *x, *c, *e, *t, *g, *u, *s; /* x the cost, g = -K, c = A + B g */
};

static void exact_add(struct pend_sum *sum, struct pend_sum x, struct pend_sum y) {
    double p = x.high * y.high, low = fma(x.high, y.high, -p) + (x.high * y.low + x.low * y.high);
    double s = sum->high + p, part = s - sum->high;
    low += (sum->high - (s - part)) + (p - part) + sum->low;
    sum->high = s + low, part = sum->high - s;
    sum->low = (s - (sum->high - part)) + (low - part);
}

/* out (n x m) += op(a) b */
static void exact_product(int n, int k, int m, const struct pend_sum a[], int ta,
                          const struct pend_sum b[], struct pend_sum out[]) {
    for (int i = 0; i < n; i++)
        for (int l = 0; l < k; l++)
            for (int j = 0; j < m; j++)
                exact_add(&out[i * m + j], a[ta ? l * n + i : i * k + l], b[l * m + j]);
}

static void exact_clear(struct pend_sum x[], int count) { memset(x, 0, (size_t)count * sizeof *x); }

/* e <- Q + K^T R K + c^T x c - x, the residual of the cost of the gains */
static void exact_residual(const struct exact *e) {
    int n = e->n, m = e->m;
    exact_clear(e->e, n * n);
    exact_clear(e->t, n * n);
    exact_clear(e->u, m * n);
    for (int i = 0; i < n; i++) e->e[i * n + i].high = e->q[i];
    for (int i = 0; i < m * n; i++) exact_add(&e->u[i], (struct pend_sum){e->r[i / n], 0}, e->g[i]);
    exact_product(n, m, n, e->g, 1, e->u, e->e);
    exact_product(n, n, n, e->x, 0, e->c, e->t);
    exact_product(n, n, n, e->c, 1, e->t, e->e);
    for (int i = 0; i < n * n; i++) exact_add(&e->e[i], (struct pend_sum){-1, 0}, e->x[i]);
}

/* h <- sum (c^T)^k h c^k, with scratch `work` of 2 n^2; c is changed; returns 0 if the sum does not
 * converge */
static int riccati_sum(int n, double c[], double h[], double work[]) {
    double *t = work, *y = work + n * n, change = INFINITY;
    for (int i = 0; i < DOUBLINGS_MOST && change > 0x1p-52; i++) {
        pend_product(n, n, n, h, 0, c, 0, 0, t);
        pend_product(n, n, n, c, 1, t, 0, 0, y);
        for (int j = 0; j < n * n; j++) h[j] += y[j];
        double sum = riccati_even(n, h);
        change = sum > 0 ? riccati_even(n, y) / sum : 0;
        pend_product(n, n, n, c, 0, c, 0, 0, t);
        memcpy(c, t, (size_t)(n * n) * sizeof *c);
    }
    return change <= 0x1p-52;
}

/* x <- the cost of the gains: its sum in doubles, and that of the residual until it is small, with
 * scratch `work` of 4 n^2; returns 0 if it is infinite */
static int exact_cost(const struct exact *e, double work[]) {
    int n = e->n, square = n * n;
    double *c = work, *h = work + square, rest = INFINITY;
    memcpy(e->c, e->a, (size_t)square * sizeof *e->c);
    exact_product(n, e->m, n, e->b, 0, e->g, e->c);
    exact_clear(e->x, square);
    for (int round = 0; round < ROUNDS_MOST && rest > 0x1p-80; round++) {
        double most = 0;
        exact_residual(e);
        for (int i = 0; i < square; i++) h[i] = e->e[i].high, c[i] = e->c[i].high;
        if (!riccati_sum(n, c, h, work + 2 * square)) return 0;
        for (int i = 0; i < square; i++) {
            exact_add(&e->x[i], (struct pend_sum){1, 0}, (struct pend_sum){h[i], 0});
            most = fmax(most, fabs(e->x[i].high));
        }
        rest = riccati_even(n, h) / most;
    }
    return 1;
}

/* g <- -(R + B^T x B)^-1 B^T x A, with scratch `work` of m (n + m); returns 0 if they are not
 * finite */
static int exact_gains(const struct exact *e, struct orbit_algebra *algebra, double work[]) {
    int n = e->n, m = e->m, good = 1;
    double *step = work, *matrix = work + m * n;
    exact_clear(e->u, m * n);
    exact_clear(e->t, m * n);
    exact_clear(e->s, m * m);
    exact_product(m, n, n, e->b, 1, e->x, e->u);
    exact_product(m, n, n, e->u, 0, e->a, e->t);
    exact_product(m, n, m, e->u, 0, e->b, e->s);
    for (int i = 0; i < m; i++)
        exact_add(&e->s[i * m + i], (struct pend_sum){e->r[i], 0}, (struct pend_sum){1, 0});
    for (int i = 0; i < m * m; i++) matrix[i] = e->s[i].high;
    exact_clear(e->g, m * n);
    for (int round = 0; round < 3 && good; round++) {
        memcpy(e->u, e->t, (size_t)(m * n) * sizeof *e->u);
        exact_product(m, m, n, e->s, 0, e->g, e->u);
        for (int i = 0; i < m * n; i++) step[i] = e->u[i].high;
        good = pend_orbit_solve(algebra, m, matrix, n, step);
        for (int i = 0; i < m * n; i++)
            exact_add(&e->g[i], (struct pend_sum){-1, 0}, (struct pend_sum){step[i], 0});
    }
    return good;
}

/* places the arrays of sums in memory of 5 n^2 + 3 m n + m^2, and copies the system */
static void exact_init(struct exact *e, const double a[], const double b[], const double h[],
                       struct pend_sum *memory) {
    int n = e->n, m = e->m, square = n * n, wide = n > m ? square : m * n;
    e->a = memory, e->x = e->a + square, e->c = e->x + square, e->e = e->c + square;
    e->t = e->e + square, e->b = e->t + wide, e->g = e->b + m * n, e->u = e->g + m * n;
    e->s = e->u + m * n;
    for (int i = 0; i < square; i++) e->a[i].high = a[i], e->x[i].high = h[i];
    for (int i = 0; i < m * n; i++) e->b[i].high = b[i];
}

/* h <- the limit of the doubling, in `block` of 7 n^2 + n m, whose third matrix is h; returns 0 if
 * there is none */
static int riccati_limit(struct orbit_algebra *algebra, const struct exact *e, const double a[],
                         const double b[], double block[]) {
    int n = e->n, m = e->m;
    double *g = block + n * n, *h = g + n * n, *work = h + n * n, *room = work + 4 * n * n,
           change = INFINITY;
    memcpy(block, a, (size_t)(n * n) * sizeof *a);
    for (int i = 0; i < n; i++) h[i * n + i] = e->q[i];
    for (int i = 0; i < n * m; i++) room[i] = b[i] / e->r[i % m];
    pend_product(n, m, n, room, 0, b, 1, 0, g);
    for (int i = 0; i < DOUBLINGS_MOST && change > 0x1p-52; i++)
        change = riccati_double(algebra, n, block, g, h, work);
    return change <= 0x1p-52;
}

enum pend_status pend_riccati(int n, int m, const double a[], const double b[], const double q[],
                              const double r[], double gains[]) {
    assert(n >= 1 && m >= 1);
    size_t square = (size_t)n * (size_t)n, few = (size_t)m * (size_t)(n + m);
    struct orbit_algebra *algebra = NULL;
    struct exact exact = {.n = n, .m = m, .q = q, .r = r};
    double *block = calloc(7 * square + few, sizeof *block), *work = block + 3 * square;
    struct pend_sum *sums = calloc(5 * square + 4 * few, sizeof *sums);
    enum pend_status status =
        block && sums ? pend_orbit_algebra_new(&algebra, n > m ? n : m) : PEND_NO_MEMORY;
    if (status == PEND_OK) {
        int good = riccati_limit(algebra, &exact, a, b, block);
        exact_init(&exact, a, b, block + 2 * square, sums);
        good = good && exact_gains(&exact, algebra, work);
        for (int i = 0; i < 2; i++)
            good = good && exact_cost(&exact, work) && exact_gains(&exact, algebra, work);
        for (int i = 0; i < m * n; i++) gains[i] = -exact.g[i].high;
        status = good ? PEND_OK : PEND_NO_CONVERGENCE;
    }
    pend_orbit_algebra_free(&algebra);
    free(block);
    free(sums);
    return status;
}
