#include "api/read/rules_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* s, the shortest time between two instants of a table */
static const double table_finest = 1e-9;

/* reads a list of numbers of a table; returns NULL after an error */
static const double *table_numbers(const struct api_value *list, int least, int *count,
                                   struct api_problem *problem) {
    *count = api_value_count(list);
    if (!api_field_needed(list, problem)) return NULL;
    if (api_field_numbers(list, 0, "instant", NULL, problem) < 0) return NULL;
    if (*count >= least) return api_value_numbers(list, count);
    api_value_fault(list, problem, API_CODE_WRONG_COUNT "needs %d or more entries", least);
    return NULL;
}

/* adds an error unless the instants ascend by at least a nanosecond */
static int table_ascends(const struct api_value *list, const double t[], int count,
                         struct api_problem *problem) {
    for (int i = 1; i < count; i++) {
        if (t[i] - t[i - 1] >= table_finest) continue;
        struct api_value item = api_value_item(list, i);
        api_value_fault(&item, problem,
                        API_CODE_OUT_OF_RANGE "is %.17g s, but the instant before it is %.17g s: a "
                                              "table's instants must ascend, by 1e-9 s or more",
                        t[i], t[i - 1]);
        return 0;
    }
    return 1;
}

enum pend_status api_rules_read_table(struct api_rules *rules, int drives,
                                      const struct api_value *value, struct api_problem *problem) {
    static const char *const names[] = {"t", "value", "hold", "outside", NULL},
                             *const tracks[] = {"t", "value", NULL},
                             *const holds[] = {"zero", "linear", NULL},
                             *const outsides[] = {"hold", "zero", NULL};
    struct pend_table table = {.drives = drives};
    int values = 0, hold = 0, outside = -1;
    if (!api_field_object(value, NULL, problem)) return PEND_OK;
    int track = drives < 0, least = 1 + track, numbers = 2 + 2 * track;
    (void)api_value_only(value, track ? tracks : names, problem);
    struct api_value t = api_value_member(value, "t"), x = api_value_member(value, "value"),
                     way = api_value_member(value, "hold");
    const double *instant = table_numbers(&t, least, &table.count, problem),
                 *number = table_numbers(&x, least, &values, problem);
    (void)(!track && api_field_needed(&way, problem) &&
           api_field_word(&way, holds, &hold, problem));
    (void)api_field_word(API_MEMBER(value, "outside"), outsides, &outside, problem);
    if (!instant || !number) return PEND_OK;
    if (values != table.count) {
        api_value_fault(&x, problem,
                        API_CODE_WRONG_COUNT "must have %d numbers, one for each instant, got %d",
                        table.count, values);
        return PEND_OK;
    }
    if (!table_ascends(&t, instant, table.count, problem)) return PEND_OK;
    table.linear = hold == 1;
    table.outside = (enum pend_outside)(outside + 1);
    if (rules->tables == rules->room) {
        int room = rules->room ? 2 * rules->room : 4;
        struct pend_table *more = realloc(rules->table, (size_t)room * sizeof *more);
        if (!more) return PEND_NO_MEMORY;
        rules->table = more, rules->room = room;
    }
    size_t bytes = (size_t)table.count * sizeof(double);
    double *both = malloc((size_t)numbers * bytes), *bend = both + 2 * table.count;
    if (!both) return PEND_NO_MEMORY;
    memcpy(both, instant, bytes);
    memcpy(both + table.count, number, bytes);
    table.t = both, table.value = both + table.count;
    if (track) pend_rules_spline(table.count, table.t, table.value, bend, bend + table.count);
    rules->table[rules->tables++] = table;
    return PEND_OK;
}

/* allocates rows of numbers of joints, initially without effect */
static enum pend_status rules_joints(struct api_rules *rules, int n) {
    size_t row = (size_t)n + 1;
    if (rules->joint) return PEND_OK;
    rules->n = n;
    rules->joint = calloc(API_JOINT_ROWS * row, sizeof *rules->joint);
    if (!rules->joint) return PEND_NO_MEMORY;
    for (size_t k = 0; k < row; k++) {
        rules->joint[API_JOINT_LEAST * row + k] = -INFINITY;
        rules->joint[API_JOINT_MOST * row + k] = INFINITY;
    }
    return PEND_OK;
}

static double *rules_number(const struct api_rules *rules, enum api_joint_row row, int arm) {
    return &rules->joint[(size_t)row * ((size_t)rules->n + 1) + (size_t)arm];
}

enum pend_status api_rules_read_friction(struct api_rules *rules, int n, int arm, const char *name,
                                         const struct api_value *value,
                                         struct api_problem *problem) {
    const char *names[] = {name, "static", NULL};
    struct api_value slides = api_value_member(value, name),
                     holds = api_value_member(value, "static");
    double sliding = 0, holding;
    PEND_TRY(rules_joints(rules, n));
    (void)api_value_only(value, names, problem);
    if (!api_field_needed(&slides, problem)) return PEND_OK;
    if (api_value_read_number(&slides, 0, INFINITY, "", &sliding, problem) < 0) return PEND_OK;
    holding = sliding;
    (void)api_value_read_number(&holds, sliding, INFINITY, "", &holding, problem);
    *rules_number(rules, API_JOINT_SLIDING, arm) = sliding;
    *rules_number(rules, API_JOINT_HOLDING, arm) = holding;
    rules->rubs |= holding > 0;
    return PEND_OK;
}

enum pend_status api_rules_read_stop(struct api_rules *rules, int n, int arm,
                                     const struct api_value *value, struct api_problem *problem) {
    static const char *const names[] = {"min", "max", "restitution", NULL};
    struct api_value low = api_value_member(value, "min"), high = api_value_member(value, "max"),
                     back = api_value_member(value, "restitution");
    if (!api_field_object(value, NULL, problem)) return PEND_OK;
    PEND_TRY(rules_joints(rules, n));
    double *least = rules_number(rules, API_JOINT_LEAST, arm),
           *most = rules_number(rules, API_JOINT_MOST, arm);
    (void)api_value_only(value, names, problem);
    if (api_value_kind(&low) == API_MISSING && api_value_kind(&high) == API_MISSING)
        api_value_fault(value, problem, API_CODE_MISSING "must have a \"min\" or a \"max\"");
    (void)api_value_read_number(&low, -INFINITY, INFINITY, "rad", least, problem);
    (void)api_value_read_number(&high, -INFINITY, INFINITY, "rad", most, problem);
    if (!(*least < *most)) {
        api_value_fault(&high, problem,
                        API_CODE_OUT_OF_RANGE "must be greater than \"min\", %.12g, got %.12g",
                        *least, *most);
        return PEND_OK;
    }
    (void)api_value_read_number(&back, 0, 1, "", rules_number(rules, API_JOINT_RESTITUTION, arm),
                                problem);
    api_value_usual_number(&back, 0);
    rules->stops = 1;
    return PEND_OK;
}

/* copies `bytes` to *at, and advances *at by them, rounded up to a multiple of 8 */
static void *rules_put(char **at, const void *from, size_t bytes) {
    char *to = *at;
    if (bytes) memcpy(to, from, bytes);
    *at = to + (bytes + 7) / 8 * 8;
    return to;
}

static const double *rules_row(const struct api_rules *rules, const struct pend_tree *tree,
                               enum api_joint_row row, char **at) {
    double *to = (double *)(void *)*at;
    for (int k = 0; k < tree->n; k++)
        to[tree->place[k]] = *rules_number(rules, row, k < rules->n ? k : rules->n);
    *at += (size_t)tree->n * sizeof *to;
    return to;
}

enum pend_status api_rules_make(const struct api_rules *rules, const struct pend_tree *tree,
                                struct pend_rules **made) {
    size_t tables = (size_t)rules->tables * sizeof *rules->table;
    size_t controllers = (size_t)rules->controllers * sizeof *rules->controller;
    size_t laws = (size_t)rules->laws * sizeof *rules->law;
    size_t numbers = rules->numbers + API_JOINT_ROWS * (size_t)tree->n;
    *made = NULL;
    if (!rules->tables && !rules->controllers && !rules->rubs && !rules->stops) return PEND_OK;
    for (int i = 0; i < rules->tables; i++) numbers += 3 * (size_t)rules->table[i].count;
    *made = malloc(sizeof **made + tables + controllers + laws + numbers * sizeof(double) + 32);
    if (!*made) return PEND_NO_MEMORY;
    char *at = (char *)(*made + 1);
    struct pend_table *table = rules_put(&at, rules->table, tables);
    **made = (struct pend_rules){.tables = rules->tables,
                                 .controllers = rules->controllers,
                                 .table = table,
                                 .numbers = numbers};
    (*made)->controller = rules_put(&at, rules->controller, controllers);
    (*made)->law = rules_put(&at, rules->law, laws);
    (*made)->number = rules_put(&at, rules->number, rules->numbers * sizeof(double));
    for (int i = 0; i < rules->tables; i++) {
        size_t count = (size_t)rules->table[i].count;
        int drives = table[i].drives, parts = drives < 0 ? 3 : 2;
        if (drives >= 0) table[i].drives = tree->place[drives];
        table[i].t = rules_put(&at, rules->table[i].t, (size_t)parts * count * sizeof(double));
        table[i].value = table[i].t + count, table[i].bend = table[i].value + count;
    }
    if (rules->rubs) {
        (*made)->sliding = rules_row(rules, tree, API_JOINT_SLIDING, &at);
        (*made)->holding = rules_row(rules, tree, API_JOINT_HOLDING, &at);
    }
    if (rules->stops) {
        (*made)->least = rules_row(rules, tree, API_JOINT_LEAST, &at);
        (*made)->most = rules_row(rules, tree, API_JOINT_MOST, &at);
        (*made)->restitution = rules_row(rules, tree, API_JOINT_RESTITUTION, &at);
    }
    return PEND_OK;
}
