/* Content codings: which one a client wants, and compressing in pieces.
 * Leaves to others: the libraries (coding_gzip, coding_zstd), whether compressing is worth it
 * (compute).
 * Invariant: what was flushed can be read by the client without what comes after it. */
#ifndef SRV_CODING_H
#define SRV_CODING_H

#include "api/base/buffer.h"

enum srv_coding { SRV_IDENTITY, SRV_GZIP, SRV_ZSTD, SRV_CODINGS };

/* What is to be done with all that was written so far. */
enum srv_coding_end { SRV_CODING_MORE, SRV_CODING_FLUSH, SRV_CODING_END };

/* A row of the table: one library's way. */
struct srv_coding_row {
    const char *name; /* as in Accept-Encoding and Content-Encoding */
    size_t bytes;     /* of memory that a state takes, about */
    /** A state for one stream, NULL without memory. */
    void *(*begin)(void);
    /** Appends what comes of some bytes, and of those before; fails as api_buffer_room does. */
    enum pend_status (*write)(void *state, const void *data, size_t bytes, enum srv_coding_end end,
                              struct api_buffer *out);
    void (*free)(void *state);
    /** Appends what comes of a whole body, by a way that is faster than the three above; NULL
     * where there is none. */
    enum pend_status (*whole)(const void *data, size_t bytes, struct api_buffer *out);
};

extern const struct srv_coding_row srv_coding_gzip, srv_coding_zstd;

/** The row of a coding; NULL for SRV_IDENTITY. */
const struct srv_coding_row *srv_coding_at(enum srv_coding coding);

/**
 * The coding that a client likes best of those that are known here: the greatest q-value; of equals
 * zstd, then gzip.
 *
 * accept  of Accept-Encoding, or NULL.
 */
enum srv_coding srv_coding_choose(const char *accept);

/** True when a client takes a coding, whether or not it likes another one better. */
int srv_coding_accepts(const char *accept, enum srv_coding coding);

/** True for a media type whose bytes are text: numbers in binary do not shrink by what
 * compressing costs. */
int srv_coding_worth(const char *media_type);

/** Compresses a whole body; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_coding_whole(enum srv_coding coding, const void *data,
                                                  size_t bytes, struct api_buffer *out);

#endif
