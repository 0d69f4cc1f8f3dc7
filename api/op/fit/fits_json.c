#include "api/op/fit/fits_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/fit/fits_data.h"
#include "api/op/fit/fits_start.h"
#include "api/op/varied.h"
#include "api/read/terms_fields.h"

static const double pi = 3.14159265358979323846;

static const char *const fields[] = {"pendulum", "initial", "time",       "start",
                                     "data",     "camera",  "loss",       "unknowns",
                                     "fixed",    "rtol",    "iterations", NULL};
static const char *const losses[] = {"linear", "soft_l1", "huber", "cauchy", NULL};

/* knees of the losses, in standard deviations; with normal noise they keep 95 % of the efficiency
 * of least squares */
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

/* ---- terms that are sought from 0 */

struct wanted {
    unsigned char row[PEND_TERM_ROWS], one[PEND_TERM_ONES];
};

/* terms that have an effect without any other term */
static int is_alone(int row) {
    static const int alone[] = {PEND_TERM_ROD,       PEND_TERM_BODY,          PEND_TERM_DAMPING,
                                PEND_TERM_STIFFNESS, PEND_TERM_FRICTION,      PEND_TERM_TORQUE,
                                PEND_TERM_DRAG,      PEND_TERM_DRAG_QUADRATIC};
    for (size_t i = 0; i < sizeof alone / sizeof *alone; i++)
        if (alone[i] == row) return 1;
    return 0;
}

/* marks the term with this name; returns whether it is new */
static int wanted_name(struct wanted *wanted, const char *name) {
    for (int i = 0; i < PEND_TERM_OWN_ROWS + PEND_TERM_OWN_ONES; i++) {
        int one = i - PEND_TERM_OWN_ROWS;
        if (strcmp(name, api_varied_name(i)) != 0) continue;
        if (one < 0 ? !is_alone(i) : one == PEND_TERM_RAIL) return 0;
        unsigned char *mark = one < 0 ? &wanted->row[i] : &wanted->one[one], had = *mark;
        *mark = 1;
        return !had;
    }
    return 0;
}

/* copies the pendulum's numbers to their new indices */
static void terms_carry(const struct api_tree *tree, struct pend_terms *made, const int place[],
                        double value[]) {
    const struct pend_terms *had = tree->terms;
    pend_terms_clear(made, tree->tree, value);
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        for (int k = 0; made->row[r] >= 0 && k < made->n; k++) {
            if (had && had->row[r] >= 0)
                value[made->row[r] + k] = tree->value[had->row[r] + k];
            else if (r != PEND_TERM_AT_X)
                value[made->row[r] + k] = api_terms_usual((enum pend_term_row)r);
        }
    for (int one = 0; had && one < PEND_TERM_ONES; one++)
        if (had->one[one] >= 0) value[made->one[one]] = tree->value[had->one[one]];
    for (int h = 0; h < made->harmonics; h++)
        memcpy(&value[made->harmonic[h].at], &tree->value[had->harmonic[place[h]].at],
               3 * sizeof *value);
    if (had) memcpy(made->hung, had->hung, (size_t)made->n);
    if (had) made->rules = had->rules;
}

/* marks the present terms, and those that unknowns name; returns whether any is new */
static int wanted_all(struct wanted *wanted, const struct pend_terms *had,
                      const struct api_value *list) {
    int fresh = 0;
    for (int r = 0; had && r < PEND_TERM_ROWS; r++) wanted->row[r] = had->row[r] >= 0;
    for (int one = 0; had && one < PEND_TERM_ONES; one++) wanted->one[one] = had->one[one] >= 0;
    API_VALUE_EACH (item, api_value_item(list, 0)) {
        struct api_value vary = api_value_member(&item, "vary");
        const char *name = api_value_text(&vary);
        if (name) fresh |= wanted_name(wanted, name);
    }
    return fresh;
}

/* Adds the terms of unknowns that may start from 0, which the pendulum lacks: masses of rods and
 * bodies, springs, friction, torques, drag, an acceleration of the pivot. A pendulum on a cart is
 * not changed. list: the unknowns in the document, valid or not. */
static enum pend_status give_terms(struct api_tree *tree, const struct api_value *list) {
    const struct pend_terms *had = tree->terms;
    struct wanted wanted = {{0}, {0}};
    int harmonics = had ? had->harmonics : 0;
    if (!tree->tree || tree->cart || api_value_kind(list) != API_ARRAY) return PEND_OK;
    if (!wanted_all(&wanted, had, list)) return PEND_OK;
    struct pend_terms *made = NULL;
    int *drives = malloc(2 * ((size_t)harmonics + 1) * sizeof *drives);
    if (!drives) return PEND_NO_MEMORY;
    for (int h = 0; h < harmonics; h++) drives[h] = had->harmonic[h].drives;
    enum pend_status status = pend_terms_new(&made, tree->tree->n, wanted.row, wanted.one,
                                             harmonics, drives, drives + harmonics);
    double *value = status == PEND_OK ? malloc((size_t)made->count * sizeof *value) : NULL;
    if (value) {
        assert(made->harmonics == harmonics);
        terms_carry(tree, made, drives + harmonics, value);
        pend_terms_free(&tree->terms);
        free(tree->value);
        tree->terms = made, tree->value = value;
        tree->loads.terms = made, tree->loads.value = value;
    } else {
        pend_terms_free(&made);
        status = PEND_NO_MEMORY;
    }
    free(drives);
    return status;
}

/* sets the pendulum's own numbers in the caller's order */

static enum pend_status fit_arms(struct api_fit *fit) {
    size_t n = (size_t)api_tree_stored(&fit->tree);
    const struct pend_tree *tree = fit->tree.tree;
    fit->length = malloc(2 * n * sizeof(double));
    fit->bare = malloc(n);
    fit->parent = malloc(n * sizeof(int));
    if (!fit->length || !fit->bare || !fit->parent) return PEND_NO_MEMORY;
    fit->mass = fit->length + n;
    for (int i = 0; i < tree->n; i++) {
        int k = tree->place[i];
        fit->length[i] = tree->len[k], fit->mass[i] = tree->mass[k];
        fit->bare[i] = fit->mass[i] == 0;
        fit->parent[i] = tree->parent[k] < 0 ? -1 : tree->order[tree->parent[k]];
    }
    return PEND_OK;
}

/* rows further apart than this many swings suggest another unit of time */
enum { MANY_ROWS = 10, FEW_SWINGS = 10 };

/* refuses instants so far apart that they are probably in another unit */
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

/* requires at least as many measurements as unknowns, counted from the start */
static void fit_check(const struct api_fit *fit, const struct api_value *root,
                      struct api_problem *problem) {
    struct api_value data = api_value_member(root, "data"),
                     start = api_field_renamed(root, "time", "start", problem);
    long count = 0;
    for (long i = 0; i < fit->rows * fit->columns; i++) count += !isnan(fit->data[i]);
    if (fit->runs == 1) fit_apart(fit, &data, problem);
    if (count < fit->unknowns)
        api_value_fault(
            &data, problem,
            API_CODE_WRONG_COUNT
            "has %ld measurements, too few for %d unknowns: there must be at least as many",
            count, fit->unknowns);
    for (int r = 0; r < fit->runs; r++) {
        struct api_value runs = api_value_member(&data, "runs"), run = api_value_item(&runs, r);
        struct api_value own = api_field_renamed(&run, "time", "start", problem);
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
    if (status == PEND_OK) PEND_TRY(give_terms(&fit->tree, &unknowns));
    (void)api_value_read_number(&rtol, 1e-14, 1e-3, "", &fit->rtol, problem);
    (void)api_field_whole(&most, 1, 10000, &fit->iterations, problem);
    (void)api_field_word(&loss, losses, &fit->loss, problem);
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
    PEND_TRY(pend_tree_new_bare(&tree, api_tree_stored(&fit->tree), fit->length, fit->mass,
                                fit->bare, fit->parent, NULL));
    pend_tree_free(&fit->tree.tree);
    fit->tree.tree = tree;
    return PEND_OK;
}
