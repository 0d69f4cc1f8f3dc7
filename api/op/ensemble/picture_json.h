/* Reads what a picture of an ensemble shows: the observable, the arm and the scale.
 * Leaves to others: drawing it (encode_png).
 * Invariant: a valid picture is a column of the table of a grid with two axes. */
#pragma once

#include "api/op/ensemble/members_fill.h"
#include "api/op/ensemble/observables.h"
#include "api/op/op.h"

/**
 * Reads `picture`, and sets the table's picture if the representation is one. The default is the
 * first observable that can be drawn, of the first arm.
 *
 * seen  its columns are set.
 *
 * Every error is added to the problem.
 */
void api_picture_read(struct api_observables *seen, const struct api_members *members,
                      const struct api_tree *tree, const struct api_reading *reading);
