/* Reading a request's JSON: typed access to the values of a document, with JSON pointers.
 * Leaves to others: the grammar (json_scan), the meaning of the fields (tree_json, op_*).
 * Invariant: no other file sees cJSON's nodes but json_scan, which builds them; arrays of numbers
 * are arrays of doubles and have no nodes for their items. */
#ifndef API_JSON_IN_H
#define API_JSON_IN_H

#include "api/base/problem.h"

struct api_json;

enum { API_FOUND_BYTES = 80 };

enum api_kind { API_MISSING, API_NULL, API_BOOL, API_NUMBER, API_STRING, API_ARRAY, API_OBJECT };

/* A place in the document. It points to its parent value, which must outlive it: values lie on
 * the reader's stack. */
struct api_value {
    const struct api_json *document;
    const void *node; /* NULL = missing */
    const struct api_value *parent;
    const char *key; /* of a member; NULL for an item or the root */
    int index;       /* of an item */
};

/**
 * Reads a document.
 *
 * document   out; NULL on failure; ends with api_json_free.
 * text       bytes of it; need not end with NUL, and need not outlive the call.
 * depth_cap  deepest nesting accepted.
 * problem    400 with line, column and byte if the text is not JSON (RFC 8259, and: no byte order
 *            mark, no key twice in one object, no number beyond the range of a double, no U+0000
 *            in a string); 422 if it is nested too deeply, an object has more than 256 members, or
 *            the document has more than 300000 values that are not in an array of numbers.
 *
 * PEND_INVALID    problem says why.
 * PEND_NO_MEMORY
 * O(bytes). Memory: at most about 20 bytes a byte of text; 8 bytes for a number in an array.
 */
PEND_MUST_CHECK enum pend_status api_json_new(struct api_json **document, const char *text,
                                              size_t bytes, int depth_cap,
                                              struct api_problem *problem);

/** Frees a document and all its values; nothing happens if it is NULL. */
void api_json_free(struct api_json **document);

/** The root of the document. */
struct api_value api_json_root(const struct api_json *document);

/** The kind of a value; API_MISSING for a member or an item that is not there. O(1). */
enum api_kind api_value_kind(const struct api_value *value);

/** Member `key` of an object; upper and lower case differ. A missing member has kind API_MISSING
 * and still has a pointer. O(members). */
struct api_value api_value_member(const struct api_value *object, const char *key);

/** The same, as an object that lives to the end of the block it is named in: for a member that is
 * looked at once. */
#define API_MEMBER(object_, key_) ((struct api_value[]){api_value_member(object_, key_)})

/** The number of items of an array or members of an object; 0 for anything else. */
int api_value_count(const struct api_value *value);

/** Item i of an array, i >= 0; missing from the count on. O(1) for arrays of numbers, else O(i):
 * use api_value_next to visit all items. */
struct api_value api_value_item(const struct api_value *array, int i);

/** The first item of an array or member of an object; missing if there is none. */
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

/** Writes the value's JSON pointer (RFC 6901), cut with "..." if it does not fit. */
void api_value_pointer(const struct api_value *value, char pointer[API_POINTER_BYTES]);

/** Adds a fault at the value. */
void api_value_fault(const struct api_value *value, struct api_problem *problem, const char *format,
                     ...) __attribute__((format(printf, 3, 4)));

/** Writes what a value is, for a message: "-1", "the text \"abc\"", "an object", "nothing" if it is
 * missing. */
void api_value_found(const struct api_value *value, char found[API_FOUND_BYTES]);

/*
 * Members that repeat a default. A reader that knows the default marks such a member, and the
 * digest skips it, so that a request with its defaults written out has the same digest as one
 * without. A member may be marked even if a request without it is refused; what matters is that no
 * request without it means something else.
 */

/** Marks a member; an item or a missing member is left unmarked. */
void api_value_usual(const struct api_value *member);

/** Marks a member if it is exactly this number, bit by bit. */
void api_value_usual_number(const struct api_value *member, double usual);

/** Marks a member if it is an array of zeros, or an empty array. */
void api_value_usual_zeros(const struct api_value *member);

/** Marks a member if it is an object all of whose members are marked. */
void api_value_usual_object(const struct api_value *member);

/** True for a marked member. */
int api_value_is_usual(const struct api_value *value);

/** The member whose key comes next behind `last` in the order of bytes, NULL = the first of all;
 * without a node behind the last. unusual: as if marked members were not there. O(members) */
struct api_value api_value_behind(const struct api_value *object, const char *last, int unusual);

/**
 * Adds a fault for every member that is not in the list; it says the name that was meant, if one is
 * near. Members that belong in another object of the list have one fault together.
 *
 * allowed  names, ended by NULL.
 * Returns the number of faults.
 */
int api_value_only(const struct api_value *object, const char *const allowed[],
                   struct api_problem *problem);

/**
 * True if a fault was added for a member of the object that was meant to be the member `key`; then
 * it is not missing besides. key NULL = any member. O(faults).
 */
int api_value_meant(const struct api_value *object, const char *key,
                    const struct api_problem *problem);

/**
 * Reads an optional number and checks its range.
 *
 * least    and greatest are allowed themselves; -INFINITY and INFINITY for no bound.
 * out      unchanged if the value is missing or faulty.
 * unit     for the message, "" for none.
 * Returns 1 when a good number was read, 0 when missing, -1 when faulty (a fault was added).
 */
int api_value_read_number(const struct api_value *value, double least, double greatest,
                          const char *unit, double *out, struct api_problem *problem);

#endif
