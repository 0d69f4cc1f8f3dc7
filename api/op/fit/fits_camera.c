#include "api/op/fit/fits_camera.h"

#include <math.h>
#include <stdio.h>

static const char *const camera_fields[] = {"scale", "rotation", "origin", "shift",
                                            "down",  "unknown",  NULL};

int api_fit_instrument(const struct api_fit *fit, enum pend_fit_kind kind, int arm, int joint) {
    for (int c = 0; c < fit->columns - fit->modes; c++) {
        const struct pend_fit_column *column = &fit->column[c];
        int turns = column->kind == PEND_FIT_PHI || column->kind == PEND_FIT_RATE;
        if (turns && column->kind == kind && column->arm == arm &&
            (joint < 0 || column->joint == joint))
            return c;
    }
    return -1;
}

static void camera_unknown(struct api_fit *fit, enum pend_fit_camera what, const char *label) {
    if (fit->unknowns == API_FIT_UNKNOWNS) return;
    snprintf(fit->label[fit->unknowns], API_FIT_LABEL, "%s", label);
    // a measurement before the start belongs to no motion
    double low = what == PEND_FIT_SHIFT ? fit->begin[0] - fit->t[0] : -INFINITY;
    fit->unknown[fit->unknowns++] =
        (struct pend_fit_unknown){.camera = what,
                                  .start = fit->camera[what],
                                  .low = what == PEND_FIT_SCALE ? 0 : low,
                                  .high = INFINITY};
}

/* the time shift; it is meaningless if the start moves with the data */
static void camera_shift(struct api_fit *fit, const struct api_value *item,
                         struct api_problem *problem) {
    if (fit->runs > 1) {
        api_value_fault(
            item, problem,
            API_CODE_CONFLICT
            "applies to a single film: with several runs give each its \"start\", or leave it out");
        return;
    }
    if (fit->runs == 1 && !fit->run[0].begins) {
        api_value_fault(
            item, problem,
            API_CODE_CONFLICT
            "needs \"start\": without it the motion starts at the first instant, wherever that is");
        return;
    }
    for (int c = 0; c < fit->columns; c++)
        if (fit->column[c].kind == PEND_FIT_RATE) {
            api_value_fault(item, problem,
                            API_CODE_CONFLICT
                            "cannot be fitted to angular velocities yet: leave it out");
            return;
        }
    if (fit->t) camera_unknown(fit, PEND_FIT_SHIFT, "shift of the camera");
}

/* y counts downwards, as in images */
static void camera_down(struct api_fit *fit, const struct api_value *camera,
                        struct api_problem *problem) {
    struct api_value down = api_value_member(camera, "down");
    int downwards = 0;
    (void)api_field_truth(&down, &downwards, problem);
    for (int c = 0; c < fit->columns && downwards; c++)
        for (long i = 0; i < fit->rows && fit->column[c].kind == PEND_FIT_Y; i++)
            fit->data[c * fit->rows + i] *= -1;
}

/* a sought scale or origin that is not given is estimated from the data */
static void camera_left(struct api_fit *fit, int which) {
    if (which == 0) fit->camera[PEND_FIT_SCALE] = NAN;
    if (which == 3) fit->camera[PEND_FIT_ORIGIN_X] = fit->camera[PEND_FIT_ORIGIN_Y] = NAN;
}

void api_fit_read_camera(struct api_fit *fit, const struct api_value *camera,
                         struct api_problem *problem) {
    static const char *const names[] = {"scale", "rotation", "shift", "origin", NULL};
    struct api_value scale = api_value_member(camera, "scale"),
                     rotation = api_value_member(camera, "rotation"),
                     origin = api_value_member(camera, "origin"),
                     shift = api_value_member(camera, "shift"),
                     unknown = api_value_member(camera, "unknown");
    fit->camera[PEND_FIT_SCALE] = 1;
    if (api_value_kind(camera) == API_MISSING || !api_field_object(camera, problem)) return;
    (void)api_value_only(camera, camera_fields, problem);
    camera_down(fit, camera, problem);
    (void)api_value_read_number(&scale, 1e-9, 1e9, "", &fit->camera[PEND_FIT_SCALE], problem);
    (void)api_value_read_number(&rotation, -10, 10, "rad", &fit->camera[PEND_FIT_ROTATION],
                                problem);
    (void)api_value_read_number(&shift, -1e9, 1e9, "s", &fit->camera[PEND_FIT_SHIFT], problem);
    int given[] = {api_value_kind(&scale) != API_MISSING, 1, 1,
                   api_value_kind(&origin) != API_MISSING};
    (void)api_field_numbers(&origin, 2, "coordinate", fit->camera + PEND_FIT_ORIGIN_X, problem);
    if (api_value_kind(&unknown) != API_MISSING && api_value_kind(&unknown) != API_ARRAY)
        api_value_fault(&unknown, problem, API_CODE_WRONG_TYPE "must be an array of names");
    struct api_value item = api_value_item(&unknown, 0);
    for (int taken[4] = {0}; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        int which = 0;
        if (api_field_word(&item, names, &which, problem) <= 0) continue;
        if (taken[which]++) api_value_fault(&item, problem, API_CODE_DUPLICATE "occurs twice");
        if (!given[which]) camera_left(fit, which);
        if (which == 0) camera_unknown(fit, PEND_FIT_SCALE, "scale of the camera");
        if (which == 1) camera_unknown(fit, PEND_FIT_ROTATION, "rotation of the camera");
        if (which == 2) camera_shift(fit, &item, problem);
        if (which < 3) continue;
        camera_unknown(fit, PEND_FIT_ORIGIN_X, "origin x of the camera");
        camera_unknown(fit, PEND_FIT_ORIGIN_Y, "origin y of the camera");
    }
}
