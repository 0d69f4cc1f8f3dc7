/* Reading a fit from JSON: measurements, the camera, what is to be found.
 * Leaves to others: the fit (core/fit), its answer (op_fits), tables of text (fits_csv).
 * Invariant: what was read holds no pointer into the document. */
#ifndef API_FITS_JSON_H
#define API_FITS_JSON_H

#include "api/op/op.h"
#include "api/op/varied.h"
#include "api/read/state_json.h"
#include "core/fit/fit.h"

enum { API_FIT_UNKNOWNS = 64, API_FIT_SERIES = 64, API_FIT_LABEL = 48 };

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
    struct pend_fit_column column[API_FIT_SERIES];
    struct pend_fit_unknown unknown[API_FIT_UNKNOWNS];
    char label[API_FIT_UNKNOWNS][API_FIT_LABEL]; /* "length of arm 2" */
    double shift[API_FIT_UNKNOWNS]; /* what is added to a value that is told: pi / 2 of a theta */
    double rtol;
    long iterations, step_cap;
};

/**
 * Reads a fit.
 *
 * fit  out; must be cleared by api_fit_clear whatever is returned.
 *
 * PEND_INVALID    every fault was added to the problem.
 * PEND_NO_MEMORY  O(measurements).
 */
PEND_MUST_CHECK enum pend_status api_fit_read(struct api_fit *fit,
                                              const struct api_reading *reading);

/** Frees all of it. */
void api_fit_clear(struct api_fit *fit);

/** The problem, once the start is settled; it points into `fit`. */
struct pend_fit_problem api_fit_problem(const struct api_fit *fit);

/** Takes the start from the data where none was given: an arm whose angle is measured begins at its
 * first measurements, at their pace. */
void api_fit_guess(struct api_fit *fit);

/** Puts the values of the unknowns into the pendulum, its start and its camera. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_fit_put(struct api_fit *fit, const double value[]);

#endif
