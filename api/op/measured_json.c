#include "api/op/measured_json.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/text.h"
#include "api/json/json_out.h"

enum { NAMES_BYTES = 400, GAP_BYTES = 100, LISTED = 64, MANY_ROWS = 8 };

static const double pi = 3.14159265358979323846;

/* an angle's zero counts as shifted if it is off by this many standard errors and this fraction of
 * half a swing */
static const double zero_errors = 4, zero_share = 0.01;

/* a tip counts as moving on an arc if a parabola explains this fraction of its rise */
static const double bent_share = 0.3;

static int is_place(enum api_csv_role role) { return role == API_CSV_X || role == API_CSV_Y; }

/* writes the names of a table's columns, and why they are not used, for a message */
static const char *measured_names(const struct api_measured *table, char out[NAMES_BYTES]) {
    size_t at = 0;
    for (int i = 0; i < table->csv.columns && at < NAMES_BYTES - 150; i++) {
        const struct api_csv_cell *name = &table->csv.column[i].name;
        const struct api_csv_taken *taken = &table->roles.column[i];
        const char *why = taken->role == API_CSV_NONE ? taken->why : NULL;
        int bytes = (int)api_text_cut(name->bytes ? name->at : "", (size_t)name->bytes, 40);
        at += (size_t)snprintf(out + at, NAMES_BYTES - at, "%s\"%.*s\"%s%s%s", at ? ", " : "",
                               bytes, bytes ? name->at : "", why ? " (" : "", why ? why : "",
                               why ? ")" : "");
    }
    return out;
}

/* reads the request's `columns`, names that replace the table's; returns their number */
static int read_given(const struct api_value *columns, struct api_csv_cell given[],
                      struct api_problem *problem) {
    struct api_value item = api_value_item(columns, 0);
    int count = api_value_count(columns);
    if (api_value_kind(columns) != API_MISSING &&
        (api_value_kind(columns) != API_ARRAY || count > API_CSV_COLUMNS)) {
        api_value_fault(columns, problem,
                        API_CODE_WRONG_COUNT
                        "must be an array of at most %d names, one for each column",
                        API_CSV_COLUMNS);
        return 0;
    }
    for (int i = 0; api_value_kind(&item) != API_MISSING; item = api_value_next(&item), i++) {
        const char *name = api_value_text(&item);
        given[i] = (struct api_csv_cell){name, name ? (int)strlen(name) : 0};
    }
    return api_value_kind(columns) == API_MISSING ? 0 : count;
}

/* adds errors for given names that are not quantities of this pendulum */
static void check_given(const struct api_measured *table, const struct api_value *columns,
                        struct api_problem *problem) {
    struct api_value item = api_value_item(columns, 0);
    for (int i = 0; api_value_kind(&item) != API_MISSING; item = api_value_next(&item), i++) {
        const char *name = api_value_text(&item), *why = "is after the table's last column";
        if (i < table->csv.columns) why = table->roles.column[i].why;
        int taken = i < table->csv.columns && table->roles.column[i].role != API_CSV_NONE;
        if (name ? !*name || taken : api_value_kind(&item) == API_NULL) continue;
        api_value_fault(&item, problem,
                        API_CODE_OUT_OF_RANGE
                        "%s: write t, theta_1, phi_1, x_1, y_1, thetad_1 or sigma_theta_1, "
                        "followed by a unit such as (deg), \"\" to leave the column out, or null",
                        name && why ? why : "does not name a quantity of a pendulum");
    }
}

/* whether a row equals the previous row in all columns that are used */
static int measured_repeats(const struct api_measured *table, const double row[],
                            const double before[]) {
    for (int i = 0; i < table->csv.columns; i++) {
        if (table->roles.column[i].role == API_CSV_NONE) continue;
        if (row[i] != before[i] && !(isnan(row[i]) && isnan(before[i]))) return 0;
    }
    return 1;
}

/* counts repeated rows, and determines the direction of y: a tip that hangs below its pivot is
 * lowest in the middle of its swing */
static void measured_rows(struct api_measured *table) {
    const struct api_csv *csv = &table->csv;
    double row[2][API_CSV_COLUMNS], n = 0, v = 0, uu = 0, uuv = 0, uuuu = 0;
    const char *at = csv->begin;
    int line = csv->first - 1, last = 0, of[2] = {0, 0}; // line numbers; columns of x and y
    for (int i = csv->columns - 1; i > 0; i--) {
        const struct api_csv_taken *taken = &table->roles.column[i];
        if (taken->arm == 1 && is_place(taken->role)) of[taken->role == API_CSV_Y] = i;
    }
    const struct api_csv_column *x = &csv->column[of[0]], *y = &csv->column[of[1]];
    for (long count = 0; api_csv_row(csv, &at, &line, row[!last]); count++) {
        last = !last;
        table->repeated += count && measured_repeats(table, row[last], row[!last]);
        if (table->roles.time >= 0 && isnan(row[last][table->roles.time]) && !table->untimed)
            table->untimed = line;
        double across = pow(row[last][of[0]] - (x->low + x->high) / 2, 2);
        double along = row[last][of[1]] - y->first;
        if (isnan(across) || isnan(along)) continue;
        n++, v += along, uu += across, uuv += across * along, uuuu += across * across;
    }
    // fits y as a linear function of x^2 by least squares
    double half = (x->high - x->low) / 2, bend = (n * uuv - uu * v) / (n * uuuu - uu * uu);
    table->downwards =
        of[0] && of[1] && n >= MANY_ROWS && bend * half * half < -bent_share * (y->high - y->low);
}

/* adds advice if an angle does not swing about hanging */
static void measured_zero(struct api_measured *table) {
    for (int i = 0; i < table->csv.columns && !*table->advice; i++) {
        const struct api_csv_taken *taken = &table->roles.column[i];
        double center, error, reach;
        if (!api_csv_is_angle(taken->role)) continue;
        if (!api_csv_center(&table->csv.column[i], &center, &error, &reach)) continue;
        if (!(reach * taken->unit < pi)) continue; // skip an angle that passes over the top
        double rest = taken->role == API_CSV_PHI ? -pi / 2 / taken->unit : 0;
        if (!(fabs(center - rest) > fmax(zero_errors * error, zero_share * reach))) continue;
        snprintf(table->advice, sizeof table->advice,
                 "the data of column %d swing about %.4g %s: is the zero shifted? Then make "
                 "\"zero\" of arm %d an unknown",
                 i + 1, center, taken->unit == 1 ? "rad" : "degrees", taken->arm);
    }
}

int api_measured_read(struct api_measured *table, const struct api_tree *tree,
                      const struct api_value *data, struct api_problem *problem) {
    struct api_value text = api_value_member(data, "csv"), arms = api_value_member(data, "arms"),
                     unit = api_value_member(data, "unit"),
                     columns = api_value_member(data, "columns");
    struct api_csv_cell given[API_CSV_COLUMNS] = {{NULL, 0}};
    int listed[LISTED], degrees = -1;
    struct api_csv_hints hints = {
        .arms = tree->n, .cart = tree->cart, .listed = listed, .given = given};
    struct api_value arm = api_value_item(&arms, 0);
    *table = (struct api_measured){.roles = {.time = -1}};
    for (; api_value_kind(&arm) != API_MISSING && hints.count < LISTED; arm = api_value_next(&arm))
        listed[hints.count++] = api_tree_read_arm(tree, &arm, problem) + 1;
    (void)api_field_word(&unit, api_field_angles, &degrees, problem);
    hints.degrees = degrees, hints.gives = read_given(&columns, given, problem);
    if (!api_value_text(&text)) {
        api_value_fault(&text, problem, API_CODE_WRONG_TYPE "must be a table as text");
        return 0;
    }
    if (!api_csv_look(&table->csv, api_value_text(&text))) {
        const char *head = api_value_text(&text);
        api_value_fault(
            &text, problem,
            head[strspn(head, " \r\n")] == '<' ? API_CODE_WRONG_TYPE
                "is XML, not a table: save Tracker's data by File > Export > Data File"
                                               : API_CODE_MISSING
                "has no row of two or more numbers: each row needs a time in s, then angles or "
                "positions");
        return 0;
    }
    // if the pendulum is invalid, an error has been added already
    if (!tree->n && problem->status) return 0;
    api_csv_guess(&table->roles, &table->csv, &hints);
    check_given(table, &columns, problem);
    measured_rows(table);
    measured_zero(table);
    return !problem->status;
}

/* adds errors for missing numbers and for words among numbers; returns 0 after an error */
static int measured_gap(const struct api_measured *table, char out[GAP_BYTES]) {
    *out = 0;
    for (int i = 0; i < table->csv.columns && !*out; i++) {
        const struct api_csv_column *column = &table->csv.column[i];
        if (table->roles.column[i].role == API_CSV_NONE || !column->words) continue;
        snprintf(out, GAP_BYTES,
                 "line %d: field %d must be a number, or empty where nothing was measured",
                 column->word_line, i + 1);
    }
    if (!*out && table->untimed)
        snprintf(out, GAP_BYTES, "line %d: t must be a number", table->untimed);
    return *out != 0;
}

int api_measured_check(const struct api_measured *table, const struct api_value *text,
                       struct api_problem *problem) {
    char names[NAMES_BYTES], gap[GAP_BYTES];
    if (table->roles.time < 0)
        api_value_fault(text, problem,
                        API_CODE_MISSING
                        "has no column of instants: call it t, in s; its columns are %s",
                        measured_names(table, names));
    else if (!table->roles.measured)
        api_value_fault(
            text, problem,
            API_CODE_MISSING
            "has no column of angles or positions: theta_1, phi_1, x_1, y_1; its columns are %s",
            measured_names(table, names));
    else if (measured_gap(table, gap))
        api_value_fault(text, problem, API_CODE_WRONG_TYPE "%s", gap);
    return !problem->status;
}

double *api_measured_rows(const struct api_measured *table) {
    const int width = table->csv.columns;
    const char *at = table->csv.begin;
    long count = 0;
    // space for one more row, because the last one may be a repetition
    double *row = malloc((size_t)(table->csv.rows + 1) * (size_t)width * sizeof *row), *now = row;
    for (int line = 0; row && api_csv_row(&table->csv, &at, &line, now); now = row + count * width)
        count += !count || !measured_repeats(table, now, now - width);
    assert(!row || count == table->csv.rows - table->repeated);
    return row;
}

double api_measured_value(const struct api_measured *table, int column, const double row[]) {
    const struct api_csv_taken *roles = table->roles.column, *taken = &roles[column];
    int sigma = taken->role == API_CSV_SIGMA, error = sigma ? column : taken->of;
    double unit = is_place(sigma ? roles[taken->of].role : taken->role) ? 1 : taken->unit;
    if (error >= 0 && !(row[error] > 0)) return sigma ? 1 : NAN;
    return row[column] * unit - (taken->role == API_CSV_TIME ? table->roles.origin : 0);
}

/* ---- writing */

/* {"column": 2, "name": "x_m2", "is": "x 2", "sure": false, "why": "..."} */
static enum pend_status write_column(const struct api_measured *table, int i,
                                     struct api_buffer *out) {
    const struct api_csv_taken *taken = &table->roles.column[i];
    const struct api_csv_cell *name = &table->csv.column[i].name;
    int error = taken->role == API_CSV_SIGMA;
    enum api_csv_role role = error ? table->roles.column[taken->of].role : taken->role;
    char is[40] = "";
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "column", i + 1));
    PEND_TRY(api_out_key(out, "name"));
    PEND_TRY(api_text_quote(out, name->bytes ? name->at : "", (size_t)name->bytes));
    snprintf(is, sizeof is, taken->arm && role != API_CSV_CART ? "%s%s %d" : "%s%s",
             error ? "sigma " : "", api_csv_role_name(role), taken->arm);
    PEND_TRY(api_out_text(out, "is", is));
    if (taken->unit > 0) PEND_TRY(api_out_number(out, "unit", taken->unit, 0));
    PEND_TRY(api_out_key(out, "sure"));
    PEND_TRY(api_buffer_text(out, taken->sure || taken->role == API_CSV_NONE ? "true" : "false"));
    if (taken->why) PEND_TRY(api_out_text(out, "why", taken->why));
    return api_buffer_text(out, "}");
}

static enum pend_status write_rows(const struct api_measured *table, int rows,
                                   struct api_buffer *out) {
    const char *at = table->csv.begin;
    double value[API_CSV_COLUMNS];
    int line = 0;
    PEND_TRY(api_out_open(out, "first", '['));
    while (rows-- > 0 && api_csv_row(&table->csv, &at, &line, value)) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "["));
        for (int i = 0; i < table->csv.columns; i++) PEND_TRY(api_out_maybe(out, NULL, value[i]));
        PEND_TRY(api_buffer_text(out, "]"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status write_values(const struct api_measured *table, const char *name, int i,
                                     const double *row, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, name, '['));
    for (long k = table->csv.rows - table->repeated; k > 0; k--, row += table->csv.columns)
        PEND_TRY(api_out_maybe(out, NULL, api_measured_value(table, i, row)));
    return api_buffer_text(out, "]");
}

/* {"t": [...], "series": [{"theta": 1, "values": [...], "sigma": [...]}]} */
static enum pend_status write_series(const struct api_measured *table, const double *row,
                                     struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "data", '{'));
    PEND_TRY(write_values(table, "t", table->roles.time, row, out));
    PEND_TRY(api_out_open(out, "series", '['));
    for (int i = 0; i < table->csv.columns; i++) {
        const struct api_csv_taken *taken = &table->roles.column[i];
        if (taken->role < API_CSV_THETA || taken->role >= API_CSV_SIGMA) continue;
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_key(out, api_csv_role_name(taken->role)));
        PEND_TRY(taken->role == API_CSV_CART ? api_buffer_text(out, "true")
                                             : api_buffer_format(out, "%d", taken->arm));
        PEND_TRY(write_values(table, "values", i, row, out));
        if (taken->of >= 0) PEND_TRY(write_values(table, "sigma", taken->of, row, out));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]}");
}

static enum pend_status write_data(const struct api_measured *table, struct api_buffer *out) {
    char gap[GAP_BYTES];
    if (table->roles.time < 0 || !table->roles.measured || measured_gap(table, gap)) return PEND_OK;
    double *row = api_measured_rows(table);
    enum pend_status status = row ? write_series(table, row, out) : PEND_NO_MEMORY;
    free(row);
    return status;
}

static enum pend_status write_advice(const struct api_measured *table, struct api_buffer *out) {
    int time = table->roles.time;
    char gap[GAP_BYTES];
    const struct {
        int is;
        const char *text;
    } advice[] = {
        {time < 0, "no column of times was found: name it in \"columns\""},
        {time >= 0 && !table->csv.column[time].rises,
         "the instants are not in order: rows are sorted"},
        {!table->roles.measured,
         "no column of angles or positions was found: name it in \"columns\""},
        {table->roles.second, "the file has a second table next to the first, which is not read"},
        {table->csv.doubtful,
         "a comma was read as the decimal mark: no number shows whether it separates thousands"},
        {table->downwards, "y increases downwards, as in images: give \"camera\" \"down\": true"},
        {measured_gap(table, gap), gap},
        {*table->advice != 0, table->advice}};
    PEND_TRY(api_out_open(out, "suggestions", '['));
    for (size_t i = 0; i < sizeof advice / sizeof *advice; i++)
        if (advice[i].is) PEND_TRY(api_out_text(out, NULL, advice[i].text));
    return api_buffer_text(out, "]");
}

enum pend_status api_measured_write(const struct api_measured *table, int rows, int data,
                                    struct api_buffer *out) {
    const struct api_csv *csv = &table->csv;
    char separator[2] = {csv->separator, 0};
    assert(csv->rows >= 1 && csv->columns >= 2);
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "rows", csv->rows - table->repeated));
    PEND_TRY(api_out_whole(out, "repeated", table->repeated));
    PEND_TRY(api_out_whole(out, "passed_over", csv->passed));
    PEND_TRY(api_out_text(out, "separator", separator));
    PEND_TRY(api_out_text(out, "decimal", csv->comma ? "," : "."));
    PEND_TRY(api_out_open(out, "columns", '['));
    for (int i = 0; i < csv->columns; i++) PEND_TRY(write_column(table, i, out));
    PEND_TRY(api_buffer_text(out, "]"));
    if (rows) PEND_TRY(write_rows(table, rows, out));
    if (data) PEND_TRY(write_data(table, out));
    PEND_TRY(write_advice(table, out));
    return api_buffer_text(out, "}");
}
