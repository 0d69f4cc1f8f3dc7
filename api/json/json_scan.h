/* The strict scan of JSON: accepts RFC 8259 and nothing else, and builds the document's tree of
 * cJSON nodes in one pass over the text.
 * Leaves to others: reading the values of the tree (json_in), the number formats (number_read).
 * Invariant: an array of numbers has no nodes for its items; its doubles are contiguous in one
 * table. The tree is read-only: `prev` of its nodes is not set. */
#pragma once

#include "api/json/json_arena.h"
#include "api/base/problem.h"

/* the most members of an object, and the most values of a document, not counting those in arrays of
 * numbers */
enum { API_SCAN_MEMBERS = 256, API_SCAN_VALUES = 300000 };

/* A bit of a node's type that cJSON does not use: an array of `valueint` numbers, stored from
 * numbers[(size_t)valuedouble] of the document on. */
enum { API_SCAN_NUMBERS = 1 << 21 };

struct cJSON;

struct api_json {
    struct cJSON *root;
    struct api_arena nodes; /* the nodes and their strings */
    double *numbers;        /* the items of all arrays of numbers */
};

/**
 * Scans a document and builds its tree.
 *
 * document   out; released by api_scan_clear, also after a failure.
 * text       `bytes` long; need not end with NUL, and need not outlive the call.
 * depth_cap  deepest nesting accepted, >= 1.
 * problem    as for api_json_new; also 422 if the values would need more than about 20 bytes of
 *            memory per byte of text.
 *
 * PEND_INVALID    problem says why.
 * PEND_NO_MEMORY
 * O(bytes), no recursion.
 */
PEND_MUST_CHECK enum pend_status api_scan_run(struct api_json *document, const char *text,
                                              size_t bytes, int depth_cap,
                                              struct api_problem *problem);
void api_scan_clear(struct api_json *document);
