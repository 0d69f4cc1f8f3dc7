/* What a trajectory costs before it is computed: time and memory, estimated.
 * Leaves to others: the limits that it is held against (op), the computation (op_trajectories).
 * Invariant: bytes are an upper bound; seconds are an estimate. */
#ifndef API_TRAJECTORY_COST_H
#define API_TRAJECTORY_COST_H

#include "api/op/events_json.h"
#include "api/op/samples.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "api/read/times_json.h"

/* how many times as long as the trajectory a comparison with 32 digits takes */
#define API_TRAJECTORY_TRUST_TIMES 26

/* What the cost depends on, as it was read. */
struct api_trajectory_size {
    const struct api_tree *tree;
    const struct api_states *start;
    const struct api_times *times;
    const struct api_method *method;
    const struct api_derived *derived;
    const struct api_events *events;
    const struct api_table *table;
    const struct api_format *format;
    int trusts; /* it is compared with 32 digits */
    long step_cap;
};

/** Returns the estimated time of computation, s. O(n + harmonics). */
double api_trajectory_cost_seconds(struct api_trajectory_size size);

/** Returns what would make it shorter, "ask for ..."; NULL: a shorter time or a looser tolerance.
 * O(n + harmonics). */
const char *api_trajectory_way_out(struct api_trajectory_size size);

/** Says in `text` that `steps` steps were so many because friction bounds those of the method most
 * of the time, and which method would take far fewer; returns 0, and says nothing, where it is not
 * so. O(n + harmonics). */
int api_trajectory_stiff(struct api_trajectory_size size, long steps, char text[API_WARNING_TEXT]);

/** Returns the most bytes of memory. O(harmonics). */
double api_trajectory_cost_bytes(struct api_trajectory_size size);

#endif
