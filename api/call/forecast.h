/* Forecasts whether a computation can end within its limits.
 * Leaves to others: running it (call), estimates before it starts (the operations).
 * Invariant: a running computation is judged only by the steps and seconds it has used. */
#pragma once

#include "api/op/op.h"

/* The state of the forecasts; all zero initially. */
struct api_forecast {
    double look_at; /* s of computation, the time of the next forecast */
    int looks;      /* number of forecasts */
};

/**
 * Forecasts before a computation starts, from its estimated time, s. The computation is refused if
 * even the estimate divided by the operation's uncertainty factor exceeds the limit.
 *
 * problem  out: the reason and the remedy.
 *
 * Returns 0 if it cannot end within the limits. O(1).
 */
int api_forecast_begins(const struct api_op *op, const void *state, const struct api_limits *limits,
                        double seconds, struct api_problem *problem);

/**
 * Forecasts during a computation, from the steps and the time used so far: first after 10 ms, then
 * whenever the time has doubled. Early forecasts have a larger tolerance, because a motion may
 * need more steps at its beginning; after 10 s the tolerance is 50 %, after 40 s 10 %. Operations
 * whose progress is unknown are never refused here.
 *
 * state    state of the operation, which is not complete.
 * seconds  computation time so far.
 * problem  out: the reason and the remedy.
 *
 * Returns 0 if it cannot end within the limits. O(1), plus the cost of the operation's `progress`.
 */
int api_forecast_good(struct api_forecast *forecast, const struct api_op *op, void *state,
                      const struct api_limits *limits, double seconds, struct api_problem *problem);
