/* The general form of the dynamics, for states for which the fast forms lose digits: light joints
 * between heavy arms that are nearly aligned or without tension.
 * Leaves to others: all other states (kernel_dynamics), the choice between the forms (dynamics).
 * Invariant: no allocation; arms in the tree's stored order. */
#pragma once

#include <stddef.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/** Returns the bytes of scratch for a tree of n arms, a multiple of 64. */
size_t pend_dynamics_careful_bytes(int n);

/**
 * Computes angular accelerations and compression forces of a moving tree; parameters as
 * pend_dynamics, but force may be NULL.
 *
 * It sums over pairs of siblings in the frame of the heaviest, takes angles between siblings as
 * exact differences, solves tensions before accelerations, and restores the balance of forces at
 * every joint. O(n), four to six times the time of the fast forms.
 */
void pend_dynamics_careful(const struct pend_tree *tree, const struct pend_loads *loads,
                           const double phi[], const double rate[], void *work, double acc[],
                           double force[]);
