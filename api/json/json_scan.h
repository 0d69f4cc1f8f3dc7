/* The strict scan: accepts RFC 8259 and nothing else, moves every number into a table of
 * doubles, leaves a small rest.
 * Leaves to others: building values of the rest (json_in).
 * Invariant: the rest is JSON that any parser reads alike; in it an integer k >= 0 stands for
 * number k, and -k - 1 for array k, an array whose items are all numbers. */
#ifndef API_JSON_SCAN_H
#define API_JSON_SCAN_H

#include "api/json/json_keys.h"
#include "api/base/problem.h"

/* of an object, and of a document but for those in arrays of numbers */
enum { API_SCAN_MEMBERS = 256, API_SCAN_VALUES = 300000 };

enum { API_SCAN_NODE = 80 }; /* bytes that a value may take in memory, beside its strings */

/* numbers[first .. first + count - 1] */
struct api_scan_array {
    size_t first;
    int count;
};

struct api_scan_frame; /* an array or object that is open */

struct api_scan {
    const char *text;
    size_t bytes, at;
    int depth, depth_cap, want;
    struct api_scan_frame *frames; /* depth of depth_cap */
    struct api_keys keys;
    double *numbers;
    size_t number_count, number_cap;
    struct api_scan_array *arrays;
    size_t array_count, array_cap;
    long nodes; /* values so far, but for those in arrays of numbers */
    size_t
        cost; /* memory of the values so far, bytes, at most: whoever builds them needs no more */
    struct api_buffer rest;
    struct api_problem *problem;
};

/**
 * Scans a document.
 *
 * scan       out: numbers, arrays and rest; ends with api_scan_clear whatever is returned.
 * text       bytes of it are read, not one more; need not outlive the call.
 * depth_cap  deepest nesting accepted, >= 1.
 * problem    as api_json_new says, and 422 for an object of more than API_SCAN_MEMBERS members, for
 *            more than
 * API_SCAN_VALUES values, and where they would need more than about 20 bytes a byte of text.
 *
 * PEND_INVALID, PEND_NO_MEMORY O(bytes), no recursion.
 */
PEND_MUST_CHECK enum pend_status api_scan_run(struct api_scan *scan, const char *text, size_t bytes,
                                              int depth_cap, struct api_problem *problem);

/** Frees all that a scan holds. */
void api_scan_clear(struct api_scan *scan);

#endif
