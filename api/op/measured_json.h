/* A measured table in a request: reading it, and what its columns were taken for, as JSON.
 * Leaves to others: the layout and the guesses (api/csv), what a fit does with it (op/fit).
 * Invariant: what the request says of a column goes before what is guessed. */
#ifndef API_MEASURED_JSON_H
#define API_MEASURED_JSON_H

#include "api/csv/csv_roles.h"
#include "api/op/op.h"
#include "api/read/tree_json.h"

enum { API_MEASURED_ADVICE = 200 };

/* A table; names stay in the document. */
struct api_measured {
    struct api_csv csv;
    struct api_csv_roles roles;
    long repeated;                    /* rows that say what the row before them says */
    int downwards;                    /* y of the first tip counts downwards, as pixels do */
    char advice[API_MEASURED_ADVICE]; /* what is probably wrong with the numbers, or "" */
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

/** Faults a table without instants or without what is measured of a pendulum, and words among the
 * numbers that are used. Returns 0 after a fault. O(columns). */
int api_measured_check(const struct api_measured *table, const struct api_value *text,
                       struct api_problem *problem);

/**
 * Writes the table as an object: its layout, and what each column was taken for.
 *
 * rows  so many of the first rows are written too.
 */
PEND_MUST_CHECK enum pend_status api_measured_write(const struct api_measured *table, int rows,
                                                    struct api_buffer *out);

/** Whether a row says in all columns that are used what the row before it says. O(columns). */
int api_measured_repeats(const struct api_measured *table, const double row[],
                         const double before[]);

#endif
