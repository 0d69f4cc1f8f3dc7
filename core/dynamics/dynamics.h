/* Angular accelerations and arm forces of a moving tree in O(n), without a matrix.
 * Leaves to others: positions and energies (kinematics).
 * Invariant: no allocation; arms in the tree's stored order. */
#pragma once

#include <stddef.h>

#include "core/base/isa.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/** Returns the bytes of scratch that pend_dynamics needs for a tree of n arms. */
size_t pend_dynamics_work_bytes(int n);

/**
 * Computes angular accelerations and compression forces of a moving tree.
 *
 * Two sweeps, leaves to root then root to leaves, solve (aaa) and (bbb) without forming a matrix:
 * with relative angles and arm-local frames, tensions before accelerations, corrected until forces
 * balance at every joint (derivation: core/theory.md).
 *
 * tree     n arms; all arrays in the tree's stored order.
 * loads    gravity and other loads; gravity of any finite value.
 * phi      n angles, rad, from the positive real axis.
 * rate     n angular velocities, rad/s.
 * work     pend_dynamics_work_bytes(n) bytes, aligned to 64; contents on entry are ignored.
 * acc      out, n values, rad/s^2; may be the same array as rate.
 * force    out, n values, N, compression positive; NULL to skip.
 *
 * A fast form uses vector instructions. It detects states for which it loses digits; then a careful
 * form is used (core/theory.md). On processors with the same instruction set, equal input gives
 * equal bits; between instruction sets the last digits differ.
 *
 * Cannot fail on a valid tree and finite inputs. O(n), no allocation. Thread-safe if each thread
 * has its own `work`.
 */
void pend_dynamics(const struct pend_tree *tree, const struct pend_loads *loads, const double phi[],
                   const double rate[], void *work, double acc[], double force[]);

/** Returns the bytes of scratch that pend_dynamics_at needs. O(harmonics). */
size_t pend_dynamics_at_bytes(const struct pend_tree *tree, const struct pend_loads *loads);

/**
 * As pend_dynamics at a given time, for ideal and real pendulums. Loads with terms use the general
 * kernel (bodies), others the fast forms.
 *
 * time   s, in the time of the request, at which drives are evaluated.
 * work   pend_dynamics_at_bytes bytes, aligned to 64.
 * force  for a real pendulum, the compression at the arms' tips.
 */
void pend_dynamics_at(const struct pend_tree *tree, const struct pend_loads *loads, double time,
                      const double phi[], const double rate[], void *work, double acc[],
                      double force[]);

/* Number of states that pend_dynamics_vec computes at once. */
enum { PEND_DYNAMICS_VEC = 8 };

/** Returns the bytes of scratch that pend_dynamics_vec needs for a tree of n arms. */
size_t pend_dynamics_vec_bytes(int n);

/**
 * Computes angular accelerations and compression forces of PEND_DYNAMICS_VEC states of one tree,
 * one state in each vector lane.
 *
 * phi, rate, acc, force  n PEND_DYNAMICS_VEC values each, aligned to 64: arm k of state i at
 *                        PEND_DYNAMICS_VEC k + i; all arrays different, none NULL. Unused lanes
 *                        hold copies of another lane.
 * work                   pend_dynamics_vec_bytes(n) bytes, aligned to 64.
 *
 * Other parameters as pend_dynamics. Results have the same bits; they do not depend on the lane or
 * on other lanes.
 */
void pend_dynamics_vec(const struct pend_tree *tree, const struct pend_loads *loads,
                       const double phi[], const double rate[], void *work, double acc[],
                       double force[]);

/** Returns the bytes of scratch that pend_dynamics_many needs for a tree of n arms. */
size_t pend_dynamics_many_bytes(int n);

/**
 * Computes angular accelerations and compression forces of any number of states of one tree, each
 * with the same bits as pend_dynamics.
 *
 * count                  states, >= 0.
 * phi, rate, acc, force  count rows of n values; all arrays different, none NULL.
 * work                   pend_dynamics_many_bytes(n) bytes, aligned to 64.
 */
void pend_dynamics_many(const struct pend_tree *tree, const struct pend_loads *loads, long count,
                        const double phi[], const double rate[], void *work, double acc[],
                        double force[]);

/**
 * As pend_dynamics at angles phi + phi_low, for small swings about hanging. Their accelerations are
 * proportional to the angle from the vertical, of which the double phi contains only a few digits.
 *
 * phi_low  n values, below an ulp of phi.
 * scratch  3 n values.
 * force    out, not NULL.
 *
 * The effect of phi_low is computed from a state displaced by 2^36 phi_low; rounding and curvature
 * cause an error of 1e-26 rad. O(n), twice the work.
 */
void pend_dynamics_fine(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], const double phi_low[], const double rate[], void *work,
                        double scratch[], double acc[], double force[]);

/** Returns non-zero if forces computed from a power series lose digits that forces computed from a
 * state keep. This is true if the masses of two arms, with rods and bodies, differ by more than a
 * factor of 64. A series computes a force as mass times acceleration, with the rounding error of
 * the largest such product. Errors relative to the largest force: 1e-13 up to that factor, 4e-13
 * with masses of 10^±2, 2e-11 of 10^±4 and 2e-9 of 10^±6 kg (trees of up to 13 arms,
 * tests/laws/test_row_forces). O(n). */
int pend_dynamics_unlike(const struct pend_tree *tree, const struct pend_loads *loads);

/** Returns pend_dynamics and pend_dynamics_vec, compiled for an instruction set that this processor
 * has. For tests only. */
void pend_dynamics_for(enum pend_isa isa, const struct pend_tree *tree,
                       const struct pend_loads *loads, const double phi[], const double rate[],
                       void *work, double acc[], double force[]);
void pend_dynamics_vec_for(enum pend_isa isa, const struct pend_tree *tree,
                           const struct pend_loads *loads, const double phi[], const double rate[],
                           void *work, double acc[], double force[]);
