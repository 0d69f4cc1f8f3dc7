#include "api/op/fit/fits_camera.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "api/op/varied.h"

static const char *const camera_fields[] = {"scale", "rotation", "origin", "shift",
                                            "tilt",  "stretch",  "center", "distortion",
                                            "down",  "unknown",  NULL};

int api_fit_instrument(const struct api_fit *fit, enum pend_fit_kind kind, int arm, int joint) {
    for (int c = 0; c < fit->columns - fit->modes; c++) {
        const struct pend_fit_column *column = &fit->column[c];
        int instrument = column->kind == PEND_FIT_PHI || column->kind == PEND_FIT_RATE ||
                         column->kind == PEND_FIT_ALONG || column->kind == PEND_FIT_ACROSS;
        if (instrument && column->kind == kind && column->arm == arm &&
            (joint < 0 || column->joint == joint))
            return c;
    }
    return -1;
}

void api_fit_label(const struct api_fit *fit, const char *name, int arm, int run,
                   char label[API_FIT_LABEL]) {
    int at = snprintf(label, API_FIT_LABEL, "%s", name);
    if (arm >= 0 && arm < fit->tree.cart)
        at += snprintf(label + at, API_FIT_LABEL - (size_t)at, " of the cart");
    else if (arm >= 0)
        at += snprintf(label + at, API_FIT_LABEL - (size_t)at, " of arm %d",
                       fit->tree.tree->order[arm] + 1);
    if (run >= 0 && fit->runs > 1)
        snprintf(label + at, API_FIT_LABEL - (size_t)at, " in run %d", run + 1);
}

static void camera_unknown(struct api_fit *fit, enum pend_fit_camera what) {
    if (fit->unknowns == API_FIT_UNKNOWNS) return;
    api_fit_label(fit, api_fit_camera_label(what), -1, -1, fit->label[fit->unknowns]);
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
            "applies to a single film: with several runs give each its \"time\", or leave it out");
        return;
    }
    if (fit->runs == 1 && !fit->run[0].begins) {
        api_value_fault(
            item, problem,
            API_CODE_CONFLICT
            "needs \"time\": without it the motion starts at the first instant, wherever that is");
        return;
    }
    for (int c = 0; c < fit->columns; c++)
        if (fit->column[c].kind >= PEND_FIT_ALONG && fit->column[c].kind != PEND_FIT_CART) {
            api_value_fault(item, problem,
                            API_CODE_CONFLICT "cannot be fitted to accelerations, amplitudes and "
                                              "periods: leave it out");
            return;
        }
    if (fit->t) camera_unknown(fit, PEND_FIT_SHIFT);
}

/* reads the flag that y counts downwards, as in images */
static void camera_down(struct api_fit *fit, const struct api_value *camera,
                        struct api_problem *problem) {
    struct api_value down = api_value_member(camera, "down");
    int downwards = 0;
    (void)api_field_truth(&down, &downwards, problem);
    for (int c = 0; c < fit->columns && downwards; c++)
        for (long i = 0; i < fit->rows && fit->column[c].kind == PEND_FIT_Y; i++)
            fit->data[c * fit->rows + i] *= -1;
}

/* the lens: its center, by default the middle of all positions, and the farthest position from it
 */
static void camera_center(struct api_fit *fit, const struct api_value *center,
                          struct api_problem *problem) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, far[2];
    for (int c = 0; c < fit->columns; c++)
        for (long i = 0; i < fit->rows; i++) {
            int at = fit->column[c].kind == PEND_FIT_Y;
            if (!at && fit->column[c].kind != PEND_FIT_X) break;
            low[at] = fmin(low[at], fit->data[c * fit->rows + i]);
            high[at] = fmax(high[at], fit->data[c * fit->rows + i]);
        }
    for (int k = 0; k < 2; k++) fit->center[k] = isfinite(low[k]) ? (low[k] + high[k]) / 2 : 0;
    (void)api_field_numbers(center, 2, "coordinate", fit->center, problem);
    for (int k = 0; k < 2; k++)
        far[k] = isfinite(low[k]) ? fmax(high[k] - fit->center[k], fit->center[k] - low[k]) : 0;
    fit->reach = hypot(far[0], far[1]) > 0 ? hypot(far[0], far[1]) : 1;
}

/* names of the camera's numbers in requests; the second of a pair is the next enum value */
static const struct {
    const char *name;
    enum pend_fit_camera what;
    int count;
    double low, high;
} parts[] = {{"scale", PEND_FIT_SCALE, 1, 1e-9, 1e9},
             {"rotation", PEND_FIT_ROTATION, 1, -10, 10},
             {"shift", PEND_FIT_SHIFT, 1, -1e9, 1e9},
             {"origin", PEND_FIT_ORIGIN_X, 2, 0, 0},
             {"tilt", PEND_FIT_TILT_X, 2, 0, 0},
             {"stretch", PEND_FIT_STRETCH, 1, -0.9, 9},
             {"distortion", PEND_FIT_DISTORTION, 1, -0.9, 9}};

enum { PARTS = sizeof parts / sizeof *parts };

const char *api_fit_camera_label(enum pend_fit_camera what) {
    static const char *const labels[] = {
        "scale of the camera",    "rotation of the camera", "origin x of the camera",
        "origin y of the camera", "shift of the camera",    "tilt x of the camera",
        "tilt y of the camera",   "stretch of the camera",  "distortion of the camera"};
    assert(what < sizeof labels / sizeof *labels);
    return labels[what];
}

/* a sought scale or origin that is not given is estimated from the data */
static void camera_left(struct api_fit *fit, enum pend_fit_camera what) {
    if (what == PEND_FIT_SCALE) fit->camera[PEND_FIT_SCALE] = NAN;
    if (what == PEND_FIT_ORIGIN_X)
        fit->camera[PEND_FIT_ORIGIN_X] = fit->camera[PEND_FIT_ORIGIN_Y] = NAN;
}

void api_fit_read_camera(struct api_fit *fit, const struct api_value *camera,
                         struct api_problem *problem) {
    const char *names[PARTS + 1] = {NULL};
    int given[PARTS], taken[PARTS] = {0};
    struct api_value unknown = api_value_member(camera, "unknown"),
                     center = api_value_member(camera, "center"), missing = {0};
    fit->camera[PEND_FIT_SCALE] = 1;
    camera_center(fit, &missing, problem);
    if (api_value_kind(camera) == API_MISSING || !api_field_object(camera, camera_fields, problem))
        return;
    camera_down(fit, camera, problem);
    camera_center(fit, &center, problem);
    for (int i = 0; i < PARTS; i++) {
        struct api_value value = api_value_member(camera, names[i] = parts[i].name);
        double *to = &fit->camera[parts[i].what];
        given[i] = api_value_kind(&value) != API_MISSING;
        if (parts[i].count == 2)
            (void)api_field_numbers(&value, 2, "coordinate", to, problem);
        else
            (void)api_value_read_number(&value, parts[i].low, parts[i].high, "", to, problem);
    }
    if (api_value_kind(&unknown) != API_MISSING && api_value_kind(&unknown) != API_ARRAY)
        api_value_fault(&unknown, problem, API_CODE_WRONG_TYPE "must be an array of names");
    API_VALUE_EACH (item, api_value_item(&unknown, 0)) {
        int which = 0;
        if (api_field_word(&item, names, &which, problem) <= 0) continue;
        if (taken[which]++) api_value_fault(&item, problem, API_CODE_DUPLICATE "occurs twice");
        if (!given[which]) camera_left(fit, parts[which].what);
        for (int k = 0; k < parts[which].count && parts[which].what != PEND_FIT_SHIFT; k++)
            camera_unknown(fit, parts[which].what + (enum pend_fit_camera)k);
        if (parts[which].what == PEND_FIT_SHIFT) camera_shift(fit, &item, problem);
    }
}

/* ---- the pendulum's unknowns, and those of instruments */

static const double pi = 3.14159265358979323846;

static const char *const unknown_fields[] = {"vary", "arm", "harmonic", "guess", "start",
                                             "run",  "low", "high",     "unit",  NULL};
static const char *const clock_fields[] = {"vary", "series", "guess", "low", "high", NULL};

/* the address of the number in the pendulum or its start */
static double target_value(const struct api_fit *fit, const struct api_target *target, int run) {
    const struct pend_tree *tree = fit->tree.tree;
    long of_run = (long)run * fit->start->n;
    switch (target->quantity) {
    case API_VARY_PHI:
    case API_VARY_THETA:
        return fit->start->phi[of_run + target->arm];
    case API_VARY_PHID:
    case API_VARY_THETAD:
        return fit->start->rate[of_run + target->arm];
    case API_VARY_LENGTH:
        return tree->len[target->arm];
    case API_VARY_MASS:
        return tree->mass[target->arm];
    case API_VARY_GRAVITY:
        return fit->tree.loads.gravity;
    case API_VARY_TERM:
        return fit->tree.value[target->place];
    default:
        break;
    }
    return 0;
}

/* 0 for numbers that must not be negative */
static double target_least(const struct api_fit *fit, const struct api_target *target) {
    if (target->quantity == API_VARY_LENGTH || target->quantity == API_VARY_MASS) return 0;
    if (target->quantity != API_VARY_TERM) return -INFINITY;
    return pend_terms_fits(fit->tree.terms, target->place, -1) ? -INFINITY : 0;
}

/* start and bounds in the request's unit; the fit's value is `scale` times that plus `shift` */
static void read_bounds(const struct api_value *item, double scale, double shift, int late,
                        struct pend_fit_unknown *u, struct api_problem *problem) {
    struct api_value start = api_field_renamed(item, "guess", "start", problem),
                     low = api_value_member(item, "low"), high = api_value_member(item, "high");
    double given;
    assert(scale > 0);
    // a start that is estimated from the data is not known yet
    if (late) u->start = NAN;
    if (api_value_read_number(&start, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->start = scale * given + shift;
    if (api_value_read_number(&low, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->low = fmax(u->low, scale * given + shift);
    if (api_value_read_number(&high, -INFINITY, INFINITY, "", &given, problem) > 0)
        u->high = scale * given + shift;
    int inside = u->low < u->high && !(u->start < u->low) && !(u->start > u->high);
    if (inside) return;
    api_value_fault(item, problem,
                    API_CODE_OUT_OF_RANGE
                    "starts at %.6g, which must lie between its bounds %.6g and %.6g: give it "
                    "another \"guess\"",
                    u->start - shift, u->low - shift, u->high - shift);
}

/* adds an unknown, and an error if it is listed already */
static void unknown_add(struct api_fit *fit, const struct api_value *item,
                        const struct pend_fit_unknown *u, struct api_problem *problem) {
    if (fit->unknowns + PEND_FIT_CAMERA >= API_FIT_UNKNOWNS) {
        api_value_fault(item, problem,
                        API_CODE_LIMIT
                        "exceeds the %d unknowns that are allowed in all runs together",
                        API_FIT_UNKNOWNS - PEND_FIT_CAMERA);
        return;
    }
    for (int j = 0; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *other = &fit->unknown[j];
        if (other->camera >= 0 && other->camera != u->camera) continue;
        if (other->camera != u->camera || other->by.kind != u->by.kind ||
            other->by.at != u->by.at || other->run != u->run)
            continue;
        api_value_fault(item, problem, API_CODE_DUPLICATE "is %s, which is in the list already",
                        fit->label[j]);
        return;
    }
    fit->unknown[fit->unknowns++] = *u;
}

/* the runs whose start contains the unknown: first .. last - 1 */
static int unknown_runs(const struct api_fit *fit, const struct api_value *item, int of_start,
                        int *first, int *last, struct api_problem *problem) {
    struct api_value run = api_value_member(item, "run");
    long chosen = 0;
    int given = api_field_whole(&run, 1, fit->runs, &chosen, problem);
    *first = given > 0 ? (int)chosen - 1 : 0;
    *last = !of_start ? 1 : given > 0 ? (int)chosen : fit->runs;
    if (given > 0 && !of_start)
        api_value_fault(
            &run, problem,
            API_CODE_NOT_APPLICABLE
            "is only for starts: any other number is the same in all runs, leave it out");
    return given >= 0 && (of_start || !given);
}

/* whether the number was identified; after the last error that is reported, further errors are only
 * counted */
static int target_found(const struct api_target *target) {
    if (target->quantity == API_VARY_TERM) return target->place >= 0;
    return target->arm >= 0 || target->quantity == API_VARY_GRAVITY;
}

/* reads the zero of an angle, or the bias of an angular velocity, which the instrument adds;
 * returns 0 for any other item */
static int read_instrument(struct api_fit *fit, const struct api_value *item,
                           struct api_problem *problem) {
    static const struct {
        const char *name;
        enum pend_fit_kind kind;
        const char *what;
    } names[] = {{"zero", PEND_FIT_PHI, "angles"},
                 {"bias", PEND_FIT_RATE, "angular velocities"},
                 {"bias_along", PEND_FIT_ALONG, "accelerations along the arm"},
                 {"bias_across", PEND_FIT_ACROSS, "accelerations across the arm"}};
    enum { NAMES = sizeof names / sizeof *names };
    struct api_value unit = api_value_member(item, "unit"), vary = api_value_member(item, "vary"),
                     arm = api_value_member(item, "arm");
    const char *name = api_value_text(&vary);
    int which = 0, degrees = 0;
    while (name && which < NAMES && strcmp(name, names[which].name) != 0) which++;
    if (!name || which == NAMES) return 0;
    (void)api_value_only(item, unknown_fields, problem);
    int at = api_tree_read_arm(&fit->tree, &arm, problem);
    (void)api_field_word(&unit, api_field_angles, &degrees, problem);
    if (problem->status || at < 0) return 1;
    int zero = api_fit_instrument(fit, names[which].kind, at, -1);
    if (zero < 0) {
        api_value_fault(&vary, problem,
                        API_CODE_NOT_APPLICABLE "needs measured %s of this arm, and there are none",
                        names[which].what);
        return 1;
    }
    struct pend_fit_unknown u = {
        .camera = PEND_FIT_CAMERA + zero, .low = -INFINITY, .high = INFINITY};
    read_bounds(item, degrees ? pi / 180 : 1, 0, 1, &u, problem);
    api_fit_label(fit, name, fit->tree.tree->place[at], -1, fit->label[fit->unknowns]);
    fit->shift[fit->unknowns] = 0;
    unknown_add(fit, item, &u, problem);
    return 1;
}

/* gives a series the clock of column `first`, or its own; returns the column, -1 on error */
static int read_series(struct api_fit *fit, const struct api_value *series, int first,
                       struct api_problem *problem) {
    long number = 0;
    if (!api_field_needed(series, problem)) return -1;
    if (api_field_whole(series, 1, fit->run[0].series, &number, problem) <= 0) return -1;
    struct pend_fit_column *column = &fit->column[number - 1];
    if (column->clock) api_value_fault(series, problem, API_CODE_DUPLICATE "has a shift already");
    if (column->kind >= PEND_FIT_ALONG && column->kind != PEND_FIT_CART)
        api_value_fault(series, problem,
                        API_CODE_NOT_APPLICABLE
                        "is of accelerations, amplitudes or periods, whose shift cannot be "
                        "computed: make that of the other series an unknown");
    if (first < 0) first = (int)number - 1;
    column->clock = 1 + API_FIT_SERIES + first;
    return first;
}

/* reads the shift of the clock of one or several series; returns 0 for other items */
static int read_clock(struct api_fit *fit, const struct api_value *item,
                      struct api_problem *problem) {
    struct api_value vary = api_value_member(item, "vary"),
                     series = api_value_member(item, "series"), one = api_value_item(&series, 0);
    const char *name = api_value_text(&vary);
    int list = api_value_kind(&one) != API_MISSING, first = -1;
    struct pend_fit_unknown u = {.low = -INFINITY, .high = INFINITY};
    if (!name || strcmp(name, "shift") != 0) return 0;
    (void)api_value_only(item, clock_fields, problem);
    if (problem->status) return 1;
    if (!list) first = read_series(fit, &series, -1, problem);
    for (; api_value_kind(&one) != API_MISSING; one = api_value_next(&one))
        first = read_series(fit, &one, first, problem);
    if (first < 0) return 1;
    u.camera = PEND_FIT_CAMERA + API_FIT_SERIES + first;
    read_bounds(item, 1, 0, 1, &u, problem);
    snprintf(fit->label[fit->unknowns], API_FIT_LABEL, "shift of series %d", first + 1);
    fit->shift[fit->unknowns] = 0;
    unknown_add(fit, item, &u, problem);
    return 1;
}

static void read_unknown(struct api_fit *fit, const struct api_value *item,
                         struct api_problem *problem) {
    struct api_value unit = api_value_member(item, "unit"), vary = api_value_member(item, "vary");
    struct api_target target;
    int degrees = 0, faults = problem->count;
    if (!api_field_object(item, unknown_fields, problem)) return;
    if (!api_target_read(&target, item, &fit->tree, problem) || problem->count > faults) return;
    if (!target_found(&target)) return;
    int angle = target.quantity <= API_VARY_THETAD;
    if (api_field_word(&unit, api_field_angles, &degrees, problem) > 0 && !angle)
        api_value_fault(&unit, problem,
                        API_CODE_NOT_APPLICABLE "is only for angles and their rates: leave it out");
    // bounds of theta are bounds of phi + pi / 2
    double scale = degrees ? pi / 180 : 1, shift = target.quantity == API_VARY_THETA ? -pi / 2 : 0;
    int first, last;
    if (!unknown_runs(fit, item, angle, &first, &last, problem)) return;
    for (int run = first; run < last && problem->count == faults; run++) {
        struct pend_fit_unknown u = {.camera = -1, .by = api_target_parameter(&target), .run = run};
        u.start = target_value(fit, &target, run), u.low = target_least(fit, &target);
        u.high = INFINITY;
        read_bounds(item, scale, shift, fit->run[run].guessed && angle, &u, problem);
        api_fit_label(fit, api_value_text(&vary), target.arm, angle ? run : -1,
                      fit->label[fit->unknowns]);
        fit->shift[fit->unknowns] = 0 - shift;
        unknown_add(fit, item, &u, problem);
    }
}

void api_fit_read_unknowns(struct api_fit *fit, const struct api_value *list,
                           struct api_problem *problem) {
    int count = api_value_count(list);
    if (api_value_kind(list) != API_MISSING &&
        (api_value_kind(list) != API_ARRAY || count > API_FIT_LISTED)) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be an array of at most %d unknowns",
                        API_FIT_LISTED);
        return;
    }
    struct api_value item = api_value_item(list, 0);
    for (; fit->start && api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        if (!read_clock(fit, &item, problem) && !read_instrument(fit, &item, problem))
            read_unknown(fit, &item, problem);
}
