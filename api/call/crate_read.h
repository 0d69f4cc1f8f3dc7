/* Reading a crate back, so that its request can be computed again and its results be compared.
 * Leaves to others: computing (server/replay), crates of other makers.
 * Invariant: whatever the bytes are, reading ends with a request or with a sentence that says why
 * not; every offset of the archive is checked before it is followed. */
#ifndef API_CRATE_READ_H
#define API_CRATE_READ_H

#include "api/call/crate.h"
#include "api/call/request.h"

enum { API_CRATE_VERSION = 64 };

/* A crate; what points into its bytes lives as long as these. */
struct api_crate_claim {
    struct api_request request; /* that the results are said to be of */
    const char *results;        /* the bytes of the results that are in it */
    size_t results_bytes;
    char digest[API_DIGEST_BYTES];   /* of the results, as it says */
    char version[API_CRATE_VERSION]; /* of the program that took the job in, as it says */
};

/** True if the bytes begin as an archive does. O(1). */
int api_crate_looks(const void *data, size_t bytes);

/**
 * Reads a crate that is whole and as it was sent: its files are stored, and request and results
 * have the digests that it says.
 *
 * error  on failure says why.
 *
 * PEND_INVALID, PEND_NO_MEMORY
 * O(bytes).
 */
PEND_MUST_CHECK enum pend_status api_crate_read(struct api_crate_claim *claim, const void *data,
                                                size_t bytes, struct pend_error *error);

#endif
