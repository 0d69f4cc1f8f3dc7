/* Counted frequencies of modes as measurements of a fit.
 * Leaves to others: everything else of a request for one (fits_json).
 * Invariant: a frequency becomes an angular one, its standard deviation with it. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads the modes into the last columns of the fit, a column each, with the number in row 0.
 *
 * list   an array of as many modes as there are columns from `first` on.
 *
 * Every fault is added. O(modes).
 */
void api_fit_read_modes(struct api_fit *fit, const struct api_value *list, int first,
                        struct api_problem *problem);
