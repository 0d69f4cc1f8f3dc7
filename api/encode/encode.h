/* Tables of samples as bytes: the table of representations, and the writer that feeds one of
 * them block by block.
 * Leaves to others: which representation a client wants (negotiate), what the columns hold
 * (op_*).
 * Invariant: no answer contains NaN or Infinity; a table's bytes do not depend on how its rows
 * were cut into blocks. */
#ifndef API_ENCODE_H
#define API_ENCODE_H

#include "api/base/buffer.h"

enum { API_COLUMNS = 24 };

/* One array of a table. Columns that share a name are its parts and stand next to each other: z
 * is re and im. */
struct api_column {
    const char *name; /* "phi" */
    const char *part; /* "re", or NULL where the name has one array only */
    int width; /* numbers a row: one an arm; 0 = one number that belongs to the row as a whole ("t")
                */
    int sparse; /* a number below 0 stands for none: text says so, what holds nothing but doubles
                   has it as it is */
};

/* What is drawn of a grid's members: one number of a column a pixel. */
struct api_table_picture {
    long across;     /* pixels of a line; 0 = no picture */
    int column, arm; /* which number */
    int logarithmic;
};

/* What an answer's rows hold. */
struct api_table {
    int count;
    struct api_column column[API_COLUMNS];
    long rows;  /* how many will come */
    int single; /* one row, and the answer's arrays are that row's, not one a row */
    int digits; /* significant digits that numbers are rounded to, 0 = the shortest that read back
                 */
    struct api_table_picture picture;
};

/* What is told of the computation behind the rows; the texts outlive the writer. */
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

/* What a representation writes at a time, about. */
enum { API_PIECE_BYTES = 1 << 16 };

struct api_writer;

/*
 * A representation. A writer of its own begins with struct api_writer.
 *
 * It flows where it writes each block of rows when it comes: nothing is kept, and the answer has no
 * limit of size. Others have their rows kept, column by column, and write all in the end.
 */
struct api_format {
    const char *media_type;   /* as Accept names it */
    const char *content_type; /* as the answer says it */
    const char
        *extension;    /* of a file that holds such an answer; NULL where it is rather looked at */
    int samples_only;  /* 1: serves tables of samples and nothing else; 2: only those that can be
                          drawn */
    int picture;       /* draws the table's picture */
    int digits;        /* text, so that numbers can be rounded */
    int exact;         /* `bytes` is what the answer has */
    int bare;          /* the answer does not say its columns: they go into a header field */
    int problem_line;  /* a broken answer ends with a line {"problem": {...}} */
    double most_bytes; /* of an answer, where the representation itself has a limit; else 0 */
    size_t writer_bytes;

    /** A number of bytes that the table's answer will not pass. */
    double (*bytes)(const struct api_table *table);
    /** What comes before the rows; NULL where nothing does. */
    enum pend_status (*begin)(struct api_writer *writer, struct api_buffer *out);
    /** rows rows; data[c] holds width (or 1) numbers a row of column c, all finite. NULL: it does
     * not flow. */
    enum pend_status (*block)(struct api_writer *writer, long rows, const double *const data[],
                              struct api_buffer *out);
    /** Writes the next piece of what comes behind the rows that were written, or, where it does
     * not flow, of the whole answer from writer->column and stats; sets *done after the last.
     * NULL: nothing comes. */
    enum pend_status (*finish)(struct api_writer *writer, struct api_buffer *out, int *done);
};

struct api_writer {
    const struct api_format *format;
    struct api_table table;
    long rows;                   /* written or kept so far */
    double *column[API_COLUMNS]; /* the rows that are kept, one block; NULL where the representation
                                    flows */
    const struct api_stats *stats; /* once all rows are there; NULL = none */
};

extern const struct api_format api_format_json, api_format_ndjson, api_format_csv,
    api_format_octets, api_format_npz, api_format_mat, api_format_png;

enum { API_FORMATS_TEXT = 160 };

/**
 * The media types of the representations, separated by commas.
 *
 * samples  as of the operation: 0, 1 where the answer is a table of samples, 2 where it may be
 *          drawn.
 * flows    non-zero: only those that flow.
 */
void api_format_list(char text[API_FORMATS_TEXT], int samples, int flows);

/** Row i of the table of representations, or NULL beyond its end; the first is the default. */
const struct api_format *api_format_at(int i);

enum { API_COLUMNS_TEXT = 400 };

/**
 * The columns as X-Columns names them: "t,phi[4],z_re[4],z_im[4]", each as often as the bracket
 * says, else once.
 */
void api_table_columns(const struct api_table *table, char text[API_COLUMNS_TEXT]);

struct api_number_rows;

/** As api_number_write_rows, of a column that may be sparse: where there is no number `none` is
 * written. */
char *api_column_write(char *out, const struct api_column *column,
                       const struct api_number_rows *rows, const char *none);

/** Adds a column; at most API_COLUMNS fit, which the caller knows. */
void api_table_add(struct api_table *table, const char *name, const char *part, int width);

/** Numbers that a column has in one row. */
static inline long api_column_numbers(const struct api_column *column) {
    return column->width ? column->width : 1;
}

/** Numbers that the columns from `first` on have in one row. */
double api_table_numbers(const struct api_table *table, int first);

void api_stats_text(struct api_stats *stats, const char *name, const char *text);
void api_stats_whole(struct api_stats *stats, const char *name, long value);
void api_stats_number(struct api_stats *stats, const char *name, double value);
/** Which version and engine have computed it. */
void api_stats_origin(struct api_stats *stats);
/** Warnings among them. */
int api_stats_warnings(const struct api_stats *stats);
/** A warning, in words: fewer than API_WARNING_TEXT letters of ASCII without comma, quote or
 * backslash. Of one name there is one. */
void api_stats_warning(struct api_stats *stats, const char *name, const char *text);

/**
 * Starts a table and writes what comes before its rows.
 *
 * writer  out; NULL on failure.
 * table   copied; its names must outlive the writer.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_new(struct api_writer **writer,
                                                const struct api_format *format,
                                                const struct api_table *table,
                                                struct api_buffer *out);

void api_writer_free(struct api_writer **writer);

/** Bytes of memory that a writer of such a table takes at most, rows that are kept included.
 * O(columns). */
double api_writer_bytes(const struct api_format *format, const struct api_table *table);

/**
 * Writes rows, or keeps them; no more than the table was said to have.
 *
 * data   one array a column, width (or 1) numbers a row.
 * error  on failure says which column and arm, and the time where the first column is t, else the
 *        row.
 *
 * PEND_NOT_FINITE  a number is NaN or infinite; nothing was written.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_block(struct api_writer *writer, long rows,
                                                  const double *const data[],
                                                  struct api_buffer *out, struct pend_error *error);

/** The same of numbers that were all looked at already: they are finite. */
PEND_MUST_CHECK enum pend_status api_writer_finite_block(struct api_writer *writer, long rows,
                                                         const double *const data[],
                                                         struct api_buffer *out);

/**
 * Writes the next piece of what comes once all rows are there, at most about API_PIECE_BYTES and
 * one row.
 *
 * stats  in representations that have a place for them; NULL where there are none. The same at
 *        every call.
 * done   set non-zero once the answer is complete.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_writer_finish(struct api_writer *writer,
                                                   const struct api_stats *stats,
                                                   struct api_buffer *out, int *done);

#endif
