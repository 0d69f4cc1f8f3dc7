/* A table as NumPy's .npz: a zip archive of uncompressed .npy arrays, which numpy.load reads at the
 * speed of memory. Zip libraries need a file or all members in memory, so zip64 writes the records.
 * The archive stores one array after another, but each row arrives with all its columns. A table
 * that is too large to be stored is therefore read in several passes: a pass writes the next array
 * as rows arrive, and stores as many of the following arrays as memory allows. Archives of large
 * tables have checksums after the arrays, small ones before them, for readers that ignore the
 * directory.
 * Leaves to others: the CRC (libdeflate, which costs less than the copy).
 * Invariant: the bytes depend on the numbers only; members and archives may have any size. */
#include "api/encode/encode_arrays.h"
#include "api/encode/zip64.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include <libdeflate.h>

#include "api/base/octets.h"
#include "api/number/number.h"

enum {
    MEMBERS = API_COLUMNS + API_STATS + 1,
    HEAD_BYTES = 128, /* bytes of an array's header: the magic string and the description */
    TEXT_CAP = 100    /* maximum number of characters of a statistic */
};

struct npz_writer {
    struct api_writer base;
    struct api_arrays arrays;
    int next;          /* index of the array that is being written */
    int last;          /* with several passes: arrays before this index are stored in this pass */
    uint64_t at;       /* index of the array's next number */
    uint64_t written;  /* bytes of the archive so far */
    int open, members; /* whether the header of array `next` is written; number of members begun */
    struct api_zip64_member member[MEMBERS];
};

static double npz_bytes(const struct api_table *table) {
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    return 8 * numbers +
           (double)MEMBERS *
               (HEAD_BYTES + API_ZIP64_LOCAL + API_ZIP64_CENTRAL + API_ZIP64_BEHIND + 64) +
           3 * 4 * TEXT_CAP + 4.0 * API_WARNINGS_BYTES + API_ZIP64_END;
}

/* writes the header of a .npy file, format 1.0; shape is "(501, 4)" */
static void npy_head(char head[HEAD_BYTES], const char *type, const char *shape) {
    memset(head, ' ', HEAD_BYTES);
    memcpy(head, "\x93NUMPY\x01\0", 8);
    char *at = stpcpy(api_octets_whole(head + 8, HEAD_BYTES - 10, 2), "{'descr': '");
    at = stpcpy(stpcpy(stpcpy(at, type), "', 'fortran_order': False, 'shape': "), shape);
    at = stpcpy(at, ", }");
    assert(at < head + HEAD_BYTES - 1);
    *at = ' ';
    head[HEAD_BYTES - 1] = '\n';
}

/* appends bytes to the archive; the caller has ensured space in the buffer */
static void npz_add(struct npz_writer *writer, struct api_buffer *out, const void *data,
                    size_t bytes) {
    memcpy(out->data + out->bytes, data, bytes);
    out->bytes += bytes;
    writer->written += bytes;
}

static enum pend_status member_begin(struct npz_writer *writer, const char head[HEAD_BYTES],
                                     struct api_buffer *out) {
    struct api_zip64_member *member = &writer->member[writer->members++];
    char local[API_ZIP64_LOCAL];
    member->offset = writer->written;
    size_t bytes = (size_t)(api_zip64_local(local, member, API_ZIP64_MOST) - local);
    PEND_TRY(api_buffer_room(out, bytes + HEAD_BYTES));
    npz_add(writer, out, local, bytes);
    npz_add(writer, out, head, HEAD_BYTES);
    return PEND_OK;
}

/* ---- arrays */

static uint64_t npz_rows(const struct npz_writer *writer) {
    return (uint64_t)(writer->base.turns ? writer->base.table.rows : writer->base.rows);
}

static uint64_t array_numbers(const struct npz_writer *writer, const struct api_array *array) {
    return npz_rows(writer) * api_array_width(array);
}

static void array_write(const struct npz_writer *writer, const struct api_array *array,
                        uint64_t from, size_t count, char *at) {
    double *const *column = writer->base.column;
    (void)api_array_write(at, array, count, column[array->re] + from,
                          array->im < 0 ? NULL : column[array->im] + from);
}

static uint32_t array_crc(const struct npz_writer *writer, const struct api_array *array,
                          uint32_t crc) {
    enum { SOME = 512 };
    char bytes[SOME * 16];
    uint64_t numbers = array_numbers(writer, array);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    if (array->im < 0 && api_array_bytes(array) == sizeof(double))
        return libdeflate_crc32(crc, writer->base.column[array->re], numbers * sizeof(double));
#endif
    for (uint64_t from = 0; from < numbers; from += SOME) {
        size_t count = numbers - from < SOME ? (size_t)(numbers - from) : SOME;
        array_write(writer, array, from, count, bytes);
        crc = libdeflate_crc32(crc, bytes, count * api_array_bytes(array));
    }
    return crc;
}

/* the shape as a Python tuple; a single row has no axis for rows */
static void array_shape(const struct npz_writer *writer, const struct api_array *array,
                        char shape[64]) {
    int rows = !writer->base.table.single;
    char *at = stpcpy(shape, "(");
    if (rows)
        at = stpcpy(api_number_write_int(at, (long)npz_rows(writer)), array->width ? ", " : ",");
    at = api_array_shape(at, array);
    if (array->width && !rows && !array->inner) at = stpcpy(at, ",");
    stpcpy(at, ")");
}

/* sets a member's name; names come from the operations' tables and always fit */
static void member_name(struct api_zip64_member *member, const char *first, const char *between,
                        const char *second) {
    assert(strlen(first) + strlen(between) + strlen(second) + sizeof ".npy" <= sizeof member->name);
    stpcpy(stpcpy(stpcpy(stpcpy(member->name, first), between), second), ".npy");
}

static enum pend_status array_begin(struct npz_writer *writer, const struct api_array *array,
                                    struct api_buffer *out) {
    struct api_zip64_member *member = &writer->member[writer->members];
    char head[HEAD_BYTES], shape[64];
    member_name(member, array->name, array->part ? "_" : "", array->part ? array->part : "");
    array_shape(writer, array, shape);
    npy_head(head, api_array_type(array), shape);
    double numbers = (double)npz_rows(writer) * api_table_numbers(&writer->base.table, 0);
    // the checksums of large arrays follow them in data descriptors
    member->streamed = numbers * (double)sizeof(double) > writer->base.most;
    member->bytes = HEAD_BYTES + array_numbers(writer, array) * api_array_bytes(array);
    member->crc = libdeflate_crc32(0, head, HEAD_BYTES);
    if (!member->streamed) member->crc = array_crc(writer, array, member->crc);
    writer->open = 1;
    return member_begin(writer, head, out);
}

/* accounts for numbers of the open array that the caller wrote directly into the buffer */
static void array_pass(struct npz_writer *writer, const struct api_array *array, size_t count,
                       struct api_buffer *out) {
    struct api_zip64_member *member = &writer->member[writer->members - 1];
    size_t bytes = count * api_array_bytes(array);
    if (member->streamed)
        member->crc = libdeflate_crc32(member->crc, out->data + out->bytes, bytes);
    out->bytes += bytes;
    writer->written += bytes;
    writer->at += count;
}

/* writes the next numbers of a kept array, about API_PIECE_BYTES */
static enum pend_status array_go_on(struct npz_writer *writer, const struct api_array *array,
                                    struct api_buffer *out) {
    uint64_t rest = array_numbers(writer, array) - writer->at;
    size_t count = API_PIECE_BYTES / api_array_bytes(array);
    if (count > rest) count = (size_t)rest;
    if (!count) return PEND_OK;
    PEND_TRY(api_buffer_room(out, count * api_array_bytes(array)));
    array_write(writer, array, writer->at, count, out->data + out->bytes);
    array_pass(writer, array, count, out);
    return PEND_OK;
}

static enum pend_status array_end(struct npz_writer *writer, struct api_buffer *out) {
    const struct api_zip64_member *member = &writer->member[writer->members - 1];
    char behind[API_ZIP64_BEHIND];
    PEND_TRY(api_buffer_room(out, sizeof behind));
    if (member->streamed)
        npz_add(writer, out, behind, (size_t)(api_zip64_behind(behind, member) - behind));
    writer->next++;
    writer->at = 0;
    writer->open = 0;
    return PEND_OK;
}

/* ---- several passes over the rows */

/* starts a pass: chooses its arrays, and assigns memory to those that are written later */
static enum pend_status turn_begin(struct npz_writer *writer, struct api_buffer *out) {
    const struct api_arrays *arrays = &writer->arrays;
    double numbers = 0;
    writer->last = writer->next + 1;
    for (; writer->last < arrays->count; writer->last++) {
        const struct api_array *array = &arrays->array[writer->last];
        double more = (double)array_numbers(writer, array) * (array->im >= 0 ? 2 : 1);
        if ((numbers + more) * (double)sizeof(double) > writer->base.most) break;
        numbers += more;
    }
    free(writer->base.kept);
    writer->base.kept = malloc((size_t)numbers * sizeof(double) + 1);
    if (!writer->base.kept) return PEND_NO_MEMORY;
    double *at = writer->base.kept;
    for (int a = writer->next + 1; a < writer->last; a++) {
        const struct api_array *array = &arrays->array[a];
        size_t each = (size_t)array_numbers(writer, array);
        writer->base.column[array->re] = at, at += each;
        if (array->im >= 0) writer->base.column[array->im] = at, at += each;
    }
    return array_begin(writer, &arrays->array[writer->next], out);
}

static enum pend_status npz_turn(struct api_writer *base, long rows, const double *const data[],
                                 struct api_buffer *out) {
    struct npz_writer *writer = (struct npz_writer *)base;
    const struct api_array *array = &writer->arrays.array[writer->next];
    assert(rows >= 0 && writer->next < writer->arrays.count);
    if (!writer->open) PEND_TRY(turn_begin(writer, out));
    size_t count = (size_t)rows * api_array_width(array);
    PEND_TRY(api_buffer_room(out, count * api_array_bytes(array) + 1));
    (void)api_array_write(out->data + out->bytes, array, count, data[array->re],
                          array->im < 0 ? NULL : data[array->im]);
    array_pass(writer, array, count, out);
    for (int a = writer->next + 1; a < writer->last; a++) {
        array = &writer->arrays.array[a];
        size_t width = api_array_width(array), from = (size_t)base->rows * width,
               bytes = (size_t)rows * width * sizeof(double);
        if (bytes) memcpy(base->column[array->re] + from, data[array->re], bytes);
        if (bytes && array->im >= 0) memcpy(base->column[array->im] + from, data[array->im], bytes);
    }
    return PEND_OK;
}

static enum pend_status member_add(struct npz_writer *writer, const char *first, const char *second,
                                   const char *type, const char *shape, const char *value,
                                   size_t bytes, struct api_buffer *out) {
    struct api_zip64_member *member = &writer->member[writer->members];
    char head[HEAD_BYTES];
    member_name(member, first, *second ? "_" : "", second);
    npy_head(head, type, shape);
    member->bytes = HEAD_BYTES + bytes;
    member->crc = libdeflate_crc32(libdeflate_crc32(0, head, HEAD_BYTES), value, bytes);
    PEND_TRY(member_begin(writer, head, out));
    PEND_TRY(api_buffer_room(out, bytes));
    npz_add(writer, out, value, bytes);
    return PEND_OK;
}

static enum pend_status stat_add(struct npz_writer *writer, const struct api_stat *stat,
                                 struct api_buffer *out) {
    char type[16] = "<f8", value[4 * TEXT_CAP], *end = value;
    if (stat->kind == API_STAT_TEXT) {
        /* NumPy stores text as UTF-32; these texts are ASCII */
        for (const char *p = stat->text; *p && p < stat->text + TEXT_CAP; p++)
            end = api_octets_whole(end, (unsigned char)*p, 4);
        *api_number_write_int(stpcpy(type, "<U"), (end - value) / 4) = 0;
    } else if (stat->kind == API_STAT_WHOLE) {
        memcpy(type, "<i8", 4);
        end = api_octets_whole(value, (uint64_t)stat->whole, 8);
    } else {
        end = api_octets_double(value, stat->number);
    }
    return member_add(writer, "stats", stat->name, type, "()", value, (size_t)(end - value), out);
}

static enum pend_status warnings_add(struct npz_writer *writer, const struct api_stats *stats,
                                     struct api_buffer *out) {
    char type[16], shape[24], value[4 * API_WARNINGS * API_WARNING_TEXT] = {0}, *end = value;
    int count = api_stats_warnings(stats);
    if (!count) return PEND_OK;
    for (int i = 0; i < stats->count; i++) {
        if (stats->stat[i].kind != API_STAT_WARNING) continue;
        char *at = end;
        for (const char *p = stats->stat[i].text; *p; p++)
            at = api_octets_whole(at, (unsigned char)*p, 4);
        end += 4 * API_WARNING_TEXT;
    }
    *api_number_write_int(stpcpy(type, "<U"), API_WARNING_TEXT) = 0;
    strcpy(api_number_write_int(stpcpy(shape, "("), count), ",)");
    return member_add(writer, "warnings", "", type, shape, value, (size_t)(end - value), out);
}

static enum pend_status npz_directory(struct npz_writer *writer, struct api_buffer *out) {
    uint64_t begin = writer->written;
    char record[API_ZIP64_CENTRAL], end[API_ZIP64_END];
    PEND_TRY(api_buffer_room(out, (size_t)writer->members * sizeof record + sizeof end));
    for (int i = 0; i < writer->members; i++) {
        const char *at = api_zip64_central(record, &writer->member[i], API_ZIP64_MOST);
        npz_add(writer, out, record, (size_t)(at - record));
    }
    const char *at =
        api_zip64_end(end, writer->members, begin, writer->written - begin, API_ZIP64_MOST);
    npz_add(writer, out, end, (size_t)(at - end));
    return PEND_OK;
}

static enum pend_status npz_begin(struct api_writer *base, struct api_buffer *out) {
    (void)out;
    api_arrays_init(&((struct npz_writer *)base)->arrays, &base->table);
    return PEND_OK;
}

static enum pend_status npz_finish(struct api_writer *base, struct api_buffer *out, int *done) {
    struct npz_writer *writer = (struct npz_writer *)base;
    size_t before = out->bytes;
    while (writer->next < writer->arrays.count) {
        const struct api_array *array = &writer->arrays.array[writer->next];
        if (out->bytes - before >= API_PIECE_BYTES) return PEND_OK;
        if (base->turns && writer->next == writer->last) {
            base->again = 1;
            return PEND_OK;
        }
        if (!writer->open) PEND_TRY(array_begin(writer, array, out));
        PEND_TRY(array_go_on(writer, array, out));
        if (writer->at == array_numbers(writer, array)) PEND_TRY(array_end(writer, out));
    }
    for (int i = 0; base->stats && i < base->stats->count; i++)
        if (base->stats->stat[i].kind != API_STAT_WARNING)
            PEND_TRY(stat_add(writer, &base->stats->stat[i], out));
    PEND_TRY(warnings_add(writer, base->stats, out));
    PEND_TRY(npz_directory(writer, out));
    *done = 1;
    return PEND_OK;
}

const struct api_format api_format_npz = {
    .media_type = "application/x-npz",
    .extension = "npz",
    .samples_only = 1,
    .binary = 1,
    .writer_bytes = sizeof(struct npz_writer),
    .bytes = npz_bytes,
    .begin = npz_begin,
    .turn = npz_turn,
    .finish = npz_finish,
};
