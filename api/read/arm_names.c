#include "api/read/arm_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/did_you_mean.h"

enum {
    NUMBER_BYTES = 12, /* bytes of an arm's number as text */
    NEAR_NAMES = 1000, /* in a larger tree, misspelt names get no suggestion */
    NEAR_FAULTS = 20   /* after more errors than this, misspelt names get no suggestion */
};

enum pend_status api_arm_names_init(struct api_arm_names *names, int n) {
    size_t count = (size_t)n;
    *names = (struct api_arm_names){.n = n};
    names->text =
        malloc((count + 1) * sizeof *names->text + count * (sizeof *names->sorted + NUMBER_BYTES));
    if (!names->text) return PEND_NO_MEMORY;
    names->text[n] = NULL;
    names->sorted = (int *)(names->text + count + 1);
    names->numbers = (char *)(names->sorted + count);
    return PEND_OK;
}

void api_arm_names_clear(struct api_arm_names *names) {
    free(names->text);
    *names = (struct api_arm_names){0};
}

void api_arm_names_take(struct api_arm_names *names, const struct api_value *arm,
                        struct api_problem *problem) {
    int i = arm->index;
    char found[API_FOUND_BYTES], *number = names->numbers + (size_t)i * NUMBER_BYTES;
    struct api_value field = api_value_member(arm, "name");
    const char *text = api_value_text(&field);
    snprintf(number, NUMBER_BYTES, "%d", i + 1);
    names->given += text && *text;
    names->text[i] = text && *text ? text : number;
    if (names->text[i] == text || api_value_kind(&field) == API_MISSING) return;
    api_value_found(&field, found);
    api_value_fault(&field, problem, API_CODE_WRONG_TYPE "must be a non-empty text, got %s", found);
}

static int name_order(const void *a, const void *b, void *context) {
    const char *const *text = context;
    int i = *(const int *)a, j = *(const int *)b, order = strcmp(text[i], text[j]);
    return order ? order : (i > j) - (i < j);
}

void api_arm_names_sort(struct api_arm_names *names, const struct api_value *arms,
                        struct api_problem *problem) {
    int first = 0;
    for (int i = 0; i < names->n; i++) names->sorted[i] = i;
    qsort_r(names->sorted, (size_t)names->n, sizeof *names->sorted, name_order, names->text);
    for (int i = 1; i < names->n; i++) {
        if (strcmp(names->text[names->sorted[i]], names->text[names->sorted[first]])) {
            first = i;
            continue;
        }
        if (api_problem_full(problem)) continue;
        struct api_value arm = api_value_item(arms, names->sorted[i]),
                         field = api_value_member(&arm, "name");
        api_value_fault(
            &field, problem,
            API_CODE_DUPLICATE
            "arm %d has this name already (an arm without a name is named by its number)",
            names->sorted[first] + 1);
    }
}

/* the first arm of that name, or API_ARM_FAULTY */
static int names_find(const struct api_arm_names *names, const char *name) {
    int low = 0, high = names->n;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (strcmp(names->text[names->sorted[middle]], name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low < names->n && !strcmp(names->text[names->sorted[low]], name) ? names->sorted[low]
                                                                            : API_ARM_FAULTY;
}

int api_arm_names_parent(const struct api_arm_names *names, const struct api_value *arm,
                         struct api_problem *problem) {
    char found[API_FOUND_BYTES];
    struct api_value field = api_value_member(arm, "parent");
    if (api_value_kind(&field) == API_MISSING || api_value_kind(&field) == API_NULL) return -1;
    const char *text = api_value_text(&field), *near = NULL;
    int parent = text ? names_find(names, text) : API_ARM_FAULTY;
    if (parent >= 0 || api_problem_full(problem)) return parent;
    if (text && names->n <= NEAR_NAMES && problem->count + problem->beyond < NEAR_FAULTS)
        near = api_name_nearest(text, names->text);
    double number = api_value_number(&field);
    if (api_value_kind(&field) == API_NUMBER && number >= 1 && number <= names->n)
        near = names->text[(int)number - 1];
    api_value_found(&field, found);
    if (near)
        api_value_fault(&field, problem,
                        API_CODE_UNKNOWN_NAME
                        "must be the name of an arm, got %s; did you mean \"%s\"?",
                        found, near);
    else
        api_value_fault(&field, problem,
                        API_CODE_UNKNOWN_NAME
                        "must be the name of an arm (left out or null at the pivot), got %s",
                        found);
    return API_ARM_FAULTY;
}

enum pend_status api_arm_names_keep(const struct api_arm_names *names, const char ***kept) {
    size_t bytes = (size_t)names->n * sizeof **kept;
    if (!names->given) return PEND_OK;
    for (int i = 0; i < names->n; i++) bytes += strlen(names->text[i]) + 1;
    const char **list = malloc(bytes);
    if (!list) return PEND_NO_MEMORY;
    char *at = (char *)(list + names->n);
    for (int i = 0; i < names->n; i++) {
        list[i] = at;
        at = stpcpy(at, names->text[i]) + 1;
    }
    *kept = list;
    return PEND_OK;
}
