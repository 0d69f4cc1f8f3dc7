#include "core/control/loop.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/control/riccati.h"
#include "core/orbits/orbit_algebra.h"

enum { TERMS = 18, SQUARINGS_MOST = 200, GRID = 4000, NEAR = 48, HALVINGS = 60 };
static const double short_step = 0.5; /* norm up to which TERMS terms of the series of e^x
                                       * suffice */
static const double far_loop = 1e8;   /* |L| above which a change of sign is a pole, not a root */
static const double alike = 1e-7;     /* relative to the largest eigenvalue: closer eigenvalues
                                       * count as equal */

static double power_near(double x) { return x > 0 && isfinite(x) ? exp2(round(log2(x))) : 1; }

/* out = e^x, n x n, with a scratch array `work` of 2 n^2 numbers; x is overwritten */
static void exponential(int n, double x[], double work[], double out[]) {
    size_t square = (size_t)n * (size_t)n, bytes = square * sizeof *x;
    double norm = 0, *term = work, *next = work + square;
    int squarings = 0;
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++) sum += fabs(x[i * n + j]);
        norm = fmax(norm, sum);
    }
    for (; norm > short_step && squarings < SQUARINGS_MOST; norm /= 2) squarings++;
    for (size_t i = 0; i < square; i++) {
        x[i] = ldexp(x[i], -squarings);
        out[i] = term[i] = i % ((size_t)n + 1) == 0;
    }
    for (int k = 1; k <= TERMS; k++) {
        pend_product(n, n, n, term, 0, x, 0, 0, next);
        for (size_t i = 0; i < square; i++) out[i] += term[i] = next[i] / k;
    }
    for (; squarings > 0; squarings--) {
        pend_product(n, n, n, out, 0, out, 0, 0, next);
        memcpy(out, next, bytes);
    }
}

/* chooses the units `scale` and sets x = h [F P; 0 0] in them; `part` contains M^-1 K, M^-1 C and
 * M^-1 E */
static void loop_rates(const struct pend_loop *loop, const double part[], double x[]) {
    int n = loop->n, m = loop->inputs, all = 2 * n + m;
    const double *spring = part, *loss = part + n * n, *push = loss + n * n;
    double *d = loop->scale, *e = loop->input_scale, fastest = 0x1p-20 / loop->period;
    for (int i = 0; i < n; i++) d[i] = 1 / power_near(sqrt(loop->mass[i * n + i]));
    for (int i = 0; i < n * n; i++) {
        double ratio = d[i % n] / d[i / n];
        fastest = fmax(fastest, fmax(sqrt(fabs(spring[i]) * ratio), fabs(loss[i]) * ratio));
    }
    fastest = power_near(fastest);
    for (int i = 0; i < n; i++) d[n + i] = d[i] * fastest;
    for (int j = 0; j < m; j++) {
        double most = 0;
        for (int i = 0; i < n; i++)
            most = fmax(most, fabs(push[i * m + j]) * loop->period / d[n + i]);
        e[j] = 1 / power_near(most);
    }
    for (int i = 0; i < n; i++) {
        double *row = x + (n + i) * all;
        x[i * all + n + i] = loop->period * fastest;
        for (int j = 0; j < n; j++) {
            row[j] = -loop->period * spring[i * n + j] * d[j] / d[n + i];
            row[n + j] = -loop->period * loss[i * n + j] * d[j] / d[i];
        }
        for (int j = 0; j < m; j++)
            row[2 * n + j] = loop->period * push[i * m + j] * e[j] / d[n + i];
    }
}

/* sets a and b from the matrix exponential, and the rows that shift delayed outputs */
static enum pend_status loop_hold(const struct pend_loop *loop, const double held[]) {
    int n = 2 * loop->n, m = loop->inputs, rows = loop->rows, all = n + m;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < all; j++) {
            double x = held[i * all + j];
            if (!isfinite(x)) return PEND_NOT_FINITE;
            if (j < n)
                loop->a[i * rows + j] = x;
            else if (loop->delay)
                loop->a[i * rows + rows - all + j] = x;
            else
                loop->b[i * m + j - n] = x;
        }
    for (int i = n; i < rows; i++) {
        loop->scale[i] = loop->input_scale[(i - n) % m];
        if (i < n + m)
            loop->b[i * m + i - n] = 1;
        else
            loop->a[i * rows + i - m] = 1;
    }
    return PEND_OK;
}

static enum pend_status loop_fill(const struct pend_loop *loop, const struct pend_tree *tree,
                                  const struct pend_loads *loads, const double phi[],
                                  const int input[]) {
    int n = loop->n, m = loop->inputs, all = 2 * n + m;
    size_t square = (size_t)n * (size_t)n, wide = (size_t)all * (size_t)all;
    struct orbit_algebra *algebra = NULL;
    double *block = calloc(4 * square + (size_t)(n * m) + 4 * wide, sizeof *block);
    enum pend_status status = block ? pend_orbit_algebra_new(&algebra, n) : PEND_NO_MEMORY;
    if (status == PEND_OK) {
        double *part = block + 2 * square, *x = part + 2 * square + n * m;
        status = pend_damped_matrices(tree, loads, phi, loop->mass, block + square, block);
        for (int j = 0; j < m; j++) {
            int holder = pend_terms_holder(loads->terms, tree->parent, input[j]);
            loop->joint[input[j] * m + j] = 1;
            if (holder >= 0) loop->joint[holder * m + j] = -1;
        }
        for (int i = 0; i < n; i++) loop->inverse[i * n + i] = 1;
        if (status == PEND_OK && !pend_orbit_solve(algebra, n, loop->mass, n, loop->inverse))
            status = PEND_NOT_FINITE;
        pend_product(n, n, n, loop->inverse, 0, block, 0, 0, part);
        pend_product(n, n, n, loop->inverse, 0, block + square, 0, 0, part + square);
        pend_product(n, n, m, loop->inverse, 0, loop->joint, 0, 0, part + 2 * square);
        loop_rates(loop, part, x);
        exponential(all, x, x + wide, x + 3 * wide);
        if (status == PEND_OK) status = loop_hold(loop, x + 3 * wide);
    }
    pend_orbit_algebra_free(&algebra);
    free(block);
    return status;
}

enum pend_status pend_loop_new(struct pend_loop **loop, const struct pend_tree *tree,
                               const struct pend_loads *loads, const double phi[], int inputs,
                               const int input[], double period, int delay) {
    assert(pend_tree_valid(tree) && inputs >= 1 && period > 0 && delay >= 0);
    size_t n = (size_t)tree->n, m = (size_t)inputs, rows = 2 * n + m * (size_t)delay;
    size_t numbers = 2 * n * n + n * m + rows * (rows + m + 1) + m;
    struct pend_loop *made = *loop = calloc(1, sizeof *made + numbers * sizeof(double));
    if (!made) return PEND_NO_MEMORY;
    *made = (struct pend_loop){
        .n = tree->n, .inputs = inputs, .delay = delay, .rows = (int)rows, .period = period};
    made->mass = (double *)(made + 1);
    made->inverse = made->mass + n * n;
    made->joint = made->inverse + n * n;
    made->a = made->joint + n * m;
    made->b = made->a + rows * rows;
    made->scale = made->b + rows * m;
    made->input_scale = made->scale + rows;
    enum pend_status status = loop_fill(made, tree, loads, phi, input);
    if (status != PEND_OK) pend_loop_free(loop);
    return status;
}

void pend_loop_free(struct pend_loop **loop) {
    free(*loop);
    *loop = NULL;
}

enum pend_status pend_loop_gains(const struct pend_loop *loop, const double q[], const double r[],
                                 double gains[]) {
    int rows = loop->rows, m = loop->inputs;
    const double *d = loop->scale, *e = loop->input_scale;
    double *weight = calloc((size_t)(rows + m), sizeof *weight), *cost = weight + rows;
    if (!weight) return PEND_NO_MEMORY;
    for (int i = 0; i < 2 * loop->n; i++) weight[i] = q[i] * d[i] * d[i];
    for (int j = 0; j < m; j++) cost[j] = r[j] * e[j] * e[j];
    enum pend_status status = pend_riccati(rows, m, loop->a, loop->b, weight, cost, gains);
    for (int i = 0; i < m * rows && status == PEND_OK; i++) gains[i] *= e[i / rows] / d[i % rows];
    free(weight);
    return status;
}

enum pend_status pend_loop_multipliers(const struct pend_loop *loop, const double gains[], int open,
                                       double re[], double im[]) {
    int rows = loop->rows, m = loop->inputs;
    struct orbit_algebra *algebra = NULL;
    double *a = malloc((size_t)rows * (size_t)rows * sizeof *a);
    enum pend_status status = a ? pend_orbit_algebra_new(&algebra, rows) : PEND_NO_MEMORY;
    for (int i = 0; i < rows * rows && status == PEND_OK; i++) {
        a[i] = loop->a[i];
        for (int k = 0; k < m; k++)
            if (k != open)
                a[i] -= loop->b[i / rows * m + k] * gains[k * rows + i % rows] *
                        loop->scale[i % rows] / loop->input_scale[k];
    }
    if (status == PEND_OK) status = pend_orbit_eigenvalues(algebra, rows, a, re, im);
    for (int i = 1; i < rows && status == PEND_OK; i++)
        for (int j = i; j > 0 && hypot(re[j], im[j]) > hypot(re[j - 1], im[j - 1]); j--) {
            double x = re[j], y = im[j];
            re[j] = re[j - 1], im[j] = im[j - 1];
            re[j - 1] = x, im[j - 1] = y;
        }
    pend_orbit_algebra_free(&algebra);
    free(a);
    return status;
}

/* ---- margins */

/* the multipliers of the closed loop (re, im), then those of the loop with one actuator open */
struct circle {
    int rows;
    const double *value;
};

/* the loop gain L at an angle on the unit circle */
static double complex circle_at(const struct circle *c, double angle) {
    const double *closed = c->value, *open = c->value + 2 * c->rows;
    double complex z = cexp(I * angle), product = 1;
    for (int i = 0; i < c->rows; i++)
        product *=
            (z - closed[i] - I * closed[c->rows + i]) / (z - open[i] - I * open[c->rows + i]);
    return product - 1;
}

/* a function that changes its sign where L is real (size = 0) or |L| is 1 (size = 1) */
static double circle_sign(const struct circle *c, double angle, int size) {
    double complex at = circle_at(c, angle);
    return size ? cabs(at) - 1 : cimag(at);
}

/* updates the margins at an angle where L is real (size = 0) or |L| is 1 (size = 1) */
static void circle_count(const struct circle *c, double angle, int size, double period,
                         struct pend_margins *margins) {
    double complex at = circle_at(c, angle);
    double factor = -1 / creal(at), lag = fmod(carg(at) + 3 * M_PI, 2 * M_PI);
    if (!(cabs(at) < far_loop)) return;
    if (size) {
        margins->phase = fmin(margins->phase, fmin(lag, 2 * M_PI - lag));
        margins->delay = fmin(margins->delay, lag / angle * period);
    } else if (factor > 1) {
        margins->gain[1] = fmin(margins->gain[1], factor);
    } else if (factor > 0) {
        margins->gain[0] = fmax(margins->gain[0], factor);
    }
}

static int ascending(const void *x, const void *y) {
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

/* angles from 0 to pi at which L is evaluated, dense near every multiplier; returns their number */
static int circle_grid(const struct circle *c, double grid[]) {
    int count = 0;
    for (int i = 0; i <= GRID; i++) grid[count++] = M_PI * i / GRID;
    for (int i = 0; i < 2 * c->rows; i++) {
        const double *re = c->value + (i < c->rows ? i : c->rows + i);
        double angle = fabs(atan2(re[c->rows], *re));
        for (int k = 0; k < 2 * NEAR; k++) {
            double at = angle + (k % 2 ? M_PI : -M_PI) * exp2(-(k / 2));
            if (at > 0 && at < M_PI) grid[count++] = at;
        }
    }
    qsort(grid, (size_t)count, sizeof *grid, ascending);
    return count;
}

static void circle_margins(const struct circle *c, double period, double grid[],
                           struct pend_margins *margins) {
    int count = circle_grid(c, grid);
    *margins = (struct pend_margins){{0, INFINITY}, M_PI, INFINITY};
    circle_count(c, 0, 0, period, margins);
    circle_count(c, M_PI, 0, period, margins);
    for (int i = 1; i < 2 * count; i++) {
        int size = i > count, at = size ? i - count : i;
        if (i == count) continue;
        double low = grid[at - 1], high = grid[at], sign = circle_sign(c, low, size);
        if ((circle_sign(c, high, size) > 0) == (sign > 0)) continue;
        for (int k = 0; k < HALVINGS; k++) {
            double middle = (low + high) / 2;
            *((circle_sign(c, middle, size) > 0) == (sign > 0) ? &low : &high) = middle;
        }
        circle_count(c, (low + high) / 2, size, period, margins);
    }
}

enum pend_status pend_loop_margins(const struct pend_loop *loop, const double gains[], int input,
                                   struct pend_margins *margins) {
    size_t rows = (size_t)loop->rows;
    assert(input >= 0 && input < loop->inputs);
    double *value = malloc((4 * rows + GRID + 1 + 4 * rows * NEAR) * sizeof *value);
    if (!value) return PEND_NO_MEMORY;
    enum pend_status status = pend_loop_multipliers(loop, gains, -1, value, value + rows);
    if (status == PEND_OK)
        status = pend_loop_multipliers(loop, gains, input, value + 2 * rows, value + 3 * rows);
    if (status == PEND_OK)
        circle_margins(&(struct circle){loop->rows, value}, loop->period, value + 4 * rows,
                       margins);
    free(value);
    return status;
}

/* ---- modes */

/* x^T v for mode j, relative to the norm of x in M and of v in M^-1 */
static double complex reach_overlap(const struct pend_loop *loop, const struct pend_damped *modes,
                                    int mode, const double v[], int step) {
    int n = loop->n;
    const double *re = modes->re + mode * n, *im = modes->im + mode * n;
    double complex sum = 0;
    double size = 0, other = 0;
    for (int i = 0; i < n; i++) {
        sum += (re[i] + I * im[i]) * v[i * step];
        for (int j = 0; j < n; j++) {
            size += (re[i] * re[j] + im[i] * im[j]) * loop->mass[i * n + j];
            other += v[i * step] * v[j * step] * loop->inverse[i * n + j];
        }
    }
    return size > 0 && other > 0 ? sum / sqrt(size * other) : 0;
}

enum pend_status pend_loop_reach(const struct pend_loop *loop, const struct pend_damped *modes,
                                 int count, const double vectors[], double reach[]) {
    int all = modes->count;
    double largest = 0;
    double complex *row = malloc((size_t)all * (size_t)count * sizeof *row);
    if (!row) return PEND_NO_MEMORY;
    for (int j = 0; j < all; j++) largest = fmax(largest, hypot(modes->omega[j], modes->decay[j]));
    for (int j = 0; j < all; j++) {
        double complex *own = row + j * count;
        for (int i = 0; i < count; i++) own[i] = reach_overlap(loop, modes, j, vectors + i, count);
        // subtracts the directions that earlier modes of the same eigenvalue reach; the remainder
        // is orthogonal to them
        for (int k = 0; k < j; k++) {
            double complex part = 0, *of = row + k * count;
            if (reach[k] < PEND_LOOP_REACHED ||
                hypot(modes->omega[k] - modes->omega[j], modes->decay[k] - modes->decay[j]) >
                    alike * largest)
                continue;
            for (int i = 0; i < count; i++) part += conj(of[i]) * own[i] / (reach[k] * reach[k]);
            for (int i = 0; i < count; i++) own[i] -= part * of[i];
        }
        double size = 0;
        for (int i = 0; i < count; i++) size += creal(own[i] * conj(own[i]));
        reach[j] = sqrt(size);
    }
    free(row);
    return PEND_OK;
}
