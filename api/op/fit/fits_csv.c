#include "api/op/fit/fits_csv.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "api/base/text.h"
#include "api/csv/csv_roles.h"
#include "api/json/json_out.h"

static const double pi = 3.14159265358979323846;

static const char *const angle_units[] = {"rad", "deg", NULL};

/* the names of a table's columns, and why one is not used, for a message */
static const char *csv_names(const struct api_csv *csv, const struct api_csv_roles *roles,
                             char out[400]) {
    size_t at = 0;
    for (int i = 0; i < csv->columns && at < 250; i++) {
        const struct api_csv_cell *name = &csv->column[i].name;
        const char *why = roles->column[i].role == API_CSV_NONE ? roles->column[i].why : NULL;
        int bytes = (int)api_text_cut(name->bytes ? name->at : "", (size_t)name->bytes, 40);
        at += (size_t)snprintf(out + at, 400 - at, "%s\"%.*s\"%s%s%s", at ? ", " : "", bytes,
                               bytes ? name->at : "", why ? " (" : "", why ? why : "",
                               why ? ")" : "");
    }
    return out;
}

/* what a table is of, for a pendulum and what the request says of it; 0 after a fault */
static int csv_look(struct api_csv *csv, struct api_csv_roles *roles, const struct api_tree *tree,
                    const struct api_value *data, const struct api_value *text,
                    struct api_problem *problem) {
    struct api_value arms = api_value_member(data, "arms"), unit = api_value_member(data, "unit");
    int listed[API_FIT_SERIES], degrees = -1, fitted = 0;
    char names[400];
    struct api_csv_hints hints = {.arms = tree->n, .listed = listed};
    struct api_value arm = api_value_item(&arms, 0);
    for (; api_value_kind(&arm) != API_MISSING && hints.count < API_FIT_SERIES;
         arm = api_value_next(&arm))
        listed[hints.count++] = api_tree_read_arm(tree, &arm, problem) + 1;
    (void)api_field_word(&unit, angle_units, &degrees, problem);
    hints.degrees = degrees;
    if (!api_value_text(text)) {
        api_value_fault(text, problem, API_CODE_WRONG_TYPE "must be a table as text");
        return 0;
    }
    if (!api_csv_look(csv, api_value_text(text))) {
        api_value_fault(text, problem,
                        API_CODE_MISSING "has no rows of two or more numbers: instants in s, and "
                                         "angles or places");
        return 0;
    }
    // where no pendulum could be read, that has been said
    if (!tree->n) return 0;
    api_csv_guess(roles, csv, &hints);
    for (int i = 0; i < csv->columns; i++)
        fitted += roles->column[i].role >= API_CSV_THETA && roles->column[i].role <= API_CSV_Y;
    if (roles->time < 0)
        api_value_fault(text, problem,
                        API_CODE_MISSING
                        "has no column of instants: call it t, in s; its columns are %s",
                        csv_names(csv, roles, names));
    else if (!fitted)
        api_value_fault(text, problem,
                        API_CODE_MISSING "has no column of angles or places: theta_1, phi_1, x_1, "
                                         "y_1; its columns are %s",
                        csv_names(csv, roles, names));
    return !problem->status;
}

/* faults the columns that are used and have words among their numbers */
static void csv_words(const struct api_csv *csv, const struct api_csv_roles *roles,
                      const struct api_value *text, struct api_problem *problem) {
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_column *column = &csv->column[i];
        if (roles->column[i].role == API_CSV_NONE || !column->words) continue;
        api_value_fault(text, problem,
                        API_CODE_WRONG_TYPE "line %d: field %d must be a number, or empty where "
                                            "nothing was measured",
                        column->word_line, i + 1);
    }
}

/* the quantity of a column, and its series in the run */
static void csv_series(struct api_fit_part *run, int c, const struct api_csv_taken *taken,
                       double error) {
    struct pend_fit_column *column = &run->column[c];
    column->kind = taken->role == API_CSV_X   ? PEND_FIT_X
                   : taken->role == API_CSV_Y ? PEND_FIT_Y
                                              : PEND_FIT_PHI;
    column->arm = taken->arm - 1;
    column->sigma = error * (column->kind == PEND_FIT_PHI ? taken->unit : 1);
    run->zero[c] = taken->role == API_CSV_THETA ? -pi / 2 : 0;
}

/* what has no error of its own, where the others have, was not measured */
static void part_weigh(struct api_fit_part *run, long row, long all) {
    for (int c = 0; c < run->columns; c++) {
        double *each = &run->each[c * all + row];
        if (!run->column[c].each || *each > 0) continue;
        *each = 1, run->data[c * all + row] = NAN;
    }
}

/* whether a row says what the row before it says */
static int row_repeats(const struct api_fit_part *run, long row, long all) {
    if (!row || run->t[row] != run->t[row - 1]) return 0;
    for (int c = 0; c < run->columns; c++) {
        double now = run->data[c * all + row], before = run->data[c * all + row - 1];
        if (now != before && !(isnan(now) && isnan(before))) return 0;
    }
    return 1;
}

/* the rows of a table; a row that is there twice counts once */
static void csv_rows(struct api_fit_part *run, const struct api_csv *csv,
                     const struct api_csv_roles *roles, const int series[],
                     const struct api_value *text, struct api_problem *problem) {
    const char *at = csv->begin;
    double value[API_CSV_COLUMNS];
    long row = 0, all = run->rows;
    int line = csv->first - 1;
    const struct api_csv_taken *time = &roles->column[roles->time];
    while (api_csv_row(csv, &at, &line, value)) {
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
            // places are in the camera's unit, whatever it is
            double unit = run->column[c].kind == PEND_FIT_PHI ? taken->unit : 1;
            double x = value[i] * unit + (sigma ? 0 : run->zero[c]);
            (sigma ? run->each : run->data)[c * all + row] = x;
        }
        part_weigh(run, row, all);
        row += !row_repeats(run, row, all);
    }
    run->rows = row;
    for (int c = 0; c < run->columns && row < all; c++) {
        memmove(run->data + c * row, run->data + c * all, (size_t)row * sizeof(double));
        memmove(run->each + c * row, run->each + c * all, (size_t)row * sizeof(double));
    }
}

/* {"column": 2, "name": "x_m2", "is": "x 2", "sure": false, "why": "..."} */
static enum pend_status csv_write_column(const struct api_csv *csv,
                                         const struct api_csv_roles *roles, int i,
                                         struct api_buffer *out) {
    const struct api_csv_taken *taken = &roles->column[i];
    const struct api_csv_cell *name = &csv->column[i].name;
    char is[40] = "";
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "column", i + 1));
    PEND_TRY(api_out_key(out, "name"));
    PEND_TRY(api_text_quote(out, name->bytes ? name->at : "", (size_t)name->bytes));
    if (taken->role == API_CSV_SIGMA)
        snprintf(is, sizeof is, "sigma of column %d", taken->of + 1);
    else
        snprintf(is, sizeof is, taken->arm ? "%s %d" : "%s", api_csv_role_name(taken->role),
                 taken->arm);
    PEND_TRY(api_out_text(out, "is", taken->role == API_CSV_RATE ? "" : is));
    if (taken->unit > 0) PEND_TRY(api_out_number(out, "unit", taken->unit, 0));
    PEND_TRY(api_out_key(out, "sure"));
    PEND_TRY(api_buffer_text(out, taken->sure || taken->role == API_CSV_NONE ? "true" : "false"));
    const char *why = taken->role == API_CSV_RATE ? "rates are not fitted" : taken->why;
    if (why) PEND_TRY(api_out_text(out, "why", why));
    return api_buffer_text(out, "}");
}

/* what the columns of a table were taken for, as JSON */
static enum pend_status csv_write(const struct api_csv *csv, const struct api_csv_roles *roles,
                                  long used, struct api_buffer *out) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "rows", used));
    PEND_TRY(api_out_whole(out, "repeated", csv->rows - used));
    PEND_TRY(api_out_whole(out, "passed_over", csv->passed));
    if (csv->doubtful)
        PEND_TRY(api_out_text(out, "why",
                              "a comma was taken for the decimal mark: no number tells whether it "
                              "marks thousands"));
    PEND_TRY(api_out_open(out, "columns", '['));
    for (int i = 0; i < csv->columns; i++) PEND_TRY(csv_write_column(csv, roles, i, out));
    return api_buffer_text(out, "]}");
}

/* what of a table becomes a series: series[column], -1 for what does not; returns how many */
static int csv_choose(const struct api_csv *csv, const struct api_csv_roles *roles, int scaled,
                      int series[], const struct api_value *text, struct api_problem *problem) {
    int count = 0;
    double unit = 0;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_taken *taken = &roles->column[i];
        int place = taken->role == API_CSV_X || taken->role == API_CSV_Y;
        int angle = taken->role == API_CSV_THETA || taken->role == API_CSV_PHI;
        series[i] = (place || angle) && count < API_FIT_SERIES ? count++ : -1;
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
    struct api_csv csv;
    struct api_csv_roles roles;
    double error = 0;
    int series[API_CSV_COLUMNS];
    (void)api_value_read_number(&sigma, 1e-12, 1e12, "", &error, problem);
    if (!csv_look(&csv, &roles, tree, data, &text, problem)) return PEND_INVALID;
    csv_words(&csv, &roles, &text, problem);
    int count =
        csv_choose(&csv, &roles, api_value_kind(&scale) != API_MISSING, series, &text, problem);
    if (problem->status) return PEND_INVALID;
    PEND_TRY(api_fit_part_room(run, csv.rows, count, data, reading));
    for (int i = 0; i < csv.columns; i++)
        if (series[i] >= 0) csv_series(run, series[i], &roles.column[i], error);
    if (!error) csv_weighted(run, &csv, &roles, series);
    csv_rows(run, &csv, &roles, series, &text, problem);
    if (!error) csv_weighted(run, &csv, &roles, series);
    return csv_write(&csv, &roles, run->rows, run->tables);
}
