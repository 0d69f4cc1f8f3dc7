/* A table as newline-delimited JSON: one object per row and line, written as rows are computed.
 * Leaves to others: which columns there are (op_*), the text of a number (number).
 * Invariant: all rows have the same members and the same text between the numbers. Statistics, if
 * any, are the last line. */
#include "api/encode/encode.h"

#include <string.h>

#include "api/encode/stats_text.h"
#include "api/json/json_out.h"

enum { NDJSON_TEXT = 1024 };

struct ndjson_writer {
    struct api_writer base;
    int begin[API_COLUMNS + 2]; /* text[begin[c] .. begin[c + 1]) precedes column c; the last piece
                                 * ends the line */
    char text[NDJSON_TEXT];
};

static double ndjson_bytes(const struct api_table *table) {
    double row = api_table_numbers(table, 0) * api_out_number_bytes(table->digits), text = 16;
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        text +=
            16 + (double)strlen(column->name) + (column->part ? (double)strlen(column->part) : 0);
        text += (double)api_column_brackets(column);
    }
    return (double)table->rows * (row + text) + 64.0 * API_STATS + API_WARNINGS_BYTES;
}

/* composes the text between the numbers of a line */
static enum pend_status ndjson_frame(struct ndjson_writer *writer, struct api_buffer *text) {
    const struct api_table *table = &writer->base.table;
    const char *close = "{", *name = "";
    int inside = 0; /* whether an object of parts is open */
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        int same = column->part && !strcmp(column->name, name);
        writer->begin[c] = (int)text->bytes;
        PEND_TRY(api_buffer_text(text, close));
        if (!same && inside) PEND_TRY(api_buffer_text(text, "}"));
        if (c) PEND_TRY(api_buffer_text(text, ","));
        if (!same)
            PEND_TRY(api_buffer_format(text, column->part ? "\"%s\":{" : "\"%s\":", column->name));
        if (column->part) PEND_TRY(api_buffer_format(text, "\"%s\":", column->part));
        if (column->width) PEND_TRY(api_buffer_text(text, "["));
        close = column->width ? "]" : "";
        name = column->name;
        inside = column->part != NULL;
    }
    writer->begin[table->count] = (int)text->bytes;
    PEND_TRY(api_buffer_format(text, "%s%s}\n", close, inside ? "}" : ""));
    writer->begin[table->count + 1] = (int)text->bytes;
    return PEND_OK;
}

static enum pend_status ndjson_begin(struct api_writer *base, struct api_buffer *out) {
    struct ndjson_writer *writer = (struct ndjson_writer *)base;
    struct api_buffer text;
    (void)out;
    api_buffer_init(&text, NDJSON_TEXT);
    enum pend_status status = ndjson_frame(writer, &text);
    if (status == PEND_OK) memcpy(writer->text, text.data, text.bytes);
    api_buffer_clear(&text);
    return status;
}

static char *ndjson_piece(const struct ndjson_writer *writer, int c, char *at) {
    size_t bytes = (size_t)(writer->begin[c + 1] - writer->begin[c]);
    memcpy(at, writer->text + writer->begin[c], bytes);
    return at + bytes;
}

static enum pend_status ndjson_block(struct api_writer *base, long rows, const double *const data[],
                                     struct api_buffer *out) {
    const struct ndjson_writer *writer = (const struct ndjson_writer *)base;
    const struct api_table *table = &base->table;
    size_t row_bytes =
        (size_t)api_table_numbers(table, 0) * (size_t)api_out_number_bytes(table->digits) +
        NDJSON_TEXT;
    for (int c = 0; c < table->count; c++) row_bytes += api_column_brackets(&table->column[c]);
    for (long i = 0; i < rows; i++) {
        PEND_TRY(api_buffer_room(out, row_bytes + API_NUMBER_BYTES));
        char *at = out->data + out->bytes;
        for (int c = 0; c < table->count; c++) {
            long width = api_column_numbers(&table->column[c]);
            at = api_column_write_row(ndjson_piece(writer, c, at), &table->column[c],
                                      data[c] + i * width, table->digits);
        }
        at = ndjson_piece(writer, table->count, at);
        out->bytes = (size_t)(at - out->data);
    }
    return PEND_OK;
}

static enum pend_status ndjson_finish(struct api_writer *writer, struct api_buffer *out,
                                      int *done) {
    *done = 1;
    if (!writer->stats) return PEND_OK;
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_stats_json(writer->stats, out));
    return api_buffer_text(out, "}\n");
}

const struct api_format api_format_ndjson = {
    .media_type = "application/x-ndjson",
    .samples_only = 1,
    .digits = 1,
    .problem_line = 1,
    .writer_bytes = sizeof(struct ndjson_writer),
    .bytes = ndjson_bytes,
    .begin = ndjson_begin,
    .block = ndjson_block,
    .finish = ndjson_finish,
};
