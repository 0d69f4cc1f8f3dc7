/* The words in a column's name, in ten languages and in the spelling of the programs that write
 * tables.
 * Leaves to others: what follows from them (csv_roles).
 * Invariant: upper and lower case are alike. */
#pragma once

#include "api/csv/csv_cells.h"

enum api_csv_word {
    API_CSV_WORD_TIME = 1 << 0,
    API_CSV_WORD_ANGLE = 1 << 1,
    API_CSV_WORD_PHI = 1 << 2,
    API_CSV_WORD_X = 1 << 3,
    API_CSV_WORD_Y = 1 << 4,
    API_CSV_WORD_RATE = 1 << 5,   /* omega, gyroscope */
    API_CSV_WORD_SPEED = 1 << 6,  /* velocity: with an angle it is a rate */
    API_CSV_WORD_ERROR = 1 << 7,  /* uncertainty */
    API_CSV_WORD_MODEL = 1 << 8,  /* simulated, fitted */
    API_CSV_WORD_FRAME = 1 << 9,  /* number of a picture */
    API_CSV_WORD_OTHER = 1 << 10, /* radius, likelihood, energy: nothing that is fitted */
    API_CSV_WORD_PRIME = 1 << 11, /* X' */
    API_CSV_WORD_JOINT = 1 << 12  /* an angle between two arms */
};

/* A name taken apart. */
struct api_csv_words {
    int words;               /* of enum api_csv_word */
    int number;              /* the last digits in it; -1 = none */
    double s, rad, m, rad_s; /* what a unit in it is of each; 0 = it names none of this */
    int pixels;
};

/** Takes a name and a unit apart; either may be empty. O(bytes). */
struct api_csv_words api_csv_words_of(const struct api_csv_cell *name,
                                      const struct api_csv_cell *unit);

/** Whether a cell holds nothing but a unit, such as "deg" or "(s)". O(bytes). */
int api_csv_is_unit(const struct api_csv_cell *cell);
