#include "api/op.h"

#include <stddef.h>

static const double turn_seconds = 0.005;

double api_turn_seconds(const struct api_turn *turn) {
    return turn->now ? turn->earlier + (turn->now(turn->context) - turn->begun) : -1;
}

int api_turn_over(const struct api_turn *turn) {
    return !turn->now || turn->now(turn->context) - turn->begun >= turn_seconds;
}

static const struct api_op *const ops[API_OP_COUNT] = {
    [API_OP_TREES] = &api_op_trees, [API_OP_TRAJECTORIES] = &api_op_trajectories, [API_OP_FORCES] = &api_op_forces,
    [API_OP_MODES] = &api_op_modes, [API_OP_PRESETS] = &api_op_presets,           [API_OP_PRESET] = &api_op_preset,
};

const struct api_op *api_op_at(enum api_op_id id) { return id >= 0 && id < API_OP_COUNT ? ops[id] : NULL; }
