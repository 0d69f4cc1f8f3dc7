/* Reading how the numbers of an answer are written: their digits, their kind, and what stands for
 * a number that there is none of.
 * Leaves to others: writing them (encode).
 * Invariant: nothing is computed otherwise because of it. */
#ifndef API_FORM_JSON_H
#define API_FORM_JSON_H

#include "api/encode/encode.h"
#include "api/json/json_in.h"

/** Reads `digits`, `number` and `none` of a request into the table of its answer. Every fault is
 * added to the problem. */
void api_form_read(struct api_table *table, const struct api_value *root,
                   struct api_problem *problem);

#endif
