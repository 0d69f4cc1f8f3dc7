#include "core/derivatives/ideal_loads.h"

#include <assert.h>

/* The least ratio of an arm's own moment of inertia to that of the arm with its load as a point at
 * the tip. The system loses that many digits: three. */
static const double ideal_own = 1e-3;

/* largest distance of a center from the middle of its arm, in lengths; beyond it the masses of the
 * equivalent points are large and nearly cancel */
static const double ideal_far = 1.5;

/* ---- supported pendulums */

/* true if the row of terms is supported, also as a parameter */
static int ideal_row_known(int row) {
    return row == PEND_TERM_ROD || row == PEND_TERM_BODY || row == PEND_TERM_CENTER_X ||
           row == PEND_TERM_INERTIA || row == PEND_TERM_DAMPING || row == PEND_TERM_STIFFNESS ||
           row == PEND_TERM_REST || row == PEND_TERM_TORQUE;
}

/* the row of terms to which an index in the list belongs; PEND_TERM_ROWS if none */
static int ideal_row_of(const struct pend_terms *terms, int at) {
    int row = 0;
    while (row < PEND_TERM_ROWS &&
           (terms->row[row] < 0 || at < terms->row[row] || at >= terms->row[row] + terms->n))
        row++;
    return row;
}

static int ideal_bodies(const struct pend_terms *terms) {
    return terms->row[PEND_TERM_ROD] >= 0 || terms->row[PEND_TERM_BODY] >= 0;
}

/* true if the kinds of terms are supported, for any values */
static int ideal_terms_known(const struct pend_terms *terms) {
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && !ideal_row_known(r) && r != PEND_TERM_CENTER_Y) return 0;
    return terms->one[PEND_TERM_DRAG_PER_MASS] < 0 && terms->one[PEND_TERM_RAIL] < 0;
}

/* the mass of the sub-tree at the tip of arm k, kg */
static double ideal_carried(const struct pend_tree *tree, const struct pend_loads *loads, int k) {
    double sum = 0;
    for (int c = k + 1; c < tree->end[k]; c++)
        sum += tree->mass[c] + pend_terms_get(loads->terms, loads->value, PEND_TERM_BODY, c) +
               pend_terms_get(loads->terms, loads->value, PEND_TERM_ROD, c);
    return sum;
}

/* true if bodies' centers are near their arms, and no arm is negligible compared with its load */
static int ideal_shaped(const struct pend_tree *tree, const struct pend_loads *loads) {
    const struct pend_terms *terms = loads->terms;
    for (int k = tree->n - 1; k >= 0; k--) {
        double l = tree->len[k], own = pend_terms_inertia(terms, l, tree->mass[k], loads->value, k);
        double middle = pend_terms_get(terms, loads->value, PEND_TERM_CENTER_X, k) - l / 2;
        double body = pend_terms_get(terms, loads->value, PEND_TERM_BODY, k);
        if (pend_terms_get(terms, loads->value, PEND_TERM_CENTER_Y, k) != 0) return 0;
        if (body != 0 && !(middle <= ideal_far * l && -middle <= ideal_far * l)) return 0;
        if (!(own >= ideal_own * (own + ideal_carried(tree, loads, k) * l * l))) return 0;
    }
    return 1;
}

int pend_ideal_suits(const struct pend_tree *tree, const struct pend_loads *loads, int count,
                     const struct pend_parameter parameter[]) {
    const struct pend_terms *terms = loads->terms;
    assert(tree->n >= 1);
    if (!terms || (!terms->count && !terms->harmonics)) return 1;
    if (!ideal_terms_known(terms)) return 0;
    for (int i = 0; i < count; i++)
        if (parameter[i].kind == PEND_PARAMETER_TERM &&
            !ideal_row_known(ideal_row_of(terms, parameter[i].at)))
            return 0;
    return !ideal_bodies(terms) || ideal_shaped(tree, loads);
}

/* ---- values of the terms */

void pend_ideal_load(struct ideal_known *known, const struct pend_tree *tree,
                     const struct pend_loads *loads) {
    const struct pend_terms *terms = loads->terms;
    double *mass = known->system.mass;
    known->loaded = 1;
    known->bodies = ideal_bodies(terms);
    known->joints = terms->row[PEND_TERM_DAMPING] >= 0 || terms->row[PEND_TERM_STIFFNESS] >= 0 ||
                    terms->row[PEND_TERM_TORQUE] >= 0;
    for (int k = 0; k < tree->n; k++) {
        double rod = pend_terms_get(terms, loads->value, PEND_TERM_ROD, k), l = tree->len[k];
        double body = pend_terms_get(terms, loads->value, PEND_TERM_BODY, k);
        double c = pend_terms_get(terms, loads->value, PEND_TERM_CENTER_X, k);
        double own = pend_terms_get(terms, loads->value, PEND_TERM_INERTIA, k);
        known->hold[k] = pend_terms_get(terms, loads->value, PEND_TERM_DAMPING, k);
        known->stiff[k] = pend_terms_get(terms, loads->value, PEND_TERM_STIFFNESS, k);
        known->inertia[k] = own - body * c * (l - c) - rod * l * l / 6;
        mass[k] += rod / 2 + body * (c / l);
        if (tree->parent[k] >= 0) mass[tree->parent[k]] += rod / 2 + body * (1 - c / l);
    }
}

/* ---- derivatives with respect to the terms */

/* derivatives of the points at the tip and at the joint of an arm, and of the additional inertia */
static void ideal_shape(struct ideal_known *known, struct ideal_group *g, int lane, int k,
                        double tip, double joint, double inertia) {
    int up = known->system.parent[k];
    g->masses = known->masses = g->pairs = 1;
    g->mass[k * IDEAL_LANES + lane] += tip;
    if (up >= 0) g->mass[up * IDEAL_LANES + lane] += joint;
    g->inertia[k * IDEAL_LANES + lane] += inertia;
}

static void ideal_vary_length(struct ideal_known *known, struct ideal_group *g, int lane,
                              const struct pend_tree *tree, const struct pend_loads *loads, int k,
                              double seed) {
    const struct pend_terms *terms = loads->terms;
    double l = tree->len[k], rod = pend_terms_get(terms, loads->value, PEND_TERM_ROD, k);
    double body = pend_terms_get(terms, loads->value, PEND_TERM_BODY, k);
    double c = pend_terms_get(terms, loads->value, PEND_TERM_CENTER_X, k);
    double away = body * (c / l) / l;
    if (known->bodies)
        ideal_shape(known, g, lane, k, -seed * away, seed * away, -seed * (body * c + rod * l / 3));
}

void pend_ideal_vary(struct ideal_known *known, struct ideal_group *group, int lane,
                     const struct pend_tree *tree, const struct pend_loads *loads,
                     struct pend_parameter by, double seed) {
    assert(known->loaded && lane >= 0 && lane < IDEAL_LANES);
    if (by.kind == PEND_PARAMETER_LENGTH) {
        ideal_vary_length(known, group, lane, tree, loads, by.at, seed);
        return;
    }
    int row = ideal_row_of(loads->terms, by.at), k = by.at - loads->terms->row[row];
    int at = k * IDEAL_LANES + lane;
    double l = tree->len[k], body = pend_terms_get(loads->terms, loads->value, PEND_TERM_BODY, k);
    double c = pend_terms_get(loads->terms, loads->value, PEND_TERM_CENTER_X, k);
    group->pairs = 1;
    if (row == PEND_TERM_ROD)
        ideal_shape(known, group, lane, k, seed / 2, seed / 2, -seed * (l * l / 6));
    if (row == PEND_TERM_BODY)
        ideal_shape(known, group, lane, k, seed * (c / l), seed * (1 - c / l),
                    -seed * (c * (l - c)));
    if (row == PEND_TERM_CENTER_X)
        ideal_shape(known, group, lane, k, seed * (body / l), -seed * (body / l),
                    -seed * (body * (l - 2 * c)));
    if (row == PEND_TERM_INERTIA) group->inertia[at] = seed;
    if (row == PEND_TERM_DAMPING) group->hold[at] = seed;
    if (row == PEND_TERM_STIFFNESS) group->stiff[at] = seed;
    if (row == PEND_TERM_TORQUE) group->torque[at] = seed;
    if (row == PEND_TERM_REST) group->torque[at] = seed * known->stiff[k];
}
