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
 * tree  the pendulum of the request; if it has no arms and no faults, the table names the arms.
 *
 * Returns 0 after a fault. O(bytes).
 */
int api_measured_read(struct api_measured *table, const struct api_tree *tree,
                      const struct api_value *data, struct api_problem *problem);

/** Adds faults for a table without instants or without measured quantities, for rows without an
 * instant, and for words among the numbers that are used. Returns 0 after a fault. O(columns). */
int api_measured_check(const struct api_measured *table, const struct api_value *text,
                       struct api_problem *problem);

/**
 * Writes the table as an object: its layout, and the role of each column.
 *
 * rows  the number of first rows that are written too.
 * data  writes "data" too, the measurements as POST /v1/fits takes them: `t`, s, and `series`, rad,
 *       rad/s, and positions in the table's unit; omitted if a fit would refuse the table.
 *
 * PEND_LIMIT of the buffer, PEND_NO_MEMORY. O(rows columns) with data.
 */
PEND_MUST_CHECK enum pend_status api_measured_write(const struct api_measured *table, int rows,
                                                    int data, struct api_buffer *out);

/** Returns the distinct rows, (csv.rows - repeated) x csv.columns; NaN for cells without a number;
 * the caller frees them. NULL = no memory. O(rows columns). */
double *api_measured_rows(const struct api_measured *table);

/** Returns the value of a row in a used column in the fit's units: s, rad, rad/s, positions in the
 * table's unit; NaN = not measured. A measurement without a standard error is NaN if others have
 * one, and that error is then 1. O(1). */
double api_measured_value(const struct api_measured *table, int column, const double row[]);
