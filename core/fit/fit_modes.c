#include "core/fit/fit_modes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/damped.h"
#include "core/modes/modes.h"

static int modes_before(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* modes of a real pendulum */
static enum pend_status modes_damped(const struct pend_tree *tree, const struct pend_loads *loads,
                                     double omega[]) {
    struct pend_damped *damped;
    int count = 0, n = tree->n;
    for (int k = 0; k < n; k++) omega[k] = -M_PI / 2;
    PEND_TRY(pend_damped_new(&damped, tree, loads, omega, NULL));
    memset(omega, 0, (size_t)n * sizeof *omega);
    for (int j = 0; j < damped->count && count < n; j++)
        if (damped->omega[j] > 0) omega[count++] = damped->omega[j];
    pend_damped_free(&damped);
    qsort(omega, (size_t)count, sizeof *omega, modes_before);
    return PEND_OK;
}

enum pend_status pend_fit_modes(const struct pend_tree *tree, const struct pend_loads *loads,
                                double omega[]) {
    assert(tree->n >= 1 && omega);
    struct pend_modes *modes;
    if (loads->terms) return modes_damped(tree, loads, omega);
    PEND_TRY(pend_modes_new(&modes, tree, loads, 0, NULL));
    memcpy(omega, modes->omega, (size_t)tree->n * sizeof *omega);
    pend_modes_free(&modes);
    return PEND_OK;
}
