/* The spectrum of a whole tree: its parts (modes_symmetry) with their weighted trees, counted
 * together.
 * Leaves to others: eigenvalues inside a part (modes_values), putting modes together (modes).
 * Invariant: eigenvalues are signed here, negative where the equilibrium gives way. */
#ifndef PEND_MODES_SPECTRUM_H
#define PEND_MODES_SPECTRUM_H

#include "core/modes/modes_symmetry.h"
#include "core/modes/modes_values.h"
#include "core/tree/loads.h"

/* The search for a part's eigenvalues: first those below 0, as positive ones of -L, then the
 * others. */
struct pend_search {
    struct pend_laplacian *part;
    struct pend_values *values; /* NULL between the two */
    double *value;
    int first, count, split; /* split: how many are below 0 */
    int done;                /* 0, 1 once those below 0 are found, 2 at the end */
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
 * Prepares the spectrum of a tree about an equilibrium.
 *
 * up  n flags in stored order, non-zero where an arm stands up; NULL when all hang.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_spectrum_new(struct pend_spectrum **spectrum,
                                                   const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const unsigned char up[]);

void pend_spectrum_free(struct pend_spectrum **spectrum);

/** Numbers of eigenvalues below ascending shifts, at most 16 of them, each mode counted as often
 * as it occurs. O(n). */
void pend_spectrum_below(const struct pend_spectrum *spectrum, int count, const double shift[],
                         int below[]);

/**
 * A shift that has `number` or a few more eigenvalues below it (above = 1), or a few less (above =
 * 0).
 */
double pend_spectrum_cut(const struct pend_spectrum *spectrum, int number, int above);

/**
 * Begins to search for eigenvalues of a part, signed and ascending.
 *
 * first, count  numbers in the part.
 * value         out, count values, once the search is done; outlives it.
 * O(n of the part).
 */
void pend_spectrum_search(struct pend_spectrum *spectrum, int part, int first, int count,
                          double value[]);

/**
 * Searches on for at most about 64 sweeps over the part.
 *
 * done  set non-zero once all are found.
 *
 * PEND_NO_MEMORY  O(count).
 */
PEND_MUST_CHECK enum pend_status pend_spectrum_step(struct pend_spectrum *spectrum, int *done);

#endif
