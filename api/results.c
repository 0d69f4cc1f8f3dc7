#include "api/results.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode_raw.h"
#include "api/negotiate.h"

struct api_results {
    const struct api_op *op;
    const struct api_format *format;
    void *state; /* the operation's, for its table */
    const struct api_table *table;
    struct api_writer *writer; /* NULL where JSON pieces are passed on as they are */
    struct api_buffer record;  /* the record that is not whole yet, head and all */
    double *rows[API_COLUMNS]; /* room for a record's rows, one block */
    struct api_raw_figures figures;
    struct api_stats stats;
    int pieces; /* JSON records so far */
    struct api_answer answer;
    char columns[API_COLUMNS_TEXT], file_name[40];
};

static size_t row_bytes(const struct api_table *table) { return (size_t)api_table_numbers(table, 0) * sizeof(double); }

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

static void results_head(struct api_results *results) {
    const struct api_format *format = results->format;
    results->answer = (struct api_answer){.status = 200, .media_type = format->content_type, .length = -1};
    if (format->exact) results->answer.length = (long long)format->bytes(results->table);
    if (format->bare) {
        api_table_columns(results->table, results->columns);
        results->answer.columns = results->columns;
    }
    if (!format->extension) return;
    snprintf(results->file_name, sizeof results->file_name, "%s.%s", results->op->name, format->extension);
    results->answer.file_name = results->file_name;
}

static enum pend_status results_begin(struct api_results *results, const struct api_request *request,
                                      const struct api_limits *limits, struct api_problem *problem,
                                      struct api_buffer *out) {
    char digest[API_DIGEST_BYTES];
    int samples = results->op->samples;
    results->format = api_negotiate_format(request->accept, samples);
    if (!results->format) api_negotiate_refuse(problem, samples);
    if (problem->status) return PEND_INVALID;
    PEND_TRY(api_request_read(request, results->format, limits, problem, &results->state, digest));
    results->table = results->op->table(results->state);
    api_buffer_init(&results->record, record_most(results->table));
    results_head(results);
    PEND_TRY(results_room(results));
    if (results->op->json_apart && results->format == &api_format_json) return PEND_OK;
    return api_writer_new(&results->writer, results->format, results->table, out);
}

int api_results_new(struct api_results **results, const struct api_request *request, const struct api_limits *limits,
                    struct api_buffer *out) {
    struct api_results *made = *results = calloc(1, sizeof *made);
    struct api_problem problem;
    int http = 0;
    api_problem_init(&problem);
    enum pend_status status = PEND_NO_MEMORY;
    if (made) {
        made->op = api_op_at(request->op);
        status = results_begin(made, request, limits, &problem, out);
    }
    if (status != PEND_OK) {
        api_problem_set(&problem, pend_status_http(status), "%s", pend_status_text(status));
        http = problem.status;
        out->bytes = 0;
        if (api_problem_write(&problem, out) != PEND_OK) out->bytes = 0;
        api_results_free(results);
    }
    api_problem_clear(&problem);
    return http;
}

void api_results_free(struct api_results **results) {
    struct api_results *gone = *results;
    *results = NULL;
    if (!gone) return;
    api_writer_free(&gone->writer);
    free(gone->rows[0]);
    api_buffer_clear(&gone->record);
    if (gone->state) gone->op->free(&gone->state);
    free(gone);
}

struct api_answer api_results_answer(const struct api_results *results) {
    return results->answer;
}

/* a record that is whole */
static enum pend_status results_take(struct api_results *results, enum api_raw kind, const char *data, size_t bytes,
                                     struct api_buffer *out) {
    if (kind == API_RAW_JSON) {
        results->pieces++;
        return results->writer ? PEND_OK : api_buffer_add(out, data, bytes);
    }
    if (!results->writer) return PEND_OK;
    if (kind == API_RAW_STATS) return api_raw_add(&results->figures, data, bytes) ? PEND_OK : PEND_BUG;
    long rows = api_raw_rows(results->table, data, bytes, results->rows);
    if (rows < 0 || rows > results->table->rows - results->writer->rows) return PEND_BUG;
    return api_writer_block(results->writer, rows, (const double *const *)results->rows, out, NULL);
}

enum pend_status api_results_feed(struct api_results *results, const void *data, size_t bytes, struct api_buffer *out) {
    struct api_buffer *record = &results->record;
    const char *from = data;
    while (bytes) {
        enum api_raw kind = API_RAW_ROWS;
        size_t wanted = API_RAW_HEAD, body = 0;
        if (record->bytes >= API_RAW_HEAD) {
            if (!api_raw_head(record->data, &kind, &body) || body > record->limit - API_RAW_HEAD) return PEND_BUG;
            wanted += body;
        }
        size_t piece = wanted - record->bytes < bytes ? wanted - record->bytes : bytes;
        PEND_TRY(api_buffer_add(record, from, piece));
        from += piece;
        bytes -= piece;
        if (record->bytes < API_RAW_HEAD) continue;
        if (!api_raw_head(record->data, &kind, &body) || body > record->limit - API_RAW_HEAD) return PEND_BUG;
        if (record->bytes < API_RAW_HEAD + body) continue;
        PEND_TRY(results_take(results, kind, record->data + API_RAW_HEAD, body, out));
        record->bytes = 0;
    }
    return PEND_OK;
}

enum pend_status api_results_end(struct api_results *results, struct api_buffer *out, int *done) {
    *done = 0;
    if (results->record.bytes) return PEND_BUG;
    if (!results->writer) {
        *done = 1;
        return results->pieces ? PEND_OK : PEND_BUG;
    }
    if (results->writer->rows != results->table->rows) return PEND_BUG;
    api_raw_stats(&results->figures, &results->stats);
    return api_writer_finish(results->writer, results->stats.count ? &results->stats : NULL, out, done);
}
