/* Cells of a text table as people and programs write them: numbers, clock times, and the words and
 * units of a column's name, in twelve languages and in the spelling of common programs.
 * Leaves to others: which lines are rows and what separates them (csv_layout), roles (csv_roles).
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
    API_CSV_NUMBER, /* a number: "1.5", "1,5", "1.234,5", "-3e-2" */
    API_CSV_CLOCK,  /* "12:30:01.5" = seconds since midnight, "2026-11-27 12:30:01" = since 1970 */
    API_CSV_WORD
};

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

/** Returns which decimal mark a cell proves: 1 = comma, -1 = point, 0 = neither ("5", "1,234"). */
int api_csv_mark(const struct api_csv_cell *cell);

/* Words of a column's name; upper and lower case are equal. */
enum api_csv_word {
    API_CSV_WORD_TIME = 1 << 0,
    API_CSV_WORD_ANGLE = 1 << 1,
    API_CSV_WORD_PHI = 1 << 2,
    API_CSV_WORD_X = 1 << 3,
    API_CSV_WORD_Y = 1 << 4,
    API_CSV_WORD_RATE = 1 << 5,   /* omega, gyroscope */
    API_CSV_WORD_SPEED = 1 << 6,  /* velocity; together with an angle it means a rate */
    API_CSV_WORD_ERROR = 1 << 7,  /* uncertainty */
    API_CSV_WORD_MODEL = 1 << 8,  /* results of a model, not measurements: simulated, fitted */
    API_CSV_WORD_FRAME = 1 << 9,  /* number of a video frame */
    API_CSV_WORD_OTHER = 1 << 10, /* radius, likelihood, energy: quantities that cannot be fitted */
    API_CSV_WORD_PRIME = 1 << 11, /* a derivative, written with a prime: X' */
    API_CSV_WORD_JOINT = 1 << 12, /* an angle between two arms */
    API_CSV_WORD_AMPLITUDE = 1 << 13,
    API_CSV_WORD_PERIOD = 1 << 14,
    API_CSV_WORD_ALONG = 1 << 15, /* an acceleration along an arm, or across it */
    API_CSV_WORD_ACROSS = 1 << 16,
    API_CSV_WORD_CART = 1 << 17
};

/* The parts of a name. */
struct api_csv_words {
    int words;  /* flags of enum api_csv_word */
    int number; /* the last number in the name; -1 = none */
    double s, rad, m,
        rad_s; /* size of the name's unit in s, rad, m or rad/s; 0 if the unit is of another kind */
    int pixels;
};

/** Splits a name and a unit into parts; either may be empty. O(bytes). */
struct api_csv_words api_csv_words_of(const struct api_csv_cell *name,
                                      const struct api_csv_cell *unit);

/** Returns whether a cell contains only a unit, such as "deg" or "(s)". O(bytes). */
int api_csv_is_unit(const struct api_csv_cell *cell);
