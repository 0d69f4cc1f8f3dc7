/* The names of arms while a tree is read: each arm has its own name or its number as a name, and
 * `parent` fields refer to names.
 * Leaves to others: the rest of an arm (tree_json).
 * Invariant: a name belongs to one arm, or an error was added. */
#pragma once

#include "api/json/json_in.h"

enum { API_ARM_FAULTY = -2 }; /* stands for a parent that was already reported as an error */

struct api_arm_names {
    int n;
    const char **text; /* n names, then NULL; the start of a block with all four arrays; texts of
                        * the document */
    int *sorted;       /* arms sorted by name, then by number */
    char *numbers;     /* the names of arms without a name */
    int given;         /* number of arms with a name of their own */
};

/** Allocates the names of n arms; released by api_arm_names_clear. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_arm_names_init(struct api_arm_names *names, int n);
void api_arm_names_clear(struct api_arm_names *names);

/** Reads an arm's own name, or uses its number from 1; a name that is not a text is an error.
 * O(1). */
void api_arm_names_take(struct api_arm_names *names, const struct api_value *arm,
                        struct api_problem *problem);

/**
 * Sorts the names, after all were read, and adds an error for every arm with the name of an earlier
 * one.
 *
 * arms  the array in the document. O(n log n).
 */
void api_arm_names_sort(struct api_arm_names *names, const struct api_value *arms,
                        struct api_problem *problem);

/** Returns the number, from 0, of the parent by its name in the field `parent`; -1 = the pivot,
 * API_ARM_FAULTY after an error. The names must be sorted. O(log n). */
int api_arm_names_parent(const struct api_arm_names *names, const struct api_value *arm,
                         struct api_problem *problem);

/**
 * Copies the names into one block that outlives the document.
 *
 * kept  out, n names, to be freed by free(); unchanged if no arm has a name of its own.
 *
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_arm_names_keep(const struct api_arm_names *names,
                                                    const char ***kept);
