/* The linearization in tip displacements, diag(m) x'' + L x = 0: a weighted tree whose root is
 * connected to the pivot.
 * Leaves to others: eigenvalues and vectors (modes_values, modes_vectors), merged branches
 * (modes_symmetry).
 * Invariant: L is never assembled; parent[k] < k, and the sibling with the largest sub-tree comes
 * last. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Properties of a node in a sweep from the leaves to the root: it has no children; it has a later
 * sibling. */
enum { PEND_TURN_LEAF = 1, PEND_TURN_NEXT = 2 };

/* The largest depth of a sweep's stack: an entry's sub-tree has at most half the arms of the
 * sub-tree of the entry below it. */
enum { PEND_LAPLACIAN_STACK = 34 };

/* All arrays have n entries and lie in one block. L = S^-T diag(spring) S^-1. */
struct pend_laplacian {
    int n;
    double *spring;      /* N/m: g (S^T m) / l; negative for an upright arm */
    double *mass;        /* kg */
    double *len;         /* m */
    int *parent, *end;   /* as in the tree */
    unsigned char *turn; /* PEND_TURN_ bits */
    double least, most;  /* 1/s^2: every eigenvalue has least <= |lambda| <= most */
    int depth;           /* number of arms on the longest path from the pivot */
};

/**
 * Allocates n nodes. The caller fills spring, mass, len, parent and end, then calls
 * pend_laplacian_close.
 *
 * laplacian  out; NULL on failure; released by pend_laplacian_free.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_laplacian_alloc(struct pend_laplacian **laplacian, int n);

/** Sets turn, least, most and depth from the other arrays. O(n). */
void pend_laplacian_close(struct pend_laplacian *laplacian);
void pend_laplacian_free(struct pend_laplacian **laplacian);
int pend_laplacian_valid(const struct pend_laplacian *laplacian);

/**
 * Returns the spring of an arm about an equilibrium.
 *
 * k   stored number of the arm.
 * up  n flags in stored order, non-zero for upright arms; NULL if all hang.
 */
double pend_laplacian_spring(const struct pend_tree *tree, const struct pend_loads *loads,
                             const unsigned char up[], int k);
