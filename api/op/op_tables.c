/* POST /v1/tables: the roles of the columns of measured tables, before anything is fitted.
 * Leaves to others: the layout and the guesses (api/csv), the sentences (measured_json).
 * Invariant: a table is read exactly as in POST /v1/fits. */
#include "api/op/op.h"

#include <assert.h>

#include "api/json/json_out.h"
#include "api/op/measured_json.h"

enum { FIRST_ROWS = 5, MOST_TABLES = 32, ANSWER_BYTES = 1 << 20, MOST_CELLS = 300000 };

/* a request for a fit may be sent unchanged */
static const char *const fields[] = {"pendulum",   "data",    "initial",  "time",  "start",
                                     "camera",     "loss",    "unknowns", "fixed", "rtol",
                                     "iterations", "include", NULL};
static const char *const included[] = {"data", NULL};

struct tables {
    struct api_tree tree;
    int data;   /* whether the answer contains the measurements */
    long cells; /* number of cells of all tables */
    struct api_buffer answer;
};

static void tables_clear(void *state) {
    struct tables *tables = state;
    api_tree_clear(&tables->tree);
    api_buffer_clear(&tables->answer);
}

static enum pend_status tables_one(struct tables *tables, const struct api_value *data,
                                   struct api_problem *problem) {
    struct api_measured table;
    if (!api_measured_read(&table, &tables->tree, data, problem)) return PEND_INVALID;
    tables->cells += table.csv.rows * table.csv.columns;
    if (tables->data && tables->cells > MOST_CELLS) {
        api_value_fault(data, problem,
                        API_CODE_LIMIT "has more than %d cells: leave \"include\" out", MOST_CELLS);
        return PEND_INVALID;
    }
    return api_measured_write(&table, FIRST_ROWS, tables->data, &tables->answer);
}

static enum pend_status tables_all(struct tables *tables, const struct api_value *data,
                                   struct api_problem *problem) {
    struct api_value runs = api_value_member(data, "runs"), run = api_value_item(&runs, 0);
    if (api_value_kind(&runs) == API_MISSING) return tables_one(tables, data, problem);
    int count = api_value_count(&runs);
    if (api_value_kind(&runs) != API_ARRAY || count < 1 || count > MOST_TABLES) {
        api_value_fault(&runs, problem, API_CODE_WRONG_COUNT "must be an array of 1 to %d runs",
                        MOST_TABLES);
        return PEND_INVALID;
    }
    for (; api_value_kind(&run) != API_MISSING; run = api_value_next(&run)) {
        if (!api_field_object(&run, NULL, problem)) continue;
        enum pend_status status = tables_one(tables, &run, problem);
        if (status != PEND_OK && status != PEND_INVALID) return status;
    }
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status tables_read(void *state, const struct api_reading *reading) {
    struct tables *tables = state;
    struct api_value pendulum = api_value_member(reading->root, "pendulum"),
                     data = api_value_member(reading->root, "data"),
                     include = api_value_member(reading->root, "include");
    struct api_problem *problem = reading->problem;
    (void)api_value_only(reading->root, fields, problem);
    tables->data = api_field_words(&include, included, problem) != 0;
    api_buffer_init(&tables->answer, tables->data
                                         ? ANSWER_BYTES + 2L * MOST_CELLS * API_OUT_NUMBER_BYTES
                                         : ANSWER_BYTES);
    enum pend_status status = PEND_OK;
    // without a pendulum, the table names the arms
    if (api_value_kind(&pendulum) != API_MISSING) status = api_reading_tree(reading, &tables->tree);
    if (status == PEND_NO_MEMORY || !api_field_object(&data, NULL, problem))
        return status == PEND_OK ? PEND_INVALID : status;
    PEND_TRY(api_buffer_text(&tables->answer, "{"));
    PEND_TRY(api_out_open(&tables->answer, "tables", '['));
    status = tables_all(tables, &data, problem);
    PEND_TRY(status);
    PEND_TRY(api_buffer_text(&tables->answer, "]"));
    return problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status tables_run(void *state, const struct api_turn *turn, int *done,
                                   struct pend_error *error) {
    const struct tables *tables = state;
    (void)error;
    assert(tables->answer.bytes && !*done);
    *done = 1;
    PEND_TRY(api_buffer_add(turn->out, tables->answer.data, tables->answer.bytes));
    return api_turn_close(turn);
}

static double tables_bytes(const void *state) {
    const struct tables *tables = state;
    return API_OP_SMALL_BYTES + 2.0 * (double)tables->answer.cap + api_tree_bytes(&tables->tree);
}

const struct api_op api_op_tables = {.name = "tables",
                                     .size = sizeof(struct tables),
                                     .body = 1,
                                     .form = 1,
                                     .terms = 1,
                                     .pieces = 1,
                                     .cart = 1,
                                     .read = tables_read,
                                     .run = tables_run,
                                     .bytes = tables_bytes,
                                     .clear = tables_clear};
