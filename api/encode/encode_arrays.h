/* Groups a table's columns into the named arrays of a file, where re and im form one complex array.
 * Leaves to others: the files (encode_npz, encode_mat).
 * Invariant: every column belongs to exactly one array, in column order. */
#pragma once

#include "api/encode/encode.h"

/* One array: rows x width numbers, or rows x (width / inner) x inner. */
struct api_array {
    const char *name; /* name of its columns */
    const char *part; /* part, such as "kinetic", if several arrays have the same name; else NULL */
    int width;        /* 0 = one number per row */
    int inner;        /* length of the second axis; 0 = no second axis */
    int re, im;       /* indices of the columns; im is -1 if the array is real */
    int float32;      /* whether the numbers are stored as 4-byte floats; never for times and member
                       * numbers, which need more digits */
};

struct api_arrays {
    int count;
    struct api_array array[API_COLUMNS];
};

/** Returns the array that consists of one column. O(1). */
struct api_array api_array_of(const struct api_table *table, int column);

/** Groups the columns of a table. */
void api_arrays_init(struct api_arrays *arrays, const struct api_table *table);

/** Returns non-zero if the numbers of a column are written as 4-byte floats. O(1). */
int api_column_float32(const struct api_column *column, const struct api_table *table);

/** Returns the numbers per row, where a complex number counts once. O(1). */
static inline size_t api_array_width(const struct api_array *array) {
    return array->width ? (size_t)array->width : 1;
}

/** Returns the bytes of one element: 4 or 8, twice as many if complex. O(1). */
size_t api_array_bytes(const struct api_array *array);

/** Returns NumPy's name of the element type, such as "<f8". O(1). */
const char *api_array_type(const struct api_array *array);

/** Writes `count` elements, little-endian; `im` only if the array is complex. Returns the end. */
char *api_array_write(char *at, const struct api_array *array, size_t count, const double re[],
                      const double im[]);

/** Writes the shape of one row as in a Python tuple: "4" or "4, 2"; nothing for a scalar. Returns
 * the end. */
char *api_array_shape(char *at, const struct api_array *array);
