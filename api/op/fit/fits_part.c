#include "api/op/fit/fits_part.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

#define QUANTITIES                                                                                 \
    "phi, theta, joint, x, y, phid, thetad, passes, along, across, amplitude, period and cart"

static const char *const series_fields[] = {
    "of",     "arm",    "phi",    "theta", "joint",  "x",       "y",
    "phid",   "thetad", "passes", "along", "across", "values",  "amplitude",
    "period", "cart",   "sigma",  "unit",  "at",     "gravity", NULL};

int api_fit_part_fits(double rows, double columns, double *taken, const struct api_value *data,
                      const struct api_reading *reading) {
    double most = reading->limits->answer_bytes;
    *taken += rows * (2 * columns + 1) * sizeof(double);
    if (*taken <= most) return 1;
    api_value_fault(data, reading->problem,
                    API_CODE_LIMIT "would take %.0f bytes of memory, rows times columns of all "
                                   "runs, more than the limit max-answer-bytes of %.0f",
                    *taken, most);
    return 0;
}

enum pend_status api_fit_part_room(struct api_fit_part *part, long rows, int columns,
                                   const struct api_value *data,
                                   const struct api_reading *reading) {
    size_t count = (size_t)rows * (size_t)columns;
    if (!api_fit_part_fits((double)rows, columns, part->taken, data, reading)) return PEND_INVALID;
    part->t = malloc((size_t)(rows + 1) * sizeof(double));
    part->data = malloc((count + 1) * sizeof(double));
    part->each = malloc((count + 1) * sizeof(double));
    if (!part->t || !part->data || !part->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) part->data[i] = NAN;
    part->rows = rows, part->columns = columns;
    return PEND_OK;
}

/* reads an array of numbers, with null for missing measurements */
static void read_values(struct api_fit_part *run, int c, const struct api_value *list, double scale,
                        double shift, struct api_problem *problem) {
    double *to = run->data + (size_t)c * (size_t)run->rows;
    if (api_value_kind(list) != API_ARRAY || api_value_count(list) != run->rows) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be %ld numbers or nulls, one for each instant",
                        run->rows);
        return;
    }
    API_VALUE_EACH (item, api_value_item(list, 0)) {
        enum api_kind kind = api_value_kind(&item);
        if (kind == API_NUMBER)
            to[item.index] = scale * api_value_number(&item) + shift;
        else if (kind != API_NULL)
            api_value_fault(&item, problem,
                            API_CODE_WRONG_TYPE "must be a number, or null for not measured");
    }
}

/* reads the standard deviation of a series, one number or one per instant; `scale`: of its unit */
static void read_sigma(struct api_fit_part *run, int c, const struct api_value *sigma, double scale,
                       struct api_problem *problem) {
    static const double least = 1e-12, most = 1e12;
    double *to = run->each + (size_t)c * (size_t)run->rows;
    if (api_value_kind(sigma) != API_ARRAY) {
        if (api_value_read_number(sigma, least, most, "", &run->column[c].sigma, problem) > 0)
            run->column[c].sigma *= scale;
        return;
    }
    if (api_value_count(sigma) != run->rows) {
        api_value_fault(sigma, problem, API_CODE_WRONG_COUNT "must be a number or an array of %ld",
                        run->rows);
        return;
    }
    API_VALUE_EACH (item, api_value_item(sigma, 0))
        if (api_value_read_number(&item, least, most, "", &to[item.index], problem) > 0)
            to[item.index] *= scale;
    run->column[c].each = to;
}

/* the quantity of a series, in the order of enum api_csv_role */
static const struct {
    const char *name;
    enum pend_fit_kind kind;
    int theta; /* 1 = from the vertical; 2 = from the parent arm */
} kinds[] = {{"theta", PEND_FIT_PHI, 1},
             {"phi", PEND_FIT_PHI, 0},
             {"joint", PEND_FIT_PHI, 2},
             {"x", PEND_FIT_X, 0},
             {"y", PEND_FIT_Y, 0},
             {"thetad", PEND_FIT_RATE, 0},
             {"amplitude", PEND_FIT_AMPLITUDE, 0},
             {"period", PEND_FIT_PERIOD, 0},
             {"along", PEND_FIT_ALONG, 0},
             {"across", PEND_FIT_ACROSS, 0},
             {"cart", PEND_FIT_CART, 0},
             {"phid", PEND_FIT_RATE, 0},
             {"passes", PEND_FIT_PASSAGE, 1}};

static int is_turn(enum pend_fit_kind kind) {
    return kind == PEND_FIT_PHI || kind == PEND_FIT_RATE || kind == PEND_FIT_AMPLITUDE ||
           kind == PEND_FIT_PASSAGE;
}

/* sets the quantity of a series; arm: -1 = none */
static void series_of(struct api_fit_part *run, int c, const struct api_tree *tree, int kind,
                      int arm) {
    struct pend_fit_column *column = &run->column[c];
    column->kind = kinds[kind].kind, column->arm = arm < 0 ? 0 : arm, column->at = -1;
    column->joint = kinds[kind].theta == 2 && arm >= 0 && api_tree_parent(tree, arm) >= 0;
    run->zero[c] = kinds[kind].theta && !column->joint ? -pi / 2 : 0;
}

/* adds an error if a quantity does not exist in this pendulum */
static void series_check(const struct api_tree *tree, enum pend_fit_kind kind,
                         const struct api_value *arm, struct api_problem *problem) {
    const struct pend_terms *terms = tree->terms;
    int springs = terms && (terms->row[PEND_TERM_STIFFNESS] >= 0 || pend_terms_cart(terms));
    int swings = kind == PEND_FIT_AMPLITUDE || kind == PEND_FIT_PERIOD;
    if (swings && (tree->n != 1 || springs || !(tree->loads.gravity > 0)))
        api_value_fault(arm, problem,
                        API_CODE_NOT_APPLICABLE "is only for a pendulum of one arm, without a "
                                                "spring and a cart, that gravity pulls down");
    if (kind == PEND_FIT_CART && !tree->cart)
        api_value_fault(arm, problem, API_CODE_NOT_APPLICABLE "needs a pivot on a cart");
}

/* reads which quantity a series measures; returns its row in `kinds`, -1 = none */
static int series_kind(struct api_fit_part *run, int c, const struct api_tree *tree,
                       const struct api_value *item, struct api_problem *problem) {
    const char *of = api_value_text(API_MEMBER(item, "of"));
    int found = -1;
    for (int i = 0; i < (int)(sizeof kinds / sizeof *kinds); i++) {
        int chosen = of && !strcmp(of, kinds[i].name);
        struct api_value arm = api_value_member(item, chosen ? "arm" : kinds[i].name);
        int cart = kinds[i].kind == PEND_FIT_CART, on = 0;
        if (!chosen && api_value_kind(&arm) == API_MISSING) continue;
        problem->deprecated |= !chosen;
        if (found >= 0)
            api_value_fault(&arm, problem,
                            API_CODE_CONFLICT
                            "is one quantity too many: give only one of " QUANTITIES);
        found = i;
        if (cart) (void)api_field_truth(&arm, &on, problem);
        series_check(tree, kinds[i].kind, &arm, problem);
        series_of(run, c, tree, i, cart ? tree->n : api_tree_read_arm(tree, &arm, problem));
    }
    if (found < 0)
        api_value_fault(item, problem,
                        API_CODE_MISSING "needs \"of\": one of " QUANTITIES "; and \"arm\"");
    return found;
}

/* reads where an accelerometer is, and whether it removes gravity */
static void read_place(struct pend_fit_column *column, const struct api_value *item,
                       struct api_problem *problem) {
    struct api_value at = api_value_member(item, "at"), gravity = api_value_member(item, "gravity");
    int with = 1;
    (void)api_value_read_number(&at, 0, 1e6, "m", &column->at, problem);
    (void)api_field_truth(&gravity, &with, problem);
    column->still = !with;
    if (column->kind == PEND_FIT_ALONG || column->kind == PEND_FIT_ACROSS) return;
    const struct api_value *wrong = api_value_kind(&at) != API_MISSING ? &at : &gravity;
    if (api_value_kind(wrong) != API_MISSING)
        api_value_fault(wrong, problem,
                        API_CODE_NOT_APPLICABLE "is only for accelerations: leave it out");
}

/* reads one series: its quantity, arm and standard deviation */
static void read_series(struct api_fit_part *run, const struct api_tree *tree,
                        const struct api_value *item, struct api_problem *problem) {
    const int c = (int)item->index;
    struct pend_fit_column *column = &run->column[c];
    struct api_value values = api_value_member(item, "values"),
                     sigma = api_value_member(item, "sigma"), unit = api_value_member(item, "unit");
    int degrees = 0;
    if (!api_field_object(item, series_fields, problem)) return;
    if (series_kind(run, c, tree, item, problem) < 0) return;
    int passes = column->kind == PEND_FIT_PASSAGE;
    if (api_field_word(&unit, api_field_angles, &degrees, problem) > 0 && !is_turn(column->kind))
        api_value_fault(&unit, problem, API_CODE_NOT_APPLICABLE "is only for angles: leave it out");
    double scale = degrees ? pi / 180 : 1;
    read_place(column, item, problem);
    read_sigma(run, c, &sigma, passes ? 1 : scale, problem);
    // without angles every passage is through the lowest point
    for (long i = 0; i < run->rows && passes && api_value_kind(&values) == API_MISSING; i++)
        run->data[c * run->rows + i] = run->zero[c];
    if (!passes || api_value_kind(&values) != API_MISSING)
        read_values(run, c, &values, scale, run->zero[c], problem);
}

static enum pend_status read_table(struct api_fit_part *run, const struct api_tree *tree,
                                   const struct api_value *data,
                                   const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value list = api_value_member(data, "t"), series = api_value_member(data, "series"),
                     unit = api_value_member(data, "unit");
    int columns = api_value_count(&series), rows = 0;
    const double *t = api_value_numbers(&list, &rows);
    if (api_value_kind(&unit) != API_MISSING)
        api_value_fault(&unit, problem,
                        API_CODE_NOT_APPLICABLE
                        "applies to a csv: give each of \"series\" its own");
    if (api_value_kind(&series) != API_ARRAY || !columns || columns > API_FIT_SERIES)
        api_value_fault(&series, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d series",
                        API_FIT_SERIES);
    if (!t || rows < 1 || (double)rows > reading->limits->samples)
        api_value_fault(&list, problem,
                        API_CODE_WRONG_COUNT "must be an array of 1 to %.0f instants",
                        reading->limits->samples);
    if (problem->status) return PEND_INVALID;
    PEND_TRY(api_fit_part_room(run, rows, columns, data, reading));
    memcpy(run->t, t, (size_t)rows * sizeof *t);
    API_VALUE_EACH (item, api_value_item(&series, 0)) read_series(run, tree, &item, problem);
    return PEND_OK;
}

/* ---- tables of text */

static enum pend_status csv_rows(struct api_fit_part *run, const struct api_measured *table,
                                 const int series[]) {
    double *rows = api_measured_rows(table);
    const double *row = rows;
    for (long k = 0; rows && k < run->rows; k++, row += table->csv.columns) {
        run->t[k] = api_measured_value(table, table->roles.time, row);
        for (int i = 0; i < table->csv.columns; i++) {
            int error = table->roles.column[i].of;
            long at = series[i] * run->rows + k;
            if (series[i] < 0) continue;
            run->data[at] = api_measured_value(table, i, row) + run->zero[series[i]];
            if (error >= 0) run->each[at] = api_measured_value(table, error, row);
        }
    }
    free(rows);
    return rows ? PEND_OK : PEND_NO_MEMORY;
}

/* chooses columns that become series: series[column] is the index or -1; returns their number */
static int csv_choose(const struct api_csv *csv, const struct api_csv_roles *roles, int scaled,
                      int series[], const struct api_value *text, struct api_problem *problem) {
    int count = 0;
    double unit = 0;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_taken *taken = &roles->column[i];
        int place = taken->role == API_CSV_X || taken->role == API_CSV_Y;
        int measured = taken->role >= API_CSV_THETA && taken->role < API_CSV_SIGMA;
        series[i] = measured && count < API_FIT_SERIES ? count++ : -1;
        if (!place) continue;
        // next to positions in metres, positions in another unit would describe another pendulum
        if (unit > 0 && taken->unit != unit)
            api_value_fault(text, problem,
                            API_CODE_CONFLICT "line %d: field %d is in another unit than the "
                                              "positions before it: give all in one unit",
                            csv->head, i + 1);
        else if (!unit && taken->unit > 0 && taken->unit < 1 && !scaled)
            api_value_fault(text, problem,
                            API_CODE_MISSING
                            "line %d: field %d is not in m: give the \"scale\" of \"camera\" "
                            "too, which is %.0f units per m",
                            csv->head, i + 1, 1 / taken->unit);
        unit = taken->unit;
    }
    return count;
}

/* reads the series that a fit can use from a table, and its errors unless `sigma` is given */
static enum pend_status read_csv(struct api_fit_part *run, const struct api_tree *tree,
                                 const struct api_value *data, const struct api_reading *reading) {
    struct api_value text = api_value_member(data, "csv"), sigma = api_value_member(data, "sigma"),
                     camera = api_value_member(reading->root, "camera"),
                     scale = api_value_member(&camera, "scale");
    struct api_problem *problem = reading->problem;
    struct api_measured table;
    double error = 0;
    int series[API_CSV_COLUMNS];
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &error, problem);
    if (!api_measured_read(&table, tree, data, problem) ||
        !api_measured_check(&table, &text, problem))
        return PEND_INVALID;
    const struct api_csv *csv = &table.csv;
    int scaled = api_value_kind(&scale) != API_MISSING;
    int count = csv_choose(csv, &table.roles, scaled, series, &text, problem);
    if (problem->status) return PEND_INVALID;
    PEND_TRY(api_fit_part_room(run, csv->rows - table.repeated, count, data, reading));
    for (int i = 0; i < csv->columns; i++) {
        struct api_csv_taken *taken = &table.roles.column[i];
        if (series[i] < 0) continue;
        struct pend_fit_column *column = &run->column[series[i]];
        int cart = taken->role == API_CSV_CART;
        series_of(run, series[i], tree, (int)taken->role - API_CSV_THETA,
                  cart ? tree->n : taken->arm - 1);
        series_check(tree, column->kind, &text, problem);
        int place = column->kind == PEND_FIT_X || column->kind == PEND_FIT_Y;
        column->sigma = error * (place ? 1 : taken->unit);
        if (error > 0) taken->of = -1;
        if (taken->of >= 0) column->each = run->each + series[i] * run->rows;
    }
    if (problem->status) return PEND_INVALID;
    PEND_TRY(csv_rows(run, &table, series));
    if (*table.advice) memcpy(run->advice, table.advice, sizeof table.advice);
    return api_measured_write(&table, 0, 0, run->tables);
}

enum pend_status api_fit_part_read(struct api_fit_part *part, const struct api_tree *tree,
                                   const struct api_value *data,
                                   const struct api_reading *reading) {
    struct api_value csv = api_value_member(data, "csv");
    assert(part && tree && data);
    return api_value_kind(&csv) != API_MISSING ? read_csv(part, tree, data, reading)
                                               : read_table(part, tree, data, reading);
}

/* ---- counted modes */

static const char *const mode_fields[] = {"mode", "omega", "frequency", "period", "sigma", NULL};

static void read_mode(struct api_fit *fit, const struct api_value *item,
                      struct pend_fit_column *column, double *to, struct api_problem *problem) {
    struct api_value mode = api_value_member(item, "mode"), sigma = api_value_member(item, "sigma");
    long number = 1;
    int found = 0;
    double error = 0, x;
    *column = (struct pend_fit_column){.kind = PEND_FIT_MODE, .data = to};
    if (!api_field_object(item, mode_fields, problem)) return;
    if (api_field_needed(&mode, problem))
        (void)api_field_whole(&mode, 1, fit->tree.n, &number, problem);
    column->arm = (int)number - 1;
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &error, problem);
    for (int i = 1; i <= 3; i++) {
        struct api_value value = api_value_member(item, mode_fields[i]);
        if (api_value_kind(&value) == API_MISSING) continue;
        if (found++)
            api_value_fault(
                &value, problem,
                API_CODE_CONFLICT
                "is one quantity too many: give only one of omega, frequency and period");
        if (api_value_read_number(&value, 1e-9, 1e9, "", &x, problem) <= 0) continue;
        // ratio of the angular frequency to the given number, or the derivative for a period
        double scale = i == 1 ? 1 : 2 * pi;
        *to = i == 3 ? scale / x : scale * x;
        column->sigma = error * (i == 3 ? scale / (x * x) : scale);
    }
    if (!found)
        api_value_fault(item, problem, API_CODE_MISSING "needs one of omega, frequency and period");
}

void api_fit_read_modes(struct api_fit *fit, const struct api_value *list, int first,
                        struct api_problem *problem) {
    assert(first >= 0 && first <= fit->columns);
    if (fit->tree.n > PEND_FIT_MODE_ARMS)
        api_value_fault(list, problem,
                        API_CODE_UNSUPPORTED
                        "modes can be data only for pendulums of at most %d arms",
                        PEND_FIT_MODE_ARMS);
    if (fit->tree.cart)
        api_value_fault(list, problem,
                        API_CODE_UNSUPPORTED "cannot be data for a pendulum on a cart");
    if (!fit->tree.terms && !(fit->tree.loads.gravity > 0))
        api_value_fault(list, problem,
                        API_CODE_NOT_APPLICABLE
                        "need a hanging pendulum: without gravity above 0 it does not swing");
    struct api_value item = api_value_item(list, 0);
    for (int c = first; c < fit->columns; c++, item = api_value_next(&item))
        read_mode(fit, &item, &fit->column[c], fit->data + (size_t)c * (size_t)fit->rows, problem);
}
