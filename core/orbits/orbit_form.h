/* The equations that a periodic orbit obeys, as functions of a list of unknowns, and their
 * derivatives.
 * Leaves to others: solving them (orbits), the motion (orbit_map).
 * Invariant: there is one more unknown than equations; what closes the system is the caller's.
 *
 * An orbit between two rests begins at rest at rest + x and is at rest again after half of its
 * period T: n equations rate(T / 2) = 0 in x and T. If a pendulum is its own mirror image, theta
 * -> -theta, it passes theta = 0 after a quarter of it: theta(T / 4) = 0. An orbit of a driven
 * pendulum comes back after k periods of the drive: 2 n equations in the start and in a number
 * that varies. An orbit that neither is driven nor rests comes back after its period, or to its
 * mirror image after half of it: 2 n equations in the start and T, of which one follows from the
 * others, since the energy is kept; in its place one arm turns back at the start. Unknowns are
 * angles, rates in parts of a frequency, the period in parts of the mode's, and the way of the
 * number that varies from its value to the last one wanted, 0 .. 1. */
#ifndef PEND_ORBIT_FORM_H
#define PEND_ORBIT_FORM_H

#include "core/orbits/orbit_map.h"
#include "core/orbits/orbit_problem.h"

enum orbit_kind { ORBIT_QUARTER, ORBIT_HALF, ORBIT_FREE, ORBIT_DRIVEN };

struct orbit_form {
    enum orbit_kind kind;
    const struct pend_orbit_problem *problem;
    int n, equations, turns; /* turns: whole turns of an arm change nothing */
    int times;               /* periods of the drive, or of the branch where all began */
    int mirrored;            /* after half of its period it is its own mirror image */
    int turning;             /* of ORBIT_FREE: the arm that turns back at the start */
    int twins, twin[2];    /* equal branches on one joint, of which the mode moves two most against
                              each other: their first arms; 0: there are no three such */
    int against;           /* the two swing against each other and all other arms hang still */
    double omega;          /* rad/s, of the mode or of the drive: the unit of rates */
    double from;           /* what varies, at the begin */
    double rest_potential; /* J */
    double *rest, *rest_low; /* n: the rest, rad */
    double *shape;           /* n: the mode, its largest angle 1 */
    /* the pendulum and the start for a list of unknowns */
    struct pend_tree *tree; /* NULL: the problem's */
    struct pend_loads loads;
    double *value; /* of its terms */
    double *phi, *phi_low, *rate;
    int halved;       /* the map takes half of the span: of a look at half of an orbit */
    double span;      /* s, of the map */
    int count, slope; /* parameters of the map; where those of what varies begin */
    struct pend_parameter *parameter;
    double *weight; /* of the parameters from `slope` on */
    double *block;
};

/**
 * Finds what the drives of a pendulum have in common.
 *
 * omega  out, rad/s: the largest frequency of which all are whole multiples, up to 12 each.
 *
 * Returns false without drives, and where there is no such frequency. O(harmonics).
 */
int pend_orbit_drive(const struct pend_loads *loads, double *omega);

/**
 * Prepares the equations: finds the rest and the mode of orbits between rests.
 *
 * form     out; ends with pend_orbit_form_clear whatever is returned.
 * problem  outlives the form.
 *
 * PEND_INVALID   the pendulum has no such mode.
 * PEND_NO_MEMORY, and the failures of modes (modes, damped).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_form_init(struct orbit_form *form,
                                                      const struct pend_orbit_problem *problem,
                                                      struct pend_error *error);

/** Frees the memory. */
void pend_orbit_form_clear(struct orbit_form *form);

/** Returns the bytes of a form, modes included while they are looked for. O(1). */
double pend_orbit_form_bytes(const struct pend_orbit_problem *problem);

/** Returns the most parameters of a map of these equations. O(1). */
int pend_orbit_form_most(const struct orbit_form *form);

/**
 * Sets the pendulum, the start and the span of a list of unknowns.
 *
 * u       equations + 1 unknowns.
 * whole   non-zero: the map has the derivatives by angles and rates, else those that the equations
 *         need.
 * motion  out, for pend_orbit_map_begin and for runs: tree, loads and start.
 *
 * PEND_INVALID  there is no such pendulum, or no such time.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_orbit_form_set(struct orbit_form *form, const double u[],
                                                     int whole, struct pend_problem *motion,
                                                     struct pend_error *error);

/**
 * Fills in the equations and their derivatives from a map of the list of unknowns that was set.
 *
 * F  out, `equations` values, 0 at an orbit.
 * J  out, rows of equations + 1, as many as equations.
 */
void pend_orbit_form_equations(const struct orbit_form *form, const struct orbit_map *map,
                               double F[], double J[]);

/**
 * The equations become those of orbits that take twice the period, near the same unknowns.
 *
 * Returns false, and changes nothing, beyond PEND_ORBIT_PERIODS.
 */
int pend_orbit_form_double(struct orbit_form *form);

/**
 * The shape of the mode becomes that in which two equal branches swing against each other, each as
 * if its joint were at rest. Three equal branches have each frequency of theirs twice, and other
 * shapes of it need not continue to larger swings.
 *
 * Returns false, and changes nothing, without three equal branches or where that is the shape.
 */
int pend_orbit_form_against(struct orbit_form *form);

/** Takes out of a list of unknowns what does not have that shape, where orbits have it. O(n). */
void pend_orbit_form_hold(const struct orbit_form *form, double u[]);

/** The equations of orbits that are their own mirror image become those of others, near the same
 * unknowns. */
void pend_orbit_form_unmirror(struct orbit_form *form);

/**
 * The equations of orbits between two rests become those of orbits that need not rest.
 *
 * turning  the arm that turns back at the start: one that gravity and springs move there.
 */
void pend_orbit_form_free(struct orbit_form *form, int turning);

/** Returns how far the end of a map, or without one the start itself, is from the start (side 1),
 * or from the mirror image of the start about hanging (side -1): rad, and rates in the form's unit.
 * O(n). */
double pend_orbit_form_apart(const struct orbit_form *form, const struct orbit_map *map, int side);

/** Returns the whole period of a list of unknowns that was set, s. O(1). */
double pend_orbit_form_period(const struct orbit_form *form);

/** Returns what varies, in its unit, for a list of unknowns. O(1). */
double pend_orbit_form_value(const struct orbit_form *form, const double u[]);

#endif
