/* Reads a request for modes from JSON: the tree, its equilibrium, the selection of modes, and the
 * contents of the answer.
 * Leaves to others: the modes and the size of the answer (op_modes).
 * Invariant: contains no pointer into the document. */
#pragma once

#include "api/op/derived.h"
#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/modes/matrix.h"
#include "core/modes/modes.h"

struct api_modes {
    struct api_tree tree;
    struct api_states *start;          /* NULL if no start was given */
    struct pend_modes_request request; /* loads, vectors and up are not set */
    unsigned char *up; /* n flags in stored order, 1 for upright arms; NULL if all hang */
    int vectors;       /* whether the answer includes the vectors */
    int digits;        /* significant digits of the answer; 0 = as many as needed */
    char include[PEND_MATRIX_COUNT]; /* flags: which matrices are requested */
    struct api_derived derived;      /* only its parameters */
};

/**
 * Reads and checks a request.
 *
 * modes  out; released by api_modes_clear, also after a failure.
 *
 * Every error is added to the reading's problem.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_modes_read(struct api_modes *modes,
                                                const struct api_reading *reading);
void api_modes_clear(struct api_modes *modes);
