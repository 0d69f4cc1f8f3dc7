/* The storage format of a job's parts: writing and reading.
 * Leaves to others: whole parts and whole answers (part, results).
 * Invariant: reading arbitrary bytes returns rows or an error. */
#pragma once

#include "api/encode/encode.h"

enum { API_RAW_HEAD = 8, API_RAW_TEXT = 256 };

/* A record begins with its kind and the length of its body, 4 bytes each, little-endian. */
enum api_raw {
    API_RAW_ROWS = 1, /* little-endian doubles in row-major order */
    API_RAW_STATS,    /* statistics of the computation */
    API_RAW_JSON,     /* a piece of the JSON answer, if it contains more than the table */
    API_RAW_FILE      /* a Parquet file that replaces the part's rows; results cannot read it */
};

/* The contents of a record API_RAW_FILE. */
struct api_raw_file {
    long rows, width; /* width: doubles of a row */
    size_t bytes;
    char digest[65]; /* SHA-256 of the file, as hexadecimal digits */
};

enum { API_RAW_FILE_BYTES = API_RAW_HEAD + 3 * 8 + 64 };

/** Writes a whole record that stands for a file, API_RAW_FILE_BYTES. */
void api_raw_file_put(char *at, const struct api_raw_file *file);

/** Reads the record at the beginning of a part's results. Returns 0 if there is none, or one of
 * another kind. */
int api_raw_file_get(const char *data, size_t bytes, struct api_raw_file *file);

/** Appends the rows of a Parquet file of doubles, written by this program, as records. O(bytes).
 * PEND_BUG: this is not such a file; PEND_NO_MEMORY, PEND_LIMIT */
PEND_MUST_CHECK enum pend_status
api_raw_from_parquet(const char *data, const struct api_raw_file *file, struct api_buffer *out);

/* A representation for storage; clients cannot request it. */
extern const struct api_format api_format_raw;

/** Writes the head of a record, API_RAW_HEAD bytes. */
void api_raw_head_put(char *at, enum api_raw kind, size_t bytes);

/** Reads the head of a record, API_RAW_HEAD bytes. Returns 0 if it is invalid. */
int api_raw_head(const char *data, enum api_raw *kind, size_t *bytes);

/**
 * Reads a record of rows into columns, which must be large enough.
 *
 * Returns the number of rows; -1 if `bytes` is no multiple of a row's size.
 */
long api_raw_rows(const struct api_table *table, const char *data, size_t bytes,
                  double *const column[]);

/* One statistic of a computation. */
struct api_raw_figure {
    int kind; /* API_STAT_TEXT, API_STAT_WHOLE, ... */
    long whole;
    double number;
    char name[API_RAW_TEXT], text[API_RAW_TEXT];
};

struct api_raw_figures {
    int count;
    struct api_raw_figure figure[API_STATS];
};

/** Adds a record of statistics to those of other parts: numbers are summed, and the last warning of
 * each name is kept. Returns 0 if the record is invalid. */
int api_raw_add(struct api_raw_figures *figures, const char *data, size_t bytes);

/** Converts the statistics for a writer. `stats` points into `figures`. */
void api_raw_stats(const struct api_raw_figures *figures, struct api_stats *stats);
