/* The answer of /v1/modes for a real pendulum: the equilibrium, and its modes with their decay.
 * Leaves to others: reading the request (modes_json), the modes (core/modes/damped).
 * Invariant: growing modes come first, then the others by frequency; the largest entry of a shape
 * is 1. */
#pragma once

#include "api/encode/encode.h"
#include "api/op/op.h"
#include "api/read/tree_json.h"
#include "core/modes/damped.h"

/* The most arms whose modes are computed: with friction, without, and as poles of a response, which
 * are computed in one turn. */
enum {
    API_DAMPED_ARMS = 1000,
    API_STILL_ARMS = 2000,
    API_POLES_DAMPED = 100,
    API_POLES_ARMS = 300
};

/* The requested answer, and the results. */
struct api_damped {
    const struct api_tree *tree; /* with terms; not owned */
    const double *phi; /* n: start of the search for the equilibrium, stored order; not owned */
    const struct api_format *format;
    struct api_table *table; /* one row per mode; not owned */
    int vectors;             /* whether the answer includes the shapes */
    const char *include;     /* PEND_MATRIX_COUNT flags: which matrices are requested; not owned */
    struct pend_damped *found;
    double *column[API_COLUMNS];     /* pointers into one block */
    const double *told[API_COLUMNS]; /* the columns that the answer contains */
    struct api_writer *writer;
    struct api_stats *stats; /* not owned */
    char warning[2][API_WARNING_TEXT];
    int row; /* the next row of the table, or the next piece of the JSON */
};

/**
 * Prepares an answer.
 *
 * damped  out, except table and stats; must be cleared by api_damped_clear.
 * table   its number of rows is the largest possible, two per arm.
 */
void api_damped_init(struct api_damped *damped, const struct api_tree *tree, const double phi[],
                     const struct api_format *format, int digits, int vectors,
                     const char include[PEND_MATRIX_COUNT]);
void api_damped_clear(struct api_damped *damped);

/**
 * Continues the computation, and appends the whole answer once it is complete.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE no equilibrium was found.
 * About a millisecond without friction, else O(n^3).
 */
PEND_MUST_CHECK enum pend_status api_damped_run(struct api_damped *damped,
                                                const struct api_turn *turn, int *done,
                                                struct pend_error *error);

/** api_damped_cost returns the estimated time of the computation, s; api_damped_bytes its memory,
 * bytes. O(1). */
double api_damped_cost(const struct api_damped *damped);
double api_damped_bytes(const struct api_damped *damped);
