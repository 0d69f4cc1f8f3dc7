#include "api/read/rules_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* s, the least time between two instants of a table */
static const double table_finest = 1e-9;

void api_rules_clear(struct api_rules *rules) {
    for (int i = 0; i < rules->tables; i++) free((void *)rules->table[i].t);
    free(rules->table);
    *rules = (struct api_rules){0};
}

/* a list of numbers of a table; NULL if it is faulty */
static const double *table_numbers(const struct api_value *list, int *count,
                                   struct api_problem *problem) {
    *count = api_value_count(list);
    if (!api_field_needed(list, problem)) return NULL;
    if (api_field_numbers(list, 0, "instant", NULL, problem) < 0) return NULL;
    if (!*count) api_value_fault(list, problem, API_CODE_WRONG_COUNT "must have an entry");
    return *count ? api_value_numbers(list, count) : NULL;
}

/* the instants ascend, by a nanosecond at least */
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
                             *const holds[] = {"zero", "linear", NULL},
                             *const outsides[] = {"hold", "zero", NULL};
    struct pend_table table = {.drives = drives};
    int values = 0, hold = 0, outside = -1;
    if (!api_field_object(value, problem)) return PEND_OK;
    (void)api_value_only(value, names, problem);
    struct api_value t = api_value_member(value, "t"), x = api_value_member(value, "value"),
                     way = api_value_member(value, "hold");
    const double *instant = table_numbers(&t, &table.count, problem),
                 *number = table_numbers(&x, &values, problem);
    (void)(api_field_needed(&way, problem) && api_field_word(&way, holds, &hold, problem));
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
    double *both = malloc(2 * bytes);
    if (!both) return PEND_NO_MEMORY;
    memcpy(both, instant, bytes);
    memcpy(both + table.count, number, bytes);
    table.t = both, table.value = both + table.count;
    rules->table[rules->tables++] = table;
    return PEND_OK;
}

enum pend_status api_rules_make(const struct api_rules *rules, const struct pend_tree *tree,
                                struct pend_rules **made) {
    size_t numbers = 0, tables = (size_t)rules->tables * sizeof *rules->table;
    *made = NULL;
    if (!rules->tables) return PEND_OK;
    for (int i = 0; i < rules->tables; i++) numbers += 2 * (size_t)rules->table[i].count;
    *made = malloc(sizeof **made + tables + numbers * sizeof(double));
    if (!*made) return PEND_NO_MEMORY;
    struct pend_table *table = (struct pend_table *)(*made + 1);
    double *at = (double *)(table + rules->tables);
    **made = (struct pend_rules){.tables = rules->tables, .table = table};
    for (int i = 0; i < rules->tables; i++) {
        size_t count = (size_t)rules->table[i].count;
        table[i] = rules->table[i];
        table[i].drives = tree->place[table[i].drives];
        table[i].t = memcpy(at, rules->table[i].t, 2 * count * sizeof(double));
        table[i].value = at + count;
        at += 2 * count;
    }
    return PEND_OK;
}
