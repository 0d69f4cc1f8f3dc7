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
    int controllers; /* of the pendulum */
};

/**
 * Reads the names of outputs; the default is phi, phid, lambda.
 *
 * Every fault is added to the problem.
 */
void api_outputs_read(struct api_outputs *outputs, const struct api_value *value,
                      struct api_problem *problem);

/** Non-zero if the place of a cart is among the outputs. O(1). */
int api_outputs_cart(const struct api_outputs *outputs);

/** Faults the output `control` of a pendulum without controllers, and notes how many it has. */
void api_outputs_control(struct api_outputs *outputs, const struct api_tree *tree,
                         const struct api_value *value, struct api_problem *problem);

/** Sets the columns of the outputs for n arms, t first; the rest of the table is unchanged. */
void api_outputs_columns(const struct api_outputs *outputs, int n, struct api_table *table);

/** Adds the columns of the derivatives of the outputs, behind those of the outputs themselves. Work
 * and heat have none: asking for them is a fault. */
void api_outputs_derived(const struct api_outputs *outputs, const struct api_value *value,
                         struct api_derived *derived, struct api_table *table,
                         struct api_problem *problem);

/* Samples of n arms and pointers to their columns, in one block of memory. */
struct api_samples {
    struct pend_samples samples;
    int n;
    double *total; /* NULL = not wanted */
    const double *column[API_COLUMNS];
};

/**
 * Allocates samples.
 *
 * samples  out; NULL on failure; ends with api_samples_free.
 * rows     of the whole table; a block has at most so many, and fewer the more arms there are.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status
api_samples_new(struct api_samples **samples, const struct api_outputs *outputs, int n, long rows);

/** Frees the samples; nothing happens if they are NULL. */
void api_samples_free(struct api_samples **samples);

/** Computes the outputs that are functions of other outputs, in the rows that are filled. */
void api_samples_derive(struct api_samples *samples);
