/* A fit as it was asked for, and its camera.
 * Leaves to others: everything else of a request for one (fits_json).
 * Invariant: what was read holds no pointer into the document. */
#ifndef API_FITS_CAMERA_H
#define API_FITS_CAMERA_H

#include "api/op/op.h"
#include "api/read/state_json.h"
#include "core/fit/fit.h"

enum { API_FIT_UNKNOWNS = 65, API_FIT_SERIES = 64, API_FIT_MODES = 30, API_FIT_LABEL = 48 };

/* A request for a fit. */
struct api_fit {
    struct api_tree tree;
    struct api_states *start;
    int guessed;           /* no start was given: it is taken from the data */
    double *length, *mass; /* the caller's order */
    unsigned char *bare;
    int *parent;
    double begin; /* s, when the start is there */
    int begins;   /* it was given */
    double camera[PEND_FIT_CAMERA];
    long rows;
    double *t, *data; /* rows; series x rows */
    double *each;     /* series x rows: standard deviations of those series that list them */
    int columns, unknowns;
    struct pend_fit_column column[API_FIT_SERIES + API_FIT_MODES]; /* the modes come last */
    struct pend_fit_unknown unknown[API_FIT_UNKNOWNS];
    char label[API_FIT_UNKNOWNS][API_FIT_LABEL]; /* "length of arm 2" */
    double shift[API_FIT_UNKNOWNS]; /* what is added to a value that is told: pi / 2 of a theta */
    double rtol;
    long iterations, step_cap;
};

/**
 * Reads where the camera is, and what of it is to be found; every fault is added.
 *
 * fit  whose instants and `begin` were read; numbers of the camera and unknowns are added to it.
 *
 * O(1).
 */
void api_fit_read_camera(struct api_fit *fit, const struct api_value *camera,
                         struct api_problem *problem);

#endif
