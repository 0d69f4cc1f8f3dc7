/* A table as one NumPy array of records, .npy: numpy.load reads it, and maps it where it is a file.
 * Leaves to others: archives of arrays (encode_npz).
 * Invariant: the bytes depend on the numbers only; it streams, so there is no limit of size. */
#include "api/encode/encode_arrays.h"

#include <assert.h>
#include <string.h>

#include "api/base/octets.h"
#include "api/number/number.h"

/* bytes of the magic and the length of the description, format 2.0, and what the whole head is a
 * multiple of; letters of a field of the description, at most */
enum { MAGIC_BYTES = 12, ALIGNED = 64, FIELD_BYTES = 112 };

struct npy_writer {
    struct api_writer base;
    struct api_arrays arrays;
};

/* writes the description of the records: "[('t', '<f8'), ('phi', '<f8', (4,)), ...]" */
static char *npy_fields(char *at, const struct api_arrays *arrays) {
    at = stpcpy(at, "[");
    for (int i = 0; i < arrays->count; i++) {
        const struct api_array *array = &arrays->array[i];
        at = stpcpy(stpcpy(at, i ? ", ('" : "('"), array->name);
        if (array->part) at = stpcpy(stpcpy(at, "_"), array->part);
        at = stpcpy(stpcpy(stpcpy(at, "', '"), api_array_type(array)), "'");
        if (array->width) {
            at = api_array_shape(stpcpy(at, ", ("), array);
            at = stpcpy(at, array->inner ? ")" : ",)");
        }
        at = stpcpy(at, ")");
    }
    return stpcpy(at, "]");
}

/* writes the whole head; returns its bytes, a multiple of ALIGNED */
static size_t npy_head(char *head, const struct api_arrays *arrays, const struct api_table *table) {
    memcpy(head, "\x93NUMPY\x02\0", 8);
    char *at = stpcpy(head + MAGIC_BYTES, "{'descr': ");
    at = stpcpy(npy_fields(at, arrays), ", 'fortran_order': False, 'shape': (");
    at = table->single ? at : stpcpy(api_number_write_int(at, table->rows), ",");
    at = stpcpy(at, "), }");
    size_t bytes = ((size_t)(at - head) + 1 + ALIGNED - 1) / ALIGNED * ALIGNED;
    memset(at, ' ', bytes - (size_t)(at - head));
    head[bytes - 1] = '\n';
    api_octets_whole(head + 8, bytes - MAGIC_BYTES, 4);
    return bytes;
}

enum { HEAD_MOST = API_COLUMNS * FIELD_BYTES + 3 * ALIGNED };

static size_t row_bytes(const struct api_arrays *arrays) {
    size_t bytes = 0;
    for (int i = 0; i < arrays->count; i++) {
        const struct api_array *array = &arrays->array[i];
        bytes += api_array_bytes(array) * (array->width ? (size_t)array->width : 1);
    }
    return bytes;
}

static double npy_bytes(const struct api_table *table) {
    struct api_arrays arrays;
    char head[HEAD_MOST];
    api_arrays_init(&arrays, table);
    return (double)npy_head(head, &arrays, table) +
           (double)table->rows * (double)row_bytes(&arrays);
}

static enum pend_status npy_begin(struct api_writer *base, struct api_buffer *out) {
    struct npy_writer *writer = (struct npy_writer *)base;
    api_arrays_init(&writer->arrays, &base->table);
    PEND_TRY(api_buffer_room(out, HEAD_MOST));
    out->bytes += npy_head(out->data + out->bytes, &writer->arrays, &base->table);
    return PEND_OK;
}

static enum pend_status npy_block(struct api_writer *base, long rows, const double *const data[],
                                  struct api_buffer *out) {
    const struct npy_writer *writer = (const struct npy_writer *)base;
    const struct api_arrays *arrays = &writer->arrays;
    PEND_TRY(api_buffer_room(out, (size_t)rows * row_bytes(arrays)));
    char *at = out->data + out->bytes;
    assert(rows >= 0 && arrays->count >= 1);
    for (long i = 0; i < rows; i++)
        for (int a = 0; a < arrays->count; a++) {
            const struct api_array *array = &arrays->array[a];
            size_t width = array->width ? (size_t)array->width : 1, from = (size_t)i * width;
            at = api_array_write(at, array, width, data[array->re] + from,
                                 array->im < 0 ? NULL : data[array->im] + from);
        }
    out->bytes = (size_t)(at - out->data);
    return PEND_OK;
}

const struct api_format api_format_npy = {
    .media_type = "application/x-npy",
    .content_type = "application/x-npy",
    .extension = "npy",
    .samples_only = 1,
    .exact = 1,
    .binary = 1,
    .counted = 1,
    .bare = 1, // it has its columns, but no place for figures
    .writer_bytes = sizeof(struct npy_writer),
    .bytes = npy_bytes,
    .begin = npy_begin,
    .block = npy_block,
};
