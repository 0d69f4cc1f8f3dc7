/* Like branches: siblings with equal sub-trees. In some modes of the tree like branches move
 * together; in the others they move against each other.
 * Leaves to others: eigenvalues and vectors of the smaller trees (modes_values, modes_vectors).
 * Invariant: like branches are equal to the last bit, arm by arm; modes of different parts are
 * orthogonal by construction. */
#pragma once

#include "core/modes/laplacian.h"
#include "core/tree/loads.h"

/* Like branches on one joint: branch[first .. first + count - 1], sorted by the smallest caller's
 * number of an arm in each. */
struct pend_likes {
    int first, count;
};

/* A pattern in which like branches move against each other: branch number `from` of the group
 * against all later ones (Helmert's contrasts). */
struct pend_contrast {
    int likes, from;
    int lead; /* first arm that moves, in the caller's numbering */
};

/* One of the trees whose modes together are all modes. Part 0 is the whole tree with like
 * branches merged. Every other part is a kind of branch that occurs several times on a joint,
 * with that joint at rest and its own like branches merged. At a joint with c such branches, each
 * mode of this part occurs c - 1 times. */
struct pend_part {
    int root;  /* stored number of the arm at which the part begins */
    int n;     /* number of arms after merging */
    int times; /* number of times that each of its modes occurs */
    int first; /* index of the first of its `times` contrasts, sorted by lead; part 0 has none */
};

struct pend_symmetry {
    int part_count, likes_count;
    struct pend_part *part;
    struct pend_likes *likes;
    struct pend_contrast *contrast;
    int *branch;  /* stored numbers of the branches' first arms */
    int *offset;  /* n: index of an arm in its merged part minus its parent's index */
    int *copies;  /* n: number of like siblings that an arm represents, itself included */
    char *merged; /* n: non-zero if an earlier like sibling represents the arm */
    const struct pend_tree *tree;
};

/**
 * Finds like branches.
 *
 * symmetry  out; NULL on failure; released by pend_symmetry_free.
 * tree      must outlive the symmetry.
 * up        n flags in stored order, non-zero for arms that stand up; NULL if all hang. Like
 *           branches have equal flags.
 *
 * PEND_NO_MEMORY  O(n).
 * O(n log n) at worst; O(n) unless joints have very many branches.
 */
PEND_MUST_CHECK enum pend_status pend_symmetry_new(struct pend_symmetry **symmetry,
                                                   const struct pend_tree *tree,
                                                   const unsigned char up[]);
void pend_symmetry_free(struct pend_symmetry **symmetry);
int pend_symmetry_valid(const struct pend_symmetry *symmetry);

/**
 * Makes the weighted tree of a part.
 *
 * place  n ints of scratch for the whole tree.
 *
 * PEND_NO_MEMORY  O(n of the part).
 */
PEND_MUST_CHECK enum pend_status pend_symmetry_laplacian(struct pend_laplacian **laplacian,
                                                         const struct pend_symmetry *symmetry,
                                                         int part, const struct pend_loads *loads,
                                                         const unsigned char up[], int place[]);

/**
 * Computes the indices, in a part, of all arms that move in its modes.
 *
 * place  n ints, one for each arm of the tree; those of other arms are not changed.
 * O(n).
 */
void pend_symmetry_places(const struct pend_symmetry *symmetry, int part, int place[]);

/**
 * Expands a part's mode to the arms of the tree.
 *
 * which   number of the mode's occurrence, 0 <= which < times; occurrences are mass-orthogonal.
 * angle   the part's n angles.
 * zero    largest angle that counts as 0.
 * place   from pend_symmetry_places.
 * vector  out, n angles of the tree.
 *
 * Returns the caller's number of the first arm that moves, whose angle in `vector` is positive; -1
 * if that arm is unknown. O(n).
 */
int pend_symmetry_spread(const struct pend_symmetry *symmetry, int part, int which,
                         const double angle[], double zero, const int place[], double vector[]);
