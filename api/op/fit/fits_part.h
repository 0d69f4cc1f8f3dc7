/* One run of a request for a fit: its instants, and its series, table or counted modes.
 * Leaves to others: several runs (fits_data), the meaning of a table's columns (op/measured_json).
 * Invariant: no pointer into the document is kept; missing measurements are NaN. */
#pragma once

#include "api/op/fit/fits_camera.h"

struct api_fit_part {
    long rows;
    int columns;
    double *t, *data, *each;
    double *taken;             /* bytes of all runs read so far, one sum for all runs */
    char *advice;              /* likely mistakes in the tables of all runs, or "" */
    struct api_buffer *tables; /* JSON: the roles of the columns of all runs' tables */
    struct pend_fit_column column[API_FIT_SERIES];
    double zero[API_FIT_SERIES]; /* rad, the phi at which a series is 0 */
};

/** Adds an error if a run of this size, with the runs before it, exceeds max-answer-bytes. Returns
 * 0 then. O(1). */
int api_fit_part_fits(double rows, double columns, double *taken, const struct api_value *data,
                      const struct api_reading *reading);

/** Allocates a run, whose measurements are missing at first. PEND_INVALID with an error,
 * PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_fit_part_room(struct api_fit_part *part, long rows,
                                                   int columns, const struct api_value *data,
                                                   const struct api_reading *reading);

/** Reads `t` and `series`, or `csv`, of a run. PEND_INVALID with errors, PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_fit_part_read(struct api_fit_part *part,
                                                   const struct api_tree *tree,
                                                   const struct api_value *data,
                                                   const struct api_reading *reading);

/** Reads an array of measured mode frequencies into the columns from `first` on, row 0.
 * O(modes). */
void api_fit_read_modes(struct api_fit *fit, const struct api_value *list, int first,
                        struct api_problem *problem);
