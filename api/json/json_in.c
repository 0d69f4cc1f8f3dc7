#include "api/json/json_in.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/json/json_arena.h"
#include "api/json/json_scan.h"
#include "api/number/number.h"
#include "api/base/text.h"

struct api_json {
    cJSON *root;
    void *nodes; /* the block that the tree lies in */
    double *numbers;
    struct api_scan_array *arrays;
};

/* a bit of a node's type that cJSON does not use */
enum { NODE_USUAL = 1 << 20 };

_Static_assert(sizeof(cJSON) <= API_SCAN_NODE, "a node takes no more than the scan has counted");

enum { FOUND_TEXT = 40, NAME_BYTES = 64, POINTER_DEPTH = 128, NEAR_EDITS = 2 };

/* building */

/* cJSON asks through here for every node and string, in this program and in tests alike */
__attribute__((constructor)) static void json_hook(void) {
    cJSON_InitHooks(&(cJSON_Hooks){.malloc_fn = api_arena_take, .free_fn = api_arena_give});
}

void api_json_free(struct api_json **document) {
    if (!*document) return;
    free((*document)->nodes);
    free((*document)->numbers);
    free((*document)->arrays);
    free(*document);
    *document = NULL;
}

/* gives back what a growing array did not use; where that fails the array simply stays */
static void *json_shrink(void *items, size_t bytes) {
    void *shrunk = bytes ? realloc(items, bytes) : items;
    return shrunk ? shrunk : items;
}

/* takes the tables of a finished scan and parses its rest */
static enum pend_status json_take(struct api_json *document, struct api_scan *scan) {
    document->numbers = json_shrink(scan->numbers, scan->number_count * sizeof *scan->numbers);
    document->arrays = json_shrink(scan->arrays, scan->array_count * sizeof *scan->arrays);
    scan->numbers = NULL;
    scan->arrays = NULL;
    document->nodes = malloc(scan->cost);
    if (!document->nodes) return PEND_NO_MEMORY;
    api_arena_begin(document->nodes, scan->cost);
    document->root = cJSON_ParseWithLength(scan->rest.data, scan->rest.bytes);
    api_arena_end();
    return document->root ? PEND_OK : PEND_NO_MEMORY; /* the rest is JSON for certain */
}

enum pend_status api_json_new(struct api_json **document, const char *text, size_t bytes,
                              int depth_cap, struct api_problem *problem) {
    struct api_scan scan;
    *document = NULL;
    enum pend_status status = api_scan_run(&scan, text, bytes, depth_cap, problem);
    if (status != PEND_OK) goto out;
    status = PEND_NO_MEMORY;
    if (!(*document = calloc(1, sizeof **document))) goto out;
    status = json_take(*document, &scan);
    if (status != PEND_OK) api_json_free(document);
out:
    api_scan_clear(&scan);
    return status;
}

/* looking */

struct api_value api_json_root(const struct api_json *document) {
    return (struct api_value){.document = document, .node = document->root};
}

/* what cJSON says that a node is; its own questions are calls of functions, one for each type */
static int node_type(const cJSON *node) { return node->type & 0xff; }

/* the table entry of an array of numbers, or NULL */
static const struct api_scan_array *value_array(const struct api_value *value);

/* an item of an array of numbers: its node is the double itself */
static int value_is_double(const struct api_value *value) {
    return value->node && value->parent && !value->key && value_array(value->parent);
}

static const struct api_scan_array *value_array(const struct api_value *value) {
    const cJSON *node = value->node;
    if (!node || value_is_double(value) || node_type(node) != cJSON_Number ||
        !(node->valuedouble < 0))
        return NULL;
    return &value->document->arrays[(size_t)(-node->valuedouble - 1)];
}

enum api_kind api_value_kind(const struct api_value *value) {
    const cJSON *node = value->node;
    if (!node) return API_MISSING;
    if (value_is_double(value)) return API_NUMBER;
    switch (node_type(node)) {
    case cJSON_Number:
        return node->valuedouble < 0 ? API_ARRAY : API_NUMBER;
    case cJSON_String:
        return API_STRING;
    case cJSON_Object:
        return API_OBJECT;
    case cJSON_Array:
        return API_ARRAY;
    case cJSON_True:
    case cJSON_False:
        return API_BOOL;
    default:
        return API_NULL;
    }
}

static struct api_value value_child(const struct api_value *parent, const void *node,
                                    const char *key, int index) {
    return (struct api_value){parent->document, node, parent, key, index};
}

/* marks */

/* the document is ours: only its readers see it as unchanging */
void api_value_usual(const struct api_value *member) {
    if (member->node && member->key) ((cJSON *)member->node)->type |= NODE_USUAL;
}

int api_value_is_usual(const struct api_value *value) {
    return value->node && value->key && ((const cJSON *)value->node)->type & NODE_USUAL;
}

void api_value_usual_number(const struct api_value *member, double usual) {
    double number = api_value_number(member);
    if (api_value_kind(member) == API_NUMBER && !memcmp(&number, &usual, sizeof usual))
        api_value_usual(member);
}

void api_value_usual_zeros(const struct api_value *member) {
    int count = 0;
    const double *number = api_value_numbers(member, &count);
    if (!number) return;
    for (int i = 0; i < count; i++)
        if (number[i] != 0 || signbit(number[i])) return;
    api_value_usual(member);
}

void api_value_usual_object(const struct api_value *member) {
    if (api_value_kind(member) != API_OBJECT) return;
    struct api_value one = api_value_first(member);
    while (api_value_is_usual(&one)) one = api_value_next(&one);
    if (api_value_kind(&one) == API_MISSING) api_value_usual(member);
}

struct api_value api_value_member(const struct api_value *object, const char *key) {
    const cJSON *node = NULL;
    if (api_value_kind(object) == API_OBJECT)
        node = cJSON_GetObjectItemCaseSensitive(object->node, key);
    return value_child(object, node, key, 0);
}

int api_value_count(const struct api_value *value) {
    enum api_kind kind = api_value_kind(value);
    const struct api_scan_array *array = value_array(value);
    if (array) return array->count;
    return kind == API_ARRAY || kind == API_OBJECT ? cJSON_GetArraySize(value->node) : 0;
}

struct api_value api_value_item(const struct api_value *array, int i) {
    const struct api_scan_array *entry = value_array(array);
    const void *node = NULL;
    if (entry)
        node = i < entry->count ? &array->document->numbers[entry->first + (size_t)i] : NULL;
    else if (api_value_kind(array) == API_ARRAY)
        node = cJSON_GetArrayItem(array->node, i);
    return value_child(array, node, NULL, i);
}

/* an item or a member that cJSON holds, or the end of them */
static struct api_value value_listed(const struct api_value *parent, const cJSON *node, int index) {
    int member = node && node_type(parent->node) == cJSON_Object;
    return value_child(parent, node, member ? node->string : NULL, index);
}

struct api_value api_value_first(const struct api_value *value) {
    if (value_array(value)) return api_value_item(value, 0);
    int holds = api_value_kind(value) == API_ARRAY || api_value_kind(value) == API_OBJECT;
    return value_listed(value, holds ? ((const cJSON *)value->node)->child : NULL, 0);
}

struct api_value api_value_next(const struct api_value *item) {
    if (!item->node) return *item;
    if (value_is_double(item)) return api_value_item(item->parent, item->index + 1);
    return value_listed(item->parent, ((const cJSON *)item->node)->next, item->index + 1);
}

const double *api_value_numbers(const struct api_value *array, int *count) {
    static const double none = 0;
    const struct api_scan_array *entry = value_array(array);
    if (!entry) return NULL;
    *count = entry->count;
    return entry->count ? &array->document->numbers[entry->first] : &none;
}

const char *api_value_text(const struct api_value *value) {
    return api_value_kind(value) == API_STRING ? ((const cJSON *)value->node)->valuestring : NULL;
}

double api_value_number(const struct api_value *value) {
    enum api_kind kind = api_value_kind(value);
    if (kind == API_BOOL) return cJSON_IsTrue((const cJSON *)value->node);
    if (kind != API_NUMBER) return 0;
    if (value_is_double(value)) return *(const double *)value->node;
    return value->document->numbers[(size_t)((const cJSON *)value->node)->valuedouble];
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

void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format,
                     ...) {
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

/* insertions, deletions, replacements and swaps of neighbours that turn a into b; upper case
 * counts as lower */
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
        used += (size_t)snprintf(list + used, API_DETAIL_BYTES - used, "%s%s", i ? ", " : "",
                                 allowed[i]);
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

int api_value_only(const struct api_value *object, const char *const allowed[],
                   struct api_problem *problem) {
    int faults = 0;
    if (api_value_kind(object) != API_OBJECT) return 0;
    struct api_value member = api_value_first(object);
    for (; api_value_kind(&member) != API_MISSING; member = api_value_next(&member)) {
        if (name_allowed(member.key, allowed)) continue;
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
    static const char *const words[] = {[API_MISSING] = "nothing",
                                        [API_NULL] = "null",
                                        [API_ARRAY] = "an array",
                                        [API_OBJECT] = "an object"};
    const char *text = api_value_text(value);
    enum api_kind kind = api_value_kind(value);
    if (text) {
        size_t bytes = strlen(text), cut = api_text_cut(text, bytes, FOUND_TEXT);
        snprintf(found, API_FOUND_BYTES, "the text \"%.*s%s\"", (int)cut, text,
                 cut < bytes ? "..." : "");
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

int api_value_read_number(const struct api_value *value, double least, double greatest,
                          const char *unit, double *out, struct api_problem *problem) {
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
