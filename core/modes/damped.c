#include "core/modes/damped.h"

#include <assert.h>
#include <complex.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/linear_arms.h"
#include "core/modes/lossy.h"
#include "core/modes/rest.h"

/* adds sum of w Re(conj(z_j) z_k), with weights w: the form of M, and of drag in C */
static void damped_form(const struct linear_arms *arms, int drag, double out[]) {
    size_t n = (size_t)arms->n;
    for (size_t k = 0; k < n; k++) {
        const struct linear_arm *arm = arms->arm + k;
        const double *moment = drag ? arm->wind : arm->whole;
        out[k * n + k] += drag ? arm->wind_inertia : arm->whole_inertia;
        for (const struct linear_arm *on = arm; on->parent >= 0; on = arms->arm + on->parent) {
            size_t j = (size_t)on->parent;
            double add = on->place[0] * moment[0] + on->place[1] * moment[1];
            out[k * n + j] += add;
            out[j * n + k] += add;
        }
    }
}

/* adds the torque of joint k: `strength` per radian of arm k relative to the arm that holds it */
static void damped_joint(const struct linear_arms *arms, size_t k, double strength, double out[]) {
    size_t n = (size_t)arms->n;
    out[k * n + k] += strength;
    if (arms->arm[k].holder < 0) return;
    size_t p = (size_t)arms->arm[k].holder;
    out[p * n + p] += strength;
    out[k * n + p] -= strength;
    out[p * n + k] -= strength;
}

enum pend_status pend_damped_matrices(const struct pend_tree *tree, const struct pend_loads *loads,
                                      const double phi[], double mass[], double damping[],
                                      double stiffness[]) {
    struct linear_arms arms;
    size_t n = (size_t)tree->n, bytes = n * n * sizeof *mass;
    enum pend_status status = pend_linear_arms_init(&arms, tree, loads, phi);
    memset(mass, 0, bytes);
    memset(damping, 0, bytes);
    memset(stiffness, 0, bytes);
    if (status == PEND_OK) damped_form(&arms, 0, mass);
    for (size_t i = 0; status == PEND_OK && i < n * n; i++)
        damping[i] += 2 * arms.drag_per_mass * mass[i];
    for (size_t k = 0; status == PEND_OK && k < n; k++) {
        stiffness[k * n + k] += arms.arm[k].fall;
        damped_joint(&arms, k, arms.arm[k].spring, stiffness);
        damped_joint(&arms, k, arms.arm[k].damper, damping);
    }
    if (status == PEND_OK) damped_form(&arms, 1, damping);
    pend_linear_arms_clear(&arms);
    return status;
}

/* writes the matrix B or S; arms on a cart turn relative to the ground */
static void damped_paths(const struct pend_tree *tree, const struct pend_loads *loads,
                         enum pend_matrix which, double out[]) {
    size_t n = (size_t)tree->n, cart = (size_t)tree->order[0];
    for (size_t i = 0; i < n; i++) pend_matrix_row(tree, loads, NULL, which, (int)i, out + i * n);
    for (size_t i = 0; i < n && pend_terms_cart(loads->terms); i++)
        if (i != cart) out[i * n + cart] = out[cart * n + i] = 0;
}

enum pend_status pend_damped_matrix(const struct pend_tree *tree, const struct pend_loads *loads,
                                    const double phi[], enum pend_matrix which, double out[]) {
    size_t n = (size_t)tree->n;
    if (which == PEND_MATRIX_S || which == PEND_MATRIX_B) {
        damped_paths(tree, loads, which, out);
        return PEND_OK;
    }
    double *mass = malloc((3 * n + 1) * n * sizeof *mass);
    if (!mass) return PEND_NO_MEMORY;
    double *damping = mass + n * n, *stiffness = damping + n * n, *column = stiffness + n * n;
    const double *from = which == PEND_MATRIX_M   ? mass
                         : which == PEND_MATRIX_C ? damping
                                                  : stiffness;
    enum pend_status status = pend_damped_matrices(tree, loads, phi, mass, damping, stiffness);
    gsl_matrix_view m = gsl_matrix_view_array(mass, n, n);
    gsl_vector_view right = gsl_vector_view_array(column, n);
    if (status == PEND_OK && which == PEND_MATRIX_A && gsl_linalg_cholesky_decomp1(&m.matrix))
        status = PEND_NOT_FINITE;
    for (size_t j = 0; j < n && status == PEND_OK; j++) {
        for (size_t i = 0; i < n; i++) column[i] = from[i * n + j];
        if (which == PEND_MATRIX_A) gsl_linalg_cholesky_svx(&m.matrix, &right.vector);
        for (size_t i = 0; i < n; i++)
            out[(size_t)tree->order[i] * n + (size_t)tree->order[j]] = column[i];
    }
    free(mass);
    return status;
}

void pend_damped_free(struct pend_damped **damped) {
    if (*damped) {
        pend_still_free(&(*damped)->still);
        pend_lossy_free(&(*damped)->lossy);
        free((*damped)->square);
    }
    free(*damped);
    *damped = NULL;
}

static struct pend_damped *damped_alloc(int n) {
    size_t count = 2 * (size_t)n, numbers = (size_t)n + 2 * count + 2 * count * (size_t)n;
    struct pend_damped *made = calloc(1, sizeof *made + numbers * sizeof(double));
    if (!made) return NULL;
    double *at = (double *)(made + 1);
    made->n = n;
    made->phi = at, at += n;
    made->omega = at, at += count;
    made->decay = at, at += count;
    made->re = at, at += count * (size_t)n;
    made->im = at;
    return made;
}

/* the first arm whose angle can normalize a shape; a cart's position only if no arm swings */
static size_t damped_first(const struct pend_damped *damped, const double complex shape[]) {
    if (!damped->loads || !pend_terms_cart(damped->loads->terms)) return 0;
    for (int k = 1; k < damped->n; k++)
        if (cabs(shape[k]) * damped->tree->len[k] > 1e-9 * cabs(shape[0])) return 1;
    return 0;
}

/* adds a mode and normalizes its shape to a largest entry of 1 */
static void damped_add(struct pend_damped *damped, double complex value,
                       const double complex shape[]) {
    size_t n = (size_t)damped->n, row = (size_t)damped->count * n;
    double complex scale = 1;
    double most = 0;
    for (size_t k = damped_first(damped, shape); k < n; k++) {
        if (cabs(shape[k]) <= most * (1 + 1e-9)) continue;
        most = cabs(shape[k]);
        scale = shape[k];
    }
    for (size_t k = 0; k < n; k++) {
        double complex entry = shape[k] / scale;
        damped->re[row + k] = creal(entry);
        damped->im[row + k] = cimag(entry);
    }
    damped->omega[damped->count] = fabs(cimag(value));
    damped->decay[damped->count++] = creal(value);
}

/* no damping: K x = omega^2 M x */
static enum pend_status damped_symmetric(struct pend_damped *damped, double mass[],
                                         double stiffness[]) {
    size_t n = (size_t)damped->n;
    gsl_matrix_view m = gsl_matrix_view_array(mass, n, n);
    gsl_matrix_view k = gsl_matrix_view_array(stiffness, n, n);
    gsl_eigen_gensymmv_workspace *work = gsl_eigen_gensymmv_alloc(n);
    double *block = malloc((n * n + n) * sizeof *block);
    double complex *shape = malloc(n * sizeof *shape);
    enum pend_status status = work && block && shape ? PEND_OK : PEND_NO_MEMORY;
    double *value = block ? block + n * n : NULL, least = 0;
    if (!status) {
        gsl_vector_view values = gsl_vector_view_array(value, n);
        gsl_matrix_view vectors = gsl_matrix_view_array(block, n, n);
        if (gsl_eigen_gensymmv(&k.matrix, &m.matrix, &values.vector, &vectors.matrix, work))
            status = PEND_NOT_FINITE;
    }
    for (size_t j = 0; j < n && !status; j++)
        least = fmax(least, (double)n * 0x1p-52 * fabs(value[j]));
    for (size_t j = 0; j < n && !status; j++) {
        double square = value[j];
        if (fabs(square) <= least) square = 0; // a cart that rolls freely has a mode of frequency 0
        for (size_t i = 0; i < n; i++) shape[i] = block[i * n + j];
        if (square >= 0) {
            damped_add(damped, I * sqrt(square), shape);
            continue;
        }
        damped_add(damped, sqrt(-square), shape);
        damped_add(damped, -sqrt(-square), shape);
    }
    free(shape);
    free(block);
    gsl_eigen_gensymmv_free(work);
    return status;
}

/* the matrix of 2 n rows: x' = v, v' = -M^{-1} (K x + C v) */
static enum pend_status damped_companion(size_t n, double mass[], const double damping[],
                                         const double stiffness[], gsl_matrix *out) {
    gsl_matrix_view m = gsl_matrix_view_array(mass, n, n);
    double *column = malloc(n * sizeof *column);
    if (!column) return PEND_NO_MEMORY;
    gsl_vector_view right = gsl_vector_view_array(column, n);
    enum pend_status status = gsl_linalg_cholesky_decomp1(&m.matrix) ? PEND_NOT_FINITE : PEND_OK;
    gsl_matrix_set_zero(out);
    for (size_t i = 0; i < n; i++) gsl_matrix_set(out, i, n + i, 1);
    for (size_t j = 0; j < 2 * n && !status; j++) {
        const double *from = j < n ? stiffness : damping;
        for (size_t i = 0; i < n; i++) column[i] = -from[i * n + j % n];
        gsl_linalg_cholesky_svx(&m.matrix, &right.vector);
        for (size_t i = 0; i < n; i++) gsl_matrix_set(out, n + i, j, column[i]);
    }
    free(column);
    return status;
}

/* stores the eigenvalues of the companion matrix, one of each complex pair */
static enum pend_status damped_take(struct pend_damped *damped, const gsl_vector_complex *value,
                                    const gsl_matrix_complex *vector) {
    size_t n = (size_t)damped->n;
    double complex *shape = malloc(n * sizeof *shape);
    if (!shape) return PEND_NO_MEMORY;
    for (size_t j = 0; j < 2 * n; j++) {
        gsl_complex z = gsl_vector_complex_get(value, j);
        if (GSL_IMAG(z) < 0) continue;
        for (size_t i = 0; i < n; i++) {
            gsl_complex x = gsl_matrix_complex_get(vector, i, j);
            shape[i] = GSL_REAL(x) + I * GSL_IMAG(x);
        }
        damped_add(damped, GSL_REAL(z) + I * GSL_IMAG(z), shape);
    }
    free(shape);
    return PEND_OK;
}

static enum pend_status damped_general(struct pend_damped *damped, double mass[],
                                       const double damping[], const double stiffness[]) {
    size_t n = (size_t)damped->n, rows = 2 * n;
    gsl_eigen_nonsymmv_workspace *work = gsl_eigen_nonsymmv_alloc(rows);
    double *block = malloc((3 * rows * rows + 2 * rows) * sizeof *block);
    enum pend_status status = work && block ? PEND_OK : PEND_NO_MEMORY;
    if (!status) {
        // balance the matrix, so that units of time and of a cart's position do not matter
        gsl_eigen_nonsymmv_params(1, work);
        gsl_matrix_view matrix = gsl_matrix_view_array(block, rows, rows);
        gsl_matrix_complex_view vector =
            gsl_matrix_complex_view_array(block + rows * rows, rows, rows);
        gsl_vector_complex_view value =
            gsl_vector_complex_view_array(block + 3 * rows * rows, rows);
        status = damped_companion(n, mass, damping, stiffness, &matrix.matrix);
        if (!status && gsl_eigen_nonsymmv(&matrix.matrix, &value.vector, &vector.matrix, work))
            status = PEND_NOT_FINITE;
        if (!status) status = damped_take(damped, &value.vector, &vector.matrix);
    }
    free(block);
    gsl_eigen_nonsymmv_free(work);
    return status;
}

/* true if mode a comes before mode b: growing modes first, then by omega, then by decay */
static int damped_before(const struct pend_damped *d, int a, int b) {
    int grows = d->decay[a] > 0, other = d->decay[b] > 0;
    if (grows != other) return grows;
    if (d->omega[a] != d->omega[b]) return d->omega[a] < d->omega[b];
    return d->decay[a] > d->decay[b];
}

static void damped_swap(double *x, double *y, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double keep = x[i];
        x[i] = y[i];
        y[i] = keep;
    }
}

static void damped_sort(struct pend_damped *d) {
    size_t n = (size_t)d->n;
    for (int i = 0; i < d->count; i++) {
        int first = i;
        for (int j = i + 1; j < d->count; j++)
            if (damped_before(d, j, first)) first = j;
        if (first == i) continue;
        damped_swap(&d->omega[i], &d->omega[first], 1);
        damped_swap(&d->decay[i], &d->decay[first], 1);
        damped_swap(d->re + (size_t)i * n, d->re + (size_t)first * n, n);
        damped_swap(d->im + (size_t)i * n, d->im + (size_t)first * n, n);
    }
}

static enum pend_status damped_solve(struct pend_damped *damped, const struct pend_tree *tree,
                                     const struct pend_loads *loads) {
    size_t square = (size_t)tree->n * (size_t)tree->n;
    double *mass = malloc(3 * square * sizeof *mass);
    if (!mass) return PEND_NO_MEMORY;
    double *damping = mass + square, *stiffness = damping + square;
    int damps = 0;
    enum pend_status status =
        pend_damped_matrices(tree, loads, damped->phi, mass, damping, stiffness);
    for (size_t i = 0; i < square && !status; i++) damps |= damping[i] != 0;
    if (!status)
        status = damps ? damped_general(damped, mass, damping, stiffness)
                       : damped_symmetric(damped, mass, stiffness);
    free(mass);
    if (!status) damped_sort(damped);
    return status;
}

/* copies the modes that were found without a matrix; values within round-off of 0 become 0 */
static enum pend_status damped_take_still(struct pend_damped *damped, const double square[],
                                          const double vector[]) {
    size_t n = (size_t)damped->n;
    double complex *shape = malloc(n * sizeof *shape);
    if (!shape) return PEND_NO_MEMORY;
    double least = (double)n * 0x1p-52 * fmax(fabs(square[0]), fabs(square[n - 1]));
    for (size_t j = 0; j < n; j++) {
        for (size_t k = 0; k < n; k++) shape[k] = vector[j * n + k];
        double size = sqrt(fabs(square[j]));
        if (square[j] >= -least) {
            damped_add(damped, square[j] <= least ? 0 : I * size, shape);
            continue;
        }
        damped_add(damped, size, shape);
        damped_add(damped, -size, shape);
    }
    free(shape);
    damped_sort(damped);
    return PEND_OK;
}

/* continues the search without a matrix, and stores a mode if it found one */
static enum pend_status damped_take_lossy(struct pend_damped *damped, int *done) {
    enum pend_lossy_stage stage = PEND_LOSSY_UNDER_WAY;
    double complex root = 0, *shape = malloc((size_t)damped->n * sizeof *shape);
    if (!shape) return PEND_NO_MEMORY;
    enum pend_status status = pend_lossy_step(damped->lossy, &stage, &root, shape);
    if (status == PEND_OK && stage == PEND_LOSSY_MODE) damped_add(damped, root, shape);
    free(shape);
    *done = stage == PEND_LOSSY_DONE;
    if (*done) damped_sort(damped);
    return status;
}

static enum pend_status damped_failed(struct pend_damped **damped, enum pend_status status,
                                      int arms, struct pend_error *error) {
    pend_damped_free(damped);
    return pend_fail(error, status, -1, 0,
                     status == PEND_NO_MEMORY ? "no memory for the modes of %d arms"
                                              : "the modes of %d arms did not converge",
                     arms);
}

enum pend_status pend_damped_begin(struct pend_damped **damped, const struct pend_tree *tree,
                                   const struct pend_loads *loads, const double phi[],
                                   struct pend_error *error) {
    assert(pend_tree_valid(tree));
    struct pend_damped *made = *damped = damped_alloc(tree->n);
    if (!made) return damped_failed(damped, PEND_NO_MEMORY, tree->n, error);
    made->tree = tree, made->loads = loads;
    memcpy(made->phi, phi, (size_t)tree->n * sizeof *phi);
    enum pend_status status = pend_rest_find(tree, loads, made->phi, NULL, error);
    if (status != PEND_OK) {
        pend_damped_free(damped);
        return status;
    }
    if (pend_loads_lose(loads) && tree->n > PEND_DAMPED_DENSE) {
        status = pend_lossy_new(&made->lossy, tree, loads, made->phi);
        return status == PEND_OK ? PEND_OK : damped_failed(damped, status, tree->n, error);
    }
    if (pend_loads_lose(loads) || tree->n < PEND_DAMPED_TREE) return PEND_OK;
    size_t n = (size_t)tree->n;
    made->square = malloc((n + n * n) * sizeof *made->square);
    status = made->square ? pend_still_new(&made->still, tree, loads, made->phi) : PEND_NO_MEMORY;
    return status == PEND_OK ? PEND_OK : damped_failed(damped, status, tree->n, error);
}

enum pend_status pend_damped_step(struct pend_damped **damped, int *done,
                                  struct pend_error *error) {
    struct pend_damped *d = *damped;
    enum pend_status status = PEND_OK;
    assert(d && (!d->count || d->lossy));
    *done = 1;
    if (d->lossy)
        status = damped_take_lossy(d, done);
    else if (!d->still)
        status = damped_solve(d, d->tree, d->loads);
    else if (!pend_still_step(d->still, d->square, d->square + d->n))
        *done = 0;
    else
        status = damped_take_still(d, d->square, d->square + d->n);
    if (*done && d->still) {
        pend_still_free(&d->still);
        free(d->square);
        d->square = NULL;
    }
    return status == PEND_OK ? PEND_OK : damped_failed(damped, status, d->n, error);
}

enum pend_status pend_damped_new(struct pend_damped **damped, const struct pend_tree *tree,
                                 const struct pend_loads *loads, const double phi[],
                                 struct pend_error *error) {
    int done = 0;
    enum pend_status status = pend_damped_begin(damped, tree, loads, phi, error);
    while (status == PEND_OK && !done) status = pend_damped_step(damped, &done, error);
    return status;
}
