#include "core/modes/modes_vectors.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/hugepage.h"

/* vectors whose eigenvalues have a smaller relative difference are orthogonalized */
#define VECTORS_NEAR 2e-3

/* a vector with more close neighbours is computed in double-double, where only eigenvalues within
 * VECTORS_NEAR_FINE count as close */
enum { VECTORS_CROWD = 16 };
#define VECTORS_NEAR_FINE 1e-11

enum { VECTORS_TRIES = 8 };

/* smaller components along other vectors are not removed */
#define VECTORS_SLIGHT 2e-14

/* number of vectors onto which one call projects */
enum { VECTORS_PIECE = 64 };

/* The state of the orthogonalization of vector `number`, of norm 1. Projections are repeated until
 * no component along the others remains; inverse iteration is repeated if too little of the vector
 * remains. */
struct settling {
    int first; /* the first vector to which this one is orthogonalized */
    int next;  /* the next vector onto which this pass projects */
    int pass, try;
    int due;        /* iterations still to do, because a random start contains every mode */
    double squares; /* the sum of the squares of the components that this pass removed */
    double left;    /* the norm of the vector after projection; 1 if nothing was removed */
};

struct pend_vectors {
    const struct pend_laplacian *laplacian;
    const double *value;
    int lead, count;
    int twisted; /* number of vectors computed by the twisted factorization */
    int number;  /* the number of the current vector */
    struct settling settling;
    int begin;           /* the first vector close to the current one by the wider tolerance */
    int begin_fine;      /* the first vector close to the current one by the narrower tolerance */
    int coarse;          /* first vector from `begin` on not computed in double-double */
    unsigned char *fine; /* for each vector, non-zero if it is computed in double-double */
    double **vector;
    double *tips; /* tip displacements of the last `rows` vectors; vector k is in row k % rows */
    int rows;     /* number of these rows; 0 when no vector has a close neighbour */
    double *load, *pivot; /* n doubles each */
    double *work;         /* scratch of the kernel, at the end of the block */
};

PEND_VALIDATOR vectors_valid(const struct pend_vectors *v) {
    return v->number >= 0 && v->number <= v->count && v->number <= v->twisted &&
           v->begin <= v->number && v->begin_fine <= v->number && v->coarse <= v->number &&
           v->settling.first <= v->settling.next && v->settling.next <= v->number;
}

static int vectors_within(const struct pend_vectors *v, int a, int b, double part) {
    return v->value[b] - v->value[a] <= part * fmax(fabs(v->value[a]), fabs(v->value[b]));
}

/* true if two vectors, the second with the larger eigenvalue, must be orthogonalized */
static int vectors_near(const struct pend_vectors *v, int a, int b) {
    return vectors_within(v, a, b, v->fine[a] && v->fine[b] ? VECTORS_NEAR_FINE : VECTORS_NEAR);
}

/* the first vector to which vector `number` is orthogonalized; call with ascending numbers */
static int vectors_first(struct pend_vectors *v, int number) {
    while (!vectors_within(v, v->begin, number, VECTORS_NEAR)) v->begin++;
    if (!v->fine[number]) return v->begin;
    while (!vectors_within(v, v->begin_fine, number, VECTORS_NEAR_FINE)) v->begin_fine++;
    if (v->coarse < v->begin) v->coarse = v->begin;
    while (v->coarse < number && v->fine[v->coarse]) v->coarse++;
    return v->coarse < v->begin_fine ? v->coarse : v->begin_fine;
}

static double *vectors_tip(const struct pend_vectors *v, int number) {
    assert(v->rows > 0 && number >= 0 && number < v->count);
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

/* subtracts from vector `number` its components along some of the other vectors, and adds up their
 * squares */
static void vectors_project(struct pend_vectors *v) {
    struct settling *s = &v->settling;
    int n = v->laplacian->n, begin = s->next;
    double *x = v->vector[v->number], *tip = vectors_tip(v, v->number), part[VECTORS_PIECE];
    if (begin == s->first)
        for (int k = 0; k < n; k++) v->load[k] = v->laplacian->mass[k] * tip[k];
    s->next = v->number - begin < VECTORS_PIECE ? v->number : begin + VECTORS_PIECE;
    for (int j = begin; j < s->next; j++)
        part[j - begin] =
            vectors_near(v, j, v->number) ? vectors_dot(n, vectors_tip(v, j), v->load) : 0;
    for (int j = begin; j < s->next; j++) {
        const double *other = v->vector[j], *other_tip = vectors_tip(v, j);
        double factor = part[j - begin];
        if (fabs(factor) < VECTORS_SLIGHT) continue;
        s->squares += factor * factor;
        for (int k = 0; k < n; k++) x[k] -= factor * other[k];
        for (int k = 0; k < n; k++) tip[k] -= factor * other_tip[k];
    }
}

/* scales vector `number` to mass norm 1; returns its previous norm */
static double vectors_scale(struct pend_vectors *v, int number) {
    int n = v->laplacian->n;
    double *x = v->vector[number], *tip = vectors_tip(v, number);
    for (int k = 0; k < n; k++) v->load[k] = v->laplacian->mass[k] * tip[k];
    double norm = sqrt(vectors_dot(n, tip, v->load));
    for (int k = 0; k < n; k++) x[k] /= norm;
    for (int k = 0; k < n; k++) tip[k] /= norm;
    return norm;
}

static double vectors_pivot(double t, double spring) {
    return t + spring != 0 ? t + spring : DBL_EPSILON * spring;
}

/* does one step of inverse iteration on vector `number` */
static void vectors_iterate(struct pend_vectors *v, double shift, int number) {
    const struct pend_laplacian *l = v->laplacian;
    double *x = v->vector[number], *tip = vectors_tip(v, number), *load = v->load,
           *pivot = v->pivot;
    /* elimination from the leaves; `pivot` does not contain the node's own spring */
    for (int k = 0; k < l->n; k++) {
        load[k] = l->mass[k] * tip[k];
        pivot[k] = -shift * l->mass[k];
    }
    for (int k = l->n - 1; k > 0; k--) {
        double d = vectors_pivot(pivot[k], l->spring[k]), ratio = l->spring[k] / d;
        pivot[l->parent[k]] += ratio * pivot[k];
        load[l->parent[k]] += ratio * load[k];
    }
    /* from the root outwards; the difference from the parent gives the arm's angle */
    for (int k = 0; k < l->n; k++) {
        double from = k ? tip[l->parent[k]] : 0, d = vectors_pivot(pivot[k], l->spring[k]);
        x[k] = (load[k] - pivot[k] * from) / d / l->len[k];
        tip[k] = (load[k] + l->spring[k] * from) / d;
    }
    /* the orthogonalization needs the tip displacements of the rounded angles */
    for (int k = 0; k < l->n; k++) tip[k] = (k ? tip[l->parent[k]] : 0) + l->len[k] * x[k];
    vectors_scale(v, number);
}

/* a deterministic start for inverse iteration, with a component along every mode */
static void vectors_start(int n, int number, double x[]) {
    unsigned long long state = (unsigned long long)number * 0x9e3779b97f4a7c15ull + 1;
    for (int k = 0; k < n; k++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        x[k] = (double)(state >> 11) * 0x1p-53 - 0.5;
    }
}

/* starts another pass over all close vectors */
static void settling_pass(struct settling *s, int pass) {
    s->pass = pass;
    s->next = s->first;
    s->squares = 0;
}

/* One step of the orthogonalization of vector `number`; returns true once its residual is
 * round-off. A pass that lost digits is repeated; if little of the vector remains, so is inverse
 * iteration. */
static int vectors_settle(struct pend_vectors *v, enum pend_status *status) {
    struct settling *s = &v->settling;
    vectors_project(v);
    if (s->next < v->number) return 0;
    if (s->squares > 1e-15) s->left *= vectors_scale(v, v->number);
    if (!(s->squares < 1e-10) && s->pass < 2) {
        settling_pass(s, s->pass + 1);
        return 0;
    }
    if (s->left > 0.3 && s->due <= 0) return 1;
    if (s->try == VECTORS_TRIES) {
        if (!(s->left > 1e-3)) *status = PEND_NO_CONVERGENCE;
        return 1;
    }
    /* the vector was parallel to the others, so inverse iteration starts again */
    if (s->try == 0 && !(s->left > 1e-6)) {
        vectors_start(v->laplacian->n, v->number, vectors_tip(v, v->number));
        s->due = 2;
    }
    vectors_iterate(v, v->value[v->number], v->number);
    s->try++;
    s->due--;
    s->left = 1;
    settling_pass(s, 0);
    return 0;
}

/* Vectors begin .. begin + lanes - 1 by twisted factorization. Tip displacements are stored only
 * for vectors with close neighbours by the wider tolerance: two adjacent double-double vectors may
 * be close to a third vector although not to each other. */
static void vectors_twist(struct pend_vectors *v, int begin) {
    const struct pend_modes_kernel *kernel = PEND_ISA_PICK(pend_modes_kernel, pend_isa_best());
    int count = v->count;
    double shift[16], *target[16], *tip[16];
    assert(kernel->lanes <= 16);
    int tips = 0;
    for (int i = 0; i < kernel->lanes; i++) {
        int number = begin + i, last = number >= count;
        shift[i] = v->value[last ? count - 1 : number];
        target[i] = last ? v->load : v->vector[number];
        tip[i] = last || !v->rows ? v->pivot : vectors_tip(v, number);
        if (!last) tips |= number > 0 && vectors_within(v, number - 1, number, VECTORS_NEAR);
        if (!last)
            tips |= number < count - 1 && vectors_within(v, number, number + 1, VECTORS_NEAR);
    }
    if (v->fine[begin])
        kernel->fine(v->laplacian, shift, v->lead, v->work, target, tips ? tip : NULL);
    else
        kernel->vectors(v->laplacian, shift, v->lead, v->work, target, tips ? tip : NULL);
}

/* Marks the vectors to compute in double-double: all vectors of a group with a crowded one. Returns
 * true if there are any. */
static int vectors_crowds(struct pend_vectors *v, int lanes) {
    int any = 0;
    for (int number = 0, low = 0, high = 0; number < v->count; number++) {
        while (!vectors_within(v, low, number, VECTORS_NEAR)) low++;
        while (high < v->count && vectors_within(v, number, high, VECTORS_NEAR)) high++;
        if (high - low <= VECTORS_CROWD) continue;
        any = 1;
        for (int i = number / lanes * lanes; i < v->count && i < (number / lanes + 1) * lanes; i++)
            v->fine[i] = 1;
    }
    return any;
}

/* the largest number of vectors from the first of an orthogonalization to the vector itself */
static int vectors_window(struct pend_vectors *v) {
    int window = 0;
    for (int number = 1; number < v->count; number++) {
        int first = vectors_first(v, number);
        if (number - first > window) window = number - first;
    }
    v->begin = v->begin_fine = v->coarse = 0;
    return window;
}

enum pend_status pend_vectors_new(struct pend_vectors **vectors,
                                  const struct pend_laplacian *laplacian, int count,
                                  const double value[], int lead, double *vector[]) {
    assert(pend_laplacian_valid(laplacian));
    assert(count >= 1 && count <= laplacian->n && lead >= 0 && lead < laplacian->n);
    int lanes = PEND_ISA_PICK(pend_modes_kernel, pend_isa_best())->lanes;
    size_t n = (size_t)laplacian->n;
    struct pend_vectors *v = *vectors = calloc(1, sizeof *v + (size_t)count);
    if (!v) return PEND_NO_MEMORY;
    *v = (struct pend_vectors){
        .laplacian = laplacian, .value = value, .lead = lead, .count = count, .vector = vector};
    v->fine = (unsigned char *)(v + 1);
    int arrays = (vectors_crowds(v, lanes) ? 6 : 3) * lanes, window = vectors_window(v);
    if (window) v->rows = window + lanes;
    v->work = pend_hugepage((size_t)(arrays + v->rows + 2) * n * sizeof *v->work);
    if (!v->work) {
        pend_vectors_free(vectors);
        return PEND_NO_MEMORY;
    }
    v->load = v->work + (size_t)arrays * n;
    v->pivot = v->load + n;
    v->tips = v->pivot + n;
    return PEND_OK;
}

static void vectors_next(struct pend_vectors *v) {
    if (++v->number == v->count) return;
    v->settling = (struct settling){.first = vectors_first(v, v->number), .left = 1};
    settling_pass(&v->settling, 0);
}

enum pend_status pend_vectors_step(struct pend_vectors *v, int *done) {
    enum pend_status status = PEND_OK;
    assert(vectors_valid(v));
    if (v->number < v->count && v->number == v->twisted) {
        vectors_twist(v, v->number);
        v->twisted += PEND_ISA_PICK(pend_modes_kernel, pend_isa_best())->lanes;
    } else if (v->number < v->count && vectors_settle(v, &status)) {
        vectors_next(v);
    }
    /* vectors without close neighbours are complete */
    while (v->number < v->count && v->number < v->twisted && v->settling.first == v->number)
        vectors_next(v);
    *done = v->number == v->count;
    assert(vectors_valid(v));
    return status;
}

void pend_vectors_free(struct pend_vectors **vectors) {
    if (*vectors) free((*vectors)->work);
    free(*vectors);
    *vectors = NULL;
}
