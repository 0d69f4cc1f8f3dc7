#include "api/op/derived.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DERIVED_NUMBERS = 65536 }; /* numbers in a block of rows */

/* steps per radian of the fastest arm; s per step and, with eight derivatives, per step and arm,
 * measured */
static const double steps_a_radian = 4, step_seconds = 3.6e-6, arm_seconds = 7.2e-6;

/* s per radian, and per radian and pair of arms, for eight derivatives of an ideal pendulum of 1 to
 * 16 arms, measured */
static const double ideal_seconds = 2e-6, pair_seconds = 0.9e-6;

static const char *const fields[] = {"vary", "arm", "harmonic", NULL};

/* ---- reading */

enum pend_status api_derived_read(struct api_derived *derived, const struct api_value *value,
                                  const struct api_tree *tree, struct api_problem *problem) {
    *derived = (struct api_derived){.n = tree->n};
    if (api_value_kind(value) == API_MISSING) return PEND_OK;
    int count = api_value_count(value);
    if (api_value_kind(value) != API_ARRAY || !count || count > API_DERIVED_MOST) {
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT "must be an array of 1 to %d parameters, such as %s",
                        API_DERIVED_MOST, "{\"vary\": \"length\", \"arm\": 1}");
        return PEND_INVALID;
    }
    derived->parameter = calloc((size_t)count, sizeof *derived->parameter);
    if (!derived->parameter) return PEND_NO_MEMORY;
    derived->count = count;
    API_VALUE_EACH (item, api_value_item(value, 0)) {
        struct api_target target;
        if (!api_field_object(&item, fields, problem)) continue;
        if (api_target_read(&target, &item, tree, problem))
            derived->parameter[item.index] = api_target_parameter(&target);
    }
    return problem->status ? PEND_INVALID : PEND_OK;
}

void api_derived_end(struct api_derived *derived) {
    pend_derivatives_free(&derived->motion);
    free(derived->block);
    derived->block = NULL;
}

void api_derived_clear(struct api_derived *derived) {
    api_derived_end(derived);
    free(derived->parameter);
    derived->parameter = NULL;
}

double api_swing(const struct api_tree *tree, const struct api_states *start) {
    const struct pend_tree *stored = tree->tree;
    double shortest = INFINITY, rate = 0;
    for (int k = tree->cart; k < stored->n; k++) {
        shortest = fmin(shortest, stored->len[k]);
        if (start) rate = fmax(rate, fabs(start->rate[k]));
    }
    return rate + sqrt(fabs(tree->loads.gravity) / shortest * sqrt(stored->n));
}

double api_terms_pace(const struct api_tree *tree) {
    static const double drives = 0.2, decays = 0.05;
    double decay = pend_loads_decay(&tree->loads, tree->tree);
    return drives * (pend_loads_rate(&tree->loads, tree->tree) - decay) + decays * decay;
}

double api_derived_seconds(const struct api_derived *derived, const struct api_tree *tree,
                           double radians) {
    assert(derived->count >= 0 && radians >= 0);
    if (!tree->loads.terms)
        return ceil(derived->count / 8.0) * radians *
               (ideal_seconds + (double)tree->n * tree->n * pair_seconds);
    return ceil(derived->count / 8.0) * steps_a_radian * radians *
           (step_seconds + tree->n * arm_seconds);
}

/* ---- columns */

static int derived_width(const struct api_derived *derived, int what) {
    return what >= PEND_DERIVED_KINETIC ? 0 : derived->n;
}

void api_derived_add(struct api_derived *derived, struct api_table *table, const char *name,
                     const char *part, int what) {
    assert(derived->count >= 1 && derived->columns < API_COLUMNS / 2);
    assert(what >= 0 && what <= API_DERIVED_TOTAL);
    char *label = derived->column[derived->columns].label;
    (void)snprintf(label, API_DERIVED_LABEL, "%s%s%s", name, part ? "_" : "", part ? part : "");
    derived->column[derived->columns++].what = what;
    api_table_add_inner(table, "derivatives", label, derived_width(derived, what), derived->count);
}

/* ---- rows */

static void derived_wanted(const struct api_derived *derived, char wanted[PEND_DERIVED + 1]) {
    memset(wanted, 0, PEND_DERIVED + 1);
    for (int c = 0; c < derived->columns; c++) wanted[derived->column[c].what] = 1;
    if (wanted[API_DERIVED_TOTAL])
        wanted[PEND_DERIVED_KINETIC] = wanted[PEND_DERIVED_POTENTIAL] = 1;
}

static size_t derived_numbers(const struct api_derived *derived, int what) {
    int width = derived_width(derived, what);
    return (size_t)(width ? width : 1) * (size_t)derived->count;
}

static size_t derived_row(const struct api_derived *derived) {
    char wanted[PEND_DERIVED + 1];
    size_t numbers = 0;
    derived_wanted(derived, wanted);
    for (int i = 0; i <= PEND_DERIVED; i++)
        if (wanted[i]) numbers += derived_numbers(derived, i);
    return numbers;
}

long api_derived_cap(const struct api_derived *derived, long rows) {
    assert(derived->count >= 1 && rows >= 1);
    size_t row = derived_row(derived);
    long cap = row ? (long)(DERIVED_NUMBERS / row) : rows;
    return cap < 1 ? 1 : cap < rows ? cap : rows;
}

double api_derived_bytes(const struct api_derived *derived, const struct api_tree *tree,
                         long rows) {
    if (!derived->count) return 0;
    double parameters = (double)derived->count * (double)sizeof *derived->parameter;
    double block = (double)derived_row(derived) * (double)rows * (double)sizeof(double);
    return parameters + block +
           pend_derivatives_bytes(tree->tree, tree->loads.terms, derived->count);
}

enum pend_status api_derived_begin(struct api_derived *derived, const struct pend_problem *problem,
                                   long cap, struct pend_error *error) {
    assert(derived->count >= 1 && cap >= 1);
    char wanted[PEND_DERIVED + 1];
    derived_wanted(derived, wanted);
    derived->cap = cap;
    derived->block = malloc(derived_row(derived) * (size_t)cap * sizeof(double) + 1);
    if (!derived->block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for derivatives");
    double *at = derived->block;
    for (int i = 0; i <= PEND_DERIVED; i++) {
        if (!wanted[i]) continue;
        if (i == API_DERIVED_TOTAL)
            derived->total = at;
        else
            derived->rows.derivative[i] = at;
        at += derived_numbers(derived, i) * (size_t)cap;
    }
    return pend_derivatives_new(&derived->motion, problem, derived->count, derived->parameter,
                                error);
}

/* computes the derivatives of the total energy, from row `from` on */
static void derived_sum(const struct api_derived *derived, long from, long rows) {
    size_t count = (size_t)derived->count;
    const double *kinetic = derived->rows.derivative[PEND_DERIVED_KINETIC];
    const double *potential = derived->rows.derivative[PEND_DERIVED_POTENTIAL];
    for (size_t i = (size_t)from * count; derived->total && i < (size_t)(from + rows) * count; i++)
        derived->total[i] = kinetic[i] + potential[i];
}

enum pend_status api_derived_next(struct api_derived *derived, long from, long rows, double work,
                                  long *made, struct pend_error *error) {
    assert(derived->motion && from >= 0 && from + rows <= derived->cap);
    struct pend_derived_rows here = {{0}, {0}};
    for (int i = 0; i < PEND_DERIVED; i++)
        if (derived->rows.derivative[i])
            here.derivative[i] =
                derived->rows.derivative[i] + (size_t)from * derived_numbers(derived, i);
    PEND_TRY(pend_derivatives_next(derived->motion, &here, rows, work, made, error));
    derived_sum(derived, from, *made);
    return PEND_OK;
}

void api_derived_state(struct api_derived *derived, const double phi[], const double phi_low[],
                       const double rate[], double time, long row) {
    assert(derived->motion && row >= 0 && row < derived->cap);
    pend_derivatives_state(derived->motion, phi, phi_low, rate, time, &derived->rows, row);
    derived_sum(derived, row, 1);
}

double *api_derived_put(const struct api_derived *derived, long row, double to[]) {
    const double *column[API_COLUMNS / 2];
    assert(derived->block && row >= 0 && row < derived->cap);
    api_derived_columns(derived, column);
    for (int c = 0; c < derived->columns; c++) {
        size_t numbers = derived_numbers(derived, derived->column[c].what);
        memcpy(to, column[c] + (size_t)row * numbers, numbers * sizeof *to);
        to += numbers;
    }
    return to;
}

void api_derived_columns(const struct api_derived *derived, const double *column[]) {
    for (int c = 0; c < derived->columns; c++) {
        int what = derived->column[c].what;
        column[c] = what == API_DERIVED_TOTAL ? derived->total : derived->rows.derivative[what];
    }
}
