/* A table as HDF5: one data set per column, statistics and warnings as attributes of the root
 * group. Real and imaginary parts are separate data sets, because Octave silently reads pairs as
 * zeros and MATLAB reads them as structures. Arrays are divided into chunks, half a megabyte for
 * one chunk of every array. Chunks are written as they are computed; the B-trees that index them
 * follow at the end. libhdf5 is not used: it needs a file in which it can seek, has 3.5 MB, and
 * opens plugins that environment variables name. hdf5 writes the few kinds of records needed.
 * Leaves to others: the records (hdf5).
 * Invariant: the bytes depend on the numbers and statistics only; it streams, so there is no size
 * limit; at most one chunk of each array is in memory. */
#include "api/encode/encode_arrays.h"
#include "api/encode/hdf5.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/base/octets.h"

/* Most bytes of a chunk of all arrays (more if one row is larger), of the name of an array or
 * statistic, and of all attributes. */
enum {
    PIECE_BYTES = 1 << 19,
    NAME_BYTES = 64,
    TEXT_BYTES = 100,
    FIGURES_BYTES =
        API_STATS * (64 + NAME_BYTES + TEXT_BYTES + 1) + 64 + NAME_BYTES + API_WARNINGS_BYTES
};

/* the layout of the file; offsets in bytes */
struct plan {
    struct api_arrays arrays;
    size_t row;                     /* bytes of one row of all arrays */
    uint64_t most, pieces;          /* rows per chunk; chunks per array */
    int divided;                    /* whether there are several chunks */
    size_t before[API_COLUMNS + 1]; /* for each array, the bytes per row of the arrays before it */
    uint64_t tree[API_COLUMNS], heads, root, end;
    size_t root_bytes;
};

struct hdf5_writer {
    struct api_writer base;
    struct plan plan;
    uint64_t held; /* number of stored rows of the current chunk */
    int array;     /* the array whose B-tree is being written */
    uint64_t node; /* index of the next node of that tree */
    char piece[PIECE_BYTES];
};

static void array_name(const struct api_array *array, char name[NAME_BYTES]) {
    assert(strlen(array->name) + (array->part ? strlen(array->part) : 0) + 2 < NAME_BYTES);
    char *at = stpcpy(name, array->name);
    if (array->part) stpcpy(stpcpy(at, "_"), array->part);
}

/* describes an array for the records; the caller sets its address */
static struct api_hdf5_array array_facts(const struct api_table *table, const struct plan *plan,
                                         const struct api_array *array) {
    struct api_hdf5_array facts = {.piece = plan->divided ? plan->most : 0};
    int narrow = array->float32;
    facts.type = narrow ? API_HDF5_FLOAT : API_HDF5_DOUBLE;
    if (!table->single) facts.length[facts.axes++] = (uint64_t)table->rows;
    if (array->inner) facts.length[facts.axes++] = (uint64_t)(array->width / array->inner);
    if (array->width)
        facts.length[facts.axes++] = (uint64_t)(array->inner ? array->inner : array->width);
    return facts;
}

static void plan_init(struct plan *plan, const struct api_table *table) {
    struct api_arrays *arrays = &plan->arrays;
    arrays->count = table->count;
    for (int c = 0; c < table->count; c++) arrays->array[c] = api_array_of(table, c);
    uint64_t rows = (uint64_t)table->rows;
    char name[NAME_BYTES];
    plan->row = 0;
    for (int i = 0; i < arrays->count; i++) {
        const struct api_array *array = &arrays->array[i];
        plan->before[i] = plan->row;
        plan->row += api_array_bytes(array) * api_array_width(array);
    }
    plan->before[arrays->count] = plan->row;
    plan->most = plan->row < PIECE_BYTES ? PIECE_BYTES / plan->row : 1;
    plan->divided = rows > plan->most;
    if (!plan->divided) plan->most = rows;
    plan->pieces = plan->divided ? (rows + plan->most - 1) / plan->most : rows > 0;
    uint64_t at = API_HDF5_SUPERBLOCK + plan->pieces * plan->most * plan->row;
    for (int i = 0; i < arrays->count; i++) {
        plan->tree[i] = at;
        if (!plan->divided) continue;
        int axes = array_facts(table, plan, &arrays->array[i]).axes;
        at += api_hdf5_nodes(plan->pieces) * api_hdf5_node_bytes(axes);
    }
    plan->heads = at;
    plan->root = at + (uint64_t)arrays->count * API_HDF5_HEADER;
    plan->root_bytes = 64 + FIGURES_BYTES;
    for (int i = 0; i < arrays->count; i++) {
        array_name(&arrays->array[i], name);
        plan->root_bytes += 15 + strlen(name);
    }
    plan->end = plan->root + plan->root_bytes;
}

static double hdf5_bytes(const struct api_table *table) {
    struct plan plan;
    plan_init(&plan, table);
    return (double)plan.end;
}

static enum pend_status hdf5_begin(struct api_writer *base, struct api_buffer *out) {
    struct hdf5_writer *writer = (struct hdf5_writer *)base;
    plan_init(&writer->plan, &base->table);
    PEND_TRY(api_buffer_room(out, API_HDF5_SUPERBLOCK));
    api_hdf5_superblock(out->data + out->bytes, writer->plan.root, writer->plan.end);
    out->bytes += API_HDF5_SUPERBLOCK;
    return PEND_OK;
}

/* copies rows [from, from + rows) of a block to rows [to, ...) of the current chunk of each array
 */
static void rows_put(const struct hdf5_writer *writer, char *piece, uint64_t to, long from,
                     long rows, const double *const data[]) {
    const struct plan *plan = &writer->plan;
    for (int i = 0; i < plan->arrays.count; i++) {
        const struct api_array *array = &plan->arrays.array[i];
        size_t width = api_array_width(array), skip = (size_t)from * width;
        size_t each = plan->before[i + 1] - plan->before[i];
        char *at = piece + plan->most * plan->before[i] + to * each;
        (void)api_array_write(at, array, (size_t)rows * width, data[array->re] + skip, NULL);
    }
}

static enum pend_status hdf5_block(struct api_writer *base, long rows, const double *const data[],
                                   struct api_buffer *out) {
    struct hdf5_writer *writer = (struct hdf5_writer *)base;
    const struct plan *plan = &writer->plan;
    size_t bytes = plan->most * plan->row;
    assert(rows >= 0 && (!rows || writer->held < plan->most));
    for (long i = 0; i < rows;) {
        uint64_t room = plan->most - writer->held, left = (uint64_t)(rows - i);
        long some = (long)(left < room ? left : room);
        if (bytes > PIECE_BYTES) { // a row that is a chunk by itself
            PEND_TRY(api_buffer_room(out, bytes));
            rows_put(writer, out->data + out->bytes, 0, i++, 1, data);
            out->bytes += bytes;
            continue;
        }
        rows_put(writer, writer->piece, writer->held, i, some, data);
        i += some;
        writer->held += (uint64_t)some;
        if (writer->held < plan->most) continue;
        PEND_TRY(api_buffer_add(out, writer->piece, bytes));
        writer->held = 0;
    }
    return PEND_OK;
}

static enum pend_status piece_end(struct hdf5_writer *writer, struct api_buffer *out) {
    const struct plan *plan = &writer->plan;
    for (int i = 0; i < plan->arrays.count; i++) {
        size_t each = plan->before[i + 1] - plan->before[i];
        memset(writer->piece + plan->most * plan->before[i] + writer->held * each, 0,
               (plan->most - writer->held) * each);
    }
    writer->held = 0;
    return api_buffer_add(out, writer->piece, plan->most * plan->row);
}

/* writes B-tree nodes, at most about API_PIECE_BYTES */
static enum pend_status trees_go_on(struct hdf5_writer *writer, struct api_buffer *out) {
    const struct plan *plan = &writer->plan;
    size_t start = out->bytes;
    while (writer->array < plan->arrays.count && out->bytes - start < API_PIECE_BYTES) {
        int i = writer->array;
        struct api_hdf5_array facts =
            array_facts(&writer->base.table, plan, &plan->arrays.array[i]);
        size_t bytes = api_hdf5_node_bytes(facts.axes);
        PEND_TRY(api_buffer_room(out, bytes));
        api_hdf5_node(out->data + out->bytes, &facts, writer->node, plan->tree[i],
                      API_HDF5_SUPERBLOCK + plan->most * plan->before[i], plan->most * plan->row);
        out->bytes += bytes;
        if (++writer->node < api_hdf5_nodes(plan->pieces)) continue;
        writer->node = 0;
        writer->array++;
    }
    return PEND_OK;
}

static enum pend_status heads_add(struct hdf5_writer *writer, struct api_buffer *out) {
    const struct plan *plan = &writer->plan;
    PEND_TRY(api_buffer_room(out, (size_t)plan->arrays.count * API_HDF5_HEADER));
    for (int i = 0; i < plan->arrays.count; i++) {
        struct api_hdf5_array facts =
            array_facts(&writer->base.table, plan, &plan->arrays.array[i]);
        if (plan->divided)
            facts.place = plan->tree[i] +
                          (api_hdf5_nodes(plan->pieces) - 1) * api_hdf5_node_bytes(facts.axes);
        else
            facts.place = plan->pieces
                              ? API_HDF5_SUPERBLOCK + (uint64_t)plan->most * plan->before[i]
                              : API_HDF5_NOWHERE;
        api_hdf5_array(out->data + out->bytes, &facts);
        out->bytes += API_HDF5_HEADER;
    }
    return PEND_OK;
}

static char *figure_put(char *at, const struct api_stat *stat) {
    char value[TEXT_BYTES + 1] = "";
    if (stat->kind == API_STAT_WHOLE) {
        api_octets_whole(value, (uint64_t)stat->whole, 8);
        return api_hdf5_number(at, stat->name, API_HDF5_WHOLE, value);
    }
    if (stat->kind == API_STAT_NUMBER) {
        api_octets_double(value, stat->number);
        return api_hdf5_number(at, stat->name, API_HDF5_DOUBLE, value);
    }
    stpncpy(value, stat->text, TEXT_BYTES);
    return api_hdf5_text(at, stat->name, -1, strlen(value) + 1, value);
}

static char *figures_put(char *at, const struct api_stats *stats) {
    char words[API_WARNINGS_BYTES] = "";
    int warnings = 0;
    for (int i = 0; stats && i < stats->count; i++) {
        const struct api_stat *stat = &stats->stat[i];
        if (stat->kind == API_STAT_WARNING)
            stpncpy(words + API_WARNING_TEXT * warnings++, stat->text, API_WARNING_TEXT);
        else
            at = figure_put(at, stat);
    }
    return warnings ? api_hdf5_text(at, "warnings", warnings, API_WARNING_TEXT, words) : at;
}

static enum pend_status root_add(struct hdf5_writer *writer, struct api_buffer *out) {
    const struct plan *plan = &writer->plan;
    char name[NAME_BYTES];
    PEND_TRY(api_buffer_room(out, plan->root_bytes));
    char *head = out->data + out->bytes, *at = api_hdf5_group(api_hdf5_begin(head));
    for (int i = 0; i < plan->arrays.count; i++) {
        array_name(&plan->arrays.array[i], name);
        at = api_hdf5_link(at, name, plan->heads + (uint64_t)i * API_HDF5_HEADER);
    }
    api_hdf5_end(head, figures_put(at, writer->base.stats), plan->root_bytes);
    out->bytes += plan->root_bytes;
    return PEND_OK;
}

static enum pend_status hdf5_finish(struct api_writer *base, struct api_buffer *out, int *done) {
    struct hdf5_writer *writer = (struct hdf5_writer *)base;
    if (writer->held) return piece_end(writer, out);
    if (writer->plan.divided && writer->array < writer->plan.arrays.count)
        return trees_go_on(writer, out);
    PEND_TRY(heads_add(writer, out));
    PEND_TRY(root_add(writer, out));
    *done = 1;
    return PEND_OK;
}

const struct api_format api_format_hdf5 = {
    .media_type = "application/x-hdf5",
    .extension = "h5",
    .samples_only = 1,
    .exact = 1,
    .binary = 1,
    .counted = 1,
    .writer_bytes = sizeof(struct hdf5_writer),
    .bytes = hdf5_bytes,
    .begin = hdf5_begin,
    .block = hdf5_block,
    .finish = hdf5_finish,
};
