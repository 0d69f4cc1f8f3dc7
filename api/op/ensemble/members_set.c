#include "api/op/ensemble/members_set.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "api/op/ensemble/members_energy.h"

static const char *const set_fields[] = {"vary", "arm", "harmonic", "value", "unit", NULL};

struct api_sets {
    long members, read; /* number of members, and of members read so far */
    size_t count, cap;
    struct api_set *set;
    unsigned quantities; /* bit q is set if some member has a number of quantity q */
    size_t from[];       /* index of the first number of each member, and the end of the last */
};

enum pend_status api_sets_new(struct api_sets **sets, long members) {
    assert(members >= 1);
    *sets = calloc(1, sizeof **sets + ((size_t)members + 1) * sizeof(size_t));
    if (!*sets) return PEND_NO_MEMORY;
    (*sets)->members = members;
    return PEND_OK;
}

void api_sets_free(struct api_sets **sets) {
    if (*sets) free((*sets)->set);
    free(*sets);
    *sets = NULL;
}

static enum pend_status sets_add(struct api_sets *sets, enum api_quantity quantity, int at,
                                 double x) {
    assert(sets->count <= sets->cap);
    if (sets->count == sets->cap) {
        size_t cap = sets->cap ? 2 * sets->cap : 64;
        struct api_set *more = realloc(sets->set, cap * sizeof *more);
        if (!more) return PEND_NO_MEMORY;
        sets->set = more;
        sets->cap = cap;
    }
    sets->set[sets->count++] = (struct api_set){quantity, at, x};
    sets->quantities |= 1u << quantity;
    return PEND_OK;
}

/* lengths or masses, one per arm */
static enum pend_status read_sizes(struct api_sets *sets, const struct api_value *value,
                                   enum api_quantity quantity, const struct api_tree *tree,
                                   struct api_problem *problem) {
    int count, lone = api_value_kind(value) == API_NUMBER;
    if (!tree->tree || api_field_numbers(value, tree->n, "arm", NULL, problem) <= 0) return PEND_OK;
    const double one = api_value_number(value);
    const double *number = lone ? &one : api_value_numbers(value, &count);
    for (int k = 0; k < tree->n; k++) {
        struct api_value item = lone ? *value : api_value_item(value, k);
        if (!(number[k] > 0))
            api_value_fault(&item, problem, API_CODE_OUT_OF_RANGE "must be greater than 0, got %g",
                            number[k]);
        PEND_TRY(sets_add(sets, quantity, tree->tree->place[k], number[k]));
    }
    return PEND_OK;
}

static int is_found(const struct api_target *target) {
    if (target->quantity == API_VARY_GRAVITY || target->quantity == API_VARY_ENERGY) return 1;
    return target->quantity == API_VARY_TERM ? target->place >= 0 : target->arm >= 0;
}

/* the error of a number, NULL if it is valid */
static const char *value_fault(const struct api_target *target, const struct api_tree *tree,
                               double x) {
    int size = target->quantity == API_VARY_LENGTH || target->quantity == API_VARY_MASS;
    if (size && !(x > 0)) return "must be greater than 0";
    if (target->quantity != API_VARY_TERM) return NULL;
    return pend_terms_fits(tree->loads.terms, target->place, x)
               ? NULL
               : "is out of range for this number of a pendulum";
}

static enum pend_status read_set(struct api_sets *sets, const struct api_value *value,
                                 const struct api_tree *tree, struct api_problem *problem) {
    struct api_value number = api_value_member(value, "value"),
                     unit = api_value_member(value, "unit");
    struct api_target target;
    int degrees = 0;
    double x = 0;
    if (!api_field_object(value, set_fields, problem)) return PEND_OK;
    int named = api_energy_target(&target, value, problem) ||
                api_target_read(&target, value, tree, problem);
    if (api_field_word(&unit, api_field_angles, &degrees, problem) > 0 && named &&
        target.quantity > API_VARY_THETAD)
        api_value_fault(&unit, problem,
                        API_CODE_NOT_APPLICABLE "is only for angles and their rates: leave it out");
    if (!api_field_needed(&number, problem) ||
        api_value_read_number(&number, -INFINITY, INFINITY, "", &x, problem) <= 0)
        return PEND_OK;
    if (!named || !tree->tree || !is_found(&target)) return PEND_OK;
    const char *fault = value_fault(&target, tree, x);
    if (fault) api_value_fault(&number, problem, API_CODE_OUT_OF_RANGE "%s, got %g", fault, x);
    return sets_add(sets, target.quantity,
                    target.quantity == API_VARY_TERM ? target.place : target.arm,
                    degrees ? M_PI / 180 * x : x);
}

/* reads a number that has a field of its own */
static enum pend_status read_one(struct api_sets *sets, const struct api_value *value,
                                 const char *unit, enum api_quantity quantity,
                                 struct api_problem *problem) {
    double x = 0;
    if (api_value_read_number(value, -INFINITY, INFINITY, unit, &x, problem) <= 0) return PEND_OK;
    return sets_add(sets, quantity, -1, x);
}

enum pend_status api_sets_read(struct api_sets *sets, long i, const struct api_value *member,
                               const struct api_tree *tree, struct api_problem *problem) {
    struct api_value length = api_value_member(member, "length"),
                     mass = api_value_member(member, "mass"),
                     gravity = api_value_member(member, "gravity"),
                     energy = api_value_member(member, "energy"),
                     set = api_value_member(member, "set");
    assert(i >= sets->read && i < sets->members);
    // members that are not objects have no numbers
    while (sets->read < i) sets->from[++sets->read] = sets->count;
    PEND_TRY(read_sizes(sets, &length, API_VARY_LENGTH, tree, problem));
    PEND_TRY(read_sizes(sets, &mass, API_VARY_MASS, tree, problem));
    PEND_TRY(read_one(sets, &gravity, "m/s^2", API_VARY_GRAVITY, problem));
    PEND_TRY(read_one(sets, &energy, "J", API_VARY_ENERGY, problem));
    struct api_value item = api_value_item(&set, 0);
    if (api_value_kind(&set) != API_MISSING && api_value_kind(&set) != API_ARRAY)
        api_value_fault(&set, problem,
                        API_CODE_WRONG_TYPE
                        "must be an array of objects with \"vary\" and \"value\"");
    else
        for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
            PEND_TRY(read_set(sets, &item, tree, problem));
    sets->from[++sets->read] = sets->count;
    return PEND_OK;
}

const struct api_set *api_sets_begin(const struct api_sets *sets, long i) {
    assert(i >= 0 && i < sets->read);
    return sets->set + sets->from[i];
}

const struct api_set *api_sets_end(const struct api_sets *sets, long i) {
    assert(i >= 0 && i < sets->read);
    return sets->set + sets->from[i + 1];
}

int api_sets_energies(const struct api_sets *sets) {
    return (int)(sets->quantities >> API_VARY_ENERGY & 1);
}

int api_sets_energy(const struct api_sets *sets, long i) {
    const struct api_set *end = api_sets_end(sets, i);
    for (const struct api_set *set = api_sets_begin(sets, i); set < end; set++)
        if (set->quantity == API_VARY_ENERGY) return 1;
    return 0;
}

int api_sets_moves(const struct api_sets *sets, long i) {
    const struct api_set *end = api_sets_end(sets, i);
    for (const struct api_set *set = api_sets_begin(sets, i); set < end; set++)
        if ((set->quantity == API_VARY_PHID || set->quantity == API_VARY_THETAD) && set->x != 0)
            return 1;
    return 0;
}

int api_sets_shapes(const struct api_sets *sets) {
    return (sets->quantities & (1u << API_VARY_LENGTH | 1u << API_VARY_MASS |
                                1u << API_VARY_GRAVITY | 1u << API_VARY_TERM)) != 0;
}

enum pend_status api_sets_places(const struct api_sets *sets, int count, int places[], int *found) {
    char *seen = calloc((size_t)count, 1);
    if (!seen) return PEND_NO_MEMORY;
    *found = 0;
    for (size_t j = 0; j < sets->count; j++) {
        const struct api_set *set = &sets->set[j];
        if (set->quantity != API_VARY_TERM || seen[set->at]) continue;
        seen[set->at] = 1;
        places[(*found)++] = set->at;
    }
    free(seen);
    return PEND_OK;
}

double api_sets_bytes(const struct api_sets *sets) {
    return (double)sizeof *sets + (double)(sets->members + 1) * sizeof(size_t) +
           (double)sets->cap * sizeof *sets->set;
}
