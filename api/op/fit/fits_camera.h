/* A fit as it was asked for, and its camera.
 * Leaves to others: everything else of a request for one (fits_json).
 * Invariant: what was read holds no pointer into the document. */
#pragma once

#include "api/op/measured_json.h"
#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/fit/fit.h"

enum {
    API_FIT_UNKNOWNS = 261, /* with the camera's */
    API_FIT_LISTED = 60,    /* of them in a request: one of a start may stand for every run's */
    API_FIT_SERIES = 64,
    API_FIT_MODES = 30,
    API_FIT_RUNS = 32,
    API_FIT_LABEL = 64,
    API_FIT_TABLES_BYTES = 1 << 20
};

/* One motion of the pendulum: its start, and what of the measurements is its own. */
struct api_fit_run {
    int guessed;                /* no start was given: it is taken from the data */
    int begins;                 /* when the start is there was given */
    long rows;                  /* of all rows */
    int series;                 /* how many it has, in the request's order */
    int column[API_FIT_SERIES]; /* the column of each */
};

/* A request for a fit. */
struct api_fit {
    struct api_tree tree;
    struct api_states *start;
    double *length, *mass; /* the caller's order */
    unsigned char *bare;
    int *parent;
    int runs;
    struct api_fit_run run[API_FIT_RUNS];
    double begin[API_FIT_RUNS]; /* s, when the start of each is there */
    int *of;                    /* of each row its run */
    long *row;                  /* and its number there, as it was given, from 0 */
    double camera[PEND_FIT_CAMERA];
    double offset[API_FIT_SERIES]; /* what instruments add: the zeros of core/fit */
    long rows;
    double *t, *data; /* rows; series x rows */
    double *each;     /* series x rows: standard deviations of those series that list them */
    int columns, modes, unknowns; /* columns: those of modes too */
    int freed; /* of the unknowns, the last ones, of starts that were taken from the data */
    struct pend_fit_column column[API_FIT_SERIES + API_FIT_MODES]; /* the modes come last */
    double zero[API_FIT_SERIES + API_FIT_MODES]; /* rad, the phi of what was given as 0 */
    struct pend_fit_unknown unknown[API_FIT_UNKNOWNS];
    char label[API_FIT_UNKNOWNS][API_FIT_LABEL]; /* "length of arm 2" */
    double shift[API_FIT_UNKNOWNS]; /* what is added to a value that is told: pi / 2 of a theta */
    int loss;
    double knee[API_FIT_SERIES + API_FIT_MODES];
    double rtol;
    long iterations, step_cap;
    char advice[API_MEASURED_ADVICE]; /* what is probably wrong with the numbers of a table */
    struct api_buffer tables;         /* JSON: what the columns of each table were taken for */
};

/** Returns the number, from 0, of what measures an angle or a rate of an arm, in all runs one
 * instrument; joint: whether it counts from another arm, -1 = either. -1 = none. */
int api_fit_instrument(const struct api_fit *fit, enum pend_fit_kind kind, int arm, int joint);

/**
 * Reads where the camera is, and what of it is to be found; every fault is added.
 *
 * fit  whose instants and `begin` were read; numbers of the camera and unknowns are added to it.
 *
 * O(1).
 */
void api_fit_read_camera(struct api_fit *fit, const struct api_value *camera,
                         struct api_problem *problem);
