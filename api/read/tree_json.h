/* A pendulum tree out of JSON, in any of its three forms, with every fault at the pointer of the
 * form that was used.
 * Leaves to others: what makes a tree (core/tree/tree), the state it starts in (state_json).
 * Invariant: a tree that was read is valid and within the limits; nothing of the document is
 * kept. */
#ifndef API_TREE_JSON_H
#define API_TREE_JSON_H

#include "api/read/field.h"
#include "api/base/limits.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct api_tree {
    int n;                   /* arms, in the caller's order; 0 where that could not be told */
    struct pend_loads loads; /* what acts on the tree */
    struct pend_tree *tree;  /* NULL where the description is faulty */
    const char **names; /* n names, or NULL where no arm was given one; an arm without a name is
                           called by its     number, "1" the first */
};

/**
 * Reads a tree.
 *
 * tree      out; to be cleared with api_tree_clear whatever is returned. n and gravity are filled
 *           in as far as they are known even when the rest is faulty, so that the rest of the
 *           request can be checked against them.
 * pendulum  the value in the document; may be missing, which is a fault.
 *
 * PEND_INVALID   every fault was added to the problem.
 * PEND_NO_MEMORY O(n log n) for arms with names, O(n) for lists, O(n^2) for a path matrix.
 */
PEND_MUST_CHECK enum pend_status api_tree_read(struct api_tree *tree,
                                               const struct api_value *pendulum,
                                               const struct api_limits *limits,
                                               struct api_problem *problem);

void api_tree_clear(struct api_tree *tree);

/** Bytes of memory that a tree takes at most, without the letters of its names. O(1). */
double api_tree_bytes(const struct api_tree *tree);

/** The caller's number, from 0, of the arm that carries the caller's arm i; -1 for the pivot.
 * O(1). */
int api_tree_parent(const struct api_tree *tree, int i);

/** The name of the caller's arm i, or its number from 1 as text, printed into the scratch given.
 * O(1). */
const char *api_tree_name(const struct api_tree *tree, int i, char scratch[16]);

/**
 * Reads which arm is meant, by its number from 1 or by its name.
 *
 * Returns the caller's number, from 0; -1 where it is missing, which is a fault, is none, or the
 * tree is faulty.
 */
int api_tree_read_arm(const struct api_tree *tree, const struct api_value *value,
                      struct api_problem *problem);

/**
 * Faults a use of the modes that the tree or the limits forbid: gravity must be positive, the modes
 * not too many for so many arms. As many are allowed as take the time of all modes of max-mode-arms
 * arms.
 *
 * value  what asks for the modes; what says so in the message: "a start in a mode".
 * count  how many modes.
 */
void api_tree_modes_allowed(const struct api_tree *tree, const struct api_value *value, int count,
                            const char *what, const struct api_limits *limits,
                            struct api_problem *problem);

#endif
