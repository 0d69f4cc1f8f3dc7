/* A motion over a given time as a map of its start, with the derivatives of the map, for shooting.
 * Leaves to others: the equations of an orbit (orbit_form), the motion (derivatives).
 * Invariant: everything is in the tree's stored order; the map of the same start has the same
 * bits, however it is divided into calls. */
#pragma once

#include "core/derivatives/derivatives.h"

/* n arms and at most `most` parameters; arrays have n numbers, derivatives n x count, [arm * count
 * + parameter]. */
struct orbit_map {
    int n, most, count;       /* arms; capacity for parameters; parameters of the last map */
    double *phi, *rate, *acc; /* at the end: rad, rad/s, rad/s^2 */
    double *phi_by, *rate_by; /* their derivatives */
    double energy;            /* J, at the start */
    double *energy_by;        /* count, its derivatives */
    /* state of a map under way */
    const int *place;
    struct pend_derivatives *motion;
    double *instant; /* 2, s */
    double *row;     /* of values and derivatives, in the caller's order */
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

/** Frees the memory. */
void pend_orbit_map_clear(struct orbit_map *map);

/** Returns the bytes of pend_orbit_map_init, without the motion's own. O(1). */
double pend_orbit_map_bytes(int n, int most);

/**
 * Starts a map; cancels an earlier one.
 *
 * problem    its times are set here; tree, loads and starts outlive the map.
 * span       s, > 0, from the time 0 on.
 * parameter  count of them, 1 .. most.
 *
 * PEND_INVALID, PEND_NO_MEMORY  as pend_derivatives_new.
 */
PEND_MUST_CHECK enum pend_status
pend_orbit_map_begin(struct orbit_map *map, const struct pend_problem *problem, double span,
                     int count, const struct pend_parameter parameter[], struct pend_error *error);

/**
 * Continues the map.
 *
 * work  as of pend_derivatives_next.
 * done  out, non-zero once the results are complete.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  the map failed; start it again.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_map_next(struct orbit_map *map, double work, int *done,
                                                     struct pend_error *error);

/** Returns the steps of the map so far. O(1). */
long pend_orbit_map_steps(const struct orbit_map *map);
