/* Tables of samples: the list of representations, and the writer that passes rows to one of them
 * block by block.
 * Leaves to others: choosing the representation (negotiate), the meaning of the columns (op_*).
 * Invariant: text contains no NaN or Infinity; a table's bytes do not depend on how its rows are
 * divided into blocks. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "api/base/buffer.h"

enum { API_COLUMNS = 48 };

/* One column of a table. Adjacent columns with the same name form one array: z has re and im. */
struct api_column {
    const char *name; /* "phi" */
    const char *part; /* "re"; NULL if the array has one column */
    int width;        /* numbers per row, one for each arm; 0 = one number per row ("t") */
    int inner;  /* length of the second axis: the array is rows x (width / inner) x inner; 0 = no
                   second axis */
    int sparse; /* non-zero: values may be missing: NaN here, null or an empty field in text */
};

/* The picture of a grid of members: each pixel shows one number of a column. */
struct api_table_picture {
    long across;     /* pixels per line; 0 = the table has no picture */
    int column, arm; /* the column and the arm whose number is shown */
    int logarithmic; /* non-zero: the colour scale is logarithmic */
};

/* The columns and rows of an answer. */
struct api_table {
    int count;
    struct api_column column[API_COLUMNS];
    long rows;      /* number of rows; an upper bound if rows_later is set */
    int rows_later; /* whether the number of rows is known only at the end */
    int single;     /* whether there is one row, and the answer's arrays have no axis for rows */
    int digits;  /* significant digits; 0 = the shortest text that reads back to the same double */
    int float32; /* whether binary representations that support it write 4-byte floats */
    struct api_table_picture picture;
};

/* A statistic of the computation, written after the rows. Its strings must outlive the writer. */
struct api_stat {
    const char *name;
    enum { API_STAT_TEXT, API_STAT_WHOLE, API_STAT_NUMBER, API_STAT_WARNING } kind;
    const char *text;
    long whole;
    double number;
};

enum {
    API_STATS = 17,
    API_WARNING_TEXT = 240,
    API_WARNINGS = 4,
    API_WARNINGS_BYTES = API_WARNINGS * API_WARNING_TEXT
};

struct api_stats {
    int count;
    struct api_stat stat[API_STATS];
};

/* Approximate bytes that a representation writes per call. */
enum { API_PIECE_BYTES = 1 << 16 };

/* Most bytes of rows that a multi-pass representation keeps. Must stay below a quarter of the
 * default memory quota of a client. */
#define API_TURN_BYTES (UINT64_C(1) << 27)

struct api_writer;

/*
 * A representation. Its own writer struct, if any, begins with struct api_writer.
 *
 * A representation with a `block` function streams: it writes each block of rows at once, keeps
 * nothing, and its answers have no size limit. For the others the writer keeps all rows, column by
 * column, and `finish` writes the answer at the end. A representation with a `turn` function can
 * instead read the rows in several passes and keep only some columns in each pass.
 */
struct api_format {
    const char *media_type;   /* media type in Accept */
    const char *content_type; /* value of Content-Type; NULL = media_type */
    const char *extension;    /* extension of a saved file; NULL if a browser should show it */
    int samples_only;         /* 1: for tables of samples only; 2: for tables with a picture only */
    int picture;              /* whether the format is a picture (table->picture) */
    int digits;               /* whether the format is text that honours the table's `digits` */
    int exact;                /* whether `bytes` is the exact length of the answer */
    int binary;               /* whether the format supports the table's `float32` */
    int counted;         /* whether the number of rows comes before the rows; with rows_later the
                          * writer then stores the rows */
    int bare;            /* whether column names are in the X-Columns header, not in the body */
    int problem_line;    /* whether a failed answer ends with a line {"problem": {...}} */
    double most_bytes;   /* size limit of an answer; 0 = none */
    size_t writer_bytes; /* size of its struct that begins with struct api_writer */

    /** Returns an upper bound of the bytes of a table's answer. */
    double (*bytes)(const struct api_table *table);
    /** Writes the bytes before the rows. NULL if there are none. */
    enum pend_status (*begin)(struct api_writer *writer, struct api_buffer *out);
    /** Writes rows; data[c] has width (or 1) finite numbers per row of column c. NULL if the
     * representation does not stream. */
    enum pend_status (*block)(struct api_writer *writer, long rows, const double *const data[],
                              struct api_buffer *out);
    /** As block, in one of several passes: writes or stores the columns of the current pass. NULL
     * if one pass suffices. */
    enum pend_status (*turn)(struct api_writer *writer, long rows, const double *const data[],
                             struct api_buffer *out);
    /** Writes the next piece of the bytes after the rows. A representation that does not stream
     * writes the whole answer here, from writer->column and stats. Sets *done after the last
     * piece. NULL if there are no such bytes. */
    enum pend_status (*finish)(struct api_writer *writer, struct api_buffer *out, int *done);
};

struct api_writer {
    const struct api_format *format;
    struct api_table table;
    long rows;                     /* number of rows written or stored so far */
    double *kept;                  /* memory of the stored columns; NULL if there are none */
    double *column[API_COLUMNS];   /* the stored columns, pointers into `kept` */
    double most;                   /* API_TURN_BYTES, or less in tests */
    int turns;                     /* whether the rows are passed again while `again` is set */
    int again;                     /* whether another pass follows this one */
    long sent;                     /* in a representation that streams: number of stored rows
                                    * already written; -1 = `begin` not yet called */
    const struct api_stats *stats; /* set once all rows are written or stored; NULL = none */
};

extern const struct api_format api_format_json, api_format_ndjson, api_format_csv,
    api_format_octets, api_format_npz, api_format_parquet, api_format_hdf5, api_format_mat,
    api_format_png;

enum { API_FORMATS_TEXT = 240 };

/**
 * Writes the media types of the representations, separated by commas.
 *
 * samples  as in struct api_op: 0, 1 for a table of samples, 2 for one with a picture.
 * streams  non-zero: only representations that stream.
 */
void api_format_list(char text[API_FORMATS_TEXT], int samples, int streams);

/** Returns representation i of the list, or NULL beyond its end. The first is the default. */
const struct api_format *api_format_at(int i);

enum { API_COLUMNS_TEXT = 1600 };

/** Writes the value of the header field X-Columns, "t,phi[4],z_re[4],z_im[4]": the numbers per row
 * are in brackets unless there is one; a column with two axes has both, "[4,2]". */
void api_table_columns(const struct api_table *table, char text[API_COLUMNS_TEXT]);

struct api_number_rows;

/** Returns non-zero if any of `count` values of a column is missing. O(count). */
int api_column_lacks(const struct api_column *column, long count, const double value[]);

/** As api_number_write_rows, for a column that may be sparse: writes `none` for missing values. */
char *api_column_write(char *out, const struct api_column *column,
                       const struct api_number_rows *rows, const char *none);

/** Writes a row of a column as JSON without the enclosing brackets: comma-separated numbers, in
 * brackets for each group of the second axis. */
char *api_column_write_row(char *out, const struct api_column *column, const double value[],
                           int digits);

/** Returns an upper bound of the brackets and commas around the groups of a row's second axis.
 * O(1). */
static inline size_t api_column_brackets(const struct api_column *column) {
    return column->inner ? (size_t)(3 * (column->width / column->inner)) : 0;
}

/** Returns non-zero if the format writes the rows of this table immediately and stores none.
 * O(1). */
int api_format_streams(const struct api_format *format, const struct api_table *table);

/** Adds a column. The caller adds at most API_COLUMNS in all. */
void api_table_add(struct api_table *table, const char *name, const char *part, int width);

/** Adds a column of arms x inner numbers per row, or of `inner` numbers if `arms` is 0. */
void api_table_add_inner(struct api_table *table, const char *name, const char *part, int arms,
                         int inner);

/** Returns the numbers per row of a column. */
static inline long api_column_numbers(const struct api_column *column) {
    return column->width ? column->width : 1;
}

/** Returns the numbers per row of all columns from `first` on. */
double api_table_numbers(const struct api_table *table, int first);

/** Adds a text. A table has at most API_STATS statistics. */
void api_stats_text(struct api_stats *stats, const char *name, const char *text);

/** Adds a whole number. */
void api_stats_whole(struct api_stats *stats, const char *name, long value);

/** Adds a finite number. */
void api_stats_number(struct api_stats *stats, const char *name, double value);

/** Adds the version and the engine that computed the answer. */
void api_stats_origin(struct api_stats *stats);

/** Returns the number of warnings. */
int api_stats_warnings(const struct api_stats *stats);

/** Adds a warning: fewer than API_WARNING_TEXT ASCII characters without comma, quote or backslash.
 * It replaces an earlier warning of the same name. */
void api_stats_warning(struct api_stats *stats, const char *name, const char *text);

/**
 * Starts the answer to a table and writes the bytes before its rows.
 *
 * writer  out; NULL on failure; released by api_writer_free.
 * table   copied; its names must outlive the writer.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_new(struct api_writer **writer,
                                                const struct api_format *format,
                                                const struct api_table *table,
                                                struct api_buffer *out);
void api_writer_free(struct api_writer **writer);
int api_writer_valid(const struct api_writer *writer);

/** Returns non-zero if a writer of this table reads its rows in several passes, so that it stores
 * at most API_TURN_BYTES. O(columns). */
int api_format_turns(const struct api_format *format, const struct api_table *table);

/** As api_writer_new, for a caller that can pass the rows again. After each api_writer_finish that
 * leaves writer->again set and *done unset, the caller calls api_writer_again and passes all rows
 * again. */
PEND_MUST_CHECK enum pend_status api_writer_new_turns(struct api_writer **writer,
                                                      const struct api_format *format,
                                                      const struct api_table *table,
                                                      struct api_buffer *out);

/** Starts another pass, in which all rows are passed again. */
void api_writer_again(struct api_writer *writer);

/** Returns an upper bound of the memory, in bytes, of a writer of this table with its stored rows.
 * O(columns). */
double api_writer_bytes(const struct api_format *format, const struct api_table *table);

/**
 * Writes or stores rows, at most as many as the table has.
 *
 * data   one array for each column, width (or 1) numbers per row.
 * error  on failure names the column, the arm, and the time (the row if the first column is not t).
 *
 * PEND_NOT_FINITE  a number is NaN, infinite or, with float32, too large for a 4-byte float;
 *                  nothing was written.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_block(struct api_writer *writer, long rows,
                                                  const double *const data[],
                                                  struct api_buffer *out, struct pend_error *error);

/** As api_writer_block, for numbers that are known to be finite. With float32 a number that is too
 * large for a 4-byte float is still an error. */
PEND_MUST_CHECK enum pend_status api_writer_finite_block(struct api_writer *writer, long rows,
                                                         const double *const data[],
                                                         struct api_buffer *out);

/**
 * Writes the next piece after the rows, once all rows were passed: at most about API_PIECE_BYTES
 * and one row.
 *
 * stats  written by representations that can contain them; NULL = none. The same in every call.
 * done   set non-zero once the answer is complete.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_finish(struct api_writer *writer,
                                                   const struct api_stats *stats,
                                                   struct api_buffer *out, int *done);
