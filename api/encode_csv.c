/* A table as CSV (RFC 4180 with plain line feeds): a header line, then one line a row, straight into the answer.
 * Leaves to others: which columns there are (op_*), how a number is spelt (number).
 * Invariant: every line has the same number of fields; no field needs quotes. */
#include "api/encode.h"

#include "api/json_out.h"

static double csv_bytes(const struct api_table *table) {
    double numbers = api_table_numbers(table, 0);
    return (double)table->rows * numbers * api_out_number_bytes(table->digits) + numbers * API_OUT_NUMBER_BYTES + 64;
}

/* one field of the header: name, name_part, name_arm or name_part_arm, and the comma */
static enum pend_status csv_name(const struct api_column *column, int arm, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, column->name));
    if (column->part) PEND_TRY(api_buffer_format(out, "_%s", column->part));
    if (column->width) PEND_TRY(api_buffer_format(out, "_%d", arm + 1));
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

static enum pend_status csv_block(struct api_writer *writer, long rows, const double *const data[],
                                  struct api_buffer *out) {
    const struct api_table *table = &writer->table;
    size_t row_bytes = (size_t)api_table_numbers(table, 0) * API_OUT_NUMBER_BYTES + API_NUMBER_BYTES;
    for (long i = 0; i < rows; i++) {
        PEND_TRY(api_buffer_room(out, row_bytes));
        char *at = out->data + out->bytes;
        for (int c = 0; c < table->count; c++) {
            long width = table->column[c].width ? table->column[c].width : 1;
            const double *value = data[c] + i * width;
            for (long k = 0; k < width; k++) {
                at = api_out_digits(at, value[k], table->digits);
                *at++ = ',';
            }
        }
        at[-1] = '\n';
        out->bytes = (size_t)(at - out->data);
    }
    return PEND_OK;
}

static enum pend_status csv_end(struct api_writer *writer, const struct api_stats *stats, struct api_buffer *out) {
    (void)writer, (void)stats, (void)out;
    return PEND_OK;
}

const struct api_format api_format_csv = {
    .media_type = "text/csv",
    .content_type = "text/csv; charset=utf-8; header=present",
    .extension = "csv",
    .samples_only = 1,
    .digits = 1,
    .flows = 1,
    .writer_bytes = sizeof(struct api_writer),
    .bytes = csv_bytes,
    .begin = csv_begin,
    .block = csv_block,
    .end = csv_end,
};
