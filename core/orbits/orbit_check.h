/* Whether an orbit comes back: the motion from its start over the whole period, by the plain
 * series, which share no step with the search.
 * Leaves to others: finding orbits (orbit_newton).
 * Invariant: what is told of an orbit was seen on this motion. */
#ifndef PEND_ORBIT_CHECK_H
#define PEND_ORBIT_CHECK_H

#include "core/integrate/run/run.h"
#include "core/orbits/orbit_form.h"

struct orbit_check {
    int n;
    double closure;    /* how far the start is missed: rad, or rates in the form's unit */
    int divisor;       /* the orbit comes back after this part of its period already; else 1 */
    double *amplitude; /* n: half of the way between its extreme angles, where all are seen */
    /* while it is under way */
    struct pend_run *run;
    long steps; /* of all runs before it */
    int rows, done;
    double *t, *seen, *phi, *rate; /* instants; of rows in the caller's order */
    double *block;
};

/**
 * Prepares the memory.
 *
 * all    non-zero: for orbits of driven pendulums and those that do not rest too.
 * check  out; ends with pend_orbit_check_clear whatever is returned.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_init(struct orbit_check *check, int n, int all);

/** Frees the memory. */
void pend_orbit_check_clear(struct orbit_check *check);

/** Returns the bytes of pend_orbit_check_init and of a run. O(1). */
double pend_orbit_check_bytes(int n, int all);

/**
 * Begins with the orbit that was set.
 *
 * motion  of pend_orbit_form_set.
 *
 * PEND_NO_MEMORY, PEND_INVALID
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_begin(struct orbit_check *check,
                                                        const struct orbit_form *form,
                                                        const struct pend_problem *motion,
                                                        struct pend_error *error);

/**
 * Goes on with the motion.
 *
 * work  as of pend_run_next.
 * done  out, non-zero once closure, divisor and amplitude are known.
 *
 * The failures of pend_run_next.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_check_next(struct orbit_check *check,
                                                       const struct orbit_form *form, double work,
                                                       int *done, struct pend_error *error);

#endif
