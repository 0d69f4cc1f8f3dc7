/* Cells of a text table, and the numbers in them, as people and programs write them.
 * Leaves to others: which lines are rows and what separates them (csv_layout), names (csv_names).
 * Invariant: reads text only up to its end; the locale does not matter. */
#pragma once

enum { API_CSV_COLUMNS = 64 };

/* The text of a cell without the blanks and quotes around it; not terminated by a NUL. */
struct api_csv_cell {
    const char *at;
    int bytes;
};

enum api_csv_kind {
    API_CSV_EMPTY,  /* no text, or a word for a missing value: "NaN", "-", "N/A" */
    API_CSV_NUMBER, /* "1.5", "1,5", "1.234,5", "-3e-2" */
    API_CSV_CLOCK,  /* "12:30:01.5", "2026-11-27 12:30:01": seconds since midnight, or since 1970 */
    API_CSV_WORD
};

/** Returns the end of a line: its CR or LF, or the end of the text. */
const char *api_csv_line_end(const char *line);

/** Returns the start of the next line; a line ends with CR, LF or CR LF. */
const char *api_csv_line_next(const char *line);

/**
 * Splits a line into cells. A separator in quotes is text; the separator ' ' is any run of blanks.
 *
 * Returns the number of cells, of which at most API_CSV_COLUMNS are stored. O(bytes).
 */
int api_csv_cut(const char *line, char separator, struct api_csv_cell cell[API_CSV_COLUMNS]);

/**
 * Reads a cell.
 *
 * comma  true if the decimal mark is a comma; thousands marks are skipped.
 * x      out, for a number or a clock.
 */
enum api_csv_kind api_csv_read(const struct api_csv_cell *cell, int comma, double *x);

/** Returns which decimal mark a cell proves: 1 a comma, -1 a point, 0 neither ("5", "1,234"). */
int api_csv_mark(const struct api_csv_cell *cell);
