/* What a fit is to find: numbers of the pendulum and of its start, with bounds.
 * Leaves to others: the camera's (fits_camera), everything else of a request for one (fits_json).
 * Invariant: a number that was taken stands in the pendulum that was read. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads the unknowns; every fault is added.
 *
 * fit   whose pendulum, start and instants were read.
 * list  an array of objects, or missing.
 *
 * O(unknowns harmonics).
 */
void api_fit_read_unknowns(struct api_fit *fit, const struct api_value *list,
                           struct api_problem *problem);
