#include "api/json_in.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json_scan.h"
#include "api/number.h"
#include "api/text.h"

struct api_json {
    struct api_node *nodes;
    double *numbers;
    char *texts;
};

enum { FOUND_TEXT = 40, NAME_BYTES = 64, POINTER_DEPTH = 128, NEAR_EDITS = 2 };

/* building */

void api_json_free(struct api_json **document) {
    if (!*document) return;
    free((*document)->nodes);
    free((*document)->numbers);
    free((*document)->texts);
    free(*document);
    *document = NULL;
}

/* gives back what a growing table did not use; where that fails the table simply stays */
static void *json_shrink(void *items, size_t bytes) {
    void *shrunk = bytes ? realloc(items, bytes) : items;
    return shrunk ? shrunk : items;
}

/* takes the tables of a finished scan */
static void json_take(struct api_json *document, struct api_scan *scan) {
    document->nodes = json_shrink(scan->nodes, scan->node_count * sizeof *scan->nodes);
    document->numbers = json_shrink(scan->numbers, scan->number_count * sizeof *scan->numbers);
    document->texts = json_shrink(scan->texts.data, scan->texts.bytes);
    scan->nodes = NULL;
    scan->numbers = NULL;
    scan->texts.data = NULL;
}

enum pend_status api_json_new(struct api_json **document, const char *text, size_t bytes, int depth_cap,
                              struct api_problem *problem) {
    struct api_scan scan;
    *document = NULL;
    enum pend_status status = api_scan_run(&scan, text, bytes, depth_cap, problem);
    if (status != PEND_OK) goto out;
    status = PEND_NO_MEMORY;
    if (!(*document = malloc(sizeof **document))) goto out;
    json_take(*document, &scan);
    status = PEND_OK;
out:
    api_scan_clear(&scan);
    return status;
}

/* looking */

struct api_value api_json_root(const struct api_json *document) {
    return (struct api_value){.document = document, .node = document->nodes};
}

static int value_is_double(const struct api_value *value);

/* the node of a value, or NULL where it is missing or is an item of an array of numbers, which has none */
static const struct api_node *value_node(const struct api_value *value) {
    return value_is_double(value) ? NULL : value->node;
}

/* an item of an array of numbers: it points at the double itself */
static int value_is_double(const struct api_value *value) {
    if (!value->node || !value->parent || value->key) return 0;
    const struct api_node *array = value_node(value->parent);
    return array && array->kind == API_NODE_NUMBERS;
}

enum api_kind api_value_kind(const struct api_value *value) {
    static const enum api_kind kinds[] = {
        [API_NODE_NULL] = API_NULL,     [API_NODE_FALSE] = API_BOOL,    [API_NODE_TRUE] = API_BOOL,
        [API_NODE_NUMBER] = API_NUMBER, [API_NODE_TEXT] = API_STRING,   [API_NODE_NUMBERS] = API_ARRAY,
        [API_NODE_ARRAY] = API_ARRAY,   [API_NODE_OBJECT] = API_OBJECT,
    };
    const struct api_node *node = value_node(value);
    return node ? kinds[node->kind] : value->node ? API_NUMBER : API_MISSING;
}

static struct api_value value_child(const struct api_value *parent, const void *node, const char *key, int index) {
    return (struct api_value){parent->document, node, parent, key, index};
}

/* the first item or member, and the one after a node; NULL where there is none */
static const struct api_node *node_first(const struct api_node *node) {
    return node && node->kind >= API_NODE_ARRAY && node->count ? node + 1 : NULL;
}

static const struct api_node *node_next(const struct api_json *document, const struct api_node *node) {
    return node->next ? &document->nodes[node->next] : NULL;
}

struct api_value api_value_member(const struct api_value *object, const char *key) {
    const struct api_node *node = NULL;
    if (api_value_kind(object) == API_OBJECT) node = node_first(value_node(object));
    while (node && strcmp(object->document->texts + node->key, key)) node = node_next(object->document, node);
    return value_child(object, node, key, 0);
}

int api_value_count(const struct api_value *value) {
    const struct api_node *node = value_node(value);
    return node && node->kind >= API_NODE_NUMBERS ? (int)node->count : 0;
}

struct api_value api_value_item(const struct api_value *array, int i) {
    const struct api_node *node = value_node(array), *item = NULL;
    if (node && node->kind == API_NODE_NUMBERS) {
        const double *numbers = array->document->numbers;
        return value_child(array, i < (int)node->count ? &numbers[node->at + (uint32_t)i] : NULL, NULL, i);
    }
    if (node && node->kind == API_NODE_ARRAY) item = node_first(node);
    for (int k = 0; k < i && item; k++) item = node_next(array->document, item);
    return value_child(array, item, NULL, i);
}

struct api_value api_value_next(const struct api_value *item) {
    const struct api_node *node = value_node(item);
    if (!item->node) return *item;
    if (!node) return api_value_item(item->parent, item->index + 1);
    return value_child(item->parent, node_next(item->document, node), NULL, item->index + 1);
}

const double *api_value_numbers(const struct api_value *array, int *count) {
    static const double none = 0;
    const struct api_node *node = value_node(array);
    if (!node || node->kind != API_NODE_NUMBERS) return NULL;
    *count = (int)node->count;
    return node->count ? &array->document->numbers[node->at] : &none;
}

const char *api_value_text(const struct api_value *value) {
    const struct api_node *node = value_node(value);
    return node && node->kind == API_NODE_TEXT ? value->document->texts + node->at : NULL;
}

double api_value_number(const struct api_value *value) {
    const struct api_node *node = value_node(value);
    if (!node) return value->node ? *(const double *)value->node : 0;
    if (node->kind == API_NODE_NUMBER) return value->document->numbers[node->at];
    return node->kind == API_NODE_TRUE;
}

/* pointers */

struct pointer_text {
    char *text;
    size_t bytes;
    int full;
};

/* appends one character of a pointer, or the sign that it was cut */
static void pointer_add(struct pointer_text *pointer, const char *text, size_t bytes) {
    if (pointer->full) return;
    if (pointer->bytes + bytes + sizeof "..." > API_POINTER_BYTES) {
        pointer->full = 1;
        text = "...";
        bytes = 3;
    }
    memcpy(pointer->text + pointer->bytes, text, bytes);
    pointer->bytes += bytes;
    pointer->text[pointer->bytes] = 0;
}

static void pointer_add_step(struct pointer_text *pointer, const struct api_value *value) {
    pointer_add(pointer, "/", 1);
    if (!value->key) {
        char index[16];
        pointer_add(pointer, index, (size_t)snprintf(index, sizeof index, "%d", value->index));
        return;
    }
    for (const char *p = value->key; *p && !pointer->full;) {
        int length = api_text_utf8(p, strlen(p));
        if (!length) length = 1;
        if (*p == '~' || *p == '/')
            pointer_add(pointer, *p == '~' ? "~0" : "~1", 2);
        else
            pointer_add(pointer, p, (size_t)length);
        p += length;
    }
}

void api_value_pointer(const struct api_value *value, char pointer[API_POINTER_BYTES]) {
    const struct api_value *way[POINTER_DEPTH];
    struct pointer_text out = {.text = pointer};
    int depth = 0;
    pointer[0] = 0;
    for (; value->parent && depth < POINTER_DEPTH; value = value->parent) way[depth++] = value;
    while (depth) pointer_add_step(&out, way[--depth]);
}

/* faults */

void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format, ...) {
    char pointer[API_POINTER_BYTES], detail[API_DETAIL_BYTES + 8];
    va_list arguments;
    if (api_problem_full(problem)) return;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    api_value_pointer(value, pointer);
    api_problem_fault(problem, pointer, "%s", detail);
}

static int name_lower(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : (unsigned char)c; }

static int least_of_three(int a, int b, int c) {
    int least = a < b ? a : b;
    return least < c ? least : c;
}

/* insertions, deletions, replacements and swaps of neighbours that turn a into b; upper case counts as lower */
static int name_edits(const char *a, const char *b) {
    int rows[3][NAME_BYTES + 1], *before = rows[0], *last = rows[1], *now = rows[2];
    int m = (int)strlen(a), n = (int)strlen(b);
    for (int j = 0; j <= n; j++) last[j] = j;
    for (int i = 1; i <= m; i++) {
        now[0] = i;
        for (int j = 1; j <= n; j++) {
            int differ = name_lower(a[i - 1]) != name_lower(b[j - 1]);
            now[j] = least_of_three(last[j] + 1, now[j - 1] + 1, last[j - 1] + differ);
            int swap = i > 1 && j > 1 && name_lower(a[i - 1]) == name_lower(b[j - 2]) &&
                       name_lower(a[i - 2]) == name_lower(b[j - 1]);
            if (swap && before[j - 2] + 1 < now[j]) now[j] = before[j - 2] + 1;
        }
        int *spare = before;
        before = last;
        last = now;
        now = spare;
    }
    return last[n];
}

const char *api_name_nearest(const char *name, const char *const allowed[]) {
    const char *nearest = NULL;
    int least = NEAR_EDITS + 1;
    if (strlen(name) > NAME_BYTES) return NULL;
    for (int i = 0; allowed[i]; i++) {
        if (strlen(allowed[i]) > NAME_BYTES) continue;
        int edits = name_edits(name, allowed[i]);
        if (edits >= least || (edits && edits >= (int)strlen(allowed[i]))) continue;
        least = edits;
        nearest = allowed[i];
    }
    return nearest;
}

static int name_allowed(const char *name, const char *const allowed[]) {
    for (int i = 0; allowed[i]; i++)
        if (!strcmp(name, allowed[i])) return 1;
    return 0;
}

static void name_list(const char *const allowed[], char list[API_DETAIL_BYTES]) {
    size_t used = 0;
    list[0] = 0;
    for (int i = 0; allowed[i] && used < API_DETAIL_BYTES; i++)
        used += (size_t)snprintf(list + used, API_DETAIL_BYTES - used, "%s%s", i ? ", " : "", allowed[i]);
}

static void value_fault_unknown(const struct api_value *member, const char *const allowed[],
                                struct api_problem *problem) {
    if (api_problem_full(problem)) return;
    const char *nearest = api_name_nearest(member->key, allowed);
    char list[API_DETAIL_BYTES];
    if (nearest) {
        api_value_fault(member, problem, "is not a known field; did you mean \"%s\"?", nearest);
        return;
    }
    name_list(allowed, list);
    api_value_fault(member, problem, "is not a known field; allowed here: %s", list);
}

int api_value_only(const struct api_value *object, const char *const allowed[], struct api_problem *problem) {
    int faults = 0;
    if (api_value_kind(object) != API_OBJECT) return 0;
    for (const struct api_node *node = node_first(value_node(object)); node; node = node_next(object->document, node)) {
        const char *name = object->document->texts + node->key;
        if (name_allowed(name, allowed)) continue;
        struct api_value member = value_child(object, node, name, 0);
        value_fault_unknown(&member, allowed, problem);
        faults++;
    }
    return faults;
}

/* numbers */

struct number_text {
    char text[API_NUMBER_BYTES + 1];
};

static struct number_text number_text(double x) {
    struct number_text number = {"an infinite number"};
    if (isfinite(x)) *api_number_write(number.text, x) = 0;
    return number;
}

void api_value_found(const struct api_value *value, char found[API_FOUND_BYTES]) {
    static const char *const words[] = {
        [API_MISSING] = "nothing", [API_NULL] = "null", [API_ARRAY] = "an array", [API_OBJECT] = "an object"};
    const char *text = api_value_text(value);
    enum api_kind kind = api_value_kind(value);
    if (text) {
        size_t bytes = strlen(text), cut = api_text_cut(text, bytes, FOUND_TEXT);
        snprintf(found, API_FOUND_BYTES, "the text \"%.*s%s\"", (int)cut, text, cut < bytes ? "..." : "");
    } else if (kind == API_NUMBER)
        snprintf(found, API_FOUND_BYTES, "%s", number_text(api_value_number(value)).text);
    else
        snprintf(found, API_FOUND_BYTES, "%s",
                 kind == API_BOOL ? api_value_number(value) ? "true" : "false" : words[kind]);
}

/* "a number from 0 to 1 s", as the range has it */
static void range_text(double least, double greatest, const char *unit, char text[], size_t cap) {
    const char *space = unit[0] ? " " : "";
    const struct number_text low = number_text(least), high = number_text(greatest);
    if (isinf(least) && isinf(greatest))
        snprintf(text, cap, "a number");
    else if (isinf(greatest) && least > 0 && least <= DBL_MIN)
        snprintf(text, cap, "a number greater than 0%s%s", space, unit);
    else if (isinf(greatest))
        snprintf(text, cap, "a number, at least %s%s%s", low.text, space, unit);
    else if (isinf(least))
        snprintf(text, cap, "a number, at most %s%s%s", high.text, space, unit);
    else if (least > 0 && least <= DBL_MIN)
        snprintf(text, cap, "a number greater than 0 and at most %s%s%s", high.text, space, unit);
    else
        snprintf(text, cap, "a number from %s to %s%s%s", low.text, high.text, space, unit);
}

int api_value_read_number(const struct api_value *value, double least, double greatest, const char *unit, double *out,
                          struct api_problem *problem) {
    char range[120], found[API_FOUND_BYTES];
    if (!value->node) return 0;
    double x = api_value_number(value);
    if (api_value_kind(value) == API_NUMBER && x >= least && x <= greatest) {
        *out = x;
        return 1;
    }
    range_text(least, greatest, unit, range, sizeof range);
    api_value_found(value, found);
    api_value_fault(value, problem, "must be %s, got %s", range, found);
    return -1;
}
