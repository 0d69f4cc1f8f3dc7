#include "api/op/fit/fits_data.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/fit/fits_part.h"

static const char *const data_fields[] = {"runs", "modes", "t",    "series",  "csv",
                                          "arms", "sigma", "unit", "columns", NULL};
static const char *const run_fields[] = {"initial", "time",  "start", "t",       "series", "csv",
                                         "arms",    "sigma", "unit",  "columns", NULL};
/* ---- several runs */

struct place {
    double since, t; /* s: time since the start of its run; time as given */
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

/* the column for a series, shared by all runs that measure it; an unknown sigma stays unknown */
static int data_column(struct api_fit *fit, const struct pend_fit_column *column, int run) {
    struct api_fit_run *own = &fit->run[run];
    int c = 0;
    for (; c < fit->columns; c++) {
        int taken = 0, known = fit->column[c].sigma > 0;
        for (int i = 0; i < own->series; i++) taken |= own->column[i] == c;
        if (!taken && fit->column[c].kind == column->kind && fit->column[c].arm == column->arm &&
            fit->column[c].joint == column->joint && known == pend_fit_known(column) &&
            fit->column[c].at == column->at && fit->column[c].still == column->still)
            break;
    }
    if (c == API_FIT_SERIES) return -1;
    if (c == fit->columns)
        fit->column[fit->columns] = *column, fit->column[c].each = NULL,
        fit->column[fit->columns++].sigma = pend_fit_known(column);
    return own->column[own->series++] = c;
}

/* sorts the rows of all runs by their time since the start of their run */
static enum pend_status data_order(struct api_fit *fit, const struct api_fit_part part[],
                                   double shift, struct place **order) {
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
static int data_columns(struct api_fit *fit, const struct api_fit_part part[],
                        const struct api_value *data, const struct api_reading *reading) {
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
static enum pend_status data_merge(struct api_fit *fit, const struct api_fit_part part[], int modes,
                                   double shift, const struct api_value *data,
                                   const struct api_reading *reading) {
    struct place *order;
    if (!data_columns(fit, part, data, reading)) return PEND_INVALID;
    fit->columns += modes, fit->modes = modes;
    size_t rows = (size_t)fit->rows, count = rows * (size_t)fit->columns;
    // runs are kept until their common table is complete
    double *taken = part[0].taken;
    *taken += (double)(rows * (sizeof(struct place) + sizeof(int) + sizeof(long)));
    if (!api_fit_part_fits((double)rows, fit->columns, taken, data, reading)) return PEND_INVALID;
    fit->t = malloc((rows + 1) * sizeof(double)), fit->of = malloc((rows + 1) * sizeof(int));
    fit->row = malloc((rows + 1) * sizeof(long));
    fit->data = malloc((count + 1) * sizeof(double));
    fit->each = malloc((count + 1) * sizeof(double));
    if (!fit->t || !fit->of || !fit->row || !fit->data || !fit->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) fit->data[i] = NAN, fit->each[i] = 1;
    PEND_TRY(data_order(fit, part, shift, &order));
    for (size_t i = 0; i < rows; i++) {
        const struct api_fit_part *from = &part[order[i].run];
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
static enum pend_status read_run(struct api_fit *fit, int r, struct api_fit_part *part,
                                 const struct api_value *at, const struct api_value *data,
                                 const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(at, "initial"),
                     start = api_field_renamed(at, "time", "start", problem);
    struct api_fit_run *run = &fit->run[r];
    run->guessed = api_value_kind(&initial) == API_MISSING;
    api_states_read(fit->start, r, &initial, &fit->tree, reading->limits, problem);
    if (fit->start && fit->start->mode[r])
        api_value_fault(&initial, problem,
                        API_CODE_NOT_APPLICABLE
                        "must be given by angles: a fit cannot start in a mode");
    run->begins = api_value_read_number(&start, -1e9, 1e9, "s", &fit->begin[r], problem) > 0;
    if (!part) return PEND_OK;
    return api_fit_part_read(part, &fit->tree, data, reading);
}

/* adds an error for fields that belong in the runs */
static void fault_beside(const struct api_value *at, const char *const names[],
                         struct api_problem *problem) {
    for (int i = 0; names[i]; i++) {
        struct api_value value = api_value_member(at, names[i]);
        if (api_value_kind(&value) != API_MISSING)
            api_value_fault(&value, problem,
                            API_CODE_CONFLICT "belongs to a run: put it into each of \"runs\"");
    }
}

static int count_runs(const struct api_value *root, const struct api_value *data,
                      const struct api_value *runs, struct api_problem *problem) {
    int count = api_value_count(runs);
    if (api_value_kind(runs) == API_MISSING) return 1;
    fault_beside(data, data_fields + 2, problem);
    fault_beside(root, (const char *const[]){"initial", "time", "start", NULL}, problem);
    if (api_value_kind(runs) == API_ARRAY && count >= 1 && count <= API_FIT_RUNS) return count;
    api_value_fault(runs, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d runs",
                    API_FIT_RUNS);
    return 0;
}

static enum pend_status read_runs(struct api_fit *fit, struct api_fit_part part[],
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
        // if only modes are measured, the motion consists of its first instant
        if (!alone) return PEND_OK;
        PEND_TRY(api_fit_part_room(part, 1, 0, data, reading));
        part->t[0] = fit->begin[0];
        return PEND_OK;
    }
    struct api_value item = api_value_item(&runs, 0);
    for (int r = 0; r < fit->runs; r++, item = api_value_next(&item)) {
        if (!api_field_object(&item, run_fields, reading->problem)) continue;
        enum pend_status status = read_run(fit, r, &part[r], &item, &item, reading);
        if (status == PEND_NO_MEMORY) return status;
    }
    return PEND_OK;
}

static void parts_free(struct api_fit_part part[], int runs) {
    for (int r = 0; r < runs; r++) free(part[r].t), free(part[r].data), free(part[r].each);
    free(part);
}

enum pend_status api_fit_read_data(struct api_fit *fit, double shift,
                                   const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    struct api_value data = api_value_member(reading->root, "data"),
                     runs = api_value_member(&data, "runs"),
                     modes = api_value_member(&data, "modes");
    double taken = 0;
    int count = api_value_count(&modes);
    if (!api_field_object(&data, data_fields, problem)) return PEND_INVALID;
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
    struct api_fit_part *part = calloc((size_t)fit->runs, sizeof *part);
    if (!part) return PEND_NO_MEMORY;
    for (int r = 0; r < fit->runs; r++) // all runs share one count of bytes
        part[r].taken = &taken, part[r].tables = &fit->tables, part[r].advice = fit->advice;
    enum pend_status status = read_runs(fit, part, &data, count, reading);
    if (status == PEND_OK && problem->status) status = PEND_INVALID;
    if (status == PEND_OK) status = data_merge(fit, part, count, shift, &data, reading);
    if (status == PEND_OK && count) api_fit_read_modes(fit, &modes, fit->columns - count, problem);
    parts_free(part, fit->runs);
    return status;
}
