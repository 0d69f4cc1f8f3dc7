/* A table as CSV (RFC 4180 with LF line ends): a header line, then one line per row. Warnings
 * follow the table as comment lines, which begin with # and contain no comma.
 * Leaves to others: which columns there are (op_*), the text of a number (number).
 * Invariant: every line of the table has the same number of fields; no field needs quotes. */
#include "api/encode/encode.h"

#include "api/encode/stats_text.h"
#include "api/json/json_out.h"

enum { CSV_NAME_BYTES = 56 }; /* maximum bytes of a header field */

static double csv_bytes(const struct api_table *table) {
    double numbers = api_table_numbers(table, 0);
    return (double)table->rows * numbers * api_out_number_bytes(table->digits) +
           numbers * CSV_NAME_BYTES + API_WARNINGS_BYTES;
}

/* appends a header field with its comma: name[_part][_arm][_inner], such as final_phi_2 */
static enum pend_status csv_name(const struct api_column *column, int arm, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, column->name));
    if (column->part) PEND_TRY(api_buffer_format(out, "_%s", column->part));
    if (column->inner)
        PEND_TRY(
            api_buffer_format(out, "_%d_%d", arm / column->inner + 1, arm % column->inner + 1));
    else if (column->width)
        PEND_TRY(api_buffer_format(out, "_%d", arm + 1));
    return api_buffer_add(out, ",", 1);
}

static enum pend_status csv_begin(struct api_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->table;
    for (int c = 0; c < table->count; c++) {
        int count = table->column[c].width ? table->column[c].width : 1;
        for (int arm = 0; arm < count; arm++) PEND_TRY(csv_name(&table->column[c], arm, out));
    }
    out->data[out->bytes - 1] = '\n';
    return PEND_OK;
}

/* writes rows in which no value is missing and that fit into `row` */
static char *csv_rows(char *at, const struct api_table *table, long rows, long from,
                      const double *const data[], double row[]) {
    long numbers = 0;
    for (long i = from; i < from + rows; i++)
        for (int c = 0; c < table->count; c++) {
            long width = api_column_numbers(&table->column[c]);
            for (long k = 0; k < width; k++) row[numbers++] = data[c][i * width + k];
        }
    const struct api_number_rows lines = {rows, numbers / rows, row, table->digits, 0, "\n", 1};
    return api_number_write_rows(at, &lines);
}

/* writes a row column by column, because it is too long for `row` or values may be missing */
static char *csv_long_row(char *at, const struct api_table *table, long i,
                          const double *const data[]) {
    for (int c = 0; c < table->count; c++) {
        long width = api_column_numbers(&table->column[c]);
        const struct api_number_rows part = {1,   width, data[c] + i * width, table->digits, 0,
                                             ",", 1};
        at = api_column_write(at, &table->column[c], &part, "");
    }
    at[-1] = '\n';
    return at;
}

static enum pend_status csv_block(struct api_writer *writer, long rows, const double *const data[],
                                  struct api_buffer *out) {
    enum { TOGETHER = 512 };
    const struct api_table *table = &writer->table;
    double row[TOGETHER];
    long numbers = (long)api_table_numbers(table, 0);
    int apart = numbers > TOGETHER;
    for (int c = 0; c < table->count; c++)
        apart |= api_column_lacks(&table->column[c], rows * api_column_numbers(&table->column[c]),
                                  data[c]) != 0;
    long most = apart ? 1 : TOGETHER / numbers;
    size_t row_bytes = (size_t)numbers * API_OUT_NUMBER_BYTES;
    for (long i = 0, some; i < rows; i += some) {
        some = rows - i < most ? rows - i : most;
        PEND_TRY(api_buffer_room(out, (size_t)some * row_bytes + API_NUMBER_ROWS_BYTES));
        char *at = out->data + out->bytes;
        at = apart ? csv_long_row(at, table, i, data) : csv_rows(at, table, some, i, data, row);
        out->bytes = (size_t)(at - out->data);
    }
    return PEND_OK;
}

static enum pend_status csv_finish(struct api_writer *writer, struct api_buffer *out, int *done) {
    *done = 1;
    return writer->stats ? api_stats_comments(writer->stats, out) : PEND_OK;
}

const struct api_format api_format_csv = {
    .media_type = "text/csv",
    .content_type = "text/csv; charset=utf-8; header=present",
    .extension = "csv",
    .samples_only = 1,
    .digits = 1,
    .writer_bytes = sizeof(struct api_writer),
    .bytes = csv_bytes,
    .begin = csv_begin,
    .block = csv_block,
    .finish = csv_finish,
};
