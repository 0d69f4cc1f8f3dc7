#include "api/read/terms_json.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- storing numbers */

static void terms_put(struct api_terms *terms, enum pend_term_row row, int i, double x) {
    double usual = api_terms_usual(row), *number = terms->row[row];
    assert(i >= 0 && i < terms->n);
    if (!number && x == usual) return;
    if (!number) {
        number = terms->row[row] = malloc((size_t)terms->n * sizeof *number);
        if (!number) {
            terms->status = PEND_NO_MEMORY;
            return;
        }
        for (int k = 0; k < terms->n; k++) number[k] = usual;
    }
    number[i] = x;
}

/* returns the next harmonic; NULL if memory is short */
static struct api_harmonic *terms_harmonic(struct api_terms *terms, int drives) {
    assert(terms->harmonics <= terms->room && drives <= terms->n);
    if (terms->harmonics == terms->room) {
        int room = terms->room ? 2 * terms->room : 8;
        struct api_harmonic *more =
            realloc(terms->harmonic, (size_t)room * sizeof *terms->harmonic);
        if (!more) {
            terms->status = PEND_NO_MEMORY;
            return NULL;
        }
        terms->harmonic = more;
        terms->room = room;
    }
    terms->harmonic[terms->harmonics] = (struct api_harmonic){.drives = drives};
    return &terms->harmonic[terms->harmonics++];
}

/* ---- reading fields */

static void read_point(struct api_terms *terms, const struct api_terms_part *part, int i,
                       const struct api_value *value) {
    int count = 0;
    char found[API_FOUND_BYTES];
    const double *pair = api_value_numbers(value, &count);
    if (api_value_kind(value) == API_NUMBER) {
        terms_put(terms, part->row, i, api_value_number(value));
        terms_put(terms, part->row + 1, i, 0);
    } else if (pair && count == 2) {
        terms_put(terms, part->row, i, pair[0]);
        terms_put(terms, part->row + 1, i, pair[1]);
    } else if (!api_problem_full(terms->problem)) {
        api_value_found(value, found);
        api_value_fault(
            value, terms->problem,
            API_CODE_WRONG_TYPE
            "must be one number (metres along the arm) or two ([along, across]), got %s",
            found);
    }
}

static void read_part(struct api_terms *terms, const struct api_terms_part *part, int i,
                      const struct api_value *value) {
    double x = api_terms_usual(part->row);
    if (part->needed && !api_field_needed(value, terms->problem)) return;
    if (part->point) {
        read_point(terms, part, i, value);
        return;
    }
    if (!part->needed) api_value_usual_number(value, x);
    if (api_value_read_number(value, part->least, INFINITY, part->unit, &x, terms->problem) >= 0)
        terms_put(terms, part->row, i, x);
}

static void read_object(struct api_terms *terms, const struct api_terms_row *field, int i,
                        const struct api_value *value) {
    const char *names[API_TERMS_PARTS + 1] = {NULL};
    if (!api_field_object(value, NULL, terms->problem)) return;
    for (int p = 0; field->part[p].unit; p++) names[p] = field->part[p].name;
    (void)api_value_only(value, names, terms->problem);
    for (int p = 0; names[p]; p++) {
        read_part(terms, &field->part[p], i, API_MEMBER(value, names[p]));
    }
    api_value_usual_object(value);
}

static void read_harmonic(struct api_terms *terms, int drives, const struct api_value *value) {
    static const char *const names[] = {"amplitude", "omega", "phase", NULL};
    if (!api_field_object(value, names, terms->problem)) return;
    struct api_harmonic *harmonic = terms_harmonic(terms, drives);
    for (int p = 0; harmonic && p < 3; p++) {
        struct api_value part = api_value_member(value, names[p]);
        if (p == 2)
            api_value_usual_number(&part, 0);
        else if (!api_field_needed(&part, terms->problem))
            continue;
        (void)api_value_read_number(&part, -INFINITY, INFINITY, "", &harmonic->part[p],
                                    terms->problem);
    }
}

static void read_harmonics(struct api_terms *terms, int drives, const struct api_value *drive) {
    struct api_value list = api_value_member(drive, "harmonics");
    char found[API_FOUND_BYTES];
    if (api_value_kind(&list) == API_MISSING) return;
    api_value_usual_zeros(&list);
    if (api_value_kind(&list) != API_ARRAY) {
        api_value_found(&list, found);
        api_value_fault(&list, terms->problem,
                        API_CODE_WRONG_TYPE "must be an array of harmonics, got %s", found);
        return;
    }
    if (api_value_count(&list) > API_TERMS_HARMONICS) {
        api_value_fault(&list, terms->problem,
                        API_CODE_LIMIT "has %d harmonics, more than the %d that it may have",
                        api_value_count(&list), API_TERMS_HARMONICS);
        return;
    }
    API_VALUE_EACH (item, api_value_first(&list)) read_harmonic(terms, drives, &item);
}

/* the parts of a drive, which are added up */
static const char *const drive_names[] = {"constant", "harmonics", "table", NULL};

static void read_table(struct api_terms *terms, int drives, const struct api_value *drive) {
    struct api_value table = api_value_member(drive, "table");
    if (api_value_kind(&table) == API_MISSING) return;
    if (api_rules_read_table(&terms->rules, drives, &table, terms->problem) != PEND_OK)
        terms->status = PEND_NO_MEMORY;
}

static void read_drive(struct api_terms *terms, const struct api_terms_row *field, int i,
                       const struct api_value *value) {
    char found[API_FOUND_BYTES];
    if (api_value_kind(value) == API_NUMBER) {
        read_part(terms, field->part, i, value);
    } else if (api_value_kind(value) == API_OBJECT) {
        (void)api_value_only(value, drive_names, terms->problem);
        read_part(terms, field->part, i, API_MEMBER(value, "constant"));
        read_harmonics(terms, i, value);
        read_table(terms, i, value);
        api_value_usual_object(value);
    } else if (!api_problem_full(terms->problem)) {
        api_value_found(value, found);
        api_value_fault(value, terms->problem,
                        API_CODE_WRONG_TYPE
                        "must be a number of N m, or an object with \"constant\", "
                        "\"harmonics\" and \"table\", got %s",
                        found);
    }
}

/* whether dry friction is Coulomb's, which has no "speed" */
static int is_coulomb(const struct api_value *value) {
    return api_value_kind(value) == API_OBJECT &&
           api_value_kind(API_MEMBER(value, "speed")) == API_MISSING;
}

static void read_rule(struct api_terms *terms, enum pend_status status) {
    if (status != PEND_OK) terms->status = status;
}

static const char *const field_names[API_TERMS_FIELDS] = {API_TERMS_OF_ARMS};

static long fault_count(const struct api_problem *problem) {
    return problem->count + problem->beyond;
}

static void read_field(struct api_terms *terms, int f, int i, const struct api_value *value) {
    long faults = fault_count(terms->problem);
    if (api_value_kind(value) == API_NULL) {
        api_value_usual(value);
        return;
    }
    if (!terms->given) terms->given = calloc((size_t)terms->n, sizeof *terms->given);
    if (!terms->given) {
        terms->status = PEND_NO_MEMORY;
        return;
    }
    const struct api_terms_row *field = api_terms_row((enum api_terms_field)f);
    if (field->kind == API_TERMS_PLAIN)
        read_part(terms, field->part, i, value);
    else if (field->kind == API_TERMS_STOPS)
        read_rule(terms, api_rules_read_stop(&terms->rules, terms->n, i, value, terms->problem));
    else if (field->kind == API_TERMS_RUBS && is_coulomb(value))
        read_rule(terms, api_rules_read_friction(&terms->rules, terms->n, i, "torque", value,
                                                 terms->problem));
    else if (field->kind == API_TERMS_OBJECT || field->kind == API_TERMS_RUBS)
        read_object(terms, field, i, value);
    else
        read_drive(terms, field, i, value);
    terms->given[i] |= (unsigned short)(1U << f);
    if (fault_count(terms->problem) > faults) terms->given[i] |= 1U << API_TERMS_FAULTY;
}

/* ---- the whole pendulum */

void api_terms_init(struct api_terms *terms, int n, struct api_problem *problem) {
    assert(n >= 1 && !strcmp(field_names[API_TERMS_STOP], api_terms_row(API_TERMS_STOP)->name));
    *terms = (struct api_terms){.n = n, .problem = problem};
}

static void terms_rules_clear(struct api_rules *rules) {
    for (int i = 0; i < rules->tables; i++) free((void *)rules->table[i].t);
    free(rules->table);
    free(rules->joint);
    free(rules->controller);
    free(rules->law);
    free(rules->number);
    *rules = (struct api_rules){0};
}

void api_terms_clear(struct api_terms *terms) {
    for (int r = 0; r < PEND_TERM_ROWS; r++) free(terms->row[r]);
    free(terms->given);
    free(terms->harmonic);
    terms_rules_clear(&terms->rules);
    *terms = (struct api_terms){0};
}

void api_terms_read_arm(struct api_terms *terms, const struct api_value *arm) {
    assert(arm->index >= 0 && arm->index < terms->n);
    API_VALUE_EACH (member, api_value_first(arm))
        for (int f = 0; f < API_TERMS_FIELDS; f++)
            if (!strcmp(member.key, field_names[f])) read_field(terms, f, arm->index, &member);
}

static void read_list(struct api_terms *terms, int f, const struct api_value *list) {
    char found[API_FOUND_BYTES];
    enum api_kind kind = api_value_kind(list);
    // with one arm the entry need not be in a list, because some encoders of arrays omit it
    if (terms->n == 1 && (kind == API_NUMBER || kind == API_OBJECT)) {
        read_field(terms, f, 0, list);
        return;
    }
    if (kind != API_ARRAY) {
        api_value_found(list, found);
        api_value_fault(list, terms->problem,
                        API_CODE_WRONG_COUNT
                        "must be an array of %d entries, one for each arm (null for none), got %s",
                        terms->n, found);
        return;
    }
    if (api_value_count(list) != terms->n) {
        api_value_fault(list, terms->problem,
                        API_CODE_WRONG_COUNT
                        "must have %d entries, one for each arm (null for none), got %d",
                        terms->n, api_value_count(list));
        return;
    }
    if (f != API_TERMS_ROD && f != API_TERMS_AT) api_value_usual_zeros(list);
    API_VALUE_EACH (item, api_value_first(list)) read_field(terms, f, item.index, &item);
}

void api_terms_read_lists(struct api_terms *terms, const struct api_value *pendulum,
                          const char *form) {
    for (int f = 0; f < API_TERMS_FIELDS; f++) {
        struct api_value list = api_value_member(pendulum, field_names[f]);
        if (api_value_kind(&list) == API_MISSING) continue;
        if (form)
            api_value_fault(&list, terms->problem,
                            API_CODE_CONFLICT
                            "cannot be combined with %s: it is a field of each arm of \"arms\", "
                            "or a list next to \"length\", \"mass\" and \"parent\"",
                            form);
        else
            read_list(terms, f, &list);
    }
}

/* reads the force along the rail: a number, or a constant and harmonics */
static void read_cart_force(struct api_terms *terms, const struct api_value *force) {
    struct api_value constant = *force;
    if (api_value_kind(force) == API_OBJECT) {
        (void)api_value_only(force, drive_names, terms->problem);
        constant = api_value_member(force, "constant");
        read_harmonics(terms, terms->n, force);
        read_table(terms, terms->n, force);
        api_value_usual_object(force);
    }
    api_value_usual_number(&constant, 0);
    (void)api_value_read_number(&constant, -INFINITY, INFINITY, "N", &terms->cart.force,
                                terms->problem);
}

static void read_cart(struct api_terms *terms, const struct api_value *cart) {
    static const char *const names[] = {"mass",  "angle",    "damping", "stiffness",
                                        "force", "friction", "stop",    NULL};
    struct api_cart *read = &terms->cart;
    const struct {
        double least;
        const char *unit;
        double *to;
    } part[] = {{DBL_MIN, "kg", &read->mass},
                {-INFINITY, "rad", &read->angle},
                {0, "N s/m", &read->damping},
                {0, "N/m", &read->stiffness}};
    read->given = read->mass = 1;
    if (!api_field_object(cart, names, terms->problem)) return;
    for (int i = 0; i < 4; i++) {
        struct api_value field = api_value_member(cart, names[i]);
        if (i)
            api_value_usual_number(&field, 0);
        else if (!api_field_needed(&field, terms->problem))
            continue;
        (void)api_value_read_number(&field, part[i].least, INFINITY, part[i].unit, part[i].to,
                                    terms->problem);
    }
    struct api_value force = api_value_member(cart, names[4]);
    if (api_value_kind(&force) != API_MISSING) read_cart_force(terms, &force);
    struct api_value friction = api_value_member(cart, names[5]),
                     stop = api_value_member(cart, names[6]);
    if (api_value_kind(&friction) != API_MISSING &&
        api_field_object(&friction, NULL, terms->problem))
        read_rule(terms, api_rules_read_friction(&terms->rules, terms->n, terms->n, "force",
                                                 &friction, terms->problem));
    if (api_value_kind(&stop) != API_MISSING)
        read_rule(terms,
                  api_rules_read_stop(&terms->rules, terms->n, terms->n, &stop, terms->problem));
}

static void read_pivot(struct api_terms *terms, const struct api_value *pivot) {
    static const char *const names[] = {"x", "y", "acceleration", "cart", NULL},
                             *const of_axis[] = {"harmonics", "table", NULL};
    if (!api_field_object(pivot, names, terms->problem)) return;
    for (int axis = 0; axis < 2; axis++) {
        struct api_value drive = api_value_member(pivot, names[axis]);
        if (api_value_kind(&drive) == API_MISSING ||
            !api_field_object(&drive, of_axis, terms->problem))
            continue;
        int drives = axis ? PEND_DRIVE_PIVOT_Y : PEND_DRIVE_PIVOT_X;
        read_harmonics(terms, drives, &drive);
        read_table(terms, drives, &drive);
        api_value_usual_object(&drive);
    }
    double both[2] = {0, 0};
    struct api_value acceleration = api_value_member(pivot, "acceleration"),
                     cart = api_value_member(pivot, "cart");
    api_value_usual_zeros(&acceleration);
    if (api_field_numbers(&acceleration, 2, "coordinate", both, terms->problem) > 0)
        memcpy(&terms->one[PEND_TERM_PIVOT_ACCELERATION_X], both, sizeof both);
    if (api_value_kind(&cart) != API_MISSING) {
        if (api_value_count(pivot) > 1)
            api_value_fault(
                pivot, terms->problem,
                API_CODE_CONFLICT
                "is either moved, by \"x\", \"y\" and \"acceleration\", or carried by a "
                "\"cart\": give one of the two");
        read_cart(terms, &cart);
        return;
    }
    api_value_usual_object(pivot);
}

void api_terms_read_whole(struct api_terms *terms, const struct api_value *pendulum) {
    struct api_value drag = api_value_member(pendulum, "drag_per_mass"),
                     pivot = api_value_member(pendulum, "pivot");
    api_value_usual_number(&drag, 0);
    (void)api_value_read_number(&drag, 0, INFINITY, "1/s", &terms->one[PEND_TERM_DRAG_PER_MASS],
                                terms->problem);
    if (api_value_kind(&pivot) != API_MISSING) read_pivot(terms, &pivot);
}

int api_terms_bare(const struct api_terms *terms, int i) {
    assert(i >= 0 && i < terms->n);
    // if memory ran out, numbers may be missing, so only that is reported
    if (terms->status != PEND_OK) return 1;
    return api_terms_has(terms, API_TERMS_ROD, i) || api_terms_has(terms, API_TERMS_BODY, i);
}

void api_terms_check(const struct api_terms *terms, const int parent[], api_terms_fault_fn *fault,
                     void *context) {
    for (int i = 0; terms->given && i < terms->n; i++) {
        if (parent[i] == -1 && api_terms_has(terms, API_TERMS_AT, i))
            fault(context, "at", i, "has no meaning for the arm at the pivot: leave it out");
        if (api_terms_has(terms, API_TERMS_REST, i) &&
            !api_terms_has(terms, API_TERMS_STIFFNESS, i))
            fault(context, "rest", i,
                  "is the angle at which a spring is relaxed, and needs a \"stiffness\"");
    }
}
