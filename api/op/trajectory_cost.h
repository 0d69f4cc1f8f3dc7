/* The estimated time and memory of a trajectory.
 * Leaves to others: the limits (op), the computation (op_trajectories).
 * Invariant: bytes are an upper bound; seconds are an estimate. */
#pragma once

#include "api/op/events_json.h"
#include "api/op/samples.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "api/read/times_json.h"

/* the time of a comparison with 32 digits, relative to that of the trajectory */
#define API_TRAJECTORY_TRUST_TIMES 26

/* The parts of a request that determine its cost. */
struct api_trajectory_size {
    const struct api_tree *tree;
    const struct api_states *start;
    const struct api_times *times;
    const struct api_method *method;
    const struct api_derived *derived;
    const struct api_events *events;
    const struct api_table *table;
    const struct api_format *format;
    int trusts; /* whether the motion is compared with 32 digits */
    long step_cap;
};

/** Returns the estimated time of computation, s. O(n + harmonics). */
double api_trajectory_cost_seconds(struct api_trajectory_size size);

/** Returns a way to shorten the computation, "ask for ..."; NULL if that is a shorter time or a
 * looser tolerance. O(n + harmonics). */
const char *api_trajectory_way_out(struct api_trajectory_size size);

/** If friction caused most of `steps` steps, writes a warning into `text`, with a method that would
 * take far fewer, and returns non-zero. Otherwise returns 0 and writes nothing. O(n +
 * harmonics). */
int api_trajectory_stiff(struct api_trajectory_size size, long steps, char text[API_WARNING_TEXT]);

/** Returns an upper bound of the bytes of memory. O(harmonics). */
double api_trajectory_cost_bytes(struct api_trajectory_size size);
