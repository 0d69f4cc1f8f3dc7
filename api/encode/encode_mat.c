/* A table as a level 5 MAT-file for MATLAB and Octave; z is complex, energy and stats are
 * structures. libmatio is not used: it writes only to named files.
 * Leaves to others: which columns there are (op_*).
 * Invariant: every element begins at a multiple of 8 bytes; the bytes depend on the numbers
 * only. */
#include "api/encode/encode_arrays.h"

#include <stdio.h>
#include <string.h>

#include "api/base/octets.h"

/* data types and array classes of "MAT-File Format", R2006b */
enum { INT8 = 1, UINT16 = 4, INT32 = 5, UINT32 = 6, DOUBLE = 9, MATRIX = 14 };
enum { STRUCT_CLASS = 2, CHAR_CLASS = 4, DOUBLE_CLASS = 6, COMPLEX_FLAG = 1 << 11 };

enum {
    FILE_HEAD = 128,
    TAG = 8,
    NAME_BYTES = 32,
    HEAD_CAP = 2 * TAG + 2 * (TAG + 8) + 8 + NAME_BYTES,
    TEXT_CAP = 100
};

struct mat_writer {
    struct api_writer base;
    struct api_arrays arrays;
    int next;    /* index of the array that is being written */
    int begun;   /* whether the file's header is written */
    int open;    /* whether the head of array `next` is written */
    int part;    /* the part of that array being written: 0 = re, 1 = im */
    uint64_t at; /* index of the next number of that part */
};

static double mat_bytes(const struct api_table *table) {
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    return 8 * numbers + FILE_HEAD +
           (double)(API_COLUMNS + API_STATS) * (3 * HEAD_CAP + NAME_BYTES) + 8 * TEXT_CAP +
           2.0 * API_WARNINGS_BYTES;
}

static uint64_t padded(uint64_t bytes) { return (bytes + 7) / 8 * 8; }

static char *tag(char *at, int type, uint64_t bytes) {
    return api_octets_whole(api_octets_whole(at, (uint64_t)type, 4), bytes, 4);
}

/* writes text, padded with zeros to a multiple of 8 bytes */
static char *pad(char *at, const char *text, size_t bytes) {
    size_t whole = (size_t)padded(bytes);
    memset(at, 0, whole);
    memcpy(at, text, bytes);
    return at + whole;
}

/* writes an array's flags, dimensions (the third is 0 if absent) and name, which follow its tag */
static char *array_head(char *at, unsigned flags, const long size[3], const char *name) {
    size_t bytes = strlen(name);
    at = api_octets_whole(tag(at, UINT32, 8), flags, 8);
    at = tag(at, INT32, size[2] ? 12 : 8);
    for (int i = 0; i < (size[2] ? 4 : 2); i++)
        at = api_octets_whole(at, i < 3 ? (uint64_t)size[i] : 0, 4);
    if (bytes && bytes <= 4) {
        /* a name of at most 4 bytes is stored inside its tag */
        at = api_octets_whole(api_octets_whole(at, INT8, 2), bytes, 2);
        memset(at, 0, 4);
        memcpy(at, name, bytes);
        return at + 4;
    }
    return pad(tag(at, INT8, bytes), name, bytes);
}

static char *matrix_head(char *at, unsigned flags, long rows, long columns, const char *name) {
    const long size[3] = {rows, columns, 0};
    return array_head(at, flags, size, name);
}

static uint64_t matrix_head_bytes(const char *name) {
    size_t bytes = strlen(name);
    return 2 * (TAG + 8) + (bytes && bytes <= 4 ? TAG : TAG + padded(bytes));
}

/* writes the head of a structure with its field names; the fields, `bytes` in all, follow as
 * unnamed matrices */
static enum pend_status struct_begin(const char *name, int count, const char *const field[],
                                     uint64_t bytes, struct api_buffer *out) {
    uint64_t names = (uint64_t)count * NAME_BYTES;
    PEND_TRY(api_buffer_room(out, TAG + HEAD_CAP + TAG + TAG + names));
    char *at =
        tag(out->data + out->bytes, MATRIX, matrix_head_bytes(name) + TAG + TAG + names + bytes);
    at = matrix_head(at, STRUCT_CLASS, 1, 1, name);
    at = api_octets_whole(api_octets_whole(at, INT32, 2), 4, 2);
    at = tag(api_octets_whole(at, NAME_BYTES, 4), INT8, names);
    memset(at, 0, names);
    for (int i = 0; i < count; i++, at += NAME_BYTES)
        memcpy(at, field[i], strnlen(field[i], NAME_BYTES - 1));
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

/* (arrays) MATLAB's order is column-major, in which the numbers of each arm are contiguous */

static uint64_t part_numbers(const struct mat_writer *writer, const struct api_array *array) {
    return (uint64_t)writer->base.rows * api_array_width(array);
}

/* bytes of a matrix without its tag */
static uint64_t array_bytes(const struct mat_writer *writer, const struct api_array *array,
                            const char *name) {
    uint64_t parts = array->im < 0 ? 1 : 2;
    return matrix_head_bytes(name) + (array->inner ? 8 : 0) +
           parts * (TAG + 8 * part_numbers(writer, array));
}

/* true if array i is the first with its name, so that it opens a structure */
static int array_leads(const struct mat_writer *writer, int i) {
    const struct api_array *array = &writer->arrays.array[i];
    return array->part && (!i || !array[-1].part || strcmp(array[-1].name, array->name));
}

/* opens the structure that contains all arrays with the name of array `next` */
static enum pend_status array_struct(const struct mat_writer *writer, struct api_buffer *out) {
    const struct api_array *first = &writer->arrays.array[writer->next];
    const char *field[API_COLUMNS];
    uint64_t bytes = 0;
    int count = 0;
    for (int i = writer->next; i < writer->arrays.count; i++) {
        const struct api_array *array = &writer->arrays.array[i];
        if (!array->part || strcmp(array->name, first->name)) break;
        field[count++] = array->part;
        bytes += TAG + array_bytes(writer, array, "");
    }
    return struct_begin(first->name, count, field, bytes, out);
}

static enum pend_status array_begin(const struct mat_writer *writer, struct api_buffer *out) {
    const struct api_array *array = &writer->arrays.array[writer->next];
    const char *name = array->part ? "" : array->name;
    unsigned flags = DOUBLE_CLASS | (array->im < 0 ? 0 : COMPLEX_FLAG);
    if (array_leads(writer, writer->next)) PEND_TRY(array_struct(writer, out));
    PEND_TRY(api_buffer_room(out, TAG + HEAD_CAP));
    char *at = tag(out->data + out->bytes, MATRIX, array_bytes(writer, array, name));
    long width = (long)api_array_width(array), inner = array->inner;
    const long size[3] = {writer->base.rows, inner ? width / inner : width, inner};
    at = array_head(at, flags, size, name);
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

/* index in the row of number `at` in MATLAB's order: arms vary faster than the second axis */
static uint64_t array_place(const struct api_array *array, uint64_t at) {
    uint64_t inner = (uint64_t)array->inner, arms = (uint64_t)array->width / inner;
    return at % arms * inner + at / arms;
}

/* writes the next numbers of the part, about API_PIECE_BYTES */
static enum pend_status array_go_on(struct mat_writer *writer, struct api_buffer *out) {
    const struct api_array *array = &writer->arrays.array[writer->next];
    const double *number = writer->base.column[writer->part ? array->im : array->re];
    uint64_t numbers = part_numbers(writer, array), rows = (uint64_t)writer->base.rows,
             rest = API_PIECE_BYTES / 8;
    size_t width = api_array_width(array);
    PEND_TRY(api_buffer_room(out, TAG + API_PIECE_BYTES));
    char *at = out->data + out->bytes;
    if (!writer->at) at = tag(at, DOUBLE, 8 * numbers);
    while (rest && writer->at < numbers) {
        uint64_t row = writer->at % rows, arm = writer->at / rows,
                 count = rows - row < rest ? rows - row : rest;
        if (array->inner) arm = array_place(array, arm);
        at = api_octets_spread(at, (size_t)count, number + row * width + arm, width);
        writer->at += count;
        rest -= count;
    }
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

/* ---- statistics: a structure of scalars and texts */

static char *stat_write(char *at, const struct api_stat *stat) {
    double number = stat->kind == API_STAT_WHOLE ? (double)stat->whole : stat->number;
    if (stat->kind == API_STAT_TEXT) {
        size_t letters = strnlen(stat->text, TEXT_CAP);
        at = tag(at, MATRIX, matrix_head_bytes("") + TAG + padded(2 * letters));
        at = tag(matrix_head(at, CHAR_CLASS, 1, (long)letters, ""), UINT16, 2 * letters);
        memset(at, 0, (size_t)padded(2 * letters));
        for (size_t i = 0; i < letters; i++)
            api_octets_whole(at + 2 * i, (unsigned char)stat->text[i], 2);
        return at + padded(2 * letters);
    }
    at = tag(at, MATRIX, matrix_head_bytes("") + TAG + 8);
    return api_octets_double(tag(matrix_head(at, DOUBLE_CLASS, 1, 1, ""), DOUBLE, 8), number);
}

static enum pend_status mat_stats(const struct api_stats *stats, struct api_buffer *out) {
    char fields[API_STATS * (TAG + HEAD_CAP + TAG + 2 * TEXT_CAP + 8)], *end = fields;
    const char *name[API_STATS];
    int count = 0;
    for (int i = 0; i < stats->count; i++) {
        if (stats->stat[i].kind == API_STAT_WARNING) continue;
        name[count++] = stats->stat[i].name;
        end = stat_write(end, &stats->stat[i]);
    }
    PEND_TRY(struct_begin("stats", count, name, (uint64_t)(end - fields), out));
    return api_buffer_add(out, fields, (size_t)(end - fields));
}

/* writes the warnings: a character matrix with one row each, in column-major order */
static enum pend_status mat_warnings(const struct api_stats *stats, struct api_buffer *out) {
    int count = api_stats_warnings(stats), row = 0;
    uint64_t bytes = padded(2 * API_WARNING_TEXT * (uint64_t)count);
    if (!count) return PEND_OK;
    PEND_TRY(api_buffer_room(out, TAG + HEAD_CAP + TAG + bytes));
    char *at = tag(out->data + out->bytes, MATRIX, matrix_head_bytes("warnings") + TAG + bytes);
    at = tag(matrix_head(at, CHAR_CLASS, count, API_WARNING_TEXT, "warnings"), UINT16, bytes);
    for (uint64_t i = 0; i < bytes / 2; i++) api_octets_whole(at + 2 * i, ' ', 2);
    for (int i = 0; i < stats->count; i++) {
        if (stats->stat[i].kind != API_STAT_WARNING) continue;
        const char *text = stats->stat[i].text;
        for (int k = 0; text[k]; k++)
            api_octets_whole(at + 2 * (k * count + row), (unsigned char)text[k], 2);
        row++;
    }
    out->bytes = (size_t)(at - out->data) + bytes;
    return PEND_OK;
}

static enum pend_status mat_begin_file(struct mat_writer *writer, struct api_buffer *out) {
    static const char text[] = "MATLAB 5.0 MAT-file, written by pendulumd";
    char head[FILE_HEAD];
    memset(head, ' ', sizeof head);
    memcpy(head, text, sizeof text - 1);
    memset(head + 116, 0, 8);
    memcpy(head + 124, "\0\1IM", 4); /* version 0x0100, little-endian */
    writer->begun = 1;
    return api_buffer_add(out, head, sizeof head);
}

static enum pend_status mat_begin(struct api_writer *base, struct api_buffer *out) {
    (void)out;
    api_arrays_init(&((struct mat_writer *)base)->arrays, &base->table);
    return PEND_OK;
}

/* continues with the imaginary part, or with the next array */
static void mat_go_on(struct mat_writer *writer) {
    const struct api_array *array = &writer->arrays.array[writer->next];
    writer->at = 0;
    if (!writer->part && array->im >= 0) {
        writer->part = 1;
        return;
    }
    writer->part = 0;
    writer->open = 0;
    writer->next++;
}

static enum pend_status mat_finish(struct api_writer *base, struct api_buffer *out, int *done) {
    struct mat_writer *writer = (struct mat_writer *)base;
    size_t before = out->bytes;
    if (!writer->begun) PEND_TRY(mat_begin_file(writer, out));
    while (writer->next < writer->arrays.count) {
        if (out->bytes - before >= API_PIECE_BYTES) return PEND_OK;
        if (!writer->open) PEND_TRY(array_begin(writer, out));
        writer->open = 1;
        PEND_TRY(array_go_on(writer, out));
        if (writer->at == part_numbers(writer, &writer->arrays.array[writer->next]))
            mat_go_on(writer);
    }
    if (base->stats) PEND_TRY(mat_stats(base->stats, out));
    if (base->stats) PEND_TRY(mat_warnings(base->stats, out));
    *done = 1;
    return PEND_OK;
}

const struct api_format api_format_mat = {
    .media_type = "application/x-matlab-data",
    .extension = "mat",
    .samples_only = 1,
    .most_bytes = 0x7fffffff,
    .writer_bytes = sizeof(struct mat_writer),
    .bytes = mat_bytes,
    .begin = mat_begin,
    .finish = mat_finish,
};
