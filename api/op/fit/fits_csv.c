#include "api/op/fit/fits_csv.h"

#include <stdlib.h>
#include <string.h>

#include "api/op/measured_json.h"

static const double pi = 3.14159265358979323846;

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
    column->sigma =
        error * (column->kind == PEND_FIT_X || column->kind == PEND_FIT_Y ? 1 : taken->unit);
    if (taken->of >= 0) column->each = run->each + (size_t)c * (size_t)run->rows;
    int hanging = taken->role == API_CSV_THETA || (taken->role == API_CSV_JOINT && !column->joint);
    run->zero[c] = hanging ? -pi / 2 : 0;
}

/* the rows of a table */
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
    PEND_TRY(api_fit_part_room(run, csv->rows - table.repeated, count, data, reading));
    for (int i = 0; i < csv->columns; i++) {
        struct api_csv_taken *taken = &table.roles.column[i];
        if (series[i] < 0) continue;
        if (error > 0) taken->of = -1;
        csv_series(run, series[i], tree, taken, error);
    }
    PEND_TRY(csv_rows(run, &table, series));
    if (*table.advice) memcpy(run->advice, table.advice, sizeof table.advice);
    return api_measured_write(&table, 0, 0, run->tables);
}
