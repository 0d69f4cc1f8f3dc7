#include "api/read/field.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "api/json/did_you_mean.h"

const char *const api_field_angles[] = {"rad", "deg", NULL};

int api_field_needed(const struct api_value *value, struct api_problem *problem) {
    if (api_value_kind(value) != API_MISSING) return 1;
    int parent = value->key && !strcmp(value->key, "parent");
    if (!value->parent || !api_value_meant(value->parent, value->key, problem))
        api_value_fault(value, problem, API_CODE_MISSING "is missing%s",
                        parent ? ": [0, 1, 2] is a chain of three arms" : "");
    return 0;
}

struct api_value api_field_renamed(const struct api_value *object, const char *name,
                                   const char *deprecated, struct api_problem *problem) {
    struct api_value value = api_value_member(object, name),
                     old = api_value_member(object, deprecated);
    if (api_value_kind(&old) == API_MISSING) return value;
    problem->deprecated = 1;
    if (api_value_kind(&value) == API_MISSING) return old;
    api_value_fault(&old, problem, API_CODE_CONFLICT "is the old name of \"%s\": leave it out",
                    name);
    return value;
}

/* what is wrong with a value: its kind, its size, or a word that is none of the list */
enum field_fault { KIND, SIZE, WORD };

static int field_fault(const struct api_value *value, enum field_fault fault, const char *expected,
                       struct api_problem *problem) {
    char found[API_FOUND_BYTES];
    if (api_problem_full(problem)) return -1;
    api_value_found(value, found);
    api_value_fault(value, problem,
                    fault == KIND   ? API_CODE_WRONG_TYPE "must be %s, got %s"
                    : fault == SIZE ? API_CODE_OUT_OF_RANGE "must be %s, got %s"
                                    : API_CODE_UNKNOWN_NAME "must be %s, got %s",
                    expected, found);
    return -1;
}

int api_field_object(const struct api_value *value, const char *const fields[],
                     struct api_problem *problem) {
    if (!api_field_needed(value, problem)) return 0;
    if (api_value_kind(value) != API_OBJECT) field_fault(value, KIND, "an object", problem);
    if (api_value_kind(value) != API_OBJECT) return 0;
    if (fields) (void)api_value_only(value, fields, problem);
    return 1;
}

/* adds an error for each item that is not a number, and copies the valid ones among the first n */
static int field_items(const struct api_value *value, int n, double out[],
                       struct api_problem *problem) {
    int good = 1;
    API_VALUE_EACH (item, api_value_item(value, 0)) {
        if (api_value_kind(&item) != API_NUMBER)
            good = field_fault(&item, KIND, "a number", problem);
        else if (out && item.index < n)
            out[item.index] = api_value_number(&item);
    }
    return good;
}

/* adds an error unless the value is a list of n numbers, or of any number of them if n is 0 */
static int field_no_list(const struct api_value *value, int n, struct api_problem *problem) {
    char expected[64] = "an array of numbers";
    if (n) snprintf(expected, sizeof expected, "an array of %d number%s", n, n == 1 ? "" : "s");
    return field_fault(value, KIND, expected, problem);
}

int api_field_numbers(const struct api_value *value, int n, const char *each, double out[],
                      struct api_problem *problem) {
    int count = api_value_count(value);
    if (api_value_kind(value) == API_MISSING) return 0;
    for (int i = 0; out && i < n; i++) out[i] = NAN;
    if (n == 1 && api_value_kind(value) == API_NUMBER) {
        if (out) *out = api_value_number(value);
        return 1;
    }
    if (api_value_kind(value) != API_ARRAY) return field_no_list(value, n, problem);
    int good = 1;
    if (n && count != n) {
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT "must have %d number%s, one for each %s, got %d", n,
                        n == 1 ? "" : "s", each, count);
        good = -1;
    }
    const double *numbers = api_value_numbers(value, &count);
    if (!numbers) return field_items(value, n, out, problem) < 0 ? -1 : good;
    if (out) memcpy(out, numbers, (size_t)(count < n ? count : n) * sizeof *out);
    return good;
}

int api_field_whole(const struct api_value *value, long least, long greatest, long *out,
                    struct api_problem *problem) {
    if (api_value_kind(value) == API_MISSING) return 0;
    double x = api_value_number(value);
    if (api_value_kind(value) == API_NUMBER && x == floor(x) && x >= (double)least &&
        x <= (double)greatest) {
        *out = (long)x;
        return 1;
    }
    char expected[80];
    snprintf(expected, sizeof expected, "a whole number from %ld to %ld", least, greatest);
    return field_fault(value, api_value_kind(value) == API_NUMBER ? SIZE : KIND, expected, problem);
}

int api_field_truth(const struct api_value *value, int *out, struct api_problem *problem) {
    if (api_value_kind(value) == API_MISSING) return 0;
    if (api_value_kind(value) != API_BOOL)
        return field_fault(value, KIND, "true or false", problem);
    *out = api_value_number(value) != 0;
    return 1;
}

/* writes the words that contain `part`, or all words if it is empty, as a list, as far as there is
 * space; returns their number */
static int field_list_words(const char *const words[], const char *part, char *list, size_t bytes) {
    static const char more[] = ", and others";
    size_t used = 0;
    int count = 0, full = 0;
    assert(bytes > sizeof more);
    list[0] = 0;
    for (int i = 0; words[i]; i++) {
        if (!strstr(words[i], part)) continue;
        size_t needed = strlen(words[i]) + sizeof "\"\", ";
        if (!full && used + needed + sizeof more <= bytes)
            used += (size_t)snprintf(list + used, bytes - used, "%s\"%s\"", count ? ", " : "",
                                     words[i]);
        else if (!full)
            full = snprintf(list + used, bytes - used, "%s", more) > 0;
        count++;
    }
    return count;
}

/* Adds an error for a text that is not in the list of words. It names the word that was probably
 * meant, the words that contain the text, or all of them. */
static void field_fault_word(const struct api_value *value, const char *const words[],
                             struct api_problem *problem) {
    enum { LEAST_PART = 3, MOST_OFFERED = 8 };
    char list[270], expected[sizeof list + 8];
    const char *text = api_value_text(value), *near = text ? api_did_you_mean(text, words) : NULL;
    if (near) {
        api_value_fault(value, problem, API_CODE_UNKNOWN_NAME "is not known; did you mean \"%s\"?",
                        near);
        return;
    }
    int part =
        text && strlen(text) >= LEAST_PART ? field_list_words(words, text, list, sizeof list) : 0;
    if (part && part <= MOST_OFFERED) {
        api_value_fault(value, problem,
                        API_CODE_UNKNOWN_NAME "is not known; did you mean one of %s?", list);
        return;
    }
    (void)field_list_words(words, "", list, sizeof list);
    snprintf(expected, sizeof expected, "one of %s", list);
    (void)field_fault(value, text ? WORD : KIND, expected, problem);
}

int api_field_word(const struct api_value *value, const char *const words[], int *out,
                   struct api_problem *problem) {
    if (api_value_kind(value) == API_MISSING) return 0;
    const char *text = api_value_text(value);
    for (int i = 0; text && words[i]; i++)
        if (!strcmp(text, words[i])) {
            *out = i;
            return 1;
        }
    if (!api_problem_full(problem)) field_fault_word(value, words, problem);
    return -1;
}

unsigned api_field_words(const struct api_value *list, const char *const words[],
                         struct api_problem *problem) {
    unsigned found = 0;
    if (api_value_kind(list) == API_MISSING) return 0;
    if (api_value_kind(list) != API_ARRAY || !api_value_count(list)) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one name, as [\"%s\"]",
                        words[0]);
        return 0;
    }
    API_VALUE_EACH (item, api_value_item(list, 0)) {
        int word = 0;
        if (api_field_word(&item, words, &word, problem) <= 0) continue;
        if (found >> word & 1) api_value_fault(&item, problem, API_CODE_DUPLICATE "is named twice");
        found |= 1u << word;
    }
    return found;
}
