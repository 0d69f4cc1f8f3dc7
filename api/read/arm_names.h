/* The names of arms while a tree is read: every arm has one, its own or its number; `parent` fields
 * refer to names.
 * Leaves to others: the rest of an arm (tree_json).
 * Invariant: a name belongs to one arm, or a fault was added. */
#pragma once

#include "api/json/json_in.h"

enum { API_ARM_FAULTY = -2 }; /* for a parent that was already reported as a fault */

struct api_arm_names {
    int n;
    const char **text; /* n and a NULL; starts the block of all four; texts of the document */
    int *sorted;       /* arms by name, then by number */
    char *numbers;     /* the names of arms without a name */
    int given;         /* arms with a name of their own */
};

/** Allocates the names of n arms; released by api_arm_names_clear. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_arm_names_init(struct api_arm_names *names, int n);

/** Frees the names. */
void api_arm_names_clear(struct api_arm_names *names);

/** Reads an arm's own name, or uses its number from 1; a name that is not a text is a fault.
 * O(1). */
void api_arm_names_take(struct api_arm_names *names, const struct api_value *arm,
                        struct api_problem *problem);

/**
 * Sorts the names, after all were read, and adds a fault for every arm that has the name of an
 * earlier one.
 *
 * arms  the array of the document. O(n log n).
 */
void api_arm_names_sort(struct api_arm_names *names, const struct api_value *arms,
                        struct api_problem *problem);

/** Returns the number, from 0, of the parent, by its name in the field `parent`; -1 = the pivot,
 * API_ARM_FAULTY after a fault. The names must be sorted. O(log n). */
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
