/* Encodes a job's answer from its stored parts.
 * Leaves to others: the request and the head of the answer (call), fetching the parts in order
 * (server).
 * Invariant: the answer does not depend on how the parts are divided into pieces. */
#pragma once

#include "api/call/digest.h"
#include "api/encode/stats_text.h"

/* The head of an answer; its texts live as long as the call. */
struct api_answer {
    int status;             /* HTTP status */
    const char *media_type; /* a static string */
    const char *columns;    /* value of X-Columns, "t,phi[4],phid[4]"; NULL if the representation
                               names its columns itself */
    const struct api_stats_headers *stat_fields; /* header fields of the statistics once the answer
                                       is complete; NULL before, or if there are none */
    const char *accepts;   /* status 415: accepted media types, a static string; NULL = only JSON */
    int deprecated;        /* the request uses a deprecated name */
    int has_stat_fields;   /* the answer will have such fields; trailers if it is streamed */
    const char *file_name; /* file name for saving; NULL if a browser should display the answer */
    const char *etag;      /* as api_call_etag; NULL for a problem */
    long long length;      /* bytes of the answer's body, -1 if unknown */
    long long first;       /* status 206: offset of the answer's first byte, from 0 */
    long long total;       /* for status 206 and 416: bytes of the whole */
};

struct api_results;

/* Access to the stored parts of a job (part). */
struct api_source {
    /**
     * Fetches the next bytes of the parts, in their order.
     *
     * data   out, space for `cap` bytes.
     * bytes  out; 0 = end.
     *
     * Any other status than PEND_OK ends the answer; error->text says why.
     */
    enum pend_status (*fetch)(void *context, void *data, size_t cap, size_t *bytes,
                              struct pend_error *error);
    /** Restarts fetch at the first part. */
    void (*again)(void *context);
    void *context;
    /** Returns non-zero if fetch will not wait; NULL = fetch may wait. */
    int (*ready)(void *context);
    int partial; /* the answer may be partial: fetch may end before the last part */
};

/** Adapts the head of an answer to a source: status 202 if the source may lack parts. */
void api_results_head(const struct api_source *source, struct api_answer *answer);

/** Returns an upper bound of the memory of an answer's kept rows, as api_writer_bytes does. */
double api_results_bytes(const struct api_source *source, const struct api_format *format,
                         const struct api_table *table);

/**
 * Begins an answer.
 *
 * results  out; NULL on failure.
 * apart    non-zero: the parts contain JSON records, because JSON contains more than the table.
 * later    non-zero: the table's number of rows is an upper bound; a record of statistics marks the
 *          end.
 * source   its `again` and `partial` decide what is written.
 * out      the bytes before the rows are appended.
 *
 * PEND_INVALID  the representation cannot hold partial results: a picture, or JSON beyond the
 *               table.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_results_new(struct api_results **results,
                                                 const struct api_format *format,
                                                 const struct api_table *table, int apart,
                                                 int later, const struct api_source *source,
                                                 struct api_buffer *out, struct pend_error *error);
void api_results_free(struct api_results **results);

/** Returns the statistics of all parts, once the answer is complete; NULL if there are none. */
const struct api_stats *api_results_stats(const struct api_results *results);

/**
 * Fetches the next bytes of the parts, and appends the completed bytes of the answer.
 *
 * all  set non-zero at the end.
 *
 * PEND_BUG        the bytes are damaged, or belong to another table.
 * PEND_NO_MEMORY, PEND_LIMIT; and as the source's fetch: then error->text says why.
 */
PEND_MUST_CHECK enum pend_status api_results_fetch(struct api_results *results,
                                                   const struct api_source *source,
                                                   struct api_buffer *out, int *all,
                                                   struct pend_error *error);

/**
 * Appends the next piece of the rest of the answer, about API_PIECE_BYTES, after the last bytes of
 * the parts.
 *
 * done  set non-zero once the answer is complete.
 *
 * Fails as api_results_fetch does, also if rows are missing.
 */
PEND_MUST_CHECK enum pend_status api_results_end(struct api_results *results,
                                                 struct api_buffer *out, int *done);

/** Returns non-zero if another pass over the parts follows, for which the source is already
 * restarted. Call it after each api_results_end that is not done. */
int api_results_again(struct api_results *results, const struct api_source *source);

/** Writes the rows and statistics of raw results, except the seconds, as a Parquet file; rows: out.
 * PEND_NO_MEMORY, PEND_LIMIT; PEND_BUG as api_results_fetch */
PEND_MUST_CHECK enum pend_status api_results_file(const struct api_table *table,
                                                  const struct api_buffer *raw,
                                                  struct api_buffer *file, long *rows);
