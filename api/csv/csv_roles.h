/* The role of each column of a measured table, guessed from names, units and numbers.
 * Leaves to others: the layout (csv_layout), the fit that uses the columns (op/fit).
 * Invariant: a column has one role, and no two columns hold the same quantity; doubts are noted. */
#pragma once

#include "api/csv/csv_layout.h"

enum api_csv_role {
    API_CSV_NONE,  /* not used; `why` is the reason */
    API_CSV_TIME,  /* s */
    API_CSV_THETA, /* rad, from the vertical */
    API_CSV_PHI,   /* rad from the positive real axis */
    API_CSV_JOINT, /* rad from the direction of the parent arm */
    API_CSV_X,
    API_CSV_Y,
    API_CSV_RATE,      /* rad/s; used if the arm has no other measurement or the request names it */
    API_CSV_AMPLITUDE, /* rad, and s for the period; used like a rate */
    API_CSV_PERIOD,
    API_CSV_ALONG, /* m/s^2, accelerations along the arm and across it */
    API_CSV_ACROSS,
    API_CSV_CART, /* m, position on the rail; its arm is 1 */
    API_CSV_SIGMA /* the standard error of column `of` */
};

struct api_csv_taken {
    enum api_csv_role role;
    int arm;     /* number of the arm, from 1; 0 if the role has no arm */
    int of;      /* a standard error: index of its measured column; a measured column: index of its
                  * standard error; -1 = none */
    double unit; /* factor from the table's unit to s, rad, rad/s or m; 0 = unknown (pixels) */
    int sure;    /* true if the role is certain, or named by the table or the request */
    const char *why; /* a static sentence without a full stop; NULL = no remark */
};

struct api_csv_roles {
    struct api_csv_taken column[API_CSV_COLUMNS];
    int time;      /* index of the column of times; -1 = none was found */
    double origin; /* s, subtracted from all times: 0, or the first reading of a clock */
    int measured;  /* number of columns with angles, positions or rates */
    int second;    /* whether the file has a second table to the right of the first */
};

/* Facts that the table does not contain. */
struct api_csv_hints {
    int arms;          /* number of arms of the pendulum; 0 = as many as the table names */
    int cart;          /* whether the pendulum is on a cart */
    int degrees;       /* whether angles without unit are in degrees; -1 = guess by range */
    int count;         /* the i-th x and y without a number belong to arm listed[i], from 1 */
    const int *listed; /* `count` numbers of arms; NULL = none */
    int gives;         /* number of leading columns that the request may name */
    const struct api_csv_cell *given; /* `gives` names; text NULL = not given, 0 bytes = not used */
};

/** Assigns the roles. The request's names override guesses. O(columns^2). */
void api_csv_guess(struct api_csv_roles *roles, const struct api_csv *csv,
                   const struct api_csv_hints *hints);

/** Returns whether a role is an angle. */
int api_csv_is_angle(enum api_csv_role role);

/** Returns the word for a role: "t", "theta", "phi", "joint", "x", "y", "thetad", "sigma", or "".
 */
const char *api_csv_role_name(enum api_csv_role role);
