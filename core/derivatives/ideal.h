/* The motion of an ideal pendulum, or of a suitable real one (ideal_loads), with its derivatives:
 * the fast kernels compute the motion once, and its derivatives in groups of eight. Leaves to
 * others: steps and rows (derivatives), arithmetic (jets, kernel_ideal). Invariant: one block of
 * the caller's memory; derivatives affect the motion only through the length of its steps. */
#pragma once

#include "core/derivatives/ideal_loads.h"
#include "core/derivatives/kernel_derivatives.h"
#include "core/derivatives/kernel_ideal.h"
#include "core/derivatives/parameter.h"
#include "core/integrate/methods/method.h"
#include "core/taylor/jets/jets.h"

struct ideal {
    struct pend_jets jets;
    struct pend_loads loads;
    struct jets_state begin, end;
    struct jets_values values; /* values of the motion at an instant */
    struct ideal_known known;
    struct ideal_group *group;
    const struct ideal_kernel *kernel;
    int groups;
    double unit, first; /* s: unit of the series; the first instant */
};

/** Returns the terms, or NULL if none is present. O(1). */
static inline const struct pend_terms *pend_ideal_terms(const struct pend_terms *terms) {
    return terms && (terms->count || terms->harmonics) ? terms : NULL;
}

/** Returns the bytes of a motion, including the structure at its start. O(n). */
size_t pend_ideal_bytes(const struct pend_tree *tree, const struct pend_terms *terms, int order,
                        int count);

/**
 * Prepares a motion; its start is stored as the end of a preceding step.
 *
 * ideal            at the beginning of pend_ideal_bytes(...) bytes, aligned to 64, not owned; must
 *                  not be moved.
 * parameter, seed  the parameter of each derivative and its unit: count of each.
 */
void pend_ideal_init(struct ideal *ideal, const struct pend_problem *problem, int order, int count,
                     const struct pend_parameter parameter[], const double seed[]);

/** Makes the end of a step the start of the next step. */
void pend_ideal_turn(struct ideal *ideal);

/** Expands about the start of a step, `since` s after the problem's first instant, in a unit of
 * time, s. Returns the step, in units, that the motion and all derivatives allow; NaN if a
 * coefficient is not finite. */
double pend_ideal_expand(struct ideal *ideal, double since, double unit, double log_rtol,
                         double log_atol);

/** Computes the state at the end of a step of x units. */
void pend_ideal_advance(struct ideal *ideal, double x);

/** Computes phi and rate, or all quantities if `all`, x units after the start, for pend_ideal_view.
 * For a real pendulum the forces are missing. */
void pend_ideal_values(struct ideal *ideal, double x, int all);

/** Copies the values, and eight derivatives from number `first` on, to a view. */
void pend_ideal_view(const struct ideal *ideal, int first, const struct derivatives_view *view);

/** Saves the state to a checkpoint, or restores it. */
void pend_ideal_carry(struct ideal *ideal, struct pend_checkpoint *checkpoint);
