#include "api/op/fit/fits_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/fit/fits_camera.h"
#include "api/op/fit/fits_data.h"
#include "api/op/fit/fits_start.h"
#include "api/op/fit/fits_terms.h"
#include "api/op/fit/fits_unknowns.h"

static const double pi = 3.14159265358979323846;

static const char *const fields[] = {"pendulum", "initial", "start", "data",       "camera", "loss",
                                     "unknowns", "fixed",   "rtol",  "iterations", NULL};
static const char *const losses[] = {"linear", "soft_l1", "huber", "cauchy", NULL};

/* with normal noise, a knee at this many standard deviations keeps 95 % of the efficiency of least
 * squares */
static const double fit_knees[] = {0, 1.345, 1.345, 2.385};

void api_fit_clear(struct api_fit *fit) {
    free(fit->t);
    free(fit->of);
    free(fit->row);
    free(fit->data);
    free(fit->each);
    free(fit->length);
    free(fit->bare);
    free(fit->parent);
    api_buffer_clear(&fit->tables);
    api_states_free(&fit->start);
    api_tree_clear(&fit->tree);
    fit->t = fit->data = fit->each = fit->length = NULL;
    fit->of = NULL;
    fit->row = NULL;
    fit->bare = NULL;
    fit->parent = NULL;
}

/* ---- all of it */

/* the pendulum's own numbers in the caller's order */
static enum pend_status fit_arms(struct api_fit *fit) {
    size_t n = (size_t)fit->tree.n;
    fit->length = malloc(2 * n * sizeof(double));
    fit->bare = malloc(n);
    fit->parent = malloc(n * sizeof(int));
    if (!fit->length || !fit->bare || !fit->parent) return PEND_NO_MEMORY;
    fit->mass = fit->length + n;
    for (int i = 0; i < fit->tree.n; i++) {
        int k = fit->tree.tree->place[i];
        fit->length[i] = fit->tree.tree->len[k], fit->mass[i] = fit->tree.tree->mass[k];
        fit->bare[i] = fit->mass[i] == 0, fit->parent[i] = api_tree_parent(&fit->tree, i);
    }
    return PEND_OK;
}

/* rows further apart than this many swings suggest another unit of time */
enum { MANY_ROWS = 10, FEW_SWINGS = 10 };

/* refuses times so far apart that they are probably in another unit */
static void fit_apart(const struct api_fit *fit, const struct api_value *data,
                      struct api_problem *problem) {
    double apart = fit->rows > 1 ? fit->t[fit->rows - 1] - fit->t[0] : 0, swing = 0;
    for (int k = 0; k < fit->tree.n; k++) swing += fit->length[k] / fit->tree.n;
    apart /= (double)(fit->rows > 1 ? fit->rows - 1 : 1);
    swing = 2 * pi * sqrt(swing / fabs(fit->tree.loads.gravity));
    if (fit->rows >= MANY_ROWS && apart > FEW_SWINGS * swing)
        api_value_fault(data, problem,
                        API_CODE_OUT_OF_RANGE "has instants %.4g s apart, which is %.3g swings of "
                                              "this pendulum: are they in ms? They must be in s",
                        apart, apart / swing);
}

/* at least as many measurements as unknowns, counted from the start */
static void fit_check(const struct api_fit *fit, const struct api_value *root,
                      struct api_problem *problem) {
    struct api_value data = api_value_member(root, "data"), start = api_value_member(root, "start");
    long count = 0;
    for (long i = 0; i < fit->rows * fit->columns; i++) count += !isnan(fit->data[i]);
    if (fit->runs == 1) fit_apart(fit, &data, problem);
    if (count < fit->unknowns)
        api_value_fault(&data, problem,
                        API_CODE_WRONG_COUNT
                        "has %ld measurements, too few for %d unknowns: there must be as many",
                        count, fit->unknowns);
    for (int r = 0; r < fit->runs; r++) {
        struct api_value runs = api_value_member(&data, "runs"), run = api_value_item(&runs, r);
        struct api_value own = api_value_member(&run, "start");
        long row = 0;
        while (fit->of[row] != r) row++;
        double first = fit->t[row] + fit->camera[PEND_FIT_SHIFT];
        if (fit->run[r].begins && fit->begin[r] > first)
            api_value_fault(api_value_kind(&runs) == API_MISSING ? &start : &own, problem,
                            API_CODE_ORDER "must not be after the first instant, %.9g s", first);
    }
}

enum pend_status api_fit_read(struct api_fit *fit, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value rtol = api_value_member(root, "rtol"),
                     most = api_value_member(root, "iterations"),
                     loss = api_value_member(root, "loss"),
                     camera = api_value_member(root, "camera"),
                     shift = api_value_member(&camera, "shift"),
                     unknowns = api_value_member(root, "unknowns"),
                     fixed = api_value_member(root, "fixed");
    *fit = (struct api_fit){.rtol = 1e-10, .iterations = 300};
    fit->step_cap = (long)reading->limits->steps;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &fit->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK) PEND_TRY(fit_arms(fit));
    if (status == PEND_OK) PEND_TRY(api_fit_give_terms(&fit->tree, &unknowns));
    (void)api_value_read_number(&rtol, 1e-14, 1e-3, "", &fit->rtol, problem);
    (void)api_field_whole(&most, 1, 10000, &fit->iterations, problem);
    (void)api_field_word(&loss, losses, &fit->loss, problem);
    // the cart was already refused with the pendulum
    if (pend_terms_cart(fit->tree.loads.terms)) return PEND_INVALID;
    status = api_fit_read_data(fit, api_value_number(&shift), reading);
    if (status == PEND_NO_MEMORY) return status;
    api_fit_read_unknowns(fit, &unknowns, problem);
    api_fit_read_camera(fit, &camera, problem);
    if (!problem->status && !fit->unknowns)
        api_value_fault(&unknowns, problem,
                        API_CODE_MISSING
                        "must name at least one unknown, of the pendulum or of the camera");
    if (!problem->status) PEND_TRY(api_fit_settle(fit, &fixed, problem));
    if (!problem->status) fit_check(fit, root, problem);
    if (problem->status) return PEND_INVALID;
    return PEND_OK;
}

int api_fit_bend(struct api_fit *fit, const struct pend_fit_result *result) {
    int fresh = 0;
    for (int c = 0; c < fit->columns - fit->modes && fit->loss; c++) {
        double spread = pend_fit_known(&fit->column[c]) ? 1 : result ? result->spread[c] : 0;
        double knee = fit_knees[fit->loss] * spread;
        fresh |= isfinite(knee) && fabs(knee - fit->knee[c]) > 0.01 * fit->knee[c];
        if (isfinite(knee)) fit->knee[c] = knee;
    }
    for (int j = 0; j < fit->unknowns && fresh && result; j++)
        fit->unknown[j].start = result->value[j];
    return fresh;
}

enum pend_status api_fit_put(struct api_fit *fit, const double value[]) {
    assert(fit->length && fit->parent && value);
    const int *order = fit->tree.tree->order;
    for (int j = 0; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *u = &fit->unknown[j];
        if (u->camera >= PEND_FIT_CAMERA) {
            fit->offset[u->camera - PEND_FIT_CAMERA] = value[j];
            continue;
        }
        if (u->camera >= 0) {
            fit->camera[u->camera] = value[j];
            continue;
        }
        double *array[] = {[PEND_PARAMETER_PHI] = fit->start->phi,
                           [PEND_PARAMETER_RATE] = fit->start->rate,
                           [PEND_PARAMETER_LENGTH] = fit->length,
                           [PEND_PARAMETER_MASS] = fit->mass,
                           [PEND_PARAMETER_GRAVITY] = &fit->tree.loads.gravity,
                           [PEND_PARAMETER_TERM] = fit->tree.value};
        int own = u->by.kind == PEND_PARAMETER_LENGTH || u->by.kind == PEND_PARAMETER_MASS;
        int start = u->by.kind <= PEND_PARAMETER_RATE;
        array[u->by.kind][own     ? order[u->by.at]
                          : start ? u->run * fit->start->n + u->by.at
                                  : u->by.at] = value[j];
    }
    struct pend_tree *tree;
    PEND_TRY(pend_tree_new_bare(&tree, fit->tree.n, fit->length, fit->mass, fit->bare, fit->parent,
                                NULL));
    pend_tree_free(&fit->tree.tree);
    fit->tree.tree = tree;
    return PEND_OK;
}
