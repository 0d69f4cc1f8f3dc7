/* A motion together with its derivatives with respect to parameters and initial values. It solves
 * the variational equations by power series in numbers with derivatives.
 * Leaves to others: names of parameters (api), motions without derivatives (run).
 * Invariant: arrays of results are in the CALLER's order of arms, the last axis is the parameter;
 * the same problem gives the same bits, whatever the sizes of the blocks. */
#pragma once

#include "core/derivatives/derived_rows.h"
#include "core/derivatives/parameter.h"
#include "core/integrate/methods/method.h"

struct pend_derivatives;

/**
 * Prepares a motion with derivatives; no step is taken yet.
 *
 * derivatives  out; NULL on failure; released by pend_derivatives_free.
 * problem      copied, except its tree, loads, terms and list of instants, which must outlive the
 *              result. rtol and atol are those of the taylor method, for the motion and for every
 *              derivative; accuracy, step and no_drift are ignored.
 * count        number of parameters, >= 1.
 * parameter    copied.
 *
 * PEND_INVALID    as in pend_run_new.
 * PEND_NO_MEMORY  O(n (order + count)), one allocation and the terms of an ideal pendulum.
 */
PEND_MUST_CHECK enum pend_status pend_derivatives_new(struct pend_derivatives **derivatives,
                                                      const struct pend_problem *problem, int count,
                                                      const struct pend_parameter parameter[],
                                                      struct pend_error *error);
void pend_derivatives_free(struct pend_derivatives **derivatives);

/**
 * Continues until `cap` rows are complete, the last instant is reached or `work` is used up.
 *
 * rows   row 0 belongs to the first instant without a row. Whole turns of a huge start are removed
 *        from angles (turns.h).
 * cap    >= 1.
 * work   approximate number of arm-evaluations in doubles that this call may take; it takes at
 *        least one step or completes one row.
 * made   out: number of completed rows, also on failure; it can be 0.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  error contains the time. Later calls
 * return the same failure. No allocation.
 */
PEND_MUST_CHECK enum pend_status pend_derivatives_next(struct pend_derivatives *derivatives,
                                                       const struct pend_derived_rows *rows,
                                                       long cap, double work, long *made,
                                                       struct pend_error *error);

/**
 * Computes the results for a single state, whose angles and rates are the parameters of kinds PHI
 * and RATE.
 *
 * phi, phi_low, rate  n values each, stored order; phi_low may be NULL.
 * time                s, the time at which drives are evaluated.
 * row                 out: index of the row that receives the results.
 *
 * Does not change the motion. Values that overflow are not finite. O(n count), no allocation.
 */
void pend_derivatives_state(struct pend_derivatives *derivatives, const double phi[],
                            const double phi_low[], const double rate[], double time,
                            const struct pend_derived_rows *rows, long row);

/** Returns the fraction of the time span for which rows are complete, 0 .. 1. O(1). */
double pend_derivatives_progress(const struct pend_derivatives *derivatives);

/** Returns the number of steps so far. O(1). */
long pend_derivatives_steps(const struct pend_derivatives *derivatives);

/** Returns an upper bound of the bytes that pend_derivatives_new allocates. O(harmonics). */
double pend_derivatives_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                              int count);

/**
 * Saves the state of a motion between two calls of pend_derivatives_next to a checkpoint, or
 * restores it. A motion created for the same problem and restored continues with the same bits. The
 * motion must not have failed.
 *
 * PEND_INVALID  the restored state does not belong to such a motion, which can then only be freed.
 */
PEND_MUST_CHECK enum pend_status pend_derivatives_carry(struct pend_derivatives *derivatives,
                                                        struct pend_checkpoint *checkpoint);
