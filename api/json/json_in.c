#include "api/json/json_in.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/base/text.h"
#include "api/json/did_you_mean.h"
#include "api/json/json_scan.h"
#include "api/number/number.h"

/* marks a node; cJSON and the scan do not use this bit of its type */
enum { NODE_USUAL = 1 << 20 };

enum { FOUND_TEXT = 40, POINTER_DEPTH = 128 };

/* ---- building */

void api_json_free(struct api_json **document) {
    if (!*document) return;
    api_scan_clear(*document);
    free(*document);
    *document = NULL;
}

enum pend_status api_json_new(struct api_json **document, const char *text, size_t bytes,
                              int depth_cap, struct api_problem *problem) {
    *document = calloc(1, sizeof **document);
    if (!*document) return PEND_NO_MEMORY;
    enum pend_status status = api_scan_run(*document, text, bytes, depth_cap, problem);
    if (status != PEND_OK) api_json_free(document);
    return status;
}

/* ---- access */

struct api_value api_json_root(const struct api_json *document) {
    return (struct api_value){.document = document, .node = document->root};
}

/* the cJSON type of a node, without a function call per type */
static int node_type(const cJSON *node) { return node->type & 0xff; }

static int node_has_numbers(const cJSON *node) { return (node->type & API_SCAN_NUMBERS) != 0; }

/* true for an item of an array of numbers, whose node is the double itself; it has no children */
static int value_is_double(const struct api_value *value) {
    return value->node && value->parent && !value->key && node_has_numbers(value->parent->node);
}

/* the node of an array of numbers, or NULL */
static const cJSON *value_array(const struct api_value *value) {
    if (!value->node || value_is_double(value) || !node_has_numbers(value->node)) return NULL;
    return value->node;
}

static const double *array_numbers(const struct api_value *value, const cJSON *array) {
    return value->document->numbers + (size_t)array->valuedouble;
}

enum api_kind api_value_kind(const struct api_value *value) {
    const cJSON *node = value->node;
    if (!node) return API_MISSING;
    if (value_is_double(value)) return API_NUMBER;
    switch (node_type(node)) {
    case cJSON_Number:
        return API_NUMBER;
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

/* ---- marks */

/* the document is const only for its readers; casting is safe here */
void api_value_usual(const struct api_value *member) {
    if (member->node && member->key) ((cJSON *)member->node)->type |= NODE_USUAL;
}

int api_value_is_usual(const struct api_value *value) {
    return value->node && value->key && ((const cJSON *)value->node)->type & NODE_USUAL;
}

struct api_value api_value_behind(const struct api_value *object, const char *last, int unusual) {
    struct api_value member = api_value_first(object), least = {0};
    for (; api_value_kind(&member) != API_MISSING; member = api_value_next(&member)) {
        if ((unusual && api_value_is_usual(&member)) || (last && strcmp(member.key, last) <= 0))
            continue;
        if (!least.node || strcmp(member.key, least.key) < 0) least = member;
    }
    return least;
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
    const cJSON *array = value_array(value);
    if (array) return array->valueint;
    return kind == API_ARRAY || kind == API_OBJECT ? cJSON_GetArraySize(value->node) : 0;
}

struct api_value api_value_item(const struct api_value *array, int i) {
    const cJSON *numbers = value_array(array);
    const void *node = NULL;
    if (numbers)
        node = i < numbers->valueint ? array_numbers(array, numbers) + i : NULL;
    else if (api_value_kind(array) == API_ARRAY)
        node = cJSON_GetArrayItem(array->node, i);
    return value_child(array, node, NULL, i);
}

/* an item or member that is a cJSON node; missing if node is NULL */
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
    const cJSON *numbers = value_array(array);
    if (!numbers) return NULL;
    *count = numbers->valueint;
    return *count ? array_numbers(array, numbers) : &none;
}

const char *api_value_text(const struct api_value *value) {
    return api_value_kind(value) == API_STRING ? ((const cJSON *)value->node)->valuestring : NULL;
}

double api_value_number(const struct api_value *value) {
    enum api_kind kind = api_value_kind(value);
    if (kind == API_BOOL) return cJSON_IsTrue((const cJSON *)value->node);
    if (kind != API_NUMBER) return 0;
    return value_is_double(value) ? *(const double *)value->node
                                  : ((const cJSON *)value->node)->valuedouble;
}

/* ---- pointers */

struct pointer_text {
    char *text;
    size_t bytes;
    int full;
};

/* appends one character of a pointer, or "..." if it does not fit */
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

/* ---- errors */

void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format,
                     ...) {
    char pointer[API_POINTER_BYTES];
    va_list arguments;
    if (api_problem_full(problem)) return;
    api_value_pointer(value, pointer);
    va_start(arguments, format);
    api_problem_fault_list(problem, pointer, format, arguments);
    va_end(arguments);
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

static const char *const state_fields[] = {"theta", "thetad", "phi",  "phid",
                                           "unit",  "theta0", "phi0", NULL};

/* whether a value is the member `key` of the document's object, or within it */
static int value_within(const struct api_value *value, const char *key) {
    while (value->parent && value->parent->parent) value = value->parent;
    return value->parent && value->key && !strcmp(value->key, key);
}

static void value_fault_unknown(const struct api_value *member, const char *const allowed[],
                                struct api_problem *problem) {
    if (api_problem_full(problem)) return;
    const char *meant =
        strcmp(member->key, "preset") != 0 ? api_did_you_mean(member->key, allowed) : NULL;
    char list[API_DETAIL_BYTES];
    if (meant) {
        api_value_fault(member, problem,
                        API_CODE_UNKNOWN_FIELD "is not a known field; did you mean \"%s\"?", meant);
        api_problem_meant(problem, meant);
        return;
    }
    const struct api_value *object = member->parent;
    const char *head = object->parent ? NULL : api_name_head(member->key);
    if (head) {
        api_value_fault(member, problem,
                        API_CODE_UNKNOWN_FIELD
                        "is not a field of the body: send the header field \"%s\"",
                        head);
        return;
    }
    if (!object->parent && !strcmp(member->key, "method")) {
        api_value_fault(member, problem,
                        API_CODE_UNKNOWN_FIELD
                        "is not a field here, leave it out: only POST /v1/trajectories takes a "
                        "method, such as \"radau\" for stiff pendulums");
        return;
    }
    if (!strcmp(member->key, "preset")) {
        api_value_fault(member, problem,
                        API_CODE_UNKNOWN_FIELD "is not a field here: GET /v1/presets/{name} "
                                               "returns a \"pendulum\": put that into the request");
        api_problem_meant(problem, "arms");
        return;
    }
    if (value_within(object, "pendulum") && api_name_outer(member->key)) {
        api_value_fault(member, problem,
                        API_CODE_UNKNOWN_FIELD
                        "is not a field here: it belongs next to \"pendulum\"%s",
                        name_allowed(member->key, state_fields) ? ", in \"initial\"" : "");
        return;
    }
    name_list(allowed, list);
    api_value_fault(member, problem,
                    API_CODE_UNKNOWN_FIELD "is not a known field; allowed here: %s", list);
}

/* adds one error for several members that belong in another object, at the first of them */
static void value_fault_place(const struct api_value *first, const char *place,
                              const char *const allowed[], struct api_problem *problem) {
    const char *found[API_NAME_PLACES + 1] = {0};
    struct api_value member = *first;
    char list[API_DETAIL_BYTES];
    int count = 0;
    if (api_problem_full(problem)) return;
    for (; api_value_kind(&member) != API_MISSING; member = api_value_next(&member)) {
        if (name_allowed(member.key, allowed)) continue;
        if (api_name_place(member.key, allowed) == place) found[count++] = member.key;
    }
    assert(count >= 1 && count <= API_NAME_PLACES);
    name_list(found, list);
    if (count == 1)
        api_value_fault(first, problem,
                        API_CODE_UNKNOWN_FIELD "is not a field here: put it into \"%s\"", place);
    else
        api_value_fault(first, problem,
                        API_CODE_UNKNOWN_FIELD "is not a field here: put these into \"%s\": %s",
                        place, list);
    api_problem_meant(problem, place);
}

int api_value_only(const struct api_value *object, const char *const allowed[],
                   struct api_problem *problem) {
    const char *told[API_NAME_PLACES + 1] = {0};
    int faults = 0, count = 0;
    if (api_value_kind(object) != API_OBJECT) return 0;
    API_VALUE_EACH (member, api_value_first(object)) {
        if (name_allowed(member.key, allowed)) continue;
        const char *place = api_name_place(member.key, allowed);
        faults++;
        if (!place) {
            value_fault_unknown(&member, allowed, problem);
        } else if (!name_allowed(place, told)) {
            told[count++] = place;
            value_fault_place(&member, place, allowed, problem);
        }
    }
    return faults;
}

int api_value_meant(const struct api_value *object, const char *key,
                    const struct api_problem *problem) {
    char pointer[API_POINTER_BYTES];
    if (!problem->count) return 0;
    api_value_pointer(object, pointer);
    return api_problem_is_meant(problem, pointer, key);
}

/* ---- numbers */

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

/* writes the expected range, such as "a number from 0 to 1 s" */
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
    if (api_value_kind(value) == API_NUMBER)
        api_value_fault(value, problem, API_CODE_OUT_OF_RANGE "must be %s, got %s", range, found);
    else
        api_value_fault(value, problem, API_CODE_WRONG_TYPE "must be %s, got %s", range, found);
    return -1;
}
