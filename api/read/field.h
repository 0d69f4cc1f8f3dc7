/* Reads the kinds of field that many requests share: lists of numbers, whole numbers, words of a
 * list.
 * Leaves to others: the meaning of the fields (tree_json, state_json, times_json, method_json,
 * op_*).
 * Invariant: an error says what was expected and what was found; every error of a field is added,
 * not only the first. */
#pragma once

#include "api/json/json_in.h"

/* The units of angles, "rad" and "deg", for api_field_word. */
extern const char *const api_field_angles[];

/** Adds an error if a value is missing or is not an object, and for every member that `fields` does
 * not list; fields: ended by NULL; NULL = any member. Returns true for an object. */
int api_field_object(const struct api_value *value, const char *const fields[],
                     struct api_problem *problem);

/** Adds an error if a field is missing, unless another field is a misspelling of it. Returns true
 * if it is present. */
int api_field_needed(const struct api_value *value, struct api_problem *problem);

/**
 * Returns a member whose name has changed, under its new name or its deprecated one; missing under
 * the new name if neither is given. Both together are a fault. O(members).
 */
struct api_value api_field_renamed(const struct api_value *object, const char *name,
                                   const char *deprecated, struct api_problem *problem);

/**
 * Reads a list of numbers. A single number need not be in a list, because some encoders of arrays
 * write it that way.
 *
 * n        required number of numbers; 0 = any.
 * each     the owner of a number, for the message: "arm".
 * out      n numbers, NAN for every item that is invalid or missing; NULL = only check.
 *
 * Returns 1 if all are valid, 0 if the field is missing (out is unchanged), -1 if errors were
 * added.
 */
int api_field_numbers(const struct api_value *value, int n, const char *each, double out[],
                      struct api_problem *problem);

/** Reads a whole number from least to greatest. Returns 1 if it is valid, 0 if it is missing, -1 if
 * it is invalid; `out` changes only if it is valid. */
int api_field_whole(const struct api_value *value, long least, long greatest, long *out,
                    struct api_problem *problem);

/** Reads true or false. Returns 1 if it is valid, 0 if it is missing, -1 if it is invalid; `out`
 * changes only if it is valid. */
int api_field_truth(const struct api_value *value, int *out, struct api_problem *problem);

/**
 * Reads one word of a list.
 *
 * words  ended by NULL.
 * out    index of the word in the list; changes only if it is valid.
 *
 * Returns 1 if it is valid, 0 if it is missing, -1 if it is invalid.
 */
int api_field_word(const struct api_value *value, const char *const words[], int *out,
                   struct api_problem *problem);

/**
 * Reads a list of words, each at most once.
 *
 * words  at most 32, ended by NULL.
 *
 * Returns bit i for word i; 0 if the list is missing or invalid.
 */
unsigned api_field_words(const struct api_value *list, const char *const words[],
                         struct api_problem *problem);
