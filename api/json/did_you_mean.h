/* "Did you mean": finds the intended name of an unknown one by synonyms, by the object that it
 * belongs in, or by edit distance.
 * Leaves to others: the message (json_in, read/field).
 * Invariant: the result is an allowed name; a suggestion never makes a request acceptable. */
#pragma once

/* maximum number of fields in api_name_place */
enum { API_NAME_PLACES = 40 };

/**
 * Finds the allowed name that `name` was probably meant to be.
 *
 * allowed  names, ended by NULL.
 * Returns the nearest name, at most two edits away (a letter inserted, dropped, replaced, or
 * swapped with its neighbour), or NULL. Names of more than 64 bytes never match. O(names x
 * length^2).
 */
const char *api_name_nearest(const char *name, const char *const allowed[]);

/** As api_name_nearest, but tries synonyms of other programs first: "dt" is "step", "ode45" is
 * "rkf45". Case is ignored. Cost as api_name_nearest. */
const char *api_did_you_mean(const char *name, const char *const allowed[]);

/**
 * Finds the object in which `name` belongs: "L" in "pendulum", "theta" in "initial".
 *
 * allowed  the siblings of `name`, ended by NULL.
 * Returns one of the allowed names, or NULL. O(names).
 */
const char *api_name_place(const char *name, const char *const allowed[]);

/** Returns true for a field of a request or of its initial state, false for a field of the
 * pendulum. */
int api_name_outer(const char *name);

/** Returns the header field that should be used instead of `name`, such as "Accept: text/csv" for
 * "csv", or NULL. */
const char *api_name_head(const char *name);
