#include "api/call/results.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode_raw.h"

struct api_results {
    struct api_table table;
    struct api_writer *writer; /* NULL if JSON pieces are copied unchanged */
    struct api_buffer record;  /* bytes of an incomplete record, with its head */
    double *rows[API_COLUMNS]; /* memory for a record's rows, one block */
    struct api_raw_figures figures;
    struct api_stats stats;
    int pieces;  /* number of JSON records so far */
    int later;   /* whether the number of rows is known only at the end */
    long most;   /* number of rows of all parts */
    int partial; /* whether the last parts may be missing */
    int turn;    /* number of completed passes over the parts */
};

static size_t row_bytes(const struct api_table *table) {
    return (size_t)api_table_numbers(table, 0) * sizeof(double);
}

/* maximum bytes of a record */
static size_t record_most(const struct api_table *table) {
    return API_RAW_HEAD + 4 * (size_t)API_PIECE_BYTES + row_bytes(table);
}

void api_results_head(const struct api_source *source, struct api_answer *answer) {
    struct api_answer plain = *answer;
    if (!source->partial) return;
    /* without an ETag, because the next part will change the answer */
    *answer = (struct api_answer){.status = 202,
                                  .media_type = plain.media_type,
                                  .columns = plain.columns,
                                  .length = -1,
                                  .file_name = plain.file_name};
}

double api_results_bytes(const struct api_source *source, const struct api_format *format,
                         const struct api_table *table) {
    struct api_table own = *table;
    own.rows_later |= source->partial;
    if (source->again && api_format_turns(format, &own))
        return (double)format->writer_bytes + (double)API_TURN_BYTES + API_PIECE_BYTES;
    return api_writer_bytes(format, &own);
}

static enum pend_status results_room(struct api_results *results) {
    const struct api_table *table = &results->table;
    size_t rows = record_most(table) / row_bytes(table) + 1;
    double *at = malloc(rows * row_bytes(table));
    if (!at) return PEND_NO_MEMORY;
    for (int c = 0; c < table->count; c++) {
        results->rows[c] = at;
        at += rows * (size_t)api_column_numbers(&table->column[c]);
    }
    return PEND_OK;
}

/* true if the incomplete record is within its limit, and a writer has the results' table */
PEND_VALIDATOR results_valid(const struct api_results *results) {
    const struct api_buffer *record = &results->record;
    if (results->pieces < 0 || !api_buffer_valid(record)) return 0;
    return !results->writer ||
           (api_writer_valid(results->writer) && results->writer->rows <= results->table.rows);
}

/* refuses representations that cannot hold partial results */
static enum pend_status results_form(const struct api_format *format, int apart,
                                     struct pend_error *error) {
    if (format->picture)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "a picture needs all members, and some are not computed yet: ask for "
                         "numbers, or wait for the end of the job");
    if (apart && format == &api_format_json)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the JSON of this job is complete only at its end: ask for its rows as "
                         "application/x-ndjson or text/csv, or wait for the end");
    return PEND_OK;
}

enum pend_status api_results_new(struct api_results **results, const struct api_format *format,
                                 const struct api_table *table, int apart, int later,
                                 const struct api_source *source, struct api_buffer *out,
                                 struct pend_error *error) {
    assert(table->count >= 1 && table->count <= API_COLUMNS);
    if (source->partial) PEND_TRY(results_form(format, apart, error));
    struct api_results *made = *results = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    made->partial = source->partial;
    made->table = *table;
    made->table.rows_later |= made->partial;
    made->most = table->rows;
    made->later = later;
    api_buffer_init(&made->record, record_most(table));
    enum pend_status status = results_room(made);
    if (status == PEND_OK && !(apart && format == &api_format_json))
        status = (source->again ? api_writer_new_turns : api_writer_new)(&made->writer, format,
                                                                         &made->table, out);
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

static enum pend_status results_take(struct api_results *results, enum api_raw kind,
                                     const char *data, size_t bytes, struct api_buffer *out) {
    if (kind == API_RAW_JSON) {
        results->pieces++;
        return results->writer ? PEND_OK : api_buffer_add(out, data, bytes);
    }
    if (!results->writer) return PEND_OK;
    if (kind == API_RAW_STATS && results->turn) return PEND_OK;
    if (kind == API_RAW_STATS)
        return api_raw_add(&results->figures, data, bytes) ? PEND_OK : PEND_BUG;
    long rows = api_raw_rows(&results->table, data, bytes, results->rows);
    if (rows < 0 || rows > results->table.rows - results->writer->rows) return PEND_BUG;
    return api_writer_block(results->writer, rows, (const double *const *)results->rows, out, NULL);
}

static enum pend_status results_feed(struct api_results *results, const void *data, size_t bytes,
                                     struct api_buffer *out) {
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
    return PEND_OK;
}

enum pend_status api_results_fetch(struct api_results *results, const struct api_source *source,
                                   struct api_buffer *out, int *all, struct pend_error *error) {
    enum { FETCH_BYTES = 1 << 18 };
    size_t bytes = 0;
    char *data = malloc(FETCH_BYTES);
    enum pend_status status = data ? PEND_OK : PEND_NO_MEMORY;
    if (data) status = source->fetch(source->context, data, FETCH_BYTES, &bytes, error);
    if (status == PEND_OK) status = results_feed(results, data, bytes, out);
    free(data);
    *all = !bytes;
    return status;
}

enum pend_status api_results_end(struct api_results *results, struct api_buffer *out, int *done) {
    assert(results_valid(results));
    *done = 0;
    if (results->record.bytes) return PEND_BUG;
    if (!results->writer) {
        *done = 1;
        return results->pieces ? PEND_OK : PEND_BUG;
    }
    if (results->partial) {
        results->stats.count = 0;
        api_stats_whole(&results->stats, "rows", results->writer->rows);
        api_stats_whole(&results->stats, "rows_all", results->most);
        return api_writer_finish(results->writer, &results->stats, out, done);
    }
    if (results->later ? !results->figures.count : results->writer->rows != results->table.rows)
        return PEND_BUG;
    api_raw_stats(&results->figures, &results->stats);
    return api_writer_finish(results->writer, results->stats.count ? &results->stats : NULL, out,
                             done);
}

int api_results_again(struct api_results *results, const struct api_source *source) {
    struct api_writer *writer = results->writer;
    assert(results_valid(results));
    if (!writer || !writer->again) return 0;
    results->turn++;
    api_writer_again(writer);
    source->again(source->context);
    return 1;
}

enum pend_status api_results_file(const struct api_table *table, const struct api_buffer *raw,
                                  struct api_buffer *file, long *rows) {
    const struct api_source source = {0};
    struct pend_error error;
    struct api_results *results;
    struct api_stats kept = {0};
    int done = 0;
    PEND_TRY(api_results_new(&results, &api_format_parquet, table, 1, 1, &source, file, &error));
    enum pend_status status = results_feed(results, raw->data, raw->bytes, file);
    api_raw_stats(&results->figures, &results->stats);
    for (int i = 0; i < results->stats.count; i++)
        if (strcmp(results->stats.stat[i].name, "compute_seconds") != 0)
            kept.stat[kept.count++] = results->stats.stat[i];
    while (status == PEND_OK && !done)
        status = api_writer_finish(results->writer, kept.count ? &kept : NULL, file, &done);
    *rows = results->writer->rows;
    api_results_free(&results);
    return status;
}
