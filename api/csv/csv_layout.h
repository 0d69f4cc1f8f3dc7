/* The layout of a table of text: its separator, its rows, and the names and ranges of its columns.
 * Leaves to others: the quantity that a column measures (csv_roles).
 * Invariant: rows begin at line `first`; later lines that are not rows are counted and skipped. */
#pragma once

#include "api/csv/csv_cells.h"

/* What a column holds. */
struct api_csv_column {
    struct api_csv_cell name, unit, group; /* from the lines above the rows; 0 bytes if absent */
    long numbers, clocks, words;
    int word_line; /* the first row that has a word here */
    double first, last, low, high,
        step;    /* of the numbers; step: the smallest difference of consecutive rows */
    int rises;   /* never decreases from row to row, like a column of times */
    double from; /* the current swing: its turning point and its direction */
    int way;
    long swings, wide; /* swings between turning points; those of more than 2 pi */
    double weight, weights, mid, mids, reach; /* sums over swings, see api_csv_center */
};

struct api_csv {
    char separator;
    int comma;       /* the decimal mark is a comma */
    int doubtful;    /* no number shows whether "1,234" is 1.234 */
    int head, first; /* line numbers from 1; 0 = none */
    int columns;
    long rows, passed; /* skipped: lines below the first row that are not rows */
    const char *begin; /* the first row */
    struct api_csv_column column[API_CSV_COLUMNS];
};

/**
 * Finds out. The text is UTF-8, with or without its mark; names stay in it.
 *
 * Returns 0 where there are no two columns of numbers. O(bytes).
 */
int api_csv_look(struct api_csv *csv, const char *text);

/**
 * The number that a column swings about: the mean of the middles of its swings, weighted by the
 * squares of their sizes, so that noise hardly counts.
 *
 * center  out, in the column's unit; `error` is its standard error, `reach` half of a swing.
 *
 * Returns 0 where there are fewer than about five swings. O(1).
 */
int api_csv_center(const struct api_csv_column *column, double *center, double *error,
                   double *reach);

/**
 * Reads the next row: value[columns], NaN where a cell is empty or no number.
 *
 * at    in: csv->begin at first; out: behind the row.
 * line  in and out: its number.
 *
 * Returns 0 at the end of the text.
 */
int api_csv_row(const struct api_csv *csv, const char **at, int *line, double value[]);
