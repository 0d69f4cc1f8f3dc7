#include "api/read/tree_json.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/read/arm_names.h"
#include "api/read/control_json.h"
#include "api/read/terms_json.h"

enum form { FORM_ARMS, FORM_LISTS, FORM_PAPER, FORM_COUNT };

/* the fields of each form, and the field at which errors found by core are reported */
static const struct {
    const char *summary;
    const char *field[3];
    const char *blamed[PEND_FIELD_PATH + 1];
} forms[FORM_COUNT] = {
    [FORM_ARMS] = {"\"arms\"",
                   {"arms"},
                   {[PEND_FIELD_LENGTH] = "length",
                    [PEND_FIELD_MASS] = "mass",
                    [PEND_FIELD_PARENT] = "parent"}},
    [FORM_LISTS] = {"\"length\", \"mass\" and \"parent\"",
                    {"length", "mass", "parent"},
                    {[PEND_FIELD_LENGTH] = "length",
                     [PEND_FIELD_MASS] = "mass",
                     [PEND_FIELD_PARENT] = "parent"}},
    [FORM_PAPER] = {"\"L\", \"m\" and \"S\"",
                    {"L", "m", "S"},
                    {[PEND_FIELD_LENGTH] = "L", [PEND_FIELD_MASS] = "m", [PEND_FIELD_PATH] = "S"}},
};

static const double usual_gravity = 9.81; /* m/s^2 */

static const char *const tree_fields[] = {
    "arms",    "length",  "mass",           "parent",          "L", "m", "S",
    "gravity", "control", API_TERMS_OF_ALL, API_TERMS_OF_ARMS, NULL};
static const char *const arm_fields[] = {"name", "parent",          "length",
                                         "mass", API_TERMS_OF_ARMS, NULL};

struct tree_reading {
    const struct api_value *pendulum;
    struct api_problem *problem;
    char at[API_POINTER_BYTES]; /* the pointer of the pendulum itself */
    enum form form;
    int n;
    double *length, *mass;  /* n each; NAN = an error was added already */
    struct api_terms terms; /* the terms beyond the ideal pendulum */
    unsigned char *bare;    /* n flags: the mass at the tip may be 0; NULL = it never may */
    int *parent; /* n numbers from 0, -1 = the pivot, or API_ARM_FAULTY; the three arrays are one
                  * block, which begins with length */
};

/* ---- errors */

static long fault_count(const struct api_problem *problem) {
    return problem->count + problem->beyond;
}

/* adds an error at entry i (and j) of a field of the form, or with -1 at the field as a whole */
static void tree_fault(const struct tree_reading *reading, const char *field, int i, int j,
                       const char *text) {
    char pointer[API_POINTER_BYTES + 64];
    if (api_problem_full(reading->problem)) return;
    struct api_value list = api_value_member(reading->pendulum, field);
    if (reading->form != FORM_ARMS && api_value_kind(&list) == API_NUMBER) i = -1;
    size_t used = (size_t)snprintf(pointer, sizeof pointer, "%s", reading->at),
           room = sizeof pointer - used;
    if (reading->form == FORM_ARMS && i >= 0)
        snprintf(pointer + used, room, "/arms/%d/%s", i, field);
    else if (reading->form == FORM_ARMS)
        snprintf(pointer + used, room, "/arms");
    else if (i < 0)
        snprintf(pointer + used, room, "/%s", field);
    else if (j < 0)
        snprintf(pointer + used, room, "/%s/%d", field, i);
    else
        snprintf(pointer + used, room, "/%s/%d/%d", field, i, j);
    int shape = !strcmp(field, "parent") || !strcmp(field, "S");
    if (shape)
        api_problem_fault(reading->problem, pointer, API_CODE_NOT_A_TREE "%s", text);
    else
        api_problem_fault(reading->problem, pointer, API_CODE_OUT_OF_RANGE "%s", text);
}

/* true for an error that was added before, or follows from one that was */
static int fault_is_known(const struct tree_reading *reading, enum pend_field field, int i) {
    if (field == PEND_FIELD_LENGTH) return i >= 0 && isnan(reading->length[i]);
    if (field == PEND_FIELD_MASS) return i >= 0 && isnan(reading->mass[i]);
    if (field != PEND_FIELD_PARENT) return 0;
    if (i >= 0) return reading->parent[i] == API_ARM_FAULTY;
    for (int k = 0; k < reading->n; k++)
        if (reading->parent[k] == API_ARM_FAULTY) return 1;
    return 0;
}

static void tree_report(void *context, enum pend_field field, int i, int j, const char *text) {
    const struct tree_reading *reading = context;
    const char *name = forms[reading->form].blamed[field];
    if (name && !fault_is_known(reading, field, i))
        tree_fault(reading, name, i, j, text ? text : "is invalid");
}

static void term_fault(void *context, const char *field, int i, const char *text) {
    const struct tree_reading *reading = context;
    int mass = !strcmp(field, "mass");
    tree_fault(reading, mass ? forms[reading->form].blamed[PEND_FIELD_MASS] : field, i, -1, text);
}

/* whether a mass may be missing or null, because a rod or a body has mass */
static int mass_is_spared(const struct tree_reading *reading, const struct api_value *mass, int i) {
    enum api_kind kind = api_value_kind(mass);
    return (kind == API_MISSING || kind == API_NULL) && api_terms_bare(&reading->terms, i);
}

/* ---- the form with names */

/* reads a length or a mass; core checks its range */
static double arm_number(const struct api_value *field, struct api_problem *problem) {
    double number = NAN;
    if (api_field_needed(field, problem))
        (void)api_value_read_number(field, -INFINITY, INFINITY, "", &number, problem);
    return number;
}

static void read_arm(struct tree_reading *reading, struct api_arm_names *names,
                     const struct api_value *arm) {
    int i = arm->index;
    api_arm_names_take(names, arm, reading->problem);
    reading->length[i] = reading->mass[i] = NAN;
    if (!api_field_object(arm, arm_fields, reading->problem)) return;
    struct api_value mass = api_value_member(arm, "mass");
    reading->length[i] = arm_number(API_MEMBER(arm, "length"), reading->problem);
    api_terms_read_arm(&reading->terms, arm);
    reading->mass[i] = mass_is_spared(reading, &mass, i) ? 0 : arm_number(&mass, reading->problem);
}

static enum pend_status read_arms(struct tree_reading *reading, const char ***kept) {
    struct api_arm_names names;
    struct api_value arms = api_value_member(reading->pendulum, "arms"), arm;
    PEND_TRY(api_arm_names_init(&names, reading->n));
    for (arm = api_value_item(&arms, 0); api_value_kind(&arm) != API_MISSING;
         arm = api_value_next(&arm))
        read_arm(reading, &names, &arm);
    api_arm_names_sort(&names, &arms, reading->problem);
    for (arm = api_value_item(&arms, 0); api_value_kind(&arm) != API_MISSING;
         arm = api_value_next(&arm))
        reading->parent[arm.index] = api_arm_names_parent(&names, &arm, reading->problem);
    enum pend_status status = api_arm_names_keep(&names, kept);
    api_arm_names_clear(&names);
    return status;
}

/* ---- the forms with lists */

static void read_list(const struct tree_reading *reading, const char *name, double out[]) {
    struct api_value field = api_value_member(reading->pendulum, name);
    for (int i = 0; i < reading->n; i++) out[i] = NAN;
    if (api_field_needed(&field, reading->problem))
        (void)api_field_numbers(&field, reading->n, "arm", out, reading->problem);
}

/* reads the list of masses, in which a mass at the tip is optional for some arms */
static void read_bare_masses(const struct tree_reading *reading) {
    struct api_value field = api_value_member(reading->pendulum, "mass"), item;
    int spared = 0, n = reading->n;
    for (int i = 0; i < n; i++) reading->mass[i] = NAN;
    if (api_value_kind(&field) == API_MISSING) {
        for (int i = 0; i < n; i++) {
            reading->mass[i] = mass_is_spared(reading, &field, i) ? 0 : NAN;
            spared += !isnan(reading->mass[i]);
        }
        if (spared < n) (void)api_field_needed(&field, reading->problem);
        return;
    }
    if (api_value_kind(&field) != API_ARRAY || api_value_count(&field) != n) {
        (void)api_field_numbers(&field, n, "arm", reading->mass, reading->problem);
        return;
    }
    for (item = api_value_first(&field); api_value_kind(&item) != API_MISSING;
         item = api_value_next(&item))
        reading->mass[item.index] =
            mass_is_spared(reading, &item, item.index) ? 0 : arm_number(&item, reading->problem);
}

/* reads parents as numbers from 1, 0 = the pivot */
static enum pend_status read_parents(struct tree_reading *reading) {
    double *number = malloc((size_t)reading->n * sizeof *number);
    if (!number) return PEND_NO_MEMORY;
    read_list(reading, "parent", number);
    for (int i = 0; i < reading->n; i++) {
        char text[120];
        double x = number[i];
        int good = x >= 0 && x <= reading->n && x == floor(x);
        reading->parent[i] = good ? (int)x - 1 : API_ARM_FAULTY;
        if (good || isnan(x)) continue;
        snprintf(text, sizeof text,
                 "must be 0 (the pivot) or the number of an arm, 1 to %d, got %.15g", reading->n,
                 x);
        tree_fault(reading, "parent", i, -1, text);
    }
    free(number);
    return PEND_OK;
}

/* copies the rows of S into one array; returns true if each has n numbers */
static int read_rows(const struct tree_reading *reading, const struct api_value *matrix,
                     double path[]) {
    int n = reading->n, good = 1;
    if (api_value_kind(matrix) == API_NUMBER) return api_field_numbers(matrix, n, "", path, NULL);
    API_VALUE_EACH (row, api_value_item(matrix, 0))
        good &= api_field_numbers(&row, n, "arm", path + (size_t)row.index * (size_t)n,
                                  reading->problem) > 0;
    return good;
}

/* computes the parents from a path matrix of n rows */
static enum pend_status read_matrix(struct tree_reading *reading, const struct api_value *matrix) {
    struct pend_fault_sink sink = {tree_report, reading, API_PROBLEM_FAULTS};
    size_t n = (size_t)reading->n;
    if (n > SIZE_MAX / n / sizeof(double)) return PEND_NO_MEMORY;
    double *path = malloc(n * n * sizeof *path);
    if (!path) return PEND_NO_MEMORY;
    enum pend_status status = PEND_INVALID;
    if (read_rows(reading, matrix, path))
        status = pend_tree_parent_from_path(reading->n, path, reading->parent, &sink);
    free(path);
    return status;
}

static enum pend_status read_path(struct tree_reading *reading) {
    struct api_value matrix = api_value_member(reading->pendulum, "S");
    enum pend_status status = PEND_INVALID;
    int n = reading->n, rows = api_value_kind(&matrix) == API_ARRAY ? api_value_count(&matrix) : -1;
    if (rows == n || (n == 1 && api_value_kind(&matrix) == API_NUMBER))
        status = read_matrix(reading, &matrix);
    else if (api_field_needed(&matrix, reading->problem))
        api_value_fault(&matrix, reading->problem,
                        API_CODE_WRONG_COUNT
                        "must be an array of %d rows of %d numbers, one for each arm%s",
                        n, n, n == 2 ? ", as [[1, 0], [1, 1]]" : "");
    for (int i = 0; status != PEND_OK && i < n; i++) reading->parent[i] = API_ARM_FAULTY;
    return status == PEND_INVALID
               ? PEND_OK
               : status; /* errors were added; the rest of the request is still to be checked */
}

/* ---- the whole tree */

/* the form whose fields are present, or FORM_COUNT; adds errors for fields of a second form */
static enum form tree_form(const struct api_value *pendulum, struct api_problem *problem) {
    enum form found = FORM_COUNT;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        enum form form = (enum form)(i / 3);
        if (!forms[form].field[i % 3]) continue;
        struct api_value field = api_value_member(pendulum, forms[form].field[i % 3]);
        if (api_value_kind(&field) == API_MISSING) continue;
        if (found == FORM_COUNT) found = form;
        if (found != form)
            api_value_fault(
                &field, problem,
                API_CODE_CONFLICT
                "belongs to another form of a tree than %s, which is given too: use one form",
                forms[found].summary);
    }
    if (found == FORM_COUNT && !api_value_meant(pendulum, NULL, problem))
        api_value_fault(
            pendulum, problem, API_CODE_MISSING "must describe the arms: by %s, or by %s, or by %s",
            forms[FORM_ARMS].summary, forms[FORM_LISTS].summary, forms[FORM_PAPER].summary);
    return found;
}

/* the length of the form's first list, or 1 for a number; 0 if no list has items, which is reported
 * separately */
static int tree_count(const struct tree_reading *reading) {
    int lone = 0;
    for (int i = 0; i < 3 && forms[reading->form].field[i]; i++) {
        struct api_value field = api_value_member(reading->pendulum, forms[reading->form].field[i]);
        if (api_value_kind(&field) == API_ARRAY && api_value_count(&field))
            return api_value_count(&field);
        lone |= reading->form != FORM_ARMS && api_value_kind(&field) == API_NUMBER;
    }
    return lone;
}

static void fault_empty(const struct tree_reading *reading) {
    char found[API_FOUND_BYTES];
    for (int i = 0; i < 3 && forms[reading->form].field[i]; i++) {
        struct api_value field = api_value_member(reading->pendulum, forms[reading->form].field[i]);
        api_value_found(&field, found);
        if (api_value_kind(&field) == API_ARRAY)
            api_value_fault(&field, reading->problem,
                            API_CODE_WRONG_COUNT "is empty, but a tree has at least one arm");
        else if (api_field_needed(&field, reading->problem))
            api_value_fault(&field, reading->problem,
                            API_CODE_WRONG_TYPE "must be an array, one entry for each arm, got %s",
                            found);
    }
}

static enum pend_status read_form(struct tree_reading *reading, const char ***names) {
    if (reading->form == FORM_ARMS) return read_arms(reading, names);
    read_list(reading, forms[reading->form].field[0], reading->length);
    if (reading->form == FORM_LISTS) api_terms_read_lists(&reading->terms, reading->pendulum, NULL);
    if (reading->terms.given)
        read_bare_masses(reading);
    else
        read_list(reading, forms[reading->form].field[1], reading->mass);
    return reading->form == FORM_LISTS ? read_parents(reading) : read_path(reading);
}

/* makes a cart arm n, after the caller's arms, which carries all arms at the pivot */
static void hang_on_cart(struct tree_reading *reading) {
    int n = reading->n;
    assert(n >= 1 && reading->terms.cart.given);
    for (int i = 0; i < n; i++)
        if (reading->parent[i] == -1) reading->parent[i] = n;
    reading->length[n] = 1;
    reading->mass[n] = reading->terms.cart.mass;
    reading->parent[n] = -1;
    reading->bare[n] = 0;
}

static enum pend_status read_whole(struct tree_reading *reading, struct api_tree *tree) {
    struct pend_fault_sink sink = {tree_report, reading, API_PROBLEM_FAULTS};
    size_t n = (size_t)reading->n;
    // n + 1, because there may be a cart
    reading->length = malloc((n + 1) * (2 * sizeof(double) + sizeof(int) + 1));
    if (!reading->length) return PEND_NO_MEMORY;
    reading->mass = reading->length + n + 1;
    reading->parent = (int *)(reading->mass + n + 1);
    reading->bare = (unsigned char *)(reading->parent + n + 1);
    PEND_TRY(read_form(reading, &tree->names));
    if (reading->form != FORM_LISTS)
        api_terms_read_lists(&reading->terms, reading->pendulum, forms[reading->form].summary);
    api_terms_read_whole(&reading->terms, reading->pendulum);
    PEND_TRY(reading->terms.status);
    api_terms_check(&reading->terms, reading->parent, term_fault, reading);
    for (int i = 0; i < reading->n; i++)
        reading->bare[i] = (unsigned char)api_terms_bare(&reading->terms, i);
    tree->cart = reading->terms.cart.given;
    if (tree->cart) hang_on_cart(reading);
    PEND_TRY(pend_tree_new_bare(&tree->tree, api_tree_stored(tree), reading->length, reading->mass,
                                reading->bare, reading->parent, &sink));
    struct api_controlled of = {tree->tree, tree->cart, api_tree_read_arm, tree};
    PEND_TRY(api_control_read(&reading->terms.rules, &of, API_MEMBER(reading->pendulum, "control"),
                              reading->problem));
    PEND_TRY(api_terms_make(&reading->terms, tree->tree, &tree->terms, &tree->value, &tree->rules,
                            term_fault, reading));
    tree->loads.terms = tree->terms;
    tree->loads.value = tree->value;
    return PEND_OK;
}

enum pend_status api_tree_read(struct api_tree *tree, const struct api_value *pendulum,
                               const struct api_limits *limits, struct api_problem *problem) {
    struct tree_reading reading = {.pendulum = pendulum, .problem = problem};
    long faults = fault_count(problem);
    *tree = (struct api_tree){.loads.gravity = usual_gravity};
    if (!api_field_object(pendulum, NULL, problem)) return PEND_INVALID;
    api_value_pointer(pendulum, reading.at);
    (void)api_value_only(pendulum, tree_fields, problem);
    struct api_value gravity = api_value_member(pendulum, "gravity");
    (void)api_value_read_number(&gravity, -INFINITY, INFINITY, "m/s^2", &tree->loads.gravity,
                                problem);
    api_value_usual_number(&gravity, usual_gravity);

    // the form and the number of arms decide how the rest is read
    reading.form = tree_form(pendulum, problem);
    if (reading.form == FORM_COUNT) return PEND_INVALID;
    tree->n = reading.n = tree_count(&reading);
    if (!reading.n) fault_empty(&reading);
    if (reading.n > limits->arms)
        api_value_fault(pendulum, problem,
                        API_CODE_LIMIT "has %d arms, more than the limit max-arms of %.0f",
                        reading.n, limits->arms);
    if (!reading.n || reading.n > limits->arms) return PEND_INVALID;
    api_terms_init(&reading.terms, reading.n, problem);
    enum pend_status status = read_whole(&reading, tree);
    api_terms_clear(&reading.terms);
    free(reading.length);
    return status == PEND_OK && fault_count(problem) > faults ? PEND_INVALID : status;
}

/* checks that the parsed fields agree with the tree that was built from them */
PEND_VALIDATOR tree_read_valid(const struct api_tree *tree) {
    return tree->n >= 0 &&
           (!tree->tree || (tree->tree->n == api_tree_stored(tree) && tree->n >= 1)) &&
           !tree->terms == !tree->value && tree->loads.terms == tree->terms;
}

double api_tree_bytes(const struct api_tree *tree) {
    assert(tree_read_valid(tree));
    double bytes = 1024 + 128.0 * tree->n, rules = tree->rules ? tree->rules->numbers + 512.0 : 0;
    if (!tree->terms) return bytes;
    return bytes + sizeof(double) * rules + sizeof *tree->terms + tree->n +
           sizeof(double) * (double)tree->terms->count +
           (double)sizeof *tree->terms->harmonic * tree->terms->harmonics;
}

void api_tree_clear(struct api_tree *tree) {
    assert(tree_read_valid(tree));
    pend_tree_free(&tree->tree);
    pend_terms_free(&tree->terms);
    free(tree->value);
    free(tree->rules);
    free(tree->names);
    *tree = (struct api_tree){0};
}

void api_tree_put(const struct api_tree *tree, const double row[], double out[]) {
    const int *order = tree->tree->order;
    assert(tree_read_valid(tree));
    for (int k = tree->cart; k < api_tree_stored(tree); k++) out[order[k]] = row[k];
}

int api_tree_parent(const struct api_tree *tree, int i) {
    assert(tree->tree && i >= 0 && i < tree->n);
    int parent = tree->tree->parent[tree->tree->place[i]];
    return parent < tree->cart ? -1 : tree->tree->order[parent];
}

const char *api_tree_name(const struct api_tree *tree, int i, char scratch[16]) {
    assert(i >= 0 && i < tree->n);
    if (tree->names) return tree->names[i];
    snprintf(scratch, 16, "%d", i + 1);
    return scratch;
}

/* the caller's number, from 0, of an arm given by its number or name; -1 if there is none */
static int tree_find(const struct api_tree *tree, const struct api_value *value) {
    const char *text = api_value_text(value);
    double number = api_value_number(value);
    char scratch[16];
    if (api_value_kind(value) == API_NUMBER && number == floor(number) && number >= 1 &&
        number <= tree->n)
        return (int)number - 1;
    for (int i = 0; text && i < tree->n; i++)
        if (!strcmp(text, api_tree_name(tree, i, scratch))) return i;
    return -1;
}

int api_tree_read_arm(const struct api_tree *tree, const struct api_value *value,
                      struct api_problem *problem) {
    assert(tree_read_valid(tree));
    char found[API_FOUND_BYTES];
    if (!api_field_needed(value, problem) || !tree->tree) return -1;
    int arm = tree_find(tree, value);
    if (arm >= 0) return arm;
    api_value_found(value, found);
    api_value_fault(value, problem,
                    API_CODE_UNKNOWN_NAME
                    "must be an arm of this pendulum, a number from 1 to %d%s, got %s",
                    tree->n, tree->names ? " or an arm's name" : "", found);
    return -1;
}

void api_tree_ideal(const struct api_tree *tree, const struct api_value *value, const char *what,
                    struct api_problem *problem) {
    if (tree->terms)
        api_value_fault(
            value, problem,
            API_CODE_UNSUPPORTED
            "%s is for ideal pendulums, without rods, bodies, springs, friction and drives: use "
            "\"taylor\", or POST /v1/modes and /v1/response for small swings",
            what);
}

void api_tree_modes_allowed(const struct api_tree *tree, const struct api_value *value, int count,
                            const char *what, const struct api_limits *limits,
                            struct api_problem *problem) {
    assert(tree_read_valid(tree) && count >= 0);
    double most = limits->mode_arms * limits->mode_arms;
    if (!pend_loads_pull_down(&tree->loads))
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE "%s needs a gravity greater than 0, got %.15g", what,
                        tree->loads.gravity);
    if ((double)tree->n * count > most)
        api_value_fault(value, problem,
                        API_CODE_LIMIT "%s takes at most %.0f arms (the limit max-mode-arms) for "
                                       "all modes, and at most %.0f modes of %d arms; got %d modes",
                        what, limits->mode_arms, floor(most / tree->n), tree->n, count);
}
