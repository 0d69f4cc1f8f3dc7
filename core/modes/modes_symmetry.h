/* Branches that are alike: siblings with equal sub-trees, what they do together and what they do
 * against each other.
 * Leaves to others: eigenvalues and vectors of the smaller trees (modes_values, modes_vectors).
 * Invariant: alike means equal to the last bit, arm by arm; modes of different parts are
 * orthogonal by construction. */
#ifndef PEND_MODES_SYMMETRY_H
#define PEND_MODES_SYMMETRY_H

#include "core/modes/laplacian.h"
#include "core/tree/loads.h"

/* Like branches on one joint: branch[first .. first + count - 1], sorted by the caller's first
 * arm in each. */
struct pend_likes {
    int first, count;
};

/* One way in which like branches move against each other: branch `from` of the likes against all
 * later ones. */
struct pend_contrast {
    int likes, from;
    int lead; /* the caller's number of the first arm that moves */
};

/* One of the trees whose modes together are all modes. Part 0 is the whole tree with like
 * branches merged. Every other part is a kind of branch that occurs several times on a joint,
 * tied to that joint at rest, its own like branches merged: each joint with c of them has its
 * modes c - 1 times. */
struct pend_part {
    int root;  /* stored number of the arm at which the part begins */
    int n;     /* arms once merged */
    int times; /* how often each of its modes occurs */
    int first; /* its first contrast; it has `times` of them, sorted by lead; part 0 has none */
};

struct pend_symmetry {
    int part_count, likes_count;
    struct pend_part *part;
    struct pend_likes *likes;
    struct pend_contrast *contrast;
    int *branch;  /* stored numbers of first arms */
    int *offset;  /* n: place of an arm in its merged part, counted from its parent's place */
    int *copies;  /* n: how many like siblings an arm stands for, itself included */
    char *merged; /* n: non-zero where an earlier like sibling stands for the arm */
    const struct pend_tree *tree;
};

/**
 * Finds like branches.
 *
 * up  n flags in stored order, arms that stand up; NULL when all hang. Like branches stand alike.
 *
 * PEND_NO_MEMORY  O(n).
 * O(n log n) at worst, O(n) as a rule.
 */
PEND_MUST_CHECK enum pend_status pend_symmetry_new(struct pend_symmetry **symmetry,
                                                   const struct pend_tree *tree,
                                                   const unsigned char up[]);

void pend_symmetry_free(struct pend_symmetry **symmetry);

/**
 * The weighted tree of a part.
 *
 * place  n ints of scratch for the whole tree.
 *
 * PEND_NO_MEMORY  O(n of the part).
 */
PEND_MUST_CHECK enum pend_status pend_symmetry_laplacian(struct pend_laplacian **laplacian,
                                                         const struct pend_symmetry *symmetry,
                                                         int part, const struct pend_loads *loads,
                                                         const unsigned char up[], int place[]);

/** The places in a part of all arms that move in its modes. place: n ints of the tree; others are
 * left alone. O(n). */
void pend_symmetry_places(const struct pend_symmetry *symmetry, int part, int place[]);

/**
 * Spreads a part's mode over the arms of the tree.
 *
 * which   number of the mode's occurrence, 0 <= which < times; occurrences are mass-orthogonal.
 * angle   the part's n angles.
 * zero    an angle of at most this size counts as none.
 * place   from pend_symmetry_places.
 * vector  out, n angles of the tree.
 *
 * Returns the caller's number of the first arm that moves, having made its angle positive; -1 where
 * that is not known.
 */
int pend_symmetry_spread(const struct pend_symmetry *symmetry, int part, int which,
                         const double angle[], double zero, const int place[], double vector[]);

#endif
