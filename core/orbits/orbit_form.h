/* The equations of a periodic orbit, as functions of a list of unknowns, and their derivatives.
 * Leaves to others: solving them (orbits), the motion (orbit_map).
 * Invariant: there is one more unknown than equations; the caller adds the last equation.
 *
 * An orbit between two states of rest starts without velocity, x away from the equilibrium, and
 * stops again after half of its period T: n equations rate(T / 2) = 0 in x and T. If a pendulum is
 * its own mirror image under theta -> -theta, it passes theta = 0 after T / 4: theta(T / 4) = 0. An
 * orbit of a driven pendulum returns after k periods of the drive: 2 n equations in the start and
 * in a varied number. A free orbit, which is not driven and never at rest, returns after its
 * period, or to its mirror image after half of it: 2 n equations in the start and T. By
 * conservation of energy one equation follows from the others; it is replaced by the condition that
 * one arm has rate 0 at the start. Unknowns are angles, rates relative to a frequency, the period
 * relative to the mode's, and the progress of the varied number from its first value to its last
 * one, 0 .. 1. */
#pragma once

#include "core/orbits/orbit_map.h"
#include "core/orbits/orbit_problem.h"

enum orbit_kind { ORBIT_QUARTER, ORBIT_HALF, ORBIT_FREE, ORBIT_DRIVEN };

struct orbit_form {
    enum orbit_kind kind;
    const struct pend_orbit_problem *problem;
    int n, equations, turns; /* arms, equations; turns: arms whose whole turns change nothing */
    int times;               /* number of periods of the drive, or of the first branch's orbits */
    int mirrored;            /* whether the orbit is its mirror image after half its period */
    int turning;             /* for ORBIT_FREE, the arm whose rate is 0 at the start */
    int twins, twin[2];      /* number of equal branches on one joint, 0 if fewer than three; first
                              * arms of the two branches with the largest opposite motion */
    int against;             /* whether only these two swing, against each other */
    double omega;            /* rad/s, frequency of the mode or of the drive: the unit of rates */
    double from;             /* start value of the varied number */
    double rest_potential;   /* J, potential energy at the equilibrium */
    double *rest, *rest_low; /* n: the equilibrium, rad */
    double *shape;           /* n: the mode, scaled to a largest angle of 1 */
    /* the pendulum and the start for a given list of unknowns */
    struct pend_tree *tree; /* NULL: the problem's tree */
    struct pend_loads loads;
    double *value; /* values of the terms */
    double *phi, *phi_low, *rate;
    int halved;       /* whether the map covers only half of the span */
    double span;      /* s, time of the map */
    int count, slope; /* parameters of the map; index of the first one of the varied number */
    struct pend_parameter *parameter;
    double *weight; /* weights of the parameters from `slope` on */
    double *block;
};

/**
 * Finds the common base frequency of a pendulum's drives.
 *
 * omega  out, rad/s: the largest frequency of which all drives are whole multiples, up to 12.
 *
 * Returns false without drives, or if there is no such frequency. O(harmonics).
 */
int pend_orbit_drive(const struct pend_loads *loads, double *omega);

/**
 * Prepares the equations: finds the equilibrium, and the mode for orbits between states of rest.
 *
 * form     out; released by pend_orbit_form_clear, also after a failure.
 * problem  outlives the form.
 *
 * PEND_INVALID   the pendulum has no such mode.
 * PEND_NO_MEMORY, and the failures of modes (modes, damped).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_form_init(struct orbit_form *form,
                                                      const struct pend_orbit_problem *problem,
                                                      struct pend_error *error);
void pend_orbit_form_clear(struct orbit_form *form);

/** Returns the bytes of a form, including modes during their search. O(1). */
double pend_orbit_form_bytes(const struct pend_orbit_problem *problem);

/** Returns the largest number of parameters of a map of these equations. O(1). */
int pend_orbit_form_most(const struct orbit_form *form);

/**
 * Sets the pendulum, the start and the span of a list of unknowns.
 *
 * u       equations + 1 unknowns.
 * whole   non-zero: the map has all derivatives with respect to angles and rates, otherwise only
 *         those in the equations.
 * motion  out, for pend_orbit_map_begin and for runs: tree, loads and start.
 *
 * PEND_INVALID  the pendulum or the time is invalid.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_orbit_form_set(struct orbit_form *form, const double u[],
                                                     int whole, struct pend_problem *motion,
                                                     struct pend_error *error);

/**
 * Computes the equations and their derivatives from a map of the unknowns that were set last.
 *
 * F  out, `equations` values, 0 at an orbit.
 * J  out, rows of equations + 1, as many as equations.
 */
void pend_orbit_form_equations(const struct orbit_form *form, const struct orbit_map *map,
                               double F[], double J[]);

/**
 * Changes the shape of the mode to that in which two equal branches swing against each other, with
 * their joint at rest. With three equal branches each frequency is double, and other shapes may
 * have no branch to larger swings.
 *
 * Returns false, and changes nothing, if there are no three equal branches or the mode has that
 * shape already.
 */
int pend_orbit_form_against(struct orbit_form *form);

/** Projects a list of unknowns onto the shape of pend_orbit_form_against, if chosen. O(n). */
void pend_orbit_form_hold(const struct orbit_form *form, double u[]);

/** Returns the distance from the start (side 1), or from the mirror image of the start about
 * hanging (side -1), to the end of a map, or without a map to the start itself. Unit: rad, and
 * rates in the form's unit. O(n). */
double pend_orbit_form_apart(const struct orbit_form *form, const struct orbit_map *map, int side);

/** Returns the whole period of the unknowns that were set last, s. O(1). */
double pend_orbit_form_period(const struct orbit_form *form);

/** Returns the varied number, in its unit, for a list of unknowns. O(1). */
double pend_orbit_form_value(const struct orbit_form *form, const double u[]);
