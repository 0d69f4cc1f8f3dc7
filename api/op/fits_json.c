#include "api/op/fits_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/fits_camera.h"
#include "api/op/fits_csv.h"
#include "api/op/fits_modes.h"
#include "api/op/fits_unknowns.h"

static const double pi = 3.14159265358979323846;

static const char *const fields[] = {"pendulum", "initial", "start",      "data", "camera",
                                     "unknowns", "rtol",    "iterations", NULL};
static const char *const data_fields[] = {"t", "series", "csv", "arms", "sigma", "modes", NULL};
static const char *const series_fields[] = {"phi",    "theta", "x",    "y",
                                            "values", "sigma", "unit", NULL};
static const char *const angle_units[] = {"rad", "deg", NULL};

void api_fit_clear(struct api_fit *fit) {
    free(fit->t);
    free(fit->data);
    free(fit->each);
    free(fit->length);
    free(fit->bare);
    free(fit->parent);
    api_states_free(&fit->start);
    api_tree_clear(&fit->tree);
    fit->t = fit->data = fit->each = fit->length = NULL;
    fit->bare = NULL;
    fit->parent = NULL;
}

/* ---- measurements */

/* room for `columns` series of `rows` measurements, none of them measured: a mode has a row's too
 */
static enum pend_status data_room(struct api_fit *fit, long rows, int columns,
                                  const struct api_value *data, const struct api_reading *reading) {
    size_t count = (size_t)rows * (size_t)columns;
    double bytes = 2.0 * (double)count * sizeof(double), most = reading->limits->answer_bytes;
    if (bytes > most) {
        api_value_fault(data, reading->problem,
                        API_CODE_LIMIT "would take %.0f bytes of memory, rows times columns, more "
                                       "than the limit max-answer-bytes of %.0f",
                        bytes, most);
        return PEND_INVALID;
    }
    fit->t = malloc((size_t)(rows + 1) * sizeof(double));
    fit->data = malloc((count + 1) * sizeof(double));
    fit->each = malloc((count + 1) * sizeof(double));
    if (!fit->t || !fit->data || !fit->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) fit->data[i] = NAN;
    fit->rows = rows, fit->columns = columns;
    for (int c = 0; c < columns; c++) fit->column[c].data = fit->data + (size_t)c * (size_t)rows;
    return PEND_OK;
}

static void read_instants(struct api_fit *fit, const struct api_value *list,
                          struct api_problem *problem) {
    int count;
    const double *t = api_value_numbers(list, &count);
    if (!t || count != fit->rows) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be an array of at least one number");
        return;
    }
    memcpy(fit->t, t, (size_t)count * sizeof *t);
    for (int i = 1; i < count; i++) {
        struct api_value item = api_value_item(list, i);
        if (t[i] > t[i - 1]) continue;
        api_value_fault(&item, problem,
                        API_CODE_ORDER "must be later than the instant before it, %.9g s, got %.9g",
                        t[i - 1], t[i]);
        return;
    }
}

/* numbers, or null where nothing was measured */
static void read_values(struct api_fit *fit, int c, const struct api_value *list, double scale,
                        double shift, struct api_problem *problem) {
    double *to = fit->data + (size_t)c * (size_t)fit->rows;
    if (api_value_kind(list) != API_ARRAY || api_value_count(list) != fit->rows) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be %ld numbers or nulls, one an instant",
                        fit->rows);
        return;
    }
    struct api_value item = api_value_item(list, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        enum api_kind kind = api_value_kind(&item);
        if (kind == API_NUMBER)
            to[item.index] = scale * api_value_number(&item) + shift;
        else if (kind != API_NULL)
            api_value_fault(&item, problem,
                            API_CODE_WRONG_TYPE "must be a number, or null for not measured");
    }
}

/* the standard deviation of a series: a number, or one an instant; scale is the unit's */
static void read_sigma(struct api_fit *fit, int c, const struct api_value *sigma, double scale,
                       struct api_problem *problem) {
    static const double least = 1e-12, most = 1e12;
    double *to = fit->each + (size_t)c * (size_t)fit->rows;
    if (api_value_kind(sigma) != API_ARRAY) {
        if (api_value_read_number(sigma, least, most, "", &fit->column[c].sigma, problem) > 0)
            fit->column[c].sigma *= scale;
        return;
    }
    if (api_value_count(sigma) != fit->rows) {
        api_value_fault(sigma, problem, API_CODE_WRONG_COUNT "must be a number or an array of %ld",
                        fit->rows);
        return;
    }
    struct api_value item = api_value_item(sigma, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        if (api_value_read_number(&item, least, most, "", &to[item.index], problem) > 0)
            to[item.index] *= scale;
    fit->column[c].each = to;
}

/* one series: what of which arm, with what error */
static void read_series(struct api_fit *fit, const struct api_value *item,
                        struct api_problem *problem) {
    static const struct {
        const char *name;
        enum pend_fit_kind kind;
        int theta;
    } kinds[] = {{"phi", PEND_FIT_PHI, 0},
                 {"theta", PEND_FIT_PHI, 1},
                 {"x", PEND_FIT_X, 0},
                 {"y", PEND_FIT_Y, 0}};
    struct pend_fit_column *column = &fit->column[item->index];
    struct api_value values = api_value_member(item, "values"),
                     sigma = api_value_member(item, "sigma"), unit = api_value_member(item, "unit");
    int found = 0, degrees = 0, theta = 0;
    if (!api_field_object(item, problem)) return;
    (void)api_value_only(item, series_fields, problem);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        struct api_value arm = api_value_member(item, kinds[i].name);
        if (api_value_kind(&arm) == API_MISSING) continue;
        if (found++) api_value_fault(&arm, problem, API_CODE_CONFLICT "is a second quantity");
        int at = api_tree_read_arm(&fit->tree, &arm, problem);
        column->kind = kinds[i].kind, column->arm = at < 0 ? 0 : at, theta = kinds[i].theta;
    }
    if (!found)
        api_value_fault(item, problem,
                        API_CODE_MISSING "needs one of phi, theta, x and y: the arm's number");
    if (api_field_word(&unit, angle_units, &degrees, problem) > 0 && column->kind != PEND_FIT_PHI)
        api_value_fault(&unit, problem, API_CODE_NOT_APPLICABLE "is for angles: leave it out");
    double scale = degrees ? pi / 180 : 1;
    read_sigma(fit, item->index, &sigma, scale, problem);
    read_values(fit, item->index, &values, scale, theta ? -pi / 2 : 0, problem);
}

/* the columns of a table of text */
static enum pend_status read_csv(struct api_fit *fit, const struct api_value *data, int modes,
                                 const struct api_reading *reading) {
    struct api_value csv = api_value_member(data, "csv"), arms = api_value_member(data, "arms"),
                     sigma = api_value_member(data, "sigma");
    struct api_csv table;
    double error = 0;
    int most = 0, listed[API_FIT_SERIES];
    struct api_value arm = api_value_item(&arms, 0);
    for (; api_value_kind(&arm) != API_MISSING && most < API_FIT_SERIES; arm = api_value_next(&arm))
        listed[most++] = api_tree_read_arm(&fit->tree, &arm, reading->problem);
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &error, reading->problem);
    if (!api_value_text(&csv)) {
        api_value_fault(&csv, reading->problem, API_CODE_WRONG_TYPE "must be a table as text");
        return PEND_INVALID;
    }
    api_csv_head(&table, &csv, fit->tree.n, most, listed, reading->problem);
    if (reading->problem->status) return PEND_INVALID;
    PEND_TRY(data_room(fit, table.rows, table.columns + modes, data, reading));
    for (int c = 0; c < table.columns; c++) {
        fit->column[c].kind = table.kind[c], fit->column[c].arm = table.arm[c];
        fit->column[c].sigma = error;
    }
    api_csv_rows(&table, &csv, fit->t, fit->data, reading->problem);
    return PEND_OK;
}

/* instants and series */
static enum pend_status read_table(struct api_fit *fit, const struct api_value *data, int modes,
                                   const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value t = api_value_member(data, "t"), series = api_value_member(data, "series");
    int columns = api_value_count(&series);
    long rows = api_value_count(&t);
    if (api_value_kind(&series) != API_ARRAY || !columns || columns > API_FIT_SERIES)
        api_value_fault(&series, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d series",
                        API_FIT_SERIES);
    if (!rows || (double)rows > reading->limits->samples)
        api_value_fault(&t, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %.0f instants",
                        reading->limits->samples);
    if (problem->status) return PEND_INVALID;
    PEND_TRY(data_room(fit, rows, columns + modes, data, reading));
    read_instants(fit, &t, problem);
    struct api_value item = api_value_item(&series, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        read_series(fit, &item, problem);
    return PEND_OK;
}

static enum pend_status read_data(struct api_fit *fit, const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value data = api_value_member(reading->root, "data");
    struct api_value t = api_value_member(&data, "t"), series = api_value_member(&data, "series"),
                     csv = api_value_member(&data, "csv"), modes = api_value_member(&data, "modes");
    enum pend_status status;
    int count = api_value_count(&modes);
    if (!api_field_object(&data, problem)) return PEND_INVALID;
    (void)api_value_only(&data, data_fields, problem);
    if (api_value_kind(&modes) != API_MISSING &&
        (api_value_kind(&modes) != API_ARRAY || !count || count > API_FIT_MODES)) {
        api_value_fault(&modes, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d modes",
                        API_FIT_MODES);
        return PEND_INVALID;
    }
    int still = count && api_value_kind(&t) == API_MISSING &&
                api_value_kind(&series) == API_MISSING && api_value_kind(&csv) == API_MISSING;
    if (api_value_kind(&csv) != API_MISSING)
        status = read_csv(fit, &data, count, reading);
    else if (!still)
        status = read_table(fit, &data, count, reading);
    else {
        // modes alone are of no motion but for its first instant
        status = data_room(fit, 1, count, &data, reading);
        if (status == PEND_OK) fit->t[0] = fit->begin;
    }
    if (status == PEND_OK && count) api_fit_read_modes(fit, &modes, fit->columns - count, problem);
    return status;
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

/* as many measurements as unknowns, from the start on */
static void fit_check(const struct api_fit *fit, const struct api_value *root,
                      struct api_problem *problem) {
    struct api_value data = api_value_member(root, "data"), start = api_value_member(root, "start");
    long count = 0;
    for (long i = 0; i < fit->rows * fit->columns; i++) count += !isnan(fit->data[i]);
    if (count < fit->unknowns)
        api_value_fault(&data, problem,
                        API_CODE_WRONG_COUNT
                        "has %ld measurements, too few for %d unknowns: there must be as many",
                        count, fit->unknowns);
    double first = fit->t[0] + fit->camera[PEND_FIT_SHIFT];
    if (fit->begins && fit->begin > first)
        api_value_fault(&start, problem,
                        API_CODE_ORDER "must not be after the first instant, %.9g s", first);
}

enum pend_status api_fit_read(struct api_fit *fit, const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial"),
                     start = api_value_member(root, "start"), rtol = api_value_member(root, "rtol"),
                     most = api_value_member(root, "iterations"),
                     camera = api_value_member(root, "camera"),
                     unknowns = api_value_member(root, "unknowns");
    *fit = (struct api_fit){.rtol = 1e-10, .iterations = 300};
    fit->step_cap = (long)reading->limits->steps;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &fit->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK) PEND_TRY(api_states_new(&fit->start, 1, fit->tree.tree->n));
    if (status == PEND_OK) PEND_TRY(fit_arms(fit));
    fit->guessed = api_value_kind(&initial) == API_MISSING;
    api_states_read(fit->start, 0, &initial, &fit->tree, reading->limits, problem);
    if (fit->start && fit->start->mode[0])
        api_value_fault(&initial, problem,
                        API_CODE_NOT_APPLICABLE
                        "must be given by angles: a fit has no mode to start in");
    fit->begins = api_value_read_number(&start, -1e9, 1e9, "s", &fit->begin, problem) > 0;
    (void)api_value_read_number(&rtol, 1e-14, 1e-3, "", &fit->rtol, problem);
    (void)api_field_whole(&most, 1, 10000, &fit->iterations, problem);
    // a cart was refused with the pendulum
    if (pend_terms_cart(fit->tree.loads.terms)) return PEND_INVALID;
    status = read_data(fit, reading);
    if (status == PEND_NO_MEMORY) return status;
    api_fit_read_unknowns(fit, &unknowns, problem);
    api_fit_read_camera(fit, &camera, problem);
    if (!problem->status && !fit->unknowns)
        api_value_fault(&unknowns, problem,
                        API_CODE_MISSING "must name at least one unknown, here or of the camera");
    if (!problem->status) fit_check(fit, root, problem);
    if (problem->status) return PEND_INVALID;
    if (!fit->begins) fit->begin = fit->t[0] + fit->camera[PEND_FIT_SHIFT];
    return PEND_OK;
}

void api_fit_guess(struct api_fit *fit) {
    enum { FIRST = 5 };
    const int *place = fit->tree.tree->place;
    for (int k = 0; k < fit->tree.n && fit->guessed; k++) fit->start->phi[k] = -pi / 2;
    for (int c = 0; c < fit->columns && fit->guessed; c++) {
        const struct pend_fit_column *column = &fit->column[c];
        long last = fit->rows < FIRST ? fit->rows - 1 : FIRST - 1;
        double first = column->data[0], then = column->data[last];
        if (column->kind != PEND_FIT_PHI || isnan(first)) continue;
        fit->start->phi[place[column->arm]] = first;
        if (last && !isnan(then))
            fit->start->rate[place[column->arm]] =
                remainder(then - first, 2 * pi) / (fit->t[last] - fit->t[0]);
    }
    for (int j = 0; j < fit->unknowns; j++) {
        struct pend_fit_unknown *u = &fit->unknown[j];
        if (!isnan(u->start)) continue;
        int angle = u->by.kind == PEND_PARAMETER_PHI;
        u->start = (angle ? fit->start->phi : fit->start->rate)[u->by.at];
        // beyond its bounds it begins inside, near the next of them
        if (!(u->start > u->low)) u->start = fmin(u->low + 1e-3, 0.5 * (u->low + u->high));
        if (!(u->start < u->high)) u->start = fmax(u->high - 1e-3, 0.5 * (u->low + u->high));
    }
}

struct pend_fit_problem api_fit_problem(const struct api_fit *fit) {
    assert(fit->tree.tree && fit->start && fit->rows >= 1 && fit->unknowns >= 1);
    struct pend_fit_problem problem = {.n = fit->tree.n,
                                       .length = fit->length,
                                       .mass = fit->mass,
                                       .bare = fit->bare,
                                       .parent = fit->parent,
                                       .order = fit->tree.tree->order,
                                       .loads = fit->tree.loads,
                                       .phi = fit->start->phi,
                                       .rate = fit->start->rate,
                                       .start = fit->begin,
                                       .rows = fit->rows,
                                       .t = fit->t,
                                       .columns = fit->columns,
                                       .column = fit->column,
                                       .unknowns = fit->unknowns,
                                       .unknown = fit->unknown,
                                       .rtol = fit->rtol,
                                       .iterations = (int)fit->iterations,
                                       .step_cap = fit->step_cap};
    memcpy(problem.camera, fit->camera, sizeof fit->camera);
    return problem;
}

enum pend_status api_fit_put(struct api_fit *fit, const double value[]) {
    assert(fit->length && fit->parent && value);
    const int *order = fit->tree.tree->order;
    for (int j = 0; j < fit->unknowns; j++) {
        const struct pend_fit_unknown *u = &fit->unknown[j];
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
        array[u->by.kind][own ? order[u->by.at] : u->by.at] = value[j];
    }
    struct pend_tree *tree;
    PEND_TRY(pend_tree_new_bare(&tree, fit->tree.n, fit->length, fit->mass, fit->bare, fit->parent,
                                NULL));
    pend_tree_free(&fit->tree.tree);
    fit->tree.tree = tree;
    return PEND_OK;
}
