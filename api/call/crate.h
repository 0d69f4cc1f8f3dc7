/* A job's results with all that says what they are, as one archive: an RO-Crate 1.1 of the profile
 * Process Run Crate 0.5. It holds the request, the results, how to cite and repeat them, and
 * ro-crate-metadata.json, which stands last as it tells the digest of the results.
 * Leaves to others: encoding the results, whose bytes it only looks at (results); reading it back
 * (crate_read).
 * Invariant: the results in it have no compute_seconds, so that whoever computes the request with
 * the same engine gets the same bytes, and the same digest. */
#ifndef API_CRATE_H
#define API_CRATE_H

#include "api/call/cite.h"
#include "api/encode/encode.h"

/* The names of its files; that of the results is "results." and the representation's extension. */
extern const char api_crate_request[], api_crate_metadata[];

struct api_crate;

/**
 * Makes a crate that has no bytes yet.
 *
 * crate  out; NULL on failure; ends with api_crate_free.
 * cite   copied; its request must outlive the crate.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_crate_new(struct api_crate **crate,
                                               const struct api_cite *cite);

/** Frees a crate; nothing happens if it is NULL. */
void api_crate_free(struct api_crate **crate);

/** Sets the digest of the archive from that of its results' answer: another job's crate, or one
 * asked of another address, is another one. */
void api_crate_etag(const struct api_crate *crate, char digest[API_DIGEST_BYTES]);

/** The representation whose files of results have this extension; NULL if there is none. */
const struct api_format *api_crate_format(const char *extension);

/** The media type of a crate, and the name of its file. */
extern const char api_crate_media_type[], api_crate_file[];

/** Appends all that stands before the bytes of the results. PEND_NO_MEMORY, PEND_LIMIT */
PEND_MUST_CHECK enum pend_status api_crate_begin(struct api_crate *crate,
                                                 const struct api_format *format,
                                                 const struct api_table *table,
                                                 struct api_buffer *out);

/** Takes notice of bytes of the results, which the caller has appended: those of `out` from `from`
 * on. O(bytes). */
void api_crate_pass(struct api_crate *crate, const struct api_buffer *out, size_t from);

/** Appends all that stands behind the results. Fails as api_crate_begin does. */
PEND_MUST_CHECK enum pend_status api_crate_end(struct api_crate *crate, struct api_buffer *out);

#endif
