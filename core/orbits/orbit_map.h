/* A motion over a given time as a map of its start, with the derivatives of the map, for shooting.
 * Leaves to others: the equations of an orbit (orbit_form), the motion (derivatives).
 * Invariant: everything is in the tree's stored order; the bits of a map do
 * not depend on its division into calls. */
#pragma once

#include "core/derivatives/derivatives.h"

/* n arms and at most `most` parameters; arrays have n numbers, derivatives n x count, [arm * count
 * + parameter]. */
struct orbit_map {
    int n, most, count;       /* arms; capacity for parameters; parameters of the last map */
    double *phi, *rate, *acc; /* rad, rad/s, rad/s^2 at the end */
    double *phi_by, *rate_by; /* derivatives of phi and rate with respect to the parameters */
    double energy;            /* J, energy at the start */
    double *energy_by;        /* count derivatives of the energy */
    /* state of a running map */
    const int *place;
    struct pend_derivatives *motion;
    double *instant; /* 2 instants, s */
    double *row;     /* values and derivatives, in the caller's order */
    long row_next;
    double *block;
};

/**
 * Prepares the memory of maps.
 *
 * map   out; released by pend_orbit_map_clear, also after a failure.
 * n, most  arms, and largest number of parameters of a map; both >= 1.
 *
 * PEND_NO_MEMORY  O(n most).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_map_init(struct orbit_map *map, int n, int most);
void pend_orbit_map_clear(struct orbit_map *map);

/** Returns the bytes of pend_orbit_map_init, without those of the motion. O(1). */
double pend_orbit_map_bytes(int n, int most);

/**
 * Starts a map; cancels an earlier one.
 *
 * problem    its times are set by this function; tree, loads and starts outlive the map.
 * span       s, > 0, from the time 0 on.
 * parameter  `count` parameters, 1 .. most.
 *
 * PEND_INVALID, PEND_NO_MEMORY  as pend_derivatives_new.
 */
PEND_MUST_CHECK enum pend_status
pend_orbit_map_begin(struct orbit_map *map, const struct pend_problem *problem, double span,
                     int count, const struct pend_parameter parameter[], struct pend_error *error);

/**
 * Continues the map.
 *
 * work  as in pend_derivatives_next.
 * done  out, non-zero once the results are complete.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  the map failed; start it again.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_map_next(struct orbit_map *map, double work, int *done,
                                                     struct pend_error *error);

/** Returns the steps of the map so far. O(1). */
long pend_orbit_map_steps(const struct orbit_map *map);
