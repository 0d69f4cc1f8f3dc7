#include "api/op/ensemble/observables.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* an observable's columns: names, parts, and which parts have one number per arm */
struct columns {
    const char *name;
    const char *part[3];
    int arms[3];
};

/* in the order of enum api_observable */
static const struct columns observables[API_SEE_COUNT] = {
    [API_SEE_START] = {"start", {"phi", "phid"}, {1, 1}},
    [API_SEE_PARAMETERS] = {"parameters", {"length", "mass", "gravity"}, {1, 1, 0}},
    [API_SEE_FINAL] = {"final", {"phi", "phid"}, {1, 1}},
    [API_SEE_FIRST_FLIP] = {"first_flip", {"time", "arm"}, {0, 0}},
    [API_SEE_FLIP_TIME] = {"flip_time", {NULL}, {1}},
    [API_SEE_FLIPS] = {"flips", {NULL}, {1}},
    [API_SEE_LAMBDA_MAX] = {"lambda_max", {"value", "time"}, {1, 1}},
    [API_SEE_LAMBDA_MIN] = {"lambda_min", {"value", "time"}, {1, 1}},
    [API_SEE_SIGN_CHANGE] = {"sign_change", {NULL}, {1}},
    [API_SEE_ENERGY_DRIFT] = {"energy_drift", {NULL}, {0}},
    [API_SEE_LYAPUNOV] = {"lyapunov", {NULL}, {0}},
    [API_SEE_HORIZON] = {"horizon", {NULL}, {0}},
    [API_SEE_CART] = {"cart", {"x", "v"}, {0, 0}},
    [API_SEE_SETTLED] = {"settled", {NULL}, {0}},
    [API_SEE_TRAJECTORY] = {"trajectory", {NULL}, {0}},
};

const char *api_observables_name(enum api_observable observable) {
    assert(observable >= 0 && observable < API_SEE_COUNT);
    return observables[observable].name;
}

void api_observables_read(struct api_observables *seen, const struct api_value *root,
                          struct api_problem *problem) {
    const char *names[API_SEE_COUNT + 1] = {0};
    struct api_value list = api_value_member(root, "observables"),
                     output = api_value_member(root, "output"),
                     within = api_value_member(root, "within");
    for (int i = 0; i < API_SEE_COUNT; i++) names[i] = observables[i].name;
    *seen = (struct api_observables){.wanted = api_field_words(&list, names, problem)};
    if (api_value_kind(&list) == API_MISSING) seen->wanted = 1u << API_SEE_FINAL;
    seen->within = 0.1;
    (void)api_value_read_number(&within, 1e-9, M_PI, "rad", &seen->within, problem);
    if (api_value_kind(&within) != API_MISSING && !(seen->wanted >> API_SEE_SETTLED & 1))
        api_value_fault(&within, problem,
                        API_CODE_NOT_APPLICABLE "is for the observable \"settled\": leave it out");
    int rows = seen->wanted >> API_SEE_TRAJECTORY & 1;
    if (rows && seen->wanted != 1u << API_SEE_TRAJECTORY)
        api_value_fault(&list, problem,
                        API_CODE_CONFLICT "\"trajectory\" has many rows for each member, the "
                                          "others have one: ask for them in another request");
    if (!rows && api_value_kind(&output) != API_MISSING)
        api_value_fault(&output, problem,
                        API_CODE_NOT_APPLICABLE
                        "is only for the observable \"trajectory\": leave it out");
    seen->output = api_member_outputs_read(&output, problem);
}

int api_observables_cart(const struct api_observables *seen) {
    return (int)(seen->wanted >> API_SEE_CART & 1) | api_member_outputs_cart(seen->output);
}

void api_observables_columns(struct api_observables *seen, int n,
                             const struct api_members *members) {
    assert(n >= 1);
    seen->members = members;
    struct api_table *table = &seen->table;
    if (seen->wanted >> API_SEE_TRAJECTORY & 1) {
        api_member_outputs_columns(seen->output, n, table);
        return;
    }
    api_table_add(table, "member", NULL, 0);
    api_table_add(table, "status", NULL, 0);
    for (int i = 0; i < API_SEE_COUNT; i++) {
        if (!(seen->wanted >> i & 1)) continue;
        seen->at[i] = table->count;
        for (int part = 0; part < 3 && (!part || observables[i].part[part]); part++) {
            api_table_add(table, observables[i].name, observables[i].part[part],
                          observables[i].arms[part] ? n : 0);
        }
        int cart = pend_terms_cart(members->terms);
        if (cart && i == API_SEE_START) {
            api_table_add(table, "start", "cart_x", 0);
            api_table_add(table, "start", "cart_v", 0);
        }
        if (cart && i == API_SEE_PARAMETERS) api_table_add(table, "parameters", "cart_mass", 0);
        if (i == API_SEE_PARAMETERS && members->shown)
            api_table_add(table, observables[i].name, "varied", members->shown);
    }
}

int api_observables_derived(struct api_observables *seen, struct api_derived *derived) {
    assert(derived->count >= 1 && seen->table.count);
    if (seen->wanted >> API_SEE_TRAJECTORY & 1)
        api_member_outputs_differ(seen->output, derived, &seen->table);
    if (seen->wanted >> API_SEE_FINAL & 1) {
        api_derived_add(derived, &seen->table, "final", "phi", PEND_DERIVED_PHI);
        api_derived_add(derived, &seen->table, "final", "phid", PEND_DERIVED_RATE);
    }
    if (seen->wanted >> API_SEE_CART & 1) {
        api_derived_add(derived, &seen->table, "cart", "x", PEND_DERIVED_CART_PLACE);
        api_derived_add(derived, &seen->table, "cart", "v", PEND_DERIVED_CART_SPEED);
    }
    return derived->columns;
}

void api_observables_ask(const struct api_observables *seen,
                         struct pend_ensemble_problem *problem) {
    const unsigned flips = 1u << API_SEE_FIRST_FLIP | 1u << API_SEE_FLIP_TIME | 1u << API_SEE_FLIPS;
    const unsigned given =
        1u << API_SEE_START | 1u << API_SEE_PARAMETERS; // known without integrating
    unsigned wanted = seen->wanted & ~given;
    problem->observe = 0;
    if (wanted & flips) problem->bound = M_PI;
    if (wanted & (1u << API_SEE_LAMBDA_MAX | 1u << API_SEE_LAMBDA_MIN))
        problem->observe |= PEND_OBSERVE_EXTREMES;
    if (wanted >> API_SEE_SIGN_CHANGE & 1) problem->observe |= PEND_OBSERVE_SIGNS;
    if (wanted >> API_SEE_ENERGY_DRIFT & 1) problem->observe |= PEND_OBSERVE_ENERGY;
    if (wanted >> API_SEE_SETTLED & 1) problem->settle = seen->within;
    if (wanted >> API_SEE_LYAPUNOV & 1) problem->observe |= PEND_OBSERVE_LYAPUNOV;
    if (!wanted || wanted & ~flips) return;
    // no other observable depends on the end, so members need not be integrated further than
    // necessary
    problem->spare = 1;
    if (!(wanted >> API_SEE_FLIPS & 1))
        problem->until = wanted >> API_SEE_FLIP_TIME & 1 ? PEND_UNTIL_ALL : PEND_UNTIL_FIRST;
}

int api_observables_status(enum pend_status status) {
    return status == PEND_OK               ? 0
           : status == PEND_NOT_FINITE     ? 1
           : status == PEND_STEP_TOO_SMALL ? 2
           : status == PEND_INVALID        ? 4
                                           : 3;
}

/* copies n values from stored to the caller's order; missing or infinite values become NaN */
static double *put(double *at, const struct api_tree *tree, const double x[]) {
    const int *order = tree->tree->order;
    for (int k = tree->cart; k < tree->tree->n; k++)
        at[order[k]] = x && isfinite(x[k]) ? x[k] : NAN;
    return at + tree->n;
}

static double *put_one(double *at, double x) {
    *at = isfinite(x) ? x : NAN;
    return at + 1;
}

/* copies the caller's number of a stored arm; 0 for no arm, if the motion is known */
static double *put_arm(double *at, const struct api_tree *tree,
                       const struct pend_outcome *outcome) {
    double none = outcome->status == PEND_OK ? 0 : NAN;
    return put_one(at, outcome->arm < 0 ? none : tree->tree->order[outcome->arm] + 1);
}

/* copies position and speed of a cart at the end */
static double *put_cart(double *at, const struct pend_outcome *outcome) {
    assert(!outcome->phi == !outcome->rate);
    at = put_one(at, outcome->phi ? outcome->phi[0] : NAN);
    return put_one(at, outcome->rate ? outcome->rate[0] : NAN);
}

static double *put_start(double *at, const struct api_tree *tree, const struct pend_member *start) {
    at = put(put(at, tree, start->phi), tree, start->rate);
    return tree->cart ? put_one(put_one(at, start->phi[0]), start->rate[0]) : at;
}

static double *write_one(enum api_observable observable, const struct api_tree *tree,
                         const struct pend_member *start, const struct pend_outcome *outcome,
                         double *at) {
    const struct pend_force_range *force = &outcome->force;
    const double one[API_SEE_COUNT] = {[API_SEE_ENERGY_DRIFT] = outcome->energy_drift,
                                       [API_SEE_HORIZON] = outcome->horizon,
                                       [API_SEE_LYAPUNOV] = outcome->lyapunov};
    switch (observable) {
    case API_SEE_START:
        return put_start(at, tree, start);
    case API_SEE_PARAMETERS:
        at = put(put(at, tree, start->length), tree, start->mass);
        at = put_one(at, start->loads.gravity);
        return tree->cart ? put_one(at, start->mass[0]) : at;
    case API_SEE_FINAL:
        return put(put(at, tree, outcome->phi), tree, outcome->rate);
    case API_SEE_FIRST_FLIP:
        at = put_one(at, outcome->first);
        return put_arm(at, tree, outcome);
    case API_SEE_FLIP_TIME:
        return put(at, tree, outcome->first_crossing);
    case API_SEE_FLIPS:
        for (int k = tree->cart; k < tree->tree->n; k++)
            at[tree->tree->order[k]] = outcome->crossings ? (double)outcome->crossings[k] : NAN;
        return at + tree->n;
    case API_SEE_LAMBDA_MAX:
        return put(put(at, tree, force->most), tree, force->most_time);
    case API_SEE_LAMBDA_MIN:
        return put(put(at, tree, force->least), tree, force->least_time);
    case API_SEE_SIGN_CHANGE:
        return put(at, tree, outcome->sign_change);
    case API_SEE_SETTLED:
        return put_one(at, outcome->settled);
    case API_SEE_CART:
        return put_cart(at, outcome);
    default:
        return put_one(at, one[observable]);
    }
}

/* true if n numbers are finite; false also if there was no step */
static int observables_finite(const double x[], int n) {
    for (int k = 0; x && k < n; k++)
        if (!isfinite(x[k])) return 0;
    return 1;
}

enum pend_status api_observables_end(const struct api_observables *seen,
                                     const struct api_tree *tree,
                                     const struct pend_outcome *outcome) {
    const struct pend_force_range *force = &outcome->force;
    unsigned wanted = outcome->status == PEND_OK && outcome->steps ? seen->wanted : 0;
    int n = tree->tree->n, known = 1;
    if (wanted & 1u << API_SEE_ENERGY_DRIFT) known &= isfinite(outcome->energy_drift) != 0;
    if (wanted & 1u << API_SEE_LAMBDA_MAX) known &= observables_finite(force->most, n);
    if (wanted & 1u << API_SEE_LAMBDA_MIN) known &= observables_finite(force->least, n);
    return known ? outcome->status : PEND_NOT_FINITE;
}

void api_observables_write(const struct api_observables *seen, const struct api_tree *tree,
                           long member, const struct pend_member *start,
                           const struct pend_outcome *outcome, double row[]) {
    assert(member >= 0 && pend_tree_valid(tree->tree));
    /* a member that failed before its end has no known values */
    static const struct pend_outcome nothing = {.status = PEND_NOT_FINITE,
                                                .arm = -1,
                                                .first = NAN,
                                                .energy_drift = NAN,
                                                .horizon = NAN,
                                                .settled = NAN,
                                                .lyapunov = NAN};
    double *at = row;
    *at++ = (double)member;
    enum pend_status end = api_observables_end(seen, tree, outcome);
    *at++ = api_observables_status(end);
    if (end != PEND_OK) outcome = &nothing;
    for (int i = 0; i < API_SEE_COUNT; i++) {
        if (!(seen->wanted >> i & 1)) continue;
        at = write_one((enum api_observable)i, tree, start, outcome, at);
        // the varying term values, in the order of the request
        for (int v = 0; i == API_SEE_PARAMETERS && v < seen->members->shown; v++)
            at = put_one(at, start->value[seen->members->shown_place[v]]);
    }
}
