/* Reads the format of the numbers of an answer: digits, kind, and the text for a missing number.
 * Leaves to others: writing them (encode).
 * Invariant: the format does not affect the computation. */
#pragma once

#include "api/encode/encode.h"
#include "api/json/json_in.h"

/** Reads `digits`, `number` and `none` of a request into the table of its answer. Every error is
 * added to the problem. */
void api_form_read(struct api_table *table, const struct api_value *root,
                   struct api_problem *problem);
