/* The unknowns of a fit: numbers of the pendulum and of its start, with bounds.
 * Leaves to others: the camera's unknowns (fits_camera), the other fields (fits_json).
 * Invariant: each unknown has an index in the parsed pendulum or start. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads the unknowns; every fault is added.
 *
 * fit   with its pendulum, start and instants already read.
 * list  an array of objects, or missing.
 *
 * O(unknowns harmonics).
 */
void api_fit_read_unknowns(struct api_fit *fit, const struct api_value *list,
                           struct api_problem *problem);
