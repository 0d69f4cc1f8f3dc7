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
};

struct api_arrays {
    int count;
    struct api_array array[API_COLUMNS];
};

/** Groups the columns of a table. */
void api_arrays_init(struct api_arrays *arrays, const struct api_table *table);

#endif
