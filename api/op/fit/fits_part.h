/* The measurements of one run as they are read, before those of all runs are put together.
 * Leaves to others: reading them (fits_csv, fits_data).
 * Invariant: what was not measured is NaN. */
#ifndef API_FITS_PART_H
#define API_FITS_PART_H

#include "api/op/fit/fits_camera.h"

/* One run as it was read. */
struct api_fit_part {
    long rows;
    int columns;
    double *t, *data, *each;
    double *taken;             /* bytes of all runs together */
    char *advice;              /* of all runs: what is probably wrong with a table, or "" */
    struct api_buffer *tables; /* JSON of all runs: what the columns of their tables are */
    struct pend_fit_column column[API_FIT_SERIES];
    double zero[API_FIT_SERIES]; /* rad, of an angle that was given as 0 */
};

/**
 * True if so many rows of so many columns fit into the limit max-answer-bytes beside what is taken;
 * else a fault is added.
 */
int api_fit_part_fits(double rows, double columns, double *taken, const struct api_value *data,
                      const struct api_reading *reading);

/**
 * Makes room for `columns` series of `rows` measurements.
 *
 * PEND_INVALID    they are beyond the limit, which was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_fit_part_room(struct api_fit_part *part, long rows,
                                                   int columns, const struct api_value *data,
                                                   const struct api_reading *reading);

#endif
