/* The field `derivatives` of a request, and the columns that it adds to the answer.
 * Leaves to others: the derivatives (core/derivatives), the outputs (samples, op_*).
 * Invariant: all columns of derivatives have the same name, with parts in the order of the outputs;
 * their last axis is the parameter, in the order of the request. */
#pragma once

#include "api/encode/encode.h"
#include "api/op/varied.h"
#include "api/read/state_json.h"
#include "api/read/method_json.h"
#include "core/derivatives/derivatives.h"

enum { API_DERIVED_MOST = 1000, API_DERIVED_LABEL = 24, API_DERIVED_TOTAL = PEND_DERIVED };

/* The quantities and the parameters of derivatives; all zero without derivatives. */
struct api_derived {
    int n;
    int count; /* number of parameters */
    struct pend_parameter *parameter;
    int columns;
    struct {
        int what;                      /* enum pend_derived, or API_DERIVED_TOTAL */
        char label[API_DERIVED_LABEL]; /* "phi", "z_re", "energy_total" */
    } column[API_COLUMNS / 2];

    /* set while the motion is computed */
    struct pend_derivatives *motion;
    long cap;      /* rows per block */
    double *block; /* the rows of all quantities */
    struct pend_derived_rows rows;
    double *total; /* NULL if not needed */
};

/**
 * Reads the field `derivatives`.
 *
 * derived  out; released by api_derived_clear, also after a failure; count is 0 if the field is
 *          missing.
 *
 * PEND_INVALID    every error was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_derived_read(struct api_derived *derived,
                                                  const struct api_value *value,
                                                  const struct api_tree *tree,
                                                  struct api_problem *problem);
void api_derived_clear(struct api_derived *derived);

/** Returns the estimated time, s, of a motion in which the fastest arm turns by a number of
 * radians. O(1). */
double api_derived_seconds(const struct api_derived *derived, const struct api_tree *tree,
                           double radians);

/** Adds the column of the derivatives of a quantity, whose name is `name` or `name_part`. The table
 * refers to the label in `derived`. */
void api_derived_add(struct api_derived *derived, struct api_table *table, const char *name,
                     const char *part, int what);

/** Returns the bytes of memory of a computation with blocks of that many rows. O(1). */
double api_derived_bytes(const struct api_derived *derived, const struct api_tree *tree, long rows);

/** Returns the number of rows per block, for `rows` rows in total. O(1). */
long api_derived_cap(const struct api_derived *derived, long rows);

/**
 * Creates the motion and the memory of its rows.
 *
 * cap  rows per block.
 *
 * PEND_NO_MEMORY; also fails as pend_derivatives_new does.
 */
PEND_MUST_CHECK enum pend_status api_derived_begin(struct api_derived *derived,
                                                   const struct pend_problem *problem, long cap,
                                                   struct pend_error *error);

/**
 * Computes the next rows of a block, from row `from` on.
 *
 * made  out: number of new rows, at most `rows`.
 *
 * Fails as pend_derivatives_next does.
 */
PEND_MUST_CHECK enum pend_status api_derived_next(struct api_derived *derived, long from, long rows,
                                                  double work, long *made,
                                                  struct pend_error *error);

/** Ends a motion and frees the memory of its rows; another may begin. */
void api_derived_end(struct api_derived *derived);

/** Computes one row of a block from a state, as pend_derivatives_state. */
void api_derived_state(struct api_derived *derived, const double phi[], const double phi_low[],
                       const double rate[], double time, long row);

/** Copies the numbers of all columns in a row of the block, column by column. Returns the end in
 * `to`. */
double *api_derived_put(const struct api_derived *derived, long row, double to[]);

/** Stores pointers to the rows of the columns, `columns` pointers. */
void api_derived_columns(const struct api_derived *derived, const double *column[]);

/** Returns the approximate angular frequency of the fastest arm, rad/s: that of the shortest arm,
 * higher with many arms below each other, and at least the rate of the start. start: NULL = at
 * rest. O(n). */
double api_swing(const struct api_tree *tree, const struct api_states *start);

/** Returns the effect of terms on the number of steps, as the rate of a swing that takes as many
 * steps, rad/s: a fifth of the rate of springs and drives, a twentieth of the decay rate of
 * friction. O(n + harmonics). */
double api_terms_pace(const struct api_tree *tree);
