/* GET /v1/presets and /v1/presets/{name}: predefined pendulums, as complete requests.
 * Leaves to others: the pendulums themselves (presets.txt).
 * Invariant: pendulum, initial and times of a preset form a valid request to /v1/trajectories. */
#include "api/op/op.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "api/json/did_you_mean.h"
#include "api/json/json_out.h"
#include "api/op/presets_text.h"

static const char begins[] = "\n{\"name\":\"", between[] = "\n\n";

enum { PRESETS_MOST = 64, NAME_BYTES = 64 };

struct presets {
    const char *only; /* the requested preset; NULL = all */
};

/* the preset after `at`, or the first one if it is NULL; NULL after the last */
static const char *preset_next(const char *at) {
    return strstr(at ? at + 1 : api_presets_text, begins);
}

static void preset_name(const char *preset, char name[NAME_BYTES]) {
    const char *from = preset + sizeof begins - 1;
    int bytes = (int)strcspn(from, "\"");
    assert(bytes > 0 && bytes < NAME_BYTES);
    snprintf(name, NAME_BYTES, "%.*s", bytes, from);
}

static enum pend_status refuse_name(const char *name, struct api_problem *problem) {
    char known[PRESETS_MOST][NAME_BYTES];
    const char *names[PRESETS_MOST + 1] = {NULL}, *preset = NULL;
    for (int i = 0; i < PRESETS_MOST && (preset = preset_next(preset)); i++) {
        preset_name(preset, known[i]);
        names[i] = known[i];
    }
    const char *near = api_name_nearest(name, names);
    if (near)
        api_problem_set(problem, 404, "there is no preset \"%s\"; did you mean \"%s\"?", name,
                        near);
    else
        api_problem_set(problem, 404, "there is no preset \"%s\"; /v1/presets lists them", name);
    return PEND_INVALID;
}

static enum pend_status presets_read(void *state, const struct api_reading *reading) {
    (void)state;
    (void)reading;
    return PEND_OK;
}

static enum pend_status preset_read(void *state, const struct api_reading *reading) {
    const char *wanted = reading->argument ? reading->argument : "", *preset = NULL;
    char name[NAME_BYTES];
    while ((preset = preset_next(preset))) {
        preset_name(preset, name);
        if (!strcmp(name, wanted)) break;
    }
    ((struct presets *)state)->only = preset;
    return preset ? PEND_OK : refuse_name(wanted, reading->problem);
}

static enum pend_status write_preset(const char *preset, struct api_buffer *out) {
    const char *end = strstr(preset, between), *line = preset;
    if (!end) end = preset + strlen(preset);
    for (; line < end; line += strcspn(line, "\n")) {
        line++;
        PEND_TRY(api_buffer_add(out, line, strcspn(line, "\n")));
    }
    return PEND_OK;
}

static enum pend_status presets_run(void *state, const struct api_turn *turn, int *done,
                                    struct pend_error *error) {
    const char *preset = NULL, *only = ((struct presets *)state)->only;
    (void)error;
    *done = 1;
    if (only) return write_preset(only, turn->out);
    PEND_TRY(api_buffer_text(turn->out, "{\"presets\":["));
    while ((preset = preset_next(preset))) {
        PEND_TRY(api_out_comma(turn->out));
        PEND_TRY(write_preset(preset, turn->out));
    }
    return api_buffer_text(turn->out, "]}");
}

const struct api_op api_op_presets = {
    .name = "presets", .size = sizeof(struct presets), .read = presets_read, .run = presets_run};

const struct api_op api_op_preset = {
    .name = "preset", .size = sizeof(struct presets), .read = preset_read, .run = presets_run};
