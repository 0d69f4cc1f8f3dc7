#include "core/orbits/orbit_floquet.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/orbits/orbit_constants.h"

static size_t floquet_numbers(size_t n) { return 8 * n + 8 * n * n; }

double pend_orbit_floquet_bytes(int n) {
    return sizeof(double) * (double)floquet_numbers((size_t)n);
}

enum pend_status pend_orbit_floquet_init(struct orbit_floquet *floquet, int n) {
    assert(n >= 1);
    size_t rows = (size_t)n;
    *floquet = (struct orbit_floquet){.n = n};
    double *at = floquet->block = calloc(floquet_numbers(rows), sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    floquet->re = at, at += 2 * rows;
    floquet->im = at, at += 2 * rows;
    floquet->part_re = at, at += 2 * rows;
    floquet->part_im = at, at += 2 * rows;
    floquet->work = at;
    return PEND_OK;
}

void pend_orbit_floquet_clear(struct orbit_floquet *floquet) {
    free(floquet->block);
    *floquet = (struct orbit_floquet){.n = 0};
}

/* counts multipliers beyond the boundaries, and computes the tests for crossings */
static void floquet_tell(struct orbit_floquet *f, int count, int driven) {
    assert(count >= 0);
    double border = driven ? floquet_driven : orbits_exact;
    f->outside = 0;
    for (int i = 0; i < ORBIT_REAL; i++) f->beyond[i] = f->surely[i] = 0, f->test[i] = 1;
    for (int i = 0; i < count; i++) {
        double re = f->part_re[i], im = f->part_im[i];
        double complex z = re + I * im;
        int pair = fabs(im) > floquet_driven;
        f->test[ORBIT_PLUS] *= pair ? cabs(z - 1) : re - 1;
        f->test[ORBIT_MINUS] *= pair ? cabs(z + 1) : re + 1;
        if (pair) {
            f->outside += !driven || cabs(z) > 1 + border;
            continue;
        }
        f->beyond[ORBIT_PLUS] += re > 1, f->surely[ORBIT_PLUS] += re > 1 + border;
        f->beyond[ORBIT_MINUS] += re < -1, f->surely[ORBIT_MINUS] += re < -1 - border;
    }
    f->stable = !f->outside && !f->surely[ORBIT_PLUS] && !f->surely[ORBIT_MINUS], f->growth = 1;
    for (int j = 0; j < 2 * f->n; j++) f->growth = fmax(f->growth, hypot(f->re[j], f->im[j]));
}

/* computes x and 1 / x from their mean k; multipliers of a half period are squared */
static void floquet_pair(struct orbit_floquet *f, int pair, double complex k, int squared) {
    double complex root = csqrt(k - 1) * csqrt(k + 1), x = k + root;
    if (cabs(x) < 1) x = k - root;
    double complex y = 1 / x;
    if (cimag(k) == 0 && fabs(creal(k)) <= 1) {
        x = creal(k) + I * sqrt((1 - creal(k)) * (1 + creal(k)));
        y = conj(x);
    }
    if (squared) x *= x, y *= y;
    f->re[2 * pair] = creal(x), f->im[2 * pair] = cimag(x);
    f->re[2 * pair + 1] = creal(y), f->im[2 * pair + 1] = cimag(y);
}

static enum pend_status floquet_mirrored(struct orbit_floquet *f, struct orbit_newton *newton) {
    const struct orbit_map *map = &newton->map;
    int quarter = newton->form.kind == ORBIT_QUARTER;
    assert(map->count == 2 * f->n);
    PEND_TRY(pend_orbit_mirrored(newton->algebra, f->n, map->phi_by, map->rate_by, map->energy_by,
                                 newton->form.omega, f->work, f->part_re, f->part_im));
    // the half period maps the orbit to its mirror image, so that the neutral multiplier is -1
    for (int i = 0; i < f->n - 1; i++) {
        if (quarter) f->part_re[i] = -f->part_re[i], f->part_im[i] = -f->part_im[i];
        double im = fabs(f->part_im[i]) > floquet_driven ? f->part_im[i] : 0;
        floquet_pair(f, i, f->part_re[i] + I * im, quarter);
    }
    f->re[2 * f->n - 2] = f->re[2 * f->n - 1] = 1;
    f->im[2 * f->n - 2] = f->im[2 * f->n - 1] = 0;
    floquet_tell(f, f->n - 1, 0);
    return PEND_OK;
}

/* the derivative of a motion with respect to its start, times `side`; rates in units of omega */
static void floquet_matrix(const struct orbit_floquet *f, const struct orbit_newton *newton,
                           double side, double matrix[]) {
    int n = f->n, q = newton->map.count;
    double omega = newton->form.omega;
    assert(q >= 2 * n);
    for (int k = 0; k < n; k++)
        for (int j = 0; j < 2 * n; j++) {
            double unit = side * (j < n ? 1 : omega);
            matrix[k * 2 * n + j] = newton->map.phi_by[k * q + j] * unit;
            matrix[(n + k) * 2 * n + j] = newton->map.rate_by[k * q + j] * unit / omega;
        }
}

static enum pend_status floquet_free_at(struct orbit_floquet *f, struct orbit_newton *newton) {
    const struct orbit_map *map = &newton->map;
    size_t n = (size_t)f->n, all = 2 * n;
    int mirrored = newton->form.mirrored;
    double omega = newton->form.omega, *matrix = f->work, *energy = matrix + all * all;
    double *flow = energy + all, *v = flow + all;
    floquet_matrix(f, newton, mirrored ? -1 : 1, matrix);
    for (size_t k = 0; k < n; k++) {
        energy[k] = map->energy_by[k], energy[n + k] = map->energy_by[n + k] * omega;
        flow[k] = map->rate[k], flow[n + k] = map->acc[k] / omega;
    }
    PEND_TRY(pend_orbit_kept(newton->algebra, 2 * f->n, matrix, energy, flow, v, f->part_re,
                             f->part_im));
    for (size_t j = 0; j < all; j++) {
        double complex x = j < all - 2 ? f->part_re[j] + I * f->part_im[j] : 1;
        if (mirrored) x *= x;
        f->re[j] = creal(x), f->im[j] = cimag(x);
    }
    floquet_tell(f, 2 * f->n - 2, 1);
    return PEND_OK;
}

enum pend_status pend_orbit_floquet_at(struct orbit_floquet *floquet, struct orbit_newton *newton) {
    int n = 2 * floquet->n;
    assert(floquet->n == newton->form.n && newton->complete);
    switch (newton->form.kind) {
    case ORBIT_DRIVEN:
        floquet_matrix(floquet, newton, 1, floquet->work);
        PEND_TRY(
            pend_orbit_eigenvalues(newton->algebra, n, floquet->work, floquet->re, floquet->im));
        memcpy(floquet->part_re, floquet->re, (size_t)n * sizeof(double));
        memcpy(floquet->part_im, floquet->im, (size_t)n * sizeof(double));
        floquet_tell(floquet, n, 1);
        return PEND_OK;
    case ORBIT_FREE:
        return floquet_free_at(floquet, newton);
    case ORBIT_QUARTER:
    case ORBIT_HALF:
        break;
    }
    return floquet_mirrored(floquet, newton);
}

enum pend_status pend_orbit_floquet_half(struct orbit_floquet *floquet,
                                         const struct orbit_newton *newton, int *breaks) {
    double odd = INFINITY, even = INFINITY;
    assert(newton->look && newton->form.kind == ORBIT_DRIVEN);
    floquet_matrix(floquet, newton, -1, floquet->work);
    PEND_TRY(pend_orbit_eigenvalues(newton->algebra, 2 * floquet->n, floquet->work,
                                    floquet->part_re, floquet->part_im));
    for (int i = 0; i < 2 * floquet->n; i++) {
        odd = fmin(odd, hypot(floquet->part_re[i] + 1, floquet->part_im[i]));
        even = fmin(even, hypot(floquet->part_re[i] - 1, floquet->part_im[i]));
    }
    *breaks = odd < even;
    return PEND_OK;
}
