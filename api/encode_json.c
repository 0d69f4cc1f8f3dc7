/* A table as one JSON object of arrays, time-major; every array grows in a buffer of its own and they are joined at the
 * end. Leaves to others: which columns there are (op_*), how a number is spelt (number).
 * Invariant: the object is valid JSON, members in the order of the columns, stats last. */
#include "api/encode.h"

#include <math.h>
#include <string.h>

#include "api/json_out.h"

/* a column's buffer begins with room for all its rows, up to this many bytes: most answers then never move */
enum { JSON_FIRST_BYTES = 1 << 18 };

struct json_writer {
    struct api_writer base;
    struct api_buffer column[API_COLUMNS];
};

static double json_bytes(const struct api_table *table) {
    double row = api_table_numbers(table, 0) * api_out_number_bytes(table->digits) + 3.0 * table->count;
    return (double)table->rows * row + 64.0 * (table->count + 12);
}

/* most bytes of a row of a column; while it is written the last number may take API_NUMBER_BYTES */
static int json_row_bytes(const struct api_column *column, int digits) {
    return (column->width ? column->width : 1) * api_out_number_bytes(digits) + 3;
}

static enum pend_status json_begin(struct api_writer *base, struct api_buffer *out) {
    struct json_writer *writer = (struct json_writer *)base;
    const struct api_table *table = &base->table;
    for (int c = 0; c < table->count; c++) {
        double bytes = (double)table->rows * json_row_bytes(&table->column[c], table->digits) + API_NUMBER_BYTES;
        api_buffer_init(&writer->column[c], out->limit);
        bytes = fmin(bytes, fmin(JSON_FIRST_BYTES, (double)out->limit));
        PEND_TRY(api_buffer_room(&writer->column[c], (size_t)bytes));
    }
    return PEND_OK;
}

/* a row's numbers and the comma behind each */
static char *json_row(char *at, long width, const double value[], int digits) {
    for (long i = 0; i < width; i++) {
        at = api_out_digits(at, value[i], digits);
        *at++ = ',';
    }
    return at;
}

static enum pend_status json_block(struct api_writer *base, long rows, const double *const data[],
                                   struct api_buffer *out) {
    struct json_writer *writer = (struct json_writer *)base;
    const struct api_table *table = &base->table;
    (void)out;
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        struct api_buffer *text = &writer->column[c];
        size_t row_bytes = (size_t)json_row_bytes(column, table->digits);
        PEND_TRY(api_buffer_room(text, (size_t)rows * row_bytes + API_NUMBER_BYTES));
        char *at = text->data + text->bytes;
        if (!column->width) at = json_row(at, rows, data[c], table->digits);
        for (long i = 0; column->width && i < rows; i++) {
            *at++ = '[';
            at = json_row(at, column->width, data[c] + i * column->width, table->digits);
            at[-1] = ']';
            *at++ = ',';
        }
        text->bytes = (size_t)(at - text->data);
    }
    return PEND_OK;
}

/* the column's array; its text ends with a comma too many, if there is any */
static enum pend_status json_join(const struct json_writer *writer, int c, struct api_buffer *out) {
    const struct api_buffer *text = &writer->column[c];
    size_t bytes = text->bytes ? text->bytes - 1 : 0;
    int bare = writer->base.table.single;
    if (!bare) PEND_TRY(api_buffer_add(out, "[", 1));
    if (bytes) PEND_TRY(api_buffer_add(out, text->data, bytes));
    return bare ? PEND_OK : api_buffer_add(out, "]", 1);
}

static enum pend_status json_stats(const struct api_stats *stats, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "stats", '{'));
    for (int i = 0; i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        if (stat->kind == API_STAT_TEXT) PEND_TRY(api_out_text(out, stat->name, stat->text));
        if (stat->kind == API_STAT_WHOLE) PEND_TRY(api_out_whole(out, stat->name, stat->whole));
        if (stat->kind == API_STAT_NUMBER) PEND_TRY(api_out_number(out, stat->name, stat->number, 0));
    }
    return api_buffer_add(out, "}", 1);
}

/* true when column c carries another name than its neighbour */
static int json_name_changes(const struct api_table *table, int c, int neighbour) {
    return neighbour < 0 || neighbour >= table->count || strcmp(table->column[c].name, table->column[neighbour].name);
}

static enum pend_status json_end(struct api_writer *base, const struct api_stats *stats, struct api_buffer *out) {
    struct json_writer *writer = (struct json_writer *)base;
    const struct api_table *table = &base->table;
    size_t bytes = 64 * (size_t)(table->count + 12);
    for (int c = 0; c < table->count; c++) bytes += writer->column[c].bytes;
    PEND_TRY(api_buffer_room(out, bytes));
    PEND_TRY(api_buffer_add(out, "{", 1));
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        if (column->part && json_name_changes(table, c, c - 1)) PEND_TRY(api_out_open(out, column->name, '{'));
        PEND_TRY(api_out_key(out, column->part ? column->part : column->name));
        PEND_TRY(json_join(writer, c, out));
        if (column->part && json_name_changes(table, c, c + 1)) PEND_TRY(api_buffer_add(out, "}", 1));
        api_buffer_clear(&writer->column[c]);
    }
    if (stats) PEND_TRY(json_stats(stats, out));
    return api_buffer_add(out, "}", 1);
}

static void json_clear(struct api_writer *base) {
    struct json_writer *writer = (struct json_writer *)base;
    for (int c = 0; c < base->table.count; c++) api_buffer_clear(&writer->column[c]);
}

const struct api_format api_format_json = {
    .media_type = "application/json",
    .content_type = "application/json",
    .digits = 1,
    .writer_bytes = sizeof(struct json_writer),
    .bytes = json_bytes,
    .begin = json_begin,
    .block = json_block,
    .end = json_end,
    .clear = json_clear,
};
