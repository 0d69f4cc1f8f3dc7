/* The names of arms while a tree is read: every arm has one, its own or its number, and others
 * name the arm that carries them.
 * Leaves to others: the rest of an arm (tree_json).
 * Invariant: a name belongs to one arm, or a fault was added. */
#ifndef API_ARM_NAMES_H
#define API_ARM_NAMES_H

#include "api/json/json_in.h"

enum { API_ARM_FAULTY = -2 }; /* stands for a parent that was faulted already */

struct api_arm_names {
    int n;
    const char **text; /* n and a NULL; begins the block of all four; texts of the document */
    int *sorted;       /* arms by name, then by number */
    char *numbers;     /* the names of those that were given none */
    int given;         /* arms with a name of their own */
};

/** Makes room for the names of n arms; ends with api_arm_names_clear. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_arm_names_init(struct api_arm_names *names, int n);

/** Frees the names. */
void api_arm_names_clear(struct api_arm_names *names);

/** Takes an arm's own name, or its number from 1; a name that is no text is a fault. O(1). */
void api_arm_names_take(struct api_arm_names *names, const struct api_value *arm,
                        struct api_problem *problem);

/**
 * Sorts the names, all of which were taken, and adds a fault for every arm that has the name of an
 * earlier one.
 *
 * arms  the array of the document. O(n log n).
 */
void api_arm_names_sort(struct api_arm_names *names, const struct api_value *arms,
                        struct api_problem *problem);

/**
 * Returns the number, from 0, of the arm that carries this one, by its name in the field `parent`;
 * -1 = the pivot, API_ARM_FAULTY after a fault. The names are sorted. O(log n).
 */
int api_arm_names_parent(const struct api_arm_names *names, const struct api_value *arm,
                         struct api_problem *problem);

/**
 * Copies the names into one block that outlives the document.
 *
 * kept  out, n names, to be freed by free(); left as it is if no arm has a name of its own.
 *
 * PEND_NO_MEMORY  O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_arm_names_keep(const struct api_arm_names *names,
                                                    const char ***kept);

#endif
