#include "api/encode/encode_arrays.h"

#include <assert.h>
#include <string.h>

#include "api/base/octets.h"
#include "api/number/number.h"

static int part_is(const struct api_column *column, const char *part) {
    return column->part && !strcmp(column->part, part);
}

int api_column_float32(const struct api_column *column, const struct api_table *table) {
    return table->float32 && strcmp(column->name, "t") != 0 && strcmp(column->name, "member") != 0;
}

struct api_array api_array_of(const struct api_table *table, int column) {
    const struct api_column *own = &table->column[column];
    return (struct api_array){.name = own->name,
                              .part = own->part,
                              .width = own->width,
                              .inner = own->inner,
                              .re = column,
                              .im = -1,
                              .float32 = api_column_float32(own, table)};
}

void api_arrays_init(struct api_arrays *arrays, const struct api_table *table) {
    arrays->count = 0;
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        struct api_array *array = &arrays->array[arrays->count++];
        *array = api_array_of(table, c);
        if (!part_is(column, "re") || c + 1 == table->count || !part_is(column + 1, "im")) continue;
        assert(column->width == column[1].width);
        array->part = NULL;
        array->im = ++c;
    }
}

size_t api_array_bytes(const struct api_array *array) {
    return (array->im < 0 ? 1 : 2) * (array->float32 ? 4u : 8u);
}

const char *api_array_type(const struct api_array *array) {
    static const char *const types[2][2] = {{"<f8", "<c16"}, {"<f4", "<c8"}};
    return types[array->float32][array->im >= 0];
}

char *api_array_write(char *at, const struct api_array *array, size_t count, const double re[],
                      const double im[]) {
    int narrow = array->float32;
    if (!narrow && array->im < 0) return api_octets_doubles(at, count, re);
    for (size_t i = 0; i < count; i++) {
        at = narrow ? api_octets_float(at, re[i]) : api_octets_double(at, re[i]);
        if (array->im >= 0)
            at = narrow ? api_octets_float(at, im[i]) : api_octets_double(at, im[i]);
    }
    return at;
}

char *api_array_shape(char *at, const struct api_array *array) {
    if (!array->width) return at;
    if (array->inner) at = stpcpy(api_number_write_int(at, array->width / array->inner), ", ");
    return api_number_write_int(at, array->inner ? array->inner : array->width);
}
