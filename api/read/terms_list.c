/* Builds the list of terms of a pendulum from the fields of its arms.
 * Leaves to others: reading (terms_json), the layout (core/tree/terms). */
#include "api/read/terms_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* whether the arm is attached to its parent at another point than its tip */
static int arm_hung(const struct api_terms *terms, const struct pend_tree *tree, int i) {
    int p = tree->parent[tree->place[i]];
    if (terms->cart.given && p == 0) return 0;
    if (!terms->row[PEND_TERM_AT_X] || isnan(terms->row[PEND_TERM_AT_X][i]) || p < 0) return 0;
    return terms->row[PEND_TERM_AT_X][i] != tree->len[p] ||
           (terms->row[PEND_TERM_AT_Y] && terms->row[PEND_TERM_AT_Y][i] != 0);
}

/* lays out the list; *made stays NULL if the list would be empty */
static enum pend_status terms_lay_out(const struct api_terms *terms, const struct pend_tree *tree,
                                      struct pend_terms **made, int place[]) {
    unsigned char rows[PEND_TERM_ROWS] = {0}, ones[PEND_TERM_ONES] = {0};
    int any = terms->harmonics, hung = 0;
    for (int i = 0; i < terms->n && !hung; i++) hung = arm_hung(terms, tree, i);
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        rows[r] = terms->row[r] && (hung || (r != PEND_TERM_AT_X && r != PEND_TERM_AT_Y));
        any |= rows[r];
    }
    for (int one = 0; one < PEND_TERM_ONES; one++) any |= ones[one] = terms->one[one] != 0;
    any |= ones[PEND_TERM_RAIL] = (unsigned char)(terms->cart.given != 0);
    rows[PEND_TERM_DAMPING] |= terms->cart.damping != 0;
    rows[PEND_TERM_STIFFNESS] |= terms->cart.stiffness != 0;
    rows[PEND_TERM_TORQUE] |= terms->cart.force != 0;
    int joints = terms->rules.rubs || terms->rules.stops;
    rows[PEND_TERM_SLIDE] = (unsigned char)joints;
    any |= rows[PEND_TERM_INPUT] = ones[PEND_TERM_PIECE] =
        joints || terms->rules.tables + terms->rules.controllers > 0;
    for (int i = 0; i < 8 * terms->rules.tables; i++)
        ones[PEND_TERM_PIVOT_TRACK + i % 8] |= terms->rules.table[i / 8].drives < 0;
    if (!any) return PEND_OK;
    int *drives = malloc(((size_t)terms->harmonics + 1) * sizeof *drives);
    if (!drives) return PEND_NO_MEMORY;
    for (int h = 0; h < terms->harmonics; h++) {
        int arm = terms->harmonic[h].drives;
        drives[h] = arm >= 0 ? tree->place[arm] : arm;
    }
    enum pend_status status =
        pend_terms_new(made, tree->n, rows, ones, terms->harmonics, drives, place);
    free(drives);
    return status;
}

/* writes the numbers of a cart, stored arm 0 */
static void cart_fill(const struct api_cart *cart, const struct pend_terms *made, double value[]) {
    const int *row = made->row;
    assert(pend_terms_cart(made) && cart->mass > 0);
    value[made->one[PEND_TERM_RAIL]] = cart->angle;
    if (row[PEND_TERM_DAMPING] >= 0) value[row[PEND_TERM_DAMPING]] = cart->damping;
    if (row[PEND_TERM_STIFFNESS] >= 0) value[row[PEND_TERM_STIFFNESS]] = cart->stiffness;
    if (row[PEND_TERM_TORQUE] >= 0) value[row[PEND_TERM_TORQUE]] = cart->force;
}

static void terms_fill(const struct api_terms *terms, const struct pend_tree *tree,
                       struct pend_terms *made, const int place[], double value[]) {
    pend_terms_clear(made, tree, value);
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        for (int i = 0; made->row[r] >= 0 && i < terms->n; i++) {
            double *number = &value[made->row[r] + tree->place[i]];
            int at = r == PEND_TERM_AT_X || r == PEND_TERM_AT_Y;
            if (at ? arm_hung(terms, tree, i) : terms->row[r] != NULL)
                *number = terms->row[r] ? terms->row[r][i] : 0;
            else if (!at)
                *number = api_terms_usual((enum pend_term_row)r);
        }
    }
    if (terms->cart.given) cart_fill(&terms->cart, made, value);
    for (int i = 0; i < terms->n; i++)
        made->hung[tree->place[i]] = (unsigned char)arm_hung(terms, tree, i);
    for (int one = 0; one < PEND_TERM_ONES; one++)
        if (made->one[one] >= 0 && one != PEND_TERM_RAIL) value[made->one[one]] = terms->one[one];
    for (int h = 0; h < made->harmonics; h++)
        memcpy(&value[made->harmonic[h].at], terms->harmonic[place[h]].part,
               sizeof terms->harmonic->part);
}

/* the receiver of errors in the list */
struct list_faults {
    const struct api_terms *terms;
    const struct pend_tree *tree;
    api_terms_fault_fn *fault;
    void *context;
    int count;
};

/* the ranges were checked one by one; the remaining error is an arm without inertia, which may
 * follow from another error of the arm */
static void list_fault(void *context, const struct pend_terms_fault *found) {
    struct list_faults *faults = context;
    int i = found->arm >= 0 && found->row >= 0 ? faults->tree->order[found->arm] : -1;
    if (i < 0 || i >= faults->terms->n || api_terms_has(faults->terms, API_TERMS_FAULTY, i)) return;
    faults->fault(faults->context, "mass", i, found->text);
    faults->count++;
}

/* checks the numbers of a list together; returns the number of errors */
static int list_check(struct list_faults *faults, const struct pend_terms *made,
                      const double value[]) {
    double sum = faults->tree->subtree_mass[0];
    (void)pend_terms_check(made, faults->tree, value, list_fault, faults);
    for (int k = 0; k < made->n; k++)
        sum += pend_terms_get(made, value, PEND_TERM_ROD, k) +
               pend_terms_get(made, value, PEND_TERM_BODY, k);
    if (isfinite(sum)) return faults->count;
    faults->fault(faults->context, "mass", -1,
                  "the masses, with those of rods and bodies, must add up to a finite number");
    return faults->count + 1;
}

enum pend_status api_terms_make(const struct api_terms *terms, const struct pend_tree *tree,
                                struct pend_terms **made, double **value, struct pend_rules **rules,
                                api_terms_fault_fn *fault, void *context) {
    struct list_faults faults = {terms, tree, fault, context, 0};
    *made = NULL;
    *value = NULL;
    *rules = NULL;
    assert(terms->n + terms->cart.given == tree->n);
    if (terms->status != PEND_OK) return terms->status;
    int *place = malloc(((size_t)terms->harmonics + 1) * sizeof *place);
    if (!place) return PEND_NO_MEMORY;
    enum pend_status status = terms_lay_out(terms, tree, made, place);
    if (status == PEND_OK && *made) {
        *value = malloc(((size_t)(*made)->count + 1) * sizeof **value);
        status = *value ? PEND_OK : PEND_NO_MEMORY;
    }
    if (status == PEND_OK && *made) {
        terms_fill(terms, tree, *made, place, *value);
        if (list_check(&faults, *made, *value)) status = PEND_INVALID;
    }
    free(place);
    if (status == PEND_OK) status = api_rules_make(&terms->rules, tree, rules);
    if (*made) (*made)->rules = *rules;
    if (status == PEND_OK) return PEND_OK;
    pend_terms_free(made);
    free(*value);
    *value = NULL;
    return status;
}
