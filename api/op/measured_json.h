/* A measured table in a request: reading it, and what its columns were taken for, as JSON.
 * Leaves to others: the layout and the guesses (api/csv), what a fit does with it (op/fit).
 * Invariant: what the request says of a column goes before what is guessed. */
#pragma once

#include "api/csv/csv_roles.h"
#include "api/op/op.h"
#include "api/read/tree_json.h"

enum { API_MEASURED_ADVICE = 200 };

/* A table; the names point into the document. */
struct api_measured {
    struct api_csv csv;
    struct api_csv_roles roles;
    long repeated;                    /* number of rows equal to the previous row */
    int untimed;                      /* the line of the first row without an instant, or 0 */
    int downwards;                    /* y of the first tip counts downwards, as pixels do */
    char advice[API_MEASURED_ADVICE]; /* likely mistakes in the numbers, or "" */
};

/**
 * Reads `csv`, `unit`, `arms` and `columns` of `data`.
 *
 * tree  what the request says of the pendulum; without arms and faults the table names the arms.
 *
 * Returns 0 after a fault. O(bytes).
 */
int api_measured_read(struct api_measured *table, const struct api_tree *tree,
                      const struct api_value *data, struct api_problem *problem);

/** Faults a table without instants or without what is measured of a pendulum, rows without an
 * instant, and words among the numbers that are used. Returns 0 after a fault. O(columns). */
int api_measured_check(const struct api_measured *table, const struct api_value *text,
                       struct api_problem *problem);

/**
 * Writes the table as an object: its layout, and what each column was taken for.
 *
 * rows  so many of the first rows are written too.
 * data  writes "data" too, the measurements as POST /v1/fits takes them: `t`, s, and `series`, rad,
 *       rad/s, and places as the table has them; not where a fit would refuse the table.
 *
 * PEND_LIMIT of the buffer, PEND_NO_MEMORY. O(rows columns) with data.
 */
PEND_MUST_CHECK enum pend_status api_measured_write(const struct api_measured *table, int rows,
                                                    int data, struct api_buffer *out);

/** Returns the rows that count, csv.rows - repeated times csv.columns, NaN where a cell has no
 * number; the caller frees them. NULL = no memory. O(rows columns). */
double *api_measured_rows(const struct api_measured *table);

/** Returns what a row has in a column that is used, as a fit has it: s, rad, rad/s, places in the
 * table's unit; NaN = not measured, as what has no standard error where the others have: that is 1
 * then. O(1). */
double api_measured_value(const struct api_measured *table, int column, const double row[]);
