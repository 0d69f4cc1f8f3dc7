/* The strict scan: accepts RFC 8259 and nothing else, and leaves the document as three tables: nodes, numbers, texts.
 * Leaves to others: finding one's way in them (json_in).
 * Invariant: an array whose items are all numbers is one node and a run of doubles; nodes stand in document order. */
#ifndef API_JSON_SCAN_H
#define API_JSON_SCAN_H

#include <stdint.h>

#include "api/problem.h"

enum { API_SCAN_MEMBERS = 256 };

enum api_node_kind {
    API_NODE_NULL,
    API_NODE_FALSE,
    API_NODE_TRUE,
    API_NODE_NUMBER,  /* numbers[at] */
    API_NODE_TEXT,    /* texts + at, count bytes and a NUL */
    API_NODE_NUMBERS, /* numbers[at .. at + count - 1] */
    API_NODE_ARRAY,   /* count items, the first is the next node */
    API_NODE_OBJECT   /* count members, the first is the next node */
};

struct api_node {
    uint32_t kind;
    uint32_t key;  /* of a member: texts + key */
    uint32_t next; /* the node of the next item or member, 0 = none */
    uint32_t at, count;
};

struct api_scan_frame; /* an array or object that is open */
struct api_scan_key;   /* a key of an object that is open */

struct api_scan {
    struct api_node *nodes; /* the root is the first */
    double *numbers;
    struct api_buffer texts;
    size_t node_count, node_cap, number_count, number_cap;

    /* while it scans */
    const char *text;
    size_t bytes, at;
    int depth, depth_cap, want;
    struct api_scan_frame *frames; /* depth of depth_cap */
    struct api_scan_key *keys;
    uint32_t *hashes; /* of the keys */
    size_t key_count, key_cap, hash_cap;
    struct api_problem *problem;
};

/**
 * Scans a document.
 *
 * scan       out: nodes, numbers and texts; ends with api_scan_clear whatever is returned.
 * text       bytes of it are read, not one more; need not outlive the call.
 * bytes      at most 2^31.
 * depth_cap  deepest nesting accepted, >= 1.
 * problem    as api_json_new says, and 422 for an object of more than API_SCAN_MEMBERS members.
 *
 * PEND_INVALID, PEND_NO_MEMORY
 * O(bytes), no recursion.
 */
PEND_MUST_CHECK enum pend_status api_scan_run(struct api_scan *scan, const char *text, size_t bytes, int depth_cap,
                                              struct api_problem *problem);

/** Frees all that a scan holds. */
void api_scan_clear(struct api_scan *scan);

#endif
