/* Newton's method for the equations of an orbit and a closing equation that selects the orbit on
 * its branch.
 * Leaves to others: the choice of orbits, and whether a solution is an orbit (orbits).
 * Invariant: the last correction of a solution has the size of round-off. */
#pragma once

#include "core/orbits/orbit_algebra.h"
#include "core/orbits/orbit_form.h"

enum orbit_newton_end { ORBIT_GOING, ORBIT_FOUND, ORBIT_LOST };

struct orbit_newton {
    struct orbit_form form;
    struct orbit_map map;
    struct orbit_algebra *algebra;
    int unknowns;
    double *u;      /* in: a guess; out: the solution */
    double *normal; /* coefficients of the closing equation, normal . u = value */
    double value;
    int energy;  /* non-zero: the closing equation is: energy above rest = value, J */
    int careful; /* non-zero: far from a solution; accepts only steps that reduce the error */
    int look;    /* non-zero: computes J at the guess instead of a solution; its last row is 0 */
    int whole;   /* non-zero: the map has all derivatives with respect to angles and rates */
    double *J;   /* of the solution: unknowns x unknowns, the last row is the closing equation */
    /* state of the search */
    int iteration, under_way, complete; /* whether the map has all derivatives */
    double *F, *delta, *good, *way;
    double last, part, size; /* last correction; tried fraction of `way`; size of F at `good` */
    struct pend_problem motion;
    long steps, maps; /* totals */
    double *block;
};

/**
 * Prepares the method; finds the equilibrium and the mode.
 *
 * newton   out; released by pend_orbit_newton_clear, also after a failure.
 * problem  must outlive the method.
 *
 * PEND_NO_MEMORY; also fails as pend_orbit_form_init does.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_newton_init(struct orbit_newton *newton,
                                                        const struct pend_orbit_problem *problem,
                                                        struct pend_error *error);
void pend_orbit_newton_clear(struct orbit_newton *newton);

/** Returns the bytes of pend_orbit_newton_init and of a map. O(1). */
double pend_orbit_newton_bytes(const struct pend_orbit_problem *problem);

/**
 * Continues by a piece of a map, or a correction.
 *
 * work  as in pend_derivatives_next.
 *
 * PEND_NO_MEMORY  Any other failure ends the search as ORBIT_LOST.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_newton_next(struct orbit_newton *newton, double work,
                                                        enum orbit_newton_end *end,
                                                        struct pend_error *error);

/**
 * Computes the direction of a branch at the solution found.
 *
 * along  in: the returned direction has a positive product with it; out: the direction, scaled to a
 *        largest entry of size 1.
 *
 * Returns true if the direction could be computed.
 */
int pend_orbit_newton_tangent(struct orbit_newton *newton, double along[]);

/** Returns the energy of a solution above the equilibrium, J, without a drive. O(1). */
double pend_orbit_newton_energy(const struct orbit_newton *newton);

/** Returns the derivative of that energy along a direction of the unknowns, J. O(n). */
double pend_orbit_newton_slope(const struct orbit_newton *newton, const double along[]);

/** Switches to the equations and unknowns of free orbits. Also converts the solution and a
 * direction; both must have space for the additional unknowns. */
void pend_orbit_newton_free(struct orbit_newton *newton, int turning, double direction[]);
