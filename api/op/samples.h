/* A block of a trajectory's samples: the outputs that a request can name, their arrays, and the
 * answer's columns.
 * Leaves to others: filling it (core/integrate/run/run), writing it (encode).
 * Invariant: column 0 is t; the others are in the order of the request's outputs. */
#pragma once

#include "api/op/derived.h"
#include "api/read/field.h"
#include "core/integrate/run/run.h"

enum { API_OUTPUTS = 14 };

/* The outputs of a request, in its order, as indices into the table of outputs. */
struct api_outputs {
    int count;
    int output[API_OUTPUTS];
    int controllers; /* number of controllers of the pendulum */
};

/**
 * Reads the names of outputs; the default is phi, phid, lambda.
 *
 * Every error is added to the problem.
 */
void api_outputs_read(struct api_outputs *outputs, const struct api_value *value,
                      struct api_problem *problem);

/** Returns non-zero if the position of a cart is one of the outputs. O(1). */
int api_outputs_cart(const struct api_outputs *outputs);

/** Adds an error if the output `control` is requested for a pendulum without controllers; stores
 * their number. */
void api_outputs_control(struct api_outputs *outputs, const struct api_tree *tree,
                         const struct api_value *value, struct api_problem *problem);

/** Sets the columns of the outputs for n arms, t first; the rest of the table is not changed. */
void api_outputs_columns(const struct api_outputs *outputs, int n, struct api_table *table);

/** Adds the columns of the derivatives of the outputs, after those of the outputs themselves. Adds
 * an error if work or heat is requested, which have no derivatives. */
void api_outputs_derived(const struct api_outputs *outputs, const struct api_value *value,
                         struct api_derived *derived, struct api_table *table,
                         struct api_problem *problem);

/* Samples of n arms and pointers to their columns, in one block of memory. */
struct api_samples {
    struct pend_samples samples;
    int n;
    double *total; /* NULL if not requested */
    const double *column[API_COLUMNS];
};

/**
 * Allocates samples.
 *
 * samples  out; NULL on failure; released by api_samples_free.
 * rows     of the whole table; a block has at most that many, and fewer if there are many arms.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status
api_samples_new(struct api_samples **samples, const struct api_outputs *outputs, int n, long rows);
void api_samples_free(struct api_samples **samples);

/** Computes the outputs that are functions of other outputs, in the rows that are filled. */
void api_samples_derive(struct api_samples *samples);
