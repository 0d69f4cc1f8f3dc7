/* A recorded request as one file: the format, written and read.
 * Leaves to others: files and their bounds (recorder), computing the answer again (replay).
 * Invariant: what was written reads back as it was; a text that differs from it in any bit is
 * refused. */
#ifndef SRV_RECORDING_H
#define SRV_RECORDING_H

#include "api/base/limits.h"
#include "api/call/digest.h"
#include "api/call/request.h"

/*
 * pendulumd request 1 HEAD-BYTES BODY-BYTES SHA256      digest of head and body
 * engine: 0123456789abcdef
 * operation: trajectories
 * argument: paper-four-arms                             where the path has a variable part
 * method: POST
 * target: /v1/trajectories
 * field: Content-Type: application/json                 each header field
 * limit: max-arms 5000                                  each limit
 *
 * the body's bytes
 * answer 200 whole SHA256 SHA256                        once the answer is known: the digest of its
 *                                                       bytes, and that of what stands before it
 */

enum {
    SRV_RECORDING_FIELDS = 16,
    SRV_RECORDING_HEAD = 16384,              /* most bytes before the body */
    SRV_RECORDING_ANSWER = 2 * 64 + 16 + 10, /* room for the last line */
    SRV_RECORDING_ENGINE = 17                /* an engine's name with its NUL */
};

/* How the answer of a recorded request ended. */
enum srv_recording_end {
    SRV_RECORDING_NONE,   /* nothing is known of it: the process or the client left before */
    SRV_RECORDING_WHOLE,  /* it was complete before its first byte was sent */
    SRV_RECORDING_STREAM, /* it was sent while it was computed, and is complete */
    SRV_RECORDING_BROKEN, /* the same, but the computation failed in the middle */
    SRV_RECORDING_ENDS
};

struct srv_recording_answer {
    enum srv_recording_end end;
    int status;                    /* HTTP status */
    char digest[API_DIGEST_BYTES]; /* of its bytes, before a content coding */
};

struct srv_recording {
    const char *engine;
    const char *method, *target;
    struct api_request request; /* content_type and accept are also among the fields */
    struct {
        const char *name, *value;
    } field[SRV_RECORDING_FIELDS];
    int fields;
    struct api_limits limits;
    struct srv_recording_answer answer;
    char seal[API_DIGEST_BYTES]; /* out: the digest of head and body */
};

/**
 * Writes what stands before the body, which the caller is to write behind it as it is.
 *
 * recording  the seal is set.
 *
 * PEND_LIMIT      the head is longer than SRV_RECORDING_HEAD, or `out` is full.
 * PEND_INVALID    a text holds a line feed.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_recording_write_head(struct srv_recording *recording,
                                                          struct api_buffer *out);

/** Writes the last line, for a recording of that seal; answer->end is not SRV_RECORDING_NONE.
 * Returns its bytes, 0 without memory. */
int srv_recording_write_answer(const struct srv_recording_answer *answer,
                               const char seal[API_DIGEST_BYTES], char text[SRV_RECORDING_ANSWER]);

/**
 * Reads a recording.
 *
 * recording  out; its texts lie in `data`, in which NULs are written, and its body as well.
 *
 * PEND_INVALID    it is damaged, or none; error says what is wrong with it. O(bytes).
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_recording_read(struct srv_recording *recording, char *data,
                                                    size_t bytes, struct pend_error *error);

#endif
