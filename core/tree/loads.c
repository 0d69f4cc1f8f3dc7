#include "core/tree/loads.h"

#include <math.h>

enum pend_status pend_loads_check(const struct pend_loads *loads, struct pend_error *error) {
    if (!isfinite(loads->gravity))
        return pend_fail(error, PEND_INVALID, -1, 0, "gravity must be finite");
    return PEND_OK;
}

enum pend_status pend_loads_check_series(const struct pend_loads *loads, struct pend_error *error) {
    return pend_loads_check(loads, error); // the series support every term
}

int pend_loads_pull_down(const struct pend_loads *loads) {
    return loads->gravity > 0 && isfinite(loads->gravity);
}

double pend_loads_rate(const struct pend_loads *loads, const struct pend_tree *tree) {
    if (!loads->terms) return 0;
    return pend_terms_rate(loads->terms, tree->parent, tree->len, tree->mass, loads->value, NULL) +
           pend_terms_drive_rate(loads->terms, loads->value);
}

double pend_loads_decay(const struct pend_loads *loads, const struct pend_tree *tree) {
    double decay = 0;
    if (loads->terms)
        (void)pend_terms_rate(loads->terms, tree->parent, tree->len, tree->mass, loads->value,
                              &decay);
    return decay;
}

enum pend_status pend_loads_check_linear(const struct pend_loads *loads, struct pend_error *error) {
    if (loads->terms)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the linearization without a matrix is for ideal pendulums, without "
                         "friction, drives, springs, rods or bodies");
    if (pend_loads_pull_down(loads)) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "gravity must be a finite number greater than 0, got %.17g", loads->gravity);
}

int pend_loads_lose(const struct pend_loads *loads) {
    static const enum pend_term_row takes[] = {PEND_TERM_DAMPING, PEND_TERM_FRICTION,
                                               PEND_TERM_DRAG, PEND_TERM_DRAG_QUADRATIC};
    const struct pend_terms *terms = loads->terms;
    for (size_t i = 0; i < sizeof takes / sizeof *takes; i++)
        for (int k = 0; terms && k < terms->n; k++)
            if (pend_terms_get(terms, loads->value, takes[i], k) != 0) return 1;
    int drag_per_mass = terms ? terms->one[PEND_TERM_DRAG_PER_MASS] : -1;
    return drag_per_mass >= 0 && loads->value[drag_per_mass] != 0;
}
