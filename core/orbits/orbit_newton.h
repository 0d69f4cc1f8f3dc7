/* Newton's method for the equations of an orbit and one more that picks it out of its branch.
 * Leaves to others: which orbit is wanted, and whether a solution is one (orbits).
 * Invariant: what is called found has a last correction of the size of round-off. */
#ifndef PEND_ORBIT_NEWTON_H
#define PEND_ORBIT_NEWTON_H

#include "core/orbits/orbit_algebra.h"
#include "core/orbits/orbit_form.h"

enum orbit_newton_end { ORBIT_GOING, ORBIT_FOUND, ORBIT_LOST };

struct orbit_newton {
    struct orbit_form form;
    struct orbit_map map;
    struct orbit_algebra *algebra;
    int unknowns;
    double *u;      /* in: a guess; once found: the solution */
    double *normal; /* closes the system: normal . u = value; */
    double value;
    int energy;  /* non-zero: the energy above the rest is value, J, instead */
    int careful; /* non-zero: from far away, by steps that make the equations' error smaller */
    int look;    /* non-zero: J of the guess is wanted, no solution; its last row is 0 */
    int whole;   /* non-zero: once found, the map has the derivatives by all angles and rates */
    double *J;   /* of the solution: unknowns x unknowns, the last row is what closes */
    /* while it is looked for */
    int iteration, under_way, complete; /* complete: the map has all derivatives */
    double *F, *delta, *good, *way;
    double last, part, size; /* last: correction; part: of `way` tried; size: of F at `good` */
    struct pend_problem motion;
    long steps, maps; /* all in all */
    double *block;
};

/**
 * Prepares the method; the rest and the mode are found.
 *
 * newton   out; ends with pend_orbit_newton_clear whatever is returned.
 * problem  outlives it.
 *
 * PEND_NO_MEMORY, and the failures of pend_orbit_form_init.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_newton_init(struct orbit_newton *newton,
                                                        const struct pend_orbit_problem *problem,
                                                        struct pend_error *error);

/** Frees the memory. */
void pend_orbit_newton_clear(struct orbit_newton *newton);

/** Returns the bytes of pend_orbit_newton_init and of a map. O(1). */
double pend_orbit_newton_bytes(const struct pend_orbit_problem *problem);

/** Begins from u; what closes the system, careful and whole have been set. */
void pend_orbit_newton_begin(struct orbit_newton *newton);

/**
 * Goes on: a piece of a map, or a correction.
 *
 * work  as of pend_derivatives_next.
 *
 * PEND_NO_MEMORY  Everything else that fails ends as ORBIT_LOST.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_newton_next(struct orbit_newton *newton, double work,
                                                        enum orbit_newton_end *end,
                                                        struct pend_error *error);

/**
 * The direction of a branch at the solution found.
 *
 * along  unknowns: the direction has a positive product with it; out: the direction, its largest
 *        entry of size 1.
 *
 * Returns true if it is known.
 */
int pend_orbit_newton_tangent(struct orbit_newton *newton, double along[]);

/** Returns the energy above the rest of a solution without a drive, J. O(1). */
double pend_orbit_newton_energy(const struct orbit_newton *newton);

/** Returns how that energy changes along a direction of the unknowns, J. O(n). */
double pend_orbit_newton_slope(const struct orbit_newton *newton, const double along[]);

/** The equations become those of orbits that need not rest, in their unknowns; those of the
 * solution and of a direction, which have room for them, too. */
void pend_orbit_newton_free(struct orbit_newton *newton, int turning, double direction[]);

#endif
