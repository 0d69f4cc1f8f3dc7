/* The form in which the parts of a job are stored: writing it and reading it back.
 * Leaves to others: whole parts and whole answers (part, results).
 * Invariant: reading ends with rows or with a refusal, whatever the bytes are. */
#ifndef API_ENCODE_RAW_H
#define API_ENCODE_RAW_H

#include "api/encode/encode.h"

enum { API_RAW_HEAD = 8, API_RAW_TEXT = 256 };

/* A record begins with its kind and the number of bytes that follow, 4 bytes each, little-endian.
 */
enum api_raw {
    API_RAW_ROWS = 1, /* rows of doubles, little-endian, all columns of a row together */
    API_RAW_STATS,    /* figures about the computation */
    API_RAW_JSON      /* a piece of the JSON answer, if that says more than the table */
};

/* A representation for the store only: clients cannot choose it. */
extern const struct api_format api_format_raw;

/** Writes a record's head, API_RAW_HEAD bytes. */
void api_raw_head_put(char *at, enum api_raw kind, size_t bytes);

/** Reads a record's head, API_RAW_HEAD bytes. Returns 0 if the bytes are not one. */
int api_raw_head(const char *data, enum api_raw *kind, size_t *bytes);

/**
 * Reads a record of rows into columns, each of which is large enough for them.
 *
 * Returns the number of rows, -1 if the bytes are not a whole number of rows.
 */
long api_raw_rows(const struct api_table *table, const char *data, size_t bytes,
                  double *const column[]);

/* One figure about a computation. */
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

/** Adds a record of figures to those of other parts: numbers are summed, and of warnings with the
 * same name the last is kept. Returns 0 if the bytes are no such record. */
int api_raw_add(struct api_raw_figures *figures, const char *data, size_t bytes);

/** Converts the figures for a writer; the texts of `stats` are those of `figures`. */
void api_raw_stats(const struct api_raw_figures *figures, struct api_stats *stats);

#endif
