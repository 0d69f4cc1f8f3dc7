/* A table as one JSON object of arrays in row-major order, written from the kept columns.
 * Leaves to others: which columns there are (op_*), the text of a number (number).
 * Invariant: the object is valid JSON, members in the order of the columns, stats last. */
#include "api/encode/encode.h"

#include <string.h>

#include "api/encode/stats_text.h"
#include "api/json/json_out.h"

struct json_writer {
    struct api_writer base;
    int column; /* the column that is being written */
    long row;   /* the next row of the column */
    int open;   /* whether the bytes before the column's rows are written */
};

static double json_bytes(const struct api_table *table) {
    double row =
        api_table_numbers(table, 0) * api_out_number_bytes(table->digits) + 3.0 * table->count;
    for (int c = 0; c < table->count; c++) row += (double)api_column_brackets(&table->column[c]);
    return (double)table->rows * row + 64.0 * (table->count + API_STATS) + API_WARNINGS_BYTES;
}

/* true if column c and the neighbouring column have different names */
static int json_name_changes(const struct api_table *table, int c, int neighbour) {
    return neighbour < 0 || neighbour >= table->count ||
           strcmp(table->column[c].name, table->column[neighbour].name);
}

/* writes the bytes before the rows of a column; column 0 has no comma before it, although the
 * buffer may be empty */
static enum pend_status json_open(const struct json_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    int c = writer->column;
    const struct api_column *column = &table->column[c];
    PEND_TRY(api_buffer_text(out, c ? "," : "{"));
    if (!column->part || json_name_changes(table, c, c - 1))
        PEND_TRY(api_buffer_format(out, column->part ? "\"%s\":{" : "\"%s\":", column->name));
    if (column->part) PEND_TRY(api_buffer_format(out, "\"%s\":", column->part));
    return table->single ? PEND_OK : api_buffer_text(out, "[");
}

static enum pend_status json_close(const struct json_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    int c = writer->column;
    if (!table->single) PEND_TRY(api_buffer_text(out, "]"));
    return table->column[c].part && json_name_changes(table, c, c + 1) ? api_buffer_text(out, "}")
                                                                       : PEND_OK;
}

/* writes rows, each followed by a comma */
static char *json_write_rows(char *at, const struct api_column *column, long rows,
                             const double value[], int digits) {
    for (long i = 0; i < rows && column->inner; i++) {
        *at++ = '[';
        at = api_column_write_row(at, column, value + i * column->width, digits);
        at = stpcpy(at, "],");
    }
    if (column->inner) return at;
    struct api_number_rows list = {rows, 1, value, digits, 0, ",", 1},
                           nested = {rows, column->width, value, digits, '[', "],", 2};
    return api_column_write(at, column, column->width ? &nested : &list, "null");
}

static enum pend_status json_rows(struct json_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    const struct api_column *column = &table->column[writer->column];
    size_t width = (size_t)api_column_numbers(column);
    size_t row_bytes =
        width * (size_t)api_out_number_bytes(table->digits) + 3 + api_column_brackets(column);
    long rows = writer->base.rows - writer->row, most = 1 + (long)(API_PIECE_BYTES / row_bytes);
    if (rows > most) rows = most;
    if (!rows) return PEND_OK;
    PEND_TRY(api_buffer_room(out, (size_t)rows * row_bytes + API_NUMBER_BYTES));
    const double *value = writer->base.column[writer->column] + (size_t)writer->row * width;
    char *end = json_write_rows(out->data + out->bytes, column, rows, value, table->digits);
    writer->row += rows;
    out->bytes = (size_t)(end - out->data) - (writer->row == writer->base.rows);
    return PEND_OK;
}

static enum pend_status json_finish(struct api_writer *base, struct api_buffer *out, int *done) {
    struct json_writer *writer = (struct json_writer *)base;
    size_t before = out->bytes;
    while (writer->column < base->table.count) {
        if (out->bytes - before >= API_PIECE_BYTES) return PEND_OK;
        if (!writer->open) PEND_TRY(json_open(writer, out));
        writer->open = 1;
        PEND_TRY(json_rows(writer, out));
        if (writer->row < base->rows) continue;
        PEND_TRY(json_close(writer, out));
        writer->column++;
        writer->row = 0;
        writer->open = 0;
    }
    if (base->stats) PEND_TRY(api_stats_json(base->stats, out));
    *done = 1;
    return api_buffer_text(out, "}");
}

const struct api_format api_format_json = {
    .media_type = "application/json",
    .digits = 1,
    .writer_bytes = sizeof(struct json_writer),
    .bytes = json_bytes,
    .finish = json_finish,
};
