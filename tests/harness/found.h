/* A search for periodic orbits and its results, for tests, with a check of its multipliers in 32
 * digits.
 * Leaves to others: which laws hold for the orbits (core/orbits).
 * Invariant: the check shares no motion with the search. */
#pragma once

#include "core/orbits/orbits.h"

enum { FOUND_ARMS = 20, FOUND_ROWS = 600, FOUND_KINDS = 40 };

/* the results of a search */
struct found {
    struct pend_tree *tree;
    struct pend_terms *terms; /* NULL: an ideal pendulum */
    double term[8];           /* their numbers */
    struct pend_orbit_problem problem;
    enum pend_status status;
    enum pend_orbits_end end;
    int rows, bifurcations;
    long calls, maps; /* of pend_orbits_next; motions with derivatives */
    double phi[FOUND_ROWS][FOUND_ARMS], low[FOUND_ROWS][FOUND_ARMS], rate[FOUND_ROWS][FOUND_ARMS],
        amplitude[FOUND_ROWS][FOUND_ARMS];
    double re[FOUND_ROWS][2 * FOUND_ARMS], im[FOUND_ROWS][2 * FOUND_ARMS];
    double period[FOUND_ROWS], energy[FOUND_ROWS], value[FOUND_ROWS], closure[FOUND_ROWS];
    int stable[FOUND_ROWS], after[FOUND_KINDS];
    enum pend_orbits_kind kind[FOUND_KINDS];
    double at[FOUND_KINDS]; /* energy or value of a bifurcation */
    int turns[FOUND_KINDS];
    double re_there[FOUND_KINDS][2 * FOUND_ARMS], im_there[FOUND_KINDS][2 * FOUND_ARMS];
};

/** Searches to the end; the tree is kept. */
void found_search(struct found *f);

/** A chain of n arms of 1 m and 1 kg, for orbits of a mode up to an amplitude; freed by found_free.
 */
struct found *found_chain(int n, int mode, double amplitude, int branch);

/** The same with a trunk of 1 m and 1 kg that carries n - 1 equal arms of 0.7 m and 0.6 kg. */
struct found *found_trunk(int n, int mode, double amplitude, int branch);

/** Terms of one row, and harmonics of a torque on the first arm; owned by f, their numbers 0. */
const struct pend_terms *found_terms(struct found *f, enum pend_term_row row, int harmonics);

/** A damped arm of 1 m and 1 kg with gravity 1 m/s^2 and a torque a cos(w t), for one orbit
 * starting from hanging at rest. */
struct found *found_driven(double damping, double torque, double omega);

/** Frees the memory and clears the pointer. NULL is accepted. */
void found_free(struct found **f);

/** The state after a time, as sums of two doubles, from the start of a row displaced by h along
 * coordinate j, none if j < 0: n angles and n rates. */
void found_moved(const struct found *f, int row, double time, int j, double h, double out[],
                 double out_low[]);

/** Checks the sum of the multipliers of a row, and that of their squares, against central
 * differences of motions in 32 digits over the whole period. */
void found_check_multipliers(const struct found *f, int row);
