#include "api/encode/encode_arrays.h"

#include <assert.h>
#include <string.h>

static int part_is(const struct api_column *column, const char *part) {
    return column->part && !strcmp(column->part, part);
}

void api_arrays_init(struct api_arrays *arrays, const struct api_table *table) {
    arrays->count = 0;
    for (int c = 0; c < table->count; c++) {
        const struct api_column *column = &table->column[c];
        struct api_array *array = &arrays->array[arrays->count++];
        *array =
            (struct api_array){column->name, column->part, column->width, column->inner, c, -1};
        if (!part_is(column, "re") || c + 1 == table->count || !part_is(column + 1, "im")) continue;
        assert(column->width == column[1].width);
        array->part = NULL;
        array->im = ++c;
    }
}
