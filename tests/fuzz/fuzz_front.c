/* Fuzzes the strict reader of HTTP messages.
 * Leaves to others: the values of fields (fuzz_fields), routes (fuzz_router), designed streams
 * (tests/harness/streams).
 * Invariant: the result does not depend on how a stream is cut, and the bytes that pass form a
 * stream that passes as a whole. */
#include <string.h>

#include "server/protocol/http_strict.h"
#include "tests/fuzz/fuzz.h"

enum { LENGTH = 4096 };

static int refusal_is_known(const struct srv_http_strict *strict) {
    int status = strict->status;
    return status == 400 || status == 413 || status == 414 || status == 431 || status == 501 ||
           status == 505;
}

/* feeds the stream in pieces whose lengths depend on its bytes; appends the bytes that pass */
static size_t in_pieces(struct srv_http_strict *strict, const char *data, size_t bytes,
                        char *passed) {
    char piece[LENGTH];
    size_t all = 0, next;
    unsigned mix = (unsigned)bytes;
    srv_http_strict_init(strict);
    for (size_t at = 0; at < bytes; at += next) {
        mix = mix * 31 + (unsigned char)data[at];
        next = 1 + mix % 13;
        if (next > bytes - at) next = bytes - at;
        memcpy(piece, data + at, next);
        size_t through = srv_http_strict_read(strict, piece, next);
        if (through > next) return bytes + 1;
        memcpy(passed + all, piece, through);
        all += through;
        if (strict->status) break;
    }
    return all;
}

static int read_front(char *text, size_t bytes) {
    char original[LENGTH], passed[LENGTH];
    struct srv_http_strict whole, cut, again;
    if (bytes > LENGTH) return 1;
    memcpy(original, text, bytes);
    srv_http_strict_init(&whole);
    size_t through = srv_http_strict_read(&whole, text, bytes);
    if (through > bytes || whole.complete > whole.requests) return 0;
    if (whole.status && (!refusal_is_known(&whole) || !whole.detail || !whole.detail[0])) return 0;
    size_t some = in_pieces(&cut, original, bytes, passed);
    if (some > bytes || cut.status != whole.status || cut.complete != whole.complete ||
        cut.requests != whole.requests || cut.detail != whole.detail)
        return 0;
    /* in one piece no byte of an invalid request passes; in several pieces its first bytes may have
     * passed */
    if (some < through || memcmp(passed, text, through) != 0) return 0;
    if (!whole.status && some != through) return 0;
    /* the reader accepts the bytes that have passed unchanged */
    srv_http_strict_init(&again);
    return srv_http_strict_read(&again, passed, through) == through && !again.status &&
           again.complete == whole.complete && !memcmp(passed, text, through);
}

static const struct fuzz_reader front[] = {
    {"front",
     read_front,
     {"GET / HTTP/1.1\r\nHost: a\r\nCookie: x=y\r\n\r\nGET /b?c=d&e HTTP/1.1\r\nHost: a\r\n\r\n",
      "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhelloGET / HTTP/1.0\r\n\r\n",
      "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n5;x=\"y\"\r\nhello\r\n0\r\n"
      "X: y\r\n\r\n",
      "\r\nGET http://a/b HTTP/1.7\r\nHOST: \t a\r\nX: caf\xc3\xa9\r\n\r\n"},
     1},
};
FUZZ_READERS(front)
