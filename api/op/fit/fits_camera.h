/* A request for a fit, and reading the camera's part of it and the unknowns.
 * Leaves to others: the other fields of the request (fits_json).
 * Invariant: the parsed fit contains no pointer into the document. */
#pragma once

#include "api/op/measured_json.h"
#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/fit/fit.h"

enum {
    API_FIT_UNKNOWNS = 265, /* maximum number of unknowns, including the camera's */
    API_FIT_LISTED = 60, /* maximum number of unknowns in a request; an unknown of a start may stand
                          * for one in every run */
    API_FIT_SERIES = 64,
    API_FIT_MODES = 30,
    API_FIT_RUNS = 32,
    API_FIT_LABEL = 64,
    API_FIT_TABLES_BYTES = 1 << 20
};

/* One motion of the pendulum: its start, and its own measurements. */
struct api_fit_run {
    int guessed;                /* whether no start was given, so that it is estimated from the
                                 * data */
    int begins;                 /* whether the time of the start was given */
    long rows;                  /* number of rows of the run */
    int series;                 /* number of columns of this run, in the request's order */
    int column[API_FIT_SERIES]; /* index of each column */
};

/* A request for a fit. */
struct api_fit {
    struct api_tree tree;
    struct api_states *start;
    double *length, *mass; /* in the caller's order */
    unsigned char *bare;
    int *parent;
    int runs;
    struct api_fit_run run[API_FIT_RUNS];
    double begin[API_FIT_RUNS]; /* s, the start time of each run */
    int *of;                    /* the run to which each row belongs */
    long *row;                  /* the number of each row within its run, as in the request, from
                                 * 0 */
    double camera[PEND_FIT_CAMERA], center[2], reach; /* center and reach of its lens */
    double offset[2 * API_FIT_SERIES]; /* for each column the instrument's offset, then the shifts
                                        * of clocks: the zeros of core/fit */
    long rows;
    double *t, *data; /* instants of the rows; data of the series, series x rows */
    double *each;     /* standard deviations, series x rows, of the series that list them */
    int columns, modes, unknowns; /* numbers of columns, including those of modes; of modes; of
                                   * unknowns */
    int freed; /* number of unknowns, at the end of the list, that are starts estimated from the
                * data */
    struct pend_fit_column column[API_FIT_SERIES + API_FIT_MODES]; /* columns; those of modes come
                                                                    * last */
    double zero[API_FIT_SERIES + API_FIT_MODES]; /* rad, the phi at which a series is 0 */
    struct pend_fit_unknown unknown[API_FIT_UNKNOWNS];
    char label[API_FIT_UNKNOWNS][API_FIT_LABEL]; /* names for messages: "length of arm 2" */
    double shift[API_FIT_UNKNOWNS];              /* offsets of reported values: pi / 2 for theta */
    int loss;
    double knee[API_FIT_SERIES + API_FIT_MODES];
    double rtol;
    long iterations, step_cap;
    char advice[API_MEASURED_ADVICE]; /* likely mistakes in the numbers of a table */
    struct api_buffer tables;         /* JSON: the role of each column of every table */
};

/** Returns the index, from 0, of the instrument that measures an angle, rate or acceleration of an
 * arm; -1 = none. All runs share the instruments. joint: whether it measures relative to the parent
 * arm; -1 = either. */
int api_fit_instrument(const struct api_fit *fit, enum pend_fit_kind kind, int arm, int joint);

/** Writes the label of an unknown: its name, then "of arm 2" or "of the cart", then "in run 1" if
 * there are several runs. arm: stored number, -1 = none; run: from 0, -1 = none. O(1). */
void api_fit_label(const struct api_fit *fit, const char *name, int arm, int run,
                   char label[API_FIT_LABEL]);

/** Returns the label of a number of the camera, "scale of the camera". O(1). */
const char *api_fit_camera_label(enum pend_fit_camera what);

/** Reads the unknowns of a fit whose pendulum, start and instants are read, from an array of
 * objects or a missing value. Every error is added. O(unknowns harmonics). */
void api_fit_read_unknowns(struct api_fit *fit, const struct api_value *list,
                           struct api_problem *problem);

/**
 * Reads the position of the camera, and which of its numbers are unknowns. Every error is added.
 *
 * fit  its instants and `begin` must be read; receives the camera and its unknowns.
 *
 * O(1).
 */
void api_fit_read_camera(struct api_fit *fit, const struct api_value *camera,
                         struct api_problem *problem);
