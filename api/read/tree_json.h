/* Reads a pendulum tree from JSON, in any of its three forms; every error has a pointer into the
 * form that the client used.
 * Leaves to others: checking and building the tree (core/tree/tree), its state (state_json).
 * Invariant: a tree that was read is valid, within the limits, and contains no pointer into the
 * document. */
#pragma once

#include "api/read/field.h"
#include "api/base/limits.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct api_tree {
    int n;    /* number of arms, in the caller's order; 0 = unknown */
    int cart; /* 1 = the pivot is on a cart, which is arm n of the tree and its first stored arm */
    struct pend_loads loads; /* gravity, terms and drives of the tree */
    struct pend_terms
        *terms;    /* terms of a real pendulum, to which `loads` points; NULL = an ideal pendulum */
    double *value; /* values of the terms, terms->count numbers */
    struct pend_rules
        *rules; /* rules of a motion in pieces, to which the terms point; NULL = one piece */
    struct pend_tree *tree; /* NULL if the description is invalid */
    const char **names;     /* n names, or NULL if no arm has one; an arm without a name has its
                             * number as name, from "1" */
};

/**
 * Reads a tree.
 *
 * tree      out; released by api_tree_clear, also after a failure. n and loads are set if known,
 *           even if other fields are invalid, so that the rest of the request can be checked.
 * pendulum  the value in the document; an error is added if it is missing.
 *
 * PEND_INVALID   every error was added to the problem.
 * PEND_NO_MEMORY
 * O(n log n) for arms with names, O(n) for lists, O(n^2) for a path matrix.
 */
PEND_MUST_CHECK enum pend_status api_tree_read(struct api_tree *tree,
                                               const struct api_value *pendulum,
                                               const struct api_limits *limits,
                                               struct api_problem *problem);
void api_tree_clear(struct api_tree *tree);

/** Returns the number of coordinates of a tree, which is the size of its states: its arms and a
 * cart. O(1). */
static inline int api_tree_stored(const struct api_tree *tree) { return tree->n + tree->cart; }

/** Copies a row in stored order to n numbers in the caller's order, without a cart. O(n). */
void api_tree_put(const struct api_tree *tree, const double row[], double out[]);

/** Returns the most bytes of memory of a tree, not counting the text of its names. O(1). */
double api_tree_bytes(const struct api_tree *tree);

/** Returns the caller's number, from 0, of the parent of the caller's arm i; -1 for the pivot and
 * for a cart. O(1). */
int api_tree_parent(const struct api_tree *tree, int i);

/** Returns the name of the caller's arm i; for an arm without one its number from 1 as text, which
 * is written into `scratch`. O(1). */
const char *api_tree_name(const struct api_tree *tree, int i, char scratch[16]);

/**
 * Reads an arm, given by its number from 1 or by its name.
 *
 * Returns the caller's number, from 0; -1 if the value is missing or not an arm, for which an error
 * is added, or if the tree is invalid.
 */
int api_tree_read_arm(const struct api_tree *tree, const struct api_value *value,
                      struct api_problem *problem);

/**
 * Adds an error if the tree has terms beyond those of an ideal pendulum.
 *
 * value  the field that requires an ideal pendulum.
 * what   the purpose, for the message: "a start in a mode".
 */
void api_tree_ideal(const struct api_tree *tree, const struct api_value *value, const char *what,
                    struct api_problem *problem);

/**
 * Adds an error if the modes cannot be used: gravity must be positive, and their computation must
 * not take longer than that of all modes of max-mode-arms arms.
 *
 * value  the field that requests the modes.
 * count  number of modes.
 * what   the purpose, for the message: "a start in a mode".
 */
void api_tree_modes_allowed(const struct api_tree *tree, const struct api_value *value, int count,
                            const char *what, const struct api_limits *limits,
                            struct api_problem *problem);
