#include "api/encode/encode.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/engine.h"
#include "api/number/number.h"

void api_table_add(struct api_table *table, const char *name, const char *part, int width) {
    assert(table->count >= 0 && table->count < API_COLUMNS && name && width >= 0);
    table->column[table->count++] = (struct api_column){.name = name, .part = part, .width = width};
}

void api_table_add_inner(struct api_table *table, const char *name, const char *part, int arms,
                         int inner) {
    assert(arms >= 0 && inner >= 1);
    api_table_add(table, name, part, arms ? arms * inner : inner);
    // a row of one group has no inner brackets
    if (arms) table->column[table->count - 1].inner = inner;
}

char *api_column_write_row(char *out, const struct api_column *column, const double value[],
                           int digits) {
    const struct api_number_rows row = {1, api_column_numbers(column), value, digits, 0, "", 0};
    if (!column->inner) return api_column_write(out, column, &row, "null");
    const struct api_number_rows groups = {
        column->width / column->inner, column->inner, value, digits, '[', "],", 2};
    return api_column_write(out, column, &groups, "null") - 1;
}

int api_column_lacks(const struct api_column *column, long count, const double value[]) {
    long i = 0;
    while (column->sparse && i < count && !isnan(value[i])) i++;
    return column->sparse && i < count;
}

char *api_column_write(char *out, const struct api_column *column,
                       const struct api_number_rows *rows, const char *none) {
    assert(rows->rows >= 0 && rows->width >= 1 && rows->digits >= 0 && rows->digits <= 17);
    if (!api_column_lacks(column, rows->rows * rows->width, rows->value))
        return api_number_write_rows(out, rows);
    size_t none_bytes = strlen(none);
    const double *value = rows->value;
    for (long i = 0; i < rows->rows; i++) {
        if (rows->open) *out++ = rows->open;
        for (long k = 0; k < rows->width; k++, value++) {
            const struct api_number_rows one = {1, 1, value, rows->digits, 0, "", 0};
            if (k) *out++ = ',';
            if (!isnan(*value)) {
                out = api_number_write_rows(out, &one);
                continue;
            }
            memcpy(out, none, none_bytes);
            out += none_bytes;
        }
        memcpy(out, rows->close, (size_t)rows->close_bytes);
        out += rows->close_bytes;
    }
    return out;
}

double api_table_numbers(const struct api_table *table, int first) {
    assert(first >= 0 && table->count <= API_COLUMNS);
    double numbers = 0;
    for (int c = first; c < table->count; c++)
        numbers += (double)api_column_numbers(&table->column[c]);
    return numbers;
}

enum { COLUMN_TEXT = 48 }; /* maximum bytes of a column's name */

void api_table_columns(const struct api_table *table, char text[API_COLUMNS_TEXT]) {
    char *at = text;
    *at = 0;
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        assert(at + COLUMN_TEXT <= text + API_COLUMNS_TEXT);
        at = stpcpy(stpcpy(at, c ? "," : ""), column->name);
        if (column->part) at = stpcpy(stpcpy(at, "_"), column->part);
        if (!column->width) continue;
        at = stpcpy(at, "[");
        if (column->inner)
            at = stpcpy(api_number_write_int(at, column->width / column->inner), ",");
        at = stpcpy(api_number_write_int(at, column->inner ? column->inner : column->width), "]");
    }
}

void api_stats_text(struct api_stats *stats, const char *name, const char *text) {
    assert(stats->count < API_STATS && name && text);
    stats->stat[stats->count++] =
        (struct api_stat){.name = name, .kind = API_STAT_TEXT, .text = text};
}

void api_stats_whole(struct api_stats *stats, const char *name, long value) {
    assert(stats->count < API_STATS && name);
    stats->stat[stats->count++] =
        (struct api_stat){.name = name, .kind = API_STAT_WHOLE, .whole = value};
}

void api_stats_number(struct api_stats *stats, const char *name, double value) {
    assert(stats->count < API_STATS && name && isfinite(value));
    stats->stat[stats->count++] =
        (struct api_stat){.name = name, .kind = API_STAT_NUMBER, .number = value};
}

void api_stats_warning(struct api_stats *stats, const char *name, const char *text) {
    assert(stats->count < API_STATS && strlen(text) < API_WARNING_TEXT);
    stats->stat[stats->count++] =
        (struct api_stat){.name = name, .kind = API_STAT_WARNING, .text = text};
}

void api_stats_origin(struct api_stats *stats) {
    api_stats_text(stats, "version", PEND_VERSION);
    api_stats_text(stats, "engine", api_engine_name);
}

int api_stats_warnings(const struct api_stats *stats) {
    int count = 0;
    for (int i = 0; stats && i < stats->count; i++)
        count += stats->stat[i].kind == API_STAT_WARNING;
    return count;
}

/* allocates all columns in one block; pages that are never written take no memory */
static enum pend_status writer_keep(struct api_writer *writer) {
    const struct api_table *table = &writer->table;
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    if (numbers > (double)(SIZE_MAX / 2) / sizeof(double)) return PEND_NO_MEMORY;
    double *at = writer->kept = malloc((size_t)numbers * sizeof *at + 1);
    if (!at) return PEND_NO_MEMORY;
    for (int c = 0; c < table->count; c++) {
        writer->column[c] = at;
        at += table->rows * api_column_numbers(&table->column[c]);
    }
    return PEND_OK;
}

int api_format_streams(const struct api_format *format, const struct api_table *table) {
    return format->block && !(format->counted && table->rows_later);
}

int api_format_turns(const struct api_format *format, const struct api_table *table) {
    double bytes = (double)table->rows * api_table_numbers(table, 0) * (double)sizeof(double);
    return format->turn && !table->rows_later && bytes > (double)API_TURN_BYTES;
}

int api_writer_valid(const struct api_writer *writer) {
    int streams = api_format_streams(writer->format, &writer->table);
    return writer->rows >= 0 && writer->rows <= writer->table.rows &&
           writer->table.count <= API_COLUMNS && !(streams && writer->turns) &&
           (writer->turns || !streams == !!writer->kept) && writer->sent <= writer->rows;
}

static enum pend_status writer_make(struct api_writer **writer, const struct api_format *format,
                                    const struct api_table *table, int turns,
                                    struct api_buffer *out) {
    *writer = calloc(1, format->writer_bytes);
    if (!*writer) return PEND_NO_MEMORY;
    (*writer)->format = format;
    (*writer)->table = *table;
    (*writer)->most = (double)API_TURN_BYTES;
    (*writer)->turns = turns;
    int streams = api_format_streams(format, table);
    (*writer)->sent = -1;
    enum pend_status status = streams || turns ? PEND_OK : writer_keep(*writer);
    if (status == PEND_OK && format->begin && (streams || !format->block))
        status = format->begin(*writer, out);
    if (status != PEND_OK) api_writer_free(writer);
    assert(!*writer || api_writer_valid(*writer));
    return status;
}

enum pend_status api_writer_new(struct api_writer **writer, const struct api_format *format,
                                const struct api_table *table, struct api_buffer *out) {
    return writer_make(writer, format, table, 0, out);
}

enum pend_status api_writer_new_turns(struct api_writer **writer, const struct api_format *format,
                                      const struct api_table *table, struct api_buffer *out) {
    return writer_make(writer, format, table, api_format_turns(format, table), out);
}

void api_writer_again(struct api_writer *writer) {
    assert(api_writer_valid(writer) && writer->turns && writer->again);
    writer->rows = writer->again = 0;
}

double api_writer_bytes(const struct api_format *format, const struct api_table *table) {
    double kept = api_format_streams(format, table)
                      ? 0
                      : (double)table->rows * api_table_numbers(table, 0) * (double)sizeof(double);
    return (double)format->writer_bytes + kept + API_PIECE_BYTES;
}

void api_writer_free(struct api_writer **writer) {
    if (*writer) free((*writer)->kept);
    free(*writer);
    *writer = NULL;
}

/* true if all values are finite. Adding one to an all-ones exponent carries into the sign bit;
 * without branches the compiler vectorizes the loop. */
static int all_finite(long count, const double value[]) {
    const uint64_t exponent = 0x7ff0000000000000, one = 0x0010000000000000;
    uint64_t carried = 0;
    for (long i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        carried |= (bits & exponent) + one;
    }
    return !(carried >> 63);
}

/* names the first value of a column that is neither finite nor missing */
static enum pend_status column_fails(const struct api_writer *writer, int c, long count,
                                     const double *const data[], struct pend_error *error) {
    const struct api_column *column = &writer->table.column[c];
    long i = 0, width = api_column_numbers(column);
    while (i < count && (isfinite(data[c][i]) || (column->sparse && isnan(data[c][i])))) i++;
    if (i == count) return PEND_OK;
    int timed = !strcmp(writer->table.column[0].name, "t"),
        arm = column->width ? (int)(i % width) / (column->inner ? column->inner : 1) : -1;
    double time = timed ? data[0][i / width] : 0;
    char where[40] = "", when[40] = "";
    if (arm >= 0) snprintf(where, sizeof where, " of arm %d", arm + 1);
    if (timed) snprintf(when, sizeof when, " at t = %g s", time);
    if (!timed && !writer->table.single)
        snprintf(when, sizeof when, " in row %ld", writer->rows + i / width + 1);
    return pend_fail(error, PEND_NOT_FINITE, arm, time, "%s%s%s%s%s exceeds the range of a double",
                     column->name, column->part ? " " : "", column->part ? column->part : "", where,
                     when);
}

/* true if the numbers of some rows fit into 4-byte floats */
static int all_narrow(const struct api_writer *writer, long rows, const double *const data[]) {
    for (int c = 0; c < writer->table.count; c++) {
        long count = rows * api_column_numbers(&writer->table.column[c]);
        for (long i = 0; i < count; i++)
            if (fabs(data[c][i]) > FLT_MAX) return 0;
    }
    return 1;
}

/* writes rows in a representation that streams, or that reads the rows in several passes */
static enum pend_status rows_write(struct api_writer *writer, long rows, const double *const data[],
                                   struct api_buffer *out) {
    const struct api_format *format = writer->format;
    return (writer->turns ? format->turn : format->block)(writer, rows, data, out);
}

enum pend_status api_writer_finite_block(struct api_writer *writer, long rows,
                                         const double *const data[], struct api_buffer *out) {
    assert(api_writer_valid(writer) && rows <= writer->table.rows - writer->rows);
    if (writer->format->binary && writer->table.float32 && !all_narrow(writer, rows, data))
        return PEND_NOT_FINITE;
    int kept = writer->kept && !writer->turns;
    if (!kept) PEND_TRY(rows_write(writer, rows, data, out));
    for (int c = 0; c < writer->table.count && kept; c++) {
        size_t width = (size_t)api_column_numbers(&writer->table.column[c]),
               count = (size_t)rows * width;
        double *to = writer->column[c] + (size_t)writer->rows * width;
        if (count) memcpy(to, data[c], count * sizeof(double));
    }
    writer->rows += rows;
    assert(api_writer_valid(writer));
    return PEND_OK;
}

enum pend_status api_writer_block(struct api_writer *writer, long rows, const double *const data[],
                                  struct api_buffer *out, struct pend_error *error) {
    for (int c = 0; c < writer->table.count; c++) {
        long count = rows * api_column_numbers(&writer->table.column[c]);
        if (!all_finite(count, data[c])) PEND_TRY(column_fails(writer, c, count, data, error));
    }
    enum pend_status status = api_writer_finite_block(writer, rows, data, out);
    if (status != PEND_NOT_FINITE) return status;
    return pend_fail(error, status, -1, 0,
                     "a number exceeds the range of a float32: ask for \"number\": \"float64\"");
}

/* writes the next rows of those that were stored until their number was known */
static enum pend_status rows_send(struct api_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->table;
    const double *data[API_COLUMNS];
    long most = 1 + (long)(API_PIECE_BYTES / (api_table_numbers(table, 0) * sizeof(double)));
    if (writer->sent < 0) {
        writer->table.rows = writer->rows;
        writer->sent = 0;
        if (writer->format->begin) PEND_TRY(writer->format->begin(writer, out));
    }
    if (most > writer->rows - writer->sent) most = writer->rows - writer->sent;
    for (int c = 0; c < table->count; c++)
        data[c] = writer->column[c] + writer->sent * api_column_numbers(&table->column[c]);
    PEND_TRY(rows_write(writer, most, data, out));
    writer->sent += most;
    return PEND_OK;
}

enum pend_status api_writer_finish(struct api_writer *writer, const struct api_stats *stats,
                                   struct api_buffer *out, int *done) {
    assert(api_writer_valid(writer));
    writer->stats = stats;
    *done = 0;
    if (writer->format->block && writer->kept && (writer->sent < 0 || writer->sent < writer->rows))
        return rows_send(writer, out);
    if (writer->format->finish) return writer->format->finish(writer, out, done);
    *done = 1;
    return PEND_OK;
}

static const struct api_format *const formats[] = {
    &api_format_json,    &api_format_ndjson, &api_format_csv, &api_format_octets, &api_format_npz,
    &api_format_parquet, &api_format_hdf5,   &api_format_mat, &api_format_png};

void api_format_list(char text[API_FORMATS_TEXT], int samples, int streams) {
    size_t used = 0;
    text[0] = 0;
    for (size_t i = 0; i < sizeof formats / sizeof *formats && used < API_FORMATS_TEXT; i++) {
        if (formats[i]->samples_only > samples || (streams && !formats[i]->block)) continue;
        used += (size_t)snprintf(text + used, API_FORMATS_TEXT - used, "%s%s", used ? ", " : "",
                                 formats[i]->media_type);
    }
}

const struct api_format *api_format_at(int i) {
    return i >= 0 && i < (int)(sizeof formats / sizeof *formats) ? formats[i] : NULL;
}
