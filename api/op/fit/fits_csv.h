/* Measurements of a run as a table of text.
 * Leaves to others: reading the table (api/csv), the rest of a fit (fits_data).
 * Invariant: a fault names the line, from 1. */
#ifndef API_FITS_CSV_H
#define API_FITS_CSV_H

#include "api/op/fit/fits_part.h"

/**
 * Reads `csv`, `sigma`, `unit`, `arms` and `columns` of `data`.
 *
 * part  out: every series of the table that a fit can use; a row that is there twice in a row
 *       counts once; the errors that the table lists, where `sigma` says none.
 * tree  what the request says of the pendulum; without arms nothing is read.
 *
 * PEND_INVALID    every fault was added to the problem.
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_fit_csv_read(struct api_fit_part *part,
                                                  const struct api_tree *tree,
                                                  const struct api_value *data,
                                                  const struct api_reading *reading);

#endif
