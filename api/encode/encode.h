/* Encoding tables of samples: the table of representations, and the writer that passes rows to one
 * of them block by block.
 * Leaves to others: which representation a client wants (negotiate), the meaning of the columns
 * (op_*).
 * Invariant: no answer contains NaN or Infinity; a table's bytes do not depend on how its rows
 * were divided into blocks. */
#ifndef API_ENCODE_H
#define API_ENCODE_H

#include <stddef.h>
#include <stdint.h>

#include "api/base/buffer.h"

enum { API_COLUMNS = 48 };

/* One array of a table. Columns of the same name are its parts and are adjacent: z is re and im. */
struct api_column {
    const char *name; /* "phi" */
    const char *part; /* "re", or NULL if the name has one array only */
    int width;  /* numbers a row, one for each arm; 0 = one number for the row as a whole ("t") */
    int inner;  /* numbers of a second axis, so that there are width / inner arms; 0 = there is none
                 */
    int sparse; /* enum api_sparse */
};

/* What a column may lack, which representations of text write as "none". */
enum api_sparse {
    API_SPARSE_TIMES = 1, /* times: a number below 0, which binary representations keep or turn into
                             NaN, as the table's `nan` says */
    API_SPARSE_GAPS       /* numbers: NaN, in binary representations too */
};

/* The picture of a grid of members: each pixel shows one number of a column. */
struct api_table_picture {
    long across;     /* pixels of a line; 0 = no picture */
    int column, arm; /* which number */
    int logarithmic;
};

/* The columns and rows of an answer. */
struct api_table {
    int count;
    struct api_column column[API_COLUMNS];
    long rows;      /* how many there will be */
    int rows_later; /* rows are known only at the end; before, they are the most that there can be
                     */
    int single;     /* there is one row, and the answer's arrays have no axis for rows */
    int digits;     /* significant digits of a number, 0 = the shortest text that reads back */
    int float32;    /* numbers of binary representations that can are floats of 4 bytes */
    int nan;        /* what a sparse column has not is NaN in binary representations that can */
    struct api_table_picture picture;
};

/* A figure about the computation, written behind the rows; the texts outlive the writer. */
struct api_stat {
    const char *name;
    enum { API_STAT_TEXT, API_STAT_WHOLE, API_STAT_NUMBER, API_STAT_WARNING } kind;
    const char *text;
    long whole;
    double number;
};

enum {
    API_STATS = 16,
    API_WARNING_TEXT = 240,
    API_WARNINGS = 4,
    API_WARNINGS_BYTES = API_WARNINGS * API_WARNING_TEXT
};

struct api_stats {
    int count;
    struct api_stat stat[API_STATS];
};

/* About how many bytes a representation writes at a time. */
enum { API_PIECE_BYTES = 1 << 16 };

/* The most bytes of rows that are kept of a table whose rows can be passed again, by a
 * representation with turns. A quarter of a client's memory by default is above it. */
#define API_TURN_BYTES (UINT64_C(1) << 27)

struct api_writer;

/*
 * A representation. Its own writer struct, if any, begins with struct api_writer.
 *
 * A representation with a `block` function streams: it writes each block of rows at once, keeps
 * nothing, and its answers have no limit of size. For the others the writer keeps all rows, column
 * by column, and `finish` writes the answer in the end. One of these with a `turn` function can do
 * without: it takes the rows as often as it says, and keeps some of their columns at a time.
 */
struct api_format {
    const char *media_type;   /* as Accept names it */
    const char *content_type; /* as the answer says it; NULL = the same */
    const char *extension; /* of a saved file; NULL if a browser should show the answer instead */
    int samples_only;      /* 1: only for tables of samples; 2: only for tables with a picture */
    int picture;           /* draws the table's picture */
    int digits;            /* is text, so that numbers can be rounded */
    int exact;             /* `bytes` is the exact length of the answer */
    int binary;            /* takes the table's float32 and nan */
    int counted;           /* writes how many rows there are before the rows: those of a table whose
                              rows are known later are kept */
    int bare;              /* the answer does not name its columns: a header field does */
    int problem_line;      /* a broken answer ends with a line {"problem": {...}} */
    double most_bytes;     /* the most bytes of an answer, if the format has a limit; else 0 */
    size_t writer_bytes;   /* size of its writer struct */

    /** Returns an upper bound of the bytes of a table's answer. */
    double (*bytes)(const struct api_table *table);
    /** Writes the bytes before the rows; NULL if there are none. */
    enum pend_status (*begin)(struct api_writer *writer, struct api_buffer *out);
    /** Writes rows; data[c] has width (or 1) numbers a row of column c, all finite. NULL: the
     * representation does not stream. */
    enum pend_status (*block)(struct api_writer *writer, long rows, const double *const data[],
                              struct api_buffer *out);
    /** As block, of a writer with turns: writes or keeps what the turn at hand has of the rows.
     * NULL: there are no turns. */
    enum pend_status (*turn)(struct api_writer *writer, long rows, const double *const data[],
                             struct api_buffer *out);
    /** Writes the next piece of the bytes behind the rows, or, if the representation does not
     * stream, of the whole answer from writer->column and stats; sets *done after the last piece.
     * NULL: there are no such bytes. */
    enum pend_status (*finish)(struct api_writer *writer, struct api_buffer *out, int *done);
};

struct api_writer {
    const struct api_format *format;
    struct api_table table;
    long rows;                     /* written or kept so far */
    double *kept;                  /* memory of the columns that are kept; NULL if none is */
    double *column[API_COLUMNS];   /* these columns, within it */
    double most;                   /* API_TURN_BYTES, or less in tests */
    int turns;                     /* the rows are passed again for as long as it says */
    int again;                     /* at this turn's end: another one follows */
    long sent;                     /* rows kept by one that can stream that are written; -1 = not
                                      even what is before them */
    const struct api_stats *stats; /* once all rows were written or kept; NULL = none */
};

extern const struct api_format api_format_json, api_format_ndjson, api_format_csv,
    api_format_octets, api_format_npz, api_format_parquet, api_format_hdf5, api_format_mat,
    api_format_png;

enum { API_FORMATS_TEXT = 240 };

/**
 * Writes the media types of the representations, separated by commas.
 *
 * samples  of struct api_op: 0, 1 for a table of samples, 2 for one with a picture.
 * streams  non-zero: only representations that stream.
 */
void api_format_list(char text[API_FORMATS_TEXT], int samples, int streams);

/** Returns row i of the table of representations, NULL beyond its end; the first is the default. */
const struct api_format *api_format_at(int i);

enum { API_COLUMNS_TEXT = 1600 };

/**
 * Writes the columns as the field X-Columns lists them: "t,phi[4],z_re[4],z_im[4]", with the
 * numbers a row in brackets unless it is one; of a column with two axes both: "[4,2]".
 */
void api_table_columns(const struct api_table *table, char text[API_COLUMNS_TEXT]);

struct api_number_rows;

/** Returns non-zero if `count` numbers of a column may lack some. O(count). */
int api_column_lacks(const struct api_column *column, long count, const double value[]);

/** As api_number_write_rows, but of a column that may be sparse: writes `none` for what it has not.
 */
char *api_column_write(char *out, const struct api_column *column,
                       const struct api_number_rows *rows, const char *none);

/** Writes a row of a column as JSON does, without the brackets around it: numbers with commas
 * between them, each group of a second axis in brackets. */
char *api_column_write_row(char *out, const struct api_column *column, const double value[],
                           int digits);

/** Returns the bytes of the brackets and commas of the groups of a row's second axis. O(1). */
static inline size_t api_column_brackets(const struct api_column *column) {
    return column->inner ? (size_t)(3 * (column->width / column->inner)) : 0;
}

/** Non-zero if rows of the table are written as they come, and none is kept. O(1). */
int api_format_streams(const struct api_format *format, const struct api_table *table);

/** Adds a column; the caller adds at most API_COLUMNS. */
void api_table_add(struct api_table *table, const char *name, const char *part, int width);

/** Adds a column of `arms` times `inner` numbers a row; no arms: `inner` numbers. */
void api_table_add_inner(struct api_table *table, const char *name, const char *part, int arms,
                         int inner);

/** Returns how many numbers a column has in one row. */
static inline long api_column_numbers(const struct api_column *column) {
    return column->width ? column->width : 1;
}

/** Returns how many numbers the columns from `first` on have in one row. */
double api_table_numbers(const struct api_table *table, int first);

/** Adds a text; at most API_STATS figures fit. */
void api_stats_text(struct api_stats *stats, const char *name, const char *text);

/** Adds a whole number. */
void api_stats_whole(struct api_stats *stats, const char *name, long value);

/** Adds a finite number. */
void api_stats_number(struct api_stats *stats, const char *name, double value);

/** Adds the version and the engine that have computed the answer. */
void api_stats_origin(struct api_stats *stats);

/** Returns how many warnings there are. */
int api_stats_warnings(const struct api_stats *stats);

/** Adds a warning: fewer than API_WARNING_TEXT letters of ASCII without comma, quote or backslash.
 * A later one of the same name replaces it. */
void api_stats_warning(struct api_stats *stats, const char *name, const char *text);

/**
 * Starts the answer to a table and writes the bytes before its rows.
 *
 * writer  out; NULL on failure; ends with api_writer_free.
 * table   copied; its names must outlive the writer.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_new(struct api_writer **writer,
                                                const struct api_format *format,
                                                const struct api_table *table,
                                                struct api_buffer *out);

/** Non-zero if a writer of such a table, whose rows can be passed again, has turns: it keeps
 * API_TURN_BYTES and no more. O(columns). */
int api_format_turns(const struct api_format *format, const struct api_table *table);

/** As api_writer_new, where the rows can be passed again: after each api_writer_finish that is not
 * done and leaves writer->again set, all of them are, behind api_writer_again. */
PEND_MUST_CHECK enum pend_status api_writer_new_turns(struct api_writer **writer,
                                                      const struct api_format *format,
                                                      const struct api_table *table,
                                                      struct api_buffer *out);

/** Begins another turn: all rows follow once more. */
void api_writer_again(struct api_writer *writer);

/** Frees a writer and the rows that it keeps; nothing happens if it is NULL. */
void api_writer_free(struct api_writer **writer);

/** True if the rows are within the table, and kept exactly if the format neither streams nor has
 * turns; for assertions. O(1). */
int api_writer_valid(const struct api_writer *writer);

/** Returns the most bytes of memory of a writer of such a table, rows that are kept included.
 * O(columns). */
double api_writer_bytes(const struct api_format *format, const struct api_table *table);

/**
 * Writes rows or keeps them, at most as many as the table has.
 *
 * data   one array for each column, width (or 1) numbers a row.
 * error  on failure names the column, the arm, and the time if the first column is t, else the row.
 *
 * PEND_NOT_FINITE  a number is NaN or infinite, or beyond floats of 4 bytes where these are
 *                  wanted; nothing was written.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_block(struct api_writer *writer, long rows,
                                                  const double *const data[],
                                                  struct api_buffer *out, struct pend_error *error);

/** As api_writer_block, for numbers that are known to be finite; floats of 4 bytes may be too
 * small for them. */
PEND_MUST_CHECK enum pend_status api_writer_finite_block(struct api_writer *writer, long rows,
                                                         const double *const data[],
                                                         struct api_buffer *out);

/**
 * Writes the next piece behind the rows, once all were passed to the writer: at most about
 * API_PIECE_BYTES and one row.
 *
 * stats  written by representations that have a place for them; NULL = none. The same at every
 *        call.
 * done   set non-zero once the answer is complete.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_finish(struct api_writer *writer,
                                                   const struct api_stats *stats,
                                                   struct api_buffer *out, int *done);

#endif
