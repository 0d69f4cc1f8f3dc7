/* The loop over the pieces of a motion, as a method that uses another method.
 * Leaves to others: the steps inside a piece (core/integrate/methods), the rules (rule_*).
 * Invariant: no step crosses the end of a piece; the loop is used only for pendulums with rules. */
#pragma once

#include "core/bodies/bodies.h"
#include "core/integrate/methods/method.h"
#include "core/tree/rules.h"

/**
 * Returns the method that computes a pendulum's motion in pieces by steps of `method`; `method`
 * itself for a pendulum without rules; NULL if `method` does not support pieces. In 32 digits
 * pieces end at known instants only: joints that hold, stick or hit a stop are not supported. O(1).
 *
 * At an instant at which a piece ends, its `at` fills in the state before the change.
 */
const struct pend_method *pend_pieces_method(const struct pend_method *method,
                                             const struct pend_terms *terms);

/** Returns non-zero if no joint of a pendulum may hold, stick or hit a stop: the series of every
 * step is that of the whole pendulum. O(1). */
static inline int pend_pieces_smooth(const struct pend_terms *terms) {
    return !terms || !terms->rules || !pend_rules_joints(terms->rules);
}

/** Returns NULL if errors grow as in the linearized equations: for a pendulum that is
 * pend_pieces_smooth and has no controllers, whose outputs depend on the errors; otherwise a
 * sentence that says why they are not estimated. O(1). */
const char *pend_pieces_unestimated(const struct pend_terms *terms);

/** Returns PEND_INVALID if `what` does not support the pendulum, because joints may hold, stick or
 * hit a stop or because it has controllers; the error names `what`. O(1). */
PEND_MUST_CHECK enum pend_status pend_pieces_check_smooth(const struct pend_terms *terms,
                                                          const char *what,
                                                          struct pend_error *error);

/** Returns the loads of the current piece, whose values change from piece to piece; for a stepper
 * of another method those of the problem. They are valid as long as the stepper. O(1). */
struct pend_loads pend_pieces_loads(const struct pend_method *method, const void *stepper,
                                    const struct pend_loads *loads);

/** Returns non-zero if the last step ended a piece. O(1). */
int pend_pieces_ends(const struct pend_method *method, const void *stepper);

/** Returns the state of a motion's controllers (control.h); NULL without controllers. It is valid
 * as long as the stepper. O(1). */
const double *pend_pieces_control(const struct pend_method *method, const void *stepper);

/** Returns +1 or -1 if joint k hits its upper or lower stop at the end of the last step; else 0.
 * O(1). */
int pend_pieces_struck(const struct pend_method *method, const void *stepper, int k);

/** Fills in rows as a method's `at` does. */
void pend_pieces_at(void *stepper, const double t[], int count, const struct pend_points *points);

/**
 * Computes the last step's series for all arms of a pendulum that is not pend_pieces_smooth.
 *
 * series  as the method's `series` gives it.
 * rate    out, coefficient j of arm k at [j n + k], j = 0 .. order, as those of the jets.
 * phi, phi_low  out, n values each, at the start of the step.
 *
 * O(n order).
 */
void pend_pieces_series(const void *stepper, const struct pend_series *series, double rate[],
                        double phi[], double phi_low[]);

/**
 * Computes accelerations and forces of a state inside the last step, or at the start, of a pendulum
 * that is not pend_pieces_smooth.
 *
 * time    s, in the time of the drives.
 * acc     out, n values.
 * forces  out, as in pend_bodies_at.
 */
void pend_pieces_forces(void *stepper, double time, const double phi[], const double rate[],
                        double acc[], const struct bodies_forces *forces);
