/* Positions, velocities and energies of an ideal or real pendulum at a given time.
 * Leaves to others: ideal pendulums (kinematics, whose functions it calls).
 * Invariant: arms in the tree's stored order; no allocation. */
#pragma once

#include "core/dynamics/kinematics.h"
#include "core/tree/loads.h"

struct at_vector {
    double x, y;
};

/** Returns the position of a real pendulum's pivot, m, its velocity or its acceleration: the
 * derivative of order 0, 1 or 2. O(harmonics). */
struct at_vector pend_kinematics_pivot(const struct pend_loads *loads, double time, int order);

/**
 * Fills in the positions of the tips, m, in the ground's frame, with attachment points other than
 * tips and a moving pivot.
 *
 * time    s, in the request's time, for a driven pivot.
 * re, im  out, n values each.
 * O(n + harmonics).
 */
void pend_kinematics_position_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 double time, const double phi[], double re[], double im[]);

/** Fills in the velocities of the tips, m/s. Parameters as pend_kinematics_position_at. */
void pend_kinematics_velocity_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 double time, const double phi[], const double rate[], double re[],
                                 double im[]);

/** Fills in the accelerations of the tips, m/s^2. acc: phi''. Parameters as
 * pend_kinematics_position_at. */
void pend_kinematics_acceleration_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                     double time, const double phi[], const double rate[],
                                     const double acc[], double re[], double im[]);

/**
 * Returns the kinetic energy in the ground's frame, and the potential energy of gravity and
 * springs, J.
 *
 * scratch  4 n values, for a real pendulum; may be NULL for an ideal one.
 *
 * O(n + harmonics), compensated sums.
 */
struct pend_energy pend_kinematics_energy_at(const struct pend_tree *tree,
                                             const struct pend_loads *loads, double time,
                                             const double phi[], const double rate[],
                                             double scratch[]);

/**
 * As pend_kinematics_energy_at for several states, rows of n, each at its own time. It is faster
 * for small trees, whose unit vectors are computed together. A state's energy has the same bits as
 * if computed alone.
 *
 * scratch  2 n (count + 1) values, for a real pendulum.
 * energy   out, count values.
 */
void pend_kinematics_energies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                 int count, const double time[], const double phi[],
                                 const double rate[], double scratch[],
                                 struct pend_energy energy[]);

/** Returns the scale to which an energy drift is compared, J: pend_kinematics_energy_scale, with
 * the masses of rods and bodies, plus the energy of springs deflected by one radian. */
double pend_kinematics_energy_scale_at(const struct pend_tree *tree, const struct pend_loads *loads,
                                       double kinetic);
