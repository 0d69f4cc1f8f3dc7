#include "api/op/fit/fits_data.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/fit/fits_modes.h"
#include "api/op/measured_json.h"

static const double pi = 3.14159265358979323846;

static const char *const data_fields[] = {"t",    "series", "csv",   "arms",    "sigma",
                                          "unit", "runs",   "modes", "columns", NULL};
static const char *const run_fields[] = {"t",    "series",  "csv",   "arms",    "sigma",
                                         "unit", "initial", "start", "columns", NULL};
static const char *const series_fields[] = {"phi",    "theta",  "joint", "x",    "y", "phid",
                                            "thetad", "values", "sigma", "unit", NULL};
static const char *const angle_units[] = {"rad", "deg", NULL};

/* One run of the request; missing measurements are NaN. */
struct part {
    long rows;
    int columns;
    double *t, *data, *each;
    double *taken;             /* bytes of all runs together */
    char *advice;              /* likely mistakes in the tables of all runs, or "" */
    struct api_buffer *tables; /* JSON: the roles of the columns of all runs' tables */
    struct pend_fit_column column[API_FIT_SERIES];
    double zero[API_FIT_SERIES]; /* rad, the phi at which the series is 0 */
};

/* adds a fault if a run of this size, with the runs before it, exceeds max-answer-bytes */
static int part_fits(double rows, double columns, double *taken, const struct api_value *data,
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

static enum pend_status part_room(struct part *part, long rows, int columns,
                                  const struct api_value *data, const struct api_reading *reading) {
    size_t count = (size_t)rows * (size_t)columns;
    if (!part_fits((double)rows, columns, part->taken, data, reading)) return PEND_INVALID;
    part->t = malloc((size_t)(rows + 1) * sizeof(double));
    part->data = malloc((count + 1) * sizeof(double));
    part->each = malloc((count + 1) * sizeof(double));
    if (!part->t || !part->data || !part->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) part->data[i] = NAN;
    part->rows = rows, part->columns = columns;
    return PEND_OK;
}

/* initializes empty runs, which share one count of bytes */
static struct part *parts_new(int runs, double *taken, struct api_fit *fit) {
    struct part *part = calloc((size_t)runs, sizeof *part);
    for (int r = 0; part && r < runs; r++)
        part[r].taken = taken, part[r].tables = &fit->tables, part[r].advice = fit->advice;
    return part;
}

static void parts_free(struct part part[], int runs) {
    for (int r = 0; r < runs; r++) {
        free(part[r].t);
        free(part[r].data);
        free(part[r].each);
    }
    free(part);
}

/* reads an array of numbers, or null for missing measurements */
static void read_values(struct part *run, int c, const struct api_value *list, double scale,
                        double shift, struct api_problem *problem) {
    double *to = run->data + (size_t)c * (size_t)run->rows;
    if (api_value_kind(list) != API_ARRAY || api_value_count(list) != run->rows) {
        api_value_fault(list, problem,
                        API_CODE_WRONG_COUNT "must be %ld numbers or nulls, one for each instant",
                        run->rows);
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

/* reads the standard deviation of a series, one number or one per instant; scale: of its unit */
static void read_sigma(struct part *run, int c, const struct api_value *sigma, double scale,
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
    struct api_value item = api_value_item(sigma, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        if (api_value_read_number(&item, least, most, "", &to[item.index], problem) > 0)
            to[item.index] *= scale;
    run->column[c].each = to;
}

static int is_place(const struct pend_fit_column *column) {
    return column->kind == PEND_FIT_X || column->kind == PEND_FIT_Y;
}

/* the quantity of a series, in the order of enum api_csv_role */
static const struct {
    const char *name;
    enum pend_fit_kind kind;
    int theta; /* 1 = measured from hanging; 2 = from the parent arm */
} kinds[] = {{"theta", PEND_FIT_PHI, 1}, {"phi", PEND_FIT_PHI, 0}, {"joint", PEND_FIT_PHI, 2},
             {"x", PEND_FIT_X, 0},       {"y", PEND_FIT_Y, 0},     {"thetad", PEND_FIT_RATE, 0},
             {"phid", PEND_FIT_RATE, 0}};

/* arm: -1 = none */
static void series_of(struct part *run, int c, const struct api_tree *tree, int kind, int arm) {
    struct pend_fit_column *column = &run->column[c];
    column->kind = kinds[kind].kind, column->arm = arm < 0 ? 0 : arm;
    column->joint = kinds[kind].theta == 2 && arm >= 0 && api_tree_parent(tree, arm) >= 0;
    run->zero[c] = kinds[kind].theta && !column->joint ? -pi / 2 : 0;
}

/* reads one series: its quantity, arm and standard deviation */
static void read_series(struct part *run, const struct api_tree *tree, const struct api_value *item,
                        struct api_problem *problem) {
    const int c = (int)item->index;
    struct api_value values = api_value_member(item, "values"),
                     sigma = api_value_member(item, "sigma"), unit = api_value_member(item, "unit");
    int found = 0, degrees = 0;
    if (!api_field_object(item, problem)) return;
    (void)api_value_only(item, series_fields, problem);
    for (int i = 0; i < (int)(sizeof kinds / sizeof *kinds); i++) {
        struct api_value arm = api_value_member(item, kinds[i].name);
        if (api_value_kind(&arm) == API_MISSING) continue;
        if (found++)
            api_value_fault(&arm, problem,
                            API_CODE_CONFLICT "is one quantity too many: give only one of phi, "
                                              "theta, joint, x, y, phid and thetad");
        series_of(run, c, tree, i, api_tree_read_arm(tree, &arm, problem));
    }
    if (!found)
        api_value_fault(item, problem,
                        API_CODE_MISSING
                        "needs one of phi, theta, joint, x, y, phid and thetad: the arm's number");
    if (api_field_word(&unit, angle_units, &degrees, problem) > 0 && is_place(&run->column[c]))
        api_value_fault(&unit, problem, API_CODE_NOT_APPLICABLE "is only for angles: leave it out");
    double scale = degrees ? pi / 180 : 1;
    read_sigma(run, c, &sigma, scale, problem);
    read_values(run, c, &values, scale, run->zero[c], problem);
}

/* instants and series */
static enum pend_status read_table(struct part *run, const struct api_tree *tree,
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
    PEND_TRY(part_room(run, rows, columns, data, reading));
    memcpy(run->t, t, (size_t)rows * sizeof *t);
    struct api_value item = api_value_item(&series, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item))
        read_series(run, tree, &item, problem);
    return PEND_OK;
}

/* ---- tables of text */

/* reads the rows of a table */
static enum pend_status csv_rows(struct part *run, const struct api_measured *table,
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
        int turns = taken->role >= API_CSV_THETA && taken->role <= API_CSV_RATE;
        series[i] = turns && count < API_FIT_SERIES ? count++ : -1;
        if (!place) continue;
        // mixed with metres, these positions would describe another pendulum
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

/* every series of a table that a fit can use; with the table's errors unless `sigma` is given */
static enum pend_status read_csv(struct part *run, const struct api_tree *tree,
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
    PEND_TRY(part_room(run, csv->rows - table.repeated, count, data, reading));
    for (int i = 0; i < csv->columns; i++) {
        struct api_csv_taken *taken = &table.roles.column[i];
        if (series[i] < 0) continue;
        struct pend_fit_column *column = &run->column[series[i]];
        series_of(run, series[i], tree, (int)taken->role - API_CSV_THETA, taken->arm - 1);
        column->sigma = error * (is_place(column) ? 1 : taken->unit);
        if (error > 0) taken->of = -1;
        if (taken->of >= 0) column->each = run->each + series[i] * run->rows;
    }
    PEND_TRY(csv_rows(run, &table, series));
    if (*table.advice) memcpy(run->advice, table.advice, sizeof table.advice);
    return api_measured_write(&table, 0, 0, run->tables);
}

/* ---- several runs */

/* a row of a run */
struct place {
    double since, t; /* s, from the start of its run, and as given */
    long row;
    int run;
};

static int place_before(const void *left, const void *right) {
    const struct place *a = left, *b = right;
    if (a->since != b->since) return a->since < b->since ? -1 : 1;
    if (a->run != b->run) return a->run < b->run ? -1 : 1;
    if (a->t != b->t) return a->t < b->t ? -1 : 1;
    return (a->row > b->row) - (a->row < b->row);
}

/* the column of a series, shared by all runs that measure it; an unknown sigma stays unknown */
static int data_column(struct api_fit *fit, const struct pend_fit_column *column, int run) {
    struct api_fit_run *own = &fit->run[run];
    int c = 0;
    for (; c < fit->columns; c++) {
        int taken = 0, known = fit->column[c].sigma > 0;
        for (int i = 0; i < own->series; i++) taken |= own->column[i] == c;
        if (!taken && fit->column[c].kind == column->kind && fit->column[c].arm == column->arm &&
            fit->column[c].joint == column->joint && known == pend_fit_known(column))
            break;
    }
    if (c == API_FIT_SERIES) return -1;
    if (c == fit->columns)
        fit->column[fit->columns++] = (struct pend_fit_column){.kind = column->kind,
                                                               .arm = column->arm,
                                                               .joint = column->joint,
                                                               .sigma = pend_fit_known(column)};
    return own->column[own->series++] = c;
}

/* sorts the rows of all runs by their time since the start of their run */
static enum pend_status data_order(struct api_fit *fit, const struct part part[], double shift,
                                   struct place **order) {
    long at = 0;
    struct place *place = *order = malloc((size_t)fit->rows * sizeof *place);
    if (!place) return PEND_NO_MEMORY;
    for (int r = 0; r < fit->runs; r++) {
        const struct api_fit_run *run = &fit->run[r];
        double first = INFINITY;
        for (long i = 0; i < part[r].rows; i++) first = fmin(first, part[r].t[i]);
        if (!run->begins && part[r].rows) fit->begin[r] = first + shift;
        for (long i = 0; i < part[r].rows; i++)
            place[at++] = (struct place){part[r].t[i] + shift - fit->begin[r], part[r].t[i], i, r};
    }
    assert(at == fit->rows);
    qsort(place, (size_t)fit->rows, sizeof *place, place_before);
    return PEND_OK;
}

/* assigns all series to columns; returns 0 if there are too many */
static int data_columns(struct api_fit *fit, const struct part part[], const struct api_value *data,
                        const struct api_reading *reading) {
    for (int r = 0; r < fit->runs; r++) {
        fit->run[r].rows = part[r].rows, fit->rows += part[r].rows;
        for (int c = 0; c < part[r].columns; c++) {
            int at = data_column(fit, &part[r].column[c], r);
            if (at >= 0) fit->zero[at] = part[r].zero[c];
            if (at >= 0) continue;
            api_value_fault(data, reading->problem,
                            API_CODE_WRONG_COUNT "has more than %d distinct series",
                            API_FIT_SERIES);
            return 0;
        }
    }
    return 1;
}

/* merges the measurements of all runs into one table, with `modes` columns at its end */
static enum pend_status data_merge(struct api_fit *fit, const struct part part[], int modes,
                                   double shift, const struct api_value *data,
                                   const struct api_reading *reading) {
    struct place *order;
    if (!data_columns(fit, part, data, reading)) return PEND_INVALID;
    fit->columns += modes, fit->modes = modes;
    size_t rows = (size_t)fit->rows, count = rows * (size_t)fit->columns;
    // keeps the runs in memory until their table is complete
    double *taken = part[0].taken;
    *taken += (double)(rows * (sizeof(struct place) + sizeof(int) + sizeof(long)));
    if (!part_fits((double)rows, fit->columns, taken, data, reading)) return PEND_INVALID;
    fit->t = malloc((rows + 1) * sizeof(double)), fit->of = malloc((rows + 1) * sizeof(int));
    fit->row = malloc((rows + 1) * sizeof(long));
    fit->data = malloc((count + 1) * sizeof(double));
    fit->each = malloc((count + 1) * sizeof(double));
    if (!fit->t || !fit->of || !fit->row || !fit->data || !fit->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) fit->data[i] = NAN, fit->each[i] = 1;
    PEND_TRY(data_order(fit, part, shift, &order));
    for (size_t i = 0; i < rows; i++) {
        const struct part *from = &part[order[i].run];
        const struct api_fit_run *run = &fit->run[order[i].run];
        fit->t[i] = from->t[order[i].row], fit->of[i] = order[i].run;
        fit->row[i] = order[i].row;
        for (int c = 0; c < run->series; c++) {
            size_t at = (size_t)run->column[c] * rows + i;
            fit->data[at] = from->data[(size_t)c * (size_t)from->rows + (size_t)order[i].row];
            fit->each[at] = pend_fit_sigma(&from->column[c], order[i].row);
        }
    }
    for (int c = 0; c < fit->columns; c++) {
        struct pend_fit_column *column = &fit->column[c];
        column->zero = api_fit_instrument(fit, column->kind, column->arm, column->joint) + 1;
        column->data = fit->data + (size_t)c * rows;
        if (column->sigma > 0) column->each = fit->each + (size_t)c * rows;
    }
    free(order);
    return PEND_OK;
}

/* ---- all of it */

/* reads the start and the measurements of a run: an item of `runs`, or the request with `data` */
static enum pend_status read_run(struct api_fit *fit, int r, struct part *part,
                                 const struct api_value *at, const struct api_value *data,
                                 const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(at, "initial"),
                     start = api_value_member(at, "start"), csv = api_value_member(data, "csv");
    struct api_fit_run *run = &fit->run[r];
    run->guessed = api_value_kind(&initial) == API_MISSING;
    api_states_read(fit->start, r, &initial, &fit->tree, reading->limits, problem);
    if (fit->start && fit->start->mode[r])
        api_value_fault(&initial, problem,
                        API_CODE_NOT_APPLICABLE
                        "must be given by angles: a fit cannot start in a mode");
    run->begins = api_value_read_number(&start, -1e9, 1e9, "s", &fit->begin[r], problem) > 0;
    if (!part) return PEND_OK;
    return api_value_kind(&csv) != API_MISSING ? read_csv(part, &fit->tree, data, reading)
                                               : read_table(part, &fit->tree, data, reading);
}

/* adds a fault for fields that belong to the runs */
static void fault_beside(const struct api_value *at, const char *const names[],
                         struct api_problem *problem) {
    for (int i = 0; names[i]; i++) {
        struct api_value value = api_value_member(at, names[i]);
        if (api_value_kind(&value) != API_MISSING)
            api_value_fault(&value, problem,
                            API_CODE_CONFLICT "belongs to a run: put it into each of \"runs\"");
    }
}

/* counts the runs of a request; 0 after a fault */
static int count_runs(const struct api_value *root, const struct api_value *data,
                      const struct api_value *runs, struct api_problem *problem) {
    static const char *const of_data[] = {"t",     "series", "csv",     "arms",
                                          "sigma", "unit",   "columns", NULL},
                             *const of_root[] = {"initial", "start", NULL};
    int count = api_value_count(runs);
    if (api_value_kind(runs) == API_MISSING) return 1;
    fault_beside(data, of_data, problem);
    fault_beside(root, of_root, problem);
    if (api_value_kind(runs) == API_ARRAY && count >= 1 && count <= API_FIT_RUNS) return count;
    api_value_fault(runs, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d runs",
                    API_FIT_RUNS);
    return 0;
}

/* reads all runs; `part` has one entry per run */
static enum pend_status read_runs(struct api_fit *fit, struct part part[],
                                  const struct api_value *data, int modes,
                                  const struct api_reading *reading) {
    struct api_value runs = api_value_member(data, "runs");
    int alone = modes && api_value_kind(&runs) == API_MISSING;
    static const char *const motion[] = {"t", "series", "csv"};
    for (size_t i = 0; i < sizeof motion / sizeof *motion; i++) {
        struct api_value value = api_value_member(data, motion[i]);
        alone &= api_value_kind(&value) == API_MISSING;
    }
    if (api_value_kind(&runs) == API_MISSING) {
        PEND_TRY(read_run(fit, 0, alone ? NULL : part, reading->root, data, reading));
        // if only modes are measured, the motion is just its first instant
        if (!alone) return PEND_OK;
        PEND_TRY(part_room(part, 1, 0, data, reading));
        part->t[0] = fit->begin[0];
        return PEND_OK;
    }
    struct api_value item = api_value_item(&runs, 0);
    for (int r = 0; r < fit->runs; r++, item = api_value_next(&item)) {
        if (!api_field_object(&item, reading->problem)) continue;
        (void)api_value_only(&item, run_fields, reading->problem);
        enum pend_status status = read_run(fit, r, &part[r], &item, &item, reading);
        if (status == PEND_NO_MEMORY) return status;
    }
    return PEND_OK;
}

enum pend_status api_fit_read_data(struct api_fit *fit, double shift,
                                   const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value data = api_value_member(reading->root, "data"),
                     runs = api_value_member(&data, "runs"),
                     modes = api_value_member(&data, "modes");
    double taken = 0;
    int count = api_value_count(&modes);
    if (!api_field_object(&data, problem)) return PEND_INVALID;
    (void)api_value_only(&data, data_fields, problem);
    if (api_value_kind(&modes) != API_MISSING &&
        (api_value_kind(&modes) != API_ARRAY || !count || count > API_FIT_MODES)) {
        api_value_fault(&modes, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d modes",
                        API_FIT_MODES);
        return PEND_INVALID;
    }
    fit->runs = count_runs(reading->root, &data, &runs, problem);
    if (!fit->runs) return PEND_INVALID;
    if (fit->tree.tree) PEND_TRY(api_states_new(&fit->start, fit->runs, fit->tree.tree->n));
    api_buffer_init(&fit->tables, API_FIT_TABLES_BYTES);
    struct part *part = parts_new(fit->runs, &taken, fit);
    if (!part) return PEND_NO_MEMORY;
    enum pend_status status = read_runs(fit, part, &data, count, reading);
    if (status == PEND_OK && problem->status) status = PEND_INVALID;
    if (status == PEND_OK) status = data_merge(fit, part, count, shift, &data, reading);
    if (status == PEND_OK && count) api_fit_read_modes(fit, &modes, fit->columns - count, problem);
    parts_free(part, fit->runs);
    return status;
}
