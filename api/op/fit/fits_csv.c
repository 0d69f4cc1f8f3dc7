#include "api/op/fit/fits_csv.h"

#include <math.h>
#include <string.h>

#include "api/op/measured_json.h"

static const double pi = 3.14159265358979323846;

/* what a number of the table is: places are in the camera's unit, whatever it is */
static double series_unit(const struct pend_fit_column *column, const struct api_csv_taken *taken) {
    return column->kind == PEND_FIT_X || column->kind == PEND_FIT_Y ? 1 : taken->unit;
}

/* the quantity of a column, and its series in the run */
static void csv_series(struct api_fit_part *run, int c, const struct api_tree *tree,
                       const struct api_csv_taken *taken, double error) {
    struct pend_fit_column *column = &run->column[c];
    column->kind = taken->role == API_CSV_X      ? PEND_FIT_X
                   : taken->role == API_CSV_Y    ? PEND_FIT_Y
                   : taken->role == API_CSV_RATE ? PEND_FIT_RATE
                                                 : PEND_FIT_PHI;
    column->arm = taken->arm - 1;
    column->joint = taken->role == API_CSV_JOINT && api_tree_parent(tree, column->arm) >= 0;
    column->sigma = error * series_unit(column, taken);
    int hanging = taken->role == API_CSV_THETA || (taken->role == API_CSV_JOINT && !column->joint);
    run->zero[c] = hanging ? -pi / 2 : 0;
}

/* what has no error of its own, where the others have, was not measured */
static void part_weigh(struct api_fit_part *run, long row, long all) {
    for (int c = 0; c < run->columns; c++) {
        double *each = &run->each[c * all + row];
        if (!run->column[c].each || *each > 0) continue;
        *each = 1, run->data[c * all + row] = NAN;
    }
}

/* the rows of a table; a row that is there twice counts once */
static void csv_rows(struct api_fit_part *run, const struct api_measured *table, const int series[],
                     const struct api_value *text, struct api_problem *problem) {
    const struct api_csv *csv = &table->csv;
    const struct api_csv_roles *roles = &table->roles;
    const char *at = csv->begin;
    double both[2][API_CSV_COLUMNS];
    long row = 0, all = run->rows;
    int line = csv->first - 1, which = 0;
    const struct api_csv_taken *time = &roles->column[roles->time];
    for (; api_csv_row(csv, &at, &line, both[which]); which = !which) {
        const double *value = both[which];
        if (row && api_measured_repeats(table, value, both[!which])) continue;
        if (isnan(value[roles->time])) {
            api_value_fault(text, problem, API_CODE_WRONG_TYPE "line %d: t must be a number", line);
            return;
        }
        run->t[row] = value[roles->time] * time->unit - roles->origin;
        for (int i = 0; i < csv->columns; i++) {
            const struct api_csv_taken *taken = &roles->column[i];
            int sigma = taken->role == API_CSV_SIGMA;
            int c = sigma ? series[taken->of] : series[i];
            if (c < 0) continue;
            double unit = series_unit(&run->column[c], taken);
            double x = value[i] * unit + (sigma ? 0 : run->zero[c]);
            (sigma ? run->each : run->data)[c * all + row] = x;
        }
        part_weigh(run, row++, all);
    }
    run->rows = row;
    for (int c = 0; c < run->columns && row < all; c++) {
        memmove(run->data + c * row, run->data + c * all, (size_t)row * sizeof(double));
        memmove(run->each + c * row, run->each + c * all, (size_t)row * sizeof(double));
    }
}

/* what of a table becomes a series: series[column], -1 for what does not; returns how many */
static int csv_choose(const struct api_csv *csv, const struct api_csv_roles *roles, int scaled,
                      int series[], const struct api_value *text, struct api_problem *problem) {
    int count = 0;
    double unit = 0;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_taken *taken = &roles->column[i];
        int place = taken->role == API_CSV_X || taken->role == API_CSV_Y;
        int turns = taken->role != API_CSV_NONE && taken->role != API_CSV_TIME &&
                    taken->role != API_CSV_SIGMA;
        series[i] = turns && count < API_FIT_SERIES ? count++ : -1;
        if (!place) continue;
        // in metres such places would be of another pendulum
        if (unit > 0 && taken->unit != unit)
            api_value_fault(text, problem,
                            API_CODE_CONFLICT
                            "line %d: field %d is in another unit than the places before it: give "
                            "all in one",
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

/* the errors that a table lists are those of its series: kept there before the rows are read, and
 * where they lie once it is known how many there are */
static void csv_weighted(struct api_fit_part *run, const struct api_csv *csv,
                         const struct api_csv_roles *roles, const int series[]) {
    for (int i = 0; i < csv->columns; i++) {
        int c = roles->column[i].role == API_CSV_SIGMA ? series[roles->column[i].of] : -1;
        if (c >= 0) run->column[c].each = run->each + (size_t)c * (size_t)run->rows;
    }
}

enum pend_status api_fit_csv_read(struct api_fit_part *run, const struct api_tree *tree,
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
    PEND_TRY(api_fit_part_room(run, csv->rows, count, data, reading));
    for (int i = 0; i < csv->columns; i++)
        if (series[i] >= 0) csv_series(run, series[i], tree, &table.roles.column[i], error);
    if (!error) csv_weighted(run, csv, &table.roles, series);
    csv_rows(run, &table, series, &text, problem);
    if (!error) csv_weighted(run, csv, &table.roles, series);
    if (*table.advice) memcpy(run->advice, table.advice, sizeof table.advice);
    return api_measured_write(&table, 0, run->tables);
}
