/* Whether a computation that is under way can end within its limits.
 * Leaves to others: running it (call), the estimates of what has not begun (the operations).
 * Invariant: once it is under way it is judged by steps and seconds that were taken alone. */
#ifndef API_FORECAST_H
#define API_FORECAST_H

#include "api/op/op.h"

/* What was judged so far; all zero before the first turn. */
struct api_forecast {
    double look_at; /* s of turns after which the computation is judged again */
    int looks;      /* how often it was */
};

/**
 * Judges a computation before it begins, by its estimated time, s: what would take longer than the
 * limit even if the estimate were too long by the operation's doubt is refused.
 *
 * problem  out: what is wrong and the way out.
 *
 * Returns 0 if it cannot end within the limits. O(1).
 */
int api_forecast_begins(const struct api_op *op, const void *state, const struct api_limits *limits,
                        double seconds, struct api_problem *problem);

/**
 * Judges a computation after a turn, from the steps and the time that the part done so far has
 * taken: first after a hundredth of a second, then each time it has taken four times as long. A
 * motion may need more steps in its first part than later, so the first judgements allow more,
 * those from 10 s on half as much again; an operation that does not integrate has no even progress,
 * and is not judged.
 *
 * state    the operation's, which is not complete.
 * seconds  of all turns so far.
 * problem  out: what is wrong and the way out.
 *
 * Returns 0 if it cannot end within the limits. O(1), and what the operation's `progress` takes.
 */
int api_forecast_good(struct api_forecast *forecast, const struct api_op *op, void *state,
                      const struct api_limits *limits, double seconds, struct api_problem *problem);

#endif
