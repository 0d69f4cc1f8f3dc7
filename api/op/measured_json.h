/* A measured table in a request: reading it, and writing the roles of its columns as JSON.
 * Leaves to others: the layout and the guesses (api/csv), the fit of its data (op/fit).
 * Invariant: the request's own words about a column override guesses. */
#pragma once

#include "api/csv/csv_roles.h"
#include "api/op/op.h"
#include "api/read/tree_json.h"

enum { API_MEASURED_ADVICE = 200 };

/* A table; the names point into the document. */
struct api_measured {
    struct api_csv csv;
    struct api_csv_roles roles;
    long repeated;                    /* number of rows that equal the previous row */
    int untimed;                      /* line of the first row without an instant, or 0 */
    int downwards;                    /* whether y of the first tip counts downwards, as pixels
                                       * do */
    char advice[API_MEASURED_ADVICE]; /* likely mistakes in the numbers, or "" */
};

/** Reads `csv`, `unit`, `arms` and `columns` of `data`. If the pendulum has no arms and no errors,
 * the table names the arms. Returns 0 after an error. O(bytes). */
int api_measured_read(struct api_measured *table, const struct api_tree *tree,
                      const struct api_value *data, struct api_problem *problem);

/** Adds errors for a table without instants or without measured quantities, for rows without an
 * instant, and for words among the numbers that are used. Returns 0 after an error. O(columns). */
int api_measured_check(const struct api_measured *table, const struct api_value *text,
                       struct api_problem *problem);

/**
 * Writes the table as an object: its layout, and the role of each column.
 *
 * rows  number of rows, from the first on, that are written too.
 * data  whether to write "data" too, the measurements in the form of POST /v1/fits: `t`, s, and
 *       `series`, rad, rad/s, and positions in the table's unit; omitted if a fit would refuse the
 *       table.
 *
 * PEND_LIMIT (of the buffer), PEND_NO_MEMORY. O(rows columns) with data.
 */
PEND_MUST_CHECK enum pend_status api_measured_write(const struct api_measured *table, int rows,
                                                    int data, struct api_buffer *out);

/** Returns the distinct rows, (csv.rows - repeated) x csv.columns, which the caller frees; NaN for
 * cells without a number. NULL if memory is short. O(rows columns). */
double *api_measured_rows(const struct api_measured *table);

/** Returns the value of a row in a used column in the fit's units: s, rad, rad/s, positions in the
 * table's unit; NaN = not measured. If other measurements have standard errors, a measurement
 * without one counts as missing, and its error as 1. O(1). */
double api_measured_value(const struct api_measured *table, int column, const double row[]);
