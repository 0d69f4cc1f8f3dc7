/* Quantities of a motion as power series over one step of the Taylor method.
 * Leaves to others: the series of angles and forces (jets), what is looked for in them (events).
 * Invariant: series are in powers of the part s of the step, 0 .. 1, so that coefficients neither
 * overflow nor vanish.
 */
#ifndef PEND_EVENT_SERIES_H
#define PEND_EVENT_SERIES_H

#include "core/integrate/method.h"
#include "core/integrate/roots.h"

enum { EVENT_TERMS = PEND_ROOTS_DEGREE + 1 };

/* A step and the room for series of all arms. */
struct event_step {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    struct pend_series series;
    double time, length; /* s: its beginning in the time of the drives, and how long it is */
    int degree;          /* of places and energies, at least that of an angle */
    double *room; /* of pend_event_series_room numbers, for energies; NULL = none are wanted */
};

/** Numbers of the room that energies of n arms need. */
size_t pend_event_series_room(int n);

/** The angle of stored arm k, rad: coefficients 0 .. degree; the rest 0. O(order). */
void pend_event_series_phi(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Its rate, rad/s. */
void pend_event_series_rate(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** Its compression force, N; after pend_jets_forces. */
void pend_event_series_force(const struct event_step *step, int k, double out[EVENT_TERMS]);

/** The place of its tip, m. O(depth order^2). */
void pend_event_series_tip(const struct event_step *step, int k, double x[EVENT_TERMS],
                           double y[EVENT_TERMS]);

/** The square of the distance of two tips, m^2. O(depth order^2). */
void pend_event_series_square(const struct event_step *step, int k, int other,
                              double out[EVENT_TERMS]);

/** Kinetic and potential energy, J, of a pendulum without a cart; with room. O(n order^2). */
void pend_event_series_energy(const struct event_step *step, double kinetic[EVENT_TERMS],
                              double potential[EVENT_TERMS]);

#endif
