/* Content codings: negotiation and streaming compression.
 * Leaves to others: the libraries (coding_gzip, coding_zstd), whether to compress (compute).
 * Invariant: a client can decode all flushed bytes without those that follow. */
#pragma once

#include "api/base/buffer.h"

enum srv_coding { SRV_IDENTITY, SRV_GZIP, SRV_ZSTD, SRV_CODINGS };

/* The action after the bytes of a write. */
enum srv_coding_end { SRV_CODING_MORE, SRV_CODING_FLUSH, SRV_CODING_END };

/* A row of the table: a coding, by the functions of one library. */
struct srv_coding_row {
    const char *name; /* as in Accept-Encoding and Content-Encoding */
    size_t bytes;     /* approximate memory of a state */
    /** Returns a state for one stream; NULL if memory is short. */
    void *(*begin)(void);
    /** Compresses some bytes and appends the output; fails as api_buffer_room does. */
    enum pend_status (*write)(void *state, const void *data, size_t bytes, enum srv_coding_end end,
                              struct api_buffer *out);
    void (*free)(void *state);
    /** Compresses a whole body and appends it, faster than the functions above; NULL if the library
     * has no such function. */
    enum pend_status (*whole)(const void *data, size_t bytes, struct api_buffer *out);
};

extern const struct srv_coding_row srv_coding_gzip, srv_coding_zstd;

/** Returns the row of a coding; NULL for SRV_IDENTITY. */
const struct srv_coding_row *srv_coding_at(enum srv_coding coding);

/**
 * Returns the coding with the greatest q-value; zstd before gzip among equals.
 *
 * accept  value of Accept-Encoding, or NULL.
 */
enum srv_coding srv_coding_choose(const char *accept);

/** Returns true if a client accepts a coding, even if it prefers another. */
int srv_coding_accepts(const char *accept, enum srv_coding coding);

/** Returns true for text media types. Binary numbers compress too little to be worth the time. */
int srv_coding_worth(const char *media_type);

/** Compresses a whole body; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_coding_whole(enum srv_coding coding, const void *data,
                                                  size_t bytes, struct api_buffer *out);
