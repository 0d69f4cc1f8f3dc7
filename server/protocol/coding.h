/* Content codings: the choice for a client, and compression piece by piece.
 * Leaves to others: the libraries (coding_gzip, coding_zstd), whether compression is worth it
 * (compute).
 * Invariant: a client can decode everything that was flushed without the bytes that follow. */
#ifndef SRV_CODING_H
#define SRV_CODING_H

#include "api/base/buffer.h"

enum srv_coding { SRV_IDENTITY, SRV_GZIP, SRV_ZSTD, SRV_CODINGS };

/* What follows the bytes that were written so far. */
enum srv_coding_end { SRV_CODING_MORE, SRV_CODING_FLUSH, SRV_CODING_END };

/* A row of the table: the functions of one library. */
struct srv_coding_row {
    const char *name; /* as in Accept-Encoding and Content-Encoding */
    size_t bytes;     /* of memory that a state takes, about */
    /** Returns a state for one stream, NULL without memory. */
    void *(*begin)(void);
    /** Appends the compressed form of some bytes and of those before; fails as api_buffer_room
     * does. */
    enum pend_status (*write)(void *state, const void *data, size_t bytes, enum srv_coding_end end,
                              struct api_buffer *out);
    void (*free)(void *state);
    /** Appends the compressed form of a whole body, faster than by the three functions above;
     * NULL if the library has no such function. */
    enum pend_status (*whole)(const void *data, size_t bytes, struct api_buffer *out);
};

extern const struct srv_coding_row srv_coding_gzip, srv_coding_zstd;

/** Returns the row of a coding; NULL for SRV_IDENTITY. */
const struct srv_coding_row *srv_coding_at(enum srv_coding coding);

/**
 * Returns the coding that a client prefers among those of the table: the greatest q-value; of
 * equals zstd, then gzip.
 *
 * accept  of Accept-Encoding, or NULL.
 */
enum srv_coding srv_coding_choose(const char *accept);

/** Returns true if a client accepts a coding, even if it prefers another. */
int srv_coding_accepts(const char *accept, enum srv_coding coding);

/** Returns true for a media type whose bytes are text: binary numbers shrink too little for the
 * time that compression takes. */
int srv_coding_worth(const char *media_type);

/** Compresses a whole body; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_coding_whole(enum srv_coding coding, const void *data,
                                                  size_t bytes, struct api_buffer *out);

#endif
