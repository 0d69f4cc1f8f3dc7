/* Which name was meant by one that is not known: by other words for it, by the object that it
 * belongs in, or by letters.
 * Leaves to others: telling it (json_in, read/field).
 * Invariant: a name that is found is one of those allowed; what is told is never accepted. */
#ifndef API_NAME_MEANT_H
#define API_NAME_MEANT_H

/* the most names that api_name_place knows */
enum { API_NAME_PLACES = 40 };

/**
 * Finds the allowed name that `name` was probably meant to be.
 *
 * allowed  names, ended by NULL.
 * Returns the nearest one, at most two edits away (a letter inserted, dropped, replaced, or swapped
 * with its neighbour), or NULL. O(names x length^2); names of more than 64 bytes are never near.
 */
const char *api_name_nearest(const char *name, const char *const allowed[]);

/**
 * The same, and before letters are compared, by the words that other programs have for it: "dt" is
 * "step", "ode45" is "rkf45". Upper case counts as lower. Cost as api_name_nearest.
 */
const char *api_name_meant(const char *name, const char *const allowed[]);

/**
 * Finds the field whose object `name` belongs in: "L" in "pendulum", "theta" in "initial".
 *
 * allowed  fields that stand beside `name`, ended by NULL.
 * Returns one of the allowed names, or NULL. O(names).
 */
const char *api_name_place(const char *name, const char *const allowed[]);

/** True for a field of a request, or of its state, which stands beside the pendulum and not in it.
 */
int api_name_outer(const char *name);

/** The field of a request's head that says what `name` is a word for, as "Accept: text/csv"; NULL
 * for others. */
const char *api_name_head(const char *name);

#endif
