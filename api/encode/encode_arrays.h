/* Grouping a table's columns into the named arrays of a file: re and im become one complex array.
 * Leaves to others: the files (encode_npz, encode_mat).
 * Invariant: every column belongs to exactly one array, in the order of the columns. */
#ifndef API_ENCODE_ARRAYS_H
#define API_ENCODE_ARRAYS_H

#include "api/encode/encode.h"

/* One array: rows x width numbers, or rows x (width / inner) x inner. */
struct api_array {
    const char *name; /* of its columns */
    const char *part; /* "kinetic", if the name has several arrays; else NULL */
    int width;        /* 0 = one number a row */
    int inner;        /* of a second axis; 0 = there is none */
    int re, im;       /* columns; im is -1 if the array is real */
    int float32; /* its numbers are floats of 4 bytes: not instants and numbers of members, of which
                  * these have too few digits */
};

struct api_arrays {
    int count;
    struct api_array array[API_COLUMNS];
};

/** Returns the array of one column alone. O(1). */
struct api_array api_array_of(const struct api_table *table, int column);

/** Groups the columns of a table. */
void api_arrays_init(struct api_arrays *arrays, const struct api_table *table);

/** Non-zero if the numbers of a column are floats of 4 bytes, as those of its array. O(1). */
int api_column_float32(const struct api_column *column, const struct api_table *table);

/** Returns the numbers of a row, a complex one counted once. O(1). */
static inline size_t api_array_width(const struct api_array *array) {
    return array->width ? (size_t)array->width : 1;
}

/** Returns the bytes of a number, a complex one counted once. O(1). */
size_t api_array_bytes(const struct api_array *array);

/** Returns NumPy's name of the kind of number: "<f8". O(1). */
const char *api_array_type(const struct api_array *array);

/** Writes numbers, little-endian; im: of a complex array. Returns the end. */
char *api_array_write(char *at, const struct api_array *array, size_t count, const double re[],
                      const double im[]);

/** Writes the shape of a row of an array as Python writes what follows the rows: "4" or "4, 2";
 * nothing for one number. Returns the end. */
char *api_array_shape(char *at, const struct api_array *array);

#endif
