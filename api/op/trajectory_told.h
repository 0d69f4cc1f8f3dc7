/* The statistics about the digits of a trajectory: horizon, energy drift, and warnings in words.
 * Leaves to others: the computation (op_trajectories), how statistics are written (encode).
 * Invariant: the horizon does not contradict the exact comparison, if there is one. */
#pragma once

#include "api/encode/encode.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "core/integrate/run/run.h"

/* The texts, which must outlive the statistics. */
struct api_trajectory_told {
    char horizon[API_WARNING_TEXT], linear[API_WARNING_TEXT], energy[API_WARNING_TEXT],
        loose[API_WARNING_TEXT], control[API_WARNING_TEXT], degrees[API_WARNING_TEXT];
};

struct api_trajectory_motion {
    const struct api_tree *tree;
    const struct api_states *start;
    const struct pend_times *times;
    const struct api_method *method;
    double tolerance, trust_until; /* the comparison's tolerance, rad (0 = no comparison), and
                                    * result, s */
};

/** Adds horizon, energy_drift and the warnings to the statistics of a run that has ended. */
void api_trajectory_tell(struct api_trajectory_told *told,
                         const struct api_trajectory_motion *motion,
                         const struct pend_run_stats *run, struct api_stats *stats);
