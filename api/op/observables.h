/* What can be found out about the members of an ensemble: names, columns, and where each number
 * stands in a raw row.
 * Leaves to others: finding it out (core/ensemble/ensemble), the rows' way into an answer
 * (ensemble).
 * Invariant: a raw row holds the numbers of the table's columns in their order, arms as the
 * caller counts. */
#ifndef API_OBSERVABLES_H
#define API_OBSERVABLES_H

#include "api/encode/encode.h"
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
    API_SEE_TRAJECTORY,
    API_SEE_COUNT
};

struct api_observables {
    unsigned wanted; /* bit i for observable i */
    unsigned output; /* of a trajectory: bits of phi, phid, theta, thetad, lambda */
    struct api_table table;
    int at[API_SEE_COUNT]; /* first column of each that is wanted */
};

/**
 * Reads `observables`, and `output` for trajectories; the final state where none is named.
 *
 * Every fault is added to the problem.
 */
void api_observables_read(struct api_observables *seen, const struct api_value *root,
                          struct api_problem *problem);

/** Sets the columns for n arms; the rows of the table are left alone. */
void api_observables_columns(struct api_observables *seen, int n);

/** The name of an observable. */
const char *api_observables_name(enum api_observable observable);

/** How an ensemble is to be run so that what is wanted is found out, at the least cost. */
void api_observables_ask(const struct api_observables *seen, struct pend_ensemble_problem *problem);

/**
 * The row of a member into `row`.
 *
 * member  its number, which is written first.
 * start   what it started from, as handed to the ensemble; stored order.
 */
void api_observables_write(const struct api_observables *seen, const struct pend_tree *tree,
                           long member, const struct pend_member *start,
                           const struct pend_outcome *outcome, double row[]);

/** One row of a trajectory: member, status 0, t, and the outputs from values in stored order. */
void api_observables_sample(const struct api_observables *seen, const struct pend_tree *tree,
                            long member, double t, const double phi[], const double rate[],
                            const double force[], const double theta[], double row[]);

/** The status column of a member that came to this end: 0 good, 1 not finite, 2 step too small, 3
 * too many steps. */
int api_observables_status(enum pend_status status);

#endif
