#include "api/op/fit/fits_start.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"
#include "api/op/varied.h"
#include "core/fit/fit_start.h"

static const double pi = 3.14159265358979323846;

struct pend_fit_problem api_fit_problem(const struct api_fit *fit) {
    assert(fit->tree.tree && fit->start && fit->rows >= 1);
    struct pend_fit_problem problem = {.n = api_tree_stored(&fit->tree),
                                       .length = fit->length,
                                       .mass = fit->mass,
                                       .bare = fit->bare,
                                       .parent = fit->parent,
                                       .order = fit->tree.tree->order,
                                       .loads = fit->tree.loads,
                                       .phi = fit->start->phi,
                                       .rate = fit->start->rate,
                                       .runs = fit->runs,
                                       .start = fit->begin,
                                       .zeros = 2 * API_FIT_SERIES,
                                       .zero = fit->offset,
                                       .rows = fit->rows,
                                       .t = fit->t,
                                       .run = fit->runs > 1 ? fit->of : NULL,
                                       .columns = fit->columns,
                                       .column = fit->column,
                                       .unknowns = fit->unknowns,
                                       .unknown = fit->unknown,
                                       .loss = (enum pend_fit_loss)fit->loss,
                                       .knee = fit->loss ? fit->knee : NULL,
                                       .rtol = fit->rtol,
                                       .iterations = (int)fit->iterations,
                                       .step_cap = fit->step_cap};
    memcpy(problem.camera, fit->camera, sizeof fit->camera);
    memcpy(problem.center, fit->center, sizeof fit->center);
    problem.reach = fit->reach;
    return problem;
}

/* returns the index of the unknown for a number; -1 = none */
static int start_sought(const struct api_fit *fit, enum pend_parameter_kind kind, int at, int run) {
    for (int j = 0; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *u = &fit->unknown[j];
        int own = kind > PEND_PARAMETER_RATE || u->run == run;
        if (u->camera < 0 && u->by.kind == kind && u->by.at == at && own) return j;
    }
    return -1;
}

/* Estimates the starts that were not given. Arms without measurements hang at rest. `seen`, runs x
 * n, is set for each arm that is measured in a run. */
static void start_guess(struct api_fit *fit, unsigned char seen[]) {
    struct pend_fit_problem problem = api_fit_problem(fit);
    const struct pend_tree *tree = fit->tree.tree;
    for (int j = 0; j < fit->unknowns; j++) {
        int zero = fit->unknown[j].camera - PEND_FIT_CAMERA;
        double start = fit->unknown[j].start;
        if (zero < 0) continue;
        fit->offset[zero] = isnan(start) ? pend_fit_start_zero(&problem, zero) : start;
    }
    (void)pend_fit_start_camera(&problem, fit->camera);
    for (int i = 0; i < PEND_FIT_CAMERA; i++)
        if (isnan(fit->camera[i])) fit->camera[i] = i == PEND_FIT_SCALE;
    problem = api_fit_problem(fit);
    for (int r = 0; r < fit->runs; r++)
        for (int k = 0; k < tree->n && fit->run[r].guessed; k++) {
            long at = (long)r * fit->start->n + k;
            fit->start->phi[at] = k < fit->tree.cart ? 0 : -pi / 2;
            seen[at] = (unsigned char)pend_fit_start_state(
                &problem, r, tree->order[k], &fit->start->phi[at], &fit->start->rate[at]);
        }
}

static void start_unknowns(struct api_fit *fit) {
    for (int j = 0; j < fit->unknowns; j++) {
        struct pend_fit_unknown *u = &fit->unknown[j];
        if (!isnan(u->start)) continue;
        int angle = u->by.kind == PEND_PARAMETER_PHI;
        long at = (long)u->run * fit->start->n + u->by.at;
        u->start = u->camera >= PEND_FIT_CAMERA ? fit->offset[u->camera - PEND_FIT_CAMERA]
                   : u->camera >= 0             ? fit->camera[u->camera]
                                                : (angle ? fit->start->phi : fit->start->rate)[at];
        // an estimate outside the bounds is moved just inside the nearest bound
        if (!(u->start > u->low)) u->start = fmin(u->low + 1e-3, 0.5 * (u->low + u->high));
        if (!(u->start < u->high)) u->start = fmax(u->high - 1e-3, 0.5 * (u->low + u->high));
    }
}

/* copies fixed numbers of the request into the start, and marks in `seen` which are not fixed */
static void start_fixed(struct api_fit *fit, const struct api_value *list, unsigned char seen[],
                        struct api_problem *problem) {
    int before = fit->unknowns;
    long numbers = fit->start->count * fit->start->n;
    api_fit_read_unknowns(fit, list, problem);
    for (int j = before; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *u = &fit->unknown[j];
        if (u->camera >= 0 && !isnan(u->start)) fit->offset[u->camera - PEND_FIT_CAMERA] = u->start;
        if (u->camera >= 0 || u->by.kind > PEND_PARAMETER_RATE) continue;
        int rate = u->by.kind == PEND_PARAMETER_RATE;
        long at = (long)u->run * fit->start->n + u->by.at;
        if (!isnan(u->start)) (rate ? fit->start->rate : fit->start->phi)[at] = u->start;
        seen[at + rate * numbers] = 0;
    }
    fit->unknowns = before;
}

/* makes unknowns of the estimated numbers of starts that are not unknowns yet */
static void start_free(struct api_fit *fit, const unsigned char seen[]) {
    static const char *const names[2][2] = {{"theta", "thetad"}, {"phi", "phid"}}; // for a cart
    long numbers = fit->start->count * fit->start->n, count = 0, more = 0;
    for (long i = 0; i < fit->rows * fit->columns; i++) count += !isnan(fit->data[i]);
    for (int pass = 0; pass < 2; pass++)
        for (long i = 0; i < 2 * numbers; i++) {
            int rate = i >= numbers, run = (int)(i % numbers / fit->start->n);
            int k = (int)(i % fit->start->n), cart = k < fit->tree.cart;
            struct pend_parameter by = {rate ? PEND_PARAMETER_RATE : PEND_PARAMETER_PHI, k};
            if (!seen[i] || start_sought(fit, by.kind, k, run) >= 0) continue;
            if (!pass && ++more) continue;
            // no measurement would be left to determine the errors
            if (fit->unknowns + more >= count || fit->unknowns + 1 > API_FIT_UNKNOWNS) return;
            int j = fit->unknowns++;
            double start = (rate ? fit->start->rate : fit->start->phi)[i % numbers];
            fit->unknown[j] = (struct pend_fit_unknown){-1, by, start, -INFINITY, INFINITY, run};
            fit->shift[j] = rate || cart ? 0 : pi / 2;
            api_fit_label(fit, names[cart][rate], k, run, fit->label[j]);
            fit->freed++, more--;
        }
}

enum pend_status api_fit_guess(struct api_fit *fit) {
    assert(fit->start && fit->rows >= 1);
    unsigned char *seen = calloc((size_t)fit->start->count, (size_t)fit->start->n);
    if (!seen) return PEND_NO_MEMORY;
    start_guess(fit, seen);
    start_unknowns(fit);
    free(seen);
    return PEND_OK;
}

enum pend_status api_fit_settle(struct api_fit *fit, const struct api_value *fixed,
                                struct api_problem *problem) {
    assert(fit->start && fit->tree.tree && fit->rows >= 1);
    size_t numbers = (size_t)(fit->start->count * fit->start->n);
    unsigned char *seen = calloc(2, numbers);
    if (!seen) return PEND_NO_MEMORY;
    start_guess(fit, seen);
    for (size_t i = 0; i < numbers; i++) seen[numbers + i] = seen[i] == PEND_FIT_START_BOTH;
    start_unknowns(fit);
    start_fixed(fit, fixed, seen, problem);
    if (!problem->status) start_free(fit, seen);
    free(seen);
    return PEND_OK;
}

/* ---- fixed numbers */

/* writes an item of a list, "mass of arm 2 in run 1"; without an arm, "all arms" */
static enum pend_status write_name(const char *name, int arm, int run, struct api_buffer *out) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_format(out, arm ? "\"%s of arm %d" : "\"%s of all arms", name, arm));
    return run ? api_buffer_format(out, " in run %d\"", run) : api_buffer_text(out, "\"");
}

/* lists the arms whose number is fixed, or all arms; `term` is -1 if it is not a term */
static enum pend_status write_arms(const struct api_fit *fit, const char *name,
                                   enum pend_parameter_kind kind, int term, int run,
                                   struct api_buffer *out) {
    int n = fit->tree.tree->n, left = 0, last = 0, in = run >= 0 && fit->runs > 1 ? run + 1 : 0;
    n -= fit->tree.cart;
    for (int pass = 0; pass < 2; pass++)
        for (int k = fit->tree.cart; k < n + fit->tree.cart; k++) {
            int at = term < 0 ? k : api_varied_place(&fit->tree, term, k, 1);
            if (at < 0 || start_sought(fit, kind, at, run < 0 ? 0 : run) >= 0) continue;
            last = fit->tree.tree->order[k] + 1, left += !pass;
            if (pass && (left < n || n == 1)) PEND_TRY(write_name(name, last, in, out));
        }
    return left == n && n > 1 ? write_name(name, 0, in, out) : PEND_OK;
}

static enum pend_status write_camera(const struct api_fit *fit, struct api_buffer *out) {
    static const char *const names[] = {"scale", "rotation", "origin"};
    int places = 0;
    for (int c = 0; c < fit->columns; c++)
        places |= fit->column[c].kind == PEND_FIT_X || fit->column[c].kind == PEND_FIT_Y;
    for (int i = 0; i < 3 && places; i++) {
        int sought = 0;
        for (int j = 0; j < fit->unknowns; j++) sought |= fit->unknown[j].camera == i;
        if (sought) continue;
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_format(out, "\"%s of the camera\"", names[i]));
    }
    return PEND_OK;
}

enum pend_status api_fit_write_fixed(const struct api_fit *fit, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "freed", '['));
    for (int j = fit->unknowns - fit->freed; j < fit->unknowns; j++)
        PEND_TRY(api_out_text(out, NULL, fit->label[j]));
    PEND_TRY(api_buffer_text(out, "]"));
    PEND_TRY(api_out_open(out, "fixed", '['));
    PEND_TRY(write_arms(fit, "length", PEND_PARAMETER_LENGTH, -1, -1, out));
    PEND_TRY(write_arms(fit, "mass", PEND_PARAMETER_MASS, -1, -1, out));
    for (int i = 0; i < PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES; i++) {
        int one = api_varied_of_arm(i) ? -1 : api_varied_place(&fit->tree, i, -1, 1);
        if (api_varied_of_arm(i))
            PEND_TRY(write_arms(fit, api_varied_name(i), PEND_PARAMETER_TERM, i, -1, out));
        if (one < 0 || start_sought(fit, PEND_PARAMETER_TERM, one, 0) >= 0) continue;
        PEND_TRY(api_out_text(out, NULL, api_varied_name(i)));
    }
    if (start_sought(fit, PEND_PARAMETER_GRAVITY, 0, 0) < 0)
        PEND_TRY(api_out_text(out, NULL, "gravity"));
    for (int r = 0; r < fit->runs && fit->columns > fit->modes; r++) {
        PEND_TRY(write_arms(fit, "theta", PEND_PARAMETER_PHI, -1, r, out));
        PEND_TRY(write_arms(fit, "thetad", PEND_PARAMETER_RATE, -1, r, out));
    }
    PEND_TRY(write_camera(fit, out));
    return api_buffer_text(out, "]");
}
