/* A table as Apache Parquet: one column for each number of a row, plain pages of doubles or floats
 * in row groups, then the metadata. Only a few of the format's Thrift structs are written; no C
 * library in Debian writes Parquet.
 * Leaves to others: compression (the server's content codings).
 * Invariant: the bytes depend on the numbers and statistics only; at most one row group is in
 * memory; columns have CSV's names. */
#include "api/encode/encode_arrays.h"
#include "api/encode/encode_raw.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/octets.h"
#include "api/number/number.h"

/* Numbers in a row group; most bytes of a column's name, of its metadata in a row group and in the
 * schema, and of a statistic. */
enum {
    GROUP_NUMBERS = 1 << 16,
    NAME_BYTES = 64,
    CHUNK_BYTES = 128 + NAME_BYTES,
    FIELD_BYTES = 32 + NAME_BYTES,
    STAT_BYTES = 2 * API_WARNING_TEXT,
    PAGE_BYTES = 32
};

enum { TYPE_FLOAT = 4, TYPE_DOUBLE = 5, REQUIRED = 0, DATA_PAGE = 0, PLAIN = 0, RLE = 3 };
enum { THRIFT_I32 = 5, THRIFT_I64 = 6, THRIFT_BINARY = 8, THRIFT_LIST = 9, THRIFT_STRUCT = 12 };

struct parquet_writer {
    struct api_writer base;
    long width;       /* numbers per row */
    long most, held;  /* rows per group; rows stored in the current group */
    uint64_t written; /* bytes so far; in the metadata, the offset of the described group */
    size_t footer;    /* bytes of the metadata so far */
    long next;        /* first row of the group that is described next */
    int begun;        /* whether the metadata is begun */
    double group[GROUP_NUMBERS]; /* number k of row i is at group[k * most + i] */
};

/* ---- Thrift's compact protocol */

static char *put_varint(char *at, uint64_t x) {
    for (; x >= 0x80; x >>= 7) *at++ = (char)(0x80 | (x & 0x7f));
    *at++ = (char)x;
    return at;
}

/* a field header: the difference between its id and the previous one, and its type */
static char *put_field(char *at, int step, int type) {
    assert(step >= 1 && step <= 15);
    *at++ = (char)(step << 4 | type);
    return at;
}

static char *put_whole(char *at, int step, int type, int64_t x) {
    return put_varint(put_field(at, step, type), (uint64_t)x << 1);
}

static char *put_text(char *at, const char *text) {
    size_t bytes = strlen(text);
    at = put_varint(at, bytes);
    memcpy(at, text, bytes);
    return at + bytes;
}

static char *put_list(char *at, int type, uint64_t count) {
    if (count < 15) {
        *at++ = (char)((int)count << 4 | type);
        return at;
    }
    *at++ = (char)(0xf0 | type);
    return put_varint(at, count);
}

/* ---- columns, one for each number of a row */

/* the table's column that contains number n of a row, and the index within it */
struct place {
    const struct api_column *column;
    int arm;
};

static struct place place_next(const struct api_table *table, struct place place) {
    if (!place.column) return (struct place){table->column, 0};
    if (++place.arm < api_column_numbers(place.column)) return place;
    return (struct place){place.column + 1, 0};
}

/* the column's name in CSV, such as final_phi_2 */
static void place_name(struct place place, char name[NAME_BYTES]) {
    const struct api_column *column = place.column;
    char *at = stpcpy(name, column->name);
    assert(strlen(column->name) + (column->part ? strlen(column->part) : 0) + 26 < NAME_BYTES);
    if (column->part) at = stpcpy(stpcpy(at, "_"), column->part);
    if (!column->width) return;
    int inner = column->inner;
    at = api_number_write_int(stpcpy(at, "_"), (inner ? place.arm / inner : place.arm) + 1);
    if (inner) at = api_number_write_int(stpcpy(at, "_"), place.arm % inner + 1);
    *at = 0;
}

static char *put_page(char *at, long rows, int bytes) {
    at = put_whole(at, 1, THRIFT_I32, DATA_PAGE);
    at = put_whole(at, 1, THRIFT_I32, rows * bytes);
    at = put_whole(at, 1, THRIFT_I32, rows * bytes);
    at = put_field(at, 2, THRIFT_STRUCT);
    at = put_whole(at, 1, THRIFT_I32, rows);
    at = put_whole(at, 1, THRIFT_I32, PLAIN);
    at = put_whole(at, 1, THRIFT_I32, RLE);
    at = put_whole(at, 1, THRIFT_I32, RLE);
    *at++ = 0;
    *at++ = 0;
    return at;
}

/* writes a row group; number k of row i is value[k * apart + i] */
static enum pend_status put_group(struct parquet_writer *writer, long rows, long apart,
                                  const double value[], struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    size_t before = out->bytes;
    PEND_TRY(api_buffer_room(out, (size_t)writer->width * ((size_t)rows * 8 + PAGE_BYTES) + 4));
    char *at = out->data + out->bytes;
    struct place place = {NULL, 0};
    for (long k = 0; k < writer->width; k++) {
        place = place_next(table, place);
        int narrow = api_column_float32(place.column, table);
        const double *from = value + k * apart;
        at = put_page(at, rows, narrow ? 4 : 8);
        if (!narrow) at = api_octets_doubles(at, (size_t)rows, from);
        for (long i = 0; narrow && i < rows; i++) at = api_octets_float(at, from[i]);
    }
    out->bytes = (size_t)(at - out->data);
    writer->written += out->bytes - before;
    return PEND_OK;
}

/* number of rows of a row group */
static long group_rows(long width) { return width < GROUP_NUMBERS ? GROUP_NUMBERS / width : 1; }

static enum pend_status parquet_begin(struct api_writer *base, struct api_buffer *out) {
    struct parquet_writer *writer = (struct parquet_writer *)base;
    writer->width = (long)api_table_numbers(&base->table, 0);
    writer->most = group_rows(writer->width);
    writer->written = 4;
    return api_buffer_add(out, "PAR1", 4);
}

/* appends a record of rows from a row group; number k of row i is at from[k * apart + 8 * i] */
static enum pend_status group_record(const char *from, size_t apart, long rows, long width,
                                     struct api_buffer *out) {
    size_t bytes = (size_t)rows * (size_t)width * 8;
    PEND_TRY(api_buffer_room(out, API_RAW_HEAD + bytes));
    char *at = out->data + out->bytes;
    api_raw_head_put(at, API_RAW_ROWS, bytes);
    at += API_RAW_HEAD;
    for (long i = 0; i < rows; i++)
        for (long k = 0; k < width; k++, at += 8) memcpy(at, from + (size_t)k * apart + 8 * i, 8);
    out->bytes += API_RAW_HEAD + bytes;
    return PEND_OK;
}

enum pend_status api_raw_from_parquet(const char *data, const struct api_raw_file *file,
                                      struct api_buffer *out) {
    long width = file->width, most = group_rows(width), piece = 1 + API_PIECE_BYTES / 8 / width;
    size_t at = 4;
    if (file->bytes < at || memcmp(data, "PAR1", 4)) return PEND_BUG;
    for (long first = 0; first < file->rows; first += most) {
        long rows = file->rows - first < most ? file->rows - first : most;
        char page[PAGE_BYTES];
        size_t head = (size_t)(put_page(page, rows, 8) - page), apart = head + (size_t)rows * 8;
        if ((file->bytes - at) / apart < (size_t)width) return PEND_BUG;
        for (long k = 0; k < width; k++)
            if (memcmp(data + at + (size_t)k * apart, page, head)) return PEND_BUG;
        for (long i = 0; i < rows; i += piece)
            PEND_TRY(group_record(data + at + head + 8 * i, apart,
                                  rows - i < piece ? rows - i : piece, width, out));
        at += (size_t)width * apart;
    }
    return PEND_OK;
}

static enum pend_status parquet_block(struct api_writer *base, long rows,
                                      const double *const data[], struct api_buffer *out) {
    struct parquet_writer *writer = (struct parquet_writer *)base;
    assert(rows >= 0 && writer->held < writer->most);
    for (long i = 0; i < rows; i++) {
        double *group = writer->group, *wide = NULL;
        if (writer->width > GROUP_NUMBERS) {
            group = wide = malloc((size_t)writer->width * sizeof *wide);
            if (!wide) return PEND_NO_MEMORY;
        }
        // successive numbers of a row are `most` doubles apart
        double *to = group + writer->held;
        for (int c = 0; c < base->table.count; c++) {
            long width = api_column_numbers(&base->table.column[c]);
            for (long k = 0; k < width; k++, to += writer->most) *to = data[c][i * width + k];
        }
        if (++writer->held < writer->most) continue;
        writer->held = 0;
        enum pend_status status = put_group(writer, writer->most, writer->most, group, out);
        free(wide);
        PEND_TRY(status);
    }
    return PEND_OK;
}

/* ---- the metadata at the end of the file */

static enum pend_status put_schema(struct parquet_writer *writer, struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    PEND_TRY(api_buffer_room(out, (size_t)(writer->width + 2) * FIELD_BYTES));
    char *at = out->data + out->bytes, name[NAME_BYTES];
    at = put_whole(at, 1, THRIFT_I32, 1);
    at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_STRUCT, (uint64_t)writer->width + 1);
    at = put_text(put_field(at, 4, THRIFT_BINARY), "schema");
    at = put_whole(at, 1, THRIFT_I32, writer->width);
    *at++ = 0;
    struct place place = {NULL, 0};
    for (long k = 0; k < writer->width; k++) {
        place = place_next(table, place);
        place_name(place, name);
        at = put_whole(at, 1, THRIFT_I32,
                       api_column_float32(place.column, table) ? TYPE_FLOAT : TYPE_DOUBLE);
        at = put_whole(at, 2, THRIFT_I32, REQUIRED);
        at = put_text(put_field(at, 1, THRIFT_BINARY), name);
        *at++ = 0;
    }
    at = put_whole(at, 1, THRIFT_I64, writer->base.rows);
    long groups = (writer->base.rows + writer->most - 1) / writer->most;
    at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_STRUCT, (uint64_t)groups);
    out->bytes = (size_t)(at - out->data);
    writer->written = 4; // offset of the group being described
    return PEND_OK;
}

static char *put_chunk(char *at, const char *name, int narrow, long rows, uint64_t offset,
                       size_t bytes) {
    at = put_whole(at, 2, THRIFT_I64, (int64_t)offset);
    at = put_field(at, 1, THRIFT_STRUCT);
    at = put_whole(at, 1, THRIFT_I32, narrow ? TYPE_FLOAT : TYPE_DOUBLE);
    at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_I32, 1);
    at = put_varint(at, PLAIN);
    at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_BINARY, 1);
    at = put_text(at, name);
    at = put_whole(at, 1, THRIFT_I32, 0); // codec 0: uncompressed
    at = put_whole(at, 1, THRIFT_I64, rows);
    at = put_whole(at, 1, THRIFT_I64, (int64_t)bytes);
    at = put_whole(at, 1, THRIFT_I64, (int64_t)bytes);
    at = put_whole(at, 2, THRIFT_I64, (int64_t)offset);
    *at++ = 0;
    *at++ = 0;
    return at;
}

static enum pend_status put_group_facts(struct parquet_writer *writer, long rows,
                                        struct api_buffer *out) {
    const struct api_table *table = &writer->base.table;
    uint64_t begin = writer->written;
    PEND_TRY(api_buffer_room(out, (size_t)(writer->width + 1) * CHUNK_BYTES));
    char *at = out->data + out->bytes, name[NAME_BYTES], page[PAGE_BYTES];
    struct place place = {NULL, 0};
    at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_STRUCT, (uint64_t)writer->width);
    for (long k = 0; k < writer->width; k++) {
        place = place_next(table, place);
        place_name(place, name);
        int narrow = api_column_float32(place.column, table), each = narrow ? 4 : 8;
        size_t bytes = (size_t)(put_page(page, rows, each) - page) + (size_t)(rows * each);
        at = put_chunk(at, name, narrow, rows, writer->written, bytes);
        writer->written += bytes;
    }
    at = put_whole(at, 1, THRIFT_I64, (int64_t)(writer->written - begin));
    at = put_whole(at, 1, THRIFT_I64, rows);
    *at++ = 0;
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

static void stat_text(const struct api_stat *stat, char text[STAT_BYTES]) {
    const struct api_number_rows one = {1, 1, &stat->number, 0, 0, "", 0};
    if (stat->kind == API_STAT_WHOLE)
        *api_number_write_int(text, stat->whole) = 0;
    else if (stat->kind == API_STAT_NUMBER)
        *api_number_write_rows(text, &one) = 0;
    else
        *stpncpy(text, stat->text, STAT_BYTES - 1) = 0;
}

static enum pend_status put_end(struct parquet_writer *writer, struct api_buffer *out) {
    const struct api_stats *stats = writer->base.stats;
    int count = stats ? stats->count : 0;
    char text[STAT_BYTES];
    PEND_TRY(api_buffer_room(out, (size_t)(count + 1) * (STAT_BYTES + NAME_BYTES)));
    size_t before = out->bytes;
    char *at = out->data + out->bytes;
    int step = count ? 1 : 2;
    if (count) at = put_list(put_field(at, 1, THRIFT_LIST), THRIFT_STRUCT, (uint64_t)count);
    for (int i = 0; i < count; i++) {
        stat_text(&stats->stat[i], text);
        at = put_text(put_field(at, 1, THRIFT_BINARY), stats->stat[i].name);
        at = put_text(put_field(at, 1, THRIFT_BINARY), text);
        *at++ = 0;
    }
    at = put_text(put_field(at, step, THRIFT_BINARY), "pendulumd version " PEND_VERSION);
    *at++ = 0;
    writer->footer += (size_t)(at - (out->data + before));
    // readers take the 4-byte length as a signed number, so they could not find longer metadata
    if (writer->footer > INT32_MAX) return PEND_LIMIT;
    at = api_octets_whole(at, writer->footer, 4);
    memcpy(at, "PAR1", 4);
    out->bytes = (size_t)(at + 4 - out->data);
    return PEND_OK;
}

static enum pend_status parquet_finish(struct api_writer *base, struct api_buffer *out, int *done) {
    struct parquet_writer *writer = (struct parquet_writer *)base;
    size_t start = out->bytes;
    if (writer->held) {
        PEND_TRY(put_group(writer, writer->held, writer->most, writer->group, out));
        writer->held = 0;
        return PEND_OK;
    }
    if (!writer->begun) PEND_TRY(put_schema(writer, out));
    writer->begun = 1;
    while (writer->next < base->rows && out->bytes - start < API_PIECE_BYTES) {
        long left = base->rows - writer->next, rows = left < writer->most ? left : writer->most;
        PEND_TRY(put_group_facts(writer, rows, out));
        writer->next += rows;
    }
    writer->footer += out->bytes - start;
    if (writer->next < base->rows) return PEND_OK;
    *done = 1;
    return put_end(writer, out);
}

static double parquet_bytes(const struct api_table *table) {
    double width = api_table_numbers(table, 0), rows = (double)table->rows,
           groups = 1 + rows * width / (GROUP_NUMBERS / 2);
    if (width > GROUP_NUMBERS) groups = rows;
    return 8 * rows * width + width * (FIELD_BYTES + groups * (CHUNK_BYTES + PAGE_BYTES)) +
           groups * 64 + API_STATS * (STAT_BYTES + NAME_BYTES) + 1024;
}

const struct api_format api_format_parquet = {
    .media_type = "application/vnd.apache.parquet",
    .extension = "parquet",
    .samples_only = 1,
    .binary = 1,
    .writer_bytes = sizeof(struct parquet_writer),
    .bytes = parquet_bytes,
    .begin = parquet_begin,
    .block = parquet_block,
    .finish = parquet_finish,
};
