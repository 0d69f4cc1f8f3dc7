/* GET /v1/presets and /v1/presets/{name}: predefined pendulums, as complete requests.
 * Leaves to others: the pendulums themselves (core/tree/presets, presets_real).
 * Invariant: pendulum, initial and times of a preset are the body of a good request to
 * /v1/trajectories. */
#include "api/op/op.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_in.h"
#include "api/json/did_you_mean.h"
#include "api/json/json_out.h"
#include "api/op/presets_real.h"
#include "core/tree/presets.h"

struct presets {
    int only; /* the requested preset, or -1: all; the real ones follow the ideal ones */
    struct pend_preset preset;
};

static enum pend_status presets_read(void *state, const struct api_reading *reading) {
    (void)reading;
    ((struct presets *)state)->only = -1;
    return PEND_OK;
}

static int presets_count(void) {
    int count = pend_preset_count();
    for (int i = 0; api_preset_real(i); i++) count++;
    return count;
}

/* the name of preset i; an ideal one is copied to `scratch` */
static const char *preset_name(int i, struct pend_preset *scratch) {
    int ideal = pend_preset_count();
    assert(i >= 0 && i < presets_count());
    if (i >= ideal) return api_preset_real(i - ideal)->name;
    pend_preset_get(i, scratch);
    return scratch->name;
}

static int preset_find(const char *name) {
    int found = pend_preset_find(name);
    for (int i = 0; found < 0 && api_preset_real(i); i++)
        if (!strcmp(name, api_preset_real(i)->name)) found = pend_preset_count() + i;
    return found;
}

/* sets a problem of status 404 with the most similar name */
static enum pend_status refuse_name(const char *name, struct api_problem *problem) {
    int count = presets_count();
    struct pend_preset scratch;
    const char **names = calloc((size_t)count + 1, sizeof *names);
    enum pend_status status = names ? PEND_INVALID : PEND_NO_MEMORY;
    if (status == PEND_INVALID) {
        for (int i = 0; i < count; i++) names[i] = preset_name(i, &scratch);
        const char *near = api_name_nearest(name, names);
        if (near)
            api_problem_set(problem, 404, "there is no preset \"%s\"; did you mean \"%s\"?", name,
                            near);
        else
            api_problem_set(problem, 404, "there is no preset \"%s\"; /v1/presets lists them",
                            name);
    }
    free(names);
    return status;
}

static enum pend_status preset_read(void *state, const struct api_reading *reading) {
    const char *name = reading->argument ? reading->argument : "";
    int found = ((struct presets *)state)->only = preset_find(name);
    return found < 0 ? refuse_name(name, reading->problem) : PEND_OK;
}

static enum pend_status write_head(const char *name, const char *title, const char *description,
                                   int n, struct api_buffer *out) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "name", name));
    PEND_TRY(api_out_text(out, "title", title));
    PEND_TRY(api_out_text(out, "description", description));
    return api_out_whole(out, "n", n);
}

/* the last members of a preset */
static enum pend_status write_times(double stop, double step, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "times", '{'));
    PEND_TRY(api_out_number(out, "start", 0, 0));
    PEND_TRY(api_out_number(out, "stop", stop, 0));
    PEND_TRY(api_out_number(out, "step", step, 0));
    return api_buffer_text(out, "}}");
}

static enum pend_status write_real(const struct api_preset_real *preset, struct api_buffer *out) {
    PEND_TRY(write_head(preset->name, preset->title, preset->description, preset->n, out));
    PEND_TRY(api_out_key(out, "pendulum"));
    PEND_TRY(api_buffer_text(out, preset->pendulum));
    PEND_TRY(api_out_key(out, "initial"));
    PEND_TRY(api_buffer_text(out, preset->initial));
    return write_times(preset->stop, preset->step, out);
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

static enum pend_status write_ideal(const struct pend_preset *preset, struct api_buffer *out) {
    PEND_TRY(write_head(preset->name, preset->title, preset->description, preset->n, out));
    PEND_TRY(write_pendulum(preset, out));
    PEND_TRY(api_out_open(out, "initial", '{'));
    PEND_TRY(api_out_numbers(out, "phi", preset->n, preset->phi, 0));
    PEND_TRY(api_out_numbers(out, "phid", preset->n, preset->rate, 0));
    PEND_TRY(api_buffer_text(out, "}"));
    return write_times(preset->stop, preset->step, out);
}

static enum pend_status write_preset(int i, struct pend_preset *scratch, struct api_buffer *out) {
    int ideal = pend_preset_count();
    if (i >= ideal) return write_real(api_preset_real(i - ideal), out);
    pend_preset_get(i, scratch);
    return write_ideal(scratch, out);
}

static enum pend_status presets_run(void *state, const struct api_turn *turn, int *done,
                                    struct pend_error *error) {
    struct presets *presets = state;
    (void)error;
    *done = 1;
    if (presets->only >= 0) return write_preset(presets->only, &presets->preset, turn->out);
    PEND_TRY(api_buffer_text(turn->out, "{\"presets\":["));
    for (int i = 0; i < presets_count(); i++)
        PEND_TRY(write_preset(i, &presets->preset, turn->out));
    return api_buffer_text(turn->out, "]}");
}

const struct api_op api_op_presets = {
    .name = "presets", .size = sizeof(struct presets), .read = presets_read, .run = presets_run};

const struct api_op api_op_preset = {
    .name = "preset", .size = sizeof(struct presets), .read = preset_read, .run = presets_run};
