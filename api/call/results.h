/* Encoding a job's answer from its stored parts.
 * Leaves to others: the request and the head of the answer (call), fetching the parts in their
 * order (server).
 * Invariant: the answer does not depend on how the parts are divided into pieces. */
#ifndef API_RESULTS_H
#define API_RESULTS_H

#include "api/call/digest.h"
#include "api/encode/stats_text.h"

/* What is known of an answer before its first byte is sent; the texts live as long as the call. */
struct api_answer {
    int status;             /* HTTP status */
    const char *media_type; /* a static string */
    const char *columns; /* of the field X-Columns, "t,phi[4],phid[4]"; NULL if the representation
                            names its columns itself */
    const struct api_stats_headers *stat_fields; /* header fields of the figures, once the answer is
                                       complete; NULL before, or if there are none */
    const char *accepts;   /* status 415: what a body may be, a static string; NULL = JSON alone */
    int has_stat_fields;   /* there will be such fields; of an answer that is streamed they are
                            * trailers
                            */
    const char *file_name; /* for a browser that saves it; NULL if a browser should show it */
    const char *etag;      /* as api_call_etag; NULL for a problem */
    long long length;      /* bytes of the answer's body, -1 if unknown */
    long long first;       /* status 206: the number of its first byte in the whole, from 0 */
    long long total;       /* status 206 and 416: bytes of the whole */
};

struct api_results;

/* Access to the stored parts of a job (part). */
struct api_source {
    /**
     * Fetches the next bytes of the parts, in their order.
     *
     * data   out, room for `cap` bytes.
     * bytes  out; 0 = there are no more.
     *
     * Any other status than PEND_OK ends the answer; error->text says why.
     */
    enum pend_status (*fetch)(void *context, void *data, size_t cap, size_t *bytes,
                              struct pend_error *error);
    /** Makes fetch begin with the first part again. */
    void (*again)(void *context);
    void *context;
    /** Returns non-zero if fetch will not wait; NULL = fetch may wait. */
    int (*ready)(void *context);
    int partial; /* fetch may end before the last part: the answer has the rows of those before */
};

/** Turns the head of the answer to a request into that of what is read from the source: where it
 * has only the parts that are there, status 202. */
void api_results_head(const struct api_source *source, struct api_answer *answer);

/** Returns the most bytes of memory of the rows that an answer keeps, as api_writer_bytes does. */
double api_results_bytes(const struct api_source *source, const struct api_format *format,
                         const struct api_table *table);

/**
 * Begins an answer.
 *
 * results  out; NULL on failure.
 * apart    non-zero: the parts have records of JSON, since JSON says more than the table.
 * later    non-zero: the table's rows are the most that there can be, and a record of figures marks
 *          their end.
 * source   whose `again` and `partial` decide what is written.
 * out      the bytes before the rows are appended.
 *
 * PEND_INVALID  the form has no place for some of the rows only: a picture, or JSON that says more.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_results_new(struct api_results **results,
                                                 const struct api_format *format,
                                                 const struct api_table *table, int apart,
                                                 int later, const struct api_source *source,
                                                 struct api_buffer *out, struct pend_error *error);

/** Returns the figures of all parts, once the answer is complete; NULL if there are none. */
const struct api_stats *api_results_stats(const struct api_results *results);

/** Frees the results; nothing happens if they are NULL. */
void api_results_free(struct api_results **results);

/**
 * Fetches the next bytes of the parts, and appends the answer's bytes that are complete with them.
 *
 * all  set non-zero where there were no more.
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

/** Returns non-zero where the parts are wanted once more, from the first: the source was told so.
 * To be asked after each api_results_end that is not done. */
int api_results_again(struct api_results *results, const struct api_source *source);

#endif
