/* The immutable pendulum tree: arms stored parent before child in depth-first order, and the
 * paper's S, B and S^T m.
 * Leaves to others: angles and motion (dynamics), names and JSON (api).
 * Invariant: parent[k] < k, parent[0] = -1, and the sub-tree of arm k is the range k ..
 * end[k]-1. */
#pragma once

#include <stddef.h>

#include "core/base/status.h"

/* The position of an arm among its siblings, in stored order, and its number of children. */
enum pend_kin {
    PEND_KIN_LEAF = 1,  /* the arm carries no other arm */
    PEND_KIN_FIRST = 2, /* the arm follows its parent immediately */
    PEND_KIN_LAST = 4,  /* the arm's sub-tree ends where its parent's ends */
    PEND_KIN_FORK = 8   /* the arm carries two or more arms */
};

/* Stored arm k is the caller's arm order[k]; place is the inverse. All arrays have n entries and
 * belong to the tree. */
struct pend_tree {
    int n;
    const double *len;          /* m */
    const double *mass;         /* kg, at the tip; 0 only if terms give the arm an inertia */
    const double *subtree_mass; /* kg, S^T m: the mass of the arm's sub-tree, its own included */
    const int *parent; /* stored number of the arm whose tip carries this one, -1 = the pivot */
    const int *end;    /* 1 + the last stored arm of the sub-tree */
    const int *depth;  /* number of arms from the pivot to this arm, itself included */
    const int *order;
    const int *place;
    const unsigned char *kin; /* flags of enum pend_kin; the root is first and last */
    double length_total;      /* m, l_tot: the sum of all lengths */
};

/**
 * Checks and stores a tree.
 *
 * tree    out; NULL on failure.
 * n       number of arms, >= 1.
 * length  n lengths, m, finite and > 0, in the caller's order.
 * mass    n masses, kg, finite and > 0.
 * parent  n numbers from 0, -1 = the pivot; exactly one arm at the pivot, no cycle; any order.
 * faults  receives every fault found, not only the first; may be NULL.
 *
 * PEND_INVALID    some fault was reported.
 * PEND_NO_MEMORY
 * O(n), one allocation. The sibling with the largest sub-tree (most arms) is stored last, so that
 * a sweep keeps the values of about log2 n arms at a time; equal siblings stay in the caller's
 * order.
 */
PEND_MUST_CHECK enum pend_status pend_tree_new(struct pend_tree **tree, int n,
                                               const double length[], const double mass[],
                                               const int parent[],
                                               const struct pend_fault_sink *faults);
void pend_tree_free(struct pend_tree **tree);
int pend_tree_valid(const struct pend_tree *tree);

/**
 * As pend_tree_new, for a tree in which arms may have no mass at their tips, because terms give
 * them a rod or a body.
 *
 * bare  n flags in the caller's order: non-zero if a mass of 0 is allowed; NULL = never.
 */
PEND_MUST_CHECK enum pend_status pend_tree_new_bare(struct pend_tree **tree, int n,
                                                    const double length[], const double mass[],
                                                    const unsigned char bare[], const int parent[],
                                                    const struct pend_fault_sink *faults);

/**
 * Finds the parents from a path matrix S (row k = the arms on the path from the pivot to tip k).
 *
 * n       number of arms, >= 1.
 * path    n x n entries, row-major, each must be exactly 0 or 1.
 * parent  out, n numbers from 0, -1 = the pivot.
 * faults  receives every fault with its row i and column j (PEND_FIELD_PATH); may be NULL.
 *
 * PEND_INVALID    path is not the path matrix of a tree with one arm at the pivot.
 * PEND_NO_MEMORY  O(n).
 * O(n^2).
 */
PEND_MUST_CHECK enum pend_status pend_tree_parent_from_path(int n, const double path[],
                                                            int parent[],
                                                            const struct pend_fault_sink *faults);

/**
 * Fills in the path (connectivity) matrix S of the paper, in the caller's order:
 * z = S [l e^{i phi}].
 *
 * path  out, n x n row-major, entries 0 and 1.
 * O(n^2).
 */
void pend_tree_path(const struct pend_tree *tree, double path[]);

/**
 * Fills in B = S^{-T}, which maps arm forces to forces on tips, in the caller's order: 1 on the
 * diagonal, -1 at (parent of k, k).
 *
 * force_map  out, n x n row-major.
 * O(n^2).
 */
void pend_tree_force_map(const struct pend_tree *tree, double force_map[]);
