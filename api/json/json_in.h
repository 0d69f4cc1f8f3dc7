/* Reading a request's JSON: typed access to the values of a document, with JSON pointers.
 * Leaves to others: the grammar (json_scan), the meaning of the fields (tree_json, op_*).
 * Invariant: only this file and json_scan, which builds them, access cJSON's nodes; arrays of
 * numbers are arrays of doubles without nodes for their items. */
#pragma once

#include "api/base/problem.h"

struct api_json;

enum { API_FOUND_BYTES = 80 };

enum api_kind { API_MISSING, API_NULL, API_BOOL, API_NUMBER, API_STRING, API_ARRAY, API_OBJECT };

/* A value in the document. It points to its parent, which must stay valid: values are on the
 * reader's stack. */
struct api_value {
    const struct api_json *document;
    const void *node; /* NULL = missing */
    const struct api_value *parent;
    const char *key; /* key of a member; NULL for an item or the root */
    int index;       /* index of an item */
};

/**
 * Reads a document.
 *
 * document   out; NULL on failure; released by api_json_free.
 * text       `bytes` long; need not end with NUL, and need not outlive the call.
 * depth_cap  deepest nesting accepted.
 * problem    400 with line, column and byte if the text is not JSON (RFC 8259, and: no byte order
 *            mark, no duplicate key in an object, no number outside the range of a double, no
 * U+0000 in a string); 422 if it is nested too deeply, an object has more than 256 members, or the
 * document has more than 300000 values outside arrays of numbers.
 *
 * PEND_INVALID    problem says why.
 * PEND_NO_MEMORY
 * O(bytes). Memory: at most about 20 bytes per byte of text; 8 bytes for a number in an array.
 */
PEND_MUST_CHECK enum pend_status api_json_new(struct api_json **document, const char *text,
                                              size_t bytes, int depth_cap,
                                              struct api_problem *problem);
void api_json_free(struct api_json **document);

/** Returns the root of the document. */
struct api_value api_json_root(const struct api_json *document);

/** Returns the kind of a value; API_MISSING if the member or item does not exist. O(1). */
enum api_kind api_value_kind(const struct api_value *value);

/** Returns member `key` of an object; case matters. A missing member has kind API_MISSING and a
 * valid pointer. O(members). */
struct api_value api_value_member(const struct api_value *object, const char *key);

/** The same member as a temporary that is valid until the end of the enclosing block. */
#define API_MEMBER(object_, key_) ((struct api_value[]){api_value_member(object_, key_)})

/** Returns the number of items of an array or members of an object; 0 for anything else. */
int api_value_count(const struct api_value *value);

/** Returns item i of an array, i >= 0; missing beyond the end. O(1) for arrays of numbers, else
 * O(i): use api_value_next to visit all items. */
struct api_value api_value_item(const struct api_value *array, int i);

/** Returns the first item of an array or member of an object; missing if it is empty. */
struct api_value api_value_first(const struct api_value *value);

/** Returns the item after `item` in its array, or the member after it in its object; missing after
 * the last. */
struct api_value api_value_next(const struct api_value *item);

/* Visits the items or members from the first one on. */
#define API_VALUE_EACH(item, first)                                                                \
    for (struct api_value item = first; api_value_kind(&item) != API_MISSING;                      \
         item = api_value_next(&item))

/** Returns the doubles of an array whose items are all numbers (or of an empty array); NULL for
 * anything else. */
const double *api_value_numbers(const struct api_value *array, int *count);

/** Returns the text of a string, NUL-terminated UTF-8, owned by the document; NULL for anything
 * else. */
const char *api_value_text(const struct api_value *value);

/** Returns the value of a number, or 0/1 for a boolean; 0 for anything else. */
double api_value_number(const struct api_value *value);

/** Writes the value's JSON pointer (RFC 6901), cut with "..." if it does not fit. */
void api_value_pointer(const struct api_value *value, char pointer[API_POINTER_BYTES]);

/** Adds an error at the value. */
void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format,
                     ...) __attribute__((format(printf, 3, 4)));

/** Describes a value for a message: "-1", "the text \"abc\"", "an object"; "nothing" if it is
 * missing. */
void api_value_found(const struct api_value *value, char found[API_FOUND_BYTES]);

/* The reader marks members that repeat a default and the digest skips them, so that a request has
 * the same digest with and without its defaults. A member may be marked even if a request without
 * it is refused, but not if a request without it has another meaning. */

/** Marks a member. Items and missing members are not changed. */
void api_value_usual(const struct api_value *member);

/** Marks a member if it is this number, bit for bit. */
void api_value_usual_number(const struct api_value *member, double usual);

/** Marks a member if it is an array of zeros, or an empty array. */
void api_value_usual_zeros(const struct api_value *member);

/** Marks a member if it is an object all of whose members are marked. */
void api_value_usual_object(const struct api_value *member);

/** Returns true for a marked member. */
int api_value_is_usual(const struct api_value *value);

/** Returns the member whose key follows `last` in byte order (the first if `last` is NULL); missing
 * after the last. unusual: non-zero skips marked members. O(members). */
struct api_value api_value_behind(const struct api_value *object, const char *last, int unusual);

/**
 * Adds an error for every member that is not in the list, with the likely intended name. Members
 * that belong in another listed object share one error.
 *
 * allowed  names, ended by NULL.
 * Returns the number of errors.
 */
int api_value_only(const struct api_value *object, const char *const allowed[],
                   struct api_problem *problem);

/** Returns true if an error was added for a misspelling of `key`, so that `key` needs no second
 * error. key NULL = any member. O(errors). */
int api_value_meant(const struct api_value *object, const char *key,
                    const struct api_problem *problem);

/**
 * Reads an optional number and checks its range.
 *
 * least, greatest  inclusive bounds; -INFINITY and INFINITY for no bound.
 * out      unchanged if the value is missing or invalid.
 * unit     for the message; "" = none.
 * Returns 1 if a valid number was read, 0 if it is missing, -1 if invalid (an error was added).
 */
int api_value_read_number(const struct api_value *value, double least, double greatest,
                          const char *unit, double *out, struct api_problem *problem);
