/* The words in a column's name, in twelve languages and in the spelling of common programs.
 * Leaves to others: the conclusions drawn from them (csv_roles).
 * Invariant: upper and lower case are equal. */
#pragma once

#include "api/csv/csv_cells.h"

enum api_csv_word {
    API_CSV_WORD_TIME = 1 << 0,
    API_CSV_WORD_ANGLE = 1 << 1,
    API_CSV_WORD_PHI = 1 << 2,
    API_CSV_WORD_X = 1 << 3,
    API_CSV_WORD_Y = 1 << 4,
    API_CSV_WORD_RATE = 1 << 5,   /* omega, gyroscope */
    API_CSV_WORD_SPEED = 1 << 6,  /* velocity; together with an angle it means a rate */
    API_CSV_WORD_ERROR = 1 << 7,  /* uncertainty */
    API_CSV_WORD_MODEL = 1 << 8,  /* simulated, fitted */
    API_CSV_WORD_FRAME = 1 << 9,  /* number of a video frame */
    API_CSV_WORD_OTHER = 1 << 10, /* radius, likelihood, energy: quantities that cannot be fitted */
    API_CSV_WORD_PRIME = 1 << 11, /* a derivative: X' */
    API_CSV_WORD_JOINT = 1 << 12  /* an angle between two arms */
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
