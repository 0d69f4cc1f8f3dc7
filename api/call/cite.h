/* What is needed to cite a job that has succeeded, and as an entry for BibTeX.
 * Leaves to others: who may read the job (server), its results with all that belongs to them
 * (crate).
 * Invariant: the same job, asked of the same address, gives the same bytes. */
#ifndef API_CITE_H
#define API_CITE_H

#include <stdint.h>

#include "api/call/digest.h"

/* A job; texts are UTF-8, instants microseconds since 1970. Nothing is copied. */
struct api_cite {
    const char *id, *operation;
    const char *title;   /* what its client calls it; "" = nothing */
    const char *version; /* of the program that took it in, "0.1.0+ENGINE"; "" = not known */
    const char *origin;  /* where the server was asked: "https://pendulum.example" */
    const char *author;  /* whose run it is called; NULL or "" = not stated */
    const char *license; /* URL of that under which it may be used; NULL or "" = not stated */
    int64_t created, started, finished;
    const void *request; /* the bytes of its request, as GET /v1/jobs/{id}/request answers them */
    size_t request_bytes;
    char digest[API_DIGEST_BYTES]; /* SHA-256 of these; made by api_cite_digest */
};

enum { API_CITE_NAME = 256 };

/** Sets the digest of the request. PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status api_cite_digest(struct api_cite *cite);

/** Writes what the run is called: its title, or what was computed. */
void api_cite_name(const struct api_cite *cite, char name[API_CITE_NAME]);

/** Appends an entry for BibTeX or biber, UTF-8; what TeX would take for a command is escaped. Fails
 * as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_cite_write(const struct api_cite *cite,
                                                struct api_buffer *out);

#endif
