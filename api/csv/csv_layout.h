/* The layout of a text table: its separator, its rows, and the names and ranges of its columns.
 * Leaves to others: the quantity that a column measures (csv_roles).
 * Invariant: rows begin at line `first`; later lines that are not rows are counted and skipped. */
#pragma once

#include "api/csv/csv_cells.h"

/* The properties of a column. */
struct api_csv_column {
    struct api_csv_cell name, unit, group; /* from the lines above the rows; 0 bytes = absent */
    long numbers, clocks, words;
    int word_line; /* line of the first row with a word in this column */
    double first, last, low, high,
        step;    /* ranges of the numbers; step: the smallest difference between consecutive rows */
    int rises;   /* true if the numbers never decrease, as times do */
    double from; /* the current swing: its turning point and its direction */
    int way;
    long swings, wide; /* number of swings between turning points; number of those above 2 pi */
    double weight, weights, mid, mids, reach; /* sums over the swings, for api_csv_center */
};

struct api_csv {
    char separator;
    int comma;       /* true if the decimal mark is a comma */
    int doubtful;    /* true if it is undecided whether "1,234" means 1.234 */
    int head, first; /* line numbers from 1; 0 = none */
    int columns;
    long rows, passed; /* number of rows; number of later lines that are not rows */
    const char *begin; /* start of the first row */
    struct api_csv_column column[API_CSV_COLUMNS];
};

/**
 * Determines the layout of a text in UTF-8, with or without a byte order mark; names point into it.
 *
 * Returns 0 if there are no two columns of numbers. O(bytes).
 */
int api_csv_look(struct api_csv *csv, const char *text);

/**
 * Computes the number about which a column swings: the mean of the centres of its swings, weighted
 * by the squares of their sizes, so that noise hardly counts.
 *
 * center  out, in the column's unit; `error` is its standard error, `reach` half of a swing.
 *
 * Returns 0 if there are fewer than about five swings. O(1).
 */
int api_csv_center(const struct api_csv_column *column, double *center, double *error,
                   double *reach);

/**
 * Reads the next row into value[columns]; NaN for an empty cell or text that is not a number.
 *
 * at    in: at first csv->begin; out: the end of the row.
 * line  in and out: line number of the row.
 *
 * Returns 0 at the end of the text.
 */
int api_csv_row(const struct api_csv *csv, const char **at, int *line, double value[]);
