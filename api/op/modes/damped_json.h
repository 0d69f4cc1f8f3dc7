/* The answer of /v1/modes for a real pendulum: the equilibrium, and its modes with their decay.
 * Leaves to others: reading the request (modes_json), the modes (core/modes/damped).
 * Invariant: modes that grow come first, then the slowest; the shape of a mode has an entry of 1.
 */
#ifndef API_DAMPED_JSON_H
#define API_DAMPED_JSON_H

#include "api/encode/encode.h"
#include "api/op/op.h"
#include "api/read/tree_json.h"
#include "core/modes/damped.h"

/* The most arms whose modes are found, with friction and without; and as poles of a response, which
 * are found at once. */
enum {
    API_DAMPED_ARMS = 1000,
    API_STILL_ARMS = 2000,
    API_POLES_DAMPED = 100,
    API_POLES_ARMS = 300
};

/* What is answered, and what was found. */
struct api_damped {
    const struct api_tree *tree; /* with terms; not owned */
    const double *phi; /* n: where the equilibrium is looked for, stored order; not owned */
    const struct api_format *format;
    struct api_table table; /* one row a mode */
    int vectors;            /* the shapes are answered */
    const char *include;    /* PEND_MATRIX_COUNT flags: the matrices that are answered; not owned */
    struct pend_damped *found;
    double *column[API_COLUMNS];     /* one block */
    const double *told[API_COLUMNS]; /* those that are answered */
    struct api_writer *writer;
    struct api_stats stats;
    char warning[2][API_WARNING_TEXT];
    int row; /* the next row of the table, or part of the JSON */
};

/**
 * Prepares an answer.
 *
 * damped  out; must be cleared by api_damped_clear.
 * table   the rows are the most that there can be, two an arm.
 */
void api_damped_init(struct api_damped *damped, const struct api_tree *tree, const double phi[],
                     const struct api_format *format, int digits, int vectors,
                     const char include[PEND_MATRIX_COUNT]);

/** Frees what was found. */
void api_damped_clear(struct api_damped *damped);

/**
 * Goes on with the computation, and appends the whole answer once it is complete.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE no equilibrium was found.
 * A millisecond or so without friction, else O(n^3).
 */
PEND_MUST_CHECK enum pend_status api_damped_run(struct api_damped *damped, struct api_buffer *out,
                                                int *done, struct pend_error *error);

/** Estimates the computation, s, and the memory, bytes. O(1). */
double api_damped_cost(const struct api_damped *damped);
double api_damped_bytes(const struct api_damped *damped);

#endif
