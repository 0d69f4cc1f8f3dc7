/* The storage format of a job's part: records of rows, and one of statistics.
 * Leaves to others: combining the parts (results), storing them (server).
 * Invariant: these bytes are never sent to a client; a record has at most about API_PIECE_BYTES, or
 * one row. */
#include "api/encode/encode_raw.h"

#include <assert.h>

#include "api/base/octets.h"

void api_raw_head_put(char *at, enum api_raw kind, size_t bytes) {
    assert(bytes <= UINT32_MAX && kind >= API_RAW_ROWS && kind <= API_RAW_FILE);
    api_octets_whole(api_octets_whole(at, (uint64_t)kind, 4), bytes, 4);
}

/* begins a record and reserves its space in the buffer */
static enum pend_status raw_begin(struct api_buffer *out, enum api_raw kind, size_t bytes) {
    PEND_TRY(api_buffer_room(out, API_RAW_HEAD + bytes));
    api_raw_head_put(out->data + out->bytes, kind, bytes);
    out->bytes += API_RAW_HEAD;
    return PEND_OK;
}

static double raw_bytes(const struct api_table *table) {
    return (double)table->rows * (api_table_numbers(table, 0) * sizeof(double) + API_RAW_HEAD) +
           4096;
}

static enum pend_status raw_record(struct api_writer *writer, long rows, long from,
                                   const double *const data[], struct api_buffer *out) {
    assert(rows >= 0 && from >= 0);
    const struct api_table *table = &writer->table;
    size_t row = (size_t)api_table_numbers(table, 0) * sizeof(double);
    PEND_TRY(raw_begin(out, API_RAW_ROWS, (size_t)rows * row));
    char *at = out->data + out->bytes;
    for (long i = from; i < from + rows; i++)
        for (int c = 0; c < table->count; c++) {
            long width = api_column_numbers(&table->column[c]);
            at = api_octets_doubles(at, (size_t)width, data[c] + i * width);
        }
    out->bytes += (size_t)rows * row;
    return PEND_OK;
}

static enum pend_status raw_block(struct api_writer *writer, long rows, const double *const data[],
                                  struct api_buffer *out) {
    long most =
        1 + (long)(API_PIECE_BYTES / (api_table_numbers(&writer->table, 0) * sizeof(double)));
    for (long from = 0; from < rows; from += most)
        PEND_TRY(raw_record(writer, rows - from < most ? rows - from : most, from, data, out));
    return PEND_OK;
}

static int is_text(int kind) { return kind == API_STAT_TEXT || kind == API_STAT_WARNING; }

static char *put_text(char *at, const char *text) {
    size_t bytes = strlen(text);
    *at++ = (char)bytes;
    memcpy(at, text, bytes);
    return at + bytes;
}

static enum pend_status raw_finish(struct api_writer *writer, struct api_buffer *out, int *done) {
    const struct api_stats *stats = writer->stats;
    size_t bytes = 0;
    // kind, length of the name, name; 8 bytes, or a length and a text
    for (int i = 0; stats && i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        bytes += 2 + strlen(stat->name) + (is_text(stat->kind) ? 1 + strlen(stat->text) : 8);
    }
    PEND_TRY(raw_begin(out, API_RAW_STATS, bytes));
    char *at = out->data + out->bytes;
    for (int i = 0; stats && i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        *at++ = (char)stat->kind;
        at = put_text(at, stat->name);
        if (is_text(stat->kind))
            at = put_text(at, stat->text);
        else if (stat->kind == API_STAT_WHOLE)
            at = api_octets_whole(at, (uint64_t)stat->whole, 8);
        else
            at = api_octets_double(at, stat->number);
    }
    out->bytes += bytes;
    *done = 1;
    return PEND_OK;
}

const struct api_format api_format_raw = {
    .media_type = "raw",
    .samples_only = 1,
    .writer_bytes = sizeof(struct api_writer),
    .bytes = raw_bytes,
    .block = raw_block,
    .finish = raw_finish,
};

/* --- reading */

static uint64_t get_whole(const char *at, int bytes) {
    uint64_t x = 0;
    for (int i = bytes; i-- > 0;) x = x << 8 | (unsigned char)at[i];
    return x;
}

static double get_double(const char *at) {
    uint64_t bits = get_whole(at, 8);
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

int api_raw_head(const char *data, enum api_raw *kind, size_t *bytes) {
    uint64_t number = get_whole(data, 4);
    *kind = (enum api_raw)number;
    *bytes = (size_t)get_whole(data + 4, 4);
    return number >= API_RAW_ROWS && number <= API_RAW_JSON;
}

void api_raw_file_put(char *at, const struct api_raw_file *file) {
    api_raw_head_put(at, API_RAW_FILE, API_RAW_FILE_BYTES - API_RAW_HEAD);
    at = api_octets_whole(at + API_RAW_HEAD, (uint64_t)file->rows, 8);
    at = api_octets_whole(api_octets_whole(at, (uint64_t)file->width, 8), file->bytes, 8);
    memcpy(at, file->digest, 64);
}

int api_raw_file_get(const char *data, size_t bytes, struct api_raw_file *file) {
    if (bytes < API_RAW_FILE_BYTES || get_whole(data, 4) != API_RAW_FILE) return 0;
    data += API_RAW_HEAD;
    *file = (struct api_raw_file){.rows = (long)get_whole(data, 8),
                                  .width = (long)get_whole(data + 8, 8),
                                  .bytes = (size_t)get_whole(data + 16, 8)};
    memcpy(file->digest, data + 24, 64);
    return file->rows >= 0 && file->width >= 1 &&
           strspn(file->digest, "0123456789abcdef") == sizeof file->digest - 1;
}

long api_raw_rows(const struct api_table *table, const char *data, size_t bytes,
                  double *const column[]) {
    size_t row = (size_t)api_table_numbers(table, 0) * sizeof(double);
    long rows = (long)(bytes / row);
    if (bytes % row) return -1;
    for (long i = 0; i < rows; i++)
        for (int c = 0; c < table->count; c++) {
            long width = api_column_numbers(&table->column[c]);
            for (long k = 0; k < width; k++, data += 8) column[c][i * width + k] = get_double(data);
        }
    return rows;
}

/* reads a text after its length, from at most `left` bytes; returns the bytes read, 0 if it is
 * incomplete */
static size_t get_text(const char *at, size_t left, char text[API_RAW_TEXT]) {
    size_t bytes = left ? (unsigned char)*at : 0;
    if (!left || bytes >= left || bytes >= API_RAW_TEXT) return 0;
    memcpy(text, at + 1, bytes);
    text[bytes] = 0;
    return bytes + 1;
}

/* reads one statistic; returns the bytes read, 0 if it is invalid */
static size_t get_figure(struct api_raw_figure *figure, const char *at, size_t left) {
    size_t used = 1, text;
    *figure = (struct api_raw_figure){.kind = left ? *at : -1};
    text = left > 1 ? get_text(at + 1, left - 1, figure->name) : 0;
    if (!text) return 0;
    used += text;
    if (is_text(figure->kind)) {
        text = get_text(at + used, left - used, figure->text);
        return text ? used + text : 0;
    }
    if (left - used < 8 || (figure->kind != API_STAT_WHOLE && figure->kind != API_STAT_NUMBER))
        return 0;
    if (figure->kind == API_STAT_WHOLE)
        figure->whole = (long)(int64_t)get_whole(at + used, 8);
    else
        figure->number = get_double(at + used);
    return used + 8;
}

int api_raw_add(struct api_raw_figures *figures, const char *data, size_t bytes) {
    while (bytes) {
        struct api_raw_figure got;
        size_t used = get_figure(&got, data, bytes);
        int at = 0;
        if (!used) return 0;
        while (at < figures->count && strcmp(figures->figure[at].name, got.name) != 0) at++;
        if (at == API_STATS) return 0;
        struct api_raw_figure *sum = &figures->figure[at];
        if (at == figures->count)
            figures->count++;
        else {
            got.whole += sum->whole;
            got.number += sum->number;
        }
        *sum = got;
        data += used;
        bytes -= used;
    }
    return 1;
}

void api_raw_stats(const struct api_raw_figures *figures, struct api_stats *stats) {
    stats->count = 0;
    for (int i = 0; i < figures->count; i++) {
        const struct api_raw_figure *figure = &figures->figure[i];
        if (figure->kind == API_STAT_TEXT)
            api_stats_text(stats, figure->name, figure->text);
        else if (figure->kind == API_STAT_WARNING)
            api_stats_warning(stats, figure->name, figure->text);
        else if (figure->kind == API_STAT_WHOLE)
            api_stats_whole(stats, figure->name, figure->whole);
        else
            api_stats_number(stats, figure->name, figure->number);
    }
}
