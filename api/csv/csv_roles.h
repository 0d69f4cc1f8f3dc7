/* What the columns of a measured table are of a pendulum, by their names, units and numbers.
 * Leaves to others: the layout (csv_layout), what a fit does with it (op/fit).
 * Invariant: no column is taken for two things, no two columns for the same; what was not certain
 * is said. */
#pragma once

#include "api/csv/csv_layout.h"

enum api_csv_role {
    API_CSV_NONE,  /* not used; `why` says for what reason */
    API_CSV_TIME,  /* s */
    API_CSV_THETA, /* rad from hanging */
    API_CSV_PHI,   /* rad from the positive real axis */
    API_CSV_JOINT, /* rad from the arm that it hangs on */
    API_CSV_X,
    API_CSV_Y,
    API_CSV_RATE, /* rad/s; of an arm of which nothing else is measured, or as given */
    API_CSV_SIGMA /* the standard error of column `of` */
};

struct api_csv_taken {
    enum api_csv_role role;
    int arm;         /* from 1; 0 of what has none */
    int of;          /* of a standard error its column, of a column that of its errors; or -1 */
    double unit;     /* s, rad, rad/s or m that one of the table's is; 0 = unknown (pixels) */
    int sure;        /* named, or not to be taken for anything else */
    const char *why; /* a sentence without its end, static; NULL where there is nothing to say */
};

struct api_csv_roles {
    struct api_csv_taken column[API_CSV_COLUMNS];
    int time;      /* the column; -1 = none was found */
    double origin; /* s; the instants are counted from here: 0, or the first of a clock */
    int measured;  /* columns of angles, places and rates */
    int second;    /* a second table stands beside the first */
};

/* What is known of a table beside its text. */
struct api_csv_hints {
    int arms;          /* of the pendulum; 0 = as many as the table names */
    int degrees;       /* angles without a unit are in degrees; -1 = by their size */
    int count;         /* the i-th x and y without a number are of arm listed[i], from 1 */
    const int *listed; /* `count`; 0 = none */
    int gives;         /* the first columns whose names are given instead of the table's */
    const struct api_csv_cell *given; /* `gives`; at NULL = not given, bytes 0 = not used */
};

/** Finds out. What is given goes before what is guessed. O(columns^2). */
void api_csv_guess(struct api_csv_roles *roles, const struct api_csv *csv,
                   const struct api_csv_hints *hints);

/** Whether a role is an angle. */
int api_csv_is_angle(enum api_csv_role role);

/** The word for a role: "t", "theta", "phi", "joint", "x", "y", "thetad", "sigma", or "". */
const char *api_csv_role_name(enum api_csv_role role);
