#include "api/call/results.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode_raw.h"

struct api_results {
    const struct api_table *table;
    struct api_writer *writer; /* NULL where JSON pieces are passed on as they are */
    struct api_buffer record;  /* the record that is not whole yet, head and all */
    double *rows[API_COLUMNS]; /* room for a record's rows, one block */
    struct api_raw_figures figures;
    struct api_stats stats;
    int pieces; /* JSON records so far */
    int later;  /* how many rows come is not known before the end */
};

static size_t row_bytes(const struct api_table *table) {
    return (size_t)api_table_numbers(table, 0) * sizeof(double);
}

/* bytes of the longest record */
static size_t record_most(const struct api_table *table) {
    return API_RAW_HEAD + 4 * (size_t)API_PIECE_BYTES + row_bytes(table);
}

static enum pend_status results_room(struct api_results *results) {
    const struct api_table *table = results->table;
    size_t rows = record_most(table) / row_bytes(table) + 1;
    double *at = malloc(rows * row_bytes(table));
    if (!at) return PEND_NO_MEMORY;
    for (int c = 0; c < table->count; c++) {
        results->rows[c] = at;
        at += rows * (size_t)api_column_numbers(&table->column[c]);
    }
    return PEND_OK;
}

/* the record that is being gathered is within its limit; a writer has the results' table */
PEND_VALIDATOR results_valid(const struct api_results *results) {
    const struct api_buffer *record = &results->record;
    if (results->pieces < 0 || !api_buffer_valid(record)) return 0;
    return !results->writer ||
           (api_writer_valid(results->writer) && results->writer->rows <= results->table->rows);
}

enum pend_status api_results_new(struct api_results **results, const struct api_format *format,
                                 const struct api_table *table, int apart, int later,
                                 struct api_buffer *out) {
    assert(table->count >= 1 && table->count <= API_COLUMNS);
    struct api_results *made = *results = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    made->table = table;
    made->later = later;
    api_buffer_init(&made->record, record_most(table));
    enum pend_status status = results_room(made);
    if (status == PEND_OK && !(apart && format == &api_format_json))
        status = api_writer_new(&made->writer, format, table, out);
    if (status != PEND_OK) api_results_free(results);
    assert(status != PEND_OK || results_valid(made));
    return status;
}

const struct api_stats *api_results_stats(const struct api_results *results) {
    return results && results->stats.count ? &results->stats : NULL;
}

void api_results_free(struct api_results **results) {
    struct api_results *gone = *results;
    *results = NULL;
    if (!gone) return;
    api_writer_free(&gone->writer);
    free(gone->rows[0]);
    api_buffer_clear(&gone->record);
    free(gone);
}

/* a record that is whole */
static enum pend_status results_take(struct api_results *results, enum api_raw kind,
                                     const char *data, size_t bytes, struct api_buffer *out) {
    if (kind == API_RAW_JSON) {
        results->pieces++;
        return results->writer ? PEND_OK : api_buffer_add(out, data, bytes);
    }
    if (!results->writer) return PEND_OK;
    if (kind == API_RAW_STATS)
        return api_raw_add(&results->figures, data, bytes) ? PEND_OK : PEND_BUG;
    long rows = api_raw_rows(results->table, data, bytes, results->rows);
    if (rows < 0 || rows > results->table->rows - results->writer->rows) return PEND_BUG;
    return api_writer_block(results->writer, rows, (const double *const *)results->rows, out, NULL);
}

enum pend_status api_results_feed(struct api_results *results, const void *data, size_t bytes,
                                  struct api_buffer *out) {
    assert(results_valid(results));
    struct api_buffer *record = &results->record;
    const char *from = data;
    while (bytes) {
        enum api_raw kind = API_RAW_ROWS;
        size_t wanted = API_RAW_HEAD, body = 0;
        if (record->bytes >= API_RAW_HEAD) {
            if (!api_raw_head(record->data, &kind, &body) || body > record->limit - API_RAW_HEAD)
                return PEND_BUG;
            wanted += body;
        }
        size_t piece = wanted - record->bytes < bytes ? wanted - record->bytes : bytes;
        PEND_TRY(api_buffer_add(record, from, piece));
        from += piece;
        bytes -= piece;
        if (record->bytes < API_RAW_HEAD) continue;
        if (!api_raw_head(record->data, &kind, &body) || body > record->limit - API_RAW_HEAD)
            return PEND_BUG;
        if (record->bytes < API_RAW_HEAD + body) continue;
        PEND_TRY(results_take(results, kind, record->data + API_RAW_HEAD, body, out));
        record->bytes = 0;
    }
    assert(results_valid(results));
    return PEND_OK;
}

enum pend_status api_results_end(struct api_results *results, struct api_buffer *out, int *done) {
    assert(results_valid(results));
    *done = 0;
    if (results->record.bytes) return PEND_BUG;
    if (!results->writer) {
        *done = 1;
        return results->pieces ? PEND_OK : PEND_BUG;
    }
    if (results->later ? !results->figures.count : results->writer->rows != results->table->rows)
        return PEND_BUG;
    api_raw_stats(&results->figures, &results->stats);
    return api_writer_finish(results->writer, results->stats.count ? &results->stats : NULL, out,
                             done);
}
