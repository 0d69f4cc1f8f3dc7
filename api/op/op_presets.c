/* GET /v1/presets and /v1/presets/{name}: ready pendulums, as requests that can be sent as they
 * are.
 * Leaves to others: the pendulums themselves (core/tree/presets).
 * Invariant: pendulum, initial and times of a preset are the body of a good request to
 * /v1/trajectories. */
#include "api/op/op.h"

#include <stdlib.h>

#include "api/json/json_in.h"
#include "api/json/json_out.h"
#include "core/tree/presets.h"

struct presets {
    int only; /* the preset asked for, or -1: all */
    struct pend_preset preset;
};

static void presets_free(void **state) {
    free(*state);
    *state = NULL;
}

static enum pend_status presets_new(void **state, int only) {
    struct presets *presets = malloc(sizeof *presets);
    *state = presets;
    if (!presets) return PEND_NO_MEMORY;
    presets->only = only;
    return PEND_OK;
}

static enum pend_status presets_read(void **state, const struct api_reading *reading) {
    (void)reading;
    return presets_new(state, -1);
}

/* states a problem of status 404 with the name that was probably meant */
static enum pend_status refuse_name(const char *name, struct api_problem *problem) {
    int count = pend_preset_count();
    struct pend_preset *presets = malloc((size_t)count * sizeof *presets);
    const char **names = calloc((size_t)count + 1, sizeof *names);
    enum pend_status status = presets && names ? PEND_INVALID : PEND_NO_MEMORY;
    if (status == PEND_INVALID) {
        for (int i = 0; i < count; i++) {
            pend_preset_get(i, &presets[i]);
            names[i] = presets[i].name;
        }
        const char *near = api_name_nearest(name, names);
        if (near)
            api_problem_set(problem, 404, "there is no preset \"%s\"; did you mean \"%s\"?", name,
                            near);
        else
            api_problem_set(problem, 404, "there is no preset \"%s\"; /v1/presets lists them",
                            name);
    }
    free(names);
    free(presets);
    return status;
}

static enum pend_status preset_read(void **state, const struct api_reading *reading) {
    const char *name = reading->argument ? reading->argument : "";
    int found = pend_preset_find(name);
    *state = NULL;
    return found < 0 ? refuse_name(name, reading->problem) : presets_new(state, found);
}

static enum pend_status write_head(const struct pend_preset *preset, struct api_buffer *out) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "name", preset->name));
    PEND_TRY(api_out_text(out, "title", preset->title));
    PEND_TRY(api_out_text(out, "description", preset->description));
    return api_out_whole(out, "n", preset->n);
}

static enum pend_status write_pendulum(const struct pend_preset *preset, struct api_buffer *out) {
    double parent[PEND_PRESET_ARMS];
    for (int i = 0; i < preset->n; i++) parent[i] = preset->parent[i] + 1;
    PEND_TRY(api_out_open(out, "pendulum", '{'));
    PEND_TRY(api_out_numbers(out, "length", preset->n, preset->length, 0));
    PEND_TRY(api_out_numbers(out, "mass", preset->n, preset->mass, 0));
    PEND_TRY(api_out_numbers(out, "parent", preset->n, parent, 0));
    PEND_TRY(api_out_number(out, "gravity", preset->loads.gravity, 0));
    return api_buffer_text(out, "}");
}

static enum pend_status write_preset(const struct pend_preset *preset, struct api_buffer *out) {
    PEND_TRY(write_head(preset, out));
    PEND_TRY(write_pendulum(preset, out));
    PEND_TRY(api_out_open(out, "initial", '{'));
    PEND_TRY(api_out_numbers(out, "phi", preset->n, preset->phi, 0));
    PEND_TRY(api_out_numbers(out, "phid", preset->n, preset->rate, 0));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(api_out_open(out, "times", '{'));
    PEND_TRY(api_out_number(out, "start", 0, 0));
    PEND_TRY(api_out_number(out, "stop", preset->stop, 0));
    PEND_TRY(api_out_number(out, "step", preset->step, 0));
    return api_buffer_text(out, "}}");
}

static enum pend_status presets_run(void *state, const struct api_turn *turn, int *done,
                                    struct pend_error *error) {
    struct presets *presets = state;
    (void)error;
    *done = 1;
    if (presets->only >= 0) {
        pend_preset_get(presets->only, &presets->preset);
        return write_preset(&presets->preset, turn->out);
    }
    PEND_TRY(api_buffer_text(turn->out, "{\"presets\":["));
    for (int i = 0; i < pend_preset_count(); i++) {
        pend_preset_get(i, &presets->preset);
        PEND_TRY(write_preset(&presets->preset, turn->out));
    }
    return api_buffer_text(turn->out, "]}");
}

const struct api_op api_op_presets = {
    .name = "presets", .read = presets_read, .run = presets_run, .free = presets_free};

const struct api_op api_op_preset = {
    .name = "preset", .read = preset_read, .run = presets_run, .free = presets_free};
