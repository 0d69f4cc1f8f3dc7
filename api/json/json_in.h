/* Strict reading of a request's JSON: one scan that accepts RFC 8259 and nothing else, then
 * typed access with pointers.
 * Leaves to others: what the fields mean (tree_json, op_*).
 * Invariant: the only file that knows cJSON; arrays of numbers never become cJSON nodes but
 * arrays of doubles. */
#ifndef API_JSON_IN_H
#define API_JSON_IN_H

#include "api/base/problem.h"

struct api_json;

enum { API_FOUND_BYTES = 80 };

enum api_kind { API_MISSING, API_NULL, API_BOOL, API_NUMBER, API_STRING, API_ARRAY, API_OBJECT };

/* A place in the document. It points at its parent value, which must outlive it: values live on
 * the reader's stack. */
struct api_value {
    const struct api_json *document;
    const void *node; /* NULL = missing */
    const struct api_value *parent;
    const char *key; /* of a member; NULL for an item or the root */
    int index;       /* of an item */
};

/**
 * Scans and parses a document.
 *
 * document   out; NULL on failure.
 * text       bytes of it need not end with NUL; copied as far as needed.
 * depth_cap  deepest nesting accepted.
 * problem    400 with line, column and byte where it is no JSON (RFC 8259: grammar, UTF-8, escapes,
 *            no BOM, nothing behind it, one key once an object, no number beyond the range of a
 *            double, no NUL in a string); 422 where it is too deep, an object has more than 256
 *            members, or the document more than 300000 values that are not in an array of numbers.
 *
 * PEND_INVALID   problem says why.
 * PEND_NO_MEMORY O(bytes); memory at most about 20 bytes a byte of text, numbers in arrays 8 bytes
 * each.
 */
PEND_MUST_CHECK enum pend_status api_json_new(struct api_json **document, const char *text,
                                              size_t bytes, int depth_cap,
                                              struct api_problem *problem);

void api_json_free(struct api_json **document);

/** The root of the document. */
struct api_value api_json_root(const struct api_json *document);

enum api_kind api_value_kind(const struct api_value *value);

/** Member `key` of an object (exact, case counts); a missing one has kind API_MISSING and still
 * knows its pointer. */
struct api_value api_value_member(const struct api_value *object, const char *key);

/** Items of an array, members of an object, else 0. */
int api_value_count(const struct api_value *value);

/** Item i of an array, 0 <= i < count. O(1) for arrays of numbers, else O(i): walk with
 * api_value_next. */
struct api_value api_value_item(const struct api_value *array, int i);

/** The first item of an array or member of an object; missing where there is none. */
struct api_value api_value_first(const struct api_value *value);

/** The item after `item` in its array, or the member after it in its object; missing after the
 * last. */
struct api_value api_value_next(const struct api_value *item);

/** The doubles of an array whose items are all numbers (an empty array included); NULL for
 * anything else. */
const double *api_value_numbers(const struct api_value *array, int *count);

/** The text of a string, NUL-terminated UTF-8, owned by the document; NULL for anything else. */
const char *api_value_text(const struct api_value *value);

/** The value of a number or 0/1 of a boolean; 0 for anything else. */
double api_value_number(const struct api_value *value);

/** Writes the value's JSON pointer (RFC 6901), cut with "..." where it does not fit. */
void api_value_pointer(const struct api_value *value, char pointer[API_POINTER_BYTES]);

/** Adds a fault at the value. */
void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format,
                     ...) __attribute__((format(printf, 3, 4)));

/** Says what a value is, for a message: "-1", "the text \"abc\"", "an object", "nothing" where it
 * is missing. */
void api_value_found(const struct api_value *value, char found[API_FOUND_BYTES]);

/*
 * Members that say what would hold without them: a reader that knows the default marks them, and
 * the digest passes over them, so that a request is the same with its defaults written out. A
 * member may be marked where leaving it out would be refused: what matters is that no other request
 * means something else without it.
 */

/** Marks a member; an item or what is missing is left alone. */
void api_value_usual(const struct api_value *member);

/** Marks a member that is this number, to the bit. */
void api_value_usual_number(const struct api_value *member, double usual);

/** Marks a member that is an array of zeros, or an empty one. */
void api_value_usual_zeros(const struct api_value *member);

/** Marks a member that is an object with no members but marked ones. */
void api_value_usual_object(const struct api_value *member);

/** True for a marked member. */
int api_value_is_usual(const struct api_value *value);

/**
 * The allowed name that was probably meant by `name`, or NULL where none is near.
 *
 * allowed  names, ended by NULL.
 * O(names x length^2); names of more than 64 bytes are never near.
 */
const char *api_name_nearest(const char *name, const char *const allowed[]);

/**
 * Faults every member that is not in the list, with the nearest allowed name where one is near.
 *
 * allowed  names, ended by NULL.
 * Returns the number of faults.
 */
int api_value_only(const struct api_value *object, const char *const allowed[],
                   struct api_problem *problem);

/**
 * Reads an optional number and checks its range (ends included; a least above -INFINITY and so on
 * as wanted).
 *
 * out      left alone when the value is missing or faulty.
 * unit     for the message, "" for none.
 * Returns 1 when a good number was read, 0 when missing, -1 when faulty (a fault was added).
 */
int api_value_read_number(const struct api_value *value, double least, double greatest,
                          const char *unit, double *out, struct api_problem *problem);

#endif
