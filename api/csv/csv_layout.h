/* How a table of text is laid out: what separates its cells, which lines are rows, which name the
 * columns, and what its columns hold.
 * Leaves to others: what a column is of a pendulum (csv_roles).
 * Invariant: rows begin at line `first`; a line that is no row below is counted and passed over. */
#pragma once

#include "api/csv/csv_cells.h"

/* What a column holds. */
struct api_csv_column {
    struct api_csv_cell name, unit,
        group; /* of the lines above; without bytes where there is none */
    long numbers, clocks, words;
    int word_line;                       /* the first row with a word in it */
    double first, last, low, high, step; /* of numbers; step: the smallest between neighbours */
    int rises;                           /* from row to row, or stays: the instants of a file */
    double from; /* of the swing that it is in: where it turned last, and which way it goes */
    int way;
    long swings, wide; /* from one turning point to the next; those of more than 2 pi */
    double weight, weights, mid, mids, reach; /* sums over swings, see api_csv_center */
};

struct api_csv {
    char separator;
    int comma;       /* the decimal mark is a comma */
    int doubtful;    /* nothing tells whether "1,234" is 1.234 */
    int head, first; /* lines from 1; 0 where there is none */
    int columns;
    long rows, passed; /* lines below the first row that are none */
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
