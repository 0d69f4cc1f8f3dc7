/* Kinds of field that many requests share: numbers, lists of numbers, whole numbers, words of a
 * list.
 * Leaves to others: what the fields mean (tree_json, state_json, times_json, method_json, op_*).
 * Invariant: a fault says what was expected and what was found; every fault of a field is added,
 * not only the first. */
#ifndef API_FIELD_H
#define API_FIELD_H

#include "api/json/json_in.h"

/**
 * Faults a value that is missing or is not an object. Returns true for an object.
 */
int api_field_object(const struct api_value *value, struct api_problem *problem);

/**
 * Faults a field that is missing. Returns true where it is there.
 */
int api_field_needed(const struct api_value *value, struct api_problem *problem);

/**
 * Reads a list of numbers.
 *
 * n        how many there must be; 0 = not known, any number.
 * each     what they belong to: "arm".
 * out      n numbers, NAN for every item that is faulty or lacking; NULL = only check.
 *
 * Returns 1 when all are good, 0 when the field is missing (out is left alone), -1 when faults were
 * added.
 */
int api_field_numbers(const struct api_value *value, int n, const char *each, double out[],
                      struct api_problem *problem);

/**
 * Reads a whole number from least to greatest. Returns 1 when good, 0 when missing, -1 when faulty;
 * out is left alone unless good.
 */
int api_field_whole(const struct api_value *value, long least, long greatest, long *out,
                    struct api_problem *problem);

/** Reads true or false. Returns 1 when good, 0 when missing, -1 when faulty; out is left alone
 * unless good. */
int api_field_truth(const struct api_value *value, int *out, struct api_problem *problem);

/**
 * Reads one word of a list.
 *
 * words  ended by NULL.
 * out    its number in the list, left alone unless good.
 *
 * Returns 1 when good, 0 when missing, -1 when faulty.
 */
int api_field_word(const struct api_value *value, const char *const words[], int *out,
                   struct api_problem *problem);

#endif
