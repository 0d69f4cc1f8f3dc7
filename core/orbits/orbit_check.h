/* Checks that an orbit returns to its start: the motion over the whole period, integrated
 * independently of the search.
 * Leaves to others: finding orbits (orbit_newton).
 * Invariant: reported properties of an orbit are those of this motion. */
#pragma once

#include "core/integrate/run/run.h"
#include "core/orbits/orbit_form.h"

struct orbit_check {
    int n;
    double closure;    /* distance between end and start: rad, or rates in the form's unit */
    int divisor;       /* how often the orbit repeats within its period; 1 if it does not */
    double *amplitude; /* n: half the difference between the extreme angles, if computed */
    /* state of the running motion */
    struct pend_run *run;
    long steps; /* number of steps of all earlier motions */
    int rows, done;
    double *t, *seen, *phi, *rate; /* instants; rows in the caller's order */
    double *block;
};

/**
 * Prepares the memory.
 *
 * all    non-zero: also for orbits of driven pendulums and free orbits.
 * check  out; released by pend_orbit_check_clear, also after a failure.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_init(struct orbit_check *check, int n, int all);
void pend_orbit_check_clear(struct orbit_check *check);

/** Returns the bytes of pend_orbit_check_init and of the motion. O(1). */
double pend_orbit_check_bytes(int n, int all);

/**
 * Starts to check an orbit.
 *
 * motion  from pend_orbit_form_set.
 *
 * PEND_NO_MEMORY, PEND_INVALID
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_begin(struct orbit_check *check,
                                                        const struct orbit_form *form,
                                                        const struct pend_problem *motion,
                                                        struct pend_error *error);

/**
 * Continues the motion.
 *
 * work  as in pend_run_next.
 * done  out, non-zero once closure, divisor and amplitude are known.
 *
 * Fails as pend_run_next does.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_next(struct orbit_check *check,
                                                       const struct orbit_form *form, double work,
                                                       int *done, struct pend_error *error);
