#include "core/modes/modes_spectrum.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { SPECTRUM_SHIFTS = 16, SPECTRUM_ROUNDS = 14 };

/* (rad/s)^2, limits of squared frequencies: beyond them, sums and quotients of the sweeps would
 * overflow or lose digits */
#define SPECTRUM_LEAST 1e-300
#define SPECTRUM_MOST 1e300

/* N/m, the weakest spring: an elimination pivot may be smaller by 2^110, and its inverse must be
 * finite */
#define SPECTRUM_WEAKEST 1e-270

PEND_VALIDATOR spectrum_valid(const struct pend_spectrum *spectrum) {
    const struct pend_search *s = &spectrum->search;
    return spectrum->negative >= 0 && spectrum->negative <= spectrum->n && s->done >= 0 &&
           s->done <= 2 && s->split >= 0 && s->split <= s->count &&
           pend_symmetry_valid(spectrum->symmetry);
}

enum pend_status pend_spectrum_new(struct pend_spectrum **spectrum, const struct pend_tree *tree,
                                   const struct pend_loads *loads, const unsigned char up[]) {
    enum pend_status status = PEND_NO_MEMORY;
    struct pend_spectrum *s = *spectrum = calloc(1, sizeof *s);
    if (!s) return PEND_NO_MEMORY;
    s->n = tree->n;
    s->lead = tree->place[0];
    s->place = malloc((size_t)tree->n * sizeof *s->place);
    if (!s->place || pend_symmetry_new(&s->symmetry, tree, up)) goto out;
    s->part = calloc((size_t)s->symmetry->part_count, sizeof *s->part);
    if (!s->part) goto out;
    s->least = INFINITY;
    for (int i = 0; i < s->symmetry->part_count; i++) {
        if (pend_symmetry_laplacian(&s->part[i], s->symmetry, i, loads, up, s->place)) goto out;
        s->least = fmin(s->least, s->part[i]->least);
        s->most = fmax(s->most, s->part[i]->most);
    }
    /* the number of negative eigenvalues equals the number of upright arms */
    for (int k = 0; up && k < tree->n; k++) s->negative += up[k] != 0;
    status = PEND_OK;
    assert(spectrum_valid(s));
out:
    if (status) pend_spectrum_free(spectrum);
    return status;
}

void pend_spectrum_free(struct pend_spectrum **spectrum) {
    struct pend_spectrum *s = *spectrum;
    if (!s) return;
    pend_values_free(&s->search.values);
    for (int i = 0; s->part && i < s->symmetry->part_count; i++) pend_laplacian_free(&s->part[i]);
    free(s->part);
    pend_symmetry_free(&s->symmetry);
    free(s->place);
    free(s);
    *spectrum = NULL;
}

enum pend_status pend_spectrum_check(const struct pend_spectrum *spectrum,
                                     struct pend_error *error) {
    double weakest = INFINITY;
    for (int i = 0; i < spectrum->symmetry->part_count; i++)
        for (int k = 0; k < spectrum->part[i]->n; k++)
            weakest = fmin(weakest, fabs(spectrum->part[i]->spring[k]));
    if (spectrum->least >= SPECTRUM_LEAST && spectrum->most <= SPECTRUM_MOST) {
        if (weakest >= SPECTRUM_WEAKEST) return PEND_OK;
        return pend_fail(
            error, PEND_INVALID, -1, 0,
            "lengths, masses and gravity differ too much or are too small: the restoring stiffness "
            "of a hanging arm is only %.3g N/m; modes need at least %.0g N/m",
            weakest, SPECTRUM_WEAKEST);
    }
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "lengths, masses and gravity differ too much: the squared frequencies lie "
                     "between %.3g and %.3g (rad/s)^2; they must lie from %.0g to %.0g",
                     fmax(spectrum->least, 0), fmin(spectrum->most, DBL_MAX), SPECTRUM_LEAST,
                     SPECTRUM_MOST);
}

/**
 * Counts the eigenvalues below each shift, each mode as often as it occurs. O(n).
 *
 * count  1 .. 16.
 * shift  ascending, 1/s^2.
 */
static void spectrum_below(const struct pend_spectrum *spectrum, int count, const double shift[],
                           int below[]) {
    assert(count >= 1 && count <= SPECTRUM_SHIFTS);
    for (int i = 1; i < count; i++) assert(!(shift[i] < shift[i - 1]));
    const struct pend_modes_kernel *kernel = PEND_ISA_PICK(pend_modes_kernel, pend_isa_best());
    for (int i = 0; i < count; i++) below[i] = 0;
    for (int p = 0; p < spectrum->symmetry->part_count; p++) {
        const struct pend_laplacian *l = spectrum->part[p];
        int times = spectrum->symmetry->part[p].times;
        /* most parts are small, and all their eigenvalues are above the shifts */
        if (!spectrum->negative && shift[count - 1] < l->least) continue;
        if (shift[0] > l->most) {
            for (int i = 0; i < count; i++) below[i] += times * l->n;
            continue;
        }
        struct pend_modes_probe probe[SPECTRUM_SHIFTS];
        for (int i = 0; i < count; i++) probe[i].shift = shift[i];
        kernel->probe(l, count, probe);
        for (int i = 0; i < count; i++) below[i] += times * probe[i].below;
    }
}

void pend_spectrum_between(const struct pend_spectrum *spectrum, double from, double to, int *first,
                           int *count) {
    assert(from <= to);
    from *= fabs(from);
    to *= fabs(to);
    double shift[] = {from - 2 * DBL_EPSILON * fabs(from), to + 2 * DBL_EPSILON * fabs(to)};
    int below[2];
    spectrum_below(spectrum, 2, shift, below);
    *first = below[0];
    *count = below[1] > below[0] ? below[1] - below[0] : 0;
}

/* Sets ascending shifts. The logarithms `at` of their sizes are evenly spaced from lo to hi. */
static void spectrum_shifts(double lo, double hi, int negative, double at[], double shift[]) {
    double step = (hi - lo) / (SPECTRUM_SHIFTS - 1);
    for (int j = 0; j < SPECTRUM_SHIFTS; j++) {
        at[j] = j == SPECTRUM_SHIFTS - 1 ? hi : lo + j * step;
        shift[negative ? SPECTRUM_SHIFTS - 1 - j : j] = negative ? -exp(at[j]) : exp(at[j]);
    }
}

double pend_spectrum_cut(const struct pend_spectrum *spectrum, int number, int above) {
    /* bisection in the logarithm of the size, on the side of 0 on which the eigenvalue lies */
    int negative = number < spectrum->negative;
    double lo = log(spectrum->least) - 1e-6, hi = log(spectrum->most) + 1e-6;
    if (number <= 0) return -2 * spectrum->most;
    if (number >= spectrum->n) return 2 * spectrum->most;
    for (int round = 0; round < SPECTRUM_ROUNDS; round++) {
        double at[SPECTRUM_SHIFTS], shift[SPECTRUM_SHIFTS];
        int below[SPECTRUM_SHIFTS], i = 0;
        spectrum_shifts(lo, hi, negative, at, shift);
        spectrum_below(spectrum, SPECTRUM_SHIFTS, shift, below);
        /* the first shift above the eigenvalue of a given number */
        while (i < SPECTRUM_SHIFTS - 1 && below[i] < number) i++;
        if (i == 0 || below[i] == number) return shift[i];
        int slack = number / 8 + 8, more = below[i] - number, less = number - below[i - 1];
        if (round == SPECTRUM_ROUNDS - 1 || (above ? more : less) <= slack)
            return shift[above ? i : i - 1];
        lo = at[negative ? SPECTRUM_SHIFTS - 1 - i : i - 1];
        hi = at[negative ? SPECTRUM_SHIFTS - i : i];
    }
    return 0;
}

/* replaces L by -L, and back */
static void spectrum_negate(struct pend_laplacian *l) {
    for (int k = 0; k < l->n; k++) l->spring[k] = -l->spring[k];
}

void pend_spectrum_search(struct pend_spectrum *spectrum, int part, int first, int count,
                          double value[]) {
    assert(part >= 0 && part < spectrum->symmetry->part_count && !spectrum->search.values);
    struct pend_laplacian *l = spectrum->part[part];
    assert(first >= 0 && count >= 0 && count <= l->n - first);
    int split = spectrum->negative ? pend_values_below(l, 0) - first : 0;
    if (split < 0) split = 0;
    if (split > count) split = count;
    spectrum->search = (struct pend_search){l, NULL, value, first, count, split, split ? 0 : 1};
}

/* eigenvalue i of L from below is eigenvalue n - 1 - i of -L, which is positive */
static enum pend_status spectrum_begin(struct pend_search *s) {
    if (s->done)
        return pend_values_new(&s->values, s->part, s->first + s->split, s->count - s->split,
                               s->value + s->split);
    spectrum_negate(s->part);
    enum pend_status status =
        pend_values_new(&s->values, s->part, s->part->n - s->first - s->split, s->split, s->value);
    if (status) spectrum_negate(s->part);
    return status;
}

enum pend_status pend_spectrum_step(struct pend_spectrum *spectrum, int *done) {
    struct pend_search *s = &spectrum->search;
    assert(spectrum_valid(spectrum));
    if (!s->values && s->done < 2) PEND_TRY(spectrum_begin(s));
    if (s->values && pend_values_step(s->values)) {
        pend_values_free(&s->values);
        if (!s->done) {
            spectrum_negate(s->part);
            // the values of the negated part, in reverse and with the opposite sign
            for (int i = 0, j = s->split - 1; i <= j; i++, j--) {
                double swap = -s->value[i];
                s->value[i] = -s->value[j];
                s->value[j] = swap;
            }
        }
        s->done++;
    }
    *done = s->done == 2;
    assert(spectrum_valid(spectrum));
    return PEND_OK;
}
