#include "core/modes_vectors.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes_room.h"

/* eigenvalues nearer to each other than this, relatively, have their vectors made orthogonal */
#define VECTORS_NEAR 2e-3

enum { VECTORS_TRIES = 8 };

/* parts smaller than this are left in */
#define VECTORS_SLIGHT 2e-14

struct vectors {
    const struct pend_laplacian *laplacian;
    const double *value;
    int lead;
    double **vector;
    double *tips;         /* tip displacements of the last `rows` vectors, vector k in row k % rows */
    int rows;             /* 0 when no vector has a near neighbour */
    double *load, *pivot; /* n doubles each */
    double *work;         /* for the kernel */
};

static double *vectors_tip(const struct vectors *v, int number) {
    return v->tips + (size_t)(number % v->rows) * (size_t)v->laplacian->n;
}

static double vectors_dot(int n, const double a[], const double b[]) {
    double total = 0, sum[8];
    for (int begin = 0; begin < n; begin += 512) {
        int end = n - begin < 512 ? n : begin + 512, k = begin;
        memset(sum, 0, sizeof sum);
        for (; k + 8 <= end; k += 8)
            for (int i = 0; i < 8; i++) sum[i] += a[k + i] * b[k + i];
        for (; k < end; k++) sum[0] += a[k] * b[k];
        total += ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
    }
    return total;
}

/* takes the parts along the vectors first .. number - 1 out of vector `number`; returns the sum of their squares */
static double vectors_project(struct vectors *v, int first, int number) {
    int n = v->laplacian->n;
    double *x = v->vector[number], *tip = vectors_tip(v, number), squares = 0;
    for (int k = 0; k < n; k++) v->load[k] = v->laplacian->mass[k] * tip[k];
    for (int begin = first; begin < number; begin += 64) {
        double part[64];
        int end = number - begin < 64 ? number : begin + 64;
        for (int j = begin; j < end; j++) part[j - begin] = vectors_dot(n, vectors_tip(v, j), v->load);
        for (int j = begin; j < end; j++) {
            const double *other = v->vector[j], *other_tip = vectors_tip(v, j);
            double factor = part[j - begin];
            if (fabs(factor) < VECTORS_SLIGHT) continue;
            squares += factor * factor;
            for (int k = 0; k < n; k++) x[k] -= factor * other[k];
            for (int k = 0; k < n; k++) tip[k] -= factor * other_tip[k];
        }
    }
    return squares;
}

/* scales vector `number` to mass norm 1; returns the norm it had */
static double vectors_scale(struct vectors *v, int number) {
    int n = v->laplacian->n;
    double *x = v->vector[number], *tip = vectors_tip(v, number);
    for (int k = 0; k < n; k++) v->load[k] = v->laplacian->mass[k] * tip[k];
    double norm = sqrt(vectors_dot(n, tip, v->load));
    for (int k = 0; k < n; k++) x[k] /= norm;
    for (int k = 0; k < n; k++) tip[k] /= norm;
    return norm;
}

/* Makes vector `number`, of norm 1, orthogonal to first .. number - 1, again where the first time cost digits; returns
 * how much of it was left, 1 when all. */
static double vectors_orthogonalize(struct vectors *v, int first, int number) {
    double left = 1;
    for (int pass = 0; pass < 3; pass++) {
        double squares = vectors_project(v, first, number);
        if (squares > 1e-15) left *= vectors_scale(v, number);
        if (squares < 1e-10) break;
    }
    return left;
}

/* a pivot that vanished becomes round-off */
static double vectors_pivot(double t, double spring) { return t + spring != 0 ? t + spring : DBL_EPSILON * spring; }

/* one step of inverse iteration on vector `number` */
static void vectors_iterate(struct vectors *v, double shift, int number) {
    const struct pend_laplacian *l = v->laplacian;
    double *x = v->vector[number], *tip = vectors_tip(v, number), *load = v->load, *pivot = v->pivot;
    /* elimination inwards; pivot: without the node's own spring */
    for (int k = 0; k < l->n; k++) {
        load[k] = l->mass[k] * tip[k];
        pivot[k] = -shift * l->mass[k];
    }
    for (int k = l->n - 1; k > 0; k--) {
        double d = vectors_pivot(pivot[k], l->spring[k]), ratio = l->spring[k] / d;
        pivot[l->parent[k]] += ratio * pivot[k];
        load[l->parent[k]] += ratio * load[k];
    }
    /* outwards; the difference to the parent's displacement is what the arm turns by */
    for (int k = 0; k < l->n; k++) {
        double from = k ? tip[l->parent[k]] : 0, d = vectors_pivot(pivot[k], l->spring[k]);
        x[k] = (load[k] - pivot[k] * from) / d / l->len[k];
        tip[k] = (load[k] + l->spring[k] * from) / d;
    }
    vectors_scale(v, number);
}

/* a start for inverse iteration that no symmetry is blind to; the same numbers every time */
static void vectors_start(int n, int number, double x[]) {
    unsigned long long state = (unsigned long long)number * 0x9e3779b97f4a7c15ull + 1;
    for (int k = 0; k < n; k++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        x[k] = (double)(state >> 11) * 0x1p-53 - 0.5;
    }
}

/* true when the vectors of two numbers, in ascending order, are to be made orthogonal */
static int vectors_near(const struct vectors *v, int a, int b) {
    return v->value[b] - v->value[a] <= VECTORS_NEAR * fmax(fabs(v->value[a]), fabs(v->value[b]));
}

/* the first of the vectors that vector `number` is to be made orthogonal to, not before `first` */
static int vectors_first(const struct vectors *v, int number, int first) {
    while (!vectors_near(v, first, number)) first++;
    return first;
}

/* makes one vector orthogonal to its neighbours, with a residual of round-off */
static int vectors_settle(struct vectors *v, int first, int number) {
    double left = vectors_orthogonalize(v, first, number);
    for (int try = 0; !(left > 0.3); try++) {
        if (try == VECTORS_TRIES) return left > 1e-3;
        /* parallel to the others: begin anew */
        if (try == 0 && !(left > 1e-6)) vectors_start(v->laplacian->n, number, vectors_tip(v, number));
        vectors_iterate(v, v->value[number], number);
        left = vectors_orthogonalize(v, first, number);
    }
    return 1;
}

/* vectors begin .. begin + lanes - 1 by twisted factorization; tip displacements only where a vector has neighbours */
static void vectors_twist(struct vectors *v, int count, int begin) {
    const struct pend_modes_kernel *kernel = pend_modes_kernel();
    double shift[16], *target[16], *tip[16];
    int tips = 0;
    for (int i = 0; i < kernel->lanes; i++) {
        int number = begin + i, last = number >= count;
        shift[i] = v->value[last ? count - 1 : number];
        target[i] = last ? v->load : v->vector[number];
        tip[i] = last || !v->rows ? v->pivot : vectors_tip(v, number);
        if (!last) tips |= number > 0 && vectors_near(v, number - 1, number);
        if (!last) tips |= number < count - 1 && vectors_near(v, number, number + 1);
    }
    kernel->vectors(v->laplacian, shift, v->lead, v->work, target, tips ? tip : NULL);
}

/* the largest number of vectors that one is to be made orthogonal to */
static int vectors_window(const struct vectors *v, int count) {
    int window = 0;
    for (int number = 1, first = 0; number < count; number++) {
        first = vectors_first(v, number, first);
        if (number - first > window) window = number - first;
    }
    return window;
}

enum pend_status pend_modes_vectors(const struct pend_laplacian *laplacian, int count, const double value[], int lead,
                                    double *vector[]) {
    int lanes = pend_modes_kernel()->lanes;
    size_t n = (size_t)laplacian->n;
    struct vectors v = {.laplacian = laplacian, .value = value, .lead = lead, .vector = vector};
    int window = vectors_window(&v, count);
    if (window) v.rows = window + lanes;
    double *work = pend_modes_room((size_t)(3 * lanes + v.rows + 2) * n * sizeof *work);
    if (!work) return PEND_NO_MEMORY;
    v.work = work;
    v.load = work + 3 * (size_t)lanes * n;
    v.pivot = v.load + n;
    v.tips = v.pivot + n;
    enum pend_status status = PEND_OK;
    for (int begin = 0, first = 0; begin < count; begin += lanes) {
        vectors_twist(&v, count, begin);
        for (int number = begin; number < begin + lanes && number < count; number++) {
            first = vectors_first(&v, number, first);
            if (first < number && !vectors_settle(&v, first, number)) status = PEND_NO_CONVERGENCE;
        }
    }
    free(work);
    return status;
}
