/* A table as little-endian doubles in row-major order, which can be read as a Float64Array in a
 * browser and by numpy.frombuffer in Python. With float32 they are floats (Float32Array).
 * Leaves to others: naming the columns (the X-Columns header field, by call).
 * Invariant: 8 or 4 bytes per number and nothing else. */
#include "api/encode/encode.h"

#include "api/base/octets.h"

static double octets_bytes(const struct api_table *table) {
    return (double)table->rows * api_table_numbers(table, 0) *
           (table->float32 ? sizeof(float) : sizeof(double));
}

/* scatters the numbers of a column into rows that are `row` bytes apart; inlined with a constant
 * width, it is one move per row */
static inline __attribute__((always_inline)) void octets_column(char *at, long rows, size_t width,
                                                                size_t row, const double value[]) {
    for (long i = 0; i < rows; i++, at += row, value += width) api_octets_doubles(at, width, value);
}

static void octets_place(char *at, long rows, size_t width, size_t row, const double value[]) {
    switch (width) {
    case 1:
        octets_column(at, rows, 1, row, value);
        return;
    case 2:
        octets_column(at, rows, 2, row, value);
        return;
    case 3:
        octets_column(at, rows, 3, row, value);
        return;
    case 4:
        octets_column(at, rows, 4, row, value);
        return;
    default:
        octets_column(at, rows, width, row, value);
        return;
    }
}

static enum pend_status octets_floats(const struct api_table *table, long rows,
                                      const double *const data[], struct api_buffer *out) {
    PEND_TRY(api_buffer_room(out, (size_t)rows * (size_t)api_table_numbers(table, 0) * 4));
    char *at = out->data + out->bytes;
    for (long i = 0; i < rows; i++)
        for (int c = 0; c < table->count; c++) {
            long width = api_column_numbers(&table->column[c]);
            for (long k = 0; k < width; k++) at = api_octets_float(at, data[c][i * width + k]);
        }
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

static enum pend_status octets_block(struct api_writer *writer, long rows,
                                     const double *const data[], struct api_buffer *out) {
    const struct api_table *table = &writer->table;
    size_t row = (size_t)api_table_numbers(table, 0) * sizeof(double);
    if (!rows) return PEND_OK;
    if (table->float32) return octets_floats(table, rows, data, out);
    PEND_TRY(api_buffer_room(out, (size_t)rows * row));
    char *at = out->data + out->bytes;
    for (int c = 0; c < table->count; c++) {
        size_t width = (size_t)api_column_numbers(&table->column[c]);
        octets_place(at, rows, width, row, data[c]);
        at += width * sizeof(double);
    }
    out->bytes += (size_t)rows * row;
    return PEND_OK;
}

const struct api_format api_format_octets = {
    .media_type = "application/octet-stream",
    .samples_only = 1,
    .exact = 1,
    .binary = 1,
    .bare = 1,
    .writer_bytes = sizeof(struct api_writer),
    .bytes = octets_bytes,
    .block = octets_block,
};
