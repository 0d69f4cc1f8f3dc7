/* What a job's part is kept as, and how it is read back.
 * Leaves to others: whole parts and whole answers (part, results).
 * Invariant: whatever the bytes are, reading them ends with rows, or with a refusal. */
#ifndef API_ENCODE_RAW_H
#define API_ENCODE_RAW_H

#include "api/encode/encode.h"

enum { API_RAW_HEAD = 8, API_RAW_TEXT = 256 };

/* A record begins with its kind and the bytes that follow, 4 bytes each, little-endian. */
enum api_raw {
    API_RAW_ROWS = 1, /* rows of doubles, little-endian, all columns of a row together */
    API_RAW_STATS,    /* what is told of the computation */
    API_RAW_JSON      /* a piece of the JSON answer, where that says more than the table */
};

/* A representation for our own use; not in the table of those that clients choose from. */
extern const struct api_format api_format_raw;

/** Writes a record's head, API_RAW_HEAD bytes. */
void api_raw_head_put(char *at, enum api_raw kind, size_t bytes);

/** Reads a record's head, API_RAW_HEAD bytes. Returns 0 where it is none. */
int api_raw_head(const char *data, enum api_raw *kind, size_t *bytes);

/**
 * Reads a record of rows into columns, each with room for them.
 *
 * Returns how many, -1 where the bytes are no whole number of rows.
 */
long api_raw_rows(const struct api_table *table, const char *data, size_t bytes,
                  double *const column[]);

/* One thing told of a computation. */
struct api_raw_figure {
    int kind; /* of struct api_stat */
    long whole;
    double number;
    char name[API_RAW_TEXT], text[API_RAW_TEXT];
};

struct api_raw_figures {
    int count;
    struct api_raw_figure figure[API_STATS];
};

/** Adds a record of figures to those of other parts: numbers are summed, of warnings of one name
 * the last is kept. Returns 0 where the bytes are none. */
int api_raw_add(struct api_raw_figures *figures, const char *data, size_t bytes);

/** The figures as a writer wants them; they point into `figures`. */
void api_raw_stats(const struct api_raw_figures *figures, struct api_stats *stats);

#endif
