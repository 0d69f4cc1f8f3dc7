/* The observables of an ensemble's members: names, columns, and the position of each number in a
 * raw row.
 * Leaves to others: computing them (core/ensemble/ensemble), writing rows into an answer
 * (ensemble).
 * Invariant: a raw row has the numbers of the table's columns in their order, with arms in the
 * caller's order. */
#pragma once

#include "api/encode/encode.h"
#include "api/op/derived.h"
#include "api/op/ensemble/member_samples.h"
#include "api/op/ensemble/members_fill.h"
#include "api/read/field.h"
#include "core/ensemble/member.h"

enum api_observable {
    API_SEE_START,
    API_SEE_PARAMETERS,
    API_SEE_FINAL,
    API_SEE_FIRST_FLIP,
    API_SEE_FLIP_TIME,
    API_SEE_FLIPS,
    API_SEE_LAMBDA_MAX,
    API_SEE_LAMBDA_MIN,
    API_SEE_SIGN_CHANGE,
    API_SEE_ENERGY_DRIFT,
    API_SEE_LYAPUNOV,
    API_SEE_HORIZON,
    API_SEE_CART,
    API_SEE_SETTLED,
    API_SEE_TRAJECTORY,
    API_SEE_COUNT
};

struct api_observables {
    unsigned wanted; /* bit i: observable i is requested */
    unsigned output; /* bits of the outputs of a trajectory (member_samples) */
    struct api_table table;
    double within;                     /* rad, bound of API_SEE_SETTLED */
    int at[API_SEE_COUNT];             /* index of the first column of each requested observable */
    const struct api_members *members; /* the members, whose variations are reported as parameters;
                                        * not owned */
};

/**
 * Reads `observables`, and `output` for trajectories; the default is the final state.
 *
 * Every error is added to the problem.
 */
void api_observables_read(struct api_observables *seen, const struct api_value *root,
                          struct api_problem *problem);

/** Returns non-zero if the position of a cart is requested, as an observable or as an output of
 * trajectories. O(1). */
int api_observables_cart(const struct api_observables *seen);

/** Sets the columns for n arms; the number of rows is not changed. members: must outlive `seen`;
 * term values that vary are reported as parameters. */
void api_observables_columns(struct api_observables *seen, int n,
                             const struct api_members *members);

/**
 * Adds the columns of the derivatives of the final state and of a cart, or of the outputs of a
 * trajectory, after all others.
 *
 * Returns 0 if neither is requested: nothing else has derivatives.
 */
int api_observables_derived(struct api_observables *seen, struct api_derived *derived);

/** Returns the name of an observable. */
const char *api_observables_name(enum api_observable observable);

/** Sets the fields of an ensemble's problem so that it computes the requested observables and no
 * others. */
void api_observables_ask(const struct api_observables *seen, struct pend_ensemble_problem *problem);

/**
 * Writes the row of a member.
 *
 * member  number of the member, which is the first number of the row.
 * start   the start that was passed to the ensemble, in stored order.
 * row     out, api_table_numbers doubles.
 */
void api_observables_write(const struct api_observables *seen, const struct api_tree *tree,
                           long member, const struct pend_member *start,
                           const struct pend_outcome *outcome, double row[]);

/** Returns the end of a member for its row: the ensemble's status, or PEND_NOT_FINITE if a
 * requested energy or force is not finite. O(n). */
enum pend_status api_observables_end(const struct api_observables *seen,
                                     const struct api_tree *tree,
                                     const struct pend_outcome *outcome);

/** Returns the number of a status in the status column: 0 valid, 1 not finite, 2 step too small, 3
 * too many steps, 4 a start beyond a stop. */
int api_observables_status(enum pend_status status);
