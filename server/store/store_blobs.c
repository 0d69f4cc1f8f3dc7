#include "server/store/store_jobs.h"

#include <string.h>

#include "server/store/store_rows.h"

enum srv_stored srv_blobs_put(struct srv_store *store, const struct srv_lease *lease,
                              const char *data, size_t bytes) {
    for (size_t at = 0; at < bytes; at += SRV_CHUNK_BYTES) {
        size_t piece = bytes - at < SRV_CHUNK_BYTES ? bytes - at : SRV_CHUNK_BYTES;
        long chunk = (long)(at / SRV_CHUNK_BYTES);
        unsigned char seal[API_SEAL_BYTES];
        srv_seal_chunk(seal, lease->job, lease->part, chunk, data + at, piece);
        SRV_STORED_TRY(SRV_POST(store, SQL_RESULT_PUT, lease->job, lease->part, chunk,
                                srv_value_bytes(data + at, piece),
                                srv_value_bytes(seal, sizeof seal)));
    }
    return SRV_STORED;
}

struct row_chunk {
    int rows;
    void *data;
    size_t *bytes;
    const char *job;
    long part, chunk;
};

static enum srv_stored row_chunk(void *context, const struct srv_value field[]) {
    struct row_chunk *row = context;
    row->rows++;
    if (field[0].kind != SRV_SQL_BYTES || field[0].bytes > SRV_CHUNK_BYTES ||
        !srv_seal_chunk_whole(&field[1], row->job, row->part, row->chunk, field[0].data,
                              field[0].bytes))
        return SRV_STORED_DAMAGED;
    *row->bytes = field[0].bytes;
    if (field[0].bytes) memcpy(row->data, field[0].data, field[0].bytes);
    return SRV_STORED;
}

enum srv_stored srv_blobs_get(struct srv_store *store, const char *job, long part, long chunk,
                              void *data, size_t *bytes) {
    struct row_chunk row = {0, data, bytes, job, part, chunk};
    SRV_STORED_TRY(SRV_RUN(store, SQL_RESULT, row_chunk, &row, job, part, chunk));
    return row.rows ? SRV_STORED : SRV_STORED_NONE;
}

enum srv_stored srv_blobs_drop(struct srv_store *store, const char *job, int *more) {
    struct srv_row_wholes gone = {.count = 1};
    if (!more) return SRV_POST(store, SQL_RESULTS_REMOVE, job);
    SRV_STORED_TRY(SRV_RUN(store, SQL_RESULTS_REMOVE_SOME, srv_row_wholes, &gone, job));
    *more = gone.rows == SQL_CHUNKS_MOST;
    return SRV_STORED;
}

struct row_files {
    const char *job;
    long *from;
    enum srv_stored (*take)(void *context, long part, const struct api_raw_file *file);
    void *context;
};

static enum srv_stored row_file(void *context, const struct srv_value field[]) {
    struct row_files *rows = context;
    struct api_raw_file file;
    long part = (long)field[0].whole;
    if (field[1].kind != SRV_SQL_BYTES || part < *rows->from ||
        !srv_seal_chunk_whole(&field[2], rows->job, part, 0, field[1].data, field[1].bytes))
        return SRV_STORED_DAMAGED;
    *rows->from = part + 1;
    return api_raw_file_get(field[1].data, field[1].bytes, &file)
               ? rows->take(rows->context, part, &file)
               : SRV_STORED_CLASH;
}

enum srv_stored srv_store_files(struct srv_store *store, const char *job, long *from,
                                enum srv_stored (*take)(void *context, long part,
                                                        const struct api_raw_file *file),
                                void *context) {
    struct row_files rows = {job, from, take, context};
    SRV_STORED_TRY(srv_store_look(store));
    return srv_store_end(
        store, SRV_RUN(store, SQL_RESULTS, row_file, &rows, job, *from, (long)SRV_PART_FILES));
}
