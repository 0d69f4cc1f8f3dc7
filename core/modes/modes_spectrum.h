/* The spectrum of a whole tree: the weighted trees of its parts (modes_symmetry), and counts of
 * eigenvalues over all parts.
 * Leaves to others: eigenvalues of one part (modes_values), combining modes (modes).
 * Invariant: eigenvalues are signed, negative for modes that grow. */
#pragma once

#include "core/modes/modes_symmetry.h"
#include "core/modes/modes_values.h"
#include "core/tree/loads.h"

/* State of the search for a part's eigenvalues: first the negative ones, as positive eigenvalues of
 * -L, then the others. */
struct pend_search {
    struct pend_laplacian *part;
    struct pend_values *values; /* NULL between the two searches */
    double *value;
    int first, count, split; /* split: number of eigenvalues below 0 */
    int done;                /* how many of both searches are complete, 0 .. 2 */
};

struct pend_spectrum {
    struct pend_symmetry *symmetry;
    struct pend_laplacian **part; /* one for each of the symmetry's parts */
    int *place;                   /* n ints of scratch */
    int n;
    int lead;     /* stored number of the caller's first arm */
    int negative; /* number of eigenvalues below 0 */
    struct pend_search search;
    double least, most; /* 1/s^2: every eigenvalue has least <= |lambda| <= most */
};

/**
 * Creates the spectrum of a tree about an equilibrium.
 *
 * up  n flags in stored order, non-zero for upright arms; NULL if all hang.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_spectrum_new(struct pend_spectrum **spectrum,
                                                   const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const unsigned char up[]);
void pend_spectrum_free(struct pend_spectrum **spectrum);

/**
 * Checks that the squares of the frequencies lie within the range of numbers in which modes can be
 * computed, 1e-300 to 1e300 (rad/s)^2, and that the stiffness of gravity at every arm is at least
 * 1e-270 N/m.
 *
 * PEND_INVALID  the error states the frequencies or the stiffness. O(n).
 */
PEND_MUST_CHECK enum pend_status pend_spectrum_check(const struct pend_spectrum *spectrum,
                                                     struct pend_error *error);

/**
 * Finds the modes with from <= omega <= to, rad/s. Both ends are widened by two units in the last
 * digit, so that a previously computed frequency is found again.
 *
 * first  out: the number, from 0, of the first such mode among all modes.
 * count  out: the number of such modes, 0 or more.
 * O(n).
 */
void pend_spectrum_between(const struct pend_spectrum *spectrum, double from, double to, int *first,
                           int *count);

/** Returns a shift, 1/s^2, below which lie `number` eigenvalues or a few more (above = 1), or a few
 * less (above = 0). O(n). */
double pend_spectrum_cut(const struct pend_spectrum *spectrum, int number, int above);

/**
 * Starts the search for eigenvalues of a part, signed and ascending.
 *
 * first, count  eigenvalues first .. first + count - 1 of the part, counted from the least.
 * value         out, count values, complete at the end of the search, which it must outlive.
 * O(n of the part).
 */
void pend_spectrum_search(struct pend_spectrum *spectrum, int part, int first, int count,
                          double value[]);

/**
 * Continues the search for at most about 64 sweeps over the part.
 *
 * done  out: non-zero once all are found.
 *
 * PEND_NO_MEMORY  O(count).
 */
PEND_MUST_CHECK enum pend_status pend_spectrum_step(struct pend_spectrum *spectrum, int *done);
